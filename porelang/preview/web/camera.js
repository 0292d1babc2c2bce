// Where the picture is taken from: the numbers of porelang/render/camera.py.
const degrees = Math.PI / 180;

export const VIEWS = {
  iso: [-45, Math.atan(Math.SQRT1_2) / degrees],
  front: [-90, 0], back: [90, 0], left: [180, 0], right: [0, 0], top: [-90, 90], bottom: [-90, -90],
};
const HALF = Math.tan(11 * degrees);  // of the height that perspective takes in, at distance 1
const MARGIN = 1.06;

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const add = (a, b, s) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];

export class Camera {
  constructor() {
    [this.azimuth, this.elevation] = VIEWS.iso;  // degrees
    this.target = [0, 0, 0];                     // mm
    this.height = 100;                           // what the picture takes in at the target, mm
    this.perspective = true;
    this.fitted = true;                          // nothing was moved since all of the part was shown
  }

  axes() {
    const turn = this.azimuth * degrees, lift = this.elevation * degrees;
    const out = [Math.cos(turn) * Math.cos(lift), Math.sin(turn) * Math.cos(lift), Math.sin(lift)];
    const right = [-Math.sin(turn), Math.cos(turn), 0];
    return { out, right, up: cross(out, right) };
  }

  turn(azimuth, elevation) {
    this.fitted = false;
    this.azimuth = (this.azimuth + azimuth) % 360;
    this.elevation = Math.min(90, Math.max(-90, this.elevation + elevation));
  }

  move(dx, dy, pixels) {
    this.fitted = false;
    const { right, up } = this.axes();
    const mm = this.height / pixels;
    this.target = add(add(this.target, right, -dx * mm), up, dy * mm);
  }

  closer(factor) {
    this.fitted = false;
    this.height = Math.min(1e7, Math.max(1e-4, this.height / factor));
  }

  // All of a box.
  fit(lo, hi, aspect) {
    this.fitted = true;
    const { out, right, up } = this.axes();
    this.target = lo.map((v, i) => (v + hi[i]) / 2);
    let distance = 0, spread = 0;
    for (let i = 0; i < 8; i++) {
      const corner = lo.map((v, k) => ((i >> k) & 1 ? hi[k] : v) - this.target[k]);
      const needed = MARGIN * Math.max(Math.abs(dot(corner, right)) / aspect, Math.abs(dot(corner, up)));
      spread = Math.max(spread, needed);
      distance = Math.max(distance, needed / HALF + dot(corner, out));
    }
    this.height = this.perspective ? 2 * HALF * distance : 2 * spread;
  }

  // What the shader wants; `diagonal` of the box in mm.
  uniforms(diagonal) {
    const { out, right, up } = this.axes();
    const far = this.perspective ? this.height / 2 / HALF : 2 * diagonal;
    return {
      eye: add(this.target, out, far),
      camera: [...right, ...up, -out[0], -out[1], -out[2]],
      zoom: this.perspective ? HALF : this.height / 2,
      perspective: this.perspective ? 1 : 0,
    };
  }
}
