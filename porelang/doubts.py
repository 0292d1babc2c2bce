"""What values show to be a mistake, of what `porelang.elaborate.suspect` noted while a program was elaborated.

Each suspicion is looked at with the params at their defaults, at some thousands of points: where those do not bear it
out, nothing is said. What reads a porosity, a file or anything else that takes long to find is left alone.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from porelang import doubts_of_frames as frames
from porelang.analysis.box import Box, part_box
from porelang.analysis.enclose import EXACT, at_points, enclose
from porelang.analysis.sampled import MOST, about_the_origin, depth_of, inside_of, number, sampler
from porelang.data import coordinates
from porelang.diagnostics import Diagnostic, Edit, Label
from porelang.elaborate.bare import value_of
from porelang.elaborate.results import Elaborated, ParamInfo, Suspicion
from porelang.formula import Bindings, Formula
from porelang.interval import interval
from porelang.ir import SLOTS, Node, X, Y, Z, node, order, param, substitute, unmoved, within
from porelang.periods import drifting
from porelang.rewrites import flatten
from porelang.settings import off_step
from porelang.source import Span

#: As many of the points that were looked at make a suspicion a doubt.
FEW = 8
#: Nodes that are looked at for one program: more take longer than a warning is worth.
MOST_NODES, MOST_CUTS = 5000, 10
#: Of the range that samples of a lattice have: how far its values go beyond.
BEYOND = 0.01
#: Boxes are looked for of graphs up to this size.
CLOSE = 400


def borne_out(found: Elaborated, bindings: Bindings) -> list[Diagnostic]:
    """A warning for each suspicion that values bear out, and for each name that nothing reads."""
    whole = {n for output in found.outputs.values() for n in output.nodes}  # of what is empty as a whole more is said
    looked_at = [s for s in found.suspicions if not _is_whole(s, whole)]
    out: list[Diagnostic] = []
    spent = cuts = 0
    for s in looked_at:
        size, cut = len(order(s.nodes, within)), s.what in ("apart", "empty")
        if spent + size > MOST_NODES or cuts + cut > MOST_CUTS:
            continue  # smaller ones may follow
        spent, cuts = spent + size, cuts + cut
        if (d := _LOOKS[s.what](s, found, bindings)) is not None:
            out.append(d)
    return [
        *out,
        *_unread(found),
        *off_step(found.params, {k: i.default for k, i in found.params.items()}, default=True),
    ]


def _is_whole(s: Suspicion, roots: Collection[Node]) -> bool:
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
    for s in [s for s in found.suspicions if s.what == "apart" and not _is_whole(s, whole)][:MOST_CUTS]:
        tried = [settings, *_ends(s, found, settings)]
        if len(order(s.nodes, within)) * len(tried) > MOST_NODES or _is_idle_throughout(s, found, defaults):
            continue
        idle = next((t for t in tried if _is_idle(s, t)), None)
        if idle is not None:
            out.append(_idle(s, found, idle))
    return out


def _figures(value: float) -> str:
    return f"{value:.3g}"


# ---- each kind of suspicion -----------------------------------------------------------------------------------------


def _with(nodes: Sequence[Node], params: Mapping[str, ParamInfo], values: Mapping[str, float] | None = None) -> str:
    """The params that nodes depend on, with the values that were looked at: their defaults unless given."""
    shown = [f"{n} = {params[n].shown(params[n].default if values is None else values[n])}" for n in _params(nodes)]
    return f" with {', '.join(shown)}" if shown else ""


def _params(nodes: Sequence[Node]) -> list[str]:
    return sorted({str(n.value) for n in order(nodes, within) if n.op == "param"})


def _total(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    a, b = s.nodes
    at = sampler([a, b], bindings)
    if at is None:
        return None
    one, other = at(about_the_origin())
    if not ((one < 0) & (other < 0)).any():  # of two that are apart it is the region nearer to one: that may be meant
        return None
    what, instead = ("the difference", "\\") if s.name == "-" else ("the union", "|")
    return _warning(
        "W213",
        f"`{s.name}` works on the values of solids; {what} of two solids is `a {instead} b`",
        s.span,
        "arithmetic, and then taken as a solid",
        f"write `{instead}`",
        edit=Edit(s.span, instead),
    )


def _copies(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    body, copies, *cell = s.nodes
    points, at = inside_of(body, bindings), sampler([copies], bindings)
    sizes = [number(w, bindings) for w in cell] or [0.0] * 3
    if points is None or at is None or any(w is None for w in sizes):
        return None
    points = points[:2500]
    least: NDArray[np.bool_] | None = None
    for bits in range(8 if cell else 1):  # a row of an even number has no copy in the middle
        shift = [0.5 * w * (bits >> i & 1) for i, w in enumerate(sizes) if w is not None]
        lost = at(points + shift)[0] > 0
        least = lost if least is None or lost.sum() < least.sum() else least
    assert least is not None
    share = least.sum() / len(points)
    if least.sum() < FEW or share < 0.002:
        return None
    parts = "sector" if not cell else "cell"
    far = points[least][int(np.argmax(np.abs(points[least]).sum(axis=1)))]
    place = coordinates(far, 3)
    if s.instead:
        hint = f"join copies that are turned one by one: `{s.instead}`"
    else:
        hint = "take larger cells, or join moved copies: `union([for i in range(n): translate(f, [w * i, 0, 0])])`"
    return _warning(
        "W215",
        f"`{s.name}` cuts its copies: each is seen only in its own {parts}, and {max(1, round(100 * share))} % is lost",
        s.span,
        f"({place}) of the body, for one",
        hint,
        edit=Edit(s.argument, s.instead) if s.argument is not None and s.instead else None,
    )


def _apart(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
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
    return _warning(
        "W223",
        f"`{s.name}` {done} here{_with(s.nodes, found.params, values)}: the two solids do not meet",
        s.span,
        _gap(*(part_box(Formula(flatten(n), bindings)) for n in _cut(s))),
        hint,
        () if s.argument is None else (Label(s.argument, "the second"),),
        edit,
    )


def _empty(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """Whether an inward offset leaves nothing, with the params as they are and at each end of a range."""
    made, body = s.nodes
    defaults = {name: info.default for name, info in found.params.items()}
    if not all(_holds_nothing(made, values) for values in (defaults, *_ends(s, found, defaults))):
        return None
    deep = depth_of(body, bindings)
    if deep is None:
        return None
    return _warning(
        "W227",
        f"`{' '.join(s.span.text.split())}` leaves nothing{_with(s.nodes, found.params)}",
        s.span,
        f"no point of it lies more than about {_figures(deep)} mm below its surface",
        f"take away less than {_figures(deep)} mm, or check the unit",
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


def _pores(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """Whether a wall is solid, or void, whatever value its lattice has."""
    walls, around = s.nodes
    lattices = [n for n in order([walls], within) if n in found.lattices]
    if not lattices:
        return None
    points, at = inside_of(around, bindings), sampler(lattices, bindings)
    if points is None or at is None:
        return None
    points = points[:500]
    ranges = at(np.random.default_rng(1).uniform(-100, 100, (1000, 3)))
    stand_in = {n: param(f"the value of lattice {i}") for i, n in enumerate(lattices)}
    replaced = flatten(substitute([walls], stand_in)[0])
    if any(n not in bindings for n in order(replaced, within) if n.op in SLOTS and n not in stand_in.values()):
        return None
    # samples do not reach the very ends of a range
    ends = [(r.min() - BEYOND * np.ptp(r), r.max() + BEYOND * np.ptp(r)) for r in ranges]
    levels = {p: interval(*end) for p, end in zip(stand_in.values(), ends, strict=True)}
    found_there = enclose(Formula(replaced, {**bindings, **levels}), at_points(points, EXACT))[0].range
    solid = bool((found_there.hi < 0).all())
    if (not solid and not (found_there.lo > 0).all()) or bool(found_there.nan.any()):
        return None
    low, high = min(float(r.min()) for r in ranges), max(float(r.max()) for r in ranges)
    return _warning(
        "W224",
        f"`{' '.join(s.span.text.split())}` is {'solid' if solid else 'void'} everywhere: the lattice is lost",
        s.span,
        f"the lattice runs from {low:.2g} to {high:.2g}",
        "its values are raw, not mm: " + ("take less" if solid else "take more, or check the sign"),
    )


def _seam(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    lattice, turn, made = s.nodes
    full = number(turn, bindings)
    if full is None or full == 0 or _closes(lattice, full, bindings) or not _seen(made, found, bindings):
        return None
    period = None if s.period is None else number(s.period, bindings)
    hint, edit = "take a whole multiple of the lattice's period", None
    if period:
        times = max(1, round(full / period))
        if _closes(lattice, times * period, bindings):
            hint = f"take a whole multiple of the period: {_figures(times)} x {period:g} = {times * period:g}"
            if s.argument is not None and re.fullmatch(r"(?:\w+\s*=\s*)?[\d.]+\s*(?:mm)?", s.argument.text):
                unit = "mm" if s.argument.text.endswith("mm") else ""
                edit = Edit(value_of(s.argument), f"{times * period:g}{unit}")
    return _warning(
        "W218",
        f"`{s.name}` leaves a seam: after a full turn of {full:g} mm the lattice does not meet itself",
        s.argument or s.span,
        f"{full / period:.4g} periods" if period else "no whole number of periods",
        hint,
        edit=edit,
    )


def _seen(made: Node, found: Elaborated, bindings: Bindings) -> bool:
    """Whether what lies at x < 0, y = 0 of a field can be seen in an output: a sector beside it has no seam."""
    random = np.random.default_rng(1)
    x = -(10 ** random.uniform(-1, 2.5, MOST))
    z = random.uniform(-1, 1, MOST) * 10 ** random.uniform(0, 2.5, MOST)
    for output in found.outputs.values():
        reached = order(output.nodes, lambda n: n.args[1:] if n.op == "at" else within(n))
        if made not in reached:  # it is not in it, or it was moved
            if made in order(output.nodes, within):
                return True
            continue
        at = sampler(output.nodes, bindings)
        if at is None:
            return True
        sides = [np.stack([x, 1e-6 * side * x, z], axis=1) for side in (-1, 1)]
        if any(bool(((a < 0) != (b < 0)).any()) for a, b in zip(at(sides[0]), at(sides[1]), strict=True)):
            return True
    return False


def _closes(lattice: Node, turn: float, bindings: Bindings) -> bool:
    """Whether a lattice is the same at y = -turn/2 and y = turn/2, on most of that plane."""
    points = np.random.default_rng(1).uniform(-100, 100, (MOST // 4, 3))
    ends = [node("at", lattice, X, (side * 0.5 * turn) + 0.0 * Y, Z) for side in (1, -1)]
    at = sampler(ends, bindings)
    if at is None:
        return True
    one, other = at(points)
    return float(np.mean((one < 0) != (other < 0))) < 0.005


_LOOKS: Mapping[str, Callable[[Suspicion, Elaborated, Bindings], Diagnostic | None]] = {
    "total": _total,
    "copies": _copies,
    "apart": _apart,
    "empty": _empty,
    "pores": _pores,
    "seam": _seam,
    "period": drifting,
    "still": frames.still,
    "fold": frames.fold,
    "fits": frames.fits,
}


# ---- names and steps ------------------------------------------------------------------------------------------------


def _unread(found: Elaborated) -> list[Diagnostic]:
    """Lets and params that nothing refers to, of a file that is more than a collection for others."""
    if not found.outputs:
        return []
    out = []
    for u in found.unread:
        if u.param:
            message, hint = f"nothing reads the param `{u.name}`", "use it, or leave it out: setting it changes nothing"
        else:
            message = f"nothing reads `{u.name}`"
            hint = (
                f"use it, or leave it out; call it `_{u.name}` if only an option names it, as in `--within _{u.name}`"
            )
            if u.fixed:
                hint = f'use it, or leave it out; call it `_{u.name}` if only Python asks for it: `number("_{u.name}")`'
        out.append(_warning("W220", message, u.span, "bound here, and not used", hint))
    return out


# ---- texts ----------------------------------------------------------------------------------------------------------


def _warning(
    code: str, message: str, span: Span, label: str, hint: str, others: tuple[Label, ...] = (), edit: Edit | None = None
) -> Diagnostic:
    return Diagnostic(code, message, span, label, others, hint, edit, "warning")
