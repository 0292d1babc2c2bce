// A part with its controls: the picture, its section and colours, its params and outputs. Of `pore view` and of the widget of
// notebooks, which differ in who is asked for what is set. Elements are those of page.html, by id, in a document or a shadow root.
import { Camera, VIEWS } from "./camera.js";
import { control, legend, made, outputs, shown } from "./controls.js";
import { hands } from "./hands.js";
import { Painter } from "./painter.js";

const AXES = ["x", "y", "z"];

export class Viewer {
  // `ask` is told what is set here: `set(settings)`, `show({ outputs, paint, plane })`, `preset(name)`, `cancel(of)`, `cut(section)`.
  constructor(root, ask, { stats = false, refines = true, keys = {} } = {}) {
    this.root = root;
    this.ask = ask;
    this.element = (id) => root.getElementById(id);
    this.canvas = this.element("view");
    this.camera = new Camera();
    this.told = { text: "", scene: "", export: "", measure: "" };  // what is wrong, by what it is about
    this.doings = new Map();  // by purpose
    this.state = { program: null, settings: {}, outputs: [], paint: "", plane: false, scene: null, fitted: "" };
    this.waiting = new Map();  // what was set since the last frame: a slider says more than can be drawn
    try {
      this.painter = new Painter(this.canvas, this.camera, (text) => {
        this.element("stats").hidden = !stats;
        this.element("stats").textContent = text;
      });
      this.painter.refines = refines;
    } catch (error) {
      this.painter = null;
      this.wrong("scene", error.message);
    }
    this.section = this.painter?.section ?? { axis: -1, offset: 0, keeps: 1 };
    this.resized = new ResizeObserver(() => this.moved());
    this.resized.observe(this.canvas);
    hands(this, keys);
    this.buttons();
  }

  buttons() {
    const { element } = this;
    element("said-shut").onclick = () => { element("said").hidden = true; };
    Object.keys(VIEWS).forEach((name, i) => {
      const button = made("button", { textContent: name, title: String(i + 1) });
      button.onclick = () => this.stand(name);
      element("views").append(button);
    });
    element("fit").onclick = () => this.fit();
    element("projection").onclick = () => this.project();
    for (const [axis, name] of [[-1, "none"], ...AXES.entries()]) {
      const button = made("button", { textContent: name, id: `across-${name}` });
      button.onclick = () => this.cross(axis);
      element("axes").append(button);
    }
    element("offset").oninput = () => this.cutAt(Number(element("offset").value));
    element("offset-number").oninput = () => this.cutAt(parseFloat(element("offset-number").value));
    element("flip").onclick = () => { this.section.keeps *= -1; this.ask.cut(this.section); this.moved(); };
    element("plane").onclick = () => { this.state.plane = !this.state.plane; this.across(); this.show(); };
    element("paint").onchange = () => { this.state.paint = element("paint").value.trim(); this.show(); };
    element("presets").onchange = () => { if (element("presets").value) this.ask.preset(element("presets").value); };
    element("defaults").onclick = () => this.ask.preset("");
  }

  // ---- what is said -------------------------------------------------------------------------------------------------

  wrong(of, text) {
    this.told[of] = text;
    const all = Object.values(this.told).filter(Boolean).join("\n\n");
    this.element("said-text").textContent = all;
    this.element("said").hidden = !all;
  }

  doing(of, what, share) {
    const { element, doings } = this;
    if (what) doings.set(of, { what, share });
    else doings.delete(of);
    const [purpose, first] = [...doings].find(([name]) => name !== "measure") ?? [];
    element("doing").hidden = !first;
    if (!first) return;
    element("doing-what").textContent = first.what;
    element("doing-share").hidden = first.share === undefined;
    element("doing-share").value = first.share ?? 0;
    element("stop").hidden = purpose !== "scene" && purpose !== "export";
    element("stop").onclick = () => this.ask.cancel(purpose);
  }

  // Whether a word is one of these, which is then done.
  heard(word) {
    const { say, of } = word;
    if (say === "scene") this.take(word);
    else if (say === "program") this.programmed(word);
    else if (say === "doing") this.doing(of, word.what, word.share);
    else if (say === "done") this.doing(of, "");
    else if (say === "refused") this.wrong(of, word.text);
  }

  // ---- the picture --------------------------------------------------------------------------------------------------

  moved() {
    this.painter?.moved();
  }

  // A scene with the texts of its shaders.
  take(scene) {
    const { state } = this;
    this.doing("scene", "compiling the shader");
    this.painter?.take(scene, (refused) => {
      this.doing("scene", "");
      this.wrong("scene", refused);
      if (refused) return;
      state.scene = scene;
      const names = scene.bodies.map((body) => body.name).join(" ");
      this.canvas.dataset.outputs = names;
      if (state.fitted !== names) this.fit();
      state.fitted = names;
      legend(this.element("legend"), scene.scale);
      this.across();
      this.listed();
      this.moved();
    });
  }

  fit() {
    const { scene } = this.state, { canvas } = this;
    if (!scene) return;
    this.camera.fit(scene.lo, scene.hi, canvas.clientWidth / canvas.clientHeight);
    this.moved();
  }

  stand(name) {
    [this.camera.azimuth, this.camera.elevation] = VIEWS[name];
    this.fit();
  }

  project() {
    this.camera.perspective = !this.camera.perspective;
    this.element("projection").setAttribute("aria-pressed", String(!this.camera.perspective));
    this.moved();
  }

  // ---- the section --------------------------------------------------------------------------------------------------

  cross(axis) {
    const { section, state: { scene } } = this;
    if (!this.painter || !scene) return;
    if (axis >= 0 && axis !== section.axis) {
      section.offset = (scene.lo[axis] + scene.hi[axis]) / 2;
      section.keeps = this.camera.axes().out[axis] > 0 ? -1 : 1;  // what is before the section is taken away
    }
    section.axis = axis;
    this.ask.cut(section);
    this.across();
    this.show();
    this.moved();
  }

  across() {
    const { element, section: { axis, offset }, state: { scene, plane } } = this;
    AXES.concat("none").forEach((name) => element(`across-${name}`).setAttribute("aria-pressed", String(name === (AXES[axis] ?? "none"))));
    element("section-more").hidden = axis < 0;
    element("plane").setAttribute("aria-pressed", String(plane));
    if (axis < 0 || !scene) return;
    Object.assign(element("offset"), { min: scene.lo[axis], max: scene.hi[axis] });
    element("offset").value = offset;
    if (this.root.activeElement !== element("offset-number")) element("offset-number").value = shown(offset);
  }

  cutAt(offset) {
    const { section, state: { scene } } = this, { axis } = section;
    if (axis < 0 || !Number.isFinite(offset)) return;
    section.offset = Math.min(Math.max(offset, scene.lo[axis]), scene.hi[axis]);
    this.ask.cut(section);
    this.across();
    this.moved();
  }

  slide(dx, dy) {
    const { camera, section: { axis, offset } } = this;
    if (axis < 0) return;
    const { right, up } = camera.axes();
    const length = Math.max(0.05, right[axis] ** 2 + up[axis] ** 2);
    this.cutAt(offset + (dx * right[axis] - dy * up[axis]) / length * camera.height / this.canvas.clientHeight);
  }

  step(way) {
    const { section: { axis, offset }, state: { scene } } = this;
    if (axis >= 0) this.cutAt(offset + way * (scene.hi[axis] - scene.lo[axis]) / 100);
  }

  // A section that was set elsewhere; `axis` -1 is none.
  cutSo({ axis, offset, keeps }) {
    Object.assign(this.section, axis < 0 ? { axis } : { axis, offset, keeps });
    this.across();
    this.moved();
  }

  // ---- settings -----------------------------------------------------------------------------------------------------

  set(name, value) {
    this.state.settings[name] = value;
    if (!this.waiting.size) requestAnimationFrame(() => {
      this.ask.set(Object.fromEntries(this.waiting));
      this.waiting.clear();
    });
    this.waiting.set(name, value);
  }

  // Settings that were made elsewhere.
  put(settings) {
    Object.assign(this.state.settings, settings);
    const boxes = this.element("params").children;
    this.state.program?.params.forEach(({ name }, i) => { if (name in settings) boxes[i].put(settings[name]); });
  }

  show() {
    const { outputs, paint, plane } = this.state;
    this.ask.show({ outputs, paint, plane: plane && this.section.axis >= 0 });
  }

  listed() {
    const { element, state } = this;
    const bodies = state.program?.bodies ?? [];
    element("outputs").hidden = bodies.length < 2;
    if (bodies.length < 2) return;
    const drawn = state.scene?.bodies ?? [];
    const names = drawn.map((body) => body.name);
    const colours = new Map(drawn.map((body) => [body.name, body.colour]));
    element("outputs").replaceChildren(made("h2", { textContent: "Outputs" }), ...outputs(bodies, names, colours, (next) => { state.outputs = next; this.show(); }));
  }

  programmed(program) {
    const { element, state } = this;
    const focused = this.root.activeElement?.id;
    state.program = program;
    element("file").textContent = program.file;
    this.wrong("text", program.wrong.join("\n\n"));
    state.settings = Object.fromEntries(program.params.filter((p) => p.value !== p.default).map((p) => [p.name, p.value]));
    element("params-all").hidden = !program.params.length;
    element("params").replaceChildren(...program.params.map((param) => control(param, (name, value) => this.set(name, value))));
    element("presets").hidden = !program.presets.length;
    element("presets").replaceChildren(new Option("preset ...", ""), ...program.presets.map((name) => new Option(name)));
    element("fields").replaceChildren(...program.fields.map((name) => made("option", { value: name })));
    this.listed();
    if (focused) element(focused)?.focus({ preventScroll: true });
  }

  // It is not looked at any more; a browser has few contexts for drawing.
  close() {
    this.resized.disconnect();
    this.painter?.end();
  }
}
