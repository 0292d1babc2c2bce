"""What a line that begins with a colon does: a table, a row each, in the order of `:help`."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO

from porelang.assist.hover import documented
from porelang.assist.shown import signature
from porelang.atomic import save
from porelang.backends.glsl import shader
from porelang.diagnostics import PoreError, fail, render, suggest
from porelang.elaborate.prelude import prelude_scope
from porelang.elaborate.values import Scalar, Value, describe
from porelang.ir import Stage, show
from porelang.repl.checked import refused
from porelang.repl.shown import shown
from porelang.repl.state import Said, State, said
from porelang.repl.typed import as_typed, pieces
from porelang.source import Source
from porelang.syntax.format import formatted
from porelang.syntax.parse import lexed

#: What a command gives: the state from now on, and a text.
Answer = tuple[State, str]


@dataclass(frozen=True, slots=True)
class Command:
    """A command: its name, what stands behind it, what it does, and what does it."""

    name: str
    takes: str
    doc: str
    run: Callable[[State, str], Answer]


def asked(state: State, words: str) -> Said:
    """An expression, or without words what was asked for last, and what it came to. Errors: those of its text; E108
    where it is none."""
    words = words or state.last or ("part" if "part" in state.statements else "")
    if not words:
        raise fail("E108", "nothing was asked for yet", hint="name an expression, as in `:type gyroid(10) & sphere(9)`")
    found = said(state, words)
    if any(d.severity == "error" for d in found.diagnostics):
        raise PoreError([d for d in found.diagnostics if d.severity == "error"])
    if found.value is None:
        raise fail("E108", f"`{words}` is no expression", hint="as in `:type gyroid(10) & sphere(9)`")
    return found


def _help(state: State, _: str) -> Answer:
    width = max(len(f"{c.name} {c.takes}") for c in COMMANDS.values())
    lines = [f"  {f'{c.name} {c.takes}':<{width}}  {c.doc}" for c in COMMANDS.values()]
    return state, "\n".join(["A statement is added to the program; an expression is asked for its value.", *lines])


def _type(state: State, words: str) -> Answer:
    value = asked(state, words).value
    assert value is not None
    return state, describe(value)


def _ir(state: State, words: str) -> Answer:
    value = asked(state, words).value
    if not isinstance(value, Scalar):
        raise fail("E108", "the graph is that of a number or a field", hint="as in `:ir gyroid(10)`")
    return state, show({words or state.last: value.node})


def _glsl(state: State, words: str) -> Answer:
    found = asked(state, words)
    program = found.design.program
    return state, shader(program.field_roots(found.name), program.ranges, "grid").text.rstrip()


def _set(state: State, words: str) -> Answer:
    name, is_set, value = (part.strip() for part in words.partition("="))
    if not name:
        infos = state.design.program.params
        lines = [f"{n} = {infos[n].shown(v)} in {infos[n].range}" for n, v in state.design.settings.items()]
        return state, "\n".join(lines) or "there is no param yet: `param w = 10mm in 5mm..20mm`"
    if not is_set:
        name, _, meant = name.partition(" ")
        raise fail(
            "E108",
            f"`:set {words}` has no `=`" if meant else f"`:set {name}` says no value",
            hint=f"write `:set {name} = {meant.strip() or '3mm'}`, or `:set {name} =` for its default",
        )
    if not value:
        new = replace(state, settings={k: v for k, v in state.settings.items() if k != name})
        info = new.design.program.params.get(name)
        if info is None:
            raise fail("E108", f"there is no param `{name}`", hint=":set alone lists them")
        return new, f"{name} = {info.shown(new.design.settings[name])}"
    new = replace(state, settings={**state.settings, name: value})
    try:
        design = new.design
    except PoreError as error:
        typed = pieces(state.statements.values())
        raise PoreError([as_typed(d, typed, state.name) for d in error.diagnostics]) from None
    return new, f"{name} = {design.program.params[name].shown(design.settings[name])}"


def _doc(state: State, words: str) -> Answer:
    if not words:
        raise fail("E108", "`:doc` names a function", hint="as in `:doc gyroid`")
    value = prelude_scope().find(words) or asked(state, words).value
    found = signature(value, words)
    if found is None:
        raise fail("E108", f"`{words}` is no function", hint=":type says what it is")
    return state, f"{found}\n\n{documented(found).replace('```pore', '').replace('```', '').strip()}"


def _slice(state: State, words: str) -> Answer:
    found = asked(state, words)
    return found.state, shown(found, True, state.colours)


def _mesh(state: State, words: str) -> Answer:
    path, expression = _named(words)
    if not path:
        hint = "write `:mesh part.stl`, or `:mesh part.stl gyroid(10) & cube(20)`"
        raise fail("E108", "`:mesh` names a file", hint=hint)
    from porelang.mesh import write
    from porelang.mesh.export import writer_of
    from porelang.mesh.made import make
    from porelang.mesh.report import facts, text

    writer_of(path)
    found = asked(state, expression)
    if not _is_field(found.value):
        assert found.value is not None
        raise fail("E108", f"`{expression or state.last}` is {describe(found.value)}, and no part",
                   hint="a part is a field, negative where it is solid, as in `:mesh part.stl sphere(9)`")  # fmt: skip
    if broken := refused(state):
        raise PoreError(broken)
    begun = time.perf_counter()
    made = make(found.design, found.name)
    write(made.surface, path)
    numbers = facts(made.surface) | made.facts | {"seconds": time.perf_counter() - begun, "backend": "numpy"}
    return found.state, "\n".join([*(render(found.typed(d)) for d in made.doubts), text(path, numbers)])


def _is_field(value: Value | None) -> bool:
    return isinstance(value, Scalar) and value.node.stage is Stage.FIELD


def _named(words: str) -> tuple[str, str]:
    """The name of a file, in quotes where it has blanks, and the rest."""
    quote = words[:1]
    if quote in ("'", '"') and quote in words[1:]:
        path, _, rest = words[1:].partition(quote)
    else:
        path, _, rest = words.partition(" ")
    return path, rest.strip()


def _save(state: State, words: str) -> Answer:
    path = _named(words)[0] or "part.pore"
    said_too = []
    if state.with_part != state.text:
        said_too.append(f"its part is `{state.field}`, which was asked for last")
    if state.settings:
        said_too.append(f"not in it: {', '.join(f'{n} = {v}' for n, v in state.settings.items())}, as was set here")
    beside = os.path.dirname(state.name)
    if _reads(state) and os.path.realpath(os.path.dirname(path) or ".") != os.path.realpath(beside or "."):
        raise fail("E113", f"what the program reads lies in `{beside or '.'}`, and would not be found from `{path}`",
                   hint=f"write it there: `:save {os.path.join(beside, os.path.basename(path))}`")  # fmt: skip
    text = formatted(Source(path, state.with_part))
    if Path(path).exists():
        raise fail("E113", f"`{path}` is there already", hint="name another file: nothing is written over here")
    save(path, lambda file: _write(file, text))
    count = len(state.statements)
    return state, "; ".join([f"{path}: {count} statement{'s' * (count != 1)}", *said_too])


def _reads(state: State) -> bool:
    """Whether the program reads files beside it, by names that begin there."""
    named = (t.text.strip('"') for t in lexed(state.text) if t.type == "STRING")
    beside = os.path.dirname(state.name)
    return any("." in name and not os.path.isabs(name) and os.path.isfile(os.path.join(beside, name)) for name in named)


def _write(file: BinaryIO, text: str) -> None:
    file.write(text.encode())


def _time(state: State, words: str) -> Answer:
    begun = time.perf_counter()
    found = asked(state, words)
    compiled = time.perf_counter() - begun
    begun = time.perf_counter()
    text = shown(found, False)
    looked = time.perf_counter() - begun
    return state, f"{text}\ncompiled in {1e3 * compiled:.1f} ms, looked at in {1e3 * looked:.0f} ms"


def _view(state: State, words: str) -> Answer:
    if words:
        state = asked(state, words).state
    if state.with_part == "":
        raise fail("E100", "nothing has been written yet", hint="write a part, as in `gyroid(10) & cube(20)`")
    if state.page is None:
        raise fail("E108", "there is no page here", hint="`pore view` shows a file")
    address = state.page.show(state.with_part, state.settings, os.path.dirname(state.name))
    return state, f"{address} follows what is written here, and ends with it; its params are set there"


def _program(state: State, _: str) -> Answer:
    return state, state.text.rstrip() or "nothing has been written yet"


def _drop(state: State, words: str) -> Answer:
    words = words.replace('"', "")  # preset "fine"
    if words not in state.statements:
        near = suggest(words, state.statements)
        hint = f"did you mean `{near}`?" if near else ":program shows all"
        raise fail("E108", f"nothing is called `{words}`", hint=hint)
    rest = {k: v for k, v in state.statements.items() if k != words}
    found = said(replace(state, statements=rest), "")
    if found.state.program is None or any(d.severity == "error" for d in found.diagnostics):
        snapshot = state.session.snapshot(state.name)
        told = snapshot.diagnostics if snapshot is not None else ()
        wrong = [d.span.in_file.start for d in told if d.span is not None]
        places = zip(rest, pieces(rest.values()), strict=True)
        users = [name for name, p in places if any(p.begins <= at <= p.begins + len(p.text) for at in wrong)]
        who = ", ".join(f"`{name}`" for name in users) or "another statement"
        hint = f"`:drop {users[0]}` first, or write another `{words}`" if users else f"write another `{words}`"
        raise fail("E108", f"`{words}` is needed by {who}", hint=hint)
    return found.state, f"`{words}` is gone"


COMMANDS: dict[str, Command] = {
    c.name: c
    for c in (
        Command(":help", "", "these lines", _help),
        Command(":type", "[EXPR]", "what kind of thing it is", _type),
        Command(":doc", "NAME", "what a function does, and what it takes", _doc),
        Command(":set", "[NAME = VALUE]", "set a param; without words, what is set", _set),
        Command(":slice", "[EXPR]", "what was asked for last, or this, cut at z = 0", _slice),
        Command(":time", "[EXPR]", "its value, and how long that took", _time),
        Command(":ir", "[EXPR]", "the graph that it becomes", _ir),
        Command(":glsl", "[EXPR]", "the shader that it becomes", _glsl),
        Command(":mesh", "FILE [EXPR]", "write the surface of what was asked for last, or of this", _mesh),
        Command(":view", "[EXPR]", "show what was asked for last, or this, on a page that follows", _view),
        Command(":program", "", "all statements so far", _program),
        Command(":drop", "NAME", "take a statement back", _drop),
        Command(":save", "[FILE]", "write the program as a file", _save),
        Command(":quit", "", "end; so does Ctrl-D", lambda state, _: (state, "")),
    )
}
