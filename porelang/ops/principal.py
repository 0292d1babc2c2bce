"""The principal values of a symmetric tensor and their directions: a frame that a lattice can be aligned with.

The values come largest first, v1 >= v2 >= v3. Directions are unit vectors at right angles, right-handed. Of the two
opposite directions of the first and of the second it is the one with 9 x + 3 y + z > 0, a side that no axis and no
diagonal lies on the edge of; the third follows from both. Where two values are one, any directions in their plane are
principal: then they are what Jacobi's rotations find there, a frame none the less, and of a tensor that is the same in
all directions, or 0, the axes x, y, z.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from porelang.interval import Array, Interval, Mask
from porelang.ir import ONE, ZERO, Node, node
from porelang.ops.points import places

Values = NDArray[Any]
RESULTS = ("v1", "v2", "v3", "x1", "y1", "z1", "x2", "y2", "z2", "x3", "y3", "z3")
#: The side of the first two directions, of length 1.
SIDE = np.array([9.0, 3.0, 1.0]) / np.sqrt(91.0)
#: Errors in epsilons of the norm, measured: 2.8 for values, 3.3 over the gap between values for directions, whose
#: length is off by 6 more. Shaders divide to 2.5 ulp.
OF_VALUES, OF_DIRECTIONS, OF_LENGTH = 5.0, 6.0, 12.0
#: Of float32: where rounding may exchange directions it counts as exchanged.
EPSILON = 2.0**-23
#: A direction whose error is more than this is none.
MOST = 0.1
#: What float64 errs by where tensors are taken at the middle of their ranges.
OWN = 1e-14


def principal(xx: Any, yy: Any, zz: Any, xy: Any, yz: Any, xz: Any, wanted: Sequence[str] = RESULTS) -> tuple[Any, ...]:
    """The wanted results (in the order of RESULTS) for components that broadcast, in their type."""
    from porelang.ops import principal_loops as loops

    parts, shape = places(xx, yy, zz, xy, yz, xz)
    out = np.empty((len(RESULTS), parts.shape[1]), parts.dtype)
    limits = np.finfo(parts.dtype)
    loops.principal(parts, parts.dtype.type(limits.eps) ** 2, limits.tiny, out)
    return tuple(out[RESULTS.index(name)].reshape(shape)[()] for name in wanted)


def slopes(*parts: Node) -> tuple[Node | None, ...]:
    """The derivatives by the six components; the last argument is the result.

    Of a value it is the product of its direction with itself; a direction turns towards each other one by the product
    of both over the gap between their values, where there is one.
    """
    *tensor, result = parts

    def of(name: str) -> Node:
        return node("principal", *tensor, value=name)

    def product(a: Sequence[Node], b: Sequence[Node]) -> list[Node]:
        plain = [a[i] * b[i] for i in range(3)]
        return plain + [a[i] * b[j] + a[j] * b[i] for i, j in ((0, 1), (1, 2), (0, 2))]

    name = str(result.value)
    axis, which = name[0], name[1]
    own = [of(c + which) for c in "xyz"]
    if axis == "v":
        return tuple(product(own, own))
    sums: list[Node] = [ZERO] * 6
    for other in "123".replace(which, ""):
        gap = of("v" + which) - of("v" + other)
        apart = node("lt", ZERO, node("abs", gap))
        rate = node("select", apart, of(axis + other) / node("select", apart, gap, ONE), ZERO)
        mixed = product([of(c + other) for c in "xyz"], own)
        sums = [s + rate * m for s, m in zip(sums, mixed, strict=True)]
    return tuple(sums)


# ---- bounds ----------------------------------------------------------------------------------------------------------


class _Over(NamedTuple):
    """What is true over boxes of tensors: ranges of the results (12, 2, n), where directions may leap (3, n), the error
    of values (n) and of directions (3, n) in epsilons, where a component may be no number, and where none is one."""

    ranges: Array
    leaps: Mask
    of_values: Array
    of_directions: Array
    nan: Mask
    none: Mask
    shape: tuple[int, ...]


def enclose(*asked: Any) -> tuple[Interval, ...]:
    """Ranges that hold the results over boxes, whichever directions rounding may exchange."""
    *parts, wanted = asked
    over = _over(parts)
    out = []
    for name in wanted:
        lo, hi = over.ranges[RESULTS.index(name)]
        lo, hi = np.where(over.none, np.inf, lo), np.where(over.none, -np.inf, hi)
        out.append(Interval(lo.reshape(over.shape), hi.reshape(over.shape), over.nan.reshape(over.shape)))
    return tuple(out)


def jumps(*asked: Any) -> tuple[Mask, ...]:
    """Over which boxes each wanted result may jump: directions where values meet, or where a side is changed."""
    *parts, wanted = asked
    over = _over(parts)
    never = np.zeros(over.shape, np.bool_)
    return tuple(never if n[0] == "v" else over.leaps[int(n[1]) - 1].reshape(over.shape) for n in wanted)


def rounding(*asked: Any) -> tuple[Array, ...]:
    """How far evaluation may be from the exact results, in epsilons."""
    *parts, wanted = asked
    over = _over(parts)
    return tuple(
        (over.of_values if n[0] == "v" else over.of_directions[int(n[1]) - 1]).reshape(over.shape) for n in wanted
    )


def _over(parts: Sequence[Interval]) -> _Over:
    """By H. Weyl values move by no more than the norm of a change, by C. Davis and W. Kahan (1970) directions by the
    arc whose sine is that norm over the gap that it leaves."""
    shape = np.broadcast_shapes(*(np.shape(p.lo) for p in parts))
    lo = np.stack([np.broadcast_to(p.lo, shape).reshape(-1) for p in parts])
    hi = np.stack([np.broadcast_to(p.hi, shape).reshape(-1) for p in parts])
    none: Mask = np.asarray((lo > hi).any(0))
    wild: Mask = np.asarray(~(np.isfinite(lo) & np.isfinite(hi)).all(0))
    nan = wild.copy()
    for p in parts:
        nan |= np.broadcast_to(p.nan, shape).reshape(-1)
    with np.errstate(all="ignore"):
        middle = np.where(wild, 0.0, lo / 2 + hi / 2)
        reach = np.where(wild, np.inf, np.maximum(hi - middle, middle - lo))
        size = _norm(np.maximum(np.abs(lo), np.abs(hi)))
        size = np.where(np.isnan(size), np.inf, size)
        moved = _norm(reach) + OWN * size
        found = np.array(principal(*middle))
        values, directions = found[:3], found[3:].reshape(3, 3, -1)
        ranges = np.empty((len(RESULTS), 2, lo.shape[1]))
        ranges[:3, 0], ranges[:3, 1] = values - moved, values + moved
        gaps = values[:2] - values[1:]
        gap = np.stack([gaps[0], np.minimum(gaps[0], gaps[1]), gaps[1]])
        left = gap - 2 * moved  # between the values themselves wherever in the box
        error = OF_DIRECTIONS * size / left + OF_LENGTH
        loose = ~(left > 0) | ~(EPSILON * error < MOST)
        sine = np.minimum(moved / np.maximum(gap - moved, 1e-300), 1.0)
        chord = np.where(loose, 2.0, sine * np.sqrt(2 / (1 + np.sqrt(1 - sine * sine))) + OWN)
        ahead = np.abs(np.tensordot(SIDE, directions[:2], (0, 1)))
        turned = loose[:2] | ~(ahead > chord[:2] + EPSILON * error[:2])
        turned = np.stack([*turned, turned[0] | turned[1] | loose[2]])
        for i in range(3):
            for k in range(3):
                e = directions[i, k]
                low, high = e - chord[i], e + chord[i]
                most = np.abs(e) + chord[i]
                low, high = np.where(turned[i], -most, low), np.where(turned[i], most, high)
                ranges[3 + 3 * i + k] = (
                    np.where(loose[i], -1.0, np.maximum(low, -1.0)),
                    np.where(loose[i], 1.0, np.minimum(high, 1.0)),
                )
        ranges[:3] = np.where(wild, np.array([-np.inf, np.inf])[None, :, None], ranges[:3])
    of_directions = np.where(loose, OF_LENGTH, error)
    return _Over(ranges, turned, OF_VALUES * size, of_directions, nan, none, shape)


def _norm(parts: Array) -> Array:
    """The root of the sum of the squares of all nine components: no less than the greatest principal value."""
    scale = np.maximum(parts.max(0), 1e-300)
    xx, yy, zz, xy, yz, xz = parts / scale
    found: Array = scale * np.sqrt(xx**2 + yy**2 + zz**2 + 2 * (xy**2 + yz**2 + xz**2))
    return found
