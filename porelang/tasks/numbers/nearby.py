"""A solid near a place: its field without what enclosures prove to have no part in its surface there.

A union of forty slots is one or two of them in any small box. An argument of min, max or `if` goes where it is proven
not to be the result, and |u| where the sign of u is. Where only the sign of the result counts, as it does for the
arguments of unions and intersections, so does what is proven void of a union and solid of an intersection. The surface
stays, and the slopes on it; values off it may be others.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.bounds import Points
from porelang.analysis.enclose import F64, boxes, enclose_all
from porelang.formula import Formula
from porelang.interval import Interval
from porelang.ir import ZERO, Node, Stage, is_const, node, order, within

#: Cells that share a formula, and operations for which no shorter one is looked for: what NumPy takes for a call is
#: then about what it takes for the values.
FEW, SHORT = 128, 24
_CHOICES = frozenset({"min", "max", "select"})
_MARGIN = 1e-9  # of a cell: points on its sides are rounded


def in_groups(
    formula: Formula, low: Points, size: NDArray[np.float64], rows: NDArray[np.int64] | None = None
) -> Iterator[tuple[NDArray[np.int64], Formula]]:
    """Cells of equal size in groups that lie together, by their rows in `low` (n, 3), each with its formula."""
    rows = np.arange(len(low)) if rows is None else rows
    tape = formula.tape
    long = len(tape.field) > SHORT and any(tape.ops[i] in _CHOICES for i in tape.field)
    if len(rows) <= FEW or not long:
        yield rows, formula
        return
    axis = int(np.argmax(np.ptp(low[rows], axis=0)))
    ranked = rows[np.argsort(low[rows, axis], kind="stable")]
    for half in (ranked[: len(ranked) // 2], ranked[len(ranked) // 2 :]):
        lo, hi = low[half].min(axis=0) - _MARGIN * size, low[half].max(axis=0) + (1 + _MARGIN) * size
        yield from in_groups(near(formula, lo, hi), low, size, half)


def near(formula: Formula, lo: Points, hi: Points) -> Formula:
    """The first root of a formula as it is in a box from `lo` to `hi` (3,)."""
    tape = formula.tape
    found = enclose_all(formula, boxes(lo[None], hi[None]), F64)
    ranges: dict[Node, Interval] = {tape.nodes[i]: e.range for i, e in found.items()}
    taken = {n: arg for n in tape.nodes if n.op in _CHOICES and (arg := _taken(n, ranges)) is not None}
    same: dict[Node, Node] = {}  # nodes of the same values
    for n in order([formula.root], lambda n: (taken[n],) if n in taken else within(n)):
        if n in taken:
            same[n] = same[taken[n]]
        elif n.stage is not Stage.FIELD or not n.args:
            same[n] = n
        else:
            same[n] = _made(n, tuple(same[a] for a in n.args), ranges)
    alike: dict[Node, Node] = {}  # and of the same signs
    into = {n: _sides(n, ranges) if n not in taken else (taken[n],) for n in same}
    for n in order([formula.root], lambda n: into[n]):
        sides = [alike[a] for a in into[n]]
        alike[n] = sides[0] if len(sides) == 1 and n.op != "neg" else node(n.op, *sides) if sides else same[n]
    return formula.with_roots(alike[formula.root])


def _sides(n: Node, ranges: dict[Node, Interval]) -> tuple[Node, ...]:
    """The arguments whose signs make that of a union, an intersection or a complement; none of anything else."""
    if n.stage is not Stage.FIELD or n.op not in ("min", "max", "neg"):
        return ()
    if n.op == "neg":
        return n.args
    known = [ranges.get(a) for a in n.args]
    left = [a for a, r in zip(n.args, known, strict=True) if r is None or not _number(r) or not _idle(n, r)]
    return tuple(left) if left else n.args[:1]


def _idle(n: Node, r: Interval) -> bool:
    return _all(r.lo > 0) if n.op == "min" else _all(r.hi < 0)


def _taken(n: Node, ranges: dict[Node, Interval]) -> Node | None:
    """The argument that a choice always takes, as far as ranges tell."""
    if n.stage is not Stage.FIELD or not all(_number(ranges.get(a)) for a in n.args):
        return None
    known = [ranges[a] for a in n.args]
    if n.op == "select":
        return n.args[1] if _all(known[0].lo >= 1) else n.args[2] if _all(known[0].hi <= 0) else None
    less, more = (0, 1) if n.op == "min" else (1, 0)  # which is taken where the first is less, and where it is more
    if _all(known[0].hi < known[1].lo):
        return n.args[less]
    return n.args[more] if _all(known[0].lo > known[1].hi) else None


def _made(n: Node, args: tuple[Node, ...], ranges: dict[Node, Interval]) -> Node:
    """A node with other arguments, shorter where that is the same."""
    if n.op == "hypot" and any(is_const(a, 0.0) for a in args):
        other = 0 if is_const(args[1], 0.0) else 1
        return _absolute(args[other], ranges.get(n.args[other]))
    if n.op == "abs":
        return _absolute(args[0], ranges.get(n.args[0]))
    if n.op == "add" and {args[0].op, args[1].op} == {"max", "min"}:
        u, v = ([a for a in arg.args if not is_const(a, 0.0)] for arg in args)
        if len(u) == len(v) == 1 and u == v:  # max(u, 0) + min(u, 0)
            return u[0]
    return node(n.op, *args, value=n.value)


def _absolute(u: Node, r: Interval | None) -> Node:
    """|u|, or the distance from a face, of a number within a range."""
    if is_const(u, 0.0):
        return ZERO
    if r is not None and _number(r):
        if _all(r.lo >= 0):
            return u
        if _all(r.hi <= 0):
            return -u
    return node("abs", u)


def _number(r: Interval | None) -> bool:
    """Whether something is proven to be a number throughout."""
    return r is not None and not np.any(r.nan) and not np.any(r.empty)


def _all(flags: NDArray[np.bool_]) -> bool:
    return bool(np.all(flags))
