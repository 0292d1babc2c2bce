"""Whether one surface lies within a distance of another, proven, not sampled.

The distance from a triangle, which is convex, is a convex function: over a piece of the one surface it is largest at a
corner of the piece. So a piece whose corners are all near to one triangle of the other surface is near as a whole. A
piece that is not is cut along the sides of the triangle nearest to its centre, and its parts are looked at in turn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.mesh.surface import Surface
from porelang.parallel import parallel_for

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
PIECES = 2**15  # triangles at a time
DEEPEST = 4000  # pieces that one triangle may come to before it counts as too far
MOST_CELLS = 4e7
SLACK = 1e-9  # of a coordinate: more than all that the arithmetic here rounds off


def within(one: Surface, other: Surface, distance: float, threads: int = 1) -> tuple[float, Ints]:
    """A bound (mm) on how far any point of `one` is from `other`, and the triangles of `one` that are further than
    `distance` somewhere, or could not be proven nearer; the bound is that of the rest. It lies between the true largest
    distance and `distance`.
    """
    size = max(float(np.sqrt(2 * other.area / len(other.faces))), 2 * distance)
    low = np.minimum(one.vertices.min(axis=0), other.vertices.min(axis=0)) - distance
    high = np.maximum(one.vertices.max(axis=0), other.vertices.max(axis=0)) + distance
    cells = cells_of(other, size, low, high)
    pieces = one.vertices
    found = np.zeros(len(one.faces))
    slack = SLACK * float(np.abs(np.stack([low, high])).max())
    corners, size, shape, start, member = cells.corners, cells.size, cells.shape, cells.start, cells.member

    def work(first: int) -> None:
        some = slice(first, first + PIECES)
        _prove(pieces, one.faces[some], corners, low, size, shape, start, member, distance - slack, found[some])

    parallel_for(work, range(0, len(one.faces), PIECES), threads)
    far = np.flatnonzero(found < 0)
    return float(found.max(initial=0.0)) + slack, far


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """The triangles (m, 3, 3) of a surface in a grid of cells of a `size` (mm) from `low` on: those that reach into a
    cell are `member[start[cell] : start[cell + 1]]`, cells counted along z first."""

    corners: Floats
    low: Floats
    size: float
    shape: Ints
    start: Ints
    member: NDArray[np.int32]


def cells_of(surface: Surface, size: float, low: Floats, high: Floats) -> Cells:
    """The triangles of a surface by cells of about a `size` in the box `low` to `high` (mm)."""
    while np.prod((high - low) / size + 1) > MOST_CELLS:
        size *= 1.25
    shape = np.ceil((high - low) / size).astype(np.int64) + 1
    corners = np.ascontiguousarray(surface.vertices[surface.faces])
    start = np.zeros(int(np.prod(shape)) + 1, np.int64)
    _count(corners, low, size, shape, start)
    np.cumsum(start, out=start)
    member = np.empty(int(start[-1]), np.int32)
    _fill(corners, low, size, shape, start[:-1].copy(), member)
    return Cells(corners, low, size, shape, start, member)


@compiled
def _cell(x: float, low: float, size: float, most: int) -> int:
    return min(max(int((x - low) / size), 0), most - 1)


@compiled
def _count(corners: Floats, low: Floats, size: float, shape: Ints, start: Ints) -> None:
    """Into `start[cell + 1]` how many triangles reach into each cell."""
    for t in range(len(corners)):
        box = _box(corners[t], low, size, shape)
        for i in range(box[0], box[1]):
            for j in range(box[2], box[3]):
                for k in range(box[4], box[5]):
                    start[(i * shape[1] + j) * shape[2] + k + 1] += 1


@compiled
def _fill(corners: Floats, low: Floats, size: float, shape: Ints, place: Ints, member: Any) -> None:
    for t in range(len(corners)):
        box = _box(corners[t], low, size, shape)
        for i in range(box[0], box[1]):
            for j in range(box[2], box[3]):
                for k in range(box[4], box[5]):
                    cell = (i * shape[1] + j) * shape[2] + k
                    member[place[cell]] = t
                    place[cell] += 1


@compiled
def _box(corner: Floats, low: Floats, size: float, shape: Ints) -> Any:
    """The range of cells that a triangle reaches into."""
    a0, a1, b0, b1, c0, c1 = (
        _cell(min(corner[0, 0], corner[1, 0], corner[2, 0]), low[0], size, shape[0]),
        _cell(max(corner[0, 0], corner[1, 0], corner[2, 0]), low[0], size, shape[0]) + 1,
        _cell(min(corner[0, 1], corner[1, 1], corner[2, 1]), low[1], size, shape[1]),
        _cell(max(corner[0, 1], corner[1, 1], corner[2, 1]), low[1], size, shape[1]) + 1,
        _cell(min(corner[0, 2], corner[1, 2], corner[2, 2]), low[2], size, shape[2]),
        _cell(max(corner[0, 2], corner[1, 2], corner[2, 2]), low[2], size, shape[2]) + 1,
    )
    return a0, a1, b0, b1, c0, c1


@compiled
def square(px: float, py: float, pz: float, t: Floats) -> float:
    """The square of the distance of a point from a triangle (Ericson 2005, Real-Time Collision Detection, 5.1.5)."""
    ax, ay, az = t[0, 0], t[0, 1], t[0, 2]
    ux, uy, uz = t[1, 0] - ax, t[1, 1] - ay, t[1, 2] - az
    vx, vy, vz = t[2, 0] - ax, t[2, 1] - ay, t[2, 2] - az
    wx, wy, wz = px - ax, py - ay, pz - az
    d1, d2 = ux * wx + uy * wy + uz * wz, vx * wx + vy * wy + vz * wz
    uu, uv, vv = ux * ux + uy * uy + uz * uz, ux * vx + uy * vy + uz * vz, vx * vx + vy * vy + vz * vz
    d3, d4, d5, d6 = d1 - uu, d2 - uv, d1 - uv, d2 - vv
    a, b, c = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if d1 <= 0 and d2 <= 0:
        s, r = 0.0, 0.0
    elif d3 >= 0 and d4 <= d3:
        s, r = 1.0, 0.0
    elif c <= 0 and d1 >= 0 and d3 <= 0:
        s, r = d1 / (d1 - d3), 0.0
    elif d6 >= 0 and d5 <= d6:
        s, r = 0.0, 1.0
    elif b <= 0 and d2 >= 0 and d6 <= 0:
        s, r = 0.0, d2 / (d2 - d6)
    elif a <= 0 and d4 - d3 >= 0 and d5 - d6 >= 0:
        r = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        s = 1.0 - r
    else:
        total = a + b + c
        if total <= 0:  # no area
            s, r = 0.0, 0.0
        else:
            s, r = b / total, c / total
    x, y, z = wx - s * ux - r * vx, wy - s * uy - r * vy, wz - s * uz - r * vz
    return float(x * x + y * y + z * z)


@compiled
def _nearest(
    x: float,
    y: float,
    z: float,
    corners: Floats,
    low: Floats,
    size: float,
    shape: Ints,
    start: Ints,
    member: Any,
    reach: float,
) -> Any:
    """The triangle nearest to a point among those within `reach`, or -1, and the square of its distance."""
    best, least = -1, reach * reach
    for i in range(_cell(x - reach, low[0], size, shape[0]), _cell(x + reach, low[0], size, shape[0]) + 1):
        for j in range(_cell(y - reach, low[1], size, shape[1]), _cell(y + reach, low[1], size, shape[1]) + 1):
            for k in range(_cell(z - reach, low[2], size, shape[2]), _cell(z + reach, low[2], size, shape[2]) + 1):
                cell = (i * shape[1] + j) * shape[2] + k
                for m in range(start[cell], start[cell + 1]):
                    d = square(x, y, z, corners[member[m]])
                    if d <= least:
                        best, least = member[m], d
    return best, least


@compiled
def _prove(
    vertices: Floats,
    faces: Any,
    corners: Floats,
    low: Floats,
    size: float,
    shape: Ints,
    start: Ints,
    member: Any,
    distance: float,
    found: Floats,
) -> None:
    """Into `found` a bound on the distance of each triangle, or -1."""
    stack = np.empty((DEEPEST + 4, 3, 3))
    for f in range(len(faces)):
        for k in range(3):
            stack[0, k] = vertices[faces[f, k]]
        top, seen, worst = 1, 0, 0.0
        while top > 0:
            top -= 1
            p = stack[top].copy()
            seen += 1
            x, y, z = (p[0] + p[1] + p[2]) / 3
            near, _ = _nearest(x, y, z, corners, low, size, shape, start, member, distance)
            if near < 0 or seen > DEEPEST:
                worst = -1.0
                break
            t = corners[near]
            d = 0.0
            for k in range(3):
                d = max(d, square(p[k, 0], p[k, 1], p[k, 2], t))
            if d <= distance * distance:
                worst = max(worst, math.sqrt(d))
                continue
            top = _split(p, t, stack, top)
        found[f] = worst


@compiled
def _split(p: Floats, t: Floats, stack: Floats, top: int) -> int:
    """Push the parts of a piece: cut by the plane through the side of `t` that it is furthest beyond, or in half."""
    u, v = t[1] - t[0], t[2] - t[0]
    nx, ny, nz = u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]
    height = np.zeros(3)
    best = np.zeros(3)
    most = 0.0
    for k in range(3):
        a, b = t[k], t[(k + 1) % 3]
        e = b - a
        ox, oy, oz = e[1] * nz - e[2] * ny, e[2] * nx - e[0] * nz, e[0] * ny - e[1] * nx
        length = math.sqrt(ox * ox + oy * oy + oz * oz)
        if length == 0.0:
            continue
        for i in range(3):
            height[i] = ((p[i, 0] - a[0]) * ox + (p[i, 1] - a[1]) * oy + (p[i, 2] - a[2]) * oz) / length
        if height.max() > most and height.min() < 0:
            least = min(height.max(), -height.min())
            if least > most:
                most = least
                best[:] = height
    longest, at = 0.0, 0
    for k in range(3):
        side = p[(k + 1) % 3] - p[k]
        length = side[0] ** 2 + side[1] ** 2 + side[2] ** 2
        if length > longest:
            longest, at = length, k
    if most <= 1e-3 * math.sqrt(longest):
        middle = (p[at] + p[(at + 1) % 3]) / 2
        stack[top, 0], stack[top, 1], stack[top, 2] = p[at], middle, p[(at + 2) % 3]
        stack[top + 1, 0], stack[top + 1, 1], stack[top + 1, 2] = middle, p[(at + 1) % 3], p[(at + 2) % 3]
        return top + 2
    one = 0  # the corner that is alone on its side
    for k in range(3):
        if (best[k] > 0) != (best[(k + 1) % 3] > 0) and (best[k] > 0) != (best[(k + 2) % 3] > 0):
            one = k
    i, j = (one + 1) % 3, (one + 2) % 3
    q = p[one] + (p[i] - p[one]) * (best[one] / (best[one] - best[i]))
    r = p[one] + (p[j] - p[one]) * (best[one] / (best[one] - best[j]))
    stack[top, 0], stack[top, 1], stack[top, 2] = p[one], q, r
    stack[top + 1, 0], stack[top + 1, 1], stack[top + 1, 2] = q, p[i], r
    stack[top + 2, 0], stack[top + 2, 1], stack[top + 2, 2] = r, p[i], p[j]
    return top + 3
