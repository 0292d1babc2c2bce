"""Names: what each use of one stands for, where it is bound, and all its uses."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

from porelang.diagnostics import fail
from porelang.elaborate.names import COORDINATES, Binding, bindings, children
from porelang.elaborate.prelude import prelude_scope
from porelang.elaborate.values import Builtin, Function, Value
from porelang.session import Snapshot
from porelang.source import Span
from porelang.syntax import tree
from porelang.syntax.parse import lexed, parse

#: Lets that stand for each other, in used files, before a def: more are a ring.
MOST_LETS = 100
Kind = Literal["param", "let", "def", "use", "out", "parameter", "item", "prelude", "preset"]


@dataclass(frozen=True, slots=True)
class Bound:
    """What binds a name: a statement, a parameter of a function, an item of a comprehension, or the language itself.

    `span` is where the name is bound, None where that is nowhere in Pore (a kernel operation); `by` is the statement
    or the parameter, None of items, lambdas and the language; `value` is what the language's own names stand for.
    """

    name: str
    kind: Kind
    span: Span | None
    by: Binding | tree.Parameter | None = None
    value: Value | None = None


@dataclass(frozen=True, slots=True)
class Use:
    """A place where a name stands, and what it stands for; None where that is nothing. `binds` at the place itself."""

    name: str
    span: Span
    bound: Bound | None
    binds: bool = False


@lru_cache(32)
def uses(snapshot: Snapshot) -> tuple[Use, ...]:
    """All names of the statements that can be read, in the order of the text, those that are bound too."""
    file = snapshot.file

    def members(use: tree.Use) -> Mapping[str, Bound]:
        return _of_file(snapshot, use)

    outer = _bound_in(file)
    found: list[Use] = []
    for s in file.statements:
        if isinstance(s, tree.Param | tree.Let | tree.Def | tree.Use) or (isinstance(s, tree.Out) and s.name_span.text):
            bound = outer.get(s.name)
            mine = bound if bound is not None and bound.by is s else Bound(s.name, _KINDS[type(s)], s.name_span, s)
            found.append(Use(s.name, s.name_span, mine, True))
        found += _uses(s, outer, members)
    return tuple(sorted(found, key=lambda use: use.span.in_file.start))


_KINDS: Mapping[type, Kind] = {tree.Param: "param", tree.Let: "let", tree.Def: "def", tree.Use: "use", tree.Out: "out"}


def _bound_in(file: tree.File) -> dict[str, Bound]:
    """What the statements of a file bind, by name."""
    own, _ = bindings(file.statements, frozenset(prelude_scope().visible()))
    return {name: Bound(name, _KINDS[type(b)], b.name_span, b) for name, b in own.items()}


def value_of(snapshot: Snapshot, bound: Bound) -> Value | None:
    """What a name came to: the language's own, a `let`, an `out` or a used file; None where that is not known."""
    elaborated = snapshot.compiled.elaborated
    if isinstance(bound.by, tree.Let | tree.Out):
        return elaborated.values.get(bound.by.value.span)
    return elaborated.files.get(bound.name) if isinstance(bound.by, tree.Use) else bound.value


def of_the_language(name: str) -> Bound | None:
    """What a name of the prelude or of the kernel stands for."""
    value = prelude_scope().find(name)
    if value is None:
        return None
    definition = value.definition if isinstance(value, Function) else None
    return Bound(name, "prelude", definition.name_span if definition is not None else None, None, value)


#: What a used file binds, by name.
Members = Callable[[tree.Use], Mapping[str, Bound]]


def _of_file(snapshot: Snapshot, use: tree.Use) -> Mapping[str, Bound]:
    source = snapshot.compiled.used.get(f"{use.span.in_file.source.name}\n{use.path.value}")
    if source is None:
        return {}
    return _bound_in(parse(source)[0])


def settable(snapshot: Snapshot) -> list[str]:
    """What a preset may set: the params of the file, and those of the files that it uses, as `plates.t`."""
    found = []
    for name, bound in _bound_in(snapshot.file).items():
        if bound.kind == "param":
            found.append(name)
        elif isinstance(bound.by, tree.Use):
            found += [f"{name}.{member}" for member, b in _of_file(snapshot, bound.by).items() if b.kind == "param"]
    return found


def uses_of(snapshot: Snapshot, bound: Bound) -> list[Span]:
    """Where a file names what another one binds, as in `plates.ring`."""
    if bound.span is None or bound.span.source.name == snapshot.source.name:
        return []
    return [u.span.in_file for u in uses(snapshot) if u.bound is not None and _same(u.bound, bound)]


def _same(a: Bound, b: Bound) -> bool:
    """Whether two names are bound at one place, whichever reading of its file they are from."""
    if a.span is None or b.span is None:
        return False
    here, there = a.span.in_file, b.span.in_file
    return a.name == b.name and (here.source.name, here.start) == (there.source.name, there.start)


def _uses(item: object, env: Mapping[str, Bound], members: Members = lambda _: {}) -> Iterator[Use]:
    todo: list[tuple[object, Mapping[str, Bound]]] = [(item, env)]
    while todo:
        one, seen = todo.pop()
        match one:
            case tree.Name():
                yield Use(one.name, one.span, seen.get(one.name) or of_the_language(one.name))
            case tree.Call():
                yield from _named_arguments(one, seen, members)
                todo += [(one.function, seen), *((a.value, seen) for a in one.arguments)]
            case tree.Def():
                yield from _parameters(one, seen, todo)
            case tree.Lambda():
                inner = dict(seen)
                for p in one.parameters:
                    inner[p.name] = Bound(p.name, "parameter", p.span)
                    yield Use(p.name, p.span, inner[p.name], True)
                todo.append((one.body, inner))
            case tree.Block():
                inner = dict(seen)
                for b in one.bindings:
                    todo.append((b, dict(inner)))
                    inner[b.name] = Bound(b.name, _KINDS[type(b)], b.name_span, b)
                    yield Use(b.name, b.name_span, inner[b.name], True)
                todo.append((one.value, inner))
            case tree.Comprehension():
                inner = dict(seen)
                for clause in one.clauses:
                    todo.append((clause.items, dict(inner)))
                    inner[clause.name.name] = Bound(clause.name.name, "item", clause.name.span)
                    yield Use(clause.name.name, clause.name.span, inner[clause.name.name], True)
                    todo += [(condition, dict(inner)) for condition in clause.filters]
                todo.append((one.value, inner))
            case tree.Member():
                todo.append((one.target, seen))
                used = _used(one.target, seen, members)
                if used is not None:
                    yield Use(one.name, one.name_span, members(used).get(one.name))
            case tree.Preset():
                for setting in one.settings:
                    yield from _set(setting, seen, members)
                    todo.append((setting.value, seen))
            case _:
                todo += [(part, seen) for part in children(one)]


def _parameters(
    one: tree.Def, seen: Mapping[str, Bound], todo: list[tuple[object, Mapping[str, Bound]]]
) -> Iterator[Use]:
    inner = {**seen, **{p.name: Bound(p.name, "parameter", p.name_span, p) for p in one.parameters}}
    before = dict(seen)
    for p in one.parameters:
        yield Use(p.name, p.name_span, inner[p.name], True)
        if p.default is not None:
            todo.append((p.default, dict(before)))
        before[p.name] = inner[p.name]
        if p.where is not None:
            todo.append((p.where, inner))
    todo.append((one.body, inner))


def _set(setting: tree.Setting, seen: Mapping[str, Bound], members: Members) -> Iterator[Use]:
    """The names of what a preset sets: a param, or that of a used file, `plates.t`."""
    first, _, member = setting.name.partition(".")
    bound, place = seen.get(first), setting.name_span
    if bound is None:
        return
    yield Use(first, Span(place.source, place.start, place.start + len(first)), bound)
    if member and isinstance(bound.by, tree.Use):
        yield Use(member, Span(place.source, place.end - len(member), place.end), members(bound.by).get(member))


def _used(target: tree.Expr, seen: Mapping[str, Bound], members: Members) -> tree.Use | None:
    """The file whose names stand behind a dot: `plates` in `plates.ring`, or `parts.plates` of a file that uses it."""
    bound: Bound | None = None
    if isinstance(target, tree.Name):
        bound = seen.get(target.name)
    elif isinstance(target, tree.Member):
        through = _used(target.target, seen, members)
        bound = members(through).get(target.name) if through is not None else None
    return bound.by if bound is not None and isinstance(bound.by, tree.Use) else None


def _parameters_of(function: tree.Expr, seen: Mapping[str, Bound], members: Members) -> dict[str, Bound] | None:
    """The parameters of what is called: of a def by its name, as a member of a used file, by a let that stands for it
    in its file, or of a lambda; None where it is none of these."""
    for _ in range(len(seen) + MOST_LETS):
        bound: Bound | None = None
        if isinstance(function, tree.Name):
            bound = seen.get(function.name)
        elif isinstance(function, tree.Member):
            used = _used(function.target, seen, members)
            if used is not None:
                seen = members(used)
                bound = seen.get(function.name)
        elif isinstance(function, tree.Lambda):
            return {p.name: Bound(p.name, "parameter", p.span) for p in function.parameters}
        if bound is not None and isinstance(bound.by, tree.Def):
            return {p.name: Bound(p.name, "parameter", p.name_span, p) for p in bound.by.parameters}
        if bound is None or not isinstance(bound.by, tree.Let):
            return None
        function = bound.by.value
    return None


def _named_arguments(call: tree.Call, seen: Mapping[str, Bound], members: Members) -> Iterator[Use]:
    """The names of arguments, which are those of the parameters of what is called."""
    parameters = _parameters_of(call.function, seen, members)
    for a in call.arguments:
        if a.name is not None and parameters is not None:
            span = Span(a.span.source, a.span.start, a.span.start + len(a.name))
            yield Use(a.name, span, parameters.get(a.name))


def use_at(snapshot: Snapshot, offset: int) -> Use | None:
    """The name that a character belongs to, or that ends before it."""
    for use in uses(snapshot):
        place = use.span.in_file
        if place.start <= offset <= place.end:
            return use
    return None


def references(snapshot: Snapshot, offset: int) -> list[Span]:
    """All places of the file where the name at a place stands for the same, the one that binds it first."""
    here = use_at(snapshot, offset)
    if here is None or here.bound is None:
        return []
    same = [
        u for u in uses(snapshot) if u.name == here.name and u.bound is not None and u.bound.span == here.bound.span
    ]
    return [u.span.in_file for u in sorted(same, key=lambda u: not u.binds)]


def definition(snapshot: Snapshot, offset: int) -> Span | None:
    """Where the name at a place is bound, which may be in the prelude; None where that is nowhere in Pore."""
    here = use_at(snapshot, offset)
    return None if here is None or here.bound is None or here.bound.span is None else here.bound.span.in_file


def refuse_unreadable(snapshot: Snapshot, name: str) -> None:
    """Errors: E196 where a statement that cannot be read has a name in it, whose uses are not all known."""
    read = [s.span.in_file for s in snapshot.file.statements]
    for token in lexed(snapshot.source.text):
        if token.type == "NAME" and token.text == name and not any(r.start <= token.start < r.end for r in read):
            line = snapshot.source.text.count("\n", 0, token.start) + 1
            where = f"line {line} of `{snapshot.source.name}`"
            raise fail("E196", f"{where} has `{name}` in it and cannot be read", hint="mend that line first")


def renamed(snapshot: Snapshot, offset: int, name: str) -> list[Span]:
    """The places to be changed so that what is called by the name at a place is called `name`.

    Errors: E196 where that is no name, is bound already where it would stand, or is the language's own.
    """
    here = use_at(snapshot, offset)
    if here is None or here.bound is None:
        raise fail("E196", "there is no name here that could be changed", hint="put the cursor on a name of the file")
    if here.bound.kind == "prelude":
        raise fail("E196", f"`{here.name}` is the language's own", hint="a name of this file can be changed")
    if here.bound.span is not None and here.bound.span.source.name != snapshot.source.name:
        where = here.bound.span.source.name
        raise fail("E196", f"`{here.name}` is bound in `{where}`", hint="change it there: files that use it go along")
    tokens = [t for t in lexed(name) if t.type != "NEWLINE"]
    if [t.type for t in tokens] != ["NAME"] or tokens[0].text != name:
        raise fail("E196", f"`{name}` is no name", hint="a name is letters, digits and _, and begins with no digit")
    if here.bound.span is not None and here.bound.span.in_file.text != here.name:
        raise fail("E196", f"`{here.name}` is what the last expression of a file is called",
                   hint=f"write `out {here.name} = ` before that expression first")  # fmt: skip
    refuse_unreadable(snapshot, here.name)
    places = references(snapshot, offset)
    known = {u.name for u in uses(snapshot) if u.bound is not None and u.bound.kind != "prelude"} | {*COORDINATES}
    if name != here.name and name in known:
        raise fail("E196", f"`{name}` stands for something else in this file", hint="choose another name")
    used = {u.name for u in uses(snapshot) if u.bound is not None and u.bound.kind == "prelude"}
    if name in used:
        raise fail("E196", f"`{name}` is used here as the language has it", hint="choose another name")
    return places


def visible(snapshot: Snapshot, offset: int) -> dict[str, Bound]:
    """What can be named at a place, nearest binding first: of the statement there, of the file, of the language."""
    found = _bound_in(snapshot.file)
    statement = snapshot.statement_at(offset)
    if statement is not None:
        at = offset - statement.span.source.begins
        for use in _uses(statement, found):
            if use.binds and use.bound is not None and _reaches(statement, use.span, at):
                found[use.name] = use.bound
    for name in prelude_scope().visible():
        if name not in found and not name.startswith("_"):
            bound = of_the_language(name)
            if bound is not None:
                found[name] = bound
    return found


def _reaches(statement: tree.Statement, binder: Span, at: int) -> bool:
    """Whether what is bound within a statement is seen at a place: in the innermost node that holds both, after it."""
    todo: list[object] = [statement]
    inner = statement.span
    while todo:
        one = todo.pop()
        if isinstance(one, _BINDERS) and one.span.start <= binder.start and binder.end <= one.span.end:
            inner = one.span
        todo += children(one)
    return inner.start <= at <= inner.end and binder.start <= at


_BINDERS = (tree.Def, tree.Lambda, tree.Block, tree.Comprehension)


def is_function(bound: Bound) -> bool:
    """Whether what a name stands for is called, as far as its text tells."""
    if isinstance(bound.by, tree.Def):
        return True
    if isinstance(bound.by, tree.Let):
        return isinstance(bound.by.value, tree.Lambda)
    return isinstance(bound.value, Function | Builtin)
