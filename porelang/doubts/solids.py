"""Solids that are subtracted as numbers, cuts that cut nothing, and offsets that leave nothing."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from porelang.analysis.box import Box, part_box
from porelang.analysis.sampled import about_the_origin, depth_of, inside_of, sampler
from porelang.diagnostics import Diagnostic, Edit, Label
from porelang.elaborate.results import Elaborated, ParamInfo, Suspicion
from porelang.formula import Bindings, Formula
from porelang.ir import Node, node, order, param, unmoved, within
from porelang.rewrites import flatten

#: Nodes that are looked at for one program: more take longer than a warning is worth.
MOST_NODES, MOST_CUTS = 5000, 10
#: Boxes are looked for of graphs up to this size.
CLOSE = 400


def is_whole(s: Suspicion, roots: Collection[Node]) -> bool:
    """Whether a cut, or an offset, is one of the `roots` as a whole."""
    if s.what == "empty":
        return s.nodes[0] in [unmoved(root) for root in roots]
    return s.what == "apart" and s.name == "&" and node("max", *s.nodes) in roots


def idle_cuts(found: Elaborated, settings: Mapping[str, float]) -> list[Diagnostic]:
    """A warning for each cut that does nothing with these settings, or with a param at either end of its range.

    Of those that do nothing at the defaults, nor at any end, it has been said.
    """
    whole = {n for output in found.outputs.values() for n in output.nodes}
    defaults = {name: info.default for name, info in found.params.items()}
    out = []
    for s in [s for s in found.suspicions if s.what == "apart" and not is_whole(s, whole)][:MOST_CUTS]:
        tried = [settings, *_ends(s, found, settings)]
        if len(order(s.nodes, within)) * len(tried) > MOST_NODES or _is_idle_throughout(s, found, defaults):
            continue
        idle = next((t for t in tried if _is_idle(s, t)), None)
        if idle is not None:
            out.append(_idle(s, found, idle))
    return out


def _with(nodes: Sequence[Node], params: Mapping[str, ParamInfo], values: Mapping[str, float] | None = None) -> str:
    """The params that nodes depend on, with the values that were looked at: their defaults unless given."""
    shown = [f"{n} = {params[n].shown(params[n].default if values is None else values[n])}" for n in _params(nodes)]
    return f" with {', '.join(shown)}" if shown else ""


def _params(nodes: Sequence[Node]) -> list[str]:
    return sorted({str(n.value) for n in order(nodes, within) if n.op == "param"})


def total(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """Two solids whose values are added or subtracted."""
    a, b = s.nodes
    at = sampler([a, b], bindings)
    if at is None:
        return None
    one, other = at(about_the_origin())
    if not ((one < 0) & (other < 0)).any():  # of two that are apart it is the region nearer to one: that may be meant
        return None
    what, instead = ("the difference", "\\") if s.name == "-" else ("the union", "|")
    return Diagnostic(
        "W213",
        f"`{s.name}` works on the values of solids; {what} of two solids is `a {instead} b`",
        s.span,
        "arithmetic, and then taken as a solid",
        hint=f"write `{instead}`",
        edit=Edit(s.span, instead),
        severity="warning",
    )


def apart(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """Of a cut that misses now and meets its solid with a param at an end of its range nothing is said at once."""
    defaults = {name: info.default for name, info in found.params.items()}
    return _idle(s, found, defaults) if _is_idle_throughout(s, found, defaults) else None


def _is_idle_throughout(s: Suspicion, found: Elaborated, defaults: Mapping[str, float]) -> bool:
    """Whether two solids do not meet, and samples of the second at every end of a param's range do not either."""
    return _is_idle(s, defaults) and all(_meet(s, values) is False for values in _ends(s, found, defaults))


def _ends(s: Suspicion, found: Elaborated, settings: Mapping[str, float]) -> list[dict[str, float]]:
    """Settings with each param that nodes depend on at either end of its range, or at each of its choices."""
    infos = (found.params[name] for name in _params(s.nodes))
    return [{**settings, info.name: value} for info in infos for value in info.ends]


def _cut(s: Suspicion) -> tuple[Node, Node]:
    """The two solids of which nothing is in both."""
    a, b = s.nodes
    return a, node("neg", b) if s.name == "\\" else b


def _meet(s: Suspicion, settings: Mapping[str, float]) -> bool | None:
    """Whether samples of the second of two solids are in the first; None where there are no samples of it."""
    a, b = _cut(s)
    bindings: Bindings = {param(name): value for name, value in settings.items()}
    points, at = inside_of(b, bindings), sampler([a], bindings)
    return None if points is None or at is None else bool((at(points)[0] < 0).any())


def _is_idle(s: Suspicion, settings: Mapping[str, float]) -> bool:
    """Whether two solids do not meet: no sample of the second is in the first, and then it is proven."""
    if _meet(s, settings) is not False:
        return False
    (flat,) = flatten(node("max", *_cut(s)))
    bindings: Bindings = {param(name): value for name, value in settings.items()}
    return len(order([flat])) <= CLOSE and part_box(Formula((flat,), bindings)) is None


def _idle(s: Suspicion, found: Elaborated, values: Mapping[str, float]) -> Diagnostic:
    done = "takes nothing away" if s.name == "\\" else "leaves nothing"
    bindings: Bindings = {param(name): value for name, value in values.items()}
    hint, edit = "check where the second lies, and its unit", None
    if s.beside is not None and _meet(replace(s, nodes=(s.beside[1], s.nodes[1])), values):
        whole, text = s.beside[0], s.span.source.text
        ours = f"({text[whole.start : s.span.start].rstrip()}) {text[s.span.start : whole.end]}"
        shown = f"write `{ours}`" if len(ours) < 80 and "\n" not in ours else "put the union into brackets"
        hint, edit = f"`\\` binds more tightly than `|`, and cuts the last alone: {shown}", Edit(whole, ours)
    return Diagnostic(
        "W223",
        f"`{s.name}` {done} here{_with(s.nodes, found.params, values)}: the two solids do not meet",
        s.span,
        _gap(*(part_box(Formula(flatten(n), bindings)) for n in _cut(s))),
        () if s.argument is None else (Label(s.argument, "the second"),),
        hint,
        edit,
        "warning",
    )


def empty(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """Whether an inward offset leaves nothing, with the params as they are and at each end of a range."""
    made, body = s.nodes
    defaults = {name: info.default for name, info in found.params.items()}
    if not all(_holds_nothing(made, values) for values in (defaults, *_ends(s, found, defaults))):
        return None
    deep = depth_of(body, bindings)
    if deep is None:
        return None
    return Diagnostic(
        "W227",
        f"`{' '.join(s.span.text.split())}` leaves nothing{_with(s.nodes, found.params)}",
        s.span,
        f"no point of it lies more than about {deep:.3g} mm below its surface",
        hint=f"take away less than {deep:.3g} mm, or check the unit",
        severity="warning",
    )


def _holds_nothing(solid: Node, settings: Mapping[str, float]) -> bool:
    """Whether a solid is empty: samples find none of it, and then it is proven."""
    bindings: Bindings = {param(name): value for name, value in settings.items()}
    at = sampler([solid], bindings)
    if at is None or bool((at(about_the_origin())[0] < 0).any()) or inside_of(solid, bindings) is not None:
        return False
    flat = flatten(solid)
    if len(order(flat)) > CLOSE:
        return False
    box = part_box(Formula(flat, bindings))
    return box is None or min(box.size) <= 0  # a ball without its radius is a point, where it is 0


def _gap(a: Box | None, b: Box | None) -> str:
    """How far two boxes are apart, along the axis where that is most."""
    if a is None or b is None:
        return "apart"
    gaps = [(max(b.lo[i] - a.hi[i], a.lo[i] - b.hi[i]), i) for i in range(3)]
    gap, i = max(gaps)
    return f"{gap:.3g} mm apart along {'xyz'[i]}" if 0 < gap < 1e5 else "apart"
