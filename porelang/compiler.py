"""Compiling: from a text, and the files it uses, to a program or to all that is wrong with it."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType

from porelang.bound import no_such_data
from porelang.contracts import broken_requirements
from porelang.data import SampledField
from porelang.diagnostics import MOST_DIAGNOSTICS, Diagnostic, Label, PoreError, fail, in_order, warn
from porelang.elaborate.context import Bound
from porelang.elaborate.prelude import prelude_scope
from porelang.elaborate.results import Elaborated, Listed, graph_of
from porelang.elaborate.runtime import room_to_compile
from porelang.elaborate.statements import elaborate_file
from porelang.elaborate.steps import Steps
from porelang.files import find_used, read_source
from porelang.ir import Node
from porelang.program import Program
from porelang.rewrites import Passes
from porelang.settings import settle
from porelang.source import Source, Span
from porelang.syntax import tree
from porelang.syntax.mistakes.statements import OTHER_WORDS
from porelang.syntax.parse import Reading, parse

#: Finds the text of a `use` statement: (path as written, source of the statement).
Finder = Callable[[str, Source], Source]
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


class Memory:
    """What compiling a program remembers from one of its texts to the next: of the same file, with paths that begin in
    the same folder, and the same params bound. It belongs to one thread at a time."""

    def __init__(self) -> None:
        self.steps = Steps()
        self.passes = Passes()
        self._readings: dict[str, Reading] = {}

    def parse(self, source: Source) -> tuple[tree.File, list[Diagnostic]]:
        """The statements of a file, those that stood in its last text being the same."""
        return parse(source, reading=self._readings.setdefault(source.name, Reading()))


@dataclass(frozen=True, slots=True)
class Compiled:
    """What compiling a text gives, also a broken one: the statements that could be read, what elaboration has found,
    the diagnostics in the order of their places, the program if there is no error among them, and the texts of the
    files that it uses."""

    source: Source
    file: tree.File
    elaborated: Elaborated
    diagnostics: tuple[Diagnostic, ...]
    program: Program | None
    used: Mapping[str, Source]


def try_compile(
    source: Source,
    find: Finder = find_used,
    folder: str | None = None,
    bound: Mapping[str, Bound] = MappingProxyType({}),
) -> tuple[Program | None, list[Diagnostic]]:
    """The program, if it has no errors, and all diagnostics in the order of their places.

    Relative paths begin in `folder`, which is the current one unless told otherwise. `bound` are the params that have
    data, from a file: `("load", path, array, options as `load` has them)`.
    """
    made = compiled(source, find, folder, bound)
    if made.program is None:
        return None, list(made.diagnostics)
    try:
        return made.program, list(made.program.warnings)
    except PoreError as error:
        return None, _at_its_beginning(source, error)


def compiled(
    source: Source,
    find: Finder = find_used,
    folder: str | None = None,
    bound: Mapping[str, Bound] = MappingProxyType({}),
    memory: Memory | None = None,
) -> Compiled:
    """As `try_compile`, with all that was found, and nothing is sampled yet: what values show to be doubtful is in the
    program's `warnings`, when these are asked for. `memory` is what compiling the same program has left, and is brought
    up to date."""
    used: dict[str, Source] = {}

    def noted(path: str, user: Source) -> Source:
        return used.setdefault(f"{user.name}\n{path}", find(path, user))

    with room_to_compile():
        return _compiled(source, noted, used, _here() if folder is None else folder, bound=bound, memory=memory)


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
        made = _compiled(source, partial(_kept, used), used, folder, structure, bound, held)
    if made.program is None:
        raise PoreError([d for d in made.diagnostics if d.severity == "error"])
    return made.program


def _kept(used: Mapping[str, Source], path: str, user: Source) -> Source:
    return used[f"{user.name}\n{path}"]


def _compiled(
    source: Source,
    find: Finder,
    used: Mapping[str, Source],
    folder: str,
    structure: Mapping[str, float] = MappingProxyType({}),
    bound: Mapping[str, Bound] = MappingProxyType({}),
    held: Mapping[Node, SampledField] = MappingProxyType({}),
    memory: Memory | None = None,
) -> Compiled:
    memory = memory or Memory()

    def load(path: str, user: Source) -> tuple[tree.File, list[Diagnostic]]:
        return memory.parse(find(path, user))

    file, found = memory.parse(source)
    lost = frozenset(a or b for a, b in _BINDING.findall(source.text)) if found else frozenset()
    out = elaborate_file(file, prelude_scope(), load, lost, folder, structure, bound, memory.steps)
    diagnostics = [*found, *out.diagnostics, *_wrong_presets(out), *_unbindable(out, bound)]
    program: Program | None = None
    sound = not any(d.severity == "error" for d in diagnostics)
    written = graph_of(out, whole=sound)
    try:
        graph = memory.passes.run(written)
        diagnostics += broken_requirements(graph, out.requirements, out.params)
        if sound:
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
        diagnostics += _at_its_beginning(source, error)
    if any(d.severity == "error" for d in diagnostics):
        program = None
    told = tuple(in_order(diagnostics[:MOST_DIAGNOSTICS], source))
    return Compiled(source, file, out, told, program, used)


def _at_its_beginning(source: Source, error: PoreError) -> list[Diagnostic]:
    """What has no place is told at the beginning of the text."""
    return [d if d.span else replace(d, span=Span(source, 0, 0)) for d in error.diagnostics]


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
