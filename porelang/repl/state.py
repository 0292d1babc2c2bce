"""The program that a session of the REPL has written so far, and what a line adds to it or asks of it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, replace
from itertools import count

from porelang.diagnostics import Diagnostic, fail
from porelang.elaborate.values import Poison, Scalar, Value
from porelang.program import Design, Program
from porelang.repl.typed import as_typed, pieces
from porelang.repl.view import View
from porelang.session import Session
from porelang.source import Source
from porelang.syntax import tree
from porelang.syntax.parse import lexed, parse
from porelang.syntax.tokens import CLOSING, CONTINUING, OPENING, UNFINISHED

#: What the text of a session is called in messages.
NAME = "<repl>"


def is_incomplete(text: str) -> bool:
    """Whether a text is to go on in a further line: a bracket is open, or it ends where the language goes on.

    >>> is_incomplete("let a = sphere(3) |>"), is_incomplete("let a = {"), is_incomplete("let a = 1")
    (True, True, False)
    """
    depth, last = 0, ""
    for token in lexed(text):
        depth += (token.type in OPENING) - (token.type in CLOSING)
        last = last if token.type == "NEWLINE" else token.type
    return depth > 0 or last in UNFINISHED or last == "DOC"  # what is documented follows


def goes_on(line: str) -> bool:
    """Whether a line goes on with the one before it, by how it begins.

    >>> goes_on("  |> shell(1)"), goes_on("let a = 1")
    (True, False)
    """
    first = next((t.type for t in lexed(line) if t.type not in ("NEWLINE", "DOC")), "")
    return first in CONTINUING and not line.lstrip().startswith(":")  # else it is a command


@dataclass(frozen=True)
class State:
    """The statements so far, each its text by what it binds; what params are set to; the program that they make; the
    expression that was asked for last, and the last that may be a part; whether pictures may have colours, and the page
    that shows all of it."""

    session: Session
    statements: dict[str, str] = dataclasses.field(default_factory=dict)
    settings: dict[str, str] = dataclasses.field(default_factory=dict)
    program: Program | None = None
    last: str = ""
    field: str = ""
    colours: bool = False
    page: View | None = None

    @property
    def text(self) -> str:
        """The program as a file."""
        return "".join(f"{s}\n" for s in self.statements.values())

    @property
    def with_part(self) -> str:
        """The same, whose part is what was asked for last where it has no output."""
        none = self.program is None or not self.program.outputs
        return f"{self.text}{self.field}\n" if none and self.field else self.text

    @property
    def design(self) -> Design:
        """The program with its params set. Errors: those of settings; E100 where nothing was written yet."""
        if self.program is None:
            raise fail("E100", "nothing has been written yet", hint="write a statement, as in `let a = gyroid(10)`")
        return self.program.design(self.settings)


@dataclass(frozen=True, slots=True)
class Said:
    """What a line came to: the state from now on, what is wrong or doubtful, and the value that it asks for, with the
    program that has it, and its name there."""

    state: State
    diagnostics: tuple[Diagnostic, ...] = ()
    value: Value | None = None
    program: Program | None = None
    name: str = ""

    @property
    def design(self) -> Design:
        """The program that has the value, with its params set."""
        assert self.program is not None
        return self.program.design(self.state.settings)

    def typed(self, found: Diagnostic) -> Diagnostic:
        """What is wrong with the value, in words and at a place of the line that asks for it."""
        last = self.state.last
        places = pieces([*self.state.statements.values(), (f"out {self.name} = ", last)])
        return as_typed(replace(found, message=found.message.replace(f"`{self.name}`", f"`{last}`")), places, NAME)


def said(state: State, line: str, part: bool = False) -> Said:
    """A line that is no command: statements are added to the program, one that binds what is bound already takes its
    place, and an expression is asked for its value; of a file it is its `part`. What is wrong changes nothing."""
    file, wrong = parse(Source(NAME, line))
    if wrong:
        return Said(state, tuple(wrong))
    statements, question = dict(state.statements), ""
    for s in file.statements:
        if isinstance(s, tree.Out) and not s.name_span.text and part:
            statements["part"] = f"out part = {s.value.span.text}"
        elif isinstance(s, tree.Out) and not s.name_span.text:
            question = s.value.span.text
        else:
            statements[_key(s, statements)] = _with_doc(s)
    text = "".join(f"{s}\n" for s in statements.values())
    it = next(name for name in ("it" + "_" * n for n in count()) if name not in statements)
    asking = f"let {it} = {question}\n" if question else ""
    snapshot = state.session.update(NAME, text + asking)
    typed = pieces([*statements.values(), *([(f"let {it} = ", question)] if question else [])])
    told = tuple(as_typed(d, typed, NAME) for d in snapshot.diagnostics if d.code != "W220")
    if snapshot.program is None:
        return Said(state, told)
    params = snapshot.program.params
    settings = {name: value for name, value in state.settings.items() if name in params}
    new = replace(state, statements=statements, settings=settings, program=snapshot.program)
    if new.field and not question and state.session.update(NAME, new.with_part).program is None:
        new = replace(new, field="")  # it names what is gone, or is something else now
    last = snapshot.file.statements[-1] if question else None
    value = snapshot.value(last.value) if isinstance(last, tree.Let) else None
    if value is None or isinstance(value, Poison):
        return Said(new, told)
    program = snapshot.program
    if isinstance(value, Scalar) and value.node.axes:  # a field may be a part
        new = replace(new, field=question)
        program = state.session.update(NAME, f"{text}out {it} = {question}\n").program or program
    return Said(replace(new, last=question), told, value, program, it)


def _key(s: tree.Statement, known: dict[str, str]) -> str:
    """What a statement takes the place of."""
    if isinstance(s, tree.Check):
        return next(name for name in (f"check {n}" for n in count(1)) if name not in known)
    return f"preset {s.name}" if isinstance(s, tree.Preset) else s.name


def _with_doc(s: tree.Statement) -> str:
    """The text of a statement, with the documentation above it."""
    doc = s.doc if isinstance(s, tree.Def) else ""
    return "".join(f"## {line}\n" for line in doc.split("\n") if doc) + s.span.text
