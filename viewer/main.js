// The page: builds it, and ties its controls to the view. Names and numbers of files go in as text only.
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
const state = { explanation: data.explanations[0], least: 0, chosen: null, hovered: null, byError: false };
const dark = matchMedia("(prefers-color-scheme: dark)");
const percent = (part) => `${(100 * part).toFixed(1)} %`;
let view = null, insight = null;

function shown() {
  return state.explanation.matches.filter((match) => match.certain >= state.least);
}

function colours() {
  return state.byError ? state.explanation.wrong : state.explanation.colours;
}

function theme(name) {
  document.documentElement.dataset.theme = name;
  $("theme").textContent = name === "dark" ? "Light" : "Dark";
  view?.theme();
  if (insight) {
    scale("votes-scale", { colours: stops(), labels: ["0", "25 %", "most votes"] }); // by the root of their share
    insight.draw();
  }
}

function update() {
  const matches = shown();
  if (state.chosen && !matches.includes(state.chosen)) state.chosen = null;
  const current = state.chosen ?? state.hovered;
  $("least-value").textContent = state.least.toFixed(2);
  $("count").textContent = `${matches.length} of ${state.explanation.matches.length} matches`;
  $("status").textContent = current
    ? `Match ${current.number + 1}` : matches.length ? "No match chosen"
      : state.explanation.matches.length ? "No match is so certain" : "There are no matches";
  const facts = current ? [
    [names[0], `vertex ${current.source}`], [names[1], `vertex ${current.target}`],
    ["confidence", current.confidence.toFixed(3)], ["kind", current.shown],
    ...(current.error === undefined ? [] : [["error", wrongness(current.error)]]),
  ] : [];
  $("hint").hidden = current !== null;
  $("facts").replaceChildren(...facts.flatMap(([name, value]) => [element("dt", name), element("dd", value)]));
  $("turn").disabled = !view || !state.chosen;
  const sought = matches.filter(fits);
  $("unfound").textContent = sought.length || !$("find").value ? "" : "None of the matches has this number.";
  all("tbody tr").forEach((row, i) => {
    row.hidden = !sought.includes(state.explanation.matches[i]);
    if (state.explanation.matches[i] === state.chosen) row.setAttribute("aria-current", "true");
    else row.removeAttribute("aria-current");
    row.querySelector("i").style.background = css(colours(), i);
  });
  const drawn = $("spheres").checked ? matches : matches.filter((match) => match === current);
  view?.show(state.explanation, drawn, current, colours());
  insight?.show(matches, current, state.explanation.colours);
}

// Whether the number of a match or of one of its vertices begins as what is looked for.
function fits(match) {
  const sought = $("find").value.trim();
  return [match.number + 1, match.source, match.target].some((number) => String(number).startsWith(sought));
}

function wrongness(error) {
  return error === null ? "not known" : `${percent(error)} of the diameter`;
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

function choose(match) {
  state.chosen = match;
  state.hovered = null;
  update();
}

function step(by) {
  const matches = shown();
  if (!matches.length) return;
  const at = matches.indexOf(state.chosen);
  choose(matches[at < 0 ? (by > 0 ? 0 : matches.length - 1) : (at + by + matches.length) % matches.length]);
}

function explain(k) {
  state.explanation = data.explanations[k];
  state.chosen = state.hovered = null;
  $("find").value = "";
  $("given").hidden = !state.explanation.matches.some((match) => match.given);
  $("explained").textContent = state.explanation.note;
  const errors = (state.explanation.errors ?? []).filter((error) => error !== null);
  const mean = errors.reduce((sum, error) => sum + error, 0) / errors.length;
  const near = errors.filter((error) => error <= 0.05).length / errors.length;
  $("wrong").textContent = errors.length ? `Mean error ${percent(mean)} of the target's diameter; ${percent(near)} of ` +
    "the matches within 5 %." : "No error is known.";
  document.querySelector("tbody").replaceChildren(...state.explanation.matches.map((match) => {
    const row = document.createElement("tr");
    const button = document.createElement("button");
    const spot = document.createElement("i");
    button.type = "button";
    button.append(spot, String(match.number + 1));
    button.addEventListener("click", () => choose(match));
    const error = match.error === undefined ? [] : [match.error === null ? "" : (100 * match.error).toFixed(1)];
    row.append(...["", match.source, match.target, match.confidence.toFixed(3), ...error, match.shown].map(
      (value) => element("td", value)));
    row.firstChild.append(button);
    return row;
  }));
  update();
}

function paint(k) {
  const colouring = data.colourings[k - 1] ?? null;
  $("coloured").textContent = colouring?.note ?? "";
  scale("scale", colouring?.scale);
  $("spheres").checked = colouring === null; // they would hide the colours
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

function select(id, rows, changed) {
  if (rows.length < 2) return;
  all(`.${id}`).forEach((part) => (part.hidden = false));
  $(id).append(...rows.map((row, k) => new Option(row, k)));
  $(id).addEventListener("change", () => changed(Number($(id).value)));
}

function follow() {
  all(".end").forEach((label, s) => {
    const current = view.chosen;
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

function pointing() {
  let down = null;
  const place = (event) => {
    const box = $("view").getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top, event.pointerType === "touch" ? 22 : 8];
  };
  $("view").addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]));
  $("view").addEventListener("pointerup", (event) => {
    if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 5) choose(view.pick(...place(event)));
    down = null;
  });
  $("view").addEventListener("pointermove", (event) => {
    if (event.buttons || event.pointerType === "touch") return;
    const match = view.pick(...place(event));
    $("view").classList.toggle("over", match !== null);
    if (match !== state.hovered) {
      state.hovered = match;
      if (!state.chosen) update();
    }
  });
  $("view").addEventListener("pointerleave", () => {
    state.hovered = null;
    if (!state.chosen) update();
  });
}

// Each name by itself: one that is written from the right must not turn what follows.
document.querySelector("h1").append(element("bdi", names[0]), " \u2194 ", element("bdi", names[1]));
all(".name").forEach((name, s) => {
  const { vertices, simplified } = data.sides[s];
  const size = `, ${vertices.toLocaleString("en")} vertices${simplified ? ", drawn with fewer" : ""}`;
  name.append(s ? "Target: " : "Source: ", element("bdi", names[s]), element("span", size));
});
try {
  view = new View($("view"), $("lines"), data);
  view.onDraw = follow;
  pointing();
} catch (error) {
  $("failure").hidden = false;
  $("failure").textContent = "This browser cannot draw the shapes (WebGL 2 is needed). The table lists the matches.";
  console.warn(error);
}
$("least").min = Math.floor(100 * Math.min(1, ...data.explanations.flatMap((one) => one.matches.map((m) => m.certain)))) / 100;
$("least").value = $("least").min;
state.least = Number($("least").value);
$("least").addEventListener("input", () => {
  state.least = Number($("least").value);
  update();
});
select("explanation", data.explanations.map((one) => one.name), explain);
select("colouring", ["Plain", ...data.colourings.map((one) => one.name)], paint);
select("marked", data.errors ? ["by place", "by error"] : [], (k) => {
  state.byError = k === 1;
  scale("marked-scale", state.byError && data.errors.scale);
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
  const told = (text) => ($("told").textContent = text || "Point at a dot or at a cell of the matrix to see its pair.");
  const pick = (vertex) => choose(shown().find((match) => match.source === vertex) ?? null);
  insight = new Insight(all("#insight canvas"), data.insight, told, pick);
  told("");
  $("triplets").textContent = data.insight.triplets.toLocaleString("en");
  $("how").hidden = false;
  $("how").addEventListener("click", () => {
    $("insight").hidden = !$("insight").hidden;
    $("how").setAttribute("aria-pressed", String(!$("insight").hidden));
    insight.draw();
  });
}
$("spheres").addEventListener("change", update);
$("all-lines").addEventListener("change", () => {
  if (view) view.allLines = $("all-lines").checked;
  update();
});
$("previous").addEventListener("click", () => step(-1));
$("next").addEventListener("click", () => step(1));
$("reset").addEventListener("click", () => view?.reset());
$("turn").addEventListener("click", () => view.face(state.chosen));
all("[data-from]").forEach((button) => button.addEventListener("click", () =>
  view?.reset(...button.dataset.from.split(",").map((degrees) => (Number(degrees) * Math.PI) / 180))));
$("find").addEventListener("input", update);
$("find").addEventListener("keydown", (event) => {
  const sought = shown().filter(fits);
  const number = $("find").value.trim();
  if (event.key === "Enter" && number && sought.length) {
    choose(sought.find((match) => [match.source, match.target].map(String).includes(number)) ?? sought[0]);
  }
});
$("theme").addEventListener("click", () => theme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
$("picture").addEventListener("click", () => {
  if (!view) return;
  const painted = view.colouring?.scale && { name: view.colouring.name, ...view.colouring.scale };
  const scale = painted ?? (state.byError ? { name: "Error", ...data.errors.scale } : null);
  picture(view, names, scale, (blob) => download("matches.png", blob));
});
$("json").addEventListener("click", () => download("matches.json", new Blob([data.text], { type: "application/json" })));
$("csv").addEventListener("click", () =>
  download("matches.csv", new Blob([csv(state.explanation.matches)], { type: "text/csv" })));
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.key === "Escape") choose(null);
  if (event.target instanceof Element && event.target.matches("select, input[type=range], input[type=search]")) return;
  if (event.key === "ArrowRight" || event.key === "ArrowLeft") {
    event.preventDefault();
    step(event.key === "ArrowRight" ? 1 : -1);
  }
});
dark.addEventListener("change", () => theme(dark.matches ? "dark" : "light"));
if (innerWidth <= 760) $("list").open = false;
$("notes").hidden = !data.result.warnings.length;
$("notes").querySelector("ul").append(...data.result.warnings.map((line) => element("li", line)));
theme(dark.matches ? "dark" : "light");
explain(0);
paint(0);
