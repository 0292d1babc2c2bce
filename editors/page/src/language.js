// Colours, comments, brackets and indentation of a program.
import { indentService, StreamLanguage, syntaxHighlighting } from "@codemirror/language";
import { Tag, tagHighlighter } from "@lezer/highlight";
import { PATTERNS } from "./patterns.js";

const named = (what) => `pore-${what.replaceAll(".", "-")}`;  // no name that StreamLanguage knows as another
const TAGS = Object.fromEntries(PATTERNS.map(([what]) => [named(what), Tag.define()]));
const TRIED = PATTERNS.map(([what, pattern]) => [named(what), new RegExp(pattern, "y")]);

const pore = StreamLanguage.define({
  name: "pore",
  tokenTable: TAGS,
  languageData: {
    commentTokens: { line: "#" },
    closeBrackets: { brackets: ["(", "[", "{", '"'] },
    indentOnInput: /^\s*[)\]}]$/,
  },
  token(stream) {
    if (stream.eatSpace()) return null;
    for (const [what, pattern] of TRIED) {
      pattern.lastIndex = stream.pos;  // on the whole line: patterns look behind
      const found = pattern.exec(stream.string);
      if (!found?.[0]) continue;
      stream.pos += found[0].length;
      return what;
    }
    stream.next();
    return null;
  },
});

// A line is as far in as the last one that is not empty; two more behind a bracket that stays open, two less where it closes.
const indentation = indentService.of((context, place) => {
  const line = context.lineAt(place, 1);
  let depth = 0;
  for (let end = line.from - 1; end >= 0;) {
    const before = context.lineAt(end, -1);
    const code = before.text.replace(/"(?:[^"\\]|\\.)*"?/g, "").replace(/#.*/, "").trimEnd();
    if (code.trim()) {
      depth = context.lineIndent(end, -1) + (/[([{]$/.test(code) ? context.unit : 0);
      break;
    }
    end = before.from - 1;
  }
  return /^\s*[)\]}]/.test(line.text) ? Math.max(0, depth - context.unit) : depth;
});

const classes = tagHighlighter(Object.entries(TAGS).map(([what, tag]) => ({ tag, class: what })));

export const language = [pore, indentation, syntaxHighlighting(classes)];
