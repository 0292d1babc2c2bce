"""The loops that find the nearest bar, compiled: a tree of boxes over the bars, and its walk for every point.

The bars are halved again and again, into leaves of 8 at most; the tree has every third of these levels, so that a group
of 8 boxes, or a leaf of 8 bars, is looked at with one vector instruction a step. It is complete and needs no pointers:
`pore_nearest.glsl` walks it too.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.ops.points import Strided, Triple

Values = NDArray[Any]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Numbers = NDArray[np.int32]
WIDE = 8
#: Places on the stack of a walk: 7 for each of more levels than memory has room for.
STACK = 80


class Tree(NamedTuple):
    """Boxes and bars in a working type.

    `boxes` (groups, 7, 8): low and high corner of the axes' box, and the largest radius, of each child of a group. The
    root's group is 0 and has `top` children; child c of group g is c + 1 where g is 0, else 8 g - 7 + top + c, which
    means a group or, from the number of groups on, a leaf. `bars` (leaves, 8, 8): start, end, radius and 1 / length^2
    of each bar of a leaf; places left over have the radius -inf. `frames` (places, 4): direction and length. `ids`
    (places): the number of each bar. `scale` (3,): the largest coordinate; 16 epsilon, what rounding may do to a
    distance, by which the walk goes further, so that its result is that of trying every bar; and the largest number.
    """

    boxes: Values
    bars: Values
    frames: Values
    ids: Numbers
    scale: Values
    top: int


class Lists(NamedTuple):
    """Cells that list the bars which may be nearest in them, in a working type: `segment_cells.Cells`, with 1 / size;
    none where `starts` is empty."""

    lo: Values
    rate: Values
    shape: Triple
    starts: Numbers
    places: Numbers


@compiled
def arrange(centres: Floats, depth: int) -> tuple[Numbers, Numbers]:
    """The order of bars in leaves, halved along the longest side at each level, and where each leaf begins."""
    count, leaves = len(centres), 1 << depth
    order = np.arange(count).astype(np.int32)
    lo, hi = np.empty(3), np.empty(3)
    for level in range(depth):
        parts = 1 << level
        for part in range(parts):
            first, last = count * part // parts, count * (part + 1) // parts
            middle = count * (2 * part + 1) // (2 * parts)
            lo[:], hi[:] = np.inf, -np.inf
            for m in range(first, last):
                for a in range(3):
                    lo[a] = min(lo[a], centres[order[m], a])
                    hi[a] = max(hi[a], centres[order[m], a])
            axis = 0
            for a in range(1, 3):
                if hi[a] - lo[a] > hi[axis] - lo[axis]:
                    axis = a
            _part(order, centres, axis, first, last, middle)
    starts = np.empty(leaves + 1, np.int32)
    for leaf in range(leaves + 1):
        starts[leaf] = count * leaf // leaves
    return order, starts


@compiled
def _part(order: Numbers, centres: Floats, axis: int, first: int, last: int, middle: int) -> None:
    """Order a stretch so that what comes before `middle` is not above what comes after (Hoare's selection)."""
    left, right = first, last - 1
    while left < right:
        pivot = centres[order[(left + right) // 2], axis]
        i, j = left, right
        while i <= j:
            while centres[order[i], axis] < pivot:
                i += 1
            while centres[order[j], axis] > pivot:
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if middle <= j:
            right = j
        elif middle >= i:
            left = i
        else:
            return


@compiled
def bound(boxes: Values, bars: Values, top: int) -> None:
    """Fill in the boxes, from the leaves to the root."""
    groups = len(boxes)
    for node in range(groups + len(bars) - 1, 0, -1):
        group = 0 if node <= top else (node + 7 - top) // WIDE
        lane = node - 1 if node <= top else (node + 7 - top) % WIDE
        for a in range(7):
            value = boxes[group, a, lane]
            for c in range(WIDE):
                if node < groups:
                    value = min(value, boxes[node, a, c]) if a < 3 else max(value, boxes[node, a, c])
                elif bars[node - groups, 6, c] >= 0:
                    p, q = bars[node - groups, a, c], bars[node - groups, (a + 3) % 6 if a < 6 else 6, c]
                    value = min(value, p, q) if a < 3 else max(value, p, q)
            boxes[group, a, lane] = value


@compiled
def _keys(boxes: Values, x: Any, y: Any, z: Any, nought: Any, out: Values) -> None:
    """What the distances from the surfaces in the eight boxes of a group are not below."""
    for c in range(len(out)):  # a length that the compiler does not know: it vectorizes loops before it unrolls them
        dx, dy, dz = boxes[0, c] - x, boxes[1, c] - y, boxes[2, c] - z
        ex, ey, ez = x - boxes[3, c], y - boxes[4, c], z - boxes[5, c]
        dx, dy, dz = dx if dx > ex else ex, dy if dy > ey else ey, dz if dz > ez else ez
        dx, dy, dz = dx if dx > nought else nought, dy if dy > nought else nought, dz if dz > nought else nought
        out[c] = np.sqrt(dx * dx + dy * dy + dz * dz) - boxes[6, c]


@compiled
def _foot(bars: Values, c: int, x: Any, y: Any, z: Any, nought: Any, one: Any) -> tuple[Any, Any, Any, Any]:
    """The vector from the nearest place on a bar's axis to a point, and where along the axis that place is.

    Beyond an end the vector is measured from the end itself, so that bars that meet there tie exactly.
    """
    ex, ey, ez = bars[3, c] - bars[0, c], bars[4, c] - bars[1, c], bars[5, c] - bars[2, c]
    wx, wy, wz = x - bars[0, c], y - bars[1, c], z - bars[2, c]
    t = (wx * ex + wy * ey + wz * ez) * bars[7, c]
    inside, beyond = t > nought, t >= one
    qx, qy, qz = wx - ex * t, wy - ey * t, wz - ez * t
    qx, qy, qz = qx if inside else wx, qy if inside else wy, qz if inside else wz
    wx, wy, wz = x - bars[3, c], y - bars[4, c], z - bars[5, c]
    qx, qy, qz = wx if beyond else qx, wy if beyond else qy, wz if beyond else qz
    t = t if inside else nought
    return qx, qy, qz, one if beyond else t


@compiled
def _distances(bars: Values, x: Any, y: Any, z: Any, nought: Any, one: Any, out: Values) -> None:
    """The distances from the surfaces of the eight bars of a leaf."""
    for c in range(len(out)):
        qx, qy, qz, _ = _foot(bars, c, x, y, z, nought, one)
        out[c] = np.sqrt(qx * qx + qy * qy + qz * qz) - bars[6, c]


@compiled
def _walk(
    tree: Tree, x: Any, y: Any, z: Any, seed: int, stack: Numbers, keys: Values, work: Values, nought: Any, one: Any
) -> int:
    """The place (leaf and lane) of the bar whose surface is nearest; that of the lower number where some tie."""
    boxes, ids = tree.boxes, tree.ids
    groups = len(boxes)
    best = seed
    qx, qy, qz, _ = _foot(tree.bars[seed // WIDE], seed % WIDE, x, y, z, nought, one)
    least = np.sqrt(qx * qx + qy * qy + qz * qz) - tree.bars[seed // WIDE, 6, seed % WIDE]
    slack = tree.scale[1] * (tree.scale[0] + (abs(x) + abs(y) + abs(z)))
    if not least + slack <= tree.scale[2]:  # too far away for the square of the distance
        return best
    node, height = 0, 0
    while True:
        if node < groups:
            _keys(boxes[node], x, y, z, nought, work)
            first = 1 if node == 0 else WIDE * node - 7 + tree.top
            bottom = height
            for c in range(WIDE):
                if work[c] <= least + slack:
                    at = height  # the nearest ends up on top
                    while at > bottom and keys[at - 1] < work[c]:
                        stack[at], keys[at] = stack[at - 1], keys[at - 1]
                        at -= 1
                    stack[at], keys[at] = first + c, work[c]
                    height += 1
        else:
            _distances(tree.bars[node - groups], x, y, z, nought, one, work)
            for c in range(WIDE):
                if work[c] <= least:
                    m = (node - groups) * WIDE + c
                    if work[c] < least or ids[m] < ids[best]:
                        best, least = m, work[c]
        while True:  # back to the last branch that may still hold a nearer bar
            if height == 0:
                return best
            height -= 1
            if keys[height] <= least + slack:
                node = stack[height]
                break


@compiled
def _listed(tree: Tree, lists: Lists, x: Any, y: Any, z: Any, nought: Any, one: Any) -> int:
    """What the walk finds, by the list of the cell that a place lies in; -1 where there is none."""
    u, v, w = (x - lists.lo[0]) * lists.rate[0], (y - lists.lo[1]) * lists.rate[0], (z - lists.lo[2]) * lists.rate[0]
    nx, ny, nz = lists.shape
    if not (u >= nought and v >= nought and w >= nought and u < nx and v < ny and w < nz):
        return -1
    k = (int(u) * ny + int(v)) * nz + int(w)
    best, least = -1, nought
    for i in range(lists.starts[k], lists.starts[k + 1]):
        m = lists.places[i]
        qx, qy, qz, _ = _foot(tree.bars[m // WIDE], m % WIDE, x, y, z, nought, one)
        d = np.sqrt(qx * qx + qy * qy + qz * qz) - tree.bars[m // WIDE, 6, m % WIDE]
        if best < 0 or d < least or (d == least and tree.ids[m] < tree.ids[best]):
            best, least = m, d
    return best


@compiled
def curve(x: Strided, y: Strided, z: Strided, lo: Floats, rate: Floats, out: NDArray[np.uint16]) -> None:
    """The cells of points, of 32^3 from `lo` on and 1 / `rate` wide, numbered along a curve that stays near itself."""
    for n in range(len(out)):
        u = (float(x.memory[n * x.steps[2]]) - lo[0]) * rate[0]
        v = (float(y.memory[n * y.steps[2]]) - lo[1]) * rate[1]
        w = (float(z.memory[n * z.steps[2]]) - lo[2]) * rate[2]
        i, j, k = (
            int(min(u, 31.0)) if u > 0 else 0,
            int(min(v, 31.0)) if v > 0 else 0,
            int(min(w, 31.0)) if w > 0 else 0,
        )
        code = 0
        for bit in range(5):
            code |= (i >> bit & 1) << 3 * bit | (j >> bit & 1) << 3 * bit + 1 | (k >> bit & 1) << 3 * bit + 2
        out[n] = code


@compiled
def nearest(
    tree: Tree, lists: Lists, wanted: int, x: Strided, y: Strided, z: Strided, order: Ints, out: Values, loops: Triple
) -> None:
    """Write the results whose bits are set in `wanted` as rows of `out` (results, points).

    `order`, unless it is empty, is that in which the points of a list (1, 1, n) are looked at.
    """
    real = tree.bars.dtype.type
    nought, one = real(0), real(1)
    bad, endless = real(float("nan")), real(float("inf"))
    stack, keys = np.empty(STACK, np.int32), np.empty(STACK, tree.bars.dtype)
    work = np.empty(WIDE, tree.bars.dtype)
    row, seed = 0, 0
    for a in range(loops[0]):
        for b in range(loops[1]):
            seed = row
            for step in range(loops[2]):
                c = order[step] if len(order) else step
                n = (a * loops[1] + b) * loops[2] + c
                px = x.memory[a * x.steps[0] + b * x.steps[1] + c * x.steps[2]]
                py = y.memory[a * y.steps[0] + b * y.steps[1] + c * y.steps[2]]
                pz = z.memory[a * z.steps[0] + b * z.steps[1] + c * z.steps[2]]
                if px == px and py == py and pz == pz:
                    found = _listed(tree, lists, px, py, pz, nought, one) if len(lists.starts) else -1
                    if found < 0:
                        found = _walk(tree, px, py, pz, seed, stack, keys, work, nought, one)
                    seed = found
                    leaf, lane = tree.bars[seed // WIDE], seed % WIDE
                    qx, qy, qz, t = _foot(leaf, lane, px, py, pz, nought, one)
                    q = np.sqrt(qx * qx + qy * qy + qz * qz)
                    there = q < endless
                    distance = q - tree.bars[seed // WIDE, 6, seed % WIDE] if there else endless
                else:
                    qx = qy = qz = t = q = distance = bad
                    there = False
                if step == 0:
                    row = seed
                if wanted == 1:
                    out[0, n] = distance
                    continue
                k = 0
                for bit in range(11):
                    if not wanted >> bit & 1:
                        continue
                    if bit == 0:
                        value = distance
                    elif not there:
                        value = bad
                    elif bit < 4:
                        value = (qx if bit == 1 else qy if bit == 2 else qz) / q if q > nought else nought
                    elif bit < 7:
                        value = tree.frames[seed, bit - 4]
                    elif bit == 7:
                        value = t
                    elif bit == 8:
                        value = tree.bars[seed // WIDE, 6, seed % WIDE]
                    elif bit == 9:
                        value = tree.frames[seed, 3]
                    else:
                        value = real(tree.ids[seed])
                    out[k, n] = value
                    k += 1
