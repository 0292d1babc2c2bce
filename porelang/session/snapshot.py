"""What is known of a file at one moment, whatever its text: there is always a snapshot, also of a broken text."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property

from porelang.compiler import Compiled
from porelang.diagnostics import Diagnostic, PoreError
from porelang.elaborate.values import Value
from porelang.program import Program
from porelang.source import Source, Span
from porelang.syntax import tree
from porelang.syntax.parse import lexed
from porelang.syntax.tokens import LexedToken


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A file after an edit. `version` counts its edits; `good` is the program of the last text without errors that
    had something to show; `compiled` is all that compiling has found.

    An offset counts the characters of the text from 0. Places of statements follow the text as it is edited, so those
    of a file's last snapshot are right.
    """

    path: str
    version: int
    compiled: Compiled
    good: Program | None

    @property
    def source(self) -> Source:
        """The text."""
        return self.compiled.source

    @property
    def file(self) -> tree.File:
        """The statements that could be read, in order."""
        return self.compiled.file

    @property
    def program(self) -> Program | None:
        """The program of this text; None where there is an error in it."""
        return self.compiled.program

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """What compiling says, at once: all errors, and the warnings for which nothing has to be sampled."""
        return self.compiled.diagnostics

    @cached_property
    def all_diagnostics(self) -> tuple[Diagnostic, ...]:
        """What `pore check` says first: with the warnings that samples bear out. It may take seconds; it can be
        cancelled."""
        if self.program is None:
            return self.diagnostics
        try:
            return self.program.warnings
        except PoreError as error:
            start = Span(self.source, 0, 0)
            return tuple(d if d.span else Diagnostic(d.code, d.message, start, hint=d.hint) for d in error.diagnostics)

    @cached_property
    def tokens(self) -> tuple[LexedToken, ...]:
        """All that is written in the text but blanks and line ends, comments and documentation too, in order."""
        return tuple(t for t in lexed(self.source.text, comments=True) if t.type != "NEWLINE")

    def statement_at(self, offset: int) -> tree.Statement | None:
        """The statement that holds a character, or ends before it; None where there is none."""
        starts = self._starts
        i = bisect_right(starts, offset) - 1
        if i < 0:
            return None
        found = self.file.statements[i]
        return found if offset <= found.span.in_file.end else None

    def expressions_at(self, offset: int) -> list[tree.Expr]:
        """The expressions that hold a character, the outermost first."""
        statement = self.statement_at(offset)
        if statement is None:
            return []
        at = offset - statement.span.source.begins
        return [n for n in _holding(statement, at) if not isinstance(n, _NO_VALUES)]  # type: ignore[misc]  # the rest are expressions

    def value(self, expression: tree.Expr) -> Value | None:
        """What an expression came to when it was first evaluated; None where it was not, or is wrong."""
        return self.compiled.elaborated.values.get(expression.span)

    @cached_property
    def _starts(self) -> list[int]:
        return [s.span.in_file.start for s in self.file.statements]


#: What holds expressions and is none.
_NO_VALUES = (tree.Argument, tree.Clause, tree.Parameter, tree.Setting, tree.Let, tree.Def, tree.Out, tree.Param,
              tree.Use, tree.Check, tree.Preset)  # fmt: skip


def _holding(item: object, at: int) -> Iterator[object]:
    """The nodes of a tree that hold a character of its piece, the outermost first."""
    while item is not None:
        yield item
        item = next((part for part in _parts(item) if part.span.start <= at <= part.span.end), None)  # type: ignore[attr-defined]  # these have places


def _parts(item: object) -> Iterator[object]:
    """The nodes right below a node that have places, in the order of the text."""
    assert is_dataclass(item)
    for f in fields(item):
        value = getattr(item, f.name)
        for part in value if isinstance(value, tuple) else (value,):
            for one in part if isinstance(part, tuple) else (part,):
                if isinstance(one, tree.Clause):  # it has no place of its own
                    yield from _parts(one)
                elif is_dataclass(one) and not isinstance(one, Span):
                    yield one
