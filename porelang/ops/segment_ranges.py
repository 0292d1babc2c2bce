"""The loops that bound the nearest bar over boxes, compiled.

The distance from one bar's surface is convex: over a box it is largest at a corner, and nowhere below its tangent plane
at the centre. The least over all bars is at most that of the bar nearest to the centre; the bars whose lower bound is
not above it are those that may be nearest somewhere in the box, and the other results are held by what they have.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[np.int32]
WIDE = 8
STACK = 80
#: Bars looked at for one box before all of them are taken for possible.
MOST = 128
RESULTS = 11


class Boxes(NamedTuple):
    """Boxes `lo`..`hi` (3, n), and the place in the tree of the bar nearest to each one's centre (-1: no centre)."""

    lo: Floats
    hi: Floats
    places: NDArray[np.int64]


class Found(NamedTuple):
    """Ranges (n, results, 2), whether several bars may be nearest, and whether the axis of one may be touched."""

    ranges: Floats
    several: Flags
    touches: Flags


@compiled
def _between(lo: float, hi: float, least: float, most: float) -> float:
    """The distance of two ranges of numbers."""
    return max(least - hi, lo - most, 0.0)


@compiled
def _tangent(bars: Floats, c: int, centre: Floats, half: Floats, q: Floats) -> tuple[float, float, float, float]:
    """What the distance from a bar is not below in a box, the length of q (foot to centre), and the foot's range."""
    square, dot = 0.0, 0.0
    for a in range(3):
        e = bars[3 + a, c] - bars[a, c]
        square += e * e
        dot += (centre[a] - bars[a, c]) * e
    t = dot / square
    sway = 0.0
    for a in range(3):
        sway += abs(bars[3 + a, c] - bars[a, c]) * half[a]
    sway /= square
    foot = min(max(t, 0.0), 1.0)
    size = 0.0
    for a in range(3):
        q[a] = centre[a] - bars[a, c] - foot * (bars[3 + a, c] - bars[a, c])
        size += q[a] * q[a]
    size = np.sqrt(size)
    fall = 0.0
    if size > 0:
        for a in range(3):
            fall += abs(q[a]) / size * half[a]
    gap = 0.0
    for a in range(3):
        least, most = min(bars[a, c], bars[3 + a, c]), max(bars[a, c], bars[3 + a, c])
        gap += _between(centre[a] - half[a], centre[a] + half[a], least, most) ** 2
    low = max(size - fall, np.sqrt(gap)) - bars[6, c]
    return low, size, min(max(t - sway, 0.0), 1.0), min(max(t + sway, 0.0), 1.0)


@compiled
def _highest(bars: Floats, c: int, lo: Floats, hi: Floats) -> float:
    """The largest distance from a bar in a box: that of a corner."""
    most = -np.inf
    for corner in range(8):
        square, dot, size = 0.0, 0.0, 0.0
        for a in range(3):
            p = hi[a] if corner >> a & 1 else lo[a]
            e = bars[3 + a, c] - bars[a, c]
            square += e * e
            dot += (p - bars[a, c]) * e
        foot = min(max(dot / square, 0.0), 1.0)
        for a in range(3):
            p = hi[a] if corner >> a & 1 else lo[a]
            size += (p - bars[a, c] - foot * (bars[3 + a, c] - bars[a, c])) ** 2
        most = max(most, np.sqrt(size) - bars[6, c])
    return most


@compiled
def _add(of: Floats, k: int, lo: float, hi: float) -> None:
    of[k, 0], of[k, 1] = min(of[k, 0], lo), max(of[k, 1], hi)


@compiled
def candidates(
    tree: Any, centres: Floats, reach: float, places: NDArray[np.int64], slack: float, out: Ints, number: Ints
) -> None:
    """Write the places of all bars that may be nearest in cubes of half side `reach` about `centres` (n, 3), and how
    many; one more than `out` holds where there are too many. `places` are those nearest to the centres."""
    groups, most_bars = len(tree.boxes), out.shape[1]
    stack = np.empty(STACK, np.int64)
    half, q, lo, hi = np.full(3, reach), np.empty(3), np.empty(3), np.empty(3)
    for n in range(len(centres)):
        centre = centres[n]
        for a in range(3):
            lo[a], hi[a] = centre[a] - reach, centre[a] + reach
        limit = _highest(tree.bars[places[n] // WIDE], places[n] % WIDE, lo, hi) + slack
        count, node, height = 0, 0, 0
        while True:
            if node < groups:
                first = 1 if node == 0 else WIDE * node - 7 + tree.top
                box = tree.boxes[node]
                for c in range(WIDE):
                    if not box[6, c] >= 0:
                        continue
                    gap = 0.0
                    for a in range(3):
                        gap += _between(lo[a], hi[a], box[a, c], box[3 + a, c]) ** 2
                    if np.sqrt(gap) - box[6, c] <= limit:
                        stack[height] = first + c
                        height += 1
            else:
                bars = tree.bars[node - groups]
                for c in range(WIDE):
                    if bars[6, c] >= 0 and _tangent(bars, c, centre, half, q)[0] <= limit:
                        if count < most_bars:
                            out[n, count] = (node - groups) * WIDE + c
                        count += 1
            if height == 0 or count > most_bars:
                break
            height -= 1
            node = stack[height]
        number[n] = count


@compiled
def enclose(tree: Any, boxes: Boxes, everything: Floats, all_results: bool, slack: Floats, out: Found) -> None:
    """Write the ranges over boxes; `everything` (results, 2) is what is true of all bars, `slack` (n,) how much nearer
    than another a bar must be to be so in float32 as well."""
    groups = len(tree.boxes)
    stack, keys = np.empty(STACK, np.int64), np.empty(STACK)
    centre, half, q, lo, hi = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for n in range(len(boxes.places)):
        finite, radius = True, 0.0
        for a in range(3):
            lo[a], hi[a] = boxes.lo[a, n], boxes.hi[a, n]
            centre[a], half[a] = lo[a] / 2 + hi[a] / 2, hi[a] / 2 - lo[a] / 2
            finite = finite and np.isfinite(half[a])
            radius += half[a] * half[a]
        radius = np.sqrt(radius)
        finite = finite and radius < 1e150
        ranges = out.ranges[n]
        ranges[:, 0], ranges[:, 1] = np.inf, -np.inf
        place = boxes.places[n]
        most = np.inf
        if finite and place >= 0:
            most = _highest(tree.bars[place // WIDE], place % WIDE, lo, hi)
        # twice down the tree: for the least distance, then for every bar that may be nearest
        least, count = np.inf, 0
        for step in range(2):
            if step == 1 and not (all_results and finite and place >= 0):
                break
            node, height = 0, 0
            limit = least if step == 0 else most + slack[n]
            while True:
                if node < groups:
                    first = 1 if node == 0 else WIDE * node - 7 + tree.top
                    bottom = height
                    for c in range(WIDE):
                        box = tree.boxes[node]
                        if not box[6, c] >= 0:
                            continue
                        gap = 0.0
                        for a in range(3):
                            gap += _between(lo[a], hi[a], box[a, c], box[3 + a, c]) ** 2
                        key = np.sqrt(gap) - box[6, c]
                        if key <= limit:
                            at = height
                            while at > bottom and keys[at - 1] < key:
                                stack[at], keys[at] = stack[at - 1], keys[at - 1]
                                at -= 1
                            stack[at], keys[at] = first + c, key
                            height += 1
                else:
                    bars = tree.bars[node - groups]
                    for c in range(WIDE):
                        if not bars[6, c] >= 0:
                            continue
                        if not finite:
                            gap = 0.0
                            for a in range(3):
                                low, high = min(bars[a, c], bars[3 + a, c]), max(bars[a, c], bars[3 + a, c])
                                gap += _between(lo[a], hi[a], low, high) ** 2
                            least = min(least, np.sqrt(gap) - bars[6, c])
                            continue
                        low, size, first_foot, last_foot = _tangent(bars, c, centre, half, q)
                        if step == 0:
                            least = min(least, low)
                        elif low <= limit:
                            count += 1
                            m = (node - groups) * WIDE + c
                            if size > radius:
                                turn = 2 * radius / (2 * size - radius)  # of a unit vector
                                for a in range(3):
                                    n_a = q[a] / size
                                    _add(ranges, 1 + a, max(n_a - turn, -1.0), min(n_a + turn, 1.0))
                            else:
                                out.touches[n] = True
                                for a in range(3):
                                    _add(ranges, 1 + a, -1.0, 1.0)
                            for a in range(3):
                                _add(ranges, 4 + a, tree.frames[m, a], tree.frames[m, a])
                            _add(ranges, 7, first_foot, last_foot)
                            _add(ranges, 8, bars[6, c], bars[6, c])
                            _add(ranges, 9, tree.frames[m, 3], tree.frames[m, 3])
                            _add(ranges, 10, float(tree.ids[m]), float(tree.ids[m]))
                    if step == 0:
                        limit = least
                    if count > MOST:
                        break
                going = False
                while height > 0 and not going:
                    height -= 1
                    node = stack[height]
                    going = keys[height] < limit if step == 0 else True
                if not going:
                    break
        if count == 0 or count > MOST:
            ranges[:] = everything
            out.touches[n] = True
        out.several[n] = count != 1
        ranges[0, 0], ranges[0, 1] = least, most
