// A part with its controls: the picture, its section and colours, its params and outputs. Of `pore view` and of the widget of
// notebooks, which differ in who is asked for what is set. Elements are those of page.html, by id, in a document or a shadow root.
import { Camera, VIEWS } from "./camera.js";
import { control, entry, legend, made, outputs, told } from "./controls.js";
import { hands } from "./hands.js";
import { Painter } from "./painter.js";
import { AXES, section } from "./section.js";

export class Viewer {
  // `ask` is told what is set here: `set(settings)`, `show({ outputs, paint, plane })`, `preset(name)`, `cancel(of)`, `cut(section)`.
  constructor(root, ask, { stats = false, refines = true, keys = {} } = {}) {
    this.root = root;
    this.ask = ask;
    this.element = (id) => root.getElementById(id);
    this.canvas = this.element("view");
    this.camera = new Camera();
    this.told = {};  // what is wrong, by what it is about, and what can be done about it
    this.doings = new Map();  // by purpose
    this.state = { program: null, settings: {}, outputs: [], paint: "", plane: false, scene: null, fitted: "" };
    this.waiting = new Map();  // what was set since the last frame: a slider says more than can be drawn
    try {
      this.painter = new Painter(this.canvas, this.camera, (text) => {
        this.element("stats").hidden = !stats;
        this.element("stats").textContent = text;
      });
      this.painter.refines = refines;
      this.painter.first = () => this.pictured();
    } catch (error) {
      this.painter = null;
      this.wrong("scene", error.message);
    }
    this.section = this.painter?.section ?? { axis: -1, offset: 0, keeps: 1 };
    this.aspect = 1;
    this.resized = new ResizeObserver(() => this.reshaped());
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
    entry(element("offset-number"), (text) => this.placed(text));
    element("said-again").onclick = () => Object.values(this.told).find((one) => one.again).again();
    element("flip").onclick = () => { this.section.keeps *= -1; this.ask.cut(this.section); this.moved(); };
    element("plane").onclick = () => { this.state.plane = !this.state.plane; this.across(); this.show(); };
    element("paint").onchange = () => { this.state.paint = element("paint").value.trim(); this.show(); };
    element("presets").onchange = () => { if (element("presets").value) this.preset(element("presets").value); };
    element("defaults").onclick = () => this.preset("");
  }

  // ---- what is said -------------------------------------------------------------------------------------------------

  // `again`, called by a button with that `label`, does something about it.
  wrong(of, text, label = "", again = null) {
    const { element } = this;
    if (text) this.told[of] = { text, label, again };
    else delete this.told[of];
    const { line, file, ...others } = this.told;  // what keeps all else from being done is said first
    const all = [line, file, ...Object.values(others)].filter(Boolean), one = all.find((some) => some.again);
    element("said-text").replaceChildren(...told([...new Set(all.map((some) => some.text))].join("\n\n")));
    element("said").hidden = !all.length;
    element("said-again").hidden = !one;
    element("said-again").textContent = one?.label ?? "";
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
    else if (say === "settings") this.put(word.settings);
    else if (say === "stopped") this.stopped(word);
  }

  // A picture that was asked for was cancelled: what is shown is what the controls say, and the picture can be asked for again.
  stopped({ text, wish }) {
    const { outputs, paint, plane } = this.state;
    this.wished(wish);
    this.wrong("scene", text, "Try again", () => {
      this.wrong("scene", "");
      this.wished({ outputs, paint, plane });
      this.show();
    });
  }

  // ---- the picture --------------------------------------------------------------------------------------------------

  moved() {
    this.painter?.moved();
    this.ask.moved?.();
  }

  // The canvas has another shape: what was seen across its shorter side still is.
  reshaped() {
    const { camera, canvas } = this, aspect = canvas.clientWidth / canvas.clientHeight;
    if (!aspect || !Number.isFinite(aspect)) return;
    if (camera.fitted) this.fit();
    else camera.height *= Math.min(1, this.aspect) / Math.min(1, aspect);
    this.aspect = aspect;
    this.moved();
  }

  // A scene with the texts of its shaders.
  take(scene) {
    const { state } = this;
    if (!this.painter) return;
    this.doing("shader", "compiling the shader");
    this.painter.take(scene, (refused) => {
      this.wrong("scene", refused);
      this.doing("shader", refused ? "" : "drawing");
      if (refused) return;
      state.scene = scene;
      const names = scene.bodies.map((body) => body.name).join(" ");
      this.canvas.dataset.outputs = names;
      if (state.fitted ? state.fitted !== names : this.camera.fitted) this.fit();
      state.fitted = names;
      this.across();
      this.listed();
      this.moved();
    });
  }

  // The first picture of a scene is there: what is said of it holds from now on.
  pictured() {
    this.doing("shader", "");
    legend(this.element("legend"), this.state.scene);
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
    if (this.camera.fitted) this.fit();
    this.moved();
  }

  // ---- settings -----------------------------------------------------------------------------------------------------

  set(name, value) {
    this.state.settings[name] = value;
    if (!this.waiting.size) requestAnimationFrame(() => this.sent());
    this.waiting.set(name, value);
  }

  // What waits is told now: what follows is to be later than that.
  sent() {
    if (this.waiting.size) this.ask.set(Object.fromEntries(this.waiting));
    this.waiting.clear();
  }

  preset(name) {
    this.sent();
    this.ask.preset(name);
  }

  // Settings that were made elsewhere.
  put(settings) {
    Object.assign(this.state.settings, settings);
    const boxes = this.element("params").children;
    this.state.program?.params.forEach(({ name }, i) => { if (name in settings) boxes[i].put(settings[name]); });
  }

  // What is drawn is this, says somebody else.
  wished(wish) {
    Object.assign(this.state, wish);
    this.element("paint").value = wish.paint;
    this.across();
    this.listed();
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
    const colours = new Map(drawn.map((body) => [body.name, body.colour]));
    const asked = () => {  // what is drawn may be of before
      const wanted = bodies.filter((name) => state.outputs.includes(name));
      return wanted.length ? wanted : (state.scene?.bodies ?? []).map((body) => body.name);
    };
    const show = (next) => { state.outputs = next; this.show(); };
    element("outputs").replaceChildren(made("h2", { textContent: "Outputs" }), ...outputs(bodies, asked, colours, show));
  }

  programmed(program) {
    const { element, state } = this;
    const focused = this.root.activeElement?.id;
    state.program = program;
    if (!state.scene && program.wish) this.wished(program.wish);
    element("file").textContent = program.file;
    this.wrong("text", program.wrong.join("\n\n"));
    state.settings = Object.fromEntries(program.params.map((p) => [p.name, p.value]));
    element("params-all").hidden = !program.params.length;
    element("params").replaceChildren(...program.params.map((param) => control(param, (name, value) => {
      if (state.program === program) this.set(name, value);  // a box that is taken away sets nothing
    })));
    this.put(Object.fromEntries(this.waiting));  // is later than this
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

Object.assign(Viewer.prototype, section);
