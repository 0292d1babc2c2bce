"""The loops that find the nearest bar, compiled: a tree of boxes over the bars, and its walk for every point.

The tree is complete: node n has the children 2n and 2n + 1, the root is 1, and the leaves are the last 2^depth nodes,
of 4 bars at most. So it needs no pointers, and a stack of depth + 1 suffices. pore_nearest.glsl walks it too.
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
LEAF = 4
#: More levels than memory has room for.
DEEPEST = 40


class Tree(NamedTuple):
    """Bars in the order of their leaves, in a working type, and the boxes over them.

    `nodes` (2 leaves, 8): low and high corner of the axes' box, the largest radius, 0. `starts`: where a leaf's bars
    begin. `bars` (n, 8): start, end, radius and 1 / length^2. `frames` (n, 4): direction and length. `ids`: the number
    of each bar. `scale` (2,): the largest coordinate, and 16 epsilon: what rounding may do to a distance, by which the
    walk goes further, so that its result is that of trying every bar.
    """

    nodes: Values
    starts: Numbers
    bars: Values
    frames: Values
    ids: Numbers
    scale: Values


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
def bound(nodes: Values, starts: Numbers, bars: Values) -> None:
    """Fill in the boxes, from the leaves to the root."""
    leaves = len(starts) - 1
    for leaf in range(leaves):
        node = leaves + leaf
        nodes[node, 0:3], nodes[node, 3:6], nodes[node, 6], nodes[node, 7] = np.inf, -np.inf, -np.inf, 0
        for m in range(starts[leaf], starts[leaf + 1]):
            for a in range(3):
                nodes[node, a] = min(nodes[node, a], bars[m, a], bars[m, 3 + a])
                nodes[node, 3 + a] = max(nodes[node, 3 + a], bars[m, a], bars[m, 3 + a])
            nodes[node, 6] = max(nodes[node, 6], bars[m, 6])
    for node in range(leaves - 1, 0, -1):
        for a in range(8):
            p, q = nodes[2 * node, a], nodes[2 * node + 1, a]
            nodes[node, a] = min(p, q) if a < 3 else max(p, q)


@compiled
def _gap(nodes: Values, node: int, x: Any, y: Any, z: Any, nought: Any) -> Any:
    """The square of the distance from a node's box."""
    dx = max(max(nodes[node, 0] - x, x - nodes[node, 3]), nought)
    dy = max(max(nodes[node, 1] - y, y - nodes[node, 4]), nought)
    dz = max(max(nodes[node, 2] - z, z - nodes[node, 5]), nought)
    return dx * dx + dy * dy + dz * dz


@compiled
def _foot(bars: Values, m: int, x: Any, y: Any, z: Any, nought: Any, one: Any) -> tuple[Any, Any, Any, Any]:
    """The vector from the nearest place on a bar's axis to a point, and where along the axis that place is.

    Beyond an end the vector is measured from the end itself, so that bars that meet there tie exactly.
    """
    ex, ey, ez = bars[m, 3] - bars[m, 0], bars[m, 4] - bars[m, 1], bars[m, 5] - bars[m, 2]
    wx, wy, wz = x - bars[m, 0], y - bars[m, 1], z - bars[m, 2]
    t = (wx * ex + wy * ey + wz * ez) * bars[m, 7]
    if t <= nought:
        return wx, wy, wz, nought
    if t >= one:
        return x - bars[m, 3], y - bars[m, 4], z - bars[m, 5], one
    return wx - ex * t, wy - ey * t, wz - ez * t, t


@compiled
def _distance(bars: Values, m: int, x: Any, y: Any, z: Any, nought: Any, one: Any) -> Any:
    qx, qy, qz, _ = _foot(bars, m, x, y, z, nought, one)
    return np.sqrt(qx * qx + qy * qy + qz * qz) - bars[m, 6]


@compiled
def _walk(tree: Tree, x: Any, y: Any, z: Any, seed: int, stack: Numbers, gaps: Values, nought: Any, one: Any) -> int:
    """The place (in the tree's order) of the bar whose surface is nearest; the lower number where some tie."""
    nodes, bars, ids = tree.nodes, tree.bars, tree.ids
    leaves = len(tree.starts) - 1
    best = seed
    least = _distance(bars, seed, x, y, z, nought, one)
    slack = tree.scale[1] * (tree.scale[0] + (abs(x) + abs(y) + abs(z)))
    node, height = 1, 0
    while True:
        if node < leaves:
            node = 2 * node
            near, far = _gap(nodes, node, x, y, z, nought), _gap(nodes, node + 1, x, y, z, nought)
            near_reach, far_reach = least + nodes[node, 6] + slack, least + nodes[node + 1, 6] + slack
            enters = near_reach >= nought and near <= near_reach * near_reach
            other = far_reach >= nought and far <= far_reach * far_reach
            if enters and other:
                first = node if near <= far else node + 1
                stack[height] = 2 * node + 1 - first
                gaps[height] = far if near <= far else near
                height += 1
                node = first
                continue
            if enters:
                continue
            if other:
                node += 1
                continue
        else:
            for m in range(tree.starts[node - leaves], tree.starts[node - leaves + 1]):
                d = _distance(bars, m, x, y, z, nought, one)
                if d < least or (d == least and ids[m] < ids[best]):
                    best, least = m, d
        while True:  # back to the last branch that may still hold a nearer bar
            if height == 0:
                return best
            height -= 1
            node = stack[height]
            reach = least + nodes[node, 6] + slack
            if reach >= nought and gaps[height] <= reach * reach:
                break


@compiled
def nearest(tree: Tree, wanted: int, x: Strided, y: Strided, z: Strided, out: Values, loops: Triple) -> None:
    """Write the results whose bits are set in `wanted` as rows of `out` (results, points)."""
    real = tree.bars.dtype.type
    nought, one = real(0), real(1)
    bad, endless = real(float("nan")), real(float("inf"))
    stack, gaps = np.empty(DEEPEST, np.int32), np.empty(DEEPEST, tree.bars.dtype)
    bars = tree.bars
    n, row, seed = 0, 0, 0
    for a in range(loops[0]):
        for b in range(loops[1]):
            seed = row
            for c in range(loops[2]):
                px = x.memory[a * x.steps[0] + b * x.steps[1] + c * x.steps[2]]
                py = y.memory[a * y.steps[0] + b * y.steps[1] + c * y.steps[2]]
                pz = z.memory[a * z.steps[0] + b * z.steps[1] + c * z.steps[2]]
                if px == px and py == py and pz == pz:
                    seed = _walk(tree, px, py, pz, seed, stack, gaps, nought, one)
                    qx, qy, qz, t = _foot(bars, seed, px, py, pz, nought, one)
                    q = np.sqrt(qx * qx + qy * qy + qz * qz)
                    there = q < endless
                    distance = q - bars[seed, 6] if there else endless
                else:
                    qx = qy = qz = t = q = distance = bad
                    there = False
                if c == 0:
                    row = seed
                if wanted == 1:
                    out[0, n] = distance
                    n += 1
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
                        value = bars[seed, 6]
                    elif bit == 9:
                        value = tree.frames[seed, 3]
                    else:
                        value = real(tree.ids[seed])
                    out[k, n] = value
                    k += 1
                n += 1
