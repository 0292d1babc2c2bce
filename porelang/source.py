"""A source text, its pieces, and places in it."""

from __future__ import annotations

import re
from bisect import bisect_right
from dataclasses import dataclass, field
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

    @property
    def whole(self) -> Source:
        """The file that this text is of: itself, unless it is a piece of one."""
        return self

    @property
    def begins(self) -> int:
        """At which character of that file this text begins."""
        return 0

    def __repr__(self) -> str:
        return f"<source {self.name}: {len(self.text)} characters>"


@dataclass(slots=True)
class Home:
    """The file that a piece is of now, and where in it the piece begins."""

    whole: Source
    begins: int


@dataclass(frozen=True, eq=False)
class Piece(Source):
    """The text of one statement of a file. Where it lies may change while the file is edited: what is known of the
    statement stays, and places in it are told as those of the file as it is now.

    >>> file = Source("a.pore", "let a = 1\nlet b = 2")
    >>> second = Piece("a.pore", "let b = 2", home=Home(file, 10))
    >>> second.position(4)
    (2, 5)
    >>> second.moves(Source("a.pore", "let b = 2"), 0)
    >>> second.position(4)
    (1, 5)
    """

    home: Home = field(default_factory=lambda: Home(Source("", ""), 0))

    def moves(self, whole: Source, begins: int) -> None:
        """From now on it is at character `begins` of this file."""
        self.home.whole, self.home.begins = whole, begins

    @property
    def whole(self) -> Source:
        return self.home.whole

    @property
    def begins(self) -> int:
        return self.home.begins

    def position(self, offset: int) -> tuple[int, int]:
        return self.whole.position(self.begins + offset)

    def line(self, number: int) -> str:
        return self.whole.line(number)

    def __repr__(self) -> str:
        return f"<piece of {self.name}: {len(self.text)} characters>"


@dataclass(frozen=True, slots=True)
class Span:
    """The half-open range of characters `start..end` of a source, which may be a piece of a file."""

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
    def in_file(self) -> Span:
        """The same place, by the characters of its file."""
        begins = self.source.begins
        return Span(self.source.whole, begins + self.start, begins + self.end)

    @property
    def line(self) -> int:
        return self.source.position(self.start)[0]

    @property
    def column(self) -> int:
        return self.source.position(self.start)[1]

    def __str__(self) -> str:
        line, column = self.source.position(self.start)
        return f"{self.source.name}:{line}:{column}"
