// Mouse, touch and keys on the canvas of a viewer. `more` are keys of its surroundings.
import { VIEWS } from "./camera.js";

export function hands(viewer, more = {}) {
  const { canvas, camera } = viewer;
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
    } else if (last.cuts) viewer.slide(dx, dy);
    else if (last.moves) camera.move(dx, dy, canvas.clientHeight);
    else camera.turn(-0.4 * dx, 0.4 * dy);
    last.x = e.clientX;
    last.y = e.clientY;
    viewer.moved();
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (e) => held.delete(e.pointerId));
  canvas.addEventListener("wheel", (e) => {
    e.preventDefault();
    camera.closer(Math.exp(-e.deltaY * (e.deltaMode === 1 ? 0.04 : 0.0015)));
    viewer.moved();
  }, { passive: false });
  canvas.addEventListener("keydown", (e) => {
    if (e.ctrlKey || e.metaKey) return;
    const turn = e.shiftKey ? 1 : 5;
    const keys = e.altKey ? {
      ArrowLeft: () => viewer.step(-1), ArrowDown: () => viewer.step(-1), ArrowRight: () => viewer.step(1), ArrowUp: () => viewer.step(1),
    } : {
      ArrowLeft: () => camera.turn(-turn, 0), ArrowRight: () => camera.turn(turn, 0),
      ArrowUp: () => camera.turn(0, turn), ArrowDown: () => camera.turn(0, -turn),
      "+": () => camera.closer(1.15), "=": () => camera.closer(1.15), "-": () => camera.closer(1 / 1.15),
      f: () => viewer.fit(), o: () => viewer.project(), ...more,
    };
    if (!e.altKey) Object.keys(VIEWS).forEach((name, i) => { keys[i + 1] = () => viewer.stand(name); });
    const act = keys[e.key] ?? keys[e.key.toLowerCase()];
    if (!act) return;
    e.preventDefault();
    e.stopPropagation();  // a notebook has meanings of its own for them
    act();
    viewer.moved();
  });
}
