// The current view as a PNG file: both shapes with names, lines, rulers, the numbers of the selected match, and the scale.
import { STRIP } from "./scene.js";

const MIN_RATIO = 2; // pixels of the picture per CSS pixel

// `scale` has a name, colours and labels, or is null.
export function picture(view, names, scale, then) {
  const ratio = Math.max(MIN_RATIO, Math.min(window.devicePixelRatio, 3));
  view.resize(ratio);
  view.draw();
  const { width, height } = view.canvas;
  const sheet = new OffscreenCanvas(width, height);
  const context = sheet.getContext("2d");
  const style = getComputedStyle(document.documentElement);
  const [paper, soft, ink] = ["--paper", "--soft", "--ink"].map((name) => style.getPropertyValue(name));
  context.fillStyle = paper;
  context.fillRect(0, 0, width, height);
  context.drawImage(view.canvas, 0, 0);
  context.drawImage(view.lines, 0, 0);
  context.scale(ratio, ratio);
  context.fillStyle = soft;
  context.font = "14px system-ui, sans-serif";
  view.boxes().forEach(([x, y, w], s) => context.fillText(names[s], x + 12, y - STRIP + 22, w - 24));
  if (view.selected) [view.selected.source, view.selected.target].forEach((vertex, s) => {
    const { x, y } = view.project(s, view.selected);
    label(context, String(vertex), x + 14, y - 26, ink, paper);
  });
  if (scale) legend(context, scale, width / ratio - 12, height / ratio - 34, soft);
  view.resize();
  sheet.convertToBlob({ type: "image/png" }).then(then);
}

function label(context, text, x, y, ink, paper) {
  context.font = "12px system-ui, sans-serif";
  context.fillStyle = ink;
  context.fillRect(x, y, context.measureText(text).width + 12, 18);
  context.fillStyle = paper;
  context.fillText(text, x + 6, y + 13);
}

// Draw the scale with its right end and its top at a position.
function legend(context, { name, colours, labels }, right, top, soft) {
  const width = 200;
  const colour = context.createLinearGradient(right - width, 0, right, 0);
  colours.forEach((stop, i) => colour.addColorStop(i / (colours.length - 1), stop));
  context.fillStyle = colour;
  context.fillRect(right - width, top, width, 10);
  context.fillStyle = soft;
  context.font = "12px system-ui, sans-serif";
  context.fillText(name, right - width, top - 6);
  labels.forEach((text, i) => {
    const part = i / (labels.length - 1);
    context.fillText(text, right - width + part * (width - context.measureText(text).width), top + 24);
  });
}
