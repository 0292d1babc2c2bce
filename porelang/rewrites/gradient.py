"""Derivatives: every `d(f)` replaced by the symbolic partial derivative of f, found with the rules of the table.

Fixed choices where a derivative does not exist: 0 for sqrt and atan2 at 0, for hypot at 0 (and for its slopes, so that
the inside of a box is level), sign(0) = 0 for |x| at 0, and at a tie of min or max that of the first argument. Where a
value jumps (floor, select) the derivative is that of the branch taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from porelang.ir import ONE, ZERO, Node, is_const, node, order, within
from porelang.ops import TABLE, kind

Triple = tuple[Node, Node, Node]
FLAT: Triple = (ZERO, ZERO, ZERO)
_UNIT: dict[str, Triple] = {"x": (ONE, ZERO, ZERO), "y": (ZERO, ONE, ZERO), "z": (ZERO, ZERO, ONE)}


def gradient(roots: Sequence[Node], before: dict[Any, Any] | None = None) -> list[Node]:
    """The graph without `d` nodes; `before` is what was made of nodes before, and is added to."""
    before = {} if before is None else before
    new: dict[Node, Node] = before.setdefault("nodes", {})
    known: dict[Node, Triple] = before.setdefault("slopes", {})
    for n in order(roots, lambda n: () if n in new else n.args):
        if n in new:
            continue
        args = tuple(new[a] for a in n.args)
        if n.op == "d":
            assert isinstance(n.value, int)
            new[n] = derivatives(args[0], known)[n.value]
        else:
            new[n] = node(n.op, *args, value=n.value)
    return [new[root] for root in roots]


def derivatives(root: Node, known: dict[Node, Triple] | None = None) -> Triple:
    """The partial derivatives of `root` (free of `d`) along x, y and z; `known` keeps them between calls."""
    known = {} if known is None else known
    for n in order([root], lambda n: () if n in known else within(n)):
        if n not in known:
            known[n] = _of(n, known)
    return known[root]


def derivative_by(root: Node, slot: Node) -> Node:
    """The derivative of a flat root by a slot that it reads: a param, an unknown, a number that a task finds."""
    known: dict[Node, Node] = {}
    for n in order([root], within):
        known[n] = ONE if n is slot else _by_slot(n, known)
    return known[root]


def _by_slot(n: Node, known: dict[Node, Node]) -> Node:
    if n.op not in TABLE or kind(n) == "bool":
        return ZERO
    if n.op == "select":
        condition, a, b = n.args
        return known[a] if known[a] is known[b] else node("select", condition, known[a], known[b])
    out = ZERO
    for slope, a in zip(TABLE[n.op].derivative(*n.args, n), n.args, strict=False):
        if slope is not None and not is_const(slope, 0.0):
            out = _plus(out, _times(slope, known[a]))
    return out


def _of(n: Node, known: dict[Node, Triple]) -> Triple:
    if n.op in _UNIT:
        return _UNIT[n.op]
    if not n.axes or kind(n) == "bool":
        return FLAT
    if n.op == "ensure":
        return known[n.args[0]]
    if n.op == "select":  # not as a sum: of the branch that is not taken nothing is read
        condition, a, b = n.args
        x, y, z = (p if p is q else node("select", condition, p, q) for p, q in zip(known[a], known[b], strict=True))
        return (x, y, z)
    if n.op == "at":
        field, *point = n.args
        partials: tuple[Node | None, ...] = tuple(
            None if is_const(slope, 0.0) else node("at", slope, *point) for slope in known[field]
        )
        inputs = point
    else:
        partials = TABLE[n.op].derivative(*n.args, n)
        inputs = list(n.args)
    sums = [ZERO, ZERO, ZERO]
    for slope, a in zip(partials, inputs, strict=False):
        if slope is None or is_const(slope, 0.0):
            continue
        for axis, inner in enumerate(known[a]):
            sums[axis] = _plus(sums[axis], _times(slope, inner))
    return (sums[0], sums[1], sums[2])


def _plus(a: Node, b: Node) -> Node:
    return b if is_const(a, 0.0) else a if is_const(b, 0.0) else a + b


def _times(a: Node, b: Node) -> Node:
    if is_const(b, 0.0):
        return ZERO
    return a if is_const(b, 1.0) else b if is_const(a, 1.0) else a * b
