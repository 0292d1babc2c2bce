"""Compiling: from a text, and the files it uses, to a program or to all that is wrong with it."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import MappingProxyType

from porelang.bound import no_such_data
from porelang.contracts import broken_requirements, doubtful_contracts
from porelang.data import SampledField
from porelang.diagnostics import Diagnostic, Label, PoreError, fail, warn
from porelang.doubts import borne_out
from porelang.elaborate.context import Bound
from porelang.elaborate.prelude import prelude_scope
from porelang.elaborate.results import Elaborated, Listed, graph_of
from porelang.elaborate.runtime import room_to_compile
from porelang.elaborate.statements import Loader, elaborate_file
from porelang.files import load_used, read_source
from porelang.formula import Bindings
from porelang.ir import Node, param
from porelang.program import Program
from porelang.rewrites import Graph, run
from porelang.settings import settle
from porelang.source import Source, Span
from porelang.syntax import tree
from porelang.syntax.mistakes.statements import OTHER_WORDS
from porelang.syntax.parse import parse

#: Nobody reads more; the first are the likeliest causes.
MOST_DIAGNOSTICS = 100
#: What a statement that cannot be read was about to bind: `let a`, `use ... as a`, also with another language's word
#: (`module a`, `float a`, `import ... as a`), with any other (`number a = 5`) or with none (`a = 5`, `a(x) = 5`).
_WORDS = "|".join(
    ["let", "def", "param", "out", *(word for word, ours in OTHER_WORDS.items() if ours not in ("use", ""))]
)
_BINDING = re.compile(
    rf"^[ \t]*(?:(?:(?:{_WORDS})|.*\bas)[ \t]+(\w+)|(?:\w+[ \t]+)?(\w+)[ \t]*(?:\([^()\n]*\)[ \t]*)?:?=(?![=>]))",
    re.MULTILINE,
)
#: What is no program, though it is a text.
_FILE = re.compile(r"\s*[^\n]*\.pore\s*")


def compile(text: str | None = None, *, path: str | Path | None = None, name: str = "<text>") -> Program:
    """Compile a program from a text, or from the file at `path`. What is doubtful is told as a `PoreWarning`.

    Errors: `PoreError`, with everything that is wrong in `.diagnostics`.

    >>> import porelang
    >>> program = porelang.compile("gyroid(30) & cylinder(75, 300)")
    >>> program.bounds("part").size
    (150.0, 150.0, 300.0)
    """
    if (text is None) == (path is None):
        raise TypeError("compile takes a text or a path")
    if isinstance(text, os.PathLike) or (isinstance(text, str) and _FILE.fullmatch(text)):
        raise fail("E108", f"`{text}` is the name of a file, and `compile` was given it as the text of a program",
                   hint=f"name it as a path: porelang.compile(path={str(text)!r})")  # fmt: skip
    if not isinstance(text, str | None):
        raise TypeError(f"a program is a text (str), not {type(text).__name__}; a file is compile(path=...)")
    if not isinstance(path, str | os.PathLike | None):
        raise TypeError(f"a path is a text or a pathlib.Path, not {type(path).__name__}")
    source = read_source(os.path.normpath(path)) if path is not None else Source(name, text or "")
    program, found = try_compile(source)
    if program is None:
        raise PoreError([d for d in found if d.severity == "error"])
    warn(found)
    return program


def try_compile(
    source: Source,
    load: Loader = load_used,
    folder: str | None = None,
    bound: Mapping[str, Bound] = MappingProxyType({}),
) -> tuple[Program | None, list[Diagnostic]]:
    """The program, if it has no errors, and all diagnostics in the order of their places.

    Relative paths begin in `folder`, which is the current one unless told otherwise. `bound` are the params that have
    data, from a file: `("load", path, array, options as `load` has them)`.
    """
    used: dict[str, Source] = {}

    def noted(path: str, user: Source) -> tuple[tree.File, list[Diagnostic]]:
        file, found = load(path, user)
        used[f"{user.name}\n{path}"] = file.source
        return file, found

    with room_to_compile():
        return _compiled(source, noted, used, _here() if folder is None else folder, bound=bound)


def _here() -> str:
    try:
        return os.getcwd()
    except OSError:  # it was removed: paths that begin at the root are of use still
        return ""


def _again(
    source: Source,
    used: Mapping[str, Source],
    folder: str,
    structure: Mapping[str, float],
    bound: Mapping[str, Bound],
    held: Mapping[Node, SampledField],
    more: str = "",
) -> Program:
    """A program from its texts, as they were when it was compiled: also where its files are not. `more` is read before
    its own text, whose last expression is its part."""
    if more:
        source = Source(source.name, more + source.text)
    with room_to_compile():
        load = partial(_kept, used)
        program, found = _compiled(source, load, used, folder, structure, bound, held)
    if program is None:
        raise PoreError([d for d in found if d.severity == "error"])
    return program


def _kept(used: Mapping[str, Source], path: str, user: Source) -> tuple[tree.File, list[Diagnostic]]:
    return parse(used[f"{user.name}\n{path}"])


def _compiled(
    source: Source,
    load: Loader,
    used: Mapping[str, Source],
    folder: str,
    structure: Mapping[str, float] = MappingProxyType({}),
    bound: Mapping[str, Bound] = MappingProxyType({}),
    held: Mapping[Node, SampledField] = MappingProxyType({}),
) -> tuple[Program | None, list[Diagnostic]]:
    file, found = parse(source)
    lost = frozenset(a or b for a, b in _BINDING.findall(source.text)) if found else frozenset()
    out = elaborate_file(file, prelude_scope(), load, lost, folder, structure, bound)
    diagnostics = [*found, *out.diagnostics, *_wrong_presets(out), *_unbindable(out, bound)]
    program: Program | None = None
    sound = not any(d.severity == "error" for d in diagnostics)
    written = graph_of(out, whole=sound)
    try:
        graph = run(written)
        diagnostics += broken_requirements(graph, out.requirements, out.params)
        if sound:
            diagnostics += _doubts(graph, out, held)
            program = Program(
                source,
                Listed(out.params),
                Listed(out.outputs),
                tuple(diagnostics),
                written,
                graph,
                out,
                {name: structure.get(name, out.params[name].default) for name in out.structure},
                partial(_again, source, used, folder),
                used,
                bound,
                held,
            )
    except PoreError as error:
        span = Span(source, 0, 0)
        diagnostics += [d if d.span else replace(d, span=span) for d in error.diagnostics]
    if any(d.severity == "error" for d in diagnostics):
        program = None
    diagnostics = diagnostics[:MOST_DIAGNOSTICS]
    diagnostics.sort(key=partial(_place, source))
    return program, diagnostics


def _place(source: Source, d: Diagnostic) -> tuple[bool, int]:
    """What diagnostics are sorted by: those of the main file first, and by their places there."""
    place = None if d.span is None else d.span.in_file
    return (True, 0) if place is None else (place.source is not source, place.start)


def _wrong_presets(out: Elaborated) -> list[Diagnostic]:
    """What presets set their params to that these cannot be."""
    wrong: list[Diagnostic] = []
    for preset in out.presets.values():
        for name, value in preset.settings.items():
            try:
                settle(out.params, {name: value})
            except PoreError as error:
                place, declared = preset.places[name], Label(out.params[name].span, "declared here")
                wrong += [replace(d, span=place, label="set here", others=(declared,)) for d in error.diagnostics]
    return wrong


def _unbindable(out: Elaborated, bound: Mapping[str, Bound]) -> list[Diagnostic]:
    """What is bound and takes no data."""
    return [no_such_data(name, out.data, out.params) for name in bound if name not in out.data]


def _doubts(graph: Graph, out: Elaborated, held: Mapping[Node, SampledField]) -> list[Diagnostic]:
    """What is doubtful with the params at their defaults: contracts on fields that break, and what was suspected."""
    solids = [root for roots in graph.outputs.values() for root in roots]
    settings = settle(out.params, {})
    bindings: Bindings = {**{param(k): v for k, v in settings.items()}, **held}
    return [*doubtful_contracts(graph.contracts, out.contracts, solids, bindings), *borne_out(out, bindings)]
