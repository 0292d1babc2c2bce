// The page of `pore view`: the viewer, and beside it measures, files and the text of the program.
import { made } from "./controls.js";
import { Line } from "./line.js";
import { SourcePane } from "./source.js";
import { Viewer } from "./viewer.js";
import { Texts } from "./wire.js";

const element = (id) => document.getElementById(id);
const options = new URLSearchParams(location.search);
const texts = new Texts();
const viewer = new Viewer(document, {
  set: (settings) => line.send({ do: "set", settings }),
  show: (wish) => line.send({ do: "show", ...wish }),
  preset: (name) => line.send({ do: "preset", name }),
  cancel: (of) => line.send({ do: "cancel", of }),
  cut: () => {},  // the page alone knows where it is
}, {
  stats: options.has("stats"),
  refines: options.get("refine") !== "0",
  keys: { e: () => source.open(element("source").hidden) },
});
const { canvas, state } = viewer;

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
  viewer.wrong("export", "");
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
  scene: (scene) => texts.into(scene),
  program: ({ file }) => { document.title = file; },
  doubts: ({ doubts }) => { element("doubts").textContent = doubts.join("\n\n"); element("doubts").hidden = !doubts.length; },
  cancelled: ({ of }) => { if (of === "measure") element("measures-head").textContent = "Measures: not of this part yet"; },
  measuring: ({ output }) => {
    viewer.wrong("measure", "");
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
    viewer.heard(word);
    source.heard(word);
  },
  () => {
    viewer.doing("line", "");
    texts.forget();
    if (!opened++) return;
    source.again();
    if (Object.keys(state.settings).length) line.send({ do: "set", settings: state.settings });
    viewer.show();
  },
  () => viewer.doing("line", "`pore view` has ended"),
);
