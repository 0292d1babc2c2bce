"""Lengths that are added to what was a distance: what they are in mm, where the part has its surface."""

from __future__ import annotations

import numpy as np

from porelang.analysis.sampled import Points, Sampler, keeps_lengths, sampler
from porelang.diagnostics import Diagnostic, Edit
from porelang.doubts.parts import Part, parts_of, seen_from, way_to
from porelang.elaborate.natures import moves
from porelang.elaborate.results import Elaborated, Suspicion
from porelang.formula import Bindings
from porelang.ir import ZERO, Node, const, node, order, substitute, within
from porelang.rewrites import flatten

#: By how much a length may miss what it says, at as large a share of the points that are looked at, before it is said.
OFF, SHARE = 0.1, 0.05
#: The share of a wall from `metric`: up to the walls of the manual's table it was at most 0.003 of 21 lattices, at
#: twice these 0.003 to 0.14.
_NARROW = 0.02
#: Points that are enough and that are too few; how many are tried at a time, and for how many operations in all.
_MOST, _FEW, _TRIED, _WORK = 500, 200, 8000, 80_000_000
#: How far apart (mm) the values are of which a slope is taken.
_STEP = 1e-4
#: By how much of a length a surface is left and met again; how many times as far as it says a length is looked for.
_NEAR, _WIDEST = 1e-3, 5.0
#: The square of the least slope that is divided by; of how much of a part nothing is said to be left.
_LEVEL = const(1e-24)
_LEFT = 0.01


def is_idle(s: Suspicion, found: Elaborated) -> bool:
    """Whether a length is added nowhere in what is made, as in branches of a function that are not taken; or nothing
    was stretched on the way to it, nor is on the way from it."""
    if s.what != "uneven":
        return False
    field, length = s.nodes[:2]
    roots = [output.nodes[0] for output in found.outputs.values() if len(output.nodes) == 1]
    if not any(n.op in ("add", "sub") and {*n.args} == {field, length} for n in order(roots, within)):
        return True
    ways = [way for root in roots if len(s.nodes) == 2 and (way := way_to(field, root)) is not None]
    return len(s.nodes) == 2 and not any(n.op == "at" and not moves(n.args[1:]) for way in ways for n, _ in way)


def uneven(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """A length that is not what it says, because the field it is added to does not rise by 1 mm in each mm.

    Where a field rises by g, what is added to it is 1/g times as far, to first order. Said is it only where that
    comes from what was stretched, scaled or mixed, or is once the length was added: a fillet rises by less too, and
    is meant. So is what is twice as large as a whole.
    """
    field, length, *causes = s.nodes
    causes = [n for n in causes if n.op != "at" or not keeps_lengths(n.args[1:], bindings)]
    if causes and _said_below(s, found, bindings):
        return None
    for part, inside in parts_of(field, found, bindings):
        bent = [n for n, _ in part.way if n.op == "at" and not keeps_lengths(n.args[1:], bindings)]
        if not (bent or causes):
            continue
        ways = [way_to(n, field) for n in causes]
        made = [seen_from([*part.way, *w], n) for w, n in zip(ways, causes, strict=True) if w is not None]
        if len(made) < len(causes):  # what is within a task cannot be told from its fillets
            made = [part.seen(field)]
        # with what was bent afterwards, all that it made longer
        at = sampler([part.seen(field), *made, part.seen(length)], bindings)
        own = sampler([part.seen(_steepness(field)) if bent else ZERO], bindings)
        points = None if at is None else _beside(part, inside, field, length, at, bindings)
        if at is None or own is None or points is None or len(points) < _FEW:
            return None
        real = _real(at, points)[:-1]
        with np.errstate(over="ignore"):
            longer = real[0] * np.asarray(own(points)[0])
        if np.isnan(real).any() or np.isnan(longer).any():
            return None
        if bent and np.ptp(np.log(longer)) < np.log(1 + OFF):  # all of it larger or smaller
            continue
        wrong = np.abs(np.log(real)) > np.log(1 + OFF)
        off = wrong[0] & (np.abs(np.log(longer)) > np.log(1 + OFF) if bent else wrong[1:].any(axis=0))
        if off.mean() >= (_NARROW if s.name else SHARE):
            if bent:
                return _told_bent(s, real[0][off], float(off.mean()))
            if s.name:
                return _told_narrow(s, real[0][off], float(off.mean()))
            return _told(s, real[0][off], float(off.mean()), _mends(part, inside, field, bindings))
    return None


def _steepness(field: Node) -> Node:
    """How much a field rises in each mm."""
    slopes = (node("square", node("d", field, value=axis)) for axis in range(3))
    return node("sqrt", node("max", sum(slopes, ZERO), _LEVEL))


def _real(at: Sampler, points: Points) -> Points:
    """How long 1 of each of some fields is in mm, to first order (fields, n)."""
    sizes = sum(((a - b) / (2 * _STEP)) ** 2 for a, b in ((np.stack(at(points + e)), np.stack(at(points - e)))
                for e in _STEP * np.eye(3)))  # fmt: skip
    with np.errstate(divide="ignore"):
        return np.asarray(1 / np.sqrt(sizes))


def _said_below(s: Suspicion, found: Elaborated, bindings: Bindings) -> bool:
    """Whether it is said of a wall of which this is one again, and nothing was stretched between."""
    field, _, *causes = s.nodes
    below = set(order([field], within)) - {field}
    others = [o for o in found.suspicions if o.what == "uneven" and o.nodes[0] in below and o.span != s.span]
    return any(set(o.nodes[2:]) == set(causes) and uneven(o, found, bindings) is not None for o in others)


def _beside(part: Part, inside: Points, field: Node, length: Node, at: Sampler, bindings: Bindings) -> Points | None:
    """Points (n, 3) between the surface of a field and where a length moves it, where that moved surface is one of an
    output: of a hole and of a thin wall too. What is added to a field that is a thickness or a weight moves none,
    however much of what is solid it decides."""
    sides = [const(side * (1 + more)) * length for side in (-1.0, 1.0) for more in (-_NEAR, _NEAR)]
    solids = sampler([substitute([part.root], {field: i})[0] for i in sides], bindings)
    if solids is None:
        return None
    lo, hi = inside.min(axis=0), inside.max(axis=0)
    random, out = np.random.default_rng(1), np.empty((0, 3))
    # a length reaches as far as it is stretched, from a part that it may have made smaller
    more = np.abs(at(inside)[-1]).max() * np.clip(np.nanquantile(_real(at, inside[:_FEW])[0], 0.95), 1, _WIDEST)
    for _ in range(max(1, min(16, _WORK // (_TRIED * len(order(flatten(field))))))):
        points = random.uniform(lo - more, hi + more, (_TRIED, 3))
        values, *_, lengths = at(points)
        between = np.abs(values) <= np.abs(lengths)
        points, up = points[between], (values * lengths)[between] >= 0
        if len(points):
            a, b, c, d = np.stack(solids(points)) < 0
            out = np.concatenate([out, points[np.where(up, c != d, a != b)]])
        if len(out) >= _MOST:
            break
    return out[:_MOST]


def _mends(part: Part, inside: Points, field: Node, bindings: Bindings) -> bool:
    """Whether more than a hundredth of a part is left where the field is the distance to its surface, as far as its
    slope tells."""
    at = sampler([substitute([part.root], {field: field / _steepness(field)})[0]], bindings)
    values = None if at is None else at(inside)[0]
    return values is not None and bool(np.isfinite(values).all() and (values < 0).mean() > _LEFT)


def _told(s: Suspicion, real: Points, share: float, mends: bool) -> Diagnostic:
    """What 1 mm is, at the places where it is not 1 mm."""
    by = "write" if s.instead else "put"
    left = "" if mends else "; as many mm as are written leave nothing of this part, so take another length as well"
    return Diagnostic(
        "W238",
        f"a length is added to what is a distance no longer: {_measure(real, share)}",
        s.span,
        "stretched, turned or mixed, its values are no mm",
        hint=f"{by} `{s.instead}`: the distance to what was made{left}" if s.instead
        else f"{by} `metric(...)` about the field that the length is added to{left}",
        edit=Edit(s.argument, s.instead) if s.argument is not None and mends else None,
        severity="warning",
    )  # fmt: skip


def _told_bent(s: Suspicion, real: Points, share: float) -> Diagnostic:
    """What 1 mm is once it was stretched with what it is a length of."""
    return Diagnostic(
        "W238",
        f"what a length was added to is stretched afterwards: {_measure(real, share)}",
        s.span,
        "of these mm, where the part is",
        hint="add it last: put `metric(...)` about what is stretched, and the length behind it",
        severity="warning",
    )


def _told_narrow(s: Suspicion, real: Points, share: float) -> Diagnostic:
    """What 1 mm is where `metric` has found no distance, but a guess of it."""
    return Diagnostic(
        "W238",
        f"a length is longer than there is room between the sheets of a lattice: {_measure(real, share)}",
        s.span,
        f"there `{s.name}` is a guess, not a distance",
        hint="take a shorter length or a longer period; the manual says up to which part of its period the walls of "
        "each lattice are what they say, under `Walls in mm`",
        severity="warning",
    )


def _measure(real: Points, share: float) -> str:
    low, high = np.quantile(real, [0.05, 0.95])
    much = f"{low:.2g} to {high:.2g}" if high - low > 0.05 else f"{high:.2g}"
    return f"1 mm of it is {much} mm long" + ("" if share > 0.95 else f" at {100 * share:.0f} % of its surface")
