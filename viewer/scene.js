// Both shapes with their matches, side by side or one above the other, seen by one camera.
import {
  AmbientLight, BoxGeometry, Color, CylinderGeometry, DirectionalLight, InstancedMesh, Matrix4, Mesh, MeshBasicMaterial,
  MeshPhongMaterial, OctahedronGeometry, OrthographicCamera, Quaternion, Raycaster, RingGeometry, Scene, SphereGeometry,
  SRGBColorSpace, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { rulers } from "./ruler.js";
import { Surface, textureOf } from "./surface.js";

const MARGIN = 1.12;
export const STRIP = 30; // height of the name above each shape, in CSS pixels

export class View {
  constructor(canvas, lines, data) {
    this.canvas = canvas;
    this.lines = lines;
    this.data = data;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setClearColor(0, 0);
    this.camera = new OrthographicCamera(-1, 1, 1, -1, 0.1, 20);
    this.camera.add(lamp(-0.6, 0.9, 1, 1.9), lamp(0.8, -0.4, 0.6, 0.5));
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.minZoom = 0.5;
    this.controls.maxZoom = 40;
    this.extent = [1, 1]; // half the width and height that the first view shows
    this.controls.addEventListener("change", () => this.redraw());
    this.sides = data.sides.map((side) => this.#side(side));
    this.allLines = false;
    this.direction = [data.azimuth, data.elevation];
    this.time = 0; // of the morph
    this.onDraw = () => {};
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.reset();
  }

  #side(data) {
    const scene = new Scene();
    const surface = new Surface(data);
    const halo = new Mesh(new RingGeometry(1.35, 1.75, 48), new MeshBasicMaterial({ depthTest: false }));
    halo.renderOrder = 3;
    halo.visible = false;
    scene.add(surface.mesh, halo, new AmbientLight(0xffffff, 0.95));
    const loops = data.loops ? rods(data.loops, 0.3 * this.data.radius) : null;
    if (loops) scene.add(loops);
    return { scene, surface, halo, loops, marks: [], points: null };
  }

  // Show these matches of an alignment in their colours; `selected` is one of them or null.
  show(alignment, matches, selected, colours) {
    this.colours = colours;
    this.matches = matches;
    this.selected = selected;
    const kinds = [[], [], []];
    for (const match of matches) kinds[match.given ? 2 : match.kind === "voted" ? 0 : 1].push(match);
    this.sides.forEach((side, s) => {
      side.points = s || !this.time ? alignment.points[s]
        : this.#interpolate([this.#first(alignment.points[0]), ...alignment.moved]);
      for (const mark of side.marks) {
        side.scene.remove(mark);
        mark.dispose();
      }
      side.marks = kinds.map((kind, k) => this.#marks(side, kind, k)).filter(Boolean);
      for (const mark of side.marks) side.scene.add(mark);
      side.halo.visible = selected !== null;
      if (selected !== null) {
        side.halo.position.copy(this.point(s, selected));
        side.halo.scale.setScalar(this.size(selected));
      }
    });
    this.redraw();
  }

  #marks(side, matches, k) {
    if (!matches.length) return null;
    const marks = new InstancedMesh(SHAPES[k], MARK[k], matches.length);
    const at = new Vector3(), turn = new Quaternion(), size = new Vector3(), matrix = new Matrix4();
    const colour = new Color();
    matches.forEach((match, i) => {
      at.fromArray(side.points, 3 * match.number);
      marks.setMatrixAt(i, matrix.compose(at, turn, size.setScalar(this.size(match))));
      const rgb = this.colours.subarray(3 * match.number, 3 * match.number + 3);
      marks.setColorAt(i, colour.setRGB(rgb[0] / 255, rgb[1] / 255, rgb[2] / 255, SRGBColorSpace));
    });
    marks.frustumCulled = false;
    return marks;
  }

  // Colour the surfaces: null for plain, or one of the colourings.
  paint(colouring) {
    this.colouring = colouring;
    if (colouring?.texture) this.texture ??= textureOf(this.data.texture, () => this.redraw());
    this.sides.forEach(({ surface }, s) =>
      surface.paint(colouring?.colours?.[s], colouring?.checker, colouring?.texture && this.texture));
    this.theme();
  }

  // Show the source, or its mirror image if that was matched, between itself (0) and the target (1); `show` then moves the matches too.
  morph(time) {
    const changed = Boolean(time) !== Boolean(this.time);
    this.time = time;
    if (changed) this.#fit();
    if (this.sides[0].loops) this.sides[0].loops.visible = !time;
    this.sides[0].surface.move(this.#interpolate([this.#first(this.data.sides[0].positions), ...this.data.morph]));
    this.redraw();
  }

  // Positions on the source as the morph begins with them: those of its mirror image, if that was matched.
  #first(positions) {
    if (!this.data.result.reflected || !this.time) return positions;
    return positions.map((value, i) => (i % 3 ? value : -value));
  }

  #interpolate(frames) {
    const at = this.time * (frames.length - 1);
    const k = Math.min(Math.floor(at), frames.length - 2);
    return frames[k].map((value, i) => value + (at - k) * (frames[k + 1][i] - value));
  }

  theme() {
    const style = getComputedStyle(document.documentElement);
    for (const side of this.sides) {
      side.surface.mesh.material.color.set(this.colouring ? "#e4e4e4" : style.getPropertyValue("--surface").trim());
      side.halo.material.color.set(style.getPropertyValue("--ink").trim());
    }
    this.redraw();
  }

  size(match) {
    return this.data.radius * (0.4 + 0.6 * match.certainty);
  }

  point(s, match) {
    return new Vector3().fromArray(this.sides[s].points, 3 * match.number);
  }

  // The boxes [left, top, width, height] of both shapes in CSS pixels, below their names; side by side or one above the
  // other, whichever shows the shapes larger.
  boxes() {
    const { clientWidth: w, clientHeight: h } = this.canvas;
    const scale = (width, height) => Math.min(width / this.extent[0], height / this.extent[1]);
    const beside = scale(w / 2, h - STRIP) * 1.1 >= scale(w, h / 2 - STRIP);
    const [width, height] = beside ? [w / 2, h] : [w, h / 2];
    return [0, 1].map((s) => [beside ? s * width : 0, STRIP + (beside ? 0 : s * height), width, height - STRIP]);
  }

  // Show both shapes completely from a direction in radians, by default that of the first view.
  reset(azimuth = this.data.azimuth, elevation = this.data.elevation) {
    this.direction = [azimuth, elevation];
    this.controls.target.set(0, 0, 0);
    this.camera.zoom = 1;
    this.#look(new Vector3(
      Math.sin(azimuth) * Math.cos(elevation), Math.sin(elevation), Math.cos(azimuth) * Math.cos(elevation)));
    this.#fit();
  }

  // Rotate both so that the ends of a match face the viewer, as well as one direction allows.
  face(match) {
    const [source, target] = this.sides.map(({ surface }, s) => surface.normal(this.point(s, match)));
    const mean = source.clone().add(target);
    this.#look(mean.length() > 0.5 ? mean : source); // ends that face opposite ways cannot both be visible
  }

  #look(direction) {
    this.camera.position.copy(this.controls.target).addScaledVector(direction.normalize(), 8);
    this.controls.update();
    this.redraw();
  }

  // Set the extent of the view: both shapes, and during the morph those between them.
  #fit() {
    const { sides, morph } = this.data;
    const [a, e] = this.direction;
    let width = 1e-3, height = 1e-3;
    for (const positions of [...sides.map((side) => side.positions), ...(this.time ? morph : [])]) {
      for (let i = 0; i < positions.length; i += 3) {
        const [x, y, z] = positions.subarray(i, i + 3);
        width = Math.max(width, Math.abs(Math.cos(a) * x - Math.sin(a) * z));
        height = Math.max(height, Math.abs(Math.cos(e) * y - Math.sin(e) * (Math.sin(a) * x + Math.cos(a) * z)));
      }
    }
    this.extent = [width, height];
    this.resize();
  }

  // Resize the canvas, with `ratio` pixels along a CSS pixel.
  resize(ratio = Math.min(window.devicePixelRatio, 2)) {
    const { clientWidth: w, clientHeight: h } = this.canvas;
    if (!w || !h) return;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(w, h, false);
    this.lines.width = w * ratio;
    this.lines.height = h * ratio;
    const [, , width, height] = this.boxes()[0];
    const half = MARGIN * Math.max(this.extent[1], (this.extent[0] * height) / width);
    Object.assign(this.camera, { top: half, bottom: -half, right: (half * width) / height, left: (-half * width) / height });
    this.camera.updateProjectionMatrix();
    this.redraw();
  }

  redraw() {
    this.frame ??= requestAnimationFrame(() => this.draw());
  }

  draw() {
    if (this.frame) cancelAnimationFrame(this.frame);
    this.frame = null;
    const { renderer, camera } = this;
    const h = this.canvas.clientHeight;
    renderer.setScissorTest(true);
    this.boxes().forEach(([x, y, w, tall], s) => {
      renderer.setViewport(x, h - y - tall, w, tall);
      renderer.setScissor(x, h - y - tall, w, tall);
      const side = this.sides[s];
      side.halo.quaternion.copy(camera.quaternion);
      side.scene.add(camera);
      renderer.render(side.scene, camera);
    });
    this.#drawLines();
    this.onDraw();
  }

  // The position of a match on the canvas, in CSS pixels; z is its depth.
  project(s, match) {
    const [x, y, w, h] = this.boxes()[s];
    const at = this.point(s, match).project(this.camera);
    return { x: x + ((at.x + 1) / 2) * w, y: y + ((1 - at.y) / 2) * h, z: at.z };
  }

  #drawLines() {
    const context = this.lines.getContext("2d");
    const ratio = this.lines.width / this.canvas.clientWidth;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, this.canvas.clientWidth, this.canvas.clientHeight);
    const ink = getComputedStyle(document.documentElement).getPropertyValue("--ink");
    const shown = this.allLines ? this.matches : this.matches.filter((match) => match === this.selected);
    for (const match of shown) {
      const [from, to] = [0, 1].map((s) => this.project(s, match));
      const rgb = this.colours.subarray(3 * match.number, 3 * match.number + 3);
      const selected = match === this.selected;
      context.globalAlpha = selected ? 1 : 0.55;
      for (const [colour, width] of [...(selected ? [[ink, 4.5]] : []), [`rgb(${rgb.join(",")})`, selected ? 2.5 : 1]]) {
        context.strokeStyle = colour;
        context.lineWidth = width;
        context.beginPath();
        context.moveTo(from.x, from.y);
        context.lineTo(to.x, to.y);
        context.stroke();
      }
    }
    rulers(context, this.boxes(), this.data.sides.map(({ unit }) => unit * this.pixels()));
  }

  // CSS pixels per unit of length of the scene.
  pixels() {
    return (this.boxes()[0][3] * this.camera.zoom) / (2 * this.camera.top);
  }

  // The visible match at a position of the canvas, or null.
  pick(x, y, reach) {
    const s = this.boxes().findIndex(([left, top, w, h]) => x >= left && x < left + w && y >= top && y < top + h);
    if (s < 0 || !this.sides[s].marks.length) return null;
    const pixels = this.pixels();
    return this.matches
      .map((match) => ({ match, at: this.project(s, match), radius: this.size(match) * pixels }))
      .map((hit) => ({ ...hit, distance: Math.hypot(hit.at.x - x, hit.at.y - y) }))
      .filter((hit) => hit.distance <= Math.max(hit.radius, reach))
      .sort((a, b) => a.distance - b.distance)
      .find((hit) => !this.#hidden(s, hit.match))?.match ?? null;
  }

  #hidden(s, match) {
    const at = this.point(s, match);
    const projected = at.clone().project(this.camera);
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2(projected.x, projected.y), this.camera);
    const first = ray.intersectObject(this.sides[s].surface.mesh)[0];
    return first !== undefined && first.distance < ray.ray.origin.distanceTo(at) - 1.1 * this.size(match);
  }
}

const SHAPES = [new SphereGeometry(1, 18, 12), new OctahedronGeometry(1.25), new BoxGeometry(1.6, 1.6, 1.6)];
const MARK = [
  new MeshPhongMaterial({ specular: 0x444444, shininess: 60 }),
  new MeshPhongMaterial({ specular: 0x222222, flatShading: true }),
  new MeshPhongMaterial({ specular: 0x222222, flatShading: true }),
];
MARK[0].onBeforeCompile = (shader) => { // a dark rim separates spheres from each other and from the surface
  shader.fragmentShader = shader.fragmentShader.replace("#include <opaque_fragment>",
    "outgoingLight *= mix(0.3, 1.0, smoothstep(0.15, 0.5, normal.z));\n#include <opaque_fragment>");
};

// Thin rods between pairs of points (x, y, z twice), for the loops around handles.
function rods(ends, radius) {
  const made = new InstancedMesh(ROD, LOOP, ends.length / 6);
  const from = new Vector3(), to = new Vector3(), turn = new Quaternion(), matrix = new Matrix4();
  for (let i = 0; i < made.count; i++) {
    from.fromArray(ends, 6 * i);
    to.fromArray(ends, 6 * i + 3);
    const along = to.clone().sub(from);
    const size = new Vector3(radius, along.length(), radius);
    turn.setFromUnitVectors(UP, along.normalize());
    made.setMatrixAt(i, matrix.compose(from.add(to).multiplyScalar(0.5), turn, size));
  }
  made.frustumCulled = false;
  return made;
}

const UP = new Vector3(0, 1, 0);
const ROD = new CylinderGeometry(1, 1, 1, 8);
const LOOP = new MeshBasicMaterial({ color: 0xb3126a });

function lamp(x, y, z, strength) {
  const light = new DirectionalLight(0xffffff, strength);
  light.position.set(x, y, z);
  return light;
}
