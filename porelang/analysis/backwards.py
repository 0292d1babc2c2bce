"""Rough boxes of solids, by reading their formulas backwards: `root <= 0` says what its arguments can be, and so on
down to x, y and z (interval constraint propagation, HC4: Benhamou et al. 1999, "Revising hull and box consistency").

What is the lesser of two is one or the other: both are followed, and the box holds either (constructive disjunction).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.enclose import EXACT, F64, Precision, enclose_all
from porelang.analysis.kin import Kin, Points, kin_of, members
from porelang.analysis.turned import solved, turns
from porelang.data import FARTHEST
from porelang.formula import Formula
from porelang.interval import Interval, interval, meet
from porelang.ir import ZERO, Node, X, Y, Z, is_const, node, order, substitute, within
from porelang.ops import TABLE
from porelang.tape import PICK, Tape

#: Parts are looked for within this distance of the origin, in mm, along each axis.
UNIVERSE = FARTHEST
#: Unions within smooth unions within ... are followed this deep, and clamps (`min(u, 0)`) within each other so deep.
DEEPEST, CLAMPED = 40, 1
_TURNS, _TURNED = 4, 8
#: Intersections of so many operations are bounded by their sides, one by one.
_LONG = 120
#: Clamps are taken apart where that does not read more operations than this.
_HALVED = 2000
#: So many operations are read before no more branches are followed, of a solid and of those that share parts with it: a
#: third of a second. A field without an end has branches within branches, of which none leads to one.
MOST = 10_000
_NEARLY = 1 - 1e-9
#: What an operation read backwards rounds, at most, in epsilons of the largest number it reads.
_ROUNDINGS = 4.0

#: Boxes (n, 3) .. (n, 3); where lo > hi there is nothing.
Rough = tuple[Points, Points]


def rough_boxes(kin: Kin, seen: Seen | None = None) -> Rough:
    """A box of each solid within the universe: never too small, exact for many plain shapes, infinite for lattices.

    `seen` keeps what was found from one solid to the next that shares parts with it.
    """
    return _held(kin, _Bound(0.0), DEEPEST, CLAMPED, Seen() if seen is None else seen)


def surely_void(kin: Kin) -> NDArray[np.bool_]:
    """Which solids are proven to hold no point where `root < 0`, though there may be some where it is 0: as where a
    shape is cut by one that covers it, and both end at one surface."""
    lo, hi = _held(kin, _Bound(0.0, kin.formula.root), DEEPEST, CLAMPED, Seen())
    return np.asarray((lo > hi).any(axis=1), np.bool_)


@dataclass(frozen=True, slots=True)
class _Bound:
    """That `root <= most`; and `below` (a node), if given, is less than `most`."""

    most: float
    below: Node | None = None


@dataclass(slots=True)
class Seen:
    """Boxes that were found, by the root, what is known of it, how deep was looked, and how many solids have which
    numbers; and how many more operations may be read while branches are followed."""

    boxes: dict[tuple[Node, _Bound, tuple[bool, int], int, bytes], Rough] = field(default_factory=dict)
    left: int = MOST


def _held(kin: Kin, bound: _Bound, depth: int, clamps: int, seen: Seen) -> Rough:
    """Boxes of `root <= most`."""
    key = (kin.formula.root, bound, (bool(depth), clamps), len(kin), kin.numbers.tobytes())
    if key not in seen.boxes:
        seen.boxes[key] = _found(kin, bound, depth, clamps, seen)
    lo, hi = seen.boxes[key]
    return lo.copy(), hi.copy()


def _found(kin: Kin, bound: _Bound, depth: int, clamps: int, seen: Seen) -> Rough:
    if (cut := _by_sides(kin, bound, depth, clamps, seen)) is not None:
        return cut
    halves = _halves(kin, bound) if clamps else []
    if len(halves) * len(kin.formula.tape) > _HALVED:
        halves = []
    seen.left -= len(kin.formula.tape)
    known, lo, hi = _pushed_back(kin, bound, 1 if halves else _TURNS)
    there = np.flatnonzero((lo <= hi).all(axis=1))
    if not len(there):
        return lo, hi
    for either in halves:
        low, high = _hull([_held(part, least, 0, clamps - 1, seen) for part, least in either], len(kin))
        lo, hi = np.maximum(lo, low), np.minimum(hi, high)
    far = np.flatnonzero(((hi - lo).max(axis=1) >= UNIVERSE) & (lo <= hi).all(axis=1))
    if depth and len(far) and seen.left > 0:
        some = kin.some(far)
        lo[far], hi[far] = _by_branches(some, _rows(known, far, len(kin)), lo[far], hi[far], depth, seen)
    return lo, hi


def _by_sides(kin: Kin, bound: _Bound, depth: int, clamps: int, seen: Seen) -> Rough | None:
    """Boxes of a long intersection by its sides, each by itself and short ones first: a bundle of tubes without its
    bores reads 37 of them for each of its tubes. Where some of them end, branches of the others are not followed: a rod
    ends a lattice along its curve, which has a choice for each corner. None of a short one, and where the sides do not
    end by themselves."""
    root = kin.formula.root
    if root.op != "max" or bound.below is not None or len(kin.formula.tape) < _LONG:
        return None
    lo, hi = np.full((len(kin), 3), -UNIVERSE), np.full((len(kin), 3), UNIVERSE)
    ends = False
    for side in sorted(_sides(root), key=lambda n: len(order([n], within))):
        if not side.axes:
            return None
        # what a solid is cut by has no end, whatever is in it
        low, high = _held(
            kin.with_root(side), bound, 0 if ends else depth, 0 if ends or side.op == "neg" else clamps, seen
        )
        lo, hi = np.maximum(lo, low), np.minimum(hi, high)
        ends = not ((lo <= hi).all(axis=1) & ((hi - lo).max(axis=1) >= UNIVERSE)).any()
    return (lo, hi) if ends else None


def _sides(root: Node) -> list[Node]:
    """What a solid is the intersection of."""
    return [root] if root.op != "max" else list(dict.fromkeys(side for a in root.args for side in _sides(a)))


def _rows(known: Mapping[int, Interval], rows: NDArray[np.intp], count: int) -> dict[int, Interval]:
    """What is known of some rows alone."""

    def taken(values: NDArray[Any]) -> NDArray[Any]:
        return np.broadcast_to(values, (count,))[rows]

    return {i: Interval(taken(r.lo), taken(r.hi), taken(r.nan)) for i, r in known.items()}


def _pushed_back(kin: Kin, bound: _Bound, times: int) -> tuple[dict[int, Interval], Points, Points]:
    """What is known of every position where `root <= most`, and of the coordinates: pushed back a few times over.

    Ends are exact but for rounding, so that those of plain shapes come out as they were written. Where they leave
    nothing they may have missed each other by a rounding alone, as those of a product that is 0 in a sum that is 0
    (`metric` of what turns with data, where these have no slope): that nothing is there is told by wider ones.
    """
    known, lo, hi, gone = _read_backwards(kin, bound, times, EXACT)
    if not len(gone):
        return known, lo, hi
    wider, lo[gone], hi[gone], still = _read_backwards(kin.some(gone), bound, times, F64)
    if len(still) < len(gone):
        for i, r in known.items():
            low, high, nan = (np.broadcast_to(values, (len(kin),)).copy() for values in (r.lo, r.hi, r.nan))
            low[gone], high[gone], nan[gone] = wider[i].lo, wider[i].hi, wider[i].nan
            known[i] = Interval(low.astype(np.float64), high.astype(np.float64), nan.astype(np.bool_))
    return known, lo, hi


def _read_backwards(
    kin: Kin, bound: _Bound, times: int, precision: Precision
) -> tuple[dict[int, Interval], Points, Points, NDArray[np.intp]]:
    """What is known, and of which solids nothing is left because ends miss each other."""
    count = len(kin)
    formula = kin.of(np.arange(count))
    tape = formula.tape
    root = tape.roots[0]
    space = [interval(np.full(count, -UNIVERSE), np.full(count, UNIVERSE)) for _ in range(3)]
    known: dict[int, Interval] = {}
    places = [tape.position.get(n) for n in (X, Y, Z)]
    turned = turns(tape)
    gone, missed = np.zeros(count, np.bool_), np.zeros(count, np.bool_)
    below = None if bound.below is None else tape.position.get(bound.below)
    for turn in range(_TURNED if turned and times > 1 else times):
        known = {i: e.range for i, e in enclose_all(formula, space, precision, held=known).items()}
        known[root] = meet(known[root], interval(np.full(count, -np.inf), np.full(count, bound.most)))
        if below is not None:
            gone |= known[below].lo >= bound.most
        with np.errstate(all="ignore"):
            _narrow_all(formula, known, precision)
            more = turned and _solved(tape, known)
            if more:
                _narrow_all(formula, known, precision)
        before = space
        space = [s if at is None else meet(s, known[at]) for at, s in zip(places, space, strict=True)]
        missed |= np.any([s.lo > s.hi for s in (*space, known[root])], axis=0) & ~gone
        gone |= missed
        # what is gone stays in the arrays as the whole of space, so that nothing after it meets an empty range
        space = [Interval(np.where(gone, -UNIVERSE, s.lo), np.where(gone, UNIVERSE, s.hi), s.nan) for s in space]
        if gone.any():
            known = {i: Interval(np.where(gone, -np.inf, r.lo), np.where(gone, np.inf, r.hi), r.nan)
                     for i, r in known.items()}  # fmt: skip
        shrunk = [(s.hi - s.lo) <= 0.95 * (b.hi - b.lo) for s, b in zip(space, before, strict=True)]
        if turn == 0 and below is not None:
            continue
        if not more and not (np.any(shrunk, axis=0) & ~gone).any():
            break
    lo, hi = (np.stack([np.broadcast_to(end, (count,)) for end in ends], axis=1).astype(np.float64)
              for ends in ([s.lo for s in space], [s.hi for s in space]))  # fmt: skip
    # an end that only rounding set apart from that of the universe is none
    lo, hi = np.where(lo <= -_NEARLY * UNIVERSE, -UNIVERSE, lo), np.where(hi >= _NEARLY * UNIVERSE, UNIVERSE, hi)
    lo[gone], hi[gone] = np.inf, -np.inf
    return known, lo, hi, np.flatnonzero(missed)


def _narrow_all(formula: Formula, known: dict[int, Interval], precision: Precision) -> None:
    for i in reversed(formula.tape.field):
        _narrow(formula, i, known, precision)


def _narrow(formula: Formula, i: int, known: dict[int, Interval], precision: Precision) -> None:
    """What the range of an operation's result says of its arguments, met with what is known of them."""
    tape = formula.tape
    inputs, op = tape.inputs[i], tape.ops[i]
    if op == PICK:  # of a walk with several results, the first is what narrows
        walk = inputs[0]
        row = TABLE[tape.ops[walk]]
        if row.narrow is None or tape.values[i] != row.results[0]:
            return
        inputs = tape.inputs[walk]
    else:
        row = TABLE[op]
        if row.narrow is None or row.results:
            return
    arguments = [known[a] if a in known else formula.known[a] for a in inputs]
    more = [tape.values[i]] if row.payload else []
    for a, r in zip(inputs, row.narrow(known[i], *arguments, *more), strict=True):
        if tape.axes[a] and r is not None:
            known[a] = meet(known[a], _widened(r, [known[i], *arguments], precision) if precision.eps else r)


def _widened(r: Interval, made_of: list[Any], precision: Precision) -> Interval:
    """A range with what rounding may have moved its ends by: a few parts in the largest number that it is made of."""
    ends = [np.abs(end) for of in (r, *made_of) if isinstance(of, Interval) for end in (of.lo, of.hi)]
    ends += [np.abs(of) for of in made_of if isinstance(of, float)]
    size: Any = 0.0
    for end in ends:
        size = np.maximum(size, np.where(np.isfinite(end), end, 0.0))
    slack = _ROUNDINGS * precision.eps * size + precision.tiny
    return Interval(r.lo - slack, r.hi + slack, r.nan)


def _solved(tape: Tape, known: dict[int, Interval]) -> bool:
    """Met with what is known: what linear forms and turns tell, solid by solid. Whether that is much."""
    count = max(r.lo.size for r in known.values())
    told: dict[int, tuple[Points, Points]] = {}
    more = False
    for row in range(count):
        for i, (lo, hi) in solved(tape, _rows(known, np.array([row]), count), UNIVERSE).items():
            if i not in told:
                told[i] = np.full(count, -np.inf), np.full(count, np.inf)
            told[i][0][row], told[i][1][row] = lo, hi
    for i, (low, high) in told.items():
        before = known[i]
        known[i] = meet(before, interval(low, high))
        more |= bool(np.any(known[i].hi - known[i].lo < 0.95 * (before.hi - before.lo)))
    return more


def _halves(kin: Kin, bound: _Bound) -> list[tuple[tuple[Kin, _Bound], tuple[Kin, _Bound]]]:
    """For each `min(u, 0)` in the formula, the solid where it is 0, and where it is u, and what is known of the roots.

    The distance from a box is `length(max(q, 0)) + min(max(q), 0)`: with both terms at once it may be twice as far.
    """
    root = kin.formula.root
    tape = kin.formula.tape
    found = []
    for i in tape.field:
        n = tape.nodes[i]
        if tape.ops[i] == "min" and n is not root and any(is_const(a, 0.0) for a in n.args):
            (u,) = (a for a in n.args if not is_const(a, 0.0))
            outside, inside = (substitute([root], {n: by})[0] for by in (ZERO, u))
            if u.axes and outside.axes and inside.axes:
                most = inside - bound.most
                strictly = bound.below is not None
                found.append((
                    (kin.with_root(outside), _Bound(bound.most, outside if strictly else None)),
                    (kin.with_root(node("max", most, u)), _Bound(0.0, most if strictly else None)),
                ))  # fmt: skip
    return found


def _hull(parts: list[Rough], count: int) -> Rough:
    """The boxes that hold those of every part, of so many solids; of one solid a part may be several."""
    if count == 1:
        parts = [(lo.min(axis=0, keepdims=True), hi.max(axis=0, keepdims=True)) for lo, hi in parts]
    return np.min([p[0] for p in parts], axis=0), np.max([p[1] for p in parts], axis=0)


def _by_branches(kin: Kin, known: Mapping[int, Interval], lo: Points, hi: Points, depth: int, seen: Seen) -> Rough:
    """The boxes cut to where a lesser of two inside the formula, or a choice, can be as small as it must be, by either
    branch."""
    tape = kin.formula.tape
    for i in reversed(tape.field):
        if not (tape.ops[i] == "min" and i not in tape.roots) and tape.ops[i] != "select":
            continue
        most = float(np.max(known[i].hi))
        if not np.isfinite(most) or most >= UNIVERSE:
            continue
        if tape.ops[i] == "min":
            ways = [(m, most) for m in _members(kin, tape.nodes[i])]
        else:
            either = _either_way(tape.nodes[i], most, lambda n: _a_number(tape, known, n))
            ways = [(kin.with_root(root), least) for root, least in either]
        low, high = _hull([_held(way, _Bound(least), depth - 1, CLAMPED, seen) for way, least in ways], len(kin))
        lo, hi = np.maximum(lo, low), np.minimum(hi, high)
        if (hi - lo).max() < UNIVERSE or seen.left <= 0:
            break
    return lo, hi


def _members(kin: Kin, least: Node) -> list[Kin]:
    """The members of a union inside a formula: of one solid, those that are alike as one, as the pieces of a curve."""
    return [kin.with_root(m) for m in members(least)] if kin.slots else kin_of(kin.formula, [*members(least)])


def _either_way(choice: Node, most: float, sure: Callable[[Node], bool]) -> list[tuple[Node, float]]:
    """Where a choice is at most so much: as roots, and how large they may be, of either branch."""
    condition, *branches = choice.args
    out = []
    for branch, holds in zip(branches, (True, False), strict=True):
        if (here := _where(condition, holds, sure)) is None:
            out.append((branch, most))
        else:
            out.append((node("max", branch - most if most else branch, here), 0.0))
    return out


def _a_number(tape: Tape, known: Mapping[int, Interval], n: Node) -> bool:
    """Whether a node is a number everywhere."""
    i = tape.position[n]
    return not tape.axes[i] or not bool(np.any(known[i].nan))


def _where(condition: Node, holds: bool, sure: Callable[[Node], bool]) -> Node | None:
    """A field that is nowhere above 0 where a condition holds, or does not; None where that is not known, as where what
    is compared may be no number (it is not `sure`): then neither a < b nor a >= b."""
    match condition.op:
        case "lt" | "le":
            a, b = condition.args
            return a - b if holds else b - a if sure(a) and sure(b) else None
        case "not":
            return _where(condition.args[0], not holds, sure)
        case "and" | "or":
            sides = [_where(a, holds, sure) for a in condition.args]
            if (condition.op == "and") == holds:
                known = [s for s in sides if s is not None]
                return node("max", *known) if len(known) == 2 else known[0] if known else None
            return node("min", sides[0], sides[1]) if sides[0] is not None and sides[1] is not None else None
        case _:
            return None
