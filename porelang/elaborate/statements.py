"""Statements and files: the definitions of a file in the order of their use, its outputs, checks and used files.

The elaborator is an abstract interpreter. Functions, lists, texts and records exist only while it runs; numbers and
conditions become nodes of the graph. It never stops at a mistake: a wrong expression is poison, what uses poison is
silent, and the rest of the file is looked at all the same.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

from porelang.diagnostics import Diagnostic, Edit, Label, PoreError
from porelang.elaborate import names as resolution
from porelang.elaborate import suspect
from porelang.elaborate.context import Bound, Context, TooBig
from porelang.elaborate.expressions import evaluate, named
from porelang.elaborate.kinds import KINDS, check_kinds
from porelang.elaborate.natures import nature
from porelang.elaborate.operators import how_to_call
from porelang.elaborate.params import declare
from porelang.elaborate.presets import declare_preset, refuse_dependent
from porelang.elaborate.results import Elaborated, Output, Requirement, Unread
from porelang.elaborate.runtime import room_to_compile
from porelang.elaborate.steps import On, Step, Steps
from porelang.elaborate.values import (
    POISON,
    Bool,
    Function,
    ListValue,
    Poison,
    Record,
    Scalar,
    Scope,
    Study,
    Value,
    Vector,
    as_vector,
    describe,
    stage,
)
from porelang.ir import Stage
from porelang.source import Source
from porelang.syntax import habits, tree
from porelang.units import UNITS, Dimension

#: Finds the file of a `use` statement: (path as written, source of the statement) -> the parsed file.
Loader = Callable[[str, Source], tuple[tree.File, list[Diagnostic]]]


#: What a `use` is made of that names no file.
_NONE: On = ("no names",)


@dataclass(frozen=True, slots=True)
class _Files:
    """What all files of a program share: the names around them, how another is found, which are being read, the names
    that are lost, the params that are fixed, and what their statements came to before."""

    base: Scope
    load: Loader | None
    open: tuple[str, ...]
    lost: frozenset[str]
    fixed: tuple[tuple[str, float], ...]
    steps: Steps


def elaborate_file(
    file: tree.File,
    base: Scope,
    load: Loader | None = None,
    lost: frozenset[str] = frozenset(),
    folder: str = "",
    structure: Mapping[str, float] | None = None,
    bound: Mapping[str, Bound] | None = None,
    steps: Steps | None = None,
) -> Elaborated:
    """All statements of a main file, over the names of `base`. `load` finds the files that it uses.

    `lost` are the names of statements that could not be read: whoever uses one is not told that it is unknown.
    `folder` is where paths that do not begin at the root begin. `structure` fixes params that count or choose what is
    there at all; one that turns out to do so is fixed at its default, and all is elaborated again. `bound` are the
    params that have data. `steps` is what statements of the same program came to before, with `folder` and `bound` as
    they are, and is brought up to date.
    """
    steps = steps or Steps()
    around = steps.around(lost, base)
    fixed, free, whole = dict(structure or {}), None, False
    while True:
        ctx = Context(evaluate, folder, fixed, bound, steps.numbers)
        files = _Files(around, load, (file.source.name,), lost, tuple(sorted(fixed.items())), steps)
        with room_to_compile(), suppress(TooBig):
            whole = False
            _members(ctx, files, file, "")
            whole = True
        if ctx.found.structure <= fixed.keys():
            break
        free = free or ctx.found.presets  # as they are read while nothing is fixed
        fixed |= {name: ctx.found.params[name].default for name in ctx.found.structure - fixed.keys()}
    steps.end(whole)
    if free is not None:
        refuse_dependent(ctx, free)
    ctx.found.structure = set(fixed) & ctx.found.params.keys()
    ctx.found.requirements = list(ctx.required)
    ctx.found.suspicions += suspect.once_cut(ctx.cuts)
    return ctx.found


def _members(ctx: Context, files: _Files, file: tree.File, prefix: str) -> tuple[Mapping[str, Value], On]:
    """The definitions of a file as values, and what they were made of; `prefix` names the params of a used file."""
    known = frozenset(files.base.visible())
    bound, duplicates = resolution.bindings(file.statements, known)
    seen = bound.keys() | known
    uses, unknown = resolution.resolve(file.statements, seen, files.steps.free_names)
    index = {s: i for i, s in enumerate(file.statements)}
    order, cycles = resolution.evaluation_order(bound, {n: uses[index[s]] for n, s in bound.items()})
    ctx.found.diagnostics += [*duplicates, *unknown, *cycles]
    read = set().union(*uses.values())
    ctx.unknown |= read - seen
    in_cycle = {d.span for d in cycles} | {o.span for d in cycles for o in d.others}
    members, scope = files.steps.scope(file.source.name, prefix, files.base)
    steps: dict[str, Step] = {}

    def made_of(s: tree.Statement) -> On:
        return tuple((name, steps.get(name) or name in bound or name in files.lost) for name in sorted(uses[index[s]]))

    def step(s: tree.Statement, what: str, evaluate: Callable[[], Value], on: On = ()) -> Step:
        key = s, what, prefix, files.fixed
        return files.steps.step(ctx, key, (*made_of(s), *on), evaluate)

    for name in order:
        binding = bound[name]
        if binding.name_span in in_cycle:
            members[name] = POISON
            continue
        if isinstance(binding, tree.Use):
            value, on = _use(ctx, files, binding)
            if not prefix:
                ctx.found.files[name] = value
            steps[name] = step(binding, "names", partial(_itself, value), on)
        else:
            steps[name] = step(binding, "value", partial(_define, ctx, binding, scope, prefix))
        members[name] = steps[name].value
    if not prefix:
        ctx.found.collection = any(isinstance(b, tree.Def) for b in bound.values()) or (
            bool(bound) and all(stage(m) is not Stage.FIELD for m in members.values())
        )
        ctx.found.unread = [
            Unread(b.name, b.name_span, isinstance(b, tree.Param), stage(members[b.name]) is not Stage.FIELD)
            for b in bound.values()
            if isinstance(b, tree.Let | tree.Param)
            and b.name not in read
            and not b.name.startswith("_")
            and not isinstance(members[b.name], Study)
        ]
    for s in file.statements:
        if isinstance(s, tree.Out) and not prefix:
            own = (steps.get(s.name),) if bound.get(s.name) is s else ()
            step(s, "output", partial(_output, ctx, s, members[s.name] if own else None, scope), own)
        elif isinstance(s, tree.Check):
            step(s, "check", partial(_check, ctx, s, scope))
        elif isinstance(s, tree.Preset) and not prefix:
            declare_preset(ctx, s, scope)
    for d in bound.values():
        if isinstance(d, tree.Def) and d not in ctx.called and members.get(d.name) is not POISON:
            step(d, "body", partial(_try_body, ctx, d, scope))
    return members, ("names", *steps.items())


def _itself(value: Value) -> Value:
    return value


def _define(ctx: Context, s: tree.Param | tree.Let | tree.Def | tree.Out, scope: Scope, prefix: str) -> Value:
    match s:
        case tree.Let():
            value = ctx.evaluate(s.value, scope)
            if isinstance(value, Scalar) and value.literal and not s.span.source.prelude:
                value = Scalar(value.node, value.dimension)
            value = named(value, s)
            if isinstance(value, Scalar) and not prefix:
                ctx.found.lets[s.name] = value
            if isinstance(value, Study) and not prefix:
                ctx.found.studies[s.name] = value.task
            return value
        case tree.Out():
            return ctx.evaluate(s.value, scope)
        case tree.Def():
            check_kinds(ctx, s)
            return Function(s.name, s.parameters, s.body, scope, s)
        case tree.Param():
            value = declare(ctx, s, scope, prefix)
            if (info := ctx.found.params.get(prefix + s.name)) is not None:
                ctx.found.params[info.name] = replace(info, written=_unit(s, info.dimension))
            return value


def _unit(s: tree.Param, dimension: Dimension | None) -> str:
    """The unit that the declaration of a param is written in: of its default, else of the first that has one."""
    todo: list[object] = [s.default, s.low, s.high, s.step, *s.choices]
    while todo:
        part = todo.pop(0)
        if isinstance(part, tree.Number) and part.unit and UNITS[part.unit].dimension == dimension:
            return part.unit
        todo[:0] = resolution.children(part)
    return ""


def _use(ctx: Context, files: _Files, s: tree.Use) -> tuple[Value, On]:
    ending = s.path.value.lower()
    if ending.endswith(habits.MESH_ENDINGS) or ending.endswith(
        (".npz", ".vtu", ".vtk", ".vti", ".nrrd", ".json", ".csv")
    ):
        mesh = ending.endswith(habits.MESH_ENDINGS) and not ending.endswith((".vtu", ".vtk"))
        read = f'fields of data are read by `load("{s.path.value}", "name")`, bars by `frame`'
        wrong = ctx.error(
            "E046",
            f'"{s.path.value}" is no program of Pore',
            s.path.span,
            label="a mesh" if mesh else "data",
            hint=habits.MESHES if mesh else read,
        )
        return wrong, _NONE
    if files.load is None:
        return ctx.error("E035", "files cannot be used here", s.span, hint="compile the program from a file"), _NONE
    try:
        file, found = files.load(s.path.value, s.span.source)
    except PoreError as failed:
        d = failed.diagnostics[0]
        return ctx.error(d.code, d.message, s.path.span, label=d.label, hint=d.hint), _NONE
    ctx.found.diagnostics.extend(found)
    name = file.source.name
    if name in files.open:
        way = " -> ".join(f"`{f}`" for f in [*files.open[files.open.index(name) :], name])
        wrong = ctx.error("E035", f"files use each other in a ring: {way}", s.path.span, label="this closes the ring")
        return wrong, _NONE
    members, on = _members(ctx, replace(files, open=(*files.open, name)), file, f"{s.name}.")
    return Record(s.name, members), on


def _output(ctx: Context, s: tree.Out, value: Value | None, scope: Scope) -> Value:
    """Note a named result; `value` is known where its name is bound to it."""
    value = ctx.evaluate(s.value, scope) if value is None else value
    if isinstance(value, ListValue) and (vector := as_vector(value)) is not None:
        value = vector
    if s.name == "part":
        suspect.total_as_solid(ctx, value)
    if isinstance(value, Scalar | Vector | Bool):
        known = nature(ctx.natures, value.node) if isinstance(value, Scalar) else None
        if known is not None and known.scaled and not known.raw:  # a distance times a number may be any field
            known = None
        made = known is not None and not known.plain
        ctx.found.outputs.setdefault(s.name, Output(s.name, value, s.value.span, known is not None, made))
    elif not isinstance(value, Poison):
        hint = how_to_call(value) or "an output is a field: a number that varies in space"
        edit = None
        if (
            isinstance(value, ListValue)
            and value.items
            and all(isinstance(i, Scalar) and i.node.stage is Stage.FIELD for i in value.items)
        ):
            edit = Edit(s.value.span, f"union({s.value.span.text})")
            hint = "join what is in it: `union([a, b])` for solids"
        ctx.error(
            "E066",
            f"the output `{s.name}` is {describe(value)}, which has no surface",
            s.value.span,
            label=f"this is {describe(value)}",
            hint=hint,
            edit=edit,
        )
    return value


def _check(ctx: Context, s: tree.Check, scope: Scope) -> Value:
    value = ctx.evaluate(s.condition, scope)
    if isinstance(value, Poison):
        return value
    if not isinstance(value, Bool):
        ctx.error(
            "E060",
            f"a check is a condition, not {describe(value)}",
            s.condition.span,
            hint='compare something: `check w > 2 * t, "..."`',
        )
    elif value.node.stage is Stage.FIELD:
        ctx.error(
            "E067",
            "this check varies in space",
            s.condition.span,
            label="true at some points, perhaps",
            hint="a check is about numbers: constants and params",
        )
    else:
        ctx.found.checks.append(Requirement(value.node, s.message, s.condition.span))
    return value


def _try_body(ctx: Context, s: tree.Def, scope: Scope) -> Value:
    """A def that nothing calls is looked at all the same, with arguments about which nothing is known."""
    names: dict[str, Value] = {p.name: POISON for p in s.parameters}
    for p in s.parameters:
        if p.default is None or not p.kinds:
            continue
        value = ctx.evaluate(p.default, Scope(names, scope))
        kinds = [KINDS[k.name] for k in p.kinds if k.name in KINDS]
        if not isinstance(value, Poison) and kinds and all(k.coerce(value) is None for k in kinds):
            ctx.error(
                "E062",
                f"the default of `{p.name}` is {describe(value)}, not {' or '.join(k.words for k in kinds)}",
                p.default.span,
                label="this is the default",
                others=(Label(p.kinds[0].span, "and this is what it is to be"),),
            )
    return ctx.evaluate(s.body, Scope(names, scope))
