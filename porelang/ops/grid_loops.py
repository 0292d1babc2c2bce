"""The loops of grid lookup, compiled: interpolation at points, in the type of the coordinates.

Every operation is rounded once and in a fixed order, which shaders/lib/pore_lookup.glsl and its neighbours repeat.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.ops.points import Strided, Triple

Values = NDArray[Any]


class Lattice(NamedTuple):
    """A grid in the working type: `origin`, `rate` (1 / spacing), `top` (the last node's number) and `end` (its place).

    `values` are flat, and float32 for either type where the data are.
    """

    values: Values
    shape: tuple[int, int, int, int]
    origin: Values
    rate: Values
    top: Values
    end: Values


@compiled
def _mix(a: Any, b: Any, f: Any, rate: Any, order: int) -> Any:
    """Between a and b at the part f, or the slope there."""
    if order == 0:
        return a + (b - a) * f
    return (b - a) * rate


@compiled
def _cell(u: Any, count: int) -> int:
    """The cell along an axis that holds u, which lies in 0..count-1."""
    i = int(u)
    return i if i < count - 2 else count - 2


@compiled
def linear(
    grid: Lattice, component: int, orders: Triple, x: Strided, y: Strided, z: Strided, out: Strided, loops: Triple
) -> None:
    """Trilinear interpolation, or a derivative of order 0 or 1 along each axis."""
    real = grid.origin.dtype.type
    values, origin, rate, top = grid.values, grid.origin, grid.rate, grid.top
    nx, ny, nz, step = grid.shape
    ox, oy, oz = origin[0], origin[1], origin[2]
    rx, ry, rz = rate[0], rate[1], rate[2]
    tx, ty, tz = top[0], top[1], top[2]
    nought = real(0)
    bad = real(float("nan"))
    row, plane = nz * step, ny * nz * step
    ki, kj, kk = orders
    plain = ki == 0 and kj == 0 and kk == 0
    for a in range(loops[0]):
        for b in range(loops[1]):
            xs = a * x.steps[0] + b * x.steps[1]
            ys = a * y.steps[0] + b * y.steps[1]
            zs = a * z.steps[0] + b * z.steps[1]
            os = a * out.steps[0] + b * out.steps[1]
            for c in range(loops[2]):
                u = (x.memory[xs + c * x.steps[2]] - ox) * rx
                v = (y.memory[ys + c * y.steps[2]] - oy) * ry
                w = (z.memory[zs + c * z.steps[2]] - oz) * rz
                at = os + c * out.steps[2]
                if not (u == u and v == v and w == w):
                    out.memory[at] = bad
                    continue
                if not plain and (
                    (ki > 0 and (u < nought or u > tx))
                    or (kj > 0 and (v < nought or v > ty))
                    or (kk > 0 and (w < nought or w > tz))
                ):
                    out.memory[at] = nought
                    continue
                u = u if u > nought else nought
                v = v if v > nought else nought
                w = w if w > nought else nought
                u = u if u < tx else tx
                v = v if v < ty else ty
                w = w if w < tz else tz
                i, j, k = _cell(u, nx), _cell(v, ny), _cell(w, nz)
                f, g, h = u - real(i), v - real(j), w - real(k)
                p = i * plane + j * row + k * step + component
                if plain:
                    p00 = real(values[p]) + (real(values[p + step]) - real(values[p])) * h
                    p01 = real(values[p + row]) + (real(values[p + row + step]) - real(values[p + row])) * h
                    q = p + plane
                    p10 = real(values[q]) + (real(values[q + step]) - real(values[q])) * h
                    p11 = real(values[q + row]) + (real(values[q + row + step]) - real(values[q + row])) * h
                    p0 = p00 + (p01 - p00) * g
                    p1 = p10 + (p11 - p10) * g
                    out.memory[at] = p0 + (p1 - p0) * f
                else:
                    q = p + plane
                    p00 = _mix(real(values[p]), real(values[p + step]), h, rz, kk)
                    p01 = _mix(real(values[p + row]), real(values[p + row + step]), h, rz, kk)
                    p10 = _mix(real(values[q]), real(values[q + step]), h, rz, kk)
                    p11 = _mix(real(values[q + row]), real(values[q + row + step]), h, rz, kk)
                    p0 = _mix(p00, p01, g, ry, kj)
                    p1 = _mix(p10, p11, g, ry, kj)
                    out.memory[at] = _mix(p0, p1, f, rx, ki)


@compiled
def _weights(f: Any, i: int, count: int, order: int, constants: Values) -> tuple[Any, Any, Any]:
    """What the nodes i-1, i+1 and i+2 add to the node i, each times its difference from it.

    Catmull-Rom: the four weights sum to 1 (to 0 in a derivative), so that of node i need not be known, and a constant
    field comes out exactly. A node beyond the border continues the line of the last two: its weight joins theirs.
    """
    half, one, two, three = constants[0], constants[1], constants[2], constants[3]
    if order == 0:
        a = f * (f * (one - half * f) - half)
        b = f * (f * (two - (one + half) * f) + half)
        c = f * f * (half * f - half)
    elif order == 1:
        a = f * (two - (one + half) * f) - half
        b = f * ((two + two) - (three + one + half) * f) + half
        c = f * ((one + half) * f - one)
    elif order == 2:
        a = two - three * f
        b = (two + two) - (three * three) * f
        c = three * f - one
    else:
        a = -three
        b = -(three * three)
        c = three
    if i == 0:
        b = b - a
        a = a - a
    if i == count - 2:
        b = b + two * c
        c = c - c
    return a, b, c


@compiled
def _blend(m: Any, n: Any, o: Any, p: Any, a: Any, b: Any, c: Any, base: Any) -> Any:
    """The cubic through four nodes in a row; `base` is 0 in a derivative, else 1."""
    return base * n + ((m - n) * a + (o - n) * b + (p - n) * c)


@compiled
def _line(values: Values, start: int, places: Any, weights: Any, constants: Values) -> Any:
    """The cubic through four nodes along z."""
    a, b, c, base = weights
    real = constants.dtype.type
    return _blend(
        real(values[start + places[0]]),
        real(values[start + places[1]]),
        real(values[start + places[2]]),
        real(values[start + places[3]]),
        a,
        b,
        c,
        base,
    )


@compiled
def cubic(
    grid: Lattice,
    constants: Values,
    component: int,
    orders: Triple,
    x: Strided,
    y: Strided,
    z: Strided,
    out: Strided,
    loops: Triple,
) -> None:
    """Tricubic Catmull-Rom interpolation, or a derivative of order 0 to 3 along each axis."""
    real = grid.origin.dtype.type
    values, origin, rate, top = grid.values, grid.origin, grid.rate, grid.top
    nx, ny, nz, step = grid.shape
    ox, oy, oz = origin[0], origin[1], origin[2]
    rx, ry, rz = rate[0], rate[1], rate[2]
    tx, ty, tz = top[0], top[1], top[2]
    nought, one = real(0), real(1)
    bad = real(float("nan"))
    row, plane = nz * step, ny * nz * step
    ki, kj, kk = orders
    scale_x, scale_y, scale_z = one, one, one
    for _ in range(ki):
        scale_x = scale_x * rx
    for _ in range(kj):
        scale_y = scale_y * ry
    for _ in range(kk):
        scale_z = scale_z * rz
    base_x = one if ki == 0 else nought
    base_y = one if kj == 0 else nought
    base_z = one if kk == 0 else nought
    for a in range(loops[0]):
        for b in range(loops[1]):
            xs = a * x.steps[0] + b * x.steps[1]
            ys = a * y.steps[0] + b * y.steps[1]
            zs = a * z.steps[0] + b * z.steps[1]
            os = a * out.steps[0] + b * out.steps[1]
            for c in range(loops[2]):
                u = (x.memory[xs + c * x.steps[2]] - ox) * rx
                v = (y.memory[ys + c * y.steps[2]] - oy) * ry
                w = (z.memory[zs + c * z.steps[2]] - oz) * rz
                at = os + c * out.steps[2]
                if not (u == u and v == v and w == w):
                    out.memory[at] = bad
                    continue
                if (
                    (ki > 0 and (u < nought or u > tx))
                    or (kj > 0 and (v < nought or v > ty))
                    or (kk > 0 and (w < nought or w > tz))
                ):
                    out.memory[at] = nought
                    continue
                u = u if u > nought else nought
                v = v if v > nought else nought
                w = w if w > nought else nought
                u = u if u < tx else tx
                v = v if v < ty else ty
                w = w if w < tz else tz
                i, j, k = _cell(u, nx), _cell(v, ny), _cell(w, nz)
                xa, xb, xc = _weights(u - real(i), i, nx, ki, constants)
                ya, yb, yc = _weights(v - real(j), j, ny, kj, constants)
                za, zb, zc = _weights(w - real(k), k, nz, kk, constants)
                k0, k1 = (k - 1 if k > 0 else 0) * step + component, k * step + component
                k2, k3 = k1 + step, (k + 2 if k + 2 < nz else k + 1) * step + component
                j0, j1, j2, j3 = (j - 1 if j > 0 else 0) * row, j * row, (j + 1) * row, min(j + 2, ny - 1) * row
                places, along_z = (k0, k1, k2, k3), (za, zb, zc, base_z)
                r0 = r1 = r2 = r3 = nought
                for m in range(4):
                    n = i - 1 + m
                    n = n if n > 0 else 0
                    n = n if n < nx else nx - 1
                    p = n * plane
                    s0 = _line(values, p + j0, places, along_z, constants)
                    s1 = _line(values, p + j1, places, along_z, constants)
                    s2 = _line(values, p + j2, places, along_z, constants)
                    s3 = _line(values, p + j3, places, along_z, constants)
                    r = _blend(s0 * scale_z, s1 * scale_z, s2 * scale_z, s3 * scale_z, ya, yb, yc, base_y) * scale_y
                    if m == 0:
                        r0 = r
                    elif m == 1:
                        r1 = r
                    elif m == 2:
                        r2 = r
                    else:
                        r3 = r
                out.memory[at] = _blend(r0, r1, r2, r3, xa, xb, xc, base_x) * scale_x


@compiled
def covers(grid: Lattice, x: Strided, y: Strided, z: Strided, out: Strided, loops: Triple) -> None:
    """Whether a point lies within the nodes' box."""
    ox, oy, oz = grid.origin[0], grid.origin[1], grid.origin[2]
    ex, ey, ez = grid.end[0], grid.end[1], grid.end[2]
    for a in range(loops[0]):
        for b in range(loops[1]):
            for c in range(loops[2]):
                px = x.memory[a * x.steps[0] + b * x.steps[1] + c * x.steps[2]]
                py = y.memory[a * y.steps[0] + b * y.steps[1] + c * y.steps[2]]
                pz = z.memory[a * z.steps[0] + b * z.steps[1] + c * z.steps[2]]
                out.memory[a * out.steps[0] + b * out.steps[1] + c * out.steps[2]] = (
                    px >= ox and px <= ex and py >= oy and py <= ey and pz >= oz and pz <= ez
                )
