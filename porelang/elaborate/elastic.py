"""What all studies take: the material of a part, the size and order of elements, what holds beyond the part."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from porelang.elaborate import arguments, bare, loads
from porelang.elaborate.context import Context
from porelang.elaborate.values import ABSENT, Poison, Scalar, Text, Value, describe
from porelang.ir import ONE, ZERO, Node, Stage, const, node
from porelang.materials import DENSEST, MATERIALS, STIFFEST, named, nearest
from porelang.source import Span
from porelang.units import LENGTH, STRESS

#: The options of every study, in this order.
OPTIONS = ("material", "E", "nu", "density", "size", "order", "outside", "smooth")
#: Values of an option, with their places, by its name.
Options = Mapping[str, tuple[Value, Span]]


@dataclass(frozen=True, slots=True)
class Elastic:
    """The arguments `HEAD` of a study but its part and its balance, and how what it gives is read: with what is beyond
    the part (None: what is nearest inside), and whether smoothly. `dense` says that its density is known."""

    nodes: tuple[Node, ...]
    outside: Node | None
    smooth: bool
    dense: bool


def elastic(ctx: Context, name: str, given: Options, site: Span) -> Elastic | None:
    """What a study `name` is given beside its part and its loads; None after saying what is wrong with it."""
    material = _material(ctx, name, given, site)
    size = _size(ctx, name, *given["size"])
    order = _order(ctx, name, *given["order"])
    outside, place = given["outside"]
    beyond = None
    if outside is not ABSENT:
        beyond = loads.number(ctx, outside, place, f"`outside` of `{name}`", None, "outside=0", field=True)
        if isinstance(outside, Scalar) and outside.dimension is not None:
            hint = "all that it gives has this value there: leave out the unit, as in `outside=0`"
            ctx.error("E062", f"`outside` of `{name}` is a bare number, not {outside.dimension}", place, hint=hint)
            return None
    smooth = arguments.flag(ctx, *given["smooth"], "smooth")
    if material is None or size is None or order is None or smooth is None:
        return None
    if beyond is None and outside is not ABSENT:
        return None
    young, nu, density, yields = material
    return Elastic((young, nu, density, size, order, yields), beyond, smooth, density is not ZERO)


def _material(ctx: Context, name: str, given: Options, site: Span) -> tuple[Node, Node, Node, Node] | None:
    """Young's modulus, Poisson's ratio, density, and where it yields (0: not known); what is given by itself counts
    before what a table says."""
    material, place = given["material"]
    young: Node | None = None
    nu: Node | None = None
    density: Node | None = ZERO
    yields = ZERO
    if material is not ABSENT:
        material = ctx.decided(material)
        if isinstance(material, Poison):
            return None
        found = named(material.value) if isinstance(material, Text) else None
        if found is None:
            near = nearest(material.value) if isinstance(material, Text) else None
            known = f"the materials are {', '.join(MATERIALS)}; of others give `E` and `nu`"
            hint = f'did you mean "{near}"? {known}' if near else known
            what = f'"{material.value}" is no material that is known' if isinstance(material, Text) else (
                f"`material` of `{name}` is the name of one, not {describe(material)}")  # fmt: skip
            ctx.error("E184", what, place, hint=hint)
            return None
        young, nu, density = const(found.young), const(found.poisson), const(found.density)
        yields = const(found.yields or 0.0)
    if given["E"][0] is not ABSENT:
        young = loads.number(ctx, *given["E"], f"`E` of `{name}`", STRESS, "E=1.7GPa", field=True)
    if given["nu"][0] is not ABSENT:
        nu = loads.number(ctx, *given["nu"], f"`nu` of `{name}`", None, "nu=0.3", field=True)
    if given["density"][0] is not ABSENT:
        density = loads.number(ctx, *given["density"], f"`density` of `{name}`", None, "density=1.01", field=True)
    if young is None or nu is None or density is None:
        if all(given[k][0] is ABSENT for k in ("material", "E", "nu")):
            hint = 'name one, `material="PA12"`, or give `E=1.7GPa, nu=0.4`'
            if name == "bend":  # other programs call so what bends a shape
                hint += "; what bends a shape, and not by a force, is `polar(f, turn)`"
            ctx.error("E184", f"`{name}` needs a material", site, "an argument is missing here", hint=hint)
        elif material is ABSENT and given["E"][0] is ABSENT:
            hint = "as in `E=1.7GPa`"
            ctx.error(
                "E184", f"`{name}` needs `E`, Young's modulus, beside `nu`", site, "it is missing here", hint=hint
            )
        elif material is ABSENT and given["nu"][0] is ABSENT:
            hint = "as in `nu=0.3`"
            ctx.error(
                "E184", f"`{name}` needs `nu`, Poisson's ratio, beside `E`", site, "it is missing here", hint=hint
            )
        return None
    limits = (
        ("E", young, node("lt", ZERO, young), "a modulus above 0", "as in `E=1.7GPa`"),
        ("nu", nu, _between(const(-1.0), nu, const(0.5)), "a Poisson's ratio between -1 and 0.5",
         "at 0.5 a material keeps its volume, and its pressure is not told by its strain: take 0.49 at most; at -1 it "
         "keeps its shape"),
        ("density", density, node("le", ZERO, density), "a density above 0", "in g/cm^3, as in `density=1.01`"),
    )  # fmt: skip
    sound = [_holds(ctx, name, *limit, given, site) for limit in limits]
    if not all(sound):
        return None
    _doubt_units(ctx, young, density, given)
    return young, nu, density, yields


def _doubt_units(ctx: Context, young: Node, density: Node, given: Options) -> None:
    """W273 for numbers that no material has and that look like those of other units. Of what is not known yet, a study
    tells when it is solved."""
    for parameter, n, limit in (("E", young, STIFFEST), ("density", density, DENSEST)):
        known = ctx.constant(n)
        if isinstance(known, float) and known > limit.value:
            bare.doubt(ctx, "W273", limit.said(known), given[parameter][1], limit.why, limit.hint(known))


def _between(low: Node, n: Node, high: Node) -> Node:
    return node("and", node("lt", low, n), node("lt", n, high))


def _holds(
    ctx: Context, name: str, parameter: str, n: Node, condition: Node, what: str, hint: str, given: Options, site: Span
) -> bool:
    """Whether a number of a material can be one: now, where it is known; for all settings; of a field it is seen when
    it is computed."""
    place = given[parameter][1] if given[parameter][0] is not ABSENT else site
    if n.stage is Stage.UNIFORM:
        ctx.require(condition, f"`{name}` needs {what}", place, ())
    known = ctx.constant(n)
    if known is None or ctx.constant(condition):
        return True
    ctx.error("E185", f"`{name}` needs {what}", place, label=f"this is {known:g}", hint=hint)
    return False


def _size(ctx: Context, name: str, value: Value, place: Span) -> Node | None:
    if value is ABSENT:
        return ZERO
    found = loads.number(ctx, value, place, f"`size` of `{name}`", LENGTH, "size=4mm")
    known = None if found is None else ctx.constant(found)
    if known is not None and not known > 0:
        what = f"elements of `{name}` have a size above 0"
        ctx.error("E187", what, place, label=f"this is {known:g} mm", hint="as in `size=4mm`, or leave it out")
        return None
    return found


def _order(ctx: Context, name: str, value: Value, place: Span) -> Node | None:
    """Of which order elements are: the second unless told otherwise."""
    if value is ABSENT:
        return const(2.0)
    known = ctx.need_constant(value, place, f"`order` of `{name}`", fixing=True)
    if known is None:
        return None
    if known not in (1, 2):
        hint = "2 is the better one for its cost: elements of order 1 are a tenth too stiff on lattices"
        ctx.error("E187", f"`order` of `{name}` is 1 or 2", place, label=f"this is {known:g}", hint=hint)
        return None
    return ONE if known == 1 else const(2.0)
