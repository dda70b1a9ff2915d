// The votes: both flattened sets of samples, and the fuzzy correspondence matrix.
import { along, css } from "./data.js";

const STOPS = ["#fbf3d5", "#f2c166", "#d97f3c", "#933d4e", "#2e144f"];

// The colours of the matrix, starting with that of no votes, which is close to the background.
export function stops() {
  return document.documentElement.dataset.theme === "dark" ? [...STOPS].reverse() : STOPS;
}

export class Insight {
  // `canvases`: the plane of the source, that of the target, and the matrix. `onHover` is called with a text on the pair
  // under the pointer, `onClick` with its source vertex.
  constructor(canvases, data, onHover, onClick) {
    Object.assign(this, { canvases, data });
    // The source sample of each paired target sample.
    this.sourceOf = new Map(data.paired.flatMap((j, i) => (j < 0 ? [] : [[j, i]])));
    canvases.forEach((canvas, k) => {
      canvas.addEventListener("pointermove", (event) => onHover(this.#text(this.#under(k, event))));
      canvas.addEventListener("pointerleave", () => onHover(""));
      canvas.addEventListener("click", (event) => {
        const [i, j] = this.#under(k, event);
        const source = i ?? this.sourceOf.get(j);
        if (source !== undefined) onClick(data.samples[0][source]);
      });
      new ResizeObserver(() => this.draw()).observe(canvas);
    });
  }

  // Show the matches in their colours; `selected` is one of them or null.
  show(matches, selected, colours) {
    this.colours = new Map(matches.map((match) => [match.source, css(colours, match.number)]));
    this.selected = selected ? this.data.samples[0].indexOf(selected.source) : -1;
    this.draw();
  }

  draw() {
    if (!this.colours || !this.canvases[0].clientWidth) return;
    const style = getComputedStyle(document.documentElement);
    const [ink, soft, edge] = ["--ink", "--soft", "--edge"].map((name) => style.getPropertyValue(name));
    this.#plane(0, this.data.paired.map((j, i) => (j < 0 ? -1 : i)), ink, soft, edge);
    this.#plane(1, this.data.samples[1].map((_, j) => this.sourceOf.get(j) ?? -1), ink, soft, edge);
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

  // The position of a sample on its canvas, in CSS pixels.
  #at(s, i) {
    const half = this.canvases[s].clientWidth / 2;
    const [x, y] = this.data.planes[s].subarray(2 * i, 2 * i + 2);
    return [half + (half - 8) * x, half - (half - 8) * y];
  }

  // `paired`: the source sample that each dot belongs to, or -1.
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
    const selected = paired.indexOf(this.selected);
    if (this.selected < 0 || selected < 0) return;
    dot(selected, 10);
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
    const row = rows.indexOf(this.selected);
    if (this.selected < 0 || row < 0) return;
    context.strokeStyle = ink;
    context.strokeRect(0.5, (row * h) / rows.length, w - 1, h / rows.length);
  }

  // The samples under the pointer, [source, target]; each may be undefined.
  #under(k, event) {
    const box = this.canvases[k].getBoundingClientRect();
    const x = event.clientX - box.left, y = event.clientY - box.top;
    if (k === 2) {
      const { rows, columns } = this.data;
      return [rows[Math.floor((y / box.height) * rows.length)], columns[Math.floor((x / box.width) * columns.length)]];
    }
    let nearest, smallest = event.pointerType === "touch" ? 22 : 12;
    this.data.samples[k].forEach((_, i) => {
      const [left, top] = this.#at(k, i);
      const distance = Math.hypot(left - x, top - y);
      if (distance < smallest) [nearest, smallest] = [i, distance];
    });
    if (nearest === undefined) return [];
    if (k === 1) return [this.sourceOf.get(nearest), nearest];
    const paired = this.data.paired[nearest];
    return [nearest, paired < 0 ? undefined : paired];
  }

  #text([i, j]) {
    const { samples, matrix, columns } = this.data;
    const named = [i === undefined ? null : `source vertex ${samples[0][i]}`,
      j === undefined ? null : `target vertex ${samples[1][j]}`].filter(Boolean);
    if (named.length < 2) return named.length ? `${named[0]}: no mutually nearest sample` : "";
    const share = matrix[i * columns.length + j] / 65535;
    return `${named.join(", ")}: ${(100 * share).toFixed(1)} % of the maximum`;
  }
}
