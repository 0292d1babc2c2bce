"""The prelude: everything that is written in Pore itself, read from `porelang/prelude/*.pore`.

Its files share one scope. A file in a folder makes a namespace: `prelude/conventions/axolotl.pore` is
`conventions.axolotl`. The parsed trees are kept in the user's cache, keyed by their text.
"""

from __future__ import annotations

import gc
import hashlib
import pickle
import sys

from porelang import cache, resources
from porelang.diagnostics import PoreError
from porelang.elaborate import names as resolution
from porelang.elaborate.builtins import builtins
from porelang.elaborate.context import Context
from porelang.elaborate.expressions import evaluate
from porelang.elaborate.runtime import room_to_compile
from porelang.elaborate.values import Function, Record, Scalar, Scope, Value
from porelang.once import once
from porelang.source import Source
from porelang.syntax import tree
from porelang.syntax.parse import parse


@once
def prelude_scope() -> Scope:
    """The names that every program sees: the kernel's, and the prelude's over them."""
    files = _files()
    base = Scope(builtins())
    scope = _scope(tree.File(files[0][1].source, _statements(files, "")), base) if files else base
    for folder in sorted({name.rpartition("/")[0] for name, _ in files} - {""}):
        spaces: dict[str, Value] = {}
        for name, file in files:
            where, _, last = name.rpartition("/")
            if where == folder:
                spaces[last] = Record(f"{folder}.{last}", _scope(file, scope).names)
        scope.names[folder] = Record(folder, spaces)
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


def _statements(files: list[tuple[str, tree.File]], folder: str) -> tuple[tree.Statement, ...]:
    return tuple(s for name, file in files if name.rpartition("/")[0] == folder for s in file.statements)


def _files() -> list[tuple[str, tree.File]]:
    """The parsed files, from the cache where their text has not changed."""
    sources = prelude_files()
    version = (
        sys.version,
        [(name, s.text) for name, s in sources],
        resources.read("grammar/pore.lark"),
        (resources.PACKAGE / "syntax" / "tree.py").read_text(encoding="utf-8"),
    )
    key = f"prelude-{hashlib.sha256(repr(version).encode()).hexdigest()[:24]}.pickle"
    kept = cache.get(key)
    if kept is not None:
        collecting = gc.isenabled()
        gc.disable()  # thousands of small objects, all of which stay
        try:
            return pickle.loads(kept)  # type: ignore[no-any-return]  # written below
        except Exception:  # a damaged cache is made anew
            pass
        finally:
            if collecting:
                gc.enable()
    files: list[tuple[str, tree.File]] = []
    for name, source in sources:
        file, found = parse(source)
        if found:
            raise PoreError(found)
        files.append((name, file))
    _resolve(files)
    with room_to_compile():
        cache.put(key, pickle.dumps(files, protocol=pickle.HIGHEST_PROTOCOL))
    return files


def _resolve(files: list[tuple[str, tree.File]]) -> None:
    """Refuse a prelude that uses an unknown name, binds one twice or recurses."""
    known: dict[str, Value] = builtins()
    everything = _statements(files, "")
    groups = [everything, *(file.statements for name, file in files if "/" in name)]
    outer: set[str] = set(known)
    for statements in groups:
        bound, found = resolution.bindings(statements)
        uses, unknown = resolution.resolve(statements, {*bound, *outer})
        _, rings = resolution.evaluation_order(bound, {s.name: uses[statements.index(s)] for s in bound.values()})
        if problems := [*found, *unknown, *rings]:
            raise PoreError(problems)
        if statements is everything:
            outer |= set(bound)


def _scope(file: tree.File, base: Scope) -> Scope:
    """The definitions of a file (or several, as one) as values; lets are constants."""
    names: dict[str, Value] = {}
    scope = Scope(names, base)
    ctx = Context(evaluate)
    for s in file.statements:
        if isinstance(s, tree.Def):
            names[s.name] = Function(s.name, s.parameters, s.body, scope, s)
    for s in file.statements:
        if isinstance(s, tree.Let):
            value = ctx.evaluate(s.value, scope)
            names[s.name] = Scalar(value.node, value.dimension, True) if isinstance(value, Scalar) else value
    if ctx.found.diagnostics:
        raise PoreError(ctx.found.diagnostics)
    return scope
