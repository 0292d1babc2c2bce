"""Calls for studies: how a part is held, loaded and made of what; and the fields and numbers that a study gives.

What finds them is one task, a grid of several components; each member is a field that looks one up, or a number that
is kept with it (`porelang.ops.studies`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from porelang.elaborate import arguments, elastic, loads
from porelang.elaborate.calls import Call
from porelang.elaborate.context import Context
from porelang.elaborate.elastic import OPTIONS, Elastic
from porelang.elaborate.values import (
    ABSENT,
    POISON,
    TENSOR,
    Acting,
    Bool,
    Builtin,
    Poison,
    Scalar,
    Study,
    Text,
    Value,
    Vector,
    as_vector,
    describe,
)
from porelang.elaborate.values import Record as Collection
from porelang.ir import TRUE, ZERO, Node, Stage, X, Y, Z, const, node
from porelang.ops import TASK_TABLE
from porelang.ops.studies import CODE, COMPONENTS, DEPTH, NUMBERS, STRAIN, TURNING
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import FORCE, LENGTH, RATIO, STRESS, Dimension

_HERE = (X, Y, Z)
_AT = {name: i for i, name in enumerate(COMPONENTS)}
#: What the stiffness of a study is measured in, by what alone loads it; of several there is none.
_STIFF = {
    "force": NUMBERS["stiffness"],
    "torque": TURNING,
    "moved": NUMBERS["stiffness"],
    "compress": NUMBERS["stiffness"],
    "shear": NUMBERS["stiffness"],
    "bend": NUMBERS["stiffness"],
    "twist_load": TURNING,
}
#: Why a study does not give a number.
_WITHOUT = {
    "stiffness": "it is the force over the way it goes, of one force, torque or `moved`: of several ask `compliance`",
    "reaction": "a study in a program gives none; `pore fea` reports the force on each support, and Python's study",
    "effective_modulus": "it is `s.stiffness * length / area` of the part; `pore fea` reports that of a compression",
    "mass": "that takes a density: `density=1.01`, in g/cm^3, or a material by its name",
}
_BEND = ("three-point", "cantilever")
_PLATENS = ("frictionless", "bonded")


class _Given:
    """The arguments of a call by their names."""

    def __init__(self, ctx: Context, name: str, site: tree.Call, of: Mapping[str, tuple[Value, Span]]) -> None:
        self.ctx, self.name, self.site, self.of = ctx, name, site, of

    def part(self) -> Node | None:
        value, place = self.of["part"]
        found = arguments.field(self.ctx, value, place, f"`part` of `{self.name}`")
        if found is not None and found.node.stage is not Stage.FIELD:
            hint = "as in `compress(cylinder(75mm, 300mm), 10kN, ...)`"
            self.ctx.error("E187", f"`part` of `{self.name}` is a solid, not one number", place, hint=hint)
            return None
        return None if found is None else found.node

    def number(self, parameter: str, dimension: Dimension, example: str) -> Node | None:
        value, place = self.of[parameter]
        return loads.number(self.ctx, value, place, f"`{parameter}` of `{self.name}`", dimension, example)

    def load(self, parameter: str, dimension: Dimension, example: str) -> Node | None:
        """A force or a torque that is not 0."""
        n = self.number(parameter, dimension, f"{parameter}={example}")
        place = self.of[parameter][1]
        what = f"a {parameter}"
        return n if n is not None and loads.something(self.ctx, (n,), place, what, f"as in `{example}`") else None

    def length(self, parameter: str) -> Node | None:
        """A length above 0; 0 where it is left out."""
        if self.of[parameter][0] is ABSENT:
            return ZERO
        n = self.number(parameter, LENGTH, f"{parameter}=100mm")
        known = None if n is None else self.ctx.constant(n)
        if known is not None and not known > 0:
            what = f"`{parameter}` of `{self.name}` is a length above 0"
            hint = f"as in `{parameter}=5mm`, or leave it out"
            self.ctx.error("E187", what, self.of[parameter][1], label=f"this is {known:g} mm", hint=hint)
            return None
        return n

    def word(self, parameter: str, words: Sequence[str]) -> int | None:
        """Which of some words it is, the first where it is left out."""
        value, place = self.of[parameter]
        if value is ABSENT:
            return 0
        value = self.ctx.decided(value)
        if isinstance(value, Text) and value.value in words:
            return words.index(value.value)
        if not isinstance(value, Poison):
            known = " or ".join(f'"{w}"' for w in words)
            hint = f'write `{parameter}="{words[0]}"`, or leave it out'
            what = f"`{parameter}` of `{self.name}` is {known}"
            self.ctx.error("E187", what, place, label=f"this is {describe(value)}", hint=hint)
        return None

    def flag(self, parameter: str) -> bool:
        """Whether an option is true that has been looked over."""
        value = self.of[parameter][0]
        return isinstance(value, Bool) and self.ctx.constant(value.node) is True

    def axis(self, parameter: str, otherwise: tuple[int, float]) -> tuple[int, float] | None:
        """Which axis it is, with its sign: `z`, `-x`, or a vector along one."""
        value, place = self.of[parameter]
        if value is ABSENT:
            return otherwise
        found = _along(self.ctx, value)
        if found is None and not isinstance(value, Poison):
            what = f"`{parameter}` of `{self.name}` is an axis: x, y or z"
            hint = f"as in `{parameter}=z`, or `-z`; turn the part where it stands otherwise"
            self.ctx.error("E187", what, place, label="this is none of them", hint=hint)
        return found

    def two_axes(self, toward: tuple[int, float]) -> tuple[int, int, float] | None:
        """The axis of the part and the direction across in which it is loaded, with its sign."""
        default = (2, 1.0) if toward[0] == 0 else (0, 1.0)
        axis, across = self.axis("axis", default), self.axis("toward", toward)
        if axis is None or across is None:
            return None
        if axis[0] == across[0]:
            what = f"`toward` of `{self.name}` stands across `axis`"
            place = self.of["toward" if self.of["toward"][0] is not ABSENT else "axis"][1]
            self.ctx.error("E187", what, place, label=f"both are {'xyz'[axis[0]]}", hint="give each its own")
            return None
        return axis[0], *across


def _along(ctx: Context, value: Value) -> tuple[int, float] | None:
    """The axis that a coordinate, its negative, a vector or a text names."""
    if isinstance(value, Text) and value.value.lstrip("+-") in ("x", "y", "z"):
        return "xyz".index(value.value[-1]), -1.0 if value.value.startswith("-") else 1.0
    if isinstance(value, Scalar):
        n = value.node.args[0] if value.node.op == "neg" else value.node
        return (_HERE.index(n), 1.0 if n is value.node else -1.0) if n in _HERE else None
    found = as_vector(value)
    known = [] if found is None else [ctx.constant(n) for n in found.nodes]
    if len([v for v in known if v != 0]) == 1 and all(isinstance(v, float) and math.isfinite(v) for v in known):
        at = next(i for i, v in enumerate(known) if v != 0)
        return at, math.copysign(1.0, float(known[at] or 0.0))
    return None


#: What a call gives a study: what acts on the part; None after saying what is wrong.
_Acts = Callable[[_Given], "list[Acting] | None"]


def _compress(given: _Given) -> list[Acting] | None:
    force, axis = given.load("force", FORCE, "10kN"), given.axis("axis", (2, 1.0))
    bonded = given.word("platens", _PLATENS)
    if force is None or axis is None or bonded is None:
        return None
    return [Acting("compress", {}, TRUE, (force, const(float(axis[0])), const(float(bonded))))]


def _shear(given: _Given) -> list[Acting] | None:
    force, axes = given.load("force", FORCE, "1kN"), given.two_axes((0, 1.0))
    if force is None or axes is None:
        return None
    axis, toward, sign = map(float, axes)
    return [Acting("shear", {}, TRUE, (force, const(axis), const(toward), const(sign)))]


def _bend(given: _Given) -> list[Acting] | None:
    force, axes = given.load("force", FORCE, "1kN"), given.two_axes((2, -1.0))
    way, span, pads = given.word("supports", _BEND), given.length("span"), given.length("pads")
    if force is None or axes is None or way is None or span is None or pads is None:
        return None
    if way == 1 and (used := next((p for p in ("span", "pads") if given.of[p][0] is not ABSENT), None)):
        what = f"`{used}` of `bend` is of three points; a cantilever is held at its end"
        given.ctx.error("E187", what, given.of[used][1], hint="leave it out")
        return None
    axis, toward, sign = map(float, axes)
    numbers = (force, const(axis), const(toward), const(sign), const(float(3 if way == 0 else 1)), span, pads)
    return [Acting("bend", {}, TRUE, numbers)]


def _twist_load(given: _Given) -> list[Acting] | None:
    torque, axis = given.load("torque", FORCE * LENGTH, "5N * 1m"), given.axis("axis", (2, 1.0))
    if torque is None or axis is None:
        return None
    return [Acting("twist_load", {}, TRUE, (torque, const(float(axis[0]))))]


def _study(given: _Given) -> list[Acting] | None:
    held = loads.acting(given.ctx, *given.of["fix"], "fix")
    loaded = loads.acting(given.ctx, *given.of["load"], "load")
    if held is None or loaded is None:
        return None
    balanced = arguments.flag(given.ctx, *given.of["balanced"], "balanced")
    if balanced is None:
        return None
    for name, some in (("fix", held), ("load", loaded)):
        if not some and not (name == "fix" and balanced):
            hint = (
                "as in `fix=z < -149mm`; or `balanced=true`, where loads balance each other"
                if name == "fix"
                else "as in `load=force(z > 149mm, [0, 0, -1kN])`"
            )
            what = "holds the part" if name == "fix" else "loads the part"
            given.ctx.error("E186", f"nothing {what}", given.of[name][1], label="an empty list", hint=hint)
            return None
    return [*held, *loaded]


def _call(name: str, parameters: Sequence[str], acts: _Acts) -> Call:
    """The call of a study."""

    def ask(ctx: Context, site: tree.Call, values: list[Value], places: list[Span]) -> Value:
        given = _Given(ctx, name, site, dict(zip(parameters, zip(values, places, strict=True), strict=True)))
        part, acting = given.part(), acts(given)
        known = elastic.elastic(ctx, name, {o: given.of[o] for o in OPTIONS}, site.span)
        if part is None or acting is None or known is None:
            return POISON
        if not known.dense and any(a.name == "weight" for a in acting):
            hint = "as in `density=1.01`, in g/cm^3, or name a material"
            return ctx.error("E184", "a weight takes a density", site.span, "it is missing here", hint=hint)
        listed = (n for a in acting for n in (const(CODE[a.name]), a.where, *a.numbers))
        balanced = const(float("balanced" in given.of and given.flag("balanced")))
        task = ctx.task(node("study", part, *known.nodes, balanced, *listed), site.span)
        members = _members(ctx, task, known, acting, site.span)
        return Study("study", members, task, {name: why for name, why in _WITHOUT.items() if name not in members})

    return ask


def _members(ctx: Context, task: Node, known: Elastic, acting: Sequence[Acting], site: Span) -> dict[str, Value]:
    """What a study gives, by name."""
    covered = node("and", node("covers", task, *_HERE), node("le", arguments.looked_up(task, DEPTH, False, None), ZERO))

    def field(name: str, beyond: Node | None = known.outside) -> Node:
        found = arguments.looked_up(task, _AT[name], known.smooth, None)
        return found if beyond is None else node("select", covered, found, beyond)

    none = None if known.outside is None else ZERO
    stress = {c: field(c, known.outside if c in ("xx", "yy", "zz") else none) for c in TENSOR}
    strain = {c: field(n, none) for c, n in zip(TENSOR, STRAIN, strict=True)}
    x, y, z = (field(c) for c in ("ux", "uy", "uz"))
    members: dict[str, Value] = {
        "von_mises": Scalar(field("von_mises"), STRESS),
        "energy": Scalar(field("energy"), STRESS),
        "displacement": Vector(x, y, z, LENGTH),
        "stress": Collection("tensor", {c: Scalar(n, STRESS) for c, n in stress.items()}),
        "strain": Collection("tensor", {c: Scalar(n, RATIO) for c, n in strain.items()}),
    }
    for k in "123":
        value, *way = (node("principal", *stress.values(), value=axis + k) for axis in "vxyz")
        members[f"principal{k}"] = Scalar(value, STRESS)
        members[f"direction{k}"] = Vector(way[0], way[1], way[2], RATIO)
    loading = [a.name for a in acting if a.name != "held"]
    for i, (name, dimension) in enumerate(NUMBERS.items()):
        if name == "stiffness":
            if len(loading) > 1 or loading[0] not in _STIFF:
                continue
            dimension = _STIFF[loading[0]]
        if name == "mass" and not known.dense:
            continue
        members[name] = Scalar(ctx.task(node("of_study", task, const(float(i))), site), dimension)
    return members


_PARAMETERS: dict[str, tuple[tuple[str, ...], int, _Acts, str]] = {
    "compress": (("part", "force", "axis", "platens"), 2, _compress,
                 "A part between two rigid platens that press its ends along an axis together with a force (a negative "
                 'one pulls): `compress(part, force=10kN, axis=z, material="PA12")`, a study. It slides on its '
                 'platens, or with `platens="bonded"` sticks to them.'),
    "shear": (("part", "force", "axis", "toward"), 2, _shear,
              "A part bonded to two rigid platens at its ends along an axis, of which one is moved `toward` an axis "
              "across by a force: a study, as `compress`."),
    "bend": (("part", "force", "axis", "toward", "supports", "span", "pads"), 2, _bend,
             "A part that lies along an axis (x) and is bent `toward` another (-z) by a force: a study, as `compress`. "
             "By three points, `span` apart (nine tenths of the part) on pads of a width `pads` (a twentieth); or with "
             '`supports="cantilever"` held at one end, the force spread over the other.'),
    "twist_load": (("part", "torque", "axis"), 2, _twist_load,
                   "A part held at one of its ends along an axis (z) and turned about it by a torque on the other, by "
                   "the right hand: a study, as `compress`."),
}  # fmt: skip
#: What asks for the tasks of these names.
CALLS: Mapping[str, Call] = {"study": _call("study", TASK_TABLE["study"].parameters, _study)}
BUILTINS = (
    *(
        Builtin(name, (*own, *OPTIONS), _call(name, (*own, *OPTIONS), acts), least, len(own) + len(OPTIONS), doc, True)
        for name, (own, least, acts, doc) in _PARAMETERS.items()
    ),
    *loads.BUILTINS,
)
