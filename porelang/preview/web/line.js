// The line to `pore view`: words as objects, scenes with their textures.
export class Line {
  // `heard(word)` is given each word, `opened()` is called whenever the line is there, `closed()` when it is not.
  constructor(heard, opened, closed) {
    Object.assign(this, { heard, opened, closed });
    this.connect();
  }

  connect() {
    this.socket = new WebSocket(`ws://${location.host}${location.pathname}live`);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => this.opened();
    this.socket.onmessage = ({ data }) => this.heard(typeof data === "string" ? JSON.parse(data) : unpacked(data));
    this.socket.onclose = () => {
      this.closed();
      setTimeout(() => this.connect(), 1000);
    };
  }

  send(word) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(word));
  }
}

// A scene of porelang/preview/wire.py: the length of its head, the head, the textures.
function unpacked(buffer) {
  const size = new DataView(buffer).getUint32(0, true);
  const scene = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, size)));
  let at = 4 + size;
  const words = (kind, count) => {
    at += 4 * count;
    return new kind(buffer, at - 4 * count, count);
  };
  for (const layer of [...scene.bodies, ...(scene.plane ? [scene.plane] : [])]) {
    layer.numbers = new Float32Array(layer.numbers);
    if (layer.counts) layer.cells = words(Float32Array, layer.counts[0] * layer.counts[1] * layer.counts[2]);
    layer.data = layer.words.map((count) => words(Uint32Array, count));
  }
  return { say: "scene", ...scene };
}
