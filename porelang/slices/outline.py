"""The contours of a layer by marching squares: closed rings with the solid at their left, found band by band.

Only what crosses zero is kept, so that the memory goes with the length of the contours, not with the pixels.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.crossing import between
from porelang.slices.stack import Band, Stack

Ring = NDArray[np.float64]
Numbers = NDArray[np.int64]
#: A field (n,) at places (n, 2).
At = Callable[[Ring], NDArray[Any]]
#: Edges of a square of four samples: from (0, 0) to (1, 0), (1, 0) to (1, 1), (0, 1) to (1, 1), (0, 0) to (0, 1).
BOTTOM, RIGHT, TOP, LEFT = range(4)
#: Where each edge begins, and the axis along which it runs.
AT, AXIS = np.array([(0, 0), (1, 0), (0, 1), (0, 0)]), np.array([0, 1, 0, 1])
#: For each set of solid corners, 1 for (0, 0), 2 for (1, 0), 4 for (1, 1), 8 for (0, 1): from which edge to which.
SEGMENTS: dict[int, tuple[tuple[int, int], ...]] = {
    1: ((BOTTOM, LEFT),), 2: ((RIGHT, BOTTOM),), 3: ((RIGHT, LEFT),), 4: ((TOP, RIGHT),), 6: ((TOP, BOTTOM),),
    7: ((TOP, LEFT),), 8: ((LEFT, TOP),), 9: ((BOTTOM, TOP),), 11: ((RIGHT, TOP),), 12: ((LEFT, RIGHT),),
    13: ((BOTTOM, RIGHT),), 14: ((LEFT, BOTTOM),),
    # two corners across: void in the middle parts them, solid joins them (16 more)
    5: ((BOTTOM, LEFT), (TOP, RIGHT)), 21: ((BOTTOM, RIGHT), (TOP, LEFT)),
    10: ((RIGHT, BOTTOM), (LEFT, TOP)), 26: ((LEFT, BOTTOM), (RIGHT, TOP)),
}  # fmt: skip
JOINED = 16
_TABLE = np.full((2, 2, 32), -1)  # first or second segment, from or to, corners
for _code, _pairs in SEGMENTS.items():
    for _n, _pair in enumerate(_pairs):
        _TABLE[_n, :, _code] = _pair


#: How near a crossing is looked for (of the smaller of the samples beside it), and values that are asked for at most.
NEAR, STEPS = 0.01, 12


def outlines(bands: Iterable[Band], stack: Stack, field: At | None = None) -> list[Ring]:
    """The rings (n, 2) in mm that enclose the solid of a layer: counter-clockwise, around holes clockwise.

    The bands hold a frame of one sample round those of the layer. Solid that reaches into it is closed half a pixel
    before, at the border of the layer. With the `field` of the layer, at points (n, 2) in mm, rings cross between
    samples where it is 0; without, where a line between them is: a field without kinks needs no more.
    """
    origin = np.array([stack.x[0], stack.y[0]]) - stack.pixel
    exact = None if field is None else lambda places: field(origin + places * stack.pixel)
    found: list[tuple[Numbers, Numbers, Ring]] = []
    before: Band | None = None
    row, last = 0, len(stack.x) + 1
    for band in bands:
        values = np.array(band)
        for frame in (values[:, 0], values[:, -1], *(values[r - row] for r in (0, last) if 0 <= r - row < len(values))):
            frame[frame < 0] = np.nan  # is not solid, and what crosses to it does so half way
        block = values if before is None else np.concatenate([before, values])
        found.append(_segments(block, row + len(values) - len(block), exact))
        before, row = values[-1:], row + len(values)
    start, end, places = (np.concatenate(parts) for parts in zip(*found, strict=True))
    # at each place one segment begins and one ends: the table sees to that
    order = np.argsort(start)
    onward = order[np.searchsorted(start, end, sorter=order)]
    return [origin + places[ring] * stack.pixel for ring in _rings(onward)]


def area_of(rings: Iterable[Ring]) -> float:
    """What rings enclose, less their holes, in mm2."""
    total = 0.0
    for ring in rings:
        x, y = (ring - ring[0]).T
        total += 0.5 * float(x @ np.roll(y, -1) - np.roll(x, -1) @ y)
    return total


def _segments(values: Band, row: int, exact: At | None) -> tuple[Numbers, Numbers, Ring]:
    """For each segment in rows of samples, of which the first is number `row`: the edge where it begins, the edge where
    it ends, as numbers that the whole layer shares, and the place (in pixels) where it begins."""
    solid = values < 0
    code = solid[:-1, :-1] + 2 * solid[1:, :-1].view(np.uint8) + 4 * solid[1:, 1:].view(np.uint8)
    code += 8 * solid[:-1, 1:].view(np.uint8)
    corner = np.argwhere((code > 0) & (code < 15))
    which = code[tuple(corner.T)].astype(np.intp)
    across = np.flatnonzero((which == 5) | (which == 10))
    i, j = corner[across].T
    with np.errstate(all="ignore"):
        middle = values[i, j].astype(np.float64) + values[i + 1, j] + values[i + 1, j + 1] + values[i, j + 1]
    which[across] += JOINED * (middle < 0)
    width = values.shape[1]
    starts, ends, places = [], [], []
    for begins, stops in _TABLE:
        there = np.flatnonzero(begins[which] >= 0)
        at, edge = corner[there], begins[which[there]]
        node, axis = at + AT[edge], AXIS[edge]
        starts.append(_number(node, axis, row, width))
        last = stops[which[there]]
        ends.append(_number(at + AT[last], AXIS[last], row, width))
        other = node + np.stack([axis == 0, axis == 1], axis=1)
        p, q = (values[tuple(n.T)].astype(np.float64) for n in (node, other))
        with np.errstate(all="ignore"):
            share = p / (p - q)
        share = np.where(np.isfinite(share), share, 0.5)
        first = node + np.array([row, 0])
        if exact is not None:
            share = _closer(share, p, q, first, other - node, exact)
        places.append(first + share[:, None] * (other - node))
    return np.concatenate(starts), np.concatenate(ends), np.concatenate(places)


def _closer(share: Ring, p: Ring, q: Ring, first: Ring, way: Numbers, exact: At) -> Ring:
    """Where the field is 0 on edges from places with the values `p` to ones with `q`; what ends at the border stays."""
    some = np.flatnonzero(np.isfinite(p) & np.isfinite(q) & ((p < 0) != (q < 0)))
    if not len(some):
        return share
    p, q = p[some], q[some]

    def value(where: Ring, which: Numbers) -> Ring:
        found = np.asarray(exact(first[some[which]] + where[:, None] * way[some[which]]), np.float64)
        return np.where(np.isnan(found), p[which], found)

    near = NEAR * np.minimum(np.abs(p), np.abs(q))
    out = share.copy()
    out[some], _ = between(value, np.zeros(len(some)), np.ones(len(some)), p, q, near, STEPS)
    return out


def _number(node: Numbers, axis: Numbers, row: int, width: int) -> Numbers:
    number: Numbers = 2 * ((node[:, 0] + row) * width + node[:, 1]) + axis
    return number


def _rings(onward: Numbers) -> Iterator[Numbers]:
    """The cycles of a permutation."""
    after, seen = onward.tolist(), bytearray(len(onward))
    for begin in range(len(after)):
        ring, k = [], begin
        while not seen[k]:
            seen[k] = 1
            ring.append(k)
            k = after[k]
        if ring:
            yield np.array(ring)
