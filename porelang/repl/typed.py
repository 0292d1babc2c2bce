"""What is wrong in a line, at its place in that line: the program around it is not what was typed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from porelang.diagnostics import Diagnostic, Label
from porelang.source import Source, Span


@dataclass(frozen=True, slots=True)
class Piece:
    """What was typed of a program from the character `begins` on: `text`, which stands in `line` from `shift` on."""

    begins: int
    text: str
    line: str
    shift: int = 0


def pieces(statements: Iterable[str | tuple[str, str]], line: str = "") -> list[Piece]:
    """The statements of a program as they were typed; of a pair the first was not. What stands in `line` is a part of
    it, else each statement was a line of its own."""
    found, begins = [], 0
    for s in statements:
        hidden, text = ("", s) if isinstance(s, str) else s
        at = line.find(text.strip("\n")) if text else -1
        lead = len(text) - len(text.lstrip("\n"))
        whole, shift = (line, at - lead) if at >= lead else (text.lstrip("\n"), -lead)
        found.append(Piece(begins + len(hidden), text, whole, shift))
        begins += len(hidden) + len(text) + 1
    return found


def as_typed(found: Diagnostic, pieces: Sequence[Piece], name: str) -> Diagnostic:
    """A diagnostic about a program at its place in what was typed."""
    span = None if found.span is None else _placed(found.span, pieces, name)
    others = tuple(Label(_placed(other.span, pieces, name), other.text) for other in found.others)
    return replace(found, span=span, others=others)


def _placed(span: Span, pieces: Sequence[Piece], name: str) -> Span:
    here = span.in_file
    if here.source.name != name:  # of a file that the program uses
        return span
    for piece in pieces:
        if piece.begins <= here.start and here.end <= piece.begins + len(piece.text):
            moved = piece.shift - piece.begins
            return Span(Source(name, piece.line), max(here.start + moved, 0), max(here.end + moved, 0))
    return span
