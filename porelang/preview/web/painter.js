// Draws a scene with WebGL 2: coarse while something moves, and then at full resolution, in strips that keep the page awake.
const CORNERS = `#version 300 es
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }`;
const ROW = 2048;       // words in a row of a texture of data
const FRAME = 40;       // ms that a frame may take while something moves
const STRIP = 30;       // ms that one strip of the full picture may take
const COARSEST = 8;     // pixels of the page for one that is drawn, at most

export class Painter {
  constructor(canvas, camera, told) {
    this.canvas = canvas;
    this.camera = camera;
    this.told = told;
    this.scene = null;
    this.coarse = 4;
    this.perPixel = 0;    // ms
    this.drawn = 0;       // pictures so far
    this.start();
    canvas.addEventListener("webglcontextlost", (e) => e.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => { this.start(); if (this.scene) this.take(this.scene, () => {}); });
  }

  start() {
    const gl = this.canvas.getContext("webgl2", { antialias: false, preserveDrawingBuffer: true, alpha: true, premultipliedAlpha: true });
    if (!gl) throw new Error("This browser has no WebGL 2 here, with which the part is drawn. `pore render` draws without it.");
    this.gl = gl;
    this.parallel = gl.getExtension("KHR_parallel_shader_compile");
    this.program = null;
    this.text = null;
    this.textures = [];
  }

  // Take over a scene; `ready` is called when it can be drawn, or with what is wrong.
  take(scene, ready) {
    const gl = this.gl;
    const text = scene.text ?? this.text;
    scene.text = text;
    const finish = () => {
      this.scene = scene;
      this.load(scene);
      ready("");
      this.moved();
    };
    if (text === this.text && this.program) return finish();
    const program = gl.createProgram();
    const shaders = [[gl.VERTEX_SHADER, CORNERS], [gl.FRAGMENT_SHADER, text]].map(([kind, source]) => {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
      return shader;
    });
    gl.linkProgram(program);
    this.linking = program;
    const look = () => {
      if (this.linking !== program) return gl.deleteProgram(program);  // a later one is on its way
      if (this.parallel && !gl.getProgramParameter(program, this.parallel.COMPLETION_STATUS_KHR)) return setTimeout(look, 20);
      if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
        const log = shaders.map((s) => gl.getShaderInfoLog(s)).concat(gl.getProgramInfoLog(program)).filter(Boolean).join("\n");
        return ready(`This browser's graphics driver refuses the shader of the part:\n${log}`);
      }
      if (this.program) gl.deleteProgram(this.program);
      this.program = program;
      this.text = text;
      this.places = new Map();
      finish();
    };
    look();
  }

  load(scene) {
    const gl = this.gl;
    for (const texture of this.textures) gl.deleteTexture(texture);
    const made = (target, unit) => {
      const texture = gl.createTexture();
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(target, texture);
      for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(target, wrap, gl.CLAMP_TO_EDGE);
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(target, filter, gl.NEAREST);
      return texture;
    };
    const [nx, ny, nz] = scene.counts;
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    this.textures = [made(gl.TEXTURE_3D, 0)];
    gl.texImage3D(gl.TEXTURE_3D, 0, gl.R32F, nx, ny, nz, 0, gl.RED, gl.FLOAT, scene.cells);
    scene.data.forEach((words, k) => {
      this.textures.push(made(gl.TEXTURE_2D, k + 1));
      const rows = Math.ceil(words.length / ROW);
      const whole = new Uint32Array(rows * ROW);
      whole.set(words);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.R32UI, ROW, rows, 0, gl.RED_INTEGER, gl.UNSIGNED_INT, whole);
    });
  }

  place(name) {
    if (!this.places.has(name)) this.places.set(name, this.gl.getUniformLocation(this.program, name));
    return this.places.get(name);
  }

  // Something has changed: draw a coarse picture at once, and the full one when nothing moves any more.
  moved() {
    this.wish = (this.wish ?? 0) + 1;
    clearTimeout(this.still);
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      if (!this.program || !this.scene) return;
      this.quick();
      const wish = this.wish;
      this.still = setTimeout(() => this.full(wish), 150);
    });
  }

  size(coarse) {
    const ratio = Math.min(window.devicePixelRatio || 1, 2) / coarse;
    return [Math.max(1, Math.round(this.canvas.clientWidth * ratio)), Math.max(1, Math.round(this.canvas.clientHeight * ratio))];
  }

  quick() {
    const size = this.size(this.coarse);
    [this.canvas.width, this.canvas.height] = size;
    const begun = performance.now();
    this.strip(size, 0, size[1]);
    this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));  // waits until it is there
    const ms = performance.now() - begun;
    this.perPixel = ms / (size[0] * size[1]);
    this.told(`${size[0]} x ${size[1]}, ${ms.toFixed(1)} ms`);
    if (ms > FRAME && this.coarse < COARSEST) this.coarse = Math.min(COARSEST, this.coarse * Math.sqrt(ms / FRAME));
    else if (ms < FRAME / 3) this.coarse = Math.max(1, this.coarse / 1.3);
  }

  full(wish) {
    const size = this.size(1);
    const rows = Math.max(1, Math.floor(STRIP / Math.max(this.perPixel, 1e-9) / size[0]));
    const picture = document.createElement("canvas");
    [picture.width, picture.height] = size;
    const begun = performance.now();
    let from = size[1];
    // strips are drawn into a buffer of their own, so that the coarse picture stays until the full one is there
    const gl = this.gl, texture = gl.createTexture(), buffer = gl.createFramebuffer();
    gl.activeTexture(gl.TEXTURE0 + 15);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA8, size[0], size[1]);
    gl.bindFramebuffer(gl.FRAMEBUFFER, buffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    const end = () => { gl.deleteFramebuffer(buffer); gl.deleteTexture(texture); };
    const step = () => {
      if (this.wish !== wish) return end();
      const to = from;
      from = Math.max(0, from - rows);
      gl.bindFramebuffer(gl.FRAMEBUFFER, buffer);
      this.strip(size, from, to);
      gl.readPixels(0, from, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
      if (from > 0) return setTimeout(step, 0);
      [this.canvas.width, this.canvas.height] = size;
      gl.bindFramebuffer(gl.READ_FRAMEBUFFER, buffer);
      gl.blitFramebuffer(0, 0, ...size, 0, 0, ...size, gl.COLOR_BUFFER_BIT, gl.NEAREST);
      gl.bindFramebuffer(gl.READ_FRAMEBUFFER, null);
      end();
      this.drawn += 1;
      this.canvas.dataset.drawn = this.drawn;  // the full pictures so far
      this.told(`${size[0]} x ${size[1]}, ${(performance.now() - begun).toFixed(0)} ms`);
    };
    step();
  }

  // The rows from..to of a picture of this size, counted from the bottom. Lengths are those of porelang/render/march.py.
  strip(size, from, to) {
    const gl = this.gl, scene = this.scene, { lo, hi } = scene;
    const edges = hi.map((v, i) => v - lo[i]);
    const diagonal = Math.hypot(...edges);
    const view = this.camera.uniforms(diagonal);
    const middle = lo.map((v, i) => (v + hi[i]) / 2);
    const forward = view.camera.slice(6);
    const depth = view.perspective ? Math.max(1e-9, middle.reduce((sum, v, i) => sum + (v - view.eye[i]) * forward[i], 0)) : 1;
    const pixel = 2 * view.zoom * depth / size[1];
    const farthest = Math.hypot(...view.eye.map((v, i) => v - middle[i])) + diagonal;
    const rounding = 2 ** -23 * Math.max(...[...view.eye, ...lo, ...hi].map(Math.abs));
    const nearest = Math.max(0.2 * pixel, 1e-6 * farthest, 4 * rounding);
    gl.useProgram(this.program);
    gl.uniform1i(this.place("cells"), 0);
    scene.data.forEach((_, k) => gl.uniform1i(this.place(`data${k}`), k + 1));
    if (scene.numbers.length) gl.uniform1fv(this.place("u"), new Float32Array(scene.numbers));
    gl.uniform1i(this.place("want"), 0);
    gl.uniform1i(this.place("samples"), 1);
    const reals = {
      side: 1, layer: 0, bare: 0, zoom: view.zoom, perspective: view.perspective, rounding, nearest,
      finest: Math.max(0.01 * pixel, 1e-7 * farthest, rounding), jump: Math.max(0.5 * pixel, nearest), reach: 0.1 * diagonal,
      grain: Math.max(0.5 * pixel, 1e-5 * farthest, 32 * rounding),
    };
    for (const [name, value] of Object.entries(reals)) gl.uniform1f(this.place(name), value);
    gl.uniform2f(this.place("size"), size[0], size[1]);
    gl.uniform2f(this.place("corner"), 0, 0);
    for (const [name, value] of Object.entries({ eye: view.eye, box_lo: lo, box_hi: hi, cut_lo: [0, 0, 0], cut_hi: [0, 0, 0] }))
      gl.uniform3fv(this.place(name), value);
    gl.uniformMatrix3fv(this.place("camera"), false, view.camera);
    gl.uniform3iv(this.place("counts"), scene.counts);
    gl.viewport(0, 0, size[0], size[1]);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, from, size[0], to - from);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.SCISSOR_TEST);
  }
}
