// The page of `pore view`: it draws scenes with the shaders that come with them, and sends what is set.
import { Camera, VIEWS } from "./camera.js";
import { control, legend, made, outputs, shown } from "./controls.js";
import { Line } from "./line.js";
import { Painter } from "./painter.js";
import { SourcePane } from "./source.js";

const element = (id) => document.getElementById(id);
const canvas = element("view");
const camera = new Camera();
const options = new URLSearchParams(location.search);
const stats = options.has("stats");
const told = { text: "", scene: "", export: "", measure: "" };  // what is wrong, by what it is about
const state = { program: null, settings: {}, outputs: [], paint: "", plane: false, scene: null, fitted: "" };
let texts = [];  // of the shaders that came, in their order

// ---- what is said ---------------------------------------------------------------------------------------------------

function wrong(of, text) {
  told[of] = text;
  const all = Object.values(told).filter(Boolean).join("\n\n");
  element("said-text").textContent = all;
  element("said").hidden = !all;
}
element("said-shut").onclick = () => { element("said").hidden = true; };

const doings = new Map();  // by purpose
function doing(of, what, share) {
  if (what) doings.set(of, { what, share });
  else doings.delete(of);
  const [purpose, first] = [...doings].find(([name]) => name !== "measure") ?? [];
  element("doing").hidden = !first;
  if (!first) return;
  element("doing-what").textContent = first.what;
  element("doing-share").hidden = first.share === undefined;
  element("doing-share").value = first.share ?? 0;
  element("stop").hidden = purpose !== "scene" && purpose !== "export";
  element("stop").onclick = () => line.send({ do: "cancel", of: purpose });
}

// ---- the picture ----------------------------------------------------------------------------------------------------

let painter = null;
try {
  painter = new Painter(canvas, camera, (text) => {
    element("stats").hidden = !stats;
    element("stats").textContent = text;
  });
  painter.refines = options.get("refine") !== "0";
} catch (error) {
  wrong("scene", error.message);
}

const moved = () => painter?.moved();

function fit() {
  if (!state.scene) return;
  camera.fit(state.scene.lo, state.scene.hi, canvas.clientWidth / canvas.clientHeight);
  moved();
}

function take(scene) {
  const layers = [...scene.bodies, ...(scene.plane ? [scene.plane] : [])];
  layers.forEach((layer, i) => { layer.text ??= texts[scene.plane === layer ? "plane" : i]; });
  texts = scene.bodies.map((body) => body.text);
  texts.plane = scene.plane?.text;
  doing("scene", "compiling the shader");
  painter?.take(scene, (refused) => {
    doing("scene", "");
    wrong("scene", refused);
    if (refused) return;
    state.scene = scene;
    const names = scene.bodies.map((body) => body.name).join(" ");
    canvas.dataset.outputs = names;
    if (state.fitted !== names) fit();
    state.fitted = names;
    legend(element("legend"), scene.scale);
    across();
    listed();
    moved();
  });
}

new ResizeObserver(moved).observe(canvas);

// ---- mouse, touch and keys ------------------------------------------------------------------------------------------

const held = new Map();
canvas.addEventListener("contextmenu", (e) => e.preventDefault());
canvas.addEventListener("pointerdown", (e) => {
  canvas.setPointerCapture(e.pointerId);
  held.set(e.pointerId, { x: e.clientX, y: e.clientY, moves: e.button !== 0 || e.shiftKey, cuts: e.altKey });
});
canvas.addEventListener("pointermove", (e) => {
  const last = held.get(e.pointerId);
  if (!last) return;
  const dx = e.clientX - last.x, dy = e.clientY - last.y;
  if (held.size === 2) {
    const [other] = [...held].filter(([id]) => id !== e.pointerId).map(([, place]) => place);
    const before = Math.hypot(last.x - other.x, last.y - other.y), now = Math.hypot(e.clientX - other.x, e.clientY - other.y);
    if (before > 0 && now > 0) camera.closer(now / before);
    camera.move(dx / 2, dy / 2, canvas.clientHeight);
  } else if (last.cuts) slide(dx, dy);
  else if (last.moves) camera.move(dx, dy, canvas.clientHeight);
  else camera.turn(-0.4 * dx, 0.4 * dy);
  last.x = e.clientX;
  last.y = e.clientY;
  moved();
});
for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (e) => held.delete(e.pointerId));
canvas.addEventListener("wheel", (e) => {
  e.preventDefault();
  camera.closer(Math.exp(-e.deltaY * (e.deltaMode === 1 ? 0.04 : 0.0015)));
  moved();
}, { passive: false });
canvas.addEventListener("keydown", (e) => {
  if (e.ctrlKey || e.metaKey) return;
  const turn = e.shiftKey ? 1 : 5;
  const keys = e.altKey ? {
    ArrowLeft: () => step(-1), ArrowDown: () => step(-1), ArrowRight: () => step(1), ArrowUp: () => step(1),
  } : {
    ArrowLeft: () => camera.turn(-turn, 0), ArrowRight: () => camera.turn(turn, 0),
    ArrowUp: () => camera.turn(0, turn), ArrowDown: () => camera.turn(0, -turn),
    "+": () => camera.closer(1.15), "=": () => camera.closer(1.15), "-": () => camera.closer(1 / 1.15),
    f: fit, o: project, e: () => source.open(element("source").hidden),
  };
  if (!e.altKey) Object.keys(VIEWS).forEach((name, i) => { keys[i + 1] = () => stand(name); });
  const act = keys[e.key] ?? keys[e.key.toLowerCase()];
  if (!act) return;
  e.preventDefault();
  act();
  moved();
});

function stand(name) {
  [camera.azimuth, camera.elevation] = VIEWS[name];
  fit();
}

function project() {
  camera.perspective = !camera.perspective;
  element("projection").setAttribute("aria-pressed", String(!camera.perspective));
  moved();
}

Object.keys(VIEWS).forEach((name, i) => {
  const button = made("button", { textContent: name, title: String(i + 1) });
  button.onclick = () => stand(name);
  element("views").append(button);
});
element("fit").onclick = fit;
element("projection").onclick = project;

// ---- the section ----------------------------------------------------------------------------------------------------

const AXES = ["x", "y", "z"];
for (const [axis, name] of [[-1, "none"], ...AXES.entries()]) {
  const button = made("button", { textContent: name, id: `across-${name}` });
  button.onclick = () => cross(axis);
  element("axes").append(button);
}

function cross(axis) {
  const { scene } = state;
  if (!painter || !scene) return;
  const section = painter.section;
  if (axis >= 0 && axis !== section.axis) {
    section.offset = (scene.lo[axis] + scene.hi[axis]) / 2;
    section.keeps = camera.axes().out[axis] > 0 ? -1 : 1;  // what is before the section is taken away
  }
  section.axis = axis;
  across();
  show();
  moved();
}

function across() {
  const { axis, offset } = painter.section;
  AXES.concat("none").forEach((name) => element(`across-${name}`).setAttribute("aria-pressed", String(name === (AXES[axis] ?? "none"))));
  element("section-more").hidden = axis < 0;
  element("plane").setAttribute("aria-pressed", String(state.plane));
  if (axis < 0) return;
  const [lo, hi] = [state.scene.lo[axis], state.scene.hi[axis]];
  Object.assign(element("offset"), { min: lo, max: hi });
  element("offset").value = offset;
  if (document.activeElement !== element("offset-number")) element("offset-number").value = shown(offset);
}

function cutAt(offset) {
  const { axis } = painter.section;
  if (axis < 0 || !Number.isFinite(offset)) return;
  painter.section.offset = Math.min(Math.max(offset, state.scene.lo[axis]), state.scene.hi[axis]);
  across();
  moved();
}

function slide(dx, dy) {
  const { axis, offset } = painter.section;
  if (axis < 0) return;
  const { right, up } = camera.axes();
  const length = Math.max(0.05, right[axis] ** 2 + up[axis] ** 2);
  cutAt(offset + (dx * right[axis] - dy * up[axis]) / length * camera.height / canvas.clientHeight);
}

function step(way) {
  const { axis, offset } = painter.section;
  if (axis >= 0) cutAt(offset + way * (state.scene.hi[axis] - state.scene.lo[axis]) / 100);
}

element("offset").oninput = () => cutAt(Number(element("offset").value));
element("offset-number").oninput = () => cutAt(parseFloat(element("offset-number").value));
element("flip").onclick = () => { painter.section.keeps *= -1; moved(); };
element("plane").onclick = () => { state.plane = !state.plane; across(); show(); };
element("paint").onchange = () => { state.paint = element("paint").value.trim(); show(); };

// ---- settings -------------------------------------------------------------------------------------------------------

const waiting = new Map();  // what was set since the last frame: a slider says more than can be drawn
function set(name, value) {
  state.settings[name] = value;
  if (!waiting.size) requestAnimationFrame(() => {
    line.send({ do: "set", settings: Object.fromEntries(waiting) });
    waiting.clear();
  });
  waiting.set(name, value);
}

function show() {
  line.send({ do: "show", outputs: state.outputs, paint: state.paint, plane: state.plane && painter?.section.axis >= 0 });
}

function listed() {
  const bodies = state.program?.bodies ?? [];
  element("outputs").hidden = bodies.length < 2;
  if (bodies.length < 2) return;
  const drawn = state.scene?.bodies ?? [];
  const names = drawn.map((body) => body.name);
  const colours = new Map(drawn.map((body) => [body.name, body.colour]));
  element("outputs").replaceChildren(made("h2", { textContent: "Outputs" }), ...outputs(bodies, names, colours, (next) => { state.outputs = next; show(); }));
}

function programmed(program) {
  const focused = document.activeElement?.id;
  state.program = program;
  element("file").textContent = document.title = program.file;
  wrong("text", program.wrong.join("\n\n"));
  state.settings = Object.fromEntries(program.params.filter((p) => p.value !== p.default).map((p) => [p.name, p.value]));
  element("params-all").hidden = !program.params.length;
  element("params").replaceChildren(...program.params.map((param) => control(param, set)));
  element("presets").hidden = !program.presets.length;
  element("presets").replaceChildren(new Option("preset ...", ""), ...program.presets.map((name) => new Option(name)));
  element("fields").replaceChildren(...program.fields.map((name) => made("option", { value: name })));
  listed();
  if (focused) element(focused)?.focus({ preventScroll: true });
}
element("presets").onchange = () => { if (element("presets").value) line.send({ do: "preset", name: element("presets").value }); };
element("defaults").onclick = () => line.send({ do: "preset", name: "" });

// ---- measures and files ---------------------------------------------------------------------------------------------

const MEASURED = { porosity: "porosity", volume: "volume", area: "area", size: "size", solid_components: "pieces" };

function measured({ output, rows }) {
  element("measures-head").textContent = `Measures of ${output}`;
  element("rows").style.opacity = 1;
  element("rows").replaceChildren(...rows.filter(([name]) => MEASURED[name] || !/^[a-z_]+$/.test(name)).flatMap(([name, value, error]) => [
    made("dt", { textContent: MEASURED[name] ?? name }), made("dd", { textContent: value, title: error }, error && name !== "size" ? ` ${error.replace(/ mm.$/, "")}` : ""),
  ]));
}

function checked({ checks }) {
  const marks = { true: ["✓", "holds"], false: ["✗", "fails"], null: ["?", "not certain"] };
  element("checks").replaceChildren(...checks.map(({ text, holds, why }) =>
    made("li", { className: marks[holds][1], title: marks[holds][1] }, `${marks[holds][0]} ${text}`, made("div", { className: "quiet", textContent: why }))));
}

for (const [ending, what] of [[".stl", "STL"], [".3mf", "3MF"], [".ply", "PLY"], [".obj", "OBJ"], [".glb", "GLB"], [".vtp", "VTP"]])
  element("ending").append(new Option(what, ending));
element("export").onclick = () => {
  const [body] = state.scene?.bodies ?? [];
  wrong("export", "");
  if (body) line.send({ do: "export", output: body.name, ending: element("ending").value, voxel: element("voxel").value.trim() || "auto" });
};
element("picture").onclick = () => canvas.toBlob((blob) => {
  const link = made("a", { href: URL.createObjectURL(blob), download: `${state.program.file.replace(/\.pore$/, "")}.png` });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);  // not before it is written
});

function ready({ name, what, link }) {
  // a browser asks before it takes a second file that nobody has clicked for: so this is clicked for
  const anchor = made("a", { href: link, download: name, textContent: `Save ${name}` });
  element("made").replaceChildren(anchor, made("div", { className: "quiet", textContent: what }));
  if (document.activeElement === element("export")) anchor.focus();
}

// ---- the line -------------------------------------------------------------------------------------------------------

const source = new SourcePane((word) => line.send(word));
const heard = {
  scene: take,
  program: programmed,
  doubts: ({ doubts }) => { element("doubts").textContent = doubts.join("\n\n"); element("doubts").hidden = !doubts.length; },
  doing: ({ of, what, share }) => doing(of, what, share),
  done: ({ of }) => doing(of, ""),
  cancelled: ({ of }) => { if (of === "measure") element("measures-head").textContent = "Measures: not of this part yet"; },
  refused: ({ of, text }) => wrong(of, text),
  measuring: ({ output }) => {
    wrong("measure", "");
    element("measures").hidden = false;
    element("measures-head").textContent = `Measuring ${output} ...`;
    element("rows").style.opacity = 0.5;  // of the part as it was
  },
  checked,
  measured,
  made: ready,
};
let opened = 0;
const line = new Line(
  (word) => {
    heard[word.say]?.(word);
    source.heard(word);
  },
  () => {
    doing("line", "");
    texts = [];
    if (!opened++) return;
    source.again();
    if (Object.keys(state.settings).length) line.send({ do: "set", settings: state.settings });
    show();
  },
  () => doing("line", "`pore view` has ended"),
);
