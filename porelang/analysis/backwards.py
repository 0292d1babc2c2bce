"""Rough boxes of solids, by reading their formulas backwards: `root <= 0` says what its arguments can be, and so on
down to x, y and z (interval constraint propagation, HC4: Benhamou et al. 1999, "Revising hull and box consistency").

What is the lesser of two is one or the other: both are followed, and the box holds either (constructive disjunction).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.enclose import enclose_all
from porelang.analysis.kin import Kin, Points, members
from porelang.data import FARTHEST
from porelang.formula import Formula
from porelang.interval import Interval, interval, meet
from porelang.ir import ZERO, Node, X, Y, Z, is_const, node, substitute
from porelang.ops import TABLE
from porelang.tape import AXES, PICK, Tape

#: Parts are looked for within this distance of the origin, in mm, along each axis.
UNIVERSE = FARTHEST
#: Unions within smooth unions within ... are followed this deep, and clamps (`min(u, 0)`) within each other so deep.
DEEPEST, CLAMPED = 40, 1
_TURNS = 4

#: Boxes (n, 3) .. (n, 3); where lo > hi there is nothing.
Rough = tuple[Points, Points]


def rough_boxes(kin: Kin) -> Rough:
    """A box of each solid within the universe: never too small, exact for many plain shapes, infinite for lattices."""
    return _held(kin, 0.0, DEEPEST, CLAMPED, {})


#: Boxes that were found, by the root, how large it may be, how deep was looked, and whose numbers these are.
_Seen = dict[tuple[Node, float, int, int], tuple[Kin, Rough]]


def _held(kin: Kin, most: float, depth: int, clamps: int, seen: _Seen) -> Rough:
    """Boxes of `root <= most`."""
    key = (kin.formula.root, most, clamps, id(kin.numbers))
    if key not in seen:
        seen[key] = kin, _found(kin, most, depth, clamps, seen)
    lo, hi = seen[key][1]
    return lo.copy(), hi.copy()


def _found(kin: Kin, most: float, depth: int, clamps: int, seen: _Seen) -> Rough:
    halves = _halves(kin, most) if clamps else []
    known, lo, hi = _pushed_back(kin, most, 1 if halves else _TURNS)
    there = np.flatnonzero((lo <= hi).all(axis=1))
    if not len(there):
        return lo, hi
    for either in halves:
        low, high = _hull([_held(part, least, 0, clamps - 1, seen) for part, least in either])
        lo, hi = np.maximum(lo, low), np.minimum(hi, high)
    far = np.flatnonzero(((hi - lo).max(axis=1) >= UNIVERSE) & (lo <= hi).all(axis=1))
    if depth and len(far):
        some = kin.some(far)
        lo[far], hi[far] = _by_branches(some, _rows(known, far, len(kin)), lo[far], hi[far], depth, seen)
    return lo, hi


def _rows(known: Mapping[int, Interval], rows: NDArray[np.intp], count: int) -> dict[int, Interval]:
    """What is known of some rows alone."""

    def taken(values: NDArray[Any]) -> NDArray[Any]:
        return np.broadcast_to(values, (count,))[rows]

    return {i: Interval(taken(r.lo), taken(r.hi), taken(r.nan)) for i, r in known.items()}


def _pushed_back(kin: Kin, most: float, turns: int) -> tuple[dict[int, Interval], Points, Points]:
    """What is known of every position where `root <= most`, and of the coordinates: pushed back a few times over."""
    count = len(kin)
    formula = kin.of(np.arange(count))
    tape = formula.tape
    root = tape.roots[0]
    space = [interval(np.full(count, -UNIVERSE), np.full(count, UNIVERSE)) for _ in range(3)]
    known: dict[int, Interval] = {}
    places = [tape.position.get(n) for n in (X, Y, Z)]
    turned = _mixes_axes(tape)
    gone = np.zeros(count, np.bool_)
    for _ in range(turns):
        known = {i: e.range for i, e in enclose_all(formula, space).items()}
        known[root] = meet(known[root], interval(np.full(count, -np.inf), np.full(count, most)))
        with np.errstate(all="ignore"):
            for i in reversed(tape.field):
                _narrow(formula, i, known)
        before = space
        space = [s if at is None else meet(s, known[at]) for at, s in zip(places, space, strict=True)]
        if turned:
            space = _solved(tape, known, space)
        gone |= np.any([s.lo > s.hi for s in space], axis=0)
        # what is gone stays in the arrays as the whole of space, so that nothing after it meets an empty range
        space = [Interval(np.where(gone, -UNIVERSE, s.lo), np.where(gone, UNIVERSE, s.hi), s.nan) for s in space]
        shrunk = [(s.hi - s.lo) <= 0.95 * (b.hi - b.lo) for s, b in zip(space, before, strict=True)]
        if not (np.any(shrunk, axis=0) & ~gone).any():
            break
    lo, hi = (np.stack([np.broadcast_to(end, (count,)) for end in ends], axis=1).astype(np.float64)
              for ends in ([s.lo for s in space], [s.hi for s in space]))  # fmt: skip
    lo[gone], hi[gone] = np.inf, -np.inf
    return known, lo, hi


def _narrow(formula: Formula, i: int, known: dict[int, Interval]) -> None:
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
    for a, r in zip(inputs, row.narrow(known[i], *arguments), strict=True):
        if tape.axes[a] and r is not None:
            known[a] = meet(known[a], r)


def _mixes_axes(tape: Tape) -> bool:
    """Whether something is linear in several coordinates, as where a shape is turned."""
    linear = np.zeros(len(tape), np.bool_)
    for i, op in enumerate(tape.ops):
        inputs = tape.inputs[i]
        if op in AXES:
            linear[i] = True
        elif op in ("add", "sub", "neg"):
            linear[i] = all(linear[a] or not tape.axes[a] for a in inputs)
        elif op in ("mul", "div"):
            varying = [a for a in inputs if tape.axes[a]]
            linear[i] = len(varying) == 1 and linear[varying[0]] and (op == "mul" or varying[0] == inputs[0])
        if linear[i] and tape.axes[i] & (tape.axes[i] - 1):
            return True
    return False


def _solved(tape: Tape, known: Mapping[int, Interval], space: list[Interval]) -> list[Interval]:
    """Coordinates from the ranges of turned ones, solid by solid."""
    lo, hi = np.stack([s.lo for s in space]), np.stack([s.hi for s in space])
    count = lo.shape[1]
    for row in range(count):
        found = _solved_forms(tape, _rows(known, np.array([row]), count))
        if found is not None:
            lo[:, row], hi[:, row] = np.maximum(lo[:, row], found[0]), np.minimum(hi[:, row], found[1])
    return [Interval(lo[i], hi[i], s.nan) for i, s in enumerate(space)]


def _solved_forms(tape: Tape, known: Mapping[int, Interval]) -> tuple[Points, Points] | None:
    """Coordinates from the ranges of turned ones: three linear forms of x, y, z are solved for them.

    A rotated box says that three sums of coordinates are small; one at a time that says nothing about any coordinate.
    """
    forms: dict[int, NDArray[np.float64]] = {}  # of what is linear: the factors of x, y, z, and the rest
    for i, op in enumerate(tape.ops):
        inputs, varies = tape.inputs[i], tape.axes[i] != 0
        if op in AXES:
            forms[i] = np.eye(4)[AXES[op]]
        elif not varies:
            value = known.get(i)
            if value is not None and value.lo.size == 1 and float(value.lo.flat[0]) == float(value.hi.flat[0]):
                forms[i] = np.array([0.0, 0.0, 0.0, float(value.lo.flat[0])])
        elif all(a in forms for a in inputs):
            f = [forms[a] for a in inputs]
            if op in ("add", "sub"):
                forms[i] = f[0] + f[1] if op == "add" else f[0] - f[1]
            elif op == "neg":
                forms[i] = -f[0]
            elif op == "mul" and not all(tape.axes[a] for a in inputs):
                forms[i] = f[0] * f[1][3] if tape.axes[inputs[0]] else f[1] * f[0][3]
            elif op == "div" and not tape.axes[inputs[1]] and f[1][3] != 0:
                forms[i] = f[0] / f[1][3]
    rows: list[tuple[float, NDArray[np.float64], float, float]] = []
    for i, form in forms.items():
        size = float(np.linalg.norm(form[:3]))
        lo, hi = (float(known[i].lo.flat[0]), float(known[i].hi.flat[0])) if tape.axes[i] else (0.0, 0.0)
        if size > 0 and np.isfinite([lo, hi]).all() and hi - lo < UNIVERSE * size:
            rows.append(((hi - lo) / size, form / size, lo / size, hi / size))
    picked: list[tuple[float, NDArray[np.float64], float, float]] = []
    for row in sorted(rows, key=lambda r: r[0]):  # the narrowest three that are independent
        stack = np.array([r[1][:3] for r in [*picked, row]])
        if np.linalg.svd(stack, compute_uv=False)[-1] > 1e-3:
            picked.append(row)
        if len(picked) == 3:
            break
    if len(picked) < 3:
        return None
    inverse = np.linalg.inv(np.array([r[1][:3] for r in picked]))
    low = np.array([r[2] - r[1][3] for r in picked])
    high = np.array([r[3] - r[1][3] for r in picked])
    middle, half = inverse @ (low + high) / 2, np.abs(inverse) @ (high - low) / 2
    half = half * (1 + 1e-12) + 1e-12 * np.abs(middle)
    return middle - half, middle + half


def _halves(kin: Kin, most: float) -> list[tuple[tuple[Kin, float], tuple[Kin, float]]]:
    """For each `min(u, 0)` in the formula, the solid where it is 0, and where it is u, and how large the roots may be.

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
                both = node("max", inside - most, u)
                found.append(((kin.with_root(outside), most), (kin.with_root(both), 0.0)))
    return found


def _hull(parts: list[Rough]) -> Rough:
    """The boxes that hold those of every part."""
    return np.min([p[0] for p in parts], axis=0), np.max([p[1] for p in parts], axis=0)


def _by_branches(kin: Kin, known: Mapping[int, Interval], lo: Points, hi: Points, depth: int, seen: _Seen) -> Rough:
    """The boxes cut to where a lesser of two inside the formula can be as small as it must be, by either branch."""
    tape = kin.formula.tape
    for i in reversed(tape.field):
        if tape.ops[i] != "min" or i in tape.roots:
            continue
        most = float(np.max(known[i].hi))
        if not np.isfinite(most) or most >= UNIVERSE:
            continue
        parts = [_held(kin.with_root(m), most, depth - 1, CLAMPED, seen) for m in members(tape.nodes[i])]
        low, high = _hull(parts)
        lo, hi = np.maximum(lo, low), np.minimum(hi, high)
        if (hi - lo).max() < UNIVERSE:
            break
    return lo, hi
