// The viewer of `pore view` in a notebook, as an anywidget. What is set are traits of the model; scenes and words come as
// messages, and are kept here for views that are opened later: a notebook that is saved has none of them.
import { Viewer } from "../../../porelang/preview/web/viewer.js";
import { Texts, unpacked } from "../../../porelang/preview/web/wire.js";
import page from "../../../porelang/preview/web/page.html";
import look from "../../../porelang/preview/web/page.css";
import own from "./widget.css";

const AXES = "xyz";
const GONE = "The kernel that this belongs to has been restarted: run the cell again. The picture is the last one.";

export default () => {
  const views = new Set(), texts = new Texts();
  const last = {};  // the words that a new view has to hear, by what they say and of what
  let gone = false;
  return {
    initialize({ model }) {
      // the one word that a notebook has for it: it says so of models whose kernel is started again
      const lost = () => { gone = true; for (const view of views) view.lost(gone); };
      const hear = (word, buffers) => {
        if (gone) { gone = false; for (const view of views) view.lost(gone); }  // it was not so
        if (word.say === "scene") {
          const { buffer, byteOffset, byteLength } = buffers[0];
          word = unpacked(buffer.slice(byteOffset, byteOffset + byteLength));
          texts.into(word);
        }
        if (["program", "scene"].includes(word.say)) last[word.say] = word;
        if (["refused", "stopped"].includes(word.say)) last[`refused ${word.of}`] = word;
        if (word.say === "scene") delete last["refused scene"];
        for (const view of views) view.heard(own_of(word));
      };
      model.on("msg:custom", hear);
      model.on("comm_live_update", lost);
      model.send({ do: "begin" });
      return () => { model.off("msg:custom", hear); model.off("comm_live_update", lost); };
    },

    render({ model, el }) {
      const host = document.createElement("div"), root = host.attachShadow({ mode: "open" });
      host.dataset.lmSuppressShortcuts = "true";  // JupyterLab keeps Enter for itself, where nobody says that it is wanted
      el.append(host);
      const forget = [themed(host, root), pictured(root, model)];
      const keep = (changes) => {
        for (const [name, value] of Object.entries(changes)) model.set(name, value);
        model.save_changes();
      };
      const viewer = new Viewer(root, {
        set: (settings) => keep({ settings: { ...model.get("settings"), ...settings } }),
        show: (wish) => { keep(wish); model.send({ do: "again" }); },  // also where nothing of it has changed
        preset: (name) => model.send({ do: "preset", name }),
        cancel: () => model.send({ do: "cancel" }),
        cut: (section) => keep({ cut: cutText(section) }),
      });
      const { state, element } = { state: viewer.state, element: viewer.element };
      const follow = {
        settings: (value) => viewer.put(value),
        outputs: (value) => { state.outputs = value; },
        paint: (value) => {
          state.paint = value;
          // who has written something that cannot be mends it: it stays as long as they are there
          if (root.activeElement !== element("paint")) element("paint").value = value;
        },
        height: (value) => host.style.setProperty("--height", `${value}px`),
        plane: (value) => {
          state.plane = value;
          if (value && state.scene && viewer.section.axis < 0) viewer.cross(1);  // it is shown somewhere
          viewer.across();
        },
        cut: (value) => { if (value !== cutText(viewer.section)) viewer.cutSo(section(value)); },
      };
      for (const [name, act] of Object.entries(follow)) {
        const changed = () => act(model.get(name));
        model.on(`change:${name}`, changed);
        forget.push(() => model.off(`change:${name}`, changed));
      }
      follow.height(model.get("height"));
      const view = {
        lost(so) {
          element("panel").inert = so;  // nobody would hear what is set there
          viewer.wrong("kernel", so ? GONE : "");
        },
        heard(word) {
          if (word.say === "program") element("panel").hidden = false;
          viewer.heard(word);
          if (word.say === "program") for (const [name, act] of Object.entries(follow)) act(model.get(name));
          if (word.say === "scene") { viewer.wrong("scene", ""); if (state.plane) follow.plane(true); }
        },
      };
      views.add(view);
      for (const word of [last.program, last.scene]) if (word) view.heard(own_of(word));
      for (const [name, word] of Object.entries(last)) if (name.startsWith("refused")) view.heard(word);
      if (gone) view.lost(gone);
      return () => {
        views.delete(view);
        viewer.close();
        for (const act of forget) act();
      };
    },
  };
};

// A word for one view: each keeps textures of its own with the layers of a scene.
function own_of(word) {
  if (word.say !== "scene") return word;
  return { ...word, bodies: word.bodies.map((body) => ({ ...body })), plane: word.plane && { ...word.plane } };
}

// A section in the words of `pore render --cut`: what is taken away.
function cutText({ axis, offset, keeps }) {
  return axis < 0 ? "" : `${AXES[axis]}${keeps > 0 ? "<" : ">"}${Number(offset.toPrecision(6))}`;
}

function section(text) {
  const axis = AXES.indexOf(text[0] ?? "-");
  return { axis, offset: Number(text.slice(2)), keeps: text[1] === "<" ? 1 : -1 };
}

// The elements of the page that a notebook wants too, in its light or dark; what they have to be told to stop.
function themed(host, root) {
  const sheets = [look, own].map((text) => { const sheet = new CSSStyleSheet(); sheet.replaceSync(text); return sheet; });
  root.adoptedStyleSheets = sheets;
  const parts = new DOMParser().parseFromString(page, "text/html");
  const main = parts.querySelector("main"), panel = parts.querySelector("aside");
  for (const part of panel.querySelectorAll("#open, #measures, #doubts, [aria-label=Export]")) part.remove();
  Object.assign(panel, { id: "panel", hidden: true });  // until somebody hears what is set there
  const frame = document.createElement("div");
  frame.className = "frame";
  frame.append(main, panel);
  root.append(frame);
  const system = matchMedia("(prefers-color-scheme: dark)");
  const turn = () => {
    const { jpThemeLight, vscodeThemeKind } = document.body.dataset;
    const dark = jpThemeLight ? jpThemeLight === "false" : vscodeThemeKind ? /dark$|contrast$/.test(vscodeThemeKind) : system.matches;
    host.style.colorScheme = dark ? "dark" : "light";
    for (const rule of sheets[0].cssRules) {
      if (rule.media && [...rule.cssRules].some((inner) => inner.style?.getPropertyValue("--ground"))) rule.media.mediaText = dark ? "all" : "not all";
    }
  };
  turn();
  const watch = new MutationObserver(turn);
  watch.observe(document.body, { attributes: true, attributeFilter: ["data-jp-theme-light", "data-vscode-theme-kind"] });
  system.addEventListener("change", turn);
  return () => { watch.disconnect(); system.removeEventListener("change", turn); };
}

// The picture that Python has drawn, under the canvas: all there is where nothing computes.
function pictured(root, model) {
  const image = document.createElement("img");
  image.id = "still";
  image.alt = "The part";
  root.querySelector("main").prepend(image);
  let url = "";
  const show = () => {
    const data = model.get("still");
    URL.revokeObjectURL(url);
    url = data?.byteLength ? URL.createObjectURL(new Blob([data], { type: "image/png" })) : "";
    image.hidden = !url;
    if (url) image.src = url;
  };
  show();
  model.on("change:still", show);
  const drawn = new MutationObserver(() => { image.hidden = true; });  // by the viewer
  drawn.observe(root.getElementById("view"), { attributes: true, attributeFilter: ["data-outputs"] });
  return () => { model.off("change:still", show); drawn.disconnect(); URL.revokeObjectURL(url); };
}
