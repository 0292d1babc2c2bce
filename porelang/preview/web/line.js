// The line to `pore view`: words as objects, scenes with their textures.
import { unpacked } from "./wire.js";

const AGAIN = 1000;  // ms between two tries
const LONGEST = 2 ** 20;  // bytes of a word, as server.py has it

// Why nobody has been told.
export const ENDED = "`pore view` has ended", LONG = "it is longer than 1 MB";

// Whether who listens at our port knows the token of this page, without telling it: what was `pore view` may be another program now.
async function known() {
  const hex = (bytes) => [...new Uint8Array(bytes)].map((b) => b.toString(16).padStart(2, "0")).join("");
  const nonce = hex(crypto.getRandomValues(new Uint8Array(16)));
  const bytes = (text) => new TextEncoder().encode(text);
  const key = await crypto.subtle.importKey("raw", bytes(location.pathname.split("/")[1]), { name: "HMAC", hash: "SHA-256" }, false, ["sign"]);
  const answer = await fetch(`/known/${nonce}`);
  return (await answer.text()) === hex(await crypto.subtle.sign("HMAC", key, bytes(nonce)));
}

export class Line {
  // `heard(word)` is given each word, `opened()` is called whenever the line is there. `closed(other)` is called when it is not: is there
  // another program at its end? `look()` is how the part is looked at, for who is at its end.
  constructor(heard, opened, closed, look) {
    Object.assign(this, { heard, opened, closed, look });
    this.connect();
  }

  connect() {
    this.socket = new WebSocket(`ws://${location.host}${location.pathname}live?${this.look()}`);
    this.socket.binaryType = "arraybuffer";
    let there = false;
    this.socket.onopen = () => { there = true; this.opened(); };
    this.socket.onmessage = ({ data }) => this.heard(typeof data === "string" ? JSON.parse(data) : unpacked(data));
    this.socket.onclose = () => {
      if (!there) this.closed(true);
      setTimeout(() => this.again(), there ? 100 : AGAIN);
    };
  }

  async again() {
    let ours = null;
    try {
      ours = await known();
    } catch {
      // nobody listens
    }
    if (ours) return this.connect();
    this.closed(ours === false);
    setTimeout(() => this.again(), AGAIN);
  }

  // Tell a word; why nobody has been told, or "".
  send(word) {
    if (this.socket.readyState !== WebSocket.OPEN) return ENDED;
    const text = JSON.stringify(word);
    if (new TextEncoder().encode(text).length > LONGEST) return LONG;
    this.socket.send(text);
    return "";
  }
}
