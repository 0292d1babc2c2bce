"""Symbols that are not Pore's: those of other languages, typographic ones, and characters that mean nothing."""

from __future__ import annotations

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

# Characters that a word processor, a web page or a keyboard puts for one of Pore's.
LOOK_ALIKES: dict[str, str] = {
    **dict.fromkeys("\u2212\u2013\u2014\u2010\u2011\uff0d", "-"),
    **dict.fromkeys("\u00d7\u00b7\u22c5\u2217", "*"),
    **dict.fromkeys("\u00f7\u2215\u2044", "/"),
    **dict.fromkeys("\u2229", "&"),
    **dict.fromkeys("\u222a", "|"),
    **dict.fromkeys("\u2216", "\\"),
    **dict.fromkeys("\u2018\u2019", '"'),
    "\u2264": "<=",
    "\u2265": ">=",
    "\u2260": "!=",
    "\u21d2": "=>",
    "\u2192": "=>",
    "\u2026": "..",
    "\u00b0": "deg",
    "\u00b5": "u",
    "\u03bc": "u",
    "\u03c0": "pi",
    "\u03c4": "tau",
    "\u00b2": "^2",
    "\u00b3": "^3",
    "\uff08": "(",
    "\uff09": ")",
    "\uff0c": ",",
    "\u200b": "",
    "\u2060": "",
}


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
    if char in LOOK_ALIKES:
        ours = LOOK_ALIKES[char]
        shown = f"`{char}` (U+{ord(char):04X})" if char.isprintable() else f"the invisible character U+{ord(char):04X}"
        hint = f"write `{ours}`" if ours else "leave it out"
        hint += ", or `\\` for a solid without another" if ours == "-" else ""
        return Diagnostic("E001", f"{shown} is not a sign of Pore", span, hint=hint, edit=Edit(span, ours))
    if char.isprintable() and char.isalpha():
        message = f"`{char}` cannot stand in a name"
        return Diagnostic("E001", message, span, hint="names are made of a-z, A-Z, 0-9 and _")
    if char.isprintable():
        return Diagnostic("E001", f"`{char}` is not a sign of Pore", span, hint="leave it out")
    message = f"the character U+{ord(char):04X} cannot stand in a program"
    return Diagnostic("E001", message, span, hint="save the file as plain text in UTF-8")
