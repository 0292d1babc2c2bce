// The line to `pore view`: words as objects, scenes with their textures.
import { unpacked } from "./wire.js";

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
