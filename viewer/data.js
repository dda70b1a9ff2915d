// The data in the page, as typed arrays; written by src/mobius_match/viewer.

function bytes(text) {
  const binary = atob(text);
  const out = new Uint8Array(binary.length);
  for (let i = 0; i < out.length; i++) out[i] = binary.charCodeAt(i);
  return out;
}

const floats = (text) => new Float32Array(bytes(text).buffer);
const shorts = (text) => new Uint16Array(bytes(text).buffer);

function positions({ low, step, codes }) {
  return Float32Array.from(shorts(codes), (code, i) => low[i % low.length] + code * step[i % low.length]);
}

function parts(values, number) {
  const size = values.length / number;
  return Array.from({ length: number }, (_, k) => values.subarray(k * size, (k + 1) * size));
}

// Positions on the source as x, y, z and 1; all 0 for a vertex without counterpart.
function origins(packed) {
  const codes = shorts(packed);
  const out = new Float32Array((codes.length / 3) * 4);
  for (let i = 0; i < codes.length / 3; i++) {
    const known = codes[3 * i] < 65535;
    for (let k = 0; k < 3; k++) out[4 * i + k] = known ? codes[3 * i + k] / 65534 : 0;
    out[4 * i + 3] = known ? 1 : 0;
  }
  return out;
}

export const GREY = [115, 115, 120]; // for no value

// The colour of a value from 0 to 1 on a scale, as three numbers from 0 to 255.
export function along(stops, value) {
  const at = Math.min(Math.max(value, 0), 1) * (stops.length - 1);
  const k = Math.min(Math.floor(at), stops.length - 2);
  const channel = (stop, c) => parseInt(stop.slice(1 + 2 * c, 3 + 2 * c), 16);
  return [0, 1, 2].map((c) => channel(stops[k], c) * (1 - at + k) + channel(stops[k + 1], c) * (at - k));
}

function shaded(stops, codes) {
  const table = Array.from({ length: 256 }, (_, code) => (code < 255 ? along(stops, code / 254) : GREY));
  const out = new Uint8Array(3 * codes.length);
  codes.forEach((code, i) => out.set(table[code], 3 * i));
  return out;
}

function colouring(packed, all) {
  if (packed.texture) return packed;
  const source = packed.like === undefined ? packed : all[packed.like];
  const colours = source.values
    ? source.values.map((codes) => shaded(source.scale.colours, bytes(codes))) : source.colours.map(bytes);
  return { ...packed, colours };
}

function alignment(packed, rows, page) {
  const colours = bytes(packed.colours);
  const errors = packed.errors ?? null;
  const errorColours = errors && new Uint8Array(errors.flatMap(
    (error) => (error === null ? GREY : along(page.errors.scale.colours, error / page.errors.worst))));
  return {
    ...packed,
    colours,
    errorColours,
    matches: rows.map((row, i) => ({
      ...row, number: i, label: row.given ? "given" : row.kind, certainty: Math.min(Math.max(row.confidence, 0), 1),
      error: errors ? errors[i] : undefined,
    })),
    points: packed.points.map(floats),
    moved: page.morph && parts(floats(packed.moved), page.morph.frames - 1),
  };
}

export function read(document) {
  const text = document.getElementById("result").textContent;
  const result = JSON.parse(text);
  const page = JSON.parse(document.getElementById("shapes").textContent);
  const rows = [result.correspondences, ...(result.alternatives ?? []).map((alternative) => alternative.correspondences)];
  return {
    ...page,
    text,
    result,
    sides: page.sides.map((side) => {
      const buffer = bytes(side.triangles).buffer;
      return {
        ...side,
        positions: positions(side.positions),
        triangles: side.wide ? new Uint32Array(buffer) : new Uint16Array(buffer),
        origins: side.origins && origins(side.origins),
        loops: side.loops && floats(side.loops),
        uv: side.uv && { coordinates: positions(side.uv), known: bytes(side.uv.known) },
      };
    }),
    alignments: page.alignments.map((packed, k) => alignment(packed, rows[k], page)),
    colourings: page.colourings.map((packed) => colouring(packed, page.colourings)),
    morph: page.morph && parts(positions(page.morph), page.morph.frames - 1),
    insight: page.insight && {
      ...page.insight, planes: page.insight.planes.map(floats), matrix: shorts(page.insight.matrix),
    },
  };
}

export function css(colours, i) {
  return `rgb(${colours[3 * i]},${colours[3 * i + 1]},${colours[3 * i + 2]})`;
}

export function csv(matches) {
  const errors = matches.some((m) => m.error !== undefined);
  const lines = matches.map((m) => [
    m.source, m.target, m.confidence, m.kind === "voted" ? "voted" : "recovered", m.given ? 1 : 0, 0,
    ...(errors ? [m.error ?? ""] : []),
  ]);
  const heads = ["source", "target", "confidence", "kind", "given", "index_base", ...(errors ? ["error"] : [])];
  return [heads, ...lines].join("\n") + "\n";
}
