// The section of a viewer: across which axis, where, and which side is kept.
import { length, shown } from "./controls.js";

export const AXES = ["x", "y", "z"];

// The nearest number that can be read of the places between two: they differ by some thousandth of the distance.
function readable(value, lo, hi) {
  const grain = 10 ** Math.floor(Math.log10((hi - lo) / 500));
  return Number((Math.round(value / grain) * grain).toPrecision(6));
}

// Methods of a viewer.
export const section = {
  cross(axis) {
    const { section, state, state: { scene } } = this;
    if (!this.painter || !scene) return;
    if (axis >= 0 && axis !== section.axis) {
      section.offset = readable((scene.lo[axis] + scene.hi[axis]) / 2, scene.lo[axis], scene.hi[axis]);
      section.keeps = this.camera.axes().out[axis] > 0 ? -1 : 1;  // what is before the section is taken away
    }
    section.axis = axis;
    state.beyond = false;
    this.wrong("section", "");
    this.ask.cut(section);
    this.across();
    this.show();
    this.moved();
  },

  across() {
    const { element, section: { axis, offset }, state: { scene, plane, beyond } } = this;
    AXES.concat("none").forEach((name) => element(`across-${name}`).setAttribute("aria-pressed", String(name === (AXES[axis] ?? "none"))));
    element("section-more").hidden = axis < 0;
    element("plane").setAttribute("aria-pressed", String(plane));
    if (axis < 0 || !scene) return;
    const lo = scene.lo[axis], hi = scene.hi[axis];
    Object.assign(element("offset"), { min: lo, max: hi });
    element("offset").value = offset;
    if (!element("offset-number").writing()) element("offset-number").say(shown(offset));
    element("offset-beyond").hidden = !beyond && offset >= lo && offset <= hi;
    element("offset-beyond").textContent = `The part is between ${Number(lo.toPrecision(4))} and ${Number(hi.toPrecision(4))} mm.`;
  },

  // A place that was written, in mm or with a unit.
  placed(text) {
    const place = length(text, this.state.program?.lengths ?? {});
    if (Number.isFinite(place)) return this.cutAt(place, true);
    this.element("offset-number").say(shown(this.section.offset));
    this.wrong("section", `\`${text}\` is no place of the section: write a number of mm, or one with a unit, as in 0.5cm`);
  },

  // A hand sets the section to what can be read; a number that is `written` stays as it is.
  cutAt(offset, written = false) {
    const { section, state, state: { scene } } = this, { axis } = section;
    if (axis < 0 || !scene) return;
    const lo = scene.lo[axis], hi = scene.hi[axis];
    const wanted = written ? offset : readable(offset, lo, hi);
    section.offset = Math.min(Math.max(wanted, lo), hi);
    state.beyond = written && wanted !== section.offset;
    this.wrong("section", "");
    this.element("offset-number").say(shown(section.offset));
    this.ask.cut(section);
    this.across();
    this.moved();
  },

  slide(dx, dy) {
    const { camera, section } = this, { axis } = section;
    if (axis < 0) return;
    const { right, up } = camera.axes();
    const length = Math.max(0.05, right[axis] ** 2 + up[axis] ** 2);
    const from = this.slid?.to === section.offset ? this.slid.exact : section.offset;  // small steps add up
    const exact = from + (dx * right[axis] - dy * up[axis]) / length * camera.height / this.canvas.clientHeight;
    this.cutAt(exact);
    this.slid = { to: section.offset, exact };
  },

  step(way) {
    const { section: { axis, offset }, state: { scene } } = this;
    if (axis >= 0) this.cutAt(offset + way * (scene.hi[axis] - scene.lo[axis]) / 100);
  },

  // A section that was set elsewhere; `axis` -1 is none.
  cutSo({ axis, offset, keeps }) {
    Object.assign(this.section, axis < 0 ? { axis } : { axis, offset, keeps });
    this.across();
    this.moved();
  },
};
