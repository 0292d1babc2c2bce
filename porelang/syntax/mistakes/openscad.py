"""Solids as OpenSCAD writes them, where what is done stands before what it is done to: the same in Pore's order."""

from __future__ import annotations

import re

from porelang.diagnostics import Diagnostic, Edit, Label
from porelang.source import Span
from porelang.syntax import habits
from porelang.syntax.failure import Failure
from porelang.syntax.tokens import CLOSING, OPENING, Token

#: What joins the solids of a `{ }`, by the word before it.
_JOINTS = {"union": "|", "difference": "\\", "intersection": "&", "group": "|", "render": "|"}
#: Words before a solid that Pore writes behind it, or not at all.
_MODIFIERS = frozenset(
    ("translate", "rotate", "scale", "mirror", "linear_extrude", "rotate_extrude", "offset", "color", "hull",
     "minkowski", "resize", "multmatrix", "projection", "repeat", "ring", "twist", "shell", "extrude", "revolve")
)  # fmt: skip
_LONGEST = 200  # letters of a way out that is shown
_NUMBER = r"\s*(-?[\d.]+)\s*"
_LOOP = re.compile(rf"\s*(\w+)\s*=\s*\[{_NUMBER}:(?:{_NUMBER}:)?{_NUMBER}\]\s*")


class _Untold(Exception):  # noqa: N818 - what cannot be told
    """Something that has no short form in Pore."""


def before_its_solid(f: Failure) -> Diagnostic | None:
    """`translate([1, 2, 3]) sphere(5)`, `difference() { ... }`, `for (i=[0:5]) ...`, `module f(r) { ... }`."""
    if f.within:
        return None
    start = _start(f)
    word = f.tokens[start]
    if word.type not in ("NAME", "FOR") or (f.at <= start and word.type != "FOR"):
        return None
    if word.text not in _JOINTS.keys() | _MODIFIERS | {"for"} or f.tokens[start + 1].type != "LPAR":
        return None
    if word.type == "NAME" and (f.before.type != "RPAR" or f.found.type not in ("NAME", "LBRACE", "FOR")):
        return None
    tokens = f.tokens[start:-1]
    span = word.span.to(tokens[-1].span)
    try:
        text, rest = _solid(tokens)
        while rest and rest[0].type == "_SEP":
            rest = rest[1:]
        if rest:
            raise _Untold
    except (_Untold, IndexError):
        general = "write `sphere(5) |> translate([1, 2, 3])`, and `a | b`, `a & b`, `a \\ b` for solids that are joined"
        return _told(word, f.found, habits.hint(word.text) or general, None)
    text = _bare(text)
    shown = f"write `{text}`" if len(text) <= _LONGEST else "a solid comes first: `sphere(5) |> translate([1, 2, 3])`"
    return _told(word, f.found, shown, Edit(span, text))


def _bare(text: str) -> str:
    """A text without the parentheses that hold all of it."""
    depth = 0
    for i, char in enumerate(text):
        depth += (char == "(") - (char == ")")
        if depth == 0:
            return text[1:-1] if char == ")" and i == len(text) - 1 and text[0] == "(" else text
    return text


def module(f: Failure) -> Diagnostic | None:
    """`module f(r) { sphere(r); }`."""
    kinds = [t.type for t in f.tokens]
    if f.at != 1 or f.head.text != "module" or kinds[1:3] != ["NAME", "LPAR"]:
        return None
    try:
        end = _closing(f.tokens, 2)
        body, rest = _block(f.tokens[end + 1 : -1], "|")
    except (_Untold, IndexError):
        return None
    if rest:
        return None
    text = f"def {Span(f.head.span.source, f.tokens[1].span.start, f.tokens[end].span.end).text} = {_bare(body)}"
    hint = f"write `{text}`" if len(text) <= _LONGEST else "write `def f(r) = ...`"
    return Diagnostic(
        "E008",
        "`module` is not a word of Pore",
        f.head.span,
        hint=hint,
        edit=Edit(f.head.span.to(f.tokens[-2].span), text),
    )


def _told(word: Token, found: Token, hint: str, edit: Edit | None) -> Diagnostic:
    others = (Label(found.span, "and this is what it is done to"),) if found.span != word.span else ()
    return Diagnostic(
        "E038", f"`{word.text}` stands before its solid, as in OpenSCAD", word.span, "", others, hint, edit
    )


def _start(f: Failure) -> int:
    """Where the value of the statement begins: behind `let a =`, or at once."""
    kinds = [t.type for t in f.tokens[: f.at]]
    if kinds[:1] in (["LET"], ["OUT"], ["DEF"]) and "EQUAL" in kinds:
        depth = 0
        for i, kind in enumerate(kinds):
            depth += (kind in OPENING) - (kind in CLOSING)
            if kind == "EQUAL" and depth == 0:
                return min(i + 1, len(f.tokens) - 2)
    return 0


def _solid(tokens: list[Token]) -> tuple[str, list[Token]]:
    """The first solid of these tokens in Pore's words, and what is left of them."""
    word = tokens[0]
    if word.type == "LBRACE":
        return _block(tokens, "|")
    if word.type not in ("NAME", "FOR") or tokens[1].type != "LPAR":
        raise _Untold
    end = _closing(tokens, 1)
    inside, rest = _between(tokens[1], tokens[end]), tokens[end + 1 :]
    if word.text == "for":
        return _loop(inside, rest)
    if not rest or rest[0].type in ("_SEP", "RBRACE", "_COMMA"):
        return f"{word.text}({inside})", rest
    if word.text in _JOINTS:
        return _block(rest, _JOINTS[word.text])
    solid, rest = _solid(rest)
    return f"{solid}{_done(word.text, inside)}", rest


def _block(tokens: list[Token], joint: str) -> tuple[str, list[Token]]:
    """The solids of a `{ }`, joined."""
    if tokens[0].type != "LBRACE":
        return _solid(tokens)
    solids: list[str] = []
    rest = tokens[1:]
    while rest[0].type != "RBRACE":
        if rest[0].type == "_SEP":
            rest = rest[1:]
            continue
        solid, rest = _solid(rest)
        solids.append(solid)
    if not solids:
        raise _Untold
    return (solids[0] if len(solids) == 1 else f"({f' {joint} '.join(solids)})"), rest[1:]


def _loop(inside: str, rest: list[Token]) -> tuple[str, list[Token]]:
    match = _LOOP.fullmatch(inside)
    if match is None:
        raise _Untold
    name, first, second, last = match.groups()
    step = float(second) if second else 1.0
    numbers = (float(first), float(last), step)
    if step == 0 or any(n != int(n) for n in numbers):
        raise _Untold
    low, high, by = (int(n) for n in numbers)
    end = high + (1 if by > 0 else -1)  # `[0:5]` holds 5
    bounds = f"{low}, {end}, {by}" if by != 1 else f"{low}, {end}" if low else f"{end}"
    solid, rest = _block(rest, "|")
    return f"union([for {name} in range({bounds}): {solid}])", rest


def _done(word: str, inside: str) -> str:
    """What is done to a solid, as a step behind it."""
    if word == "color":
        return ""
    if word == "rotate_extrude" and not inside.strip():
        return " |> revolve()"
    if word == "linear_extrude":
        match = re.fullmatch(r"\s*(?:height|h)?\s*=?\s*([\w.*/+-]+)\s*(?:,\s*center\s*=\s*\w+\s*)?", inside)
        if match is None:
            raise _Untold
        return f" |> extrude({match[1]})"
    if word == "offset":
        match = re.fullmatch(r"\s*(?:r|delta)?\s*=?\s*([\w.*/+-]+)\s*", inside)
        if match is None:
            raise _Untold
        return f" |> offset({match[1]})"
    if word == "rotate":
        return _turned(inside)
    if word not in ("translate", "scale", "mirror", "repeat", "ring", "twist", "shell", "extrude", "revolve"):
        raise _Untold
    vector = re.sub(r"^\s*v\s*=\s*", "", inside)
    return f" |> {word}({vector})"


def _turned(inside: str) -> str:
    """`[0, 0, 45]`, or `45`, or `a=45, v=[0, 0, 1]`: turns in degrees round the axes, that round x first."""
    match = re.fullmatch(r"\s*(?:a\s*=\s*)?\[([^][,]+),([^][,]+),([^][,]+)\]\s*", inside)
    if match is not None:
        turns = [t.strip() for t in match.groups()]
    elif re.fullmatch(r"\s*(?:a\s*=\s*)?-?[\w.]+\s*", inside):
        turns = ["0", "0", inside.split("=")[-1].strip()]
    else:
        match = re.fullmatch(r"\s*a\s*=\s*([^,]+),\s*v\s*=\s*(\[[^]]+\])\s*", inside)
        if match is None:
            raise _Untold
        return f" |> rotate({match[2]}, {_degrees(match[1].strip())})"
    axes = ("[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]")
    return "".join(f" |> rotate({axis}, {_degrees(t)})" for axis, t in zip(axes, turns, strict=True) if t != "0")


def _degrees(text: str) -> str:
    if re.fullmatch(r"-?[\d.]+", text):
        return f"{text}deg"
    return f"{text} * 1deg" if text.isidentifier() else f"({text}) * 1deg"


def _closing(tokens: list[Token], at: int) -> int:
    """Where the bracket closes that opens at `at`."""
    depth = 0
    for i in range(at, len(tokens)):
        depth += (tokens[i].type in OPENING) - (tokens[i].type in CLOSING)
        if depth == 0:
            return i
    raise _Untold


def _between(opened: Token, closed: Token) -> str:
    return Span(opened.span.source, opened.span.end, closed.span.start).text
