// How the part is looked at, in the address of the page: what differs from the usual, by names. The server reads `p.NAME`, `outputs`,
// `paint` and `plane` (porelang/preview/look.py); the others are of the page alone. What cannot be is passed over.
import { VIEWS } from "./camera.js";
import { AXES } from "./section.js";

const ROUND = 6;  // figures
const round = (value) => Number(Number(value).toPrecision(ROUND));

export function written({ state, section, camera, aspect }) {
  const said = new URLSearchParams();
  for (const { name, default: usual, begun } of state.program?.params ?? []) {
    const value = state.settings[name];
    if (value !== usual || value !== begun) said.set(`p.${name}`, value);  // whatever the command is that is started next
  }
  if (state.outputs.length) said.set("outputs", state.outputs.join(","));
  if (state.paint) said.set("paint", state.paint);
  if (section.axis >= 0) {
    said.set("cut", `${AXES[section.axis]}${section.keeps > 0 ? "<" : ">"}${round(section.offset)}`);
    if (state.plane) said.set("plane", "1");
  }
  const eye = [camera.azimuth, camera.elevation].map(round);
  if (String(eye) !== String(VIEWS.iso.map(round))) said.set("eye", eye);
  if (!camera.fitted) said.set("at", [camera.height * Math.min(1, aspect), ...camera.target].map(round));
  if (!camera.perspective) said.set("parallel", "1");
  return String(said);
}

// Look at the part as an address says; before there is a scene.
export function look(viewer, address) {
  const said = new URLSearchParams(address), { camera } = viewer;
  const numbers = (name, count) => {
    const found = (said.get(name) ?? "").split(",").map(parseFloat);
    return found.length === count && found.every(Number.isFinite) ? found : null;
  };
  const eye = numbers("eye", 2), at = numbers("at", 4);
  if (eye) [camera.azimuth, camera.elevation] = [eye[0] % 360, Math.min(90, Math.max(-90, eye[1]))];
  if (at && at[0] > 0) {
    [camera.height, ...camera.target] = at;  // the height is that of the shorter side until there is a canvas
    camera.fitted = false;
  }
  if (said.get("parallel") === "1") viewer.project();
  const [, axis, side, offset] = /^([xyz])([<>])(-?[\d.]+(?:e-?\d+)?)$/.exec(said.get("cut") ?? "") ?? [];
  if (axis && Number.isFinite(Number(offset))) viewer.cutSo({ axis: AXES.indexOf(axis), offset: Number(offset), keeps: side === "<" ? 1 : -1 });
}
