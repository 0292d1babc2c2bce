"""The box of a solid that is twisted about an axis: a twist keeps the distance from it.

Read backwards, a twisted formula says little: sums of two coordinates, by a cosine and a sine that vary. But the point
that it looks a shape up at is as far from the axis as the point itself, and as far along it. So the box of the shape,
untwisted, tells the cylinder that the twisted one lies in.
"""

from __future__ import annotations

import numpy as np

from porelang.analysis.backwards import UNIVERSE, Rough, rough_boxes
from porelang.analysis.kin import Kin
from porelang.ir import ZERO, Node, X, Y, Z, node, order, substitute, within


def bounded(kin: Kin) -> Rough:
    """Rough boxes of solids; of what has no end by its formula alone also by what it is a twist of."""
    lo, hi = rough_boxes(kin)
    far = (lo <= hi).all(axis=1) & (np.maximum(-lo, hi) >= UNIVERSE).any(axis=1)
    twisted = _untwisted(kin) if far.any() else None
    return (lo, hi) if twisted is None else (np.maximum(lo, twisted[0]), np.minimum(hi, twisted[1]))


def _untwisted(kin: Kin) -> Rough | None:
    """The boxes of solids from those of what they are a twist of; None where they are none."""
    found = _twist(kin.formula.root)
    if found is None:
        return None
    root, a, b, along = found
    low, high = bounded(kin.with_root(root))
    radius = np.hypot(*np.maximum(np.abs(low), np.abs(high))[:, :2].T)
    lo, hi = np.full(low.shape, -UNIVERSE), np.full(high.shape, UNIVERSE)
    for row in range(len(kin)):
        if (low[row] > high[row]).any():
            lo[row], hi[row] = np.inf, -np.inf
            continue
        tube = node("hypot", a, b) - float(radius[row])
        ends = node("max", along - float(high[row, 2]), float(low[row, 2]) - along)
        held = rough_boxes(kin.some(np.array([row])).with_root(node("max", tube, ends)))
        lo[row], hi[row] = held[0][0], held[1][0]
    return lo, hi


def _twist(root: Node) -> tuple[Node, Node, Node, Node] | None:
    """A shape, and the coordinates across (two) and along the axis that it is twisted about: the formula is the shape
    at `a cos u - b sin u`, `a sin u + b cos u` and what u is proportional to, and reads nothing else."""
    listed = order([root], within)
    sums = {frozenset(_products(n)): n for n in listed if n.op == "add" and _products(n)}
    for n in listed:
        for c, a in _by_a_wave(n, 0, "cos"):
            for s, b in _by_a_wave(n, 1, "sin"):
                other = sums.get(frozenset({frozenset({a, s}), frozenset({b, c})}))
                if c.args != s.args or other is None:
                    continue
                turn = c.args[0]
                along = turn.args[0] if turn.op == "mul" and not turn.args[1].axes else turn
                for third, by in _moved(along):
                    (rest,) = substitute([root], dict.fromkeys((n, other, third), ZERO))
                    if not rest.axes:
                        (shape,) = substitute([root], {n: X, other: Y, third: by})
                        return shape, a, b, along
    return None


def _moved(along: Node) -> list[tuple[Node, Node]]:
    """What is to be replaced by what, so that a coordinate becomes z: itself, or of one that is moved the axis."""
    ways = [(along, Z)]
    if along.op in ("add", "sub") and along.args[0] in (X, Y, Z) and not along.args[1].axes:
        ways.append((along.args[0], node("sub" if along.op == "add" else "add", Z, along.args[1])))
    return ways


def _products(n: Node) -> list[frozenset[Node]]:
    """The factors of the two products that a sum or a difference is of; none where it is of something else."""
    return [frozenset(m.args) for m in n.args] if [m.op for m in n.args] == ["mul", "mul"] else []


def _by_a_wave(n: Node, side: int, wave: str) -> list[tuple[Node, Node]]:
    """Of a difference of products one, as a wave that varies and what it is multiplied by."""
    if n.op != "sub" or not _products(n):
        return []
    first, second = n.args[side].args
    pairs = ((first, second), (second, first))
    return [(w, by) for w, by in pairs if w.op in (wave, f"{wave}_turns") and w.axes]
