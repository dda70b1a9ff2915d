// How the matches were found: both flattened sets of samples, and the fuzzy correspondence matrix.
import { along, css } from "./data.js";

const STOPS = ["#fbf3d5", "#f2c166", "#d97f3c", "#933d4e", "#2e144f"];

// The colours of the matrix, from no votes, which are as the ground is.
export function stops() {
  return document.documentElement.dataset.theme === "dark" ? [...STOPS].reverse() : STOPS;
}

export class Insight {
  // `canvases` are those of the source's plane, of the target's, and of the matrix; `told` takes what is pointed at.
  constructor(canvases, data, told, picked) {
    Object.assign(this, { canvases, data, told, picked });
    this.back = data.paired.reduce((back, j, i) => (j < 0 ? back : back.set(j, i)), new Map());
    canvases.forEach((canvas, k) => {
      canvas.addEventListener("pointermove", (event) => told(this.#text(this.#under(k, event))));
      canvas.addEventListener("pointerleave", () => told(""));
      canvas.addEventListener("click", (event) => {
        const [i, j] = this.#under(k, event);
        const source = i ?? this.back.get(j);
        if (source !== undefined) picked(data.samples[0][source]);
      });
      new ResizeObserver(() => this.draw()).observe(canvas);
    });
  }

  // The matches in their colours; `chosen` is one of them or null.
  show(matches, chosen, colours) {
    this.colours = new Map(matches.map((match) => [match.source, css(colours, match.number)]));
    this.chosen = chosen ? this.data.samples[0].indexOf(chosen.source) : -1;
    this.draw();
  }

  draw() {
    if (!this.colours || !this.canvases[0].clientWidth) return;
    const style = getComputedStyle(document.documentElement);
    const [ink, soft, edge] = ["--ink", "--soft", "--edge"].map((name) => style.getPropertyValue(name));
    this.#plane(0, this.data.paired.map((j, i) => (j < 0 ? -1 : i)), ink, soft, edge);
    this.#plane(1, this.data.samples[1].map((_, j) => this.back.get(j) ?? -1), ink, soft, edge);
    this.#matrix(ink);
  }

  #context(k) {
    const canvas = this.canvases[k];
    const ratio = Math.min(window.devicePixelRatio, 2);
    canvas.width = canvas.clientWidth * ratio;
    canvas.height = canvas.clientHeight * ratio;
    const context = canvas.getContext("2d");
    context.scale(ratio, ratio);
    return context;
  }

  // Where a sample is on its canvas, in CSS pixels.
  #at(s, i) {
    const half = this.canvases[s].clientWidth / 2;
    const [x, y] = this.data.planes[s].subarray(2 * i, 2 * i + 2);
    return [half + (half - 8) * x, half - (half - 8) * y];
  }

  // `paired`: the sample of the source that each dot belongs to, or -1.
  #plane(s, paired, ink, soft, edge) {
    const context = this.#context(s);
    const half = this.canvases[s].clientWidth / 2;
    context.strokeStyle = edge;
    context.beginPath();
    context.arc(half, half, half - 8, 0, 2 * Math.PI);
    context.stroke();
    context.beginPath();
    this.data.triplet[s].forEach((i, k) => context[k ? "lineTo" : "moveTo"](...this.#at(s, i)));
    context.closePath();
    context.strokeStyle = soft;
    context.stroke();
    const dot = (i, radius) => {
      context.beginPath();
      context.arc(...this.#at(s, i), radius, 0, 2 * Math.PI);
    };
    paired.forEach((source, i) => {
      const colour = this.colours.get(this.data.samples[0][source]);
      dot(i, colour ? 4.5 : 2);
      context.fillStyle = colour ?? soft;
      context.fill();
    });
    context.strokeStyle = ink;
    context.lineWidth = 2;
    for (const i of this.data.triplet[s]) {
      dot(i, 6.5);
      context.stroke();
    }
    const chosen = paired.indexOf(this.chosen);
    if (this.chosen < 0 || chosen < 0) return;
    dot(chosen, 10);
    context.stroke();
  }

  #matrix(ink) {
    const { rows, columns, matrix } = this.data;
    const context = this.#context(2);
    const { clientWidth: w, clientHeight: h } = this.canvases[2];
    const colours = stops();
    const small = new OffscreenCanvas(columns.length, rows.length);
    const image = new ImageData(columns.length, rows.length);
    rows.forEach((i, y) => columns.forEach((j, x) => {
      const share = matrix[i * columns.length + j] / 65535;
      image.data.set([...along(colours, Math.sqrt(share)), 255], 4 * (y * columns.length + x));
    }));
    small.getContext("2d").putImageData(image, 0, 0);
    context.imageSmoothingEnabled = false;
    context.drawImage(small, 0, 0, w, h);
    const row = rows.indexOf(this.chosen);
    if (this.chosen < 0 || row < 0) return;
    context.strokeStyle = ink;
    context.strokeRect(0.5, (row * h) / rows.length, w - 1, h / rows.length);
  }

  // The samples that an event is over: [of the source, of the target], either undefined.
  #under(k, event) {
    const box = this.canvases[k].getBoundingClientRect();
    const x = event.clientX - box.left, y = event.clientY - box.top;
    if (k === 2) {
      const { rows, columns } = this.data;
      return [rows[Math.floor((y / box.height) * rows.length)], columns[Math.floor((x / box.width) * columns.length)]];
    }
    let nearest, least = event.pointerType === "touch" ? 22 : 12;
    this.data.samples[k].forEach((_, i) => {
      const [left, top] = this.#at(k, i);
      const apart = Math.hypot(left - x, top - y);
      if (apart < least) [nearest, least] = [i, apart];
    });
    if (nearest === undefined) return [];
    if (k === 1) return [this.back.get(nearest), nearest];
    const paired = this.data.paired[nearest];
    return [nearest, paired < 0 ? undefined : paired];
  }

  #text([i, j]) {
    const { samples, matrix, columns } = this.data;
    const named = [i === undefined ? null : `source vertex ${samples[0][i]}`,
      j === undefined ? null : `target vertex ${samples[1][j]}`].filter(Boolean);
    if (named.length < 2) return named.length ? `${named[0]}: not mutually nearest to any` : "";
    const share = matrix[i * columns.length + j] / 65535;
    return `${named.join(", ")}: ${(100 * share).toFixed(1)} % of the most votes`;
  }
}
