"""The prelude: everything that is written in Pore itself, read from `porelang/prelude/*.pore`.

Its files share one scope. A file in a folder makes a namespace: `prelude/conventions/axolotl.pore` is
`conventions.axolotl`. A program uses a few of its hundred definitions: each is parsed when a name is first looked up,
so that nothing has to be kept between runs. Its statements are `def` and `let` in column 1, which is all that has to
be known to find them; the suite parses and resolves every one.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from porelang import resources
from porelang.diagnostics import PoreError
from porelang.elaborate.builtins import builtins
from porelang.elaborate.context import Context
from porelang.elaborate.expressions import evaluate
from porelang.elaborate.values import Function, Record, Scalar, Scope, Value
from porelang.once import once
from porelang.source import Source
from porelang.syntax import tree
from porelang.syntax.parse import parse

#: A definition: the `##` lines right above it, and its name.
_HEAD = re.compile(r"^(?:##.*\n)*(?:def|let)[ \t]+(\w+)", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Place:
    """Where a definition of the prelude is written: the characters `start..end` of a file."""

    source: Source
    start: int
    end: int


class Definitions(Mapping[str, Value]):
    """The values of definitions by name, each parsed when it is first asked for. Threads may ask side by side."""

    def __init__(self, places: Mapping[str, Place], outer: Scope) -> None:
        self._places = places
        self._outer = outer
        self._known: dict[str, Value] = {}
        self.scope = Scope(self, outer)

    def __getitem__(self, name: str) -> Value:
        found = self._known.get(name)
        if found is None:  # two threads may both parse it: the first that is done gives the value for all
            found = self._known.setdefault(name, self._value(statement(self._places[name])))
        return found

    def __contains__(self, name: object) -> bool:
        return name in self._places

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)

    def _value(self, s: tree.Def | tree.Let) -> Value:
        if isinstance(s, tree.Def):
            return Function(s.name, s.parameters, s.body, self.scope, s)
        ctx = Context(evaluate)
        value = ctx.evaluate(s.value, self.scope)
        if ctx.found.diagnostics:
            raise PoreError(ctx.found.diagnostics)
        return Scalar(value.node, value.dimension, True) if isinstance(value, Scalar) else value


@once
def prelude_scope() -> Scope:
    """The names that every program sees: the kernel's, and the prelude's over them."""
    files = prelude_files()
    kernel = builtins()
    scope = Definitions(places(*(source for name, source in files if "/" not in name)), Scope(kernel)).scope
    folders: dict[str, dict[str, Value]] = {}
    for name, source in files:
        folder, _, last = name.rpartition("/")
        if folder:
            folders.setdefault(folder, {})[last] = Record(f"{folder}.{last}", Definitions(places(source), scope))
    kernel.update({name: Record(name, members) for name, members in folders.items()})
    return scope


def prelude_files() -> list[tuple[str, Source]]:
    """The sources of the prelude, by their path without `.pore`."""
    root = resources.folder("prelude")
    return [
        (
            path.relative_to(root).with_suffix("").as_posix(),
            Source(f"prelude/{path.relative_to(root).as_posix()}", path.read_text(encoding="utf-8"), prelude=True),
        )
        for path in sorted(root.rglob("*.pore"))
    ]


def places(*sources: Source) -> dict[str, Place]:
    """Where each definition of these files is written, by its name."""
    found: dict[str, Place] = {}
    for source in sources:
        heads = list(_HEAD.finditer(source.text))
        ends = [*(head.start() for head in heads[1:]), len(source.text)]
        found |= {head[1]: Place(source, head.start(), end) for head, end in zip(heads, ends, strict=True)}
    return found


def statement(place: Place) -> tree.Def | tree.Let:
    """The definition that is written in a place."""
    file, found = parse(place.source, place.start, place.end)
    if found:
        raise PoreError(found)
    (read,) = file.statements
    assert isinstance(read, tree.Def | tree.Let)
    return read
