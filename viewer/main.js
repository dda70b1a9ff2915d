// Builds the page and connects its controls with the view. Names and notes of files are inserted as text only.
import page from "./page.html";
import style from "./style.css";
import { css, csv, read } from "./data.js";
import { Insight, stops } from "./insight.js";
import { picture } from "./picture.js";
import { STRIP, View } from "./scene.js";

const data = read(document);
document.head.appendChild(document.createElement("style")).textContent = style;
document.body.insertAdjacentHTML("afterbegin", page);
const $ = (id) => document.getElementById(id);
const all = (selector) => [...document.querySelectorAll(selector)];

const names = data.sides.map((side) => side.name);
const state = { alignment: data.alignments[0], minimum: 0, selected: null, hovered: null, byError: false };
const dark = matchMedia("(prefers-color-scheme: dark)");
const percent = (fraction) => `${(100 * fraction).toFixed(1)} %`;
let view = null, insight = null;

// The matches that are confident enough.
function shown() {
  return state.alignment.matches.filter((match) => match.certainty >= state.minimum);
}

function colours() {
  return state.byError ? state.alignment.errorColours : state.alignment.colours;
}

function theme(name) {
  document.documentElement.dataset.theme = name;
  $("theme").textContent = name === "dark" ? "Light" : "Dark";
  view?.theme();
  if (insight) {
    scale("votes-scale", { colours: stops(), labels: ["0", "25 %", "maximum"] }); // by the square root of the votes
    insight.draw();
  }
}

function update() {
  const matches = shown();
  if (state.selected && !matches.includes(state.selected)) state.selected = null;
  const current = state.selected ?? state.hovered;
  $("minimum-value").textContent = state.minimum.toFixed(2);
  $("count").textContent = `${matches.length} of ${state.alignment.matches.length} matches`;
  $("status").textContent = current
    ? `Match ${current.number + 1}` : matches.length ? "No match selected"
      : state.alignment.matches.length ? "No match is this confident" : "There are no matches";
  const facts = current ? [
    [names[0], `vertex ${current.source}`], [names[1], `vertex ${current.target}`],
    ["confidence", current.confidence.toFixed(3)], ["kind", current.label],
    ...(current.error === undefined ? [] : [["error", errorText(current.error)]]),
  ] : [];
  $("hint").hidden = current !== null;
  $("facts").replaceChildren(...facts.flatMap(([name, value]) => [element("dt", name), element("dd", value)]));
  $("turn").disabled = !view || !state.selected;
  const found = matches.filter(isFound);
  $("unfound").textContent = found.length || !$("find").value ? "" : "No match or vertex has this number.";
  all("tbody tr").forEach((row, i) => {
    row.hidden = !found.includes(state.alignment.matches[i]);
    if (state.alignment.matches[i] === state.selected) row.setAttribute("aria-current", "true");
    else row.removeAttribute("aria-current");
    row.querySelector("i").style.background = css(colours(), i);
  });
  const drawn = $("matches").checked ? matches : matches.filter((match) => match === current);
  view?.show(state.alignment, drawn, current, colours());
  insight?.show(matches, current, state.alignment.colours);
}

// Whether the number of a match or of one of its vertices starts with the text in the search field.
function isFound(match) {
  const start = $("find").value.trim();
  return [match.number + 1, match.source, match.target].some((number) => String(number).startsWith(start));
}

function errorText(error) {
  return error === null ? "unknown" : `${percent(error)} of the diameter`;
}

function scale(id, shown) {
  $(id).hidden = !shown;
  if (!shown) return;
  $(id).firstChild.style.background = `linear-gradient(to right, ${shown.colours.join(", ")})`;
  $(id).lastChild.replaceChildren(...shown.labels.map((label) => element("span", label)));
}

function element(name, text) {
  const made = document.createElement(name);
  made.textContent = text;
  return made;
}

function select(match) {
  state.selected = match;
  state.hovered = null;
  update();
}

function step(by) {
  const matches = shown();
  if (!matches.length) return;
  const at = matches.indexOf(state.selected);
  select(matches[at < 0 ? (by > 0 ? 0 : matches.length - 1) : (at + by + matches.length) % matches.length]);
}

function showAlignment(k) {
  state.alignment = data.alignments[k];
  state.selected = state.hovered = null;
  $("find").value = "";
  $("given").hidden = !state.alignment.matches.some((match) => match.given);
  $("alignment-note").textContent = state.alignment.note;
  const errors = (state.alignment.errors ?? []).filter((error) => error !== null);
  const mean = errors.reduce((sum, error) => sum + error, 0) / errors.length;
  const near = errors.filter((error) => error <= 0.05).length / errors.length;
  $("spheres-note").textContent = errors.length ? `Mean error ${percent(mean)} of the target's diameter; ${percent(near)} of ` +
    "the matches within 5 %." : "No error is known.";
  document.querySelector("tbody").replaceChildren(...state.alignment.matches.map((match) => {
    const row = document.createElement("tr");
    const button = document.createElement("button");
    const spot = document.createElement("i");
    button.type = "button";
    button.append(spot, String(match.number + 1));
    button.addEventListener("click", () => select(match));
    const error = match.error === undefined ? [] : [match.error === null ? "" : (100 * match.error).toFixed(1)];
    row.append(...["", match.source, match.target, match.confidence.toFixed(3), ...error, match.label].map(
      (value) => element("td", value)));
    row.firstChild.append(button);
    return row;
  }));
  update();
}

function colourSurfaces(k) {
  const colouring = data.colourings[k - 1] ?? null;
  $("surface-note").textContent = colouring?.note ?? "";
  scale("surface-scale", colouring?.scale);
  $("matches").checked = colouring === null; // spheres would hide the colours
  view?.paint(colouring);
  update();
}

function download(name, blob) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

// Fill a list of choices and show all that belongs to it, if there is more than one.
function fillList(id, rows, changed) {
  if (rows.length < 2) return;
  all(`.${id}`).forEach((part) => (part.hidden = false));
  $(id).append(...rows.map((row, k) => new Option(row, k)));
  $(id).addEventListener("change", () => changed(Number($(id).value)));
}

// Place the labels on the drawn shapes.
function placeLabels() {
  all(".end").forEach((label, s) => {
    const current = view.selected;
    label.hidden = !current;
    if (!current) return;
    label.textContent = s ? current.target : current.source;
    const { x, y } = view.project(s, current);
    const [left, top, width, height] = view.boxes()[s];
    const right = Math.min(Math.max(x + 14, left), left + width - label.offsetWidth - 4);
    label.style.transform = `translate(${right}px, ${Math.min(Math.max(y - 26, top), top + height - 22)}px)`;
  });
  all(".name").forEach((name, s) => {
    const [x, y, width] = view.boxes()[s];
    name.lastChild.hidden = width < 380;
    Object.assign(name.style, { left: `${x}px`, top: `${y - STRIP + 7}px`, maxWidth: `${width}px` });
  });
}

function listenToPointer() {
  let down = null;
  const position = (event) => {
    const box = $("view").getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top, event.pointerType === "touch" ? 22 : 8];
  };
  $("view").addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]));
  $("view").addEventListener("pointerup", (event) => {
    if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 5) select(view.pick(...position(event)));
    down = null;
  });
  $("view").addEventListener("pointermove", (event) => {
    if (event.buttons || event.pointerType === "touch") return;
    const match = view.pick(...position(event));
    $("view").classList.toggle("over", match !== null);
    if (match !== state.hovered) {
      state.hovered = match;
      if (!state.selected) update();
    }
  });
  $("view").addEventListener("pointerleave", () => {
    state.hovered = null;
    if (!state.selected) update();
  });
}

// Each name in a <bdi>: one that is written from right to left must not reorder what follows.
document.querySelector("h1").append(element("bdi", names[0]), " \u2194 ", element("bdi", names[1]));
all(".name").forEach((name, s) => {
  const { vertices, simplified } = data.sides[s];
  const size = `, ${vertices.toLocaleString("en")} vertices${simplified ? ", drawn simplified" : ""}`;
  name.append(s ? "Target: " : "Source: ", element("bdi", names[s]), element("span", size));
});
try {
  view = new View($("view"), $("lines"), data);
  view.onDraw = placeLabels;
  listenToPointer();
} catch (error) {
  $("failure").hidden = false;
  $("failure").textContent = "This browser cannot draw the shapes (it has no WebGL 2). The table lists the matches.";
  console.warn(error);
}
const certainties = data.alignments.flatMap(({ matches }) => matches.map((match) => match.certainty));
$("minimum").min = Math.floor(100 * Math.min(1, ...certainties)) / 100;
$("minimum").value = $("minimum").min;
state.minimum = Number($("minimum").value);
$("minimum").addEventListener("input", () => {
  state.minimum = Number($("minimum").value);
  update();
});
fillList("alignment", data.alignments.map(({ name }) => name), showAlignment);
fillList("surface", ["Plain", ...data.colourings.map(({ name }) => name)], colourSurfaces);
fillList("spheres", data.errors ? ["by position", "by error"] : [], (k) => {
  state.byError = k === 1;
  scale("spheres-scale", state.byError && data.errors.scale);
  update();
});
if (data.morph && view) {
  $("morphing").hidden = false;
  $("morph").addEventListener("input", () => {
    $("morph-value").textContent = `${Math.round(100 * $("morph").value)} %`;
    view.morph(Number($("morph").value));
    update();
  });
}
if (data.insight) {
  const describe = (text) => ($("pair").textContent = text || "Point at a dot or a cell of the matrix to see its pair.");
  const pick = (vertex) => select(shown().find((match) => match.source === vertex) ?? null);
  insight = new Insight(all("#insight canvas"), data.insight, describe, pick);
  describe("");
  $("triplets").textContent = data.insight.triplets.toLocaleString("en");
  $("votes").hidden = false;
  $("votes").addEventListener("click", () => {
    $("insight").hidden = !$("insight").hidden;
    $("votes").setAttribute("aria-pressed", String(!$("insight").hidden));
    insight.draw();
  });
}
$("matches").addEventListener("change", update);
$("all-lines").addEventListener("change", () => {
  if (view) view.allLines = $("all-lines").checked;
  update();
});
$("previous").addEventListener("click", () => step(-1));
$("next").addEventListener("click", () => step(1));
$("reset").addEventListener("click", () => view?.reset());
$("turn").addEventListener("click", () => view.face(state.selected));
all("[data-direction]").forEach((button) => button.addEventListener("click", () =>
  view?.reset(...button.dataset.direction.split(",").map((degrees) => (Number(degrees) * Math.PI) / 180))));
$("find").addEventListener("input", update);
$("find").addEventListener("keydown", (event) => {
  const found = shown().filter(isFound);
  const number = $("find").value.trim();
  if (event.key === "Enter" && number && found.length) {
    select(found.find((match) => [match.source, match.target].map(String).includes(number)) ?? found[0]);
  }
});
$("theme").addEventListener("click", () => theme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
$("picture").addEventListener("click", () => {
  if (!view) return;
  const ofSurface = view.colouring?.scale && { name: view.colouring.name, ...view.colouring.scale };
  const scale = ofSurface ?? (state.byError ? { name: "Error", ...data.errors.scale } : null);
  picture(view, names, scale, (blob) => download("matches.png", blob));
});
$("json").addEventListener("click", () => download("matches.json", new Blob([data.text], { type: "application/json" })));
$("csv").addEventListener("click", () =>
  download("matches.csv", new Blob([csv(state.alignment.matches)], { type: "text/csv" })));
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.key === "Escape") select(null);
  if (event.target instanceof Element && event.target.matches("select, input[type=range], input[type=search]")) return;
  if (event.key === "ArrowRight" || event.key === "ArrowLeft") {
    event.preventDefault();
    step(event.key === "ArrowRight" ? 1 : -1);
  }
});
dark.addEventListener("change", () => theme(dark.matches ? "dark" : "light"));
if (innerWidth <= 760) $("list").open = false;
$("loops").hidden = !data.sides.some((side) => side.loops);
$("notes").hidden = !data.result.warnings.length;
$("notes").querySelector("ul").append(...data.result.warnings.map((line) => element("li", line)));
theme(dark.matches ? "dark" : "light");
showAlignment(0);
colourSurfaces(0);
