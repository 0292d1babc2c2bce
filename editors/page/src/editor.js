// The editor of `pore view`: CodeMirror 6 with the colours, keys and completion of a program.
import {
  autocompletion, acceptCompletion, closeBrackets, closeBracketsKeymap, completionKeymap, pickedCompletion,
} from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap, indentWithTab, isolateHistory } from "@codemirror/commands";
import { bracketMatching, indentOnInput, indentUnit } from "@codemirror/language";
import { lintGutter, nextDiagnostic, previousDiagnostic, setDiagnostics } from "@codemirror/lint";
import { highlightSelectionMatches, search, searchKeymap } from "@codemirror/search";
import { Annotation, Compartment, EditorSelection, EditorState, Transaction } from "@codemirror/state";
import {
  drawSelection, EditorView, highlightActiveLine, highlightActiveLineGutter, highlightSpecialChars, keymap, lineNumbers,
  rectangularSelection,
} from "@codemirror/view";
import { change, kept } from "./change.js";
import { language } from "./language.js";
import { rules, theme } from "./theme.js";

const PAUSE = 150;  // ms after the last key until a change is told
const PATIENCE = 5000;  // ms after which an answer is no longer waited for
const LABEL = "The program. Escape, then Tab leaves the editor.";
const KINDS = {
  function: "function", param: "property", value: "variable", file: "text", argument: "property", member: "method",
  unit: "constant", word: "keyword", kind: "type", text: "text", namespace: "namespace",
};
const shown = Annotation.define();  // a change that the page made, not whoever writes

export function edit(parent, { changed, complete, save, format } = {}) {
  // CodeMirror's rules are a <style> in a document, which the page's CSP refuses, and an adopted sheet in a shadow root.
  const host = document.createElement("div");
  const root = host.attachShadow({ mode: "open" });
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(rules);
  root.adoptedStyleSheets = [sheet];
  parent.append(host);

  // CodeMirror counts every end of a line as one unit. Where all are those of Windows, they are taken out here and put
  // back in what the page gets; all other text, a lone \r too, stays as it is.
  let windows = false;
  let waiting = 0;
  let blank = true;
  const inward = (text) => windows ? text.replaceAll("\r\n", "\n") : text;
  const outward = (text) => windows ? text.replaceAll("\n", "\r\n") : text;
  const text = () => outward(view.state.doc.toString());
  const within = (offset) => Math.max(0, Math.min(Math.trunc(offset) || 0, view.state.doc.length));
  function at(offset) {  // the place in CodeMirror's text of an offset in the page's
    if (!windows) return within(offset);
    let low = 0, high = view.state.doc.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (from(middle) < offset) low = middle + 1;
      else high = middle;
    }
    return low;
  }
  const from = (place) => windows ? place + view.state.doc.lineAt(place).number - 1 : place;

  function wrote() {
    clearTimeout(waiting);
    waiting = setTimeout(() => changed?.(text()), PAUSE);
  }

  const told = (act) => () => {
    act?.(text());
    return true;
  };

  const dark = matchMedia("(prefers-color-scheme: dark)");
  const scheme = new Compartment();
  const view = new EditorView({
    parent: root,
    root,
    state: EditorState.create({
      extensions: [
        EditorState.lineSeparator.of("\n"),
        EditorView.clipboardInputFilter.of((pasted) => pasted.replace(/\r\n?/g, "\n")),
        lineNumbers(), EditorView.lineWrapping, highlightActiveLine(), highlightActiveLineGutter(), highlightSpecialChars(),
        lintGutter(), history(), drawSelection(), rectangularSelection(),
        EditorState.allowMultipleSelections.of(true), EditorState.tabSize.of(2), indentUnit.of("  "),
        language, indentOnInput(), bracketMatching(), closeBrackets(),
        search({ top: true }), highlightSelectionMatches(),
        autocompletion({ override: [completions(complete, { text, from, at })] }),
        keymap.of([
          { key: "Mod-s", preventDefault: true, run: told(save) },
          { key: "Mod-Shift-f", preventDefault: true, run: told(format) },
          { key: "Shift-Alt-f", preventDefault: true, run: told(format) },
          { key: "F8", run: nextDiagnostic, shift: previousDiagnostic },
          { key: "Tab", run: acceptCompletion },
          ...closeBracketsKeymap, ...completionKeymap, ...searchKeymap, ...historyKeymap, ...defaultKeymap, indentWithTab,
        ]),
        EditorView.contentAttributes.of({ "aria-label": LABEL, autocapitalize: "off" }),
        EditorView.updateListener.of((update) => {
          if (update.docChanged && !update.transactions.every((t) => !t.docChanged || t.annotation(shown))) wrote();
        }),
        theme, scheme.of(EditorView.darkTheme.of(dark.matches)),
      ],
    }),
  });
  dark.addEventListener("change", () => {
    view.dispatch({ effects: scheme.reconfigure(EditorView.darkTheme.of(dark.matches)) });
  });

  return {
    text,
    show(fresh) {
      windows = fresh.includes("\r\n") && !/(^|[^\r])\n|\r(?!\n)/.test(fresh);
      const old = view.state.doc.toString(), now = inward(fresh);
      const first = blank;
      blank = false;
      if (old === now) return;
      clearTimeout(waiting);  // what was written is gone, or is part of this
      const made = change(old, now);
      const place = (offset) => kept(old, now, made, offset);
      const ranges = view.state.selection.ranges.map((r) => EditorSelection.range(place(r.anchor), place(r.head)));
      const { scrollTop, scrollLeft } = view.scrollDOM;
      const top = view.lineBlockAtHeight(scrollTop - view.documentPadding.top);
      const below = scrollTop - top.top, line = place(top.from);
      view.dispatch({
        changes: made,
        selection: EditorSelection.create(ranges, view.state.selection.mainIndex),
        annotations: [shown.of(true), isolateHistory.of("full"), Transaction.addToHistory.of(!first)],
      });
      // the line that was seen first is still where it was: CodeMirror itself loses it where it was replaced
      view.requestMeasure({
        read: () => view.lineBlockAt(Math.min(line, view.state.doc.length)).top + below,
        write: (now) => view.scrollDOM.scrollTo(scrollLeft, now),
      });
    },
    mark(marks) {
      view.dispatch(setDiagnostics(view.state, marks.map(({ from: a, to: b, severity, message }) => {
        const start = at(a);
        return { from: start, to: Math.max(start, at(b)), severity, message };
      }).sort((a, b) => a.from - b.from || a.to - b.to)));
    },
    dirty(is) { parent.toggleAttribute("data-dirty", Boolean(is)); },
    focus() { view.focus(); },
    go(offset) {
      const place = at(offset);
      view.dispatch({ selection: { anchor: place }, effects: EditorView.scrollIntoView(place, { y: "center" }) });
    },
  };
}

// ---- completion -----------------------------------------------------------------------------------------------------

// Numbers open no list: Enter after `10` is to end the line, not to write a unit. Nor does the first letter of a name.
const OPENS = /(?:[A-Za-z_]\w+|(?:^|[^.])\.|^[^"]*"(?:[^"]*"[^"]*")*[^"]*|\d[A-Za-z]+)$/;
const NUMBER = /(?:^|[^\w.])(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?$/;

function completions(complete, { text, from, at }) {
  let asked = null;
  return async (context) => {
    if (!complete) return null;
    const line = context.state.doc.lineAt(context.pos);
    const before = line.text.slice(0, context.pos - line.from);
    if (!context.explicit && (!OPENS.test(before) || NUMBER.test(before))) return null;
    while (asked) await asked;
    if (context.aborted) return null;
    const patience = new Promise((resolve) => setTimeout(resolve, PATIENCE, []));
    const whole = text();
    const ask = Promise.resolve().then(() => complete(whole, from(context.pos)));
    asked = Promise.race([ask, patience]).catch(() => []);
    const items = await asked;
    asked = null;
    if (context.aborted || !items?.length) return null;
    return offered(items, context.pos, at);
  };
}

// What is offered stands in for `start..end` of the text that was asked about; `begin..` moves with what is written since.
function offered(items, pos, at) {
  const begin = Math.min(pos, at(items[0].start));
  const option = (item, i) => {
    const called = item.detail?.startsWith(`${item.label}(`);  // the name is not to stand there twice
    const before = at(item.start) - begin, behind = Math.max(0, at(item.end) - pos);
    return {
      label: item.label,
      type: KINDS[item.kind],
      detail: (called ? item.detail.slice(item.label.length) : item.detail) || undefined,
      info: item.doc || undefined,
      sortText: String(i).padStart(6, "0"),
      apply(view, picked, from, to) {
        view.dispatch({
          changes: { from: from + before, to: to + behind, insert: item.text },
          selection: { anchor: from + before + item.text.length },
          scrollIntoView: true,
          userEvent: "input.complete",
          annotations: pickedCompletion.of(picked),
        });
      },
    };
  };
  return { from: begin, options: items.map(option), validFor: /^(?:[A-Za-z_]\w*)?$/ };
}
