"""The program that a session of the REPL has written so far, and what a line adds to it or asks of it."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count

from porelang.diagnostics import Diagnostic, PoreError, fail
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


_PARTED = re.compile(r"\n[ \t]*\n")


@dataclass(frozen=True)
class State:
    """What the program is called, in messages and as that beside which files are sought; the statements so far, each
    its text by what it binds; what params are set to; the program that they make; the expression that was asked for
    last, and the last that may be a part; remarks that no statement has followed yet; whether pictures may have
    colours, and the page that shows all of it."""

    session: Session
    name: str = NAME
    statements: dict[str, str] = dataclasses.field(default_factory=dict)
    settings: dict[str, str] = dataclasses.field(default_factory=dict)
    program: Program | None = None
    last: str = ""
    field: str = ""
    remarks: str = ""
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
    """What a line came to: the state from now on, what is wrong or doubtful, the value that it asks for, with the
    program that has it, and its name there, and the checks that it writes, by the names of their statements."""

    state: State
    diagnostics: tuple[Diagnostic, ...] = ()
    value: Value | None = None
    program: Program | None = None
    name: str = ""
    checks: tuple[str, ...] = ()

    @property
    def design(self) -> Design:
        """The program that has the value, with its params set."""
        assert self.program is not None
        return self.program.design(self.state.settings)

    def typed(self, found: Diagnostic) -> Diagnostic:
        """What is wrong with the value, in words and at a place of the line that asks for it."""
        last = self.state.last
        places = pieces([*self.state.statements.values(), (f"out {self.name} = ", last)])
        renamed = replace(found, message=found.message.replace(f"`{self.name}`", f"`{last}`"))
        return as_typed(renamed, places, self.state.name)


def said(state: State, line: str, part: bool = False) -> Said:
    """A line that is no command: statements are added to the program, one that binds what is bound already takes its
    place, and an expression is asked for its value; of a file it is its `part`. What is wrong changes nothing."""
    file, wrong = parse(Source(state.name, line))
    if wrong:
        return Said(state, tuple(wrong))
    if not file.statements and line.strip():  # of what follows it
        return Said(replace(state, remarks="".join(f"{r}\n" for r in (state.remarks + line).rstrip().split("\n"))))
    statements, question, checks, remarks = dict(state.statements), "", list[str](), state.remarks
    for s, (text, begins) in zip(file.statements, _texts(line, file.statements), strict=True):
        if isinstance(s, tree.Out) and not s.name_span.text and part:
            statements["part"] = f"{text[:begins]}out part = {text[begins:]}"
        elif isinstance(s, tree.Out) and not s.name_span.text:
            question = s.value.span.text
        else:
            key = _key(s, statements, text)
            statements[key] = (remarks or _remarks(statements.get(key, ""), text)) + text
            checks += [key] if isinstance(s, tree.Check) else []
            remarks = ""
    text = "".join(f"{s}\n" for s in statements.values())
    taken = {*statements, *(t.text for t in lexed(question))}
    it = next(name for name in ("it" + "_" * n for n in count()) if name not in taken)
    asking = f"let {it} = {question}\n" if question else ""
    snapshot = state.session.update(state.name, text + asking)
    typed = pieces([*statements.values(), *([(f"let {it} = ", question)] if question else [])], line)
    told = tuple(as_typed(d, typed, state.name) for d in snapshot.diagnostics if d.code != "W220")
    told = tuple(replace(d, hint="") if f"`{it}`" in d.hint else d for d in told)  # nobody has typed that name
    if snapshot.program is None:
        return Said(state, told)
    params = snapshot.program.params
    typed_anew = {s.name for s in file.statements if isinstance(s, tree.Param)}
    settings = {name: value for name, value in state.settings.items() if name in params and name not in typed_anew}
    told += tuple(
        Diagnostic("", f"`{name}` is what this line says, and not {state.settings[name]} any more", severity="note")
        for name in state.settings if name in typed_anew
    )  # fmt: skip
    for name, setting in list(settings.items()):
        try:
            snapshot.program.design({name: setting})
        except PoreError:
            del settings[name]
            said_ = f"`{name}` is what the program says, and not {setting} any more, which lies outside of it now"
            told += (Diagnostic("", said_, severity="note"),)
    new = replace(state, statements=statements, settings=settings, program=snapshot.program, remarks=remarks)
    if new.field and not question and state.session.update(state.name, new.with_part).program is None:
        new = replace(new, field="")  # it names what is gone, or is something else now
    last = snapshot.file.statements[-1] if question else None
    value = snapshot.value(last.value) if isinstance(last, tree.Let) else None
    if value is None or isinstance(value, Poison):
        return Said(new, told, checks=tuple(checks))
    program = snapshot.program
    if isinstance(value, Scalar) and value.node.axes:  # a field may be a part
        new = replace(new, field=question)
        program = state.session.update(state.name, f"{text}out {it} = {question}\n").program or program
    return Said(replace(new, last=question), told, value, program, it, tuple(checks))


def _key(s: tree.Statement, known: dict[str, str], text: str) -> str:
    """What a statement takes the place of."""
    if isinstance(s, tree.Check):
        same = next((name for name, other in known.items() if name.startswith("check ") and other == text), None)
        return same or next(name for name in (f"check {n}" for n in count(1)) if name not in known)
    return f"preset {s.name}" if isinstance(s, tree.Preset) else s.name


def _texts(line: str, statements: tuple[tree.Statement, ...]) -> Iterator[tuple[str, int]]:
    """The text of each statement and where in it the statement begins: with the remarks above it and behind it, and an
    empty line that parts it from the one before; remarks at the end belong to the last."""
    starts = [0, *(_line_end(line, s.span.in_file.end) for s in statements[:-1])]
    for s, start, end in zip(statements, starts, [*starts[1:], len(line)], strict=False):
        whole = line[start:end].rstrip()
        text, parted = whole.lstrip("\n"), "\n" if _PARTED.match(whole) else ""
        yield parted + text, len(parted) + s.span.in_file.start - start - (len(whole) - len(text))


def _line_end(text: str, at: int) -> int:
    end = text.find("\n", at)
    return len(text) if end < 0 else end


def _remarks(before: str, now: str) -> str:
    """The remarks that stood above a statement, where the one that takes its place has none."""
    lines = before.split("\n")
    count_ = next((i for i, text in enumerate(lines) if text.strip() and not text.lstrip().startswith("#")), 0)
    return "" if now.lstrip().startswith("#") else "".join(f"{text}\n" for text in lines[:count_])
