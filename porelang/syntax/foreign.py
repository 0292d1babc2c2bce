"""Symbols that are not Pore's: those of other languages, typographic ones, and characters that mean nothing."""

from __future__ import annotations

import re
import unicodedata

from porelang.diagnostics import Diagnostic, Edit
from porelang.source import Span

# A symbol of another language: what it is called there, and what stands for it here (None: nothing does).
OTHER_LANGUAGES: dict[str, tuple[str, str | None]] = {
    "&&": ("two conditions are joined by `and`, two solids are intersected by `&`", "&"),
    "||": ("two conditions are joined by `or`, two solids are united by `|`", "|"),
    "**": ("a power is written with `^`", "^"),
    "/*": ("a comment starts with `#` and ends with the line", None),
    "->": ("a function is written with `=>`", "=>"),
    "++": ("`+` adds; there is no `++`", "+"),
    "===": ("two values are compared with `==`", "=="),
    ":=": ("a name gets its value with `=`", "="),
    "=<": ("`<=` compares", "<="),
    "<>": ("`!=` compares", "!="),
    "!": ("a condition is negated by `not`, a solid is inverted by `~`", "not "),
    "?": ("a choice is written `if c then a else b`", None),
}

# Characters that a word processor, a web page or a keyboard puts for one of Pore's, but for those that Unicode knows
# to be one of its signs in another form (a dash, a wide letter, a space, something that is not seen).
LOOK_ALIKES: dict[str, str] = {
    "\u2212": "-",
    **dict.fromkeys("\u00d7\u00b7\u22c5\u2217\u2022", "*"),
    **dict.fromkeys("\u00f7\u2215\u2044", "/"),
    **dict.fromkeys("\u2229\u2227", "&"),
    **dict.fromkeys("\u222a\u2228", "|"),
    **dict.fromkeys("\u2216", "\\"),
    **dict.fromkeys("\u223c\u02dc", "~"),
    "\u2264": "<=",
    "\u2265": ">=",
    "\u2260": "!=",
    "\u00ac": "not ",
    "\u21d2": "=>",
    "\u2192": "=>",
    "\u25b7": "|>",
    "\u2026": "..",
    "\u00b0": "deg",
    "\u00ba": "deg",
    "\u00b5": "u",
    "\u03bc": "u",
    "\u03c0": "pi",
    "\u03c4": "tau",
}
#: Signs that open or close a text elsewhere.
_QUOTES = "\u2018\u2019\u201a\u201b\u00ab\u00bb\u2039\u203a\u300c\u300d\u00b4`"
#: Signs that stand for more than a sign of Pore, and what is written for them.
_WRITTEN = {
    "\u221a": "a root is written `sqrt(a)`",
    "\u221b": "a root is written `cbrt(a)`",
    "\u221e": "there is no infinity: leave out what would be compared with it",
    "\u2211": "a sum is written `sum([a, b, c])`",
    "\u2208": "write `for i in range(6)`",
    "\u2032": "lengths are written 10mm, 1in; angles 30deg",
    "\u2033": "lengths are written 10mm, 1in; angles 30deg",
    "\u2103": "temperatures have no unit here",
}
#: Greek letters and others that have no plain form in Unicode, for names.
_SPELT = {
    "\u03b1": "alpha",
    "\u03b2": "beta",
    "\u03b3": "gamma",
    "\u03b4": "delta",
    "\u03b5": "epsilon",
    "\u03b8": "theta",
    "\u03bb": "lambda_",
    "\u03c1": "rho",
    "\u03c3": "sigma",
    "\u03c6": "phi",
    "\u03c9": "omega",
    "\u00df": "ss",
    "\u00e6": "ae",
    "\u00f8": "o",
    "\u0153": "oe",
    "\u0142": "l",
    "\u00f0": "d",
    "\u00fe": "th",
    "\u0394": "delta",
    "\u03a6": "phi",
    "\u03a9": "omega",
}
_WORD = re.compile(r"\w+")
_SETTING = re.compile(r"\$f[nas]\s*=\s*[\w.]+")


def is_space(text: str) -> bool:
    """Whether these are spaces of another width than the usual one: they part words as that does."""
    return all(unicodedata.category(c) == "Zs" for c in text)


def foreign_symbol(kind: str, span: Span) -> Diagnostic:
    """What to say of a symbol that no rule takes; `kind` is its terminal: FOREIGN, UNCLOSED or JUNK."""
    if kind == "UNCLOSED":
        return Diagnostic(
            "E004",
            "this text is not closed",
            span,
            'a `"` is missing before the end of the line',
            hint='close it with `"`; a text ends on the line where it starts',
            edit=Edit(Span(span.source, span.end, span.end), '"'),
        )
    return _foreign(span) if kind == "FOREIGN" else _character(span)


def comment_at(span: Span) -> str:
    """The `/* */` that begins here, to the end of the file where it is not closed."""
    text = span.source.text
    end = text.find("*/", span.start + 2)
    return text[span.start :] if end < 0 else text[span.start : end + 2]


def foreign_comment(span: Span) -> Diagnostic:
    """What to say of a `/* */`; what stands in it is not read."""
    text = comment_at(span)
    whole = Span(span.source, span.start, span.start + len(text))
    inside = text[2:].removesuffix("*/")
    lines = [f"# {line.strip().lstrip('*').strip()}".rstrip() for line in inside.strip().split("\n")]
    rest = span.source.text[whole.end :].partition("\n")[0]
    ours = "" if rest.strip() else "\n".join(lines)  # code follows on its line
    hint = "a comment starts with `#` and ends with the line"
    return Diagnostic("E001", "`/*` is not a sign of Pore", span, hint=hint, edit=Edit(whole, ours))


def _foreign(span: Span) -> Diagnostic:
    text = span.text
    if text.startswith("//"):
        return Diagnostic(
            "E001",
            "`//` is not a sign of Pore",
            Span(span.source, span.start, span.start + 2),
            hint="a comment starts with `#`; for a whole number of times write `floor(a / b)`",
            edit=Edit(span, "#" + text[2:]),
        )
    if text == "...":
        return Diagnostic(
            "E013", "a range is written with two dots", span, hint="write `lo..hi`", edit=Edit(span, "..")
        )
    if text in OTHER_LANGUAGES:
        hint, ours = OTHER_LANGUAGES[text]
        edit = None if ours is None else Edit(span, ours)
        return Diagnostic("E001", f"`{text}` is not a sign of Pore", span, hint=hint, edit=edit)
    before = span.source.text[max(0, span.start - 1) : span.start]
    if before.isdigit() and re.match(r"'\d", text):
        mark = Span(span.source, span.start, span.start + 1)
        return Diagnostic("E001", "a number has no separators", mark, hint="leave the `'` out", edit=Edit(mark, ""))
    inner = text[1:-1] if len(text) > 1 and text[-1] in "'\"“”„‟" else text[1:]
    return Diagnostic(
        "E004",
        'a text stands in straight double quotes, "..."',
        span,
        hint='write "..."',
        edit=Edit(span, f'"{inner}"'),
    )


def _character(span: Span) -> Diagnostic:
    char = span.text[0]
    if char == "$":
        return _dollar(span)
    if char in _QUOTES:
        return _quote(span)
    if char in _WRITTEN:
        return Diagnostic("E001", f"`{char}` is not a sign of Pore", span, hint=_WRITTEN[char])
    ours = _ours(char)
    if ours is not None:
        shown = f"`{char}` (U+{ord(char):04X})" if char.isprintable() else f"the invisible character U+{ord(char):04X}"
        hint = f"write `{ours.strip()}`" if ours.strip() else "begin a new line" if ours else "leave it out"
        hint += ", or `\\` for a solid without another" if ours == "-" else ""
        return Diagnostic("E001", f"{shown} is not a sign of Pore", span, hint=hint, edit=Edit(span, ours))
    if char.isprintable() and char.isalpha():
        return _letter(span, char)
    if char.isprintable():
        return Diagnostic("E001", f"`{char}` is not a sign of Pore", span, hint="leave it out")
    message = f"the character U+{ord(char):04X} cannot stand in a program"
    return Diagnostic("E001", message, span, hint="save the file as plain text in UTF-8")


def _ours(char: str) -> str | None:
    """The sign of Pore that a character is another form of: "" for one that is not seen, None for none."""
    if char in LOOK_ALIKES:
        return LOOK_ALIKES[char]
    kind = unicodedata.category(char)
    if kind == "Pd":
        return "-"
    if kind == "Cf":
        return ""
    if kind in ("Zl", "Zp") or char == "\u0085":
        return "\n"
    if kind == "No" and 0 < (value := unicodedata.numeric(char)) < 1:  # a fraction
        return f"{value:.17g}"
    plain = unicodedata.normalize("NFKC", char)
    if char in "\u00b2\u00b3\u00b9\u2070" or "\u2074" <= char <= "\u2079":
        return f"^{plain}"
    return plain if plain.isascii() and plain.isprintable() else None


def _quote(span: Span) -> Diagnostic:
    """A quotation mark of another script, with the text that it opens, if the line has its end."""
    text, start = span.source.text, span.start
    line = text[start : (text.find("\n", start) + 1 or len(text) + 1) - 1]
    end = next((i for i, c in enumerate(line) if i and c in _QUOTES), None)
    edit = None if end is None else Edit(Span(span.source, start, start + end + 1), f'"{line[1:end]}"')
    shown = f'write `"{line[1:end]}"`' if end is not None else 'write "..."'
    return Diagnostic("E004", 'a text stands in straight double quotes, "..."', span, hint=shown, edit=edit)


def _letter(span: Span, char: str) -> Diagnostic:
    """A letter that names are not made of: the word it stands in, and how that is written without it."""
    text = span.source.text
    start = span.start
    while start > 0 and _WORD.fullmatch(text[start - 1]):
        start -= 1
    found = _WORD.match(text, start)
    end = found.end() if found else span.end
    spelt = "".join(_SPELT.get(c) or unicodedata.normalize("NFKD", c) for c in text[start:end])
    plain = "".join(c for c in spelt if not unicodedata.combining(c))
    message = f"`{char}` cannot stand in a name"
    if not (plain.isascii() and plain.isidentifier()):
        return Diagnostic("E001", message, span, hint="names are made of a-z, A-Z, 0-9 and _")
    hint = f"names are made of a-z, A-Z, 0-9 and _: write `{plain}`"
    return Diagnostic("E001", message, span, hint=hint, edit=Edit(Span(span.source, start, end), plain))


def _dollar(span: Span) -> Diagnostic:
    """`$fn = 64` of OpenSCAD, as a statement or as an argument."""
    text = span.source.text
    setting = _SETTING.match(text, span.start)
    if setting is None:
        hint = "names are made of a-z, A-Z, 0-9 and _: leave it out"
        return Diagnostic("E001", "`$` is not a sign of Pore", span, hint=hint, edit=Edit(span, ""))
    before = len(text[: span.start].rstrip())
    start = before - 1 if text[:before].endswith(",") else span.start
    return Diagnostic(
        "E001",
        f"`{setting[0].split('=')[0].strip()}` is a setting of OpenSCAD",
        Span(span.source, span.start, setting.end()),
        hint="leave it out: surfaces are exact, and `pore mesh --voxel 0.5mm` says how fine a mesh is",
        edit=Edit(Span(span.source, start, setting.end()), ""),
    )
