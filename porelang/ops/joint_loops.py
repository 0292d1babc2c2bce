"""The loops that join bars smoothly, compiled: those near a place, and the one number in which they agree.

Of the distances d of the bars near a place the union is the least, m. The smooth one is f, where
sum of (1 - (d - f) / k)^3 = 1 over the bars with d < f + k: of a bar alone f = d. With s = (m - f) / k and
t = (d - m) / k it is sum of (1 - t - s)^3 = 1: falling and convex in s, so that Newton's steps from s = 0 come to it
from one side. No more than the MOST nearest bars count, which is their distances in order, whatever the order of bars.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.ops.segment_loops import STACK, WIDE, Tree, _foot, _keys, _walk

Values = NDArray[Any]
Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
#: Bars that are joined at a place, and Newton's steps: from s = 0 to 1 - 64^(-1/3) it is exact after nine.
MOST, STEPS = 64, 10


@compiled
def _near(
    tree: Tree, x: Any, y: Any, z: Any, limit: Any, stack: Ints, work: Values, nought: Any, one: Any, out: Values,
    places: Ints,
) -> int:  # fmt: skip
    """Write the distances of the bars up to a limit and their places, of more than fit the nearest; their number."""
    groups, room = len(tree.boxes), len(places)
    node, height, count = 0, 0, 0
    while True:
        if node < groups:
            _keys(tree.boxes[node], x, y, z, nought, work)
            first = 1 if node == 0 else WIDE * node - 7 + tree.top
            for c in range(WIDE):
                if work[c] <= limit:
                    stack[height] = first + c
                    height += 1
        else:
            bars = tree.bars[node - groups]
            for c in range(WIDE):
                if not bars[6, c] >= nought:
                    continue
                qx, qy, qz, _ = _foot(bars, c, x, y, z, nought, one)
                d = np.sqrt(qx * qx + qy * qy + qz * qz) - bars[6, c]
                if not d <= limit:
                    continue
                at = count
                if count >= room:  # in place of the farthest
                    at = 0
                    for i in range(1, room):
                        if out[i] > out[at]:
                            at = i
                    if not d < out[at]:
                        count += 1
                        continue
                out[at], places[at] = d, (node - groups) * WIDE + c
                count += 1
        if height == 0:
            return count
        height -= 1
        node = stack[height]


@compiled
def joined(tree: Tree, x: Values, y: Values, z: Values, k: Values, out: Values) -> None:
    """Write results (results, points) at points, each with its own k: all of `joints.RESULTS`, or the first alone."""
    real = tree.bars.dtype.type
    nought, one, two = real(0), real(1), real(2)
    endless = real(float("inf"))
    stack, keys, work = np.empty(STACK, np.int32), np.empty(STACK, tree.bars.dtype), np.empty(WIDE, tree.bars.dtype)
    d, places = np.empty(MOST, tree.bars.dtype), np.empty(MOST, np.int32)
    seed = 0
    for n in range(out.shape[1]):
        px, py, pz, wide = x[n], y[n], z[n], k[n]
        if not (px == px and py == py and pz == pz and wide == wide):
            out[:, n] = real(float("nan"))
            continue
        seed = _walk(tree, px, py, pz, seed, stack, keys, work, nought, one)
        qx, qy, qz, _ = _foot(tree.bars[seed // WIDE], seed % WIDE, px, py, pz, nought, one)
        q = np.sqrt(qx * qx + qy * qy + qz * qz)
        if not q < endless:
            out[:, n] = real(float("nan"))
            out[0, n] = endless
            continue
        least = q - tree.bars[seed // WIDE, 6, seed % WIDE]
        d[0], places[0] = least, seed
        count = 1
        if wide > nought:
            count = _near(tree, px, py, pz, least + wide, stack, work, nought, one, d, places)
            count = min(count, MOST)
        over = one / wide if wide > nought else nought
        s = nought
        for _ in range(STEPS if count > 1 else 0):
            cubes, squares = -one, nought
            for i in range(count):
                u = one - (d[i] - least) * over - s
                if u > nought:
                    squares += u * u
                    cubes += u * u * u
            if cubes > nought:
                s += cubes / (real(3) * squares)
        out[0, n] = least - wide * s if wide > nought else least
        if len(out) == 1:
            continue
        # the means, weighted by u^2
        b = gx = gy = gz = slope = nought
        for i in range(count):
            u = one - (d[i] - least) * over - s
            if u > nought:
                leaf, lane = tree.bars[places[i] // WIDE], places[i] % WIDE
                qx, qy, qz, _ = _foot(leaf, lane, px, py, pz, nought, one)
                q = np.sqrt(qx * qx + qy * qy + qz * qz)
                if q > nought:
                    gx += u * u * (qx / q)
                    gy += u * u * (qy / q)
                    gz += u * u * (qz / q)
                b += u * u
                slope += u * u * (one - u)
        gx, gy, gz, slope = gx / b, gy / b, gz / b, -slope / b
        out[1, n], out[2, n], out[3, n], out[4, n] = gx, gy, gz, slope
        for a in range(5, 15):
            out[a, n] = nought
        for i in range(count):
            u = one - (d[i] - least) * over - s
            if not u > nought:
                continue
            leaf, lane = tree.bars[places[i] // WIDE], places[i] % WIDE
            qx, qy, qz, t = _foot(leaf, lane, px, py, pz, nought, one)
            q = np.sqrt(qx * qx + qy * qy + qz * qz)
            nx = ny = nz = bend = along = nought
            if q > nought:
                nx, ny, nz, bend = qx / q, qy / q, qz / q, u * u / q
                along = one if t > nought and t < one else nought
            tx, ty, tz = tree.frames[places[i], 0], tree.frames[places[i], 1], tree.frames[places[i], 2]
            ex, ey, ez = nx - gx, ny - gy, nz - gz
            pull, rate = two * u * over, (one - u + slope) * over
            out[5, n] += bend * (one - nx * nx - along * tx * tx) - pull * ex * ex
            out[6, n] += bend * (-nx * ny - along * tx * ty) - pull * ex * ey
            out[7, n] += bend * (-nx * nz - along * tx * tz) - pull * ex * ez
            out[8, n] += bend * (one - ny * ny - along * ty * ty) - pull * ey * ey
            out[9, n] += bend * (-ny * nz - along * ty * tz) - pull * ey * ez
            out[10, n] += bend * (one - nz * nz - along * tz * tz) - pull * ez * ez
            out[11, n] += two * u * rate * ex
            out[12, n] += two * u * rate * ey
            out[13, n] += two * u * rate * ez
            out[14, n] -= (two * u - real(3) * u * u + two * u * slope) * rate
        for a in range(5, 15):
            out[a, n] /= b


@compiled
def around(tree: Tree, x: Floats, y: Floats, z: Floats, reach: Floats, out: Floats) -> None:
    """Write of points (4, points): the number of bars up to `reach` farther than the nearest, their least distance to
    an axis, how near to the plane at an end of one the point lies, and their least length."""
    stack, keys, work = np.empty(STACK, np.int32), np.empty(STACK), np.empty(WIDE)
    d, places = np.empty(4 * MOST), np.empty(4 * MOST, np.int32)
    seed = 0
    for n in range(out.shape[1]):
        out[0, n], out[1, n], out[2, n], out[3, n] = np.inf, 0.0, 0.0, 0.0
        if not (np.isfinite(x[n]) and np.isfinite(y[n]) and np.isfinite(z[n]) and reach[n] >= 0):
            continue
        seed = _walk(tree, x[n], y[n], z[n], seed, stack, keys, work, 0.0, 1.0)
        qx, qy, qz, _ = _foot(tree.bars[seed // WIDE], seed % WIDE, x[n], y[n], z[n], 0.0, 1.0)
        limit = np.sqrt(qx * qx + qy * qy + qz * qz) - tree.bars[seed // WIDE, 6, seed % WIDE] + reach[n]
        if not limit < np.inf:
            continue
        count = _near(tree, x[n], y[n], z[n], limit, stack, work, 0.0, 1.0, d, places)
        out[0, n] = count
        if count > len(places):
            continue
        axis = plane = short = np.inf
        for i in range(count):
            leaf, lane = tree.bars[places[i] // WIDE], places[i] % WIDE
            qx, qy, qz, _ = _foot(leaf, lane, x[n], y[n], z[n], 0.0, 1.0)
            axis = min(axis, np.sqrt(qx * qx + qy * qy + qz * qz))
            length, dot = tree.frames[places[i], 3], 0.0
            px, py, pz = x[n] - leaf[0, lane], y[n] - leaf[1, lane], z[n] - leaf[2, lane]
            frame = tree.frames[places[i]]
            dot = px * frame[0] + py * frame[1] + pz * frame[2]
            plane = min(plane, abs(dot), abs(length - dot))
            short = min(short, length)
        out[1, n], out[2, n], out[3, n] = axis, plane, short
