"""The outline of a text: what it declares, what can be folded, and what each of its tokens is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from porelang.assist.names import Bound, is_function, uses, value_of
from porelang.assist.shown import number_of
from porelang.elaborate.values import Poison, Record, stage
from porelang.ir import Stage
from porelang.session import Snapshot
from porelang.source import Span
from porelang.syntax import tree
from porelang.syntax.tokens import OPERATORS, STATEMENTS

Word = Literal["keyword", "number", "string", "comment", "operator", "function", "parameter", "variable", "property",
               "namespace", "type"]  # fmt: skip
#: The terminals that are words of the language.
_KEYWORDS = STATEMENTS | {"IF", "THEN", "ELSE", "FOR", "IN", "WHERE", "AND", "OR", "NOT", "TRUE", "FALSE"}
_OPERATORS = (OPERATORS | {"MINUS", "TILDE", "EQUAL", "ARROW", "DOTS"}) - {"AND", "OR"}


@dataclass(frozen=True, slots=True)
class Symbol:
    """A declaration: its name, what it is (param, let, def, use, out, check, preset), a line about it, all of its text
    and its name's place."""

    name: str
    what: str
    detail: str
    span: Span
    name_span: Span


def symbols(snapshot: Snapshot) -> list[Symbol]:
    """What a file declares, in order."""
    found = []
    for s in snapshot.file.statements:
        what = type(s).__name__.lower()
        if isinstance(s, tree.Check):
            found.append(
                Symbol(s.message, what, " ".join(s.condition.span.text.split()), s.span.in_file, s.span.in_file)
            )
            continue
        detail = f"({', '.join(p.name for p in s.parameters)})" if isinstance(s, tree.Def) else ""
        if isinstance(s, tree.Param):
            detail = s.doc
        found.append(Symbol(s.name, what, detail, s.span.in_file, s.name_span.in_file))
    return found


def folds(snapshot: Snapshot) -> list[tuple[int, int, str]]:
    """The first and the last line (from 1) of what can be folded, and whether it is a "region" or a "comment"."""
    text = snapshot.source
    found = []
    for s in snapshot.file.statements:
        first, last = (text.position(at)[0] for at in (s.span.in_file.start, s.span.in_file.end))
        if last > first:
            found.append((first, last, "region"))
    lines = [
        text.position(t.start)[0] for t in snapshot.tokens if t.type in ("COMMENT", "DOC") and _alone(snapshot, t.start)
    ]
    first = previous = -1
    for line in [*lines, -9]:
        if line != previous + 1:
            if previous > first > 0:
                found.append((first, previous, "comment"))
            first = line
        previous = line
    return sorted(found)


def _alone(snapshot: Snapshot, start: int) -> bool:
    text = snapshot.source.text
    return not text[text.rfind("\n", 0, start) + 1 : start].strip()


@dataclass(frozen=True, slots=True)
class Said:
    """What a token is, and what more: declaration, the language's own, when its value is known."""

    start: int
    length: int
    word: Word
    more: tuple[str, ...] = ()


def semantic(snapshot: Snapshot) -> list[Said]:
    """What each token of a text is, in order; a broken text has its words, numbers and remarks still."""
    names = {use.span.in_file.start: use for use in uses(snapshot)}
    found = []
    tokens = snapshot.tokens
    for i, t in enumerate(tokens):
        word: Word | None = None
        more: tuple[str, ...] = ()
        if t.type in _KEYWORDS or (t.type == "NAME" and t.text in ("as", "step", "preset") and t.start not in names):
            word = "keyword"
        elif t.type in ("COMMENT", "DOC"):
            word, more = "comment", ("documentation",) if t.type == "DOC" else ()
        elif t.type in ("NUMBER", "STRING"):
            word = "number" if t.type == "NUMBER" else "string"
        elif t.type in _OPERATORS:
            word = "operator"
        elif t.type == "NAME":
            use = names.get(t.start)
            if use is not None and use.bound is not None:
                word, more = _name(snapshot, use.bound, use.binds)
            elif i and tokens[i - 1].type == "DOT":
                word = "property"
            elif i and tokens[i - 1].type in ("COLON", "BAR"):
                word = "type"
            else:
                word = "variable"
        if word is not None:
            found.append(Said(t.start, len(t.text), word, more))
    return found


def _name(snapshot: Snapshot, bound: Bound, binds: bool) -> tuple[Word, tuple[str, ...]]:
    more = ("declaration",) if binds else ()
    if bound.kind == "prelude":
        more = (*more, "defaultLibrary")
    if bound.kind == "use" or isinstance(bound.value, Record):
        return "namespace", more
    if is_function(bound):
        return "function", more
    if bound.kind in ("parameter", "item"):
        return "parameter", more
    if bound.kind == "param":
        return "variable", (*more, "readonly")
    value = value_of(snapshot, bound)
    known = value is not None and not isinstance(value, Poison) and stage(value) is not Stage.FIELD
    return "variable", (*more, "readonly") if known else more


def hints(snapshot: Snapshot) -> Iterator[tuple[int, str]]:
    """What may be shown behind a `let` that is one number and is not written as one: where, and `= 12.3MPa`."""
    design = None if snapshot.good is None else snapshot.good.design()
    for s in snapshot.file.statements:
        if isinstance(s, tree.Let) and not isinstance(s.value, tree.Number):
            value = snapshot.compiled.elaborated.values.get(s.value.span)
            said = number_of(value, design)
            if said is not None:
                yield s.value.span.in_file.end, f"= {said}"
