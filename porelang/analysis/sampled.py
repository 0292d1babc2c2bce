"""Fields at points that are drawn at random: where a solid is, and whether it ends.

Nothing here is proven. What samples find is there; what they do not find may be. It is for what need not be certain,
and has to be known within a few milliseconds, where an enclosing box takes a hundred.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.backwards import UNIVERSE
from porelang.backends.numpy import NumpyField
from porelang.formula import Bindings, Formula
from porelang.ir import SLOTS, Node, node, order, within
from porelang.rewrites import flatten

Points = NDArray[np.float64]
#: Points at which a field is looked at.
MOST = 4000
#: What of the material lies farthest is followed so many times, from so many points of it.
_FARTHER, _FOLLOWED = 40, 100


#: How the deepest place of a solid is looked for: steps, places that are followed, tries at each, and how much shorter
#: every step is. The last is a millionth of the first.
_STEPS, _LOWEST, _TRIES, _SHORTER = 28, 12, 40, 0.6


#: Points within a solid that are enough; how often twice MOST of them are tried, and for how many operations in all.
_ENOUGH, _TRIED, _WORK = MOST // 10, 12, 40_000_000
#: Solids of a union whose boxes are looked for one by one; of a box, how much is added to what samples found.
_APART, _BESIDE = 8, 0.02
#: Where nothing of a solid is known, how many times as far it is looked for as the least value says, and how many times
#: as near at most as the time before: the value may fall to 0 where two surfaces touch.
_NEAREST, _NEARER = 1.5, 4.0
#: How often a box is widened at most. It is known when it has grown by less than this factor so many times in a row;
#: one that grows by more than `_ENDLESS` to the last has no end.
_WIDENED, _GROWN, _STILL, _ENDLESS = 36, 1.02, 2, 1.5
#: More of a solid is looked for in a box wider by this part of it on each side, and about so many that are outermost
#: along each axis, at powers of ten of its size; of a single point, of this many mm.
_WIDER, _OUTER, _SCALES, _SMALLEST = 0.2, 8, (-3.0, 0.5), 1.0


#: The values of some nodes at points (n, 3), each (n,).
Sampler = Callable[[Points], list[Points]]


def sampler(roots: Sequence[Node], bindings: Bindings) -> Sampler | None:
    """The values of nodes at points; None where that would take long to find."""
    flat = flatten(*roots)
    if any(n not in bindings for n in order(flat, within) if n.op in SLOTS):
        return None
    fields = [NumpyField(Formula((r,), bindings), "f64", 1) for r in flat]

    def at(points: Points) -> list[Points]:
        with np.errstate(all="ignore"):
            return [np.broadcast_to(np.asarray(f.at(points), np.float64), len(points)) for f in fields]

    return at


def number(n: Node, bindings: Bindings) -> float | None:
    """The value of a node that is the same everywhere."""
    at = None if n.axes else sampler([n], bindings)
    value = np.nan if at is None else float(at(np.zeros((1, 3)))[0][0])
    return value if np.isfinite(value) else None


def unstretched(roots: Sequence[Node], bindings: Bindings) -> list[Node]:
    """The nodes below roots that are seen in their own mm: through no `at` but such as move and turn."""
    out: dict[Node, None] = {}
    todo = list(roots)
    while todo:
        n = todo.pop()
        if n in out:
            continue
        out[n] = None
        if n.op != "at":
            todo += within(n)
        elif keeps_lengths(n.args[1:], bindings):
            todo.append(n.args[0])
    return list(out)


def keeps_lengths(point: Sequence[Node], bindings: Bindings) -> bool:
    """Whether a place depends on the point as by a rotation and a translation, wherever samples look."""
    at = sampler([node("d", c, value=axis) for c in point for axis in range(3)], bindings)
    if at is None:
        return False
    slopes = np.stack(at(about_the_origin()[::100]), -1).reshape(-1, 3, 3)
    return bool(np.allclose(slopes @ slopes.transpose(0, 2, 1), np.eye(3), atol=1e-6))


def about_the_origin() -> Points:
    """Points (n, 3) of several scales, up to 256 mm from the origin."""
    scales = np.repeat([[2.0], [8.0], [32.0], [128.0], [256.0]], 2 * MOST // 5, 0)
    points: Points = np.random.default_rng(1).uniform(-1, 1, (len(scales), 3)) * scales
    return points


def inside_of(body: Node, bindings: Bindings) -> Points | None:
    """Points spread evenly within a solid; None where samples find none of it, or no end.

    Samples of several scales find some of it, or what is nearest, and a box round what was found is widened until it
    grows no more: of a union, each of its solids. A box that encloses it for certain would take ten times as long.
    """
    at, random = sampler([body], bindings), np.random.default_rng(1)
    if at is None:
        return None
    solids = _united(body)
    searches = [at] if len(solids) > _APART else [sampler([solid], bindings) for solid in solids]
    boxes = [None if one is None else _box_within(one, random) for one in searches]
    found = [box for box in boxes if box is not None]
    if not found or any(box is not None and not np.isfinite(box).all() for box in boxes):
        return None
    box = np.min([b[0] for b in found], axis=0), np.max([b[1] for b in found], axis=0)
    return _within(at, box, random, len(order(flatten(body))))


def _united(body: Node) -> list[Node]:
    return [solid for part in body.args for solid in _united(part)] if body.op == "min" else [body]


def _box_within(at: Sampler, random: np.random.Generator) -> Points | None:
    """The corners (2, 3) of a box round the points of a solid that samples find; infinite where they find no end, None
    where they find no point."""
    points, known = about_the_origin(), np.empty((0, 3))
    before, grown, still = 0.0, np.inf, 0
    nearest, farther, reach = np.inf, _NEAREST, 0.0
    for _ in range(_WIDENED):
        (values,) = at(points)
        known = np.concatenate([known, points[values < 0]])
        if not len(known):  # the nearest is about as far from it as its value says, if that is a distance
            if np.isnan(values).all():
                return None
            at_least = int(np.nanargmin(values))
            value = float(values[at_least])
            farther = _NEAREST if value < nearest / 2 else 2 * farther  # which hardly falls is no distance to it
            nearest, reach = value, max(farther * value, reach / _NEARER)
            if not 0 < reach < UNIVERSE:
                return None
            points = random.uniform(points[at_least] - reach, points[at_least] + reach, (MOST, 3))
            continue
        lo, hi = known.min(axis=0), known.max(axis=0)
        if max(np.abs(lo).max(), np.abs(hi).max()) >= UNIVERSE:
            return np.full((2, 3), np.inf)
        size = float(np.prod(hi - lo))
        grown = size / before if before else np.inf
        still = still + 1 if grown < _GROWN else 0
        if still == _STILL:
            break
        before = size
        points = _about(known, random)
    if not len(known):
        return None
    beside = _BESIDE * (hi - lo)
    return np.stack([lo - beside, hi + beside]) if grown < _ENDLESS else np.full((2, 3), np.inf)


def _about(known: Points, random: np.random.Generator) -> Points:
    """Points at which to look for more of a solid of which some are known: half of them within a box a little larger
    than what is known, half about its outermost ones, at distances of every scale, along each axis another: so a plate
    is followed as well as a ball, and what is known of a part of a tenth of a mm is soon all of it."""
    lo, hi = known.min(axis=0), known.max(axis=0)
    along = np.argsort(known, axis=0)
    outermost = known[np.concatenate([along[:_OUTER], along[-_OUTER:]]).ravel()]
    size = max(float(np.linalg.norm(hi - lo)), _SMALLEST)
    from_there = outermost[random.integers(len(outermost), size=MOST // 2)]
    scales = size * 10 ** random.uniform(*_SCALES, (MOST // 2, 3))
    more = _WIDER * (hi - lo)
    within = random.uniform(lo - more, hi + more, (MOST - MOST // 2, 3))
    return np.concatenate([within, from_there + scales * random.uniform(-1, 1, (MOST // 2, 3))])


def _within(at: Sampler, box: tuple[Points, Points], random: np.random.Generator, operations: int) -> Points:
    """Points within a solid in a box: of one that fills little of it, more are tried, as far as that takes no time."""
    found: Points = np.empty((0, 3))
    for _ in range(max(1, min(_TRIED, _WORK // (2 * MOST * operations)))):
        points = random.uniform(*box, (2 * MOST, 3))
        found = np.concatenate([found, points[at(points)[0] < 0]])
        if len(found) >= _ENOUGH:
            break
    return found


def depth_of(body: Node, bindings: Bindings) -> float | None:
    """About how far below 0 a solid's values go; None where samples find none of it, or no end.

    The lowest of many points are followed downhill by chance, with ever smaller steps: the middle of a ball is a point,
    and samples alone come no nearer to it than a twelfth of its radius.
    """
    points, at = inside_of(body, bindings), sampler([body], bindings)
    if points is None or at is None or not len(points):
        return None
    random = np.random.default_rng(1)
    (values,) = at(points)
    step = (points.max(axis=0) - points.min(axis=0)) / 8
    for _ in range(_STEPS):
        best = points[np.argsort(values)[:_LOWEST]]
        aside = random.uniform(-1, 1, (_TRIES * len(best), 3)) * step
        points = np.concatenate([best, np.repeat(best, _TRIES, 0) + aside])
        (values,) = at(points)
        step = _SHORTER * step
    return -float(np.nanmin(values))


def holds_anything(formula: Formula) -> bool:
    """Whether samples find material, about the origin or where the values of a part lead."""
    if bool((NumpyField(formula, "f64", 1).at(about_the_origin()) < 0).any()):
        return True
    points = inside_of(formula.root, formula.bindings)
    return points is not None and len(points) > 0


def unending(formula: Formula) -> str:
    """The axes along which samples find material beyond where parts are looked for, as text."""
    random = np.random.default_rng(1)
    near = random.choice([-1.0, 1.0], (1500, 3)) * 10 ** random.uniform(-2, np.log10(UNIVERSE), (1500, 3))
    found = ""
    for i, axis in enumerate("xyz"):
        points = near.copy()
        points[:, i] = np.copysign(random.uniform(UNIVERSE, 1.001 * UNIVERSE, 1500), near[:, i])
        found += axis if (NumpyField(formula, "f64", 1).at(points) < 0).any() else ""
    return ", ".join(found)


def seen(formula: Formula) -> tuple[Points, Points] | None:
    """The box of the material that samples find, in mm; None where they find none.

    What is found about the origin is followed outward, each time from what lies farthest, so that an end that is not
    there is seen as one that is beyond the universe, however thin what goes there is.
    """
    random = np.random.default_rng(1)
    field = NumpyField(formula, "f64", 1)

    def inside(points: Points) -> Points:
        return np.asarray(points[field.at(points) < 0])

    scales = np.repeat([[1e3], [1e4]], MOST, 0)
    found = [inside(about_the_origin()), inside(random.uniform(-1, 1, (len(scales), 3)) * scales)]
    if (spread := inside_of(formula.root, formula.bindings)) is not None:
        found.append(spread)
    points = np.concatenate(found)
    if not len(points):
        return None
    lo, hi = points.min(axis=0), points.max(axis=0)
    for _ in range(_FARTHER):
        farthest = points[np.argsort(-np.abs(points).max(axis=1))[:_FOLLOWED]]
        size = np.abs(farthest).max()
        if size >= UNIVERSE:
            break
        more = farthest[random.integers(len(farthest), size=MOST)]
        aside = random.normal(size=(MOST, 3)) * size * 10 ** random.uniform(-4, 0, (MOST, 1))
        points = np.concatenate([farthest, inside(more * random.uniform(1, 2, (MOST, 1)) + aside)])
        lo, hi = np.minimum(lo, points.min(axis=0)), np.maximum(hi, points.max(axis=0))
    return lo, hi
