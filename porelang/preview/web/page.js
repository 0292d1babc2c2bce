// The page of `pore view`: it draws scenes with the shader that comes with them, and sends what is set.
import { Camera, VIEWS } from "./camera.js";
import { Painter } from "./painter.js";

const element = (id) => document.getElementById(id);
const canvas = element("view");
const camera = new Camera();
const stats = new URLSearchParams(location.search).has("stats");
let painter = null;
let fitted = false;
let socket = null;

function say(text) {
  element("said").textContent = text;
  element("said").hidden = !text;
}

function doing(text) {
  element("doing").textContent = text;
  element("doing").hidden = !text;
}

// ---- the picture ----------------------------------------------------------------------------------------------------

try {
  painter = new Painter(canvas, camera, (told) => {
    if (!stats) return;
    element("stats").hidden = false;
    element("stats").textContent = told;
  });
} catch (error) {
  say(error.message);
}

function moved() {
  painter?.moved();
}

function fit() {
  if (!painter?.scene) return;
  camera.fit(painter.scene.lo, painter.scene.hi, canvas.clientWidth / canvas.clientHeight);
  moved();
}

function take(buffer) {
  const size = new DataView(buffer).getUint32(0, true);
  const scene = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, size)));
  const from = 4 + size;
  const cells = scene.counts[0] * scene.counts[1] * scene.counts[2];
  scene.cells = new Float32Array(buffer, from, cells);
  let at = from + 4 * cells;
  scene.data = scene.words.map((count) => {
    const words = new Uint32Array(buffer, at, count);
    at += 4 * count;
    return words;
  });
  doing(scene.text === null ? "" : "compiling the shader");
  painter?.take(scene, (wrong) => {
    doing("");
    if (wrong) return say(wrong);
    document.body.dataset.output = scene.output;
    if (!fitted) fit();
    fitted = true;
  });
}

new ResizeObserver(() => moved()).observe(canvas);

// ---- mouse, touch and keys ------------------------------------------------------------------------------------------

const held = new Map();
canvas.addEventListener("contextmenu", (e) => e.preventDefault());
canvas.addEventListener("pointerdown", (e) => {
  canvas.setPointerCapture(e.pointerId);
  held.set(e.pointerId, { x: e.clientX, y: e.clientY, moves: e.button !== 0 || e.shiftKey });
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
  } else if (last.moves) camera.move(dx, dy, canvas.clientHeight);
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
  if (e.ctrlKey || e.metaKey || e.altKey) return;
  const turn = e.shiftKey ? 1 : 5;
  const keys = {
    ArrowLeft: () => camera.turn(-turn, 0), ArrowRight: () => camera.turn(turn, 0),
    ArrowUp: () => camera.turn(0, turn), ArrowDown: () => camera.turn(0, -turn),
    "+": () => camera.closer(1.15), "=": () => camera.closer(1.15), "-": () => camera.closer(1 / 1.15),
    f: fit, o: project,
  };
  Object.keys(VIEWS).forEach((name, i) => { keys[i + 1] = () => stand(name); });
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
  const button = document.createElement("button");
  button.textContent = name;
  button.title = String(i + 1);
  button.onclick = () => stand(name);
  element("views").append(button);
});
element("fit").onclick = fit;
element("projection").onclick = project;

// ---- settings -------------------------------------------------------------------------------------------------------

function send(word) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(word));
}

const wanted = new Map();  // what was set since the last frame: a slider says more than can be drawn
function set(name, value) {
  if (!wanted.size) requestAnimationFrame(() => { send({ set: Object.fromEntries(wanted) }); wanted.clear(); });
  wanted.set(name, value);
}

const shown = (value) => String(Number(Number(value).toPrecision(6)));

function control(param) {
  const box = document.createElement("div");
  box.className = "param";
  const id = `param-${param.name}`;
  const name = document.createElement("div");
  name.className = "name";
  const label = document.createElement("label");
  label.textContent = param.name;
  label.htmlFor = id;
  name.append(label);
  box.append(name);
  if (param.doc) {
    const doc = document.createElement("div");
    doc.className = "doc";
    doc.id = `${id}-doc`;
    doc.textContent = param.doc;
    box.append(doc);
  }
  let main;
  if (param.choices.length) {
    main = document.createElement("select");
    for (const choice of param.choices) main.append(new Option(String(choice)));
    main.value = String(param.value);
    main.onchange = () => set(param.name, param.choices[main.selectedIndex]);
  } else {
    main = document.createElement("input");
    main.type = "range";
    const number = document.createElement("input");
    number.type = "number";
    number.setAttribute("aria-label", `${param.name}${param.unit ? ` in ${param.unit}` : ""}`);
    for (const input of [main, number]) {
      input.min = param.low;
      input.max = param.high;
      input.step = param.step ?? (input === main ? (param.high - param.low) / 500 : "any");
    }
    main.value = param.value;
    number.value = shown(param.value);
    main.oninput = () => { number.value = shown(main.value); set(param.name, Number(main.value)); };
    number.onchange = () => {
      const value = Math.min(Math.max(Number(number.value), param.low), param.high);
      number.value = shown(value);
      main.value = value;
      set(param.name, value);
    };
    const beside = document.createElement("div");
    beside.className = "box";
    beside.append(number, param.unit);
    name.append(beside);
  }
  main.id = id;
  if (param.doc) main.setAttribute("aria-describedby", `${id}-doc`);
  main.ondblclick = () => { set(param.name, param.default); };
  box.append(main);
  return box;
}

function told(program) {
  element("file").textContent = program.file;
  document.title = program.file;
  say(program.wrong.join("\n\n"));
  element("doubts").textContent = program.doubts.join("\n\n");
  element("doubts").hidden = !program.doubts.length;
  if (program.params.length || !program.wrong.length) {
    const focused = document.activeElement?.id;
    element("params").replaceChildren(...program.params.map(control));
    if (focused) element(focused)?.focus();
  }
  const outputs = element("outputs");
  outputs.replaceChildren();
  if (program.outputs.length > 1) {
    const select = document.createElement("select");
    select.setAttribute("aria-label", "Output");
    for (const name of program.outputs) select.append(new Option(name));
    select.value = document.body.dataset.output ?? program.outputs[0];
    select.onchange = () => { fitted = false; send({ output: select.value }); };
    outputs.append(select);
  }
}

// ---- the line -------------------------------------------------------------------------------------------------------

function connect() {
  socket = new WebSocket(`ws://${location.host}${location.pathname}live`);
  socket.binaryType = "arraybuffer";
  socket.onmessage = ({ data }) => {
    if (typeof data !== "string") return take(data);
    const word = JSON.parse(data);
    if (word.say === "program") told(word);
    if (word.say === "drawing") doing("working");
    if (word.say === "refused") { doing(""); say(word.text); }
  };
  socket.onclose = () => {
    doing("pore view has ended");
    setTimeout(connect, 1000);
  };
}
connect();
