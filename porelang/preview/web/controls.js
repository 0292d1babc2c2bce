// The controls of a program: its params with units, ranges, steps and docs, its presets, and which outputs are shown.
export const shown = (value) => String(Number(Number(value).toPrecision(6)));

export function made(kind, options = {}, ...inside) {
  const element = Object.assign(document.createElement(kind), options);
  element.append(...inside);
  return element;
}

// What is said of a program. Lines of its text keep their shape, so that the marks below them point right; words are wrapped.
export const told = (text) => text.split("\n").map((line) =>
  made("div", { className: /^ *\d* \|/.test(line) ? "code" : "words", textContent: line || " " }));

// A step of 1, 2 or 5 times a power of ten, so that some hundreds make a range.
function fine(range) {
  const power = 10 ** Math.floor(Math.log10(range / 250));
  return power * [5, 2, 1].find((n) => n * power <= range / 250);
}

const NUMBER = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;

// A length in mm as it was written, in mm or with one of the units `lengths`; NaN for what is none.
export function length(text, lengths) {
  const [, number, unit] = /^(.*?\d\.?)\s*([a-z]*)$/i.exec(text.trim()) ?? [];
  return NUMBER.test(number ?? "") ? Number(number) * (lengths[unit || "mm"] ?? NaN) : NaN;
}

// A box of text that tells what is entered there, and only where that is another text than it said last: a browser may tell of one
// change twice, at Enter and when the box is left. Its `say(text)` shows another; `writing()` is whether somebody writes there.
export function entry(box, entered) {
  let said = box.value;
  box.say = (text) => { box.value = said = text; };
  box.writing = () => box.getRootNode().activeElement === box && box.value !== said;
  box.onchange = () => {
    if (box.value === said) return;
    said = box.value;
    entered(said.trim());
  };
  box.addEventListener("keydown", (e) => {
    if (e.key !== "Enter") return;
    e.preventDefault();  // not all who lie around it let a browser see that this is a change
    box.onchange();
  });
  return box;
}

// A slider with its number, or a choice; `set(name, value)` is told of each change, in base units, or as the text that was written:
// whoever is told knows units, and what cannot be. Its `put(value)` shows a value that was set elsewhere.
export function control(param, set) {
  const id = `param-${param.name}`;
  const name = made("div", { className: "name" }, made("label", { textContent: param.name, htmlFor: id }));
  const box = made("div", { className: "param" }, name);
  if (param.doc) box.append(made("div", { className: "doc", id: `${id}-doc`, textContent: param.doc }));
  let main, last;
  const say = (value) => { if (value !== last) set(param.name, last = value); };
  if (param.choices.length) {
    main = made("select", {}, ...param.choices.map((choice) => new Option(String(choice))));
    box.put = (value) => { main.value = String(last = value); };
    main.onchange = () => say(param.choices[main.selectedIndex]);
  } else {
    // in the unit of the param a number has twelve figures at most: 15deg are no 15 in float64, and 0 is no 1e-14
    const plainly = (v) => Math.abs(v) < 1e-12 * Math.max(Math.abs(param.low), Math.abs(param.high)) / param.scale ? 0 : Number(v.toPrecision(12));
    const [low, high, step] = [param.low, param.high, param.step].map((v) => v === null ? null : plainly(v / param.scale));
    main = made("input", { type: "range" });
    Object.assign(main, { min: low, max: high, step: step ?? fine(high - low) });
    const number = entry(made("input", { type: "text", id: `${id}-number`, className: "number", autocomplete: "off", spellcheck: false }), (text) => {
      const plain = NUMBER.test(text) ? Number(text) * param.scale : NaN;
      if (plain >= param.low && plain <= param.high) main.value = plain / param.scale;  // else it is told
      say(Number.isFinite(plain) ? plain : text);
    });
    number.setAttribute("aria-label", `${param.name}${param.unit ? ` in ${param.unit}` : ""}`);
    box.put = (given) => {
      last = given;
      if (typeof given !== "number") return;  // a text that was sent: what it is worth follows
      main.value = given / param.scale;
      if (!number.writing()) number.say(shown(given / param.scale));
    };
    const take = (moved) => {
      const given = plainly(moved);
      number.say(shown(given));
      say(Math.min(Math.max(given * param.scale, param.low), param.high));
    };
    main.oninput = () => take(Number(main.value));
    number.onkeydown = (e) => {
      const way = { ArrowUp: 1, ArrowDown: -1 }[e.key];
      if (!way || e.altKey || e.ctrlKey || e.metaKey) return;
      e.preventDefault();
      if (NUMBER.test(number.value.trim())) main.value = Number(number.value);  // from what is written there
      main.value = Number(main.value) + way * Number(main.step);
      take(Number(main.value));
    };
    main.title = "Double click: its default";
    main.ondblclick = () => { main.value = param.default / param.scale; take(param.default / param.scale); };
    name.append(made("div", { className: "box" }, number, param.unit));
  }
  main.id = id;
  if (param.doc) main.setAttribute("aria-describedby", `${id}-doc`);
  box.append(main);
  box.put(param.value);
  return box;
}

// Which outputs are to be shown, of those that `asked()` says now; the first is what is measured, exported and cut by the plane.
export function outputs(names, asked, colours, show) {
  return names.map((name, i) => {
    const box = made("input", { type: "checkbox", id: `output-${i}`, checked: asked().includes(name) });
    box.onchange = () => {
      const before = asked(), next = names.filter((n) => (n === name ? box.checked : before.includes(n)));
      if (next.length) show(next);
      else box.checked = true;  // something is to be seen
    };
    const swatch = made("span", { className: "swatch" });
    if (colours.has(name)) swatch.style.background = `rgb(${colours.get(name).map((c) => Math.round(255 * c)).join(" ")})`;
    return made("label", { htmlFor: box.id }, box, swatch, name);
  });
}

// The scale of colours, with its numbers; or that what was to give them is `nowhere` a number.
export function legend(element, { scale, nowhere }) {
  element.hidden = !scale && !nowhere;
  if (nowhere) {
    element.setAttribute("aria-label", `${nowhere} is nowhere a number`);
    element.replaceChildren(made("div", { className: "what", textContent: `${nowhere}: nowhere a number` }));
  }
  if (!scale) return;
  const [low, middle, high] = scale.ends;
  const strip = made("canvas", { width: 1, height: 256 });
  const pen = strip.getContext("2d");
  const colour = (value) => {
    const place = 8 * (value < middle ? 0.5 * (value - low) / (middle - low) : 0.5 + 0.5 * (value - middle) / (high - middle));
    const below = Math.min(7, Math.max(0, Math.floor(place)));
    return scale.colours[below].map((c, i) => Math.round(255 * (c + (place - below) * (scale.colours[below + 1][i] - c))));
  };
  for (let y = 0; y < 256; y++) {
    pen.fillStyle = `rgb(${colour(high + (low - high) * y / 255).join(" ")})`;
    pen.fillRect(0, y, 1, 1);
  }
  const ticks = [...new Set([low, ...scale.numbers, high])].filter((v) => v === low || v === high || Math.min(v - low, high - v) > 0.07 * (high - low));
  const marks = ticks.map((value) => {
    const tick = made("span", { className: "tick", textContent: shown(value.toPrecision(4)) });
    tick.style.top = `${100 * (high - value) / (high - low)}%`;
    return tick;
  });
  const what = `${scale.shown}${scale.unit && scale.unit !== scale.shown ? ` (${scale.unit.replace(scale.shown, "").trim() || scale.unit})` : ""}`;
  element.setAttribute("aria-label", `Colours of ${what}: from ${shown(low)} to ${shown(high)}`);
  element.replaceChildren(made("div", { className: "what", textContent: what }), made("div", { className: "scale" }, strip, ...marks));
}
