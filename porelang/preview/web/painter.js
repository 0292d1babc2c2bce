// Draws scenes with WebGL 2: coarse while something moves, and then at full resolution, in strips that keep the page awake.
const CORNERS = `#version 300 es
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }`;
const ROW = 2048;       // words in a row of a texture of data
const FRAME = 40;       // ms that a frame may take while something moves
const STRIP = 30;       // ms that one strip of the full picture may take
const COARSEST = 8;     // pixels of the page for one that is drawn, at most
const MOST_LOSSES = 3;
const FINE = 400;       // ms that a full picture may take for another of four times as many pixels to follow
const STILL = 150;      // ms without a change until the full picture is begun
const CLEAR = 0.45;     // of a plane shows where the part is not

export class Painter {
  // `told(text)` is told how long a picture took.
  constructor(canvas, camera, told) {
    this.canvas = canvas;
    this.camera = camera;
    this.told = told;
    this.scene = null;
    this.section = { axis: -1, offset: 0, keeps: 1 };  // keeps: 1 what is beyond the offset, -1 what is below
    this.coarse = 4;
    this.perPixel = 0;    // ms
    this.drawn = 0;       // full pictures so far
    this.whole = false;   // whether the canvas has the full picture of how things are now
    this.awaited = [];    // called when it has
    this.seen = null;     // the scene of the last picture
    this.first = null;    // called when there is the first picture of a scene
    this.refines = true;  // whether one with four samples in each pixel follows where that is quick
    this.start();
    this.losses = 0;      // how often the driver gave up: it does where a picture keeps it too long
    canvas.addEventListener("webglcontextlost", (e) => {
      e.preventDefault();
      this.losses += 1;
      this.scene = null;
    });
    canvas.addEventListener("webglcontextrestored", () => {
      this.start();
      if (this.losses > MOST_LOSSES) return this.ready?.("This browser's graphics give up on the part: it takes them too long. `pore render` draws it.");
      if (this.wanted) this.take(this.wanted, this.ready);
    });
  }

  start() {
    const gl = this.canvas.getContext("webgl2", { antialias: false, preserveDrawingBuffer: true, alpha: true, premultipliedAlpha: true, depth: true });
    if (!gl) throw new Error("This browser has no WebGL 2 here, with which the part is drawn. `pore render` draws without it.");
    this.gl = gl;
    this.parallel = gl.getExtension("KHR_parallel_shader_compile");
    this.programs = new Map();  // by text
    this.textures = [];
  }

  end() {
    clearTimeout(this.still);
    this.scene = this.wanted = null;
    this.wish = null;  // of a picture that is being drawn
    this.gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  // Take over a scene; `ready` is called when it can be drawn, or with what is wrong.
  take(scene, ready) {
    const gl = this.gl;
    if (gl.isContextLost()) {
      this.wanted = scene;
      this.ready = ready;
      return;
    }
    const layers = [...scene.bodies, ...(scene.plane ? [scene.plane] : [])];
    const waiting = layers.map((layer) => this.compiled(layer.text));
    this.wanted = scene;
    this.ready = ready;
    const look = () => {
      if (this.wanted !== scene || gl.isContextLost()) return;  // a later one is on its way, or this one will be again
      if (this.parallel && waiting.some((p) => !gl.getProgramParameter(p.program, this.parallel.COMPLETION_STATUS_KHR))) return setTimeout(look, 20);
      for (const one of waiting) {
        if (gl.getProgramParameter(one.program, gl.LINK_STATUS)) continue;
        const log = one.shaders.map((s) => gl.getShaderInfoLog(s)).concat(gl.getProgramInfoLog(one.program)).filter(Boolean).join("\n");
        return ready(`This browser's graphics driver refuses the shader of the part:\n${log}`);
      }
      for (const [text, one] of this.programs) {
        if (waiting.includes(one)) continue;
        gl.deleteProgram(one.program);
        this.programs.delete(text);
      }
      // nobody knows how long a new shader takes: the first picture is small
      if (layers.some((layer) => !this.scene || ![...this.scene.bodies, this.scene.plane].some((known) => known?.text === layer.text)))
        this.coarse = COARSEST * (1 + this.losses);
      this.scene = scene;
      this.load(layers);
      ready("");
      this.moved();
    };
    look();
  }

  compiled(text) {
    if (this.programs.has(text)) return this.programs.get(text);
    performance.mark("compiled");
    const gl = this.gl;
    const program = gl.createProgram();
    const shaders = [[gl.VERTEX_SHADER, CORNERS], [gl.FRAGMENT_SHADER, text]].map(([kind, source]) => {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
      return shader;
    });
    gl.linkProgram(program);
    const one = { program, shaders, places: new Map() };
    this.programs.set(text, one);
    return one;
  }

  // The textures of layers: those of each begin at its unit 0.
  load(layers) {
    const gl = this.gl;
    for (const texture of this.textures) gl.deleteTexture(texture);
    this.textures = [];
    const made = (target) => {
      const texture = gl.createTexture();
      gl.activeTexture(gl.TEXTURE0);
      gl.bindTexture(target, texture);
      for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(target, wrap, gl.CLAMP_TO_EDGE);
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(target, filter, gl.NEAREST);
      this.textures.push(texture);
      return texture;
    };
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    for (const layer of layers) {
      layer.units = [];
      if (layer.cells) {
        layer.units.push([gl.TEXTURE_3D, made(gl.TEXTURE_3D), "cells"]);
        gl.texImage3D(gl.TEXTURE_3D, 0, gl.R32F, ...layer.counts, 0, gl.RED, gl.FLOAT, layer.cells);
      }
      layer.data.forEach((words, k) => {
        layer.units.push([gl.TEXTURE_2D, made(gl.TEXTURE_2D), `data${k}`]);
        const rows = Math.ceil(words.length / ROW);
        const whole = new Uint32Array(rows * ROW);
        whole.set(words);
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.R32UI, ROW, rows, 0, gl.RED_INTEGER, gl.UNSIGNED_INT, whole);
      });
    }
  }

  // Something has changed: draw a coarse picture at once, and the full one when nothing moves any more.
  moved() {
    this.wish = (this.wish ?? 0) + 1;
    this.whole = false;
    clearTimeout(this.still);
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      if (!this.scene) return;
      this.quick();
      const wish = this.wish;
      this.still = setTimeout(() => this.refine(wish), STILL);
    });
  }

  // Resolved when the canvas has the full picture: while something moves, it has a coarse one.
  full() {
    return new Promise((call) => this.whole ? call() : this.awaited.push(call));
  }

  size(coarse) {
    const ratio = Math.min(window.devicePixelRatio || 1, 2) / coarse;
    return [Math.max(1, Math.round(this.canvas.clientWidth * ratio)), Math.max(1, Math.round(this.canvas.clientHeight * ratio))];
  }

  quick() {
    const size = this.size(this.coarse);
    [this.canvas.width, this.canvas.height] = size;
    const begun = performance.now();
    this.strip(size, 0, size[1], 1);
    this.wait(0);  // until it is there
    const ms = performance.now() - begun;
    this.perPixel = ms / (size[0] * size[1]);
    this.told(`${size[0]} x ${size[1]}, ${ms.toFixed(1)} ms`);
    if (this.seen !== this.scene) {
      this.seen = this.scene;
      this.first?.();
    }
    if (ms > FRAME && this.coarse < COARSEST) this.coarse = Math.min(COARSEST, this.coarse * Math.sqrt(ms / FRAME));
    else if (ms < FRAME / 3) this.coarse = Math.max(1, this.coarse / 1.3);
  }

  wait(row) {
    this.gl.readPixels(0, row, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
  }

  // The picture at full resolution, or with `samples` along a side of each pixel. Strips go into a buffer of their own,
  // so that the picture before stays until this one is there.
  refine(wish, samples = 1) {
    const gl = this.gl, shown = this.size(1), size = shown.map((n) => n * samples);
    const rows = Math.max(1, Math.floor(STRIP / Math.max(this.perPixel, 1e-9) / size[0]));
    const begun = performance.now();
    const buffer = gl.createFramebuffer(), colour = gl.createRenderbuffer(), depth = gl.createRenderbuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, buffer);
    for (const [store, form, at] of [[colour, gl.RGBA8, gl.COLOR_ATTACHMENT0], [depth, gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]]) {
      gl.bindRenderbuffer(gl.RENDERBUFFER, store);
      gl.renderbufferStorage(gl.RENDERBUFFER, form, ...size);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, at, gl.RENDERBUFFER, store);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    const end = () => { gl.deleteFramebuffer(buffer); gl.deleteRenderbuffer(colour); gl.deleteRenderbuffer(depth); };
    let from = size[1];
    const step = () => {
      if (this.wish !== wish || !this.scene) return end();
      const to = from;
      from = Math.max(0, from - rows);
      gl.bindFramebuffer(gl.FRAMEBUFFER, buffer);
      this.strip(size, from, to, samples);
      this.wait(from);
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
      if (from > 0) return setTimeout(step, 0);
      [this.canvas.width, this.canvas.height] = shown;
      gl.bindFramebuffer(gl.READ_FRAMEBUFFER, buffer);
      gl.blitFramebuffer(0, 0, ...size, 0, 0, ...shown, gl.COLOR_BUFFER_BIT, samples > 1 ? gl.LINEAR : gl.NEAREST);
      gl.bindFramebuffer(gl.READ_FRAMEBUFFER, null);
      end();
      const ms = performance.now() - begun;
      this.told(`${shown[0]} x ${shown[1]}${samples > 1 ? `, ${samples * samples} samples` : ""}, ${ms.toFixed(0)} ms`);
      if (samples > 1) return;
      this.drawn += 1;
      this.canvas.dataset.drawn = this.drawn;
      this.whole = true;
      for (const call of this.awaited.splice(0)) call();
      if (ms < FINE && this.refines) this.refine(wish, 2);
    };
    step();
  }

  // The rows from..to of a picture of this size, counted from the bottom. Lengths are those of porelang/render/march.py.
  strip(size, from, to, samples) {
    const gl = this.gl, scene = this.scene;
    const view = this.camera.uniforms(Math.hypot(...scene.hi.map((v, i) => v - scene.lo[i])));
    const most = Math.max(...[...view.eye, ...scene.lo, ...scene.hi].map(Math.abs));
    const farthest = Math.hypot(...scene.lo.map((v, i) => Math.max(Math.abs(v - view.eye[i]), Math.abs(scene.hi[i] - view.eye[i]))));
    gl.viewport(0, 0, ...size);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, from, size[0], to - from);
    gl.clearColor(0, 0, 0, 0);
    gl.clearDepth(1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.disable(gl.BLEND);
    const rounding = 2 ** -23 * most;
    for (const body of scene.bodies) this.body(body, view, size, samples, farthest, rounding);
    if (scene.plane && this.section.axis >= 0) {
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      this.plane(scene, view, size, farthest, rounding);
    }
    gl.disable(gl.SCISSOR_TEST);
  }

  body(body, view, size, samples, farthest, rounding) {
    const lo = [...body.lo], hi = [...body.hi], cutLo = [0, 0, 0], cutHi = [0, 0, 0];
    const { axis, offset, keeps } = this.section;
    if (axis >= 0) {
      if (keeps > 0 ? offset >= hi[axis] : offset <= lo[axis]) return;
      if (keeps > 0 && offset > lo[axis]) { lo[axis] = offset; cutLo[axis] = 1; }
      if (keeps < 0 && offset < hi[axis]) { hi[axis] = offset; cutHi[axis] = 1; }
    }
    const diagonal = Math.hypot(...body.hi.map((v, i) => v - body.lo[i]));
    const middle = body.lo.map((v, i) => (v + body.hi[i]) / 2);
    const forward = view.camera.slice(6);
    const depth = view.perspective ? Math.max(1e-9, middle.reduce((sum, v, i) => sum + (v - view.eye[i]) * forward[i], 0)) : 1;
    const pixel = 2 * view.zoom * depth / size[1];
    const far = Math.hypot(...view.eye.map((v, i) => v - middle[i])) + diagonal;
    const nearest = Math.max(0.2 * pixel, 1e-6 * far, 4 * rounding);
    this.draw(body, view, size, {
      want: [1, "i", 0], samples: [1, "i", samples], side: [1, "f", 1], layer: [1, "f", 0], rounding: [1, "f", rounding],
      nearest: [1, "f", nearest], finest: [1, "f", Math.max(0.01 * pixel, 1e-7 * far, rounding)],
      jump: [1, "f", Math.max(0.5 * pixel, nearest)], reach: [1, "f", 0.1 * diagonal],
      grain: [1, "f", Math.max(0.5 * pixel, 1e-5 * far, 32 * rounding)], corner: [2, "f", [0, 0]], farthest: [1, "f", farthest],
      box_lo: [3, "f", lo], box_hi: [3, "f", hi], cells_lo: [3, "f", body.lo], cells_hi: [3, "f", body.hi],
      cut_lo: [3, "f", cutLo], cut_hi: [3, "f", cutHi], counts: [3, "i", body.counts], material: [3, "f", body.colour],
      section: [3, "f", body.section],
    });
  }

  plane(scene, view, size, farthest, rounding) {
    const { axis, offset } = this.section;
    this.draw(scene.plane, view, size, {
      box_lo: [3, "f", scene.lo], box_hi: [3, "f", scene.hi], axis: [1, "i", axis], offset: [1, "f", offset], farthest: [1, "f", farthest],
      nearer: [1, "f", Math.max(2e-6 * farthest, 8 * rounding)], every: [1, "f", scene.scale.every], clear: [1, "f", CLEAR],
    });
  }

  draw(layer, view, size, values) {
    const gl = this.gl, { program, places } = this.programs.get(layer.text);
    const place = (name) => {
      if (!places.has(name)) places.set(name, gl.getUniformLocation(program, name));
      return places.get(name);
    };
    gl.useProgram(program);
    layer.units.forEach(([target, texture, name], k) => {
      gl.activeTexture(gl.TEXTURE0 + k);
      gl.bindTexture(target, texture);
      gl.uniform1i(place(name), k);
    });
    if (layer.numbers.length) gl.uniform1fv(place("u"), layer.numbers);
    const scale = this.scene.scale;
    if (scale) {
      gl.uniform3fv(place("scale_colours"), scale.colours.flat());
      gl.uniform3fv(place("scale_ends"), scale.ends);
    }
    const common = { zoom: [1, "f", view.zoom], perspective: [1, "f", view.perspective], size: [2, "f", size], eye: [3, "f", view.eye] };
    for (const [name, [count, kind, value]] of Object.entries({ ...common, ...values })) {
      if (count === 1) gl[`uniform1${kind}`](place(name), value);
      else gl[`uniform${count}${kind}v`](place(name), value);
    }
    gl.uniformMatrix3fv(place("camera"), false, view.camera);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }
}
