"""A source text and places in it."""

from __future__ import annotations

import re
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property


@dataclass(frozen=True, eq=False)
class Source:
    """A named text: a file, a line typed into the REPL, or a part of the prelude.

    A carriage return alone ends a line too, as on old machines: it becomes the usual end, and no place changes.
    """

    name: str
    text: str
    prelude: bool = False

    def __post_init__(self) -> None:
        if "\r" in self.text:
            object.__setattr__(self, "text", re.sub(r"\r(?!\n)", "\n", self.text))

    @cached_property
    def line_starts(self) -> tuple[int, ...]:
        starts = [0]
        starts.extend(i + 1 for i, char in enumerate(self.text) if char == "\n")
        return tuple(starts)

    def position(self, offset: int) -> tuple[int, int]:
        """Line and column of a character offset, both counted from 1."""
        line = bisect_right(self.line_starts, offset)
        return line, offset - self.line_starts[line - 1] + 1

    def line(self, number: int) -> str:
        """The text of a line (counted from 1) without its line end."""
        start = self.line_starts[number - 1]
        end = self.text.find("\n", start)
        return self.text[start : len(self.text) if end < 0 else end].rstrip("\r")

    def __repr__(self) -> str:
        return f"<source {self.name}: {len(self.text)} characters>"


@dataclass(frozen=True, slots=True)
class Span:
    """The half-open range of characters `start..end` of a source."""

    source: Source
    start: int
    end: int

    def __repr__(self) -> str:
        return f"<{self}>"

    def to(self, other: Span) -> Span:
        """The smallest span that covers this one and `other` (of the same source)."""
        return Span(self.source, min(self.start, other.start), max(self.end, other.end))

    @property
    def text(self) -> str:
        return self.source.text[self.start : self.end]

    @property
    def line(self) -> int:
        return self.source.position(self.start)[0]

    @property
    def column(self) -> int:
        return self.source.position(self.start)[1]

    def __str__(self) -> str:
        line, column = self.source.position(self.start)
        return f"{self.source.name}:{line}:{column}"
