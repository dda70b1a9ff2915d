// What the page holds, as typed arrays; see _content in src/mobius_match/viewer/__init__.py.

function bytes(text) {
  const binary = atob(text);
  const out = new Uint8Array(binary.length);
  for (let i = 0; i < out.length; i++) out[i] = binary.charCodeAt(i);
  return out;
}

function positions(side) {
  const codes = new Uint16Array(bytes(side.positions).buffer);
  return Float32Array.from(codes, (code, i) => side.low[i % 3] + code * side.step[i % 3]);
}

// Places on the source, as x, y, z and 1; or 0 for a vertex without counterpart.
function origins(packed) {
  const codes = new Uint16Array(bytes(packed).buffer);
  const out = new Float32Array((codes.length / 3) * 4);
  for (let i = 0; i < codes.length / 3; i++) {
    const known = codes[3 * i] < 65535;
    for (let k = 0; k < 3; k++) out[4 * i + k] = known ? codes[3 * i + k] / 65534 : 0;
    out[4 * i + 3] = known ? 1 : 0;
  }
  return out;
}

export function read(document) {
  const text = document.getElementById("result").textContent;
  const result = JSON.parse(text);
  const page = JSON.parse(document.getElementById("shapes").textContent);
  const rows = [result.correspondences, ...(result.alternatives ?? []).map((one) => one.correspondences)];
  return {
    text,
    result,
    azimuth: page.azimuth,
    elevation: page.elevation,
    radius: page.radius,
    sides: page.sides.map((side) => {
      const buffer = bytes(side.triangles).buffer;
      return {
        ...side,
        positions: positions(side),
        triangles: side.wide ? new Uint32Array(buffer) : new Uint16Array(buffer),
        origins: side.origins && origins(side.origins),
      };
    }),
    explanations: page.explanations.map((one, k) => ({
      ...one,
      matches: rows[k].map((row, i) => ({ ...row, number: i, certain: Math.min(Math.max(row.confidence, 0), 1) })),
      points: one.points.map((points) => new Float32Array(bytes(points).buffer)),
      colours: bytes(one.colours),
    })),
    colourings: page.colourings.map((one) => ({ ...one, colours: one.colours.map(bytes) })),
  };
}

export function css(colours, i) {
  return `rgb(${colours[3 * i]},${colours[3 * i + 1]},${colours[3 * i + 2]})`;
}

export function csv(matches) {
  const lines = matches.map((m) => `${m.source},${m.target},${m.confidence},${m.kind === "voted" ? "voted" : "recovered"}`);
  return ["source,target,confidence,kind", ...lines].join("\n") + "\n";
}
