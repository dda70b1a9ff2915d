// A ruler below each shape: a round length in the units of its file, of which `pixels` has the CSS pixels per unit. It is
// the same length for both, unless their units differ.
export function rulers(context, boxes, pixels) {
  const room = Math.min(120, boxes[0][2] / 3);
  const longest = pixels.map((perUnit) => room / perUnit);
  const sameUnits = Math.max(...longest) < 5 * Math.min(...longest);
  boxes.forEach(([x, y, , h], s) => {
    const length = roundDown(sameUnits ? Math.min(...longest) : longest[s]);
    if (length > 0 && length < Infinity) ruler(context, x + 12, y + h - 10, length, length * pixels[s]);
  });
}

// The largest number 1, 2 or 5 times a power of ten that is not above a limit.
function roundDown(limit) {
  const power = 10 ** Math.floor(Math.log10(limit));
  return ([5, 2].find((k) => k * power <= limit) ?? 1) * power;
}

function ruler(context, left, low, length, width) {
  const style = getComputedStyle(document.documentElement);
  const text = `${Number(length.toPrecision(1))} units`;
  context.globalAlpha = 1;
  context.font = "12px system-ui, sans-serif";
  for (const [colour, wider] of [["--paper", 3], ["--soft", 0]]) { // with an outline in the background colour, to be legible over shapes
    context.strokeStyle = context.fillStyle = style.getPropertyValue(colour);
    context.lineWidth = 1.5 + wider;
    context.beginPath();
    for (const [x, y] of [[0, -5], [0, 0], [width, 0], [width, -5]]) context.lineTo(left + x, low + y);
    context.stroke();
    if (wider) context.strokeText(text, left, low - 9);
    else context.fillText(text, left, low - 9);
  }
}
