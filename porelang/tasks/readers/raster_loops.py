"""The loops of rasterising, compiled: tetrahedra onto the nodes of a grid, and the nodes about a surface of triangles.

Places are in steps of the grid for the former (`u = (p - origin) / step`), in mm for the latter.
"""

from __future__ import annotations

import math
from typing import Any

from numpy.typing import NDArray

from porelang.compiled import compiled

Array = NDArray[Any]
#: A node that lies outside of a tetrahedron by so much, as a barycentric coordinate, is on its border.
_BORDER = 1e-9


@compiled
def fill(
    u: Array, tetrahedra: Array, values: Array, in_cells: bool, start: int, stop: int, inside: Array, out: Array
) -> None:
    """Values (nx, ny, nz, k) at the nodes of layers start..stop that lie in tetrahedra, of which `inside` tells.

    A node on several has the value that the last of them gives it: of a field that is linear in each and has its values
    at corners they all give the same.
    """
    _, ny, nz, k = out.shape
    for t in range(len(tetrahedra)):
        a, b, c, d = tetrahedra[t, 0], tetrahedra[t, 1], tetrahedra[t, 2], tetrahedra[t, 3]
        ax, ay, az = u[a, 0], u[a, 1], u[a, 2]
        low = min(ax, u[b, 0], u[c, 0], u[d, 0])
        high = max(ax, u[b, 0], u[c, 0], u[d, 0])
        i0, i1 = max(start, math.ceil(low - 1e-9)), min(stop - 1, math.floor(high + 1e-9))
        if i0 > i1:
            continue
        bx, by, bz = u[b, 0] - ax, u[b, 1] - ay, u[b, 2] - az
        cx, cy, cz = u[c, 0] - ax, u[c, 1] - ay, u[c, 2] - az
        dx, dy, dz = u[d, 0] - ax, u[d, 1] - ay, u[d, 2] - az
        volume = bx * (cy * dz - cz * dy) + by * (cz * dx - cx * dz) + bz * (cx * dy - cy * dx)
        if volume == 0:
            continue
        w = 1 / volume
        gbx, gby, gbz = (cy * dz - cz * dy) * w, (cz * dx - cx * dz) * w, (cx * dy - cy * dx) * w
        gcx, gcy, gcz = (dy * bz - dz * by) * w, (dz * bx - dx * bz) * w, (dx * by - dy * bx) * w
        gdx, gdy, gdz = (by * cz - bz * cy) * w, (bz * cx - bx * cz) * w, (bx * cy - by * cx) * w
        j0 = max(0, math.ceil(min(ay, u[b, 1], u[c, 1], u[d, 1]) - 1e-9))
        j1 = min(ny - 1, math.floor(max(ay, u[b, 1], u[c, 1], u[d, 1]) + 1e-9))
        l0 = math.ceil(min(az, u[b, 2], u[c, 2], u[d, 2]) - 1e-9)
        l1 = math.floor(max(az, u[b, 2], u[c, 2], u[d, 2]) + 1e-9)
        for i in range(i0, i1 + 1):
            x = i - ax
            for j in range(j0, j1 + 1):
                y = j - ay
                # along z each coordinate is linear: between which nodes are all of them positive?
                first, last = float(max(0, l0)), float(min(nz - 1, l1))
                sb = gbx * x + gby * y - gbz * az
                sc = gcx * x + gcy * y - gcz * az
                sd = gdx * x + gdy * y - gdz * az
                for m in range(4):
                    if m == 0:
                        s, g = sb, gbz
                    elif m == 1:
                        s, g = sc, gcz
                    elif m == 2:
                        s, g = sd, gdz
                    else:
                        s, g = 1 - sb - sc - sd, -gbz - gcz - gdz
                    s += _BORDER
                    if g > 0:
                        first = max(first, -s / g)
                    elif g < 0:
                        last = min(last, -s / g)
                    elif s < 0:
                        last = -1.0
                if not first <= last:
                    continue
                for l_ in range(math.ceil(first), math.floor(last) + 1):
                    inside[i, j, l_] = True
                    if in_cells:
                        for n in range(k):
                            out[i, j, l_, n] = values[t, n]
                    else:
                        fb, fc, fd = sb + gbz * l_, sc + gcz * l_, sd + gdz * l_
                        for n in range(k):
                            v = values[a, n]
                            out[i, j, l_, n] = (
                                v + fb * (values[b, n] - v) + fc * (values[c, n] - v) + fd * (values[d, n] - v)
                            )


@compiled
def _foot(x: float, y: float, z: float, p: Array, a: int, b: int, c: int) -> tuple[float, float, float, float]:
    """The square of the distance to a triangle, and the nearest place on it: C. Ericson, Real-Time Collision
    Detection, 2004, 5.1.5."""
    ax, ay, az = p[a, 0], p[a, 1], p[a, 2]
    ux, uy, uz = p[b, 0] - ax, p[b, 1] - ay, p[b, 2] - az
    vx, vy, vz = p[c, 0] - ax, p[c, 1] - ay, p[c, 2] - az
    wx, wy, wz = x - ax, y - ay, z - az
    d1, d2 = ux * wx + uy * wy + uz * wz, vx * wx + vy * wy + vz * wz
    uu, uv, vv = ux * ux + uy * uy + uz * uz, ux * vx + uy * vy + uz * vz, vx * vx + vy * vy + vz * vz
    d3, d4, d5, d6 = d1 - uu, d2 - uv, d1 - uv, d2 - vv
    s, t = 0.0, 0.0
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if d1 <= 0 and d2 <= 0:
        pass
    elif d3 >= 0 and d4 <= d3:
        s = 1.0
    elif d6 >= 0 and d5 <= d6:
        t = 1.0
    elif vc <= 0 and d1 >= 0 and d3 <= 0:
        s = d1 / (d1 - d3)
    elif vb <= 0 and d2 >= 0 and d6 <= 0:
        t = d2 / (d2 - d6)
    elif va <= 0 and d4 >= d3 and d5 >= d6:
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        s = 1 - t
    else:
        total = va + vb + vc
        s, t = vb / total, vc / total
    fx, fy, fz = ax + s * ux + t * vx, ay + s * uy + t * vy, az + s * uz + t * vz
    return (x - fx) ** 2 + (y - fy) ** 2 + (z - fz) ** 2, fx, fy, fz


@compiled
def near(
    p: Array,
    faces: Array,
    origin: Array,
    step: Array,
    reach: float,
    start: int,
    stop: int,
    square: Array,
    nearest: Array,
) -> None:
    """At the nodes of layers start..stop that lie within `reach` of a triangle, the square of the distance to the
    nearest of them, and which one it is."""
    _, ny, nz = square.shape
    ox, oy, oz = origin[0], origin[1], origin[2]
    sx, sy, sz = step[0], step[1], step[2]
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        i0 = max(start, math.ceil((min(p[a, 0], p[b, 0], p[c, 0]) - reach - ox) / sx))
        i1 = min(stop - 1, math.floor((max(p[a, 0], p[b, 0], p[c, 0]) + reach - ox) / sx))
        if i0 > i1:
            continue
        j0 = max(0, math.ceil((min(p[a, 1], p[b, 1], p[c, 1]) - reach - oy) / sy))
        j1 = min(ny - 1, math.floor((max(p[a, 1], p[b, 1], p[c, 1]) + reach - oy) / sy))
        l0 = max(0, math.ceil((min(p[a, 2], p[b, 2], p[c, 2]) - reach - oz) / sz))
        l1 = min(nz - 1, math.floor((max(p[a, 2], p[b, 2], p[c, 2]) + reach - oz) / sz))
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                for l_ in range(l0, l1 + 1):
                    found, _, _, _ = _foot(ox + sx * i, oy + sy * j, oz + sz * l_, p, a, b, c)
                    if found < square[i, j, l_] and found <= reach * reach:
                        square[i, j, l_] = found
                        nearest[i, j, l_] = f


@compiled
def extend(
    p: Array, tetrahedra: Array, faces: Array, owner: Array, values: Array, in_cells: bool,
    origin: Array, step: Array, start: int, stop: int, inside: Array, nearest: Array, known: Array, out: Array,
) -> None:  # fmt: skip
    """Values at nodes outside that lie near a triangle of the border: the field of its tetrahedron goes on, as far from
    its value at the foot as values of that tetrahedron lie apart."""
    _, ny, nz, k = out.shape
    for i in range(start, stop):
        for j in range(ny):
            for l_ in range(nz):
                f = nearest[i, j, l_]
                if inside[i, j, l_]:
                    known[i, j, l_] = True
                    continue
                if f < 0:
                    continue
                known[i, j, l_] = True
                t = owner[f]
                if in_cells:
                    for n in range(k):
                        out[i, j, l_, n] = values[t, n]
                    continue
                x, y, z = origin[0] + step[0] * i, origin[1] + step[1] * j, origin[2] + step[2] * l_
                _, fx, fy, fz = _foot(x, y, z, p, faces[f, 0], faces[f, 1], faces[f, 2])
                a, b, c, d = tetrahedra[t, 0], tetrahedra[t, 1], tetrahedra[t, 2], tetrahedra[t, 3]
                ax, ay, az = p[a, 0], p[a, 1], p[a, 2]
                bx, by, bz = p[b, 0] - ax, p[b, 1] - ay, p[b, 2] - az
                cx, cy, cz = p[c, 0] - ax, p[c, 1] - ay, p[c, 2] - az
                dx, dy, dz = p[d, 0] - ax, p[d, 1] - ay, p[d, 2] - az
                volume = bx * (cy * dz - cz * dy) + by * (cz * dx - cx * dz) + bz * (cx * dy - cy * dx)
                w = 1 / volume if volume != 0 else 0.0
                gbx, gby, gbz = (cy * dz - cz * dy) * w, (cz * dx - cx * dz) * w, (cx * dy - cy * dx) * w
                gcx, gcy, gcz = (dy * bz - dz * by) * w, (dz * bx - dx * bz) * w, (dx * by - dy * bx) * w
                gdx, gdy, gdz = (by * cz - bz * cy) * w, (bz * cx - bx * cz) * w, (bx * cy - by * cx) * w
                hx, hy, hz, ex, ey, ez = fx - ax, fy - ay, fz - az, x - fx, y - fy, z - fz
                for n in range(k):
                    v = values[a, n]
                    vb, vc, vd = values[b, n] - v, values[c, n] - v, values[d, n] - v
                    gx, gy, gz = (
                        gbx * vb + gcx * vc + gdx * vd,
                        gby * vb + gcy * vc + gdy * vd,
                        gbz * vb + gcz * vc + gdz * vd,
                    )
                    most = max(0.0, vb, vc, vd) - min(0.0, vb, vc, vd)
                    more = gx * ex + gy * ey + gz * ez
                    out[i, j, l_, n] = v + gx * hx + gy * hy + gz * hz + min(max(more, -most), most)
