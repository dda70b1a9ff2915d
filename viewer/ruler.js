// How large the shapes are: below each, in its box, a round length in the units of its file, which has so many CSS pixels
// a unit. The same length for both, unless the units are others.
export function rulers(context, boxes, pixels) {
  const room = Math.min(120, boxes[0][2] / 3);
  const most = pixels.map((one) => room / one);
  const alike = Math.max(...most) < 5 * Math.min(...most);
  boxes.forEach(([x, y, , h], s) => {
    const length = round(alike ? Math.min(...most) : most[s]);
    if (length > 0 && length < Infinity) ruler(context, x + 12, y + h - 10, length, length * pixels[s]);
  });
}

// The greatest of 1, 2 and 5 times powers of ten up to a number.
function round(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  return ([5, 2].find((k) => k * power <= most) ?? 1) * power;
}

function ruler(context, left, low, length, width) {
  const style = getComputedStyle(document.documentElement);
  const text = `${Number(length.toPrecision(1))} units`;
  context.globalAlpha = 1;
  context.font = "12px system-ui, sans-serif";
  for (const [colour, wider] of [["--paper", 3], ["--soft", 0]]) { // around it the colour of the ground, over shapes
    context.strokeStyle = context.fillStyle = style.getPropertyValue(colour);
    context.lineWidth = 1.5 + wider;
    context.beginPath();
    for (const [x, y] of [[0, -5], [0, 0], [width, 0], [width, -5]]) context.lineTo(left + x, low + y);
    context.stroke();
    if (wider) context.strokeText(text, left, low - 9);
    else context.fillText(text, left, low - 9);
  }
}
