// The program beside the picture: written, marked where it is wrong, completed, saved.
import { LONG } from "./line.js";

const TOO_LONG = "This text is longer than 1 MB, which is the most that the page sends: it is not saved, and what is drawn and marked is the text before. "
  + "Put what makes it long into a file of its own, which it uses or loads; or save it with another editor.";
const element = (id) => document.getElementById(id);

export class SourcePane {
  // `send(word)` tells a word, and gives why nobody has been told; `wrong(of, text)` is told what is wrong.
  constructor(send, wrong) {
    this.send = (word) => {
      const why = send(word);
      if ("text" in word) wrong("long", why === LONG ? TOO_LONG : "");
      return why;
    };
    this.wrong = wrong;
    this.editor = null;
    this.disk = "";       // the text of the file
    this.now = "";        // the text here
    this.marks = [];
    this.asked = new Map();  // completions that are waited for
    this.count = 0;
    this.gone = "";       // why the file cannot be read, if it cannot
    this.known = false;   // whether there was ever a text of it
    this.refused = "";    // why nobody was told to save it
    element("save").onclick = () => this.save();
    element("style").onclick = () => this.style();
    element("shut").onclick = () => this.open(false);
    element("open").onclick = () => this.open(element("source").hidden);
    element("theirs").onclick = () => {
      if (this.send({ do: "discard" })) return;
      element("conflict").hidden = true;
      this.now = this.disk;  // what is on disk now comes, and takes its place
    };
    element("ours").onclick = () => { element("conflict").hidden = true; this.save(true); };
    addEventListener("beforeunload", (e) => { if (this.dirty || this.gone) e.preventDefault(); });
  }

  get dirty() {
    return this.now !== this.disk;
  }

  async open(wanted) {
    element("source").hidden = !wanted;
    element("open").setAttribute("aria-pressed", String(wanted));
    if (!wanted) return;
    if (!this.editor) {
      const { edit } = await import("./editor.js");
      if (this.editor) return;
      this.editor = edit(element("editor"), {
        changed: (text) => {
          this.now = text;
          this.refused = "";
          this.wrong("style", "");  // of the text as it was
          this.stand();
          this.send({ do: "edit", text });
        },
        complete: (text, offset) => this.complete(text, offset),
        save: () => this.save(),
        format: () => this.style(),
      });
      this.editor.show(this.now);
      this.editor.mark(this.marks);
    }
    this.stand();
    this.editor.focus();
  }

  complete(text, offset) {
    this.now = text;
    const number = ++this.count;
    this.send({ do: "complete", number, text, offset });
    return new Promise((resolve) => this.asked.set(number, resolve));
  }

  save(over = false) {
    if (this.editor) this.now = this.editor.text();
    this.stand();
    if (element("save").disabled) return;
    if (!over && !element("conflict").hidden) return;  // that is to be answered first
    this.saving = this.now;
    this.refused = this.send({ do: "save", text: this.now, over });
    this.stand();
  }

  style() {
    this.styling = this.editor.text();
    this.send({ do: "style", text: this.styling });
  }

  // What is said of the text.
  heard(word) {
    if (word.say === "gone") this.gone = word.why;
    else if (word.say === "text") {
      this.known = true;
      if (this.dirty) {  // what is written here stays, and where it began with another text than is on disk now, both are asked about
        if (word.text !== this.disk) element("conflict").hidden = false;
        return;
      }
      this.disk = this.now = word.text;
      this.wrong("long", "");
      this.editor?.show(word.text);
    } else if (word.say === "program" || word.say === "doubts") {
      this.marks = word.say === "program" ? word.marks : [...this.marks.filter((m) => m.severity === "error"), ...word.marks];
      this.editor?.mark(this.marks);
    } else if (word.say === "styled") {
      if (this.editor.text() !== this.styling) return;  // it was written on meanwhile
      this.editor.show(word.text);
      this.now = word.text;
      this.wrong("style", "");
      this.send({ do: "edit", text: word.text });
    } else if (word.say === "saved") {
      this.disk = this.saving;
      this.known = true;
      this.wrong("save", "");
    } else if (word.say === "conflict") element("conflict").hidden = false;
    else if (word.say === "completions") {
      this.asked.get(word.number)?.(word.items);
      this.asked.delete(word.number);
    }
    this.stand();
  }

  // The line is there again: whoever is at its other end knows only what is on disk.
  again() {
    this.asked.clear();
    this.refused = "";
    this.gone = "";  // it is said again
    this.stand();
    if (this.dirty) this.send({ do: "edit", text: this.now });
  }

  stand() {
    const state = this.dirty ? "not saved" : this.gone ? "not on disk" : "saved";
    element("state").textContent = this.refused ? `Nothing was saved: ${this.refused}` : state;
    element("save").disabled = !this.dirty && !(this.gone && this.known);  // a text that nobody has read is not empty
    this.editor?.dirty(this.dirty);
  }
}
