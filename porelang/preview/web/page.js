// The page of `pore view`: the viewer, and beside it measures, files and the text of the program.
import { look, written } from "./address.js";
import { made, told } from "./controls.js";
import { Line } from "./line.js";
import { SourcePane } from "./source.js";
import { Viewer } from "./viewer.js";
import { Texts } from "./wire.js";

const element = (id) => document.getElementById(id);
const options = new URLSearchParams(location.search);
const texts = new Texts();
const viewer = new Viewer(document, {
  set: (settings) => {
    if (!line.send({ do: "set", settings })) unanswered++;
    other();
    noted();
  },
  show: (wish) => { line.send({ do: "show", ...wish }); if (String(wish.outputs) !== exported) other(); noted(); },
  preset: (name) => { line.send({ do: "preset", name }); other(); },
  moved: noted,
  cancel: (of) => line.send({ do: "cancel", of }),
  cut: () => {},  // the page alone knows where it is
}, {
  stats: options.has("stats"),
  refines: options.get("refine") !== "0",
  keys: { e: () => source.open(element("source").hidden) },
});
const { canvas, state } = viewer;

// ---- the address ----------------------------------------------------------------------------------------------------

let remembering = null;

function noted() {
  remembering ??= setTimeout(remember, 300);
}

// As it is in this page, once that is known: until then it is to be followed.
const address = () => (state.program?.bodies.length ? written(viewer) : location.hash.slice(1));

function remember() {
  remembering = null;
  const now = address();
  if (now !== location.hash.slice(1)) history.replaceState(null, "", now ? `#${now}` : location.pathname + location.search);
}

look(viewer, location.hash.slice(1));
addEventListener("hashchange", () => location.reload());  // an address was written there

// ---- measures and files ---------------------------------------------------------------------------------------------

const MEASURED = { porosity: "porosity", volume: "volume", area: "area", size: "size", solid_components: "pieces" };

function measured({ output, rows, envelope }) {
  element("measures-head").textContent = `Measures of ${output}`;
  element("rows").className = "";
  element("rows").replaceChildren(...rows.filter(([name]) => MEASURED[name] || !/^[a-z_]+$/.test(name)).map(([name, value, error]) => {
    const text = error && name !== "size" ? `${value} ${error.replace(/^(\+- \S+) .*/, "$1")}` : value;  // the unit is that of the value
    return made("div", {},
      made("dt", { textContent: MEASURED[name] ?? name }),
      made("dd", { textContent: text, title: error }),
      ...(name === "porosity" ? [made("dd", { className: "of", textContent: `of ${envelope}` })] : []));
  }));
}

// Of the part as it was, until others are there.
function unmeasured() {
  viewer.wrong("measure", "");
  element("measures-head").textContent = "Measures: not of this part yet";
  for (const of of ["rows", "checks", "notes"]) element(of).className = "old";
}

function checked({ checks }) {
  element("checks").className = "";
  const marks = { true: ["✓", "holds"], false: ["✗", "fails"], null: ["?", "not certain"] };
  element("checks").replaceChildren(...checks.map(({ text, holds, why }) =>
    made("li", { className: marks[holds][1], title: marks[holds][1] }, `${marks[holds][0]} ${text}`, made("div", { className: "quiet", textContent: why }))));
}

for (const [ending, what] of [[".stl", "STL"], [".3mf", "3MF"], [".ply", "PLY"], [".obj", "OBJ"], [".glb", "GLB"], [".vtp", "VTP"]])
  element("ending").append(new Option(what, ending));
let exported = "", later = false;  // the outputs when a mesh was asked for, and whether the part was changed since

function mesh(force) {
  const [body] = state.scene?.bodies ?? [];
  viewer.wrong("export", "");
  element("made").replaceChildren();
  [exported, later] = [String(state.outputs), false];
  if (body) line.send({ do: "export", output: body.name, ending: element("ending").value, voxel: element("voxel").value.trim() || "auto", force });
}

// The part is another one now: a mesh of what it was is not offered beside it.
function other() {
  later = true;
  element("made").replaceChildren();
}

element("export").onclick = () => mesh(false);
element("picture").onclick = async () => {
  await viewer.painter?.full();
  canvas.toBlob((blob) => {
    const link = made("a", { href: URL.createObjectURL(blob), download: `${state.program.file.replace(/\.pore$/, "")}.png` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);  // not before it is written
  });
};

function ready({ name, what, link }) {
  // a browser asks before it takes a second file that nobody has clicked for: so this is clicked for
  const anchor = made("a", { href: link, download: name, textContent: `Save ${name}` });
  if (later) what += "\nof the part before its last change";
  element("made").replaceChildren(anchor, ...what.split("\n").map((text) => made("div", { className: "quiet", textContent: text })));
  if (document.activeElement === element("export")) anchor.focus();
}

// ---- the line -------------------------------------------------------------------------------------------------------

const source = new SourcePane((word) => line.send(word), (of, text) => viewer.wrong(of, text));
let unanswered = 0;  // settings that were sent: an answer to earlier ones is not what holds

function gone({ why }) {
  const way = source.known
    ? "What is shown is the program as it was. Save, in its text (E), writes it anew."
    : "Nothing of it is known here: it is shown when it is there again.";
  viewer.wrong("file", why && `${state.program?.file ?? "The program"} ${why}. ${way}`);
}

function refused({ of, lost }) {
  if (of !== "export") return;
  element("made").replaceChildren();
  if (lost) queueMicrotask(() => viewer.wrong("export", viewer.told.export.text, "Make it all the same", () => mesh(true)));
}

function ended(others) {
  const { file = "program", again = "pore view FILE" } = state.program ?? {};
  const how = others
    ? `What listens at port ${location.port} now is not of this page: open the address that it has printed.`
    : !again ? `The ${file} that it showed has been left.`
    : `Start it again, and this page goes on:\n\n    ${again} --port ${location.port}`;
  const unsaved = source.dirty ? "\n\nYour text is not saved. It is still here, under Program: copy it before you close this page." : "";
  viewer.wrong("line", `\`pore view\` has ended: nothing more is drawn or saved.\n${how}${unsaved}`);
}

const heard = {
  scene: (scene) => texts.into(scene),
  program: ({ file }) => { document.title = file; viewer.wrong("measure", ""); other(); noted(); },
  settings: noted,
  stopped: noted,
  doubts: ({ doubts, notes }) => {
    element("doubts").replaceChildren(...told(doubts.join("\n\n")));
    element("doubts").hidden = !doubts.length;
    element("notes").className = "";
    element("notes").replaceChildren(...notes.map((text) => made("li", { textContent: text })));
  },
  gone,
  refused,
  unmeasured,
  measuring: ({ output }) => {
    element("measures").hidden = false;
    element("measures-head").textContent = `Measuring ${output} ...${element("rows").children.length ? " not of this part yet" : ""}`;
  },
  checked,
  measured,
  made: ready,
};
let opened = 0;
const line = new Line(
  (word) => {
    heard[word.say]?.(word);
    if (word.say !== "settings" || --unanswered === 0) viewer.heard(word);
    source.heard(word);
  },
  () => {
    for (const of of ["line", "file"]) viewer.wrong(of, "");
    texts.forget();
    unanswered = 0;
    if (opened++) source.again();
  },
  ended,
  address,
);
