// A scene of porelang/preview/wire.py: the length of its head, the head, the textures.
export function unpacked(buffer) {
  const size = new DataView(buffer).getUint32(0, true);
  const scene = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, size)));
  let at = 4 + size;
  const words = (kind, count) => {
    at += 4 * count;
    return new kind(buffer, at - 4 * count, count);
  };
  for (const layer of layers(scene)) {
    layer.numbers = new Float32Array(layer.numbers);
    if (layer.counts) layer.cells = words(Float32Array, layer.counts[0] * layer.counts[1] * layer.counts[2]);
    layer.data = layer.words.map((count) => words(Uint32Array, count));
  }
  return { say: "scene", ...scene };
}

export const layers = (scene) => [...scene.bodies, ...(scene.plane ? [scene.plane] : [])];

// The shaders' texts that came: a scene leaves out those that did not change.
export class Texts {
  constructor() {
    this.known = [];
  }

  forget() {
    this.known = [];
  }

  into(scene) {
    layers(scene).forEach((layer, i) => { layer.text ??= this.known[scene.plane === layer ? "plane" : i]; });
    this.known = scene.bodies.map((body) => body.text);
    this.known.plane = scene.plane?.text;
  }
}
