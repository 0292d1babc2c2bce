"""What is wrong in a line, at its place in that line: the program around it is not what was typed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from porelang.diagnostics import Diagnostic, Label
from porelang.source import Source, Span


def pieces(statements: list[str | tuple[str, str]]) -> list[tuple[int, str]]:
    """Where each statement begins in the program, and its text; of a pair the first was not typed."""
    found, begins = [], 0
    for s in statements:
        hidden, text = ("", s) if isinstance(s, str) else s
        found.append((begins + len(hidden), text))
        begins += len(hidden) + len(text) + 1
    return found


def as_typed(found: Diagnostic, pieces: Sequence[tuple[int, str]], name: str) -> Diagnostic:
    """A diagnostic about a program of which each piece begins at a character of it, and was typed as this text."""
    span = None if found.span is None else _placed(found.span, pieces, name)
    others = tuple(Label(_placed(other.span, pieces, name), other.text) for other in found.others)
    return replace(found, span=span, others=others)


def _placed(span: Span, pieces: Sequence[tuple[int, str]], name: str) -> Span:
    here = span.in_file
    if here.source.name != name:  # of a file that the program uses
        return span
    for begins, text in pieces:
        if begins <= here.start and here.end <= begins + len(text):
            return Span(Source(name, text), here.start - begins, here.end - begins)
    return span
