"""The loops that find the nearest of random sites, one in each cell of size 1, compiled.

A site lies on a raster of its cell so coarse that its place, and the vector between two sites, are exact in float32: a
shader rounds only a point's distance from them, and walls between sites that nearly meet are as true as others.
shaders/lib/pore_sites.glsl has the same steps; these are in float64 for all, and keep the sites of a cell for the
points that follow in it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.ops.points import FARTHEST
from porelang.ops.random_loops import LOWER, PART, pcg4d, word

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]
#: Offsets of the cells that are looked at along an axis, near ones first. What lies beyond is 2 away at least; of 10^7
#: places at jitter 1 none looks for the fourth site or the second wall farther than 1.7.
NEAR = np.array([0, -1, 1, -2, 2], np.int64)
SIDE, REACH = 5, 2
#: Of a word, what is left for the place of a site along an axis: 15 bits.
PLACE = np.uint64(17)
MIDDLE = 2**14
#: Steps of the jitter from 0 to 1, and of places in a cell.
STEPS = 256


@compiled
def _site(cell: Whole, slot: int, places: Floats, numbers: Floats) -> None:
    """The site of the cell at an offset from `cell` (three whole numbers, the seed and the jitter's step)."""
    i, j, k = slot // (SIDE * SIDE) - REACH, slot // SIDE % SIDE - REACH, slot % SIDE - REACH
    x, y, z, number = pcg4d(word(cell[0] + i), word(cell[1] + j), word(cell[2] + k), word(cell[3]))
    places[slot, 0] = i + 0.5 + (2 * (np.int64(x >> PLACE) - MIDDLE) + 1) * cell[4] * PART
    places[slot, 1] = j + 0.5 + (2 * (np.int64(y >> PLACE) - MIDDLE) + 1) * cell[4] * PART
    places[slot, 2] = k + 0.5 + (2 * (np.int64(z >> PLACE) - MIDDLE) + 1) * cell[4] * PART
    numbers[slot] = (number >> LOWER) * PART


@compiled
def _gap(offset: int, f: float, half: float) -> float:
    """The square of the least distance along an axis of sites at an offset: they are within `half` of their middles."""
    gap = abs(offset + 0.5 - f) - half
    return gap * gap if gap > 0 else 0.0


@compiled
def sites(at: Floats, walls: bool, margins: bool, out: Floats) -> None:
    """What is known at places, (5, n) as x, y, z, seed and jitter, into out (19, n) in the order of `sites.RESULTS`.

    Walls are looked for only if they are wanted; and the distances from the fourth site and from the second wall, the
    last two rows, only with `margins`.
    """
    keep = 4 if margins else 3
    cell, here = np.empty(5, np.int64), np.empty(5, np.int64)
    places, numbers = np.empty((SIDE**3, 3)), np.empty(SIDE**3)
    made = np.zeros(SIDE**3, np.int64)  # in which of the cells so far a site was placed
    count = 0
    f, squares, slots = np.empty(3), np.empty(keep), np.empty(keep, np.int64)
    last = keep - 1
    cell[:] = 0
    for n in range(at.shape[1]):
        good = at[4, n] >= 0 and at[4, n] <= 1
        for a in range(4):
            good = good and abs(at[a, n]) < FARTHEST
        if not good:
            out[:, n] = np.nan
            continue
        for a in range(4):
            here[a] = np.int64(np.floor(at[a, n]))
        here[4] = np.int64(np.rint(at[4, n] * STEPS))
        fresh = count == 0
        for a in range(5):
            fresh = fresh or here[a] != cell[a]
        if fresh:
            cell[:] = here
            count += 1
        half = cell[4] / (2 * STEPS)
        for a in range(3):
            f[a] = at[a, n] - cell[a]
        squares[:], slots[:] = np.inf, -1
        for i in NEAR:
            gx = _gap(i, f[0], half)
            if gx > squares[last]:
                continue
            for j in NEAR:
                gy = gx + _gap(j, f[1], half)
                if gy > squares[last]:
                    continue
                for k in NEAR:
                    if gy + _gap(k, f[2], half) > squares[last]:
                        continue
                    slot = ((i + REACH) * SIDE + j + REACH) * SIDE + k + REACH
                    if made[slot] != count:
                        _site(cell, slot, places, numbers)
                        made[slot] = count
                    rx, ry, rz = places[slot, 0] - f[0], places[slot, 1] - f[1], places[slot, 2] - f[2]
                    square = rx * rx + ry * ry + rz * rz
                    if square < squares[last]:
                        m = last
                        while m > 0 and square < squares[m - 1]:
                            squares[m], slots[m] = squares[m - 1], slots[m - 1]
                            m -= 1
                        squares[m], slots[m] = square, slot
        for m in range(3):
            root = np.sqrt(squares[m])
            out[m, n] = root
            for a in range(3):
                out[4 + 3 * m + a, n] = (f[a] - places[slots[m], a]) / root if root > 0 else 0.0
        out[16, n] = numbers[slots[0]]
        if margins:
            out[17, n] = np.sqrt(squares[last])
        if not walls:
            continue
        own, across = slots[0], slots[1]
        wall = _wall(places, own, across, squares[1] - squares[0])
        second = _wall(places, own, slots[2], squares[2] - squares[0]) if margins else wall
        wall, second = min(wall, second), max(wall, second)
        reach = _reach(out[0, n], second)
        second = np.inf
        wall = np.inf
        for i in NEAR:
            gx = _gap(i, f[0], half)
            if gx > reach:
                continue
            for j in NEAR:
                gy = gx + _gap(j, f[1], half)
                if gy > reach:
                    continue
                for k in NEAR:
                    slot = ((i + REACH) * SIDE + j + REACH) * SIDE + k + REACH
                    if slot == own or gy + _gap(k, f[2], half) > reach:
                        continue
                    if made[slot] != count:
                        _site(cell, slot, places, numbers)
                        made[slot] = count
                    rx, ry, rz = places[slot, 0] - f[0], places[slot, 1] - f[1], places[slot, 2] - f[2]
                    found = _wall(places, own, slot, rx * rx + ry * ry + rz * rz - squares[0])
                    if found < wall:
                        wall, second, across = found, wall, slot
                    elif found < second:
                        second = found
                    reach = min(reach, _reach(out[0, n], second if margins else wall))
        out[3, n] = wall
        length = _apart(places, own, across)
        for a in range(3):
            out[13 + a, n] = (places[own, a] - places[across, a]) / length
        if margins:
            out[18, n] = second


@compiled
def _reach(nearest: float, wall: float) -> float:
    """The square of how far a site may be whose wall is no farther than this, with room for rounding where many are."""
    return (nearest + 2 * wall) ** 2 * (1 + 1e-12)


@compiled
def _apart(places: Floats, i: int, j: int) -> float:
    """The distance between two sites."""
    x, y, z = places[i, 0] - places[j, 0], places[i, 1] - places[j, 1], places[i, 2] - places[j, 2]
    return float(np.sqrt(x * x + y * y + z * z))


@compiled
def _wall(places: Floats, own: int, other: int, difference: float) -> float:
    """The distance of a point from the plane between two sites, by the difference of its squared distances."""
    return difference / (2 * _apart(places, own, other))
