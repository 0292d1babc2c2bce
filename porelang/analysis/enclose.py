"""Enclosures: ranges that hold what the graph can return, over boxes of space and ranges of params.

With `EXACT` the ranges hold the mathematical value. With `F32` or `F64` they also hold what a backend of that precision
returns, because every operation's result is widened by its tolerance from the table. Over a box this decides whether a
surface can pass through it; over a single point it is the running error bound against which backends are compared.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from porelang.interval import INF, Interval, Mask, interval, truth
from porelang.ir import Node, Stage, order
from porelang.ops import TABLE, Op


@dataclass(frozen=True, slots=True)
class Precision:
    """A floating-point type: its epsilon, its least normal number and its greatest number."""

    name: str
    eps: float
    tiny: float
    huge: float


EXACT = Precision("exact", 0.0, 0.0, INF)
F64 = Precision("f64", 2.0**-52, 2.0**-1022, 1.7976931348623157e308)
F32 = Precision("f32", 2.0**-23, 2.0**-126, 3.4028234663852886e38)
_AXIS = {"x": 0, "y": 1, "z": 2}


@dataclass(frozen=True, slots=True)
class Enclosure:
    """The range of one root over every box, and where the root may jump inside the box."""

    range: Interval
    jumps: Mask


def enclose(
    roots: Sequence[Node],
    box: Sequence[Interval] = (),
    params: Mapping[str, Interval] | None = None,
    precision: Precision = EXACT,
) -> list[Enclosure]:
    """Ranges of the roots over boxes.

    `box` gives x, y and z as intervals of n boxes (arrays of shape (n,)); it may be left out where no root is a field.
    `params` gives each param's range. Memory is n times the widest cut through the graph.
    """
    nodes = order(roots)
    last = {a: i for i, n in enumerate(nodes) for a in n.args}
    kept = set(roots)
    exact: dict[Node, Enclosure] = {}  # of const and uniform nodes, before they are rounded for the field stage
    found: dict[Node, Enclosure] = {}
    with np.errstate(all="ignore"):
        for i, n in enumerate(nodes):
            known = exact if n.stage < Stage.FIELD else found
            if n.op in TABLE:
                row = TABLE[n.op]
                inputs = [known[a] for a in n.args]
                ranges = [e.range for e in inputs]
                here = precision if n.stage is Stage.FIELD or not precision.eps else F64  # uniforms are float64
                out = _widen(row, row.enclose(*ranges), ranges, here)
                jumps = inputs[0].jumps
                for e in inputs[1:]:
                    jumps = jumps | e.jumps
                if row.jumps is not None:
                    jumps = jumps | row.jumps(*ranges)
                made = Enclosure(out, jumps)
            else:
                made = _leaf(n, box, params or {}, precision)
            if n.stage < Stage.FIELD:
                exact[n] = made
                made = Enclosure(_rounded(made.range, precision), made.jumps)
            found[n] = made
            for a in set(n.args):
                if last[a] == i and a not in kept and a.stage is Stage.FIELD:
                    del found[a]
    return [found[r] for r in roots]


def _leaf(n: Node, box: Sequence[Interval], params: Mapping[str, Interval], precision: Precision) -> Enclosure:
    none = np.zeros((), np.bool_)
    if n.op == "const":
        value = n.value
        if isinstance(value, bool):
            return Enclosure(truth(np.array(not value), np.array(value)), none)
        return Enclosure(interval(value), none)
    if n.op == "param":
        return Enclosure(params[str(n.value)], none)
    if n.op in _AXIS:
        return Enclosure(_flushed(box[_AXIS[n.op]], precision), none)
    raise ValueError(f"an unresolved `{n.op}` cannot be enclosed")


def _flushed(r: Interval, precision: Precision) -> Interval:
    """Numbers too small for the type may count as 0."""
    tiny = precision.tiny
    if not tiny:
        return r
    lo = np.where((r.lo > 0) & (r.lo < tiny), 0.0, r.lo)
    hi = np.where((r.hi < 0) & (r.hi > -tiny), 0.0, r.hi)
    return Interval(lo, hi, r.nan)


def _rounded(r: Interval, precision: Precision) -> Interval:
    """A number handed to a backend is rounded to its type once; numbers the type holds stay exact."""
    if precision is not F32:
        return r
    with np.errstate(over="ignore"):
        down, up = r.lo.astype(np.float32).astype(np.float64), r.hi.astype(np.float32).astype(np.float64)
    return _flushed(Interval(np.minimum(down, r.lo), np.maximum(up, r.hi), r.nan), precision)


def _widen(row: Op, r: Interval, arguments: list[Interval], precision: Precision) -> Interval:
    """The range after a backend's own error in this operation."""
    t = row.tolerance
    if row.result == "bool" or not precision.eps:
        return r
    if not (t.ulp or t.absolute or t.extra):
        return r
    more = np.asarray(precision.eps * t.absolute + precision.tiny)
    if t.extra is not None:
        more = more + precision.eps * t.extra(*arguments)
    relative = precision.eps * t.ulp
    lo = r.lo - np.where(np.isinf(r.lo), 0.0, np.abs(r.lo) * relative + more)
    hi = r.hi + np.where(np.isinf(r.hi), 0.0, np.abs(r.hi) * relative + more)
    if not t.absolute and t.extra is None:  # what is wrong by a part of itself, or counts as 0, keeps its sign
        lo = np.where(r.lo >= 0, np.maximum(lo, 0.0), lo)
        hi = np.where(r.hi <= 0, np.minimum(hi, 0.0), hi)
    empty = r.empty
    lo = np.where(empty, r.lo, np.where(lo < -precision.huge, -INF, np.minimum(lo, precision.huge)))
    hi = np.where(empty, r.hi, np.where(hi > precision.huge, INF, np.maximum(hi, -precision.huge)))
    return Interval(lo, hi, r.nan)


def at_points(points: np.ndarray[tuple[int, int], np.dtype[np.float64]], precision: Precision) -> list[Interval]:
    """Points (n, 3) as boxes of no size, after their own rounding to the type."""
    return [_rounded(interval(points[:, i]), precision) for i in range(3)]


def fixed(params: Mapping[str, float]) -> dict[str, Interval]:
    """Params at given values, as ranges."""
    return {name: interval(value) for name, value in params.items()}


def everywhere() -> list[Interval]:
    """Space as one box: 1000 km each way, so that no product of coordinates overflows."""
    return [interval(np.array([-1e9]), np.array([1e9])) for _ in range(3)]
