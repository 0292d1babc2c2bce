// How the editor looks: in the colours of the page, and in some of its own for what a program consists of.
import { EditorView } from "@codemirror/view";

export const rules = `
:host {
  display: block; height: 100%; min-height: 0;
  --pore-doc: #2f6b3a; --pore-string: #2f6b3a; --pore-number: #1f5fa8; --pore-constant: #76389b; --pore-coordinate: #a0246e;
  --pore-function: #0f5f78; --pore-doubt: #7a5200; --pore-hint: #1f5fa8;
}
@media (prefers-color-scheme: dark) {
  :host {
    --pore-doc: #9ad0a0; --pore-string: #9ad0a0; --pore-number: #8fc1ff; --pore-constant: #d3b1f2; --pore-coordinate: #f2a7d0;
    --pore-function: #8bd2e6; --pore-doubt: #e8c069; --pore-hint: #8fc1ff;
  }
}`;

const faint = (colour, share) => `color-mix(in srgb, var(${colour}) ${share}%, transparent)`;
const field = {
  font: "inherit", color: "inherit", background: "var(--ground)", border: "1px solid var(--line)", borderRadius: "4px",
  padding: "2px 6px",
};
const wavy = (colour) => ({
  backgroundImage: "none", paddingBottom: "0", textDecoration: `underline wavy var(${colour}) 1px`, textUnderlineOffset: "3px",
});
// signs beside the lines differ in shape too
const sign = (colour, shape) => ({
  content: "normal", lineHeight: "1", "&:before": { content: `"${shape}"`, color: `var(${colour})` },
});
const beside = (colour) => ({ borderLeftColor: `var(${colour})` });

export const theme = EditorView.theme({
  "&": { height: "100%", background: "var(--ground)", color: "var(--text)", fontSize: "13px" },
  "&.cm-focused": { outline: "none" },
  "&.cm-focused .cm-gutters": { borderRightColor: "var(--accent)" },
  ".cm-scroller": { fontFamily: "ui-monospace, monospace", lineHeight: "1.5", overflow: "auto" },
  ".cm-content": { caretColor: "var(--text)", padding: "6px 0" },
  ".cm-line": { padding: "0 12px 0 8px" },
  ".cm-cursor, .cm-dropCursor": { borderLeftColor: "var(--text)", borderLeftWidth: "2px" },
  ".cm-gutters": { background: "var(--panel)", color: "var(--quiet)", borderRight: "1px solid var(--line)" },
  ".cm-activeLine": { background: faint("--text", 4) },
  ".cm-activeLineGutter": { background: faint("--text", 7), color: "var(--text)" },
  ".cm-selectionLayer .cm-selectionBackground": { background: faint("--pore-number", 22) },
  "&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground": { background: faint("--pore-number", 22) },
  ".cm-selectionMatch": { background: faint("--pore-number", 12) },
  "&.cm-focused .cm-matchingBracket, .cm-matchingBracket": {
    background: faint("--accent", 18), outline: `1px solid ${faint("--accent", 60)}`,
  },
  "&.cm-focused .cm-nonmatchingBracket, .cm-nonmatchingBracket": { background: faint("--wrong", 18) },
  ".cm-searchMatch": { background: faint("--pore-doubt", 22), outline: `1px solid ${faint("--pore-doubt", 60)}` },
  ".cm-searchMatch-selected": { background: faint("--pore-doubt", 40) },

  ".pore-comment": { color: "var(--quiet)" },
  ".pore-comment-documentation": { color: "var(--pore-doc)" },
  ".pore-string": { color: "var(--pore-string)" },
  ".pore-number": { color: "var(--pore-number)" },
  ".pore-keyword": { color: "var(--accent)" },
  ".pore-keyword-declaration": { color: "var(--accent)", fontWeight: "600" },
  ".pore-constant": { color: "var(--pore-constant)" },
  ".pore-variable-coordinate": { color: "var(--pore-coordinate)" },
  ".pore-function": { color: "var(--pore-function)" },

  ".cm-lintRange-error": wavy("--wrong"),
  ".cm-lintRange-warning": wavy("--pore-doubt"),
  ".cm-lintRange-info": wavy("--pore-hint"),
  ".cm-lintRange-active": { background: faint("--accent", 14) },
  ".cm-lintPoint-error:after": { borderBottomColor: "var(--wrong)" },
  ".cm-lintPoint-warning:after": { borderBottomColor: "var(--pore-doubt)" },
  ".cm-lintPoint-info:after": { borderBottomColor: "var(--pore-hint)" },
  ".cm-gutter-lint": { width: "16px" },
  ".cm-gutter-lint .cm-gutterElement": { padding: "0", display: "flex", alignItems: "center", justifyContent: "center" },
  ".cm-lint-marker": { width: "auto", height: "auto", cursor: "help" },
  ".cm-lint-marker-error": sign("--wrong", "●"),
  ".cm-lint-marker-warning": sign("--pore-doubt", "▲"),
  ".cm-lint-marker-info": sign("--pore-hint", "◆"),
  ".cm-diagnostic": { padding: "5px 10px", borderLeft: "4px solid", whiteSpace: "pre-wrap", overflowWrap: "anywhere" },
  ".cm-diagnostic-error": beside("--wrong"),
  ".cm-diagnostic-warning": beside("--pore-doubt"),
  ".cm-diagnostic-info": beside("--pore-hint"),

  ".cm-tooltip": {
    background: "var(--panel)", color: "var(--text)", border: "1px solid var(--line)", borderRadius: "4px", overflow: "hidden",
  },
  ".cm-tooltip-hover, .cm-tooltip-lint": { maxWidth: "min(520px, 90vw)", maxHeight: "50vh", overflow: "auto" },
  ".cm-tooltip.cm-tooltip-autocomplete": { overflow: "visible" },
  ".cm-tooltip.cm-tooltip-autocomplete > ul": {
    fontFamily: "ui-monospace, monospace", maxHeight: "16em", maxWidth: "min(560px, 95vw)",
  },
  ".cm-tooltip.cm-tooltip-autocomplete > ul > li": {
    padding: "2px 8px 2px 2.4em", textIndent: "-1.6em", color: "var(--text)", whiteSpace: "normal", overflowWrap: "anywhere",
  },
  ".cm-tooltip.cm-tooltip-autocomplete > ul > li[aria-selected]": { background: faint("--accent", 22), color: "var(--text)" },
  ".cm-completionMatchedText": { textDecoration: "none", fontWeight: "700" },
  ".cm-completionDetail": { color: "var(--quiet)", fontStyle: "normal", marginLeft: "1em" },
  ".cm-completionIcon": { opacity: "1", color: "var(--quiet)" },
  "li[aria-selected] .cm-completionDetail, li[aria-selected] .cm-completionIcon": { color: "var(--text)" },
  ".cm-completionInfo": { whiteSpace: "pre-wrap", maxWidth: "320px", padding: "5px 10px" },

  ".cm-panels": { background: "var(--panel)", color: "var(--text)" },
  ".cm-panels-top": { borderBottom: "1px solid var(--line)" },
  ".cm-panel.cm-search": { padding: "6px 24px 6px 8px" },
  ".cm-panel.cm-search label": { fontSize: "12px" },
  ".cm-textfield": field,
  ".cm-textfield::placeholder": { color: "var(--quiet)", opacity: "1" },
  ".cm-button": { ...field, backgroundImage: "none", cursor: "pointer" },
  ".cm-button:hover": { borderColor: "var(--accent)" },
  ".cm-button:active": { backgroundImage: "none" },
  ".cm-textfield:focus-visible, .cm-button:focus-visible, .cm-panel [name=close]:focus-visible": { outline: "2px solid var(--accent)" },
  ".cm-panel.cm-search [name=close]": { color: "var(--text)", fontSize: "16px" },
  ".cm-specialChar": { color: "var(--wrong)" },
});
