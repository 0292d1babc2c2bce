"""Compiled loops over the voxels of a periodic grid, component first, z fastest."""

from __future__ import annotations

from typing import Any

import numpy as np

from porelang.compiled import compiled


@compiled
def forces(u: Any, density: Any, rows: Any, cols: Any, entries: Any, out: Any) -> None:
    """The nodal forces of nodal values u (d, nx, ny, nz) in voxels of a density (nx, ny, nz); node n is the lower
    corner of voxel n.

    Row by row along z: to modes, times the element in modes, and back. Every step is a pass over a row, which the
    compiler makes vector instructions of.
    """
    d, nx, ny, nz = u.shape
    out[:] = 0.0
    a, b = np.empty((4, nz + 1)), np.empty((4, nz))
    mode, force = np.empty((8 * d, nz)), np.empty((8 * d, nz))
    for i in range(nx):
        i1 = i + 1 if i + 1 < nx else 0
        for j in range(ny):
            w = density[i, j]
            if not w.any():
                continue
            j1 = j + 1 if j + 1 < ny else 0
            for x in range(d):
                r0, r1, r2, r3 = u[x, i, j], u[x, i, j1], u[x, i1, j], u[x, i1, j1]
                for k in range(nz):
                    s0, d0, s1, d1 = r0[k] + r1[k], r1[k] - r0[k], r2[k] + r3[k], r3[k] - r2[k]
                    a[0, k], a[1, k], a[2, k], a[3, k] = s0 + s1, d0 + d1, s1 - s0, d1 - d0
                for q in range(4):
                    row, low, high = a[q], mode[8 * x + 2 * q], mode[8 * x + 2 * q + 1]
                    row[nz] = row[0]
                    for k in range(nz):
                        low[k], high[k] = w[k] * (row[k] + row[k + 1]), w[k] * (row[k + 1] - row[k])
            force[:] = 0.0
            for e in range(len(entries)):
                source, target, entry = mode[cols[e]], force[rows[e]], entries[e]
                for k in range(nz):
                    target[k] += entry * source[k]
            for x in range(d):
                for q in range(4):
                    row, low, high = b[q], force[8 * x + 2 * q], force[8 * x + 2 * q + 1]
                    row[0] = low[0] - high[0] + low[nz - 1] + high[nz - 1]
                    for k in range(1, nz):
                        row[k] = low[k] - high[k] + low[k - 1] + high[k - 1]
                r0, r1, r2, r3 = out[x, i, j], out[x, i, j1], out[x, i1, j], out[x, i1, j1]
                for k in range(nz):
                    s0, d0, s1, d1 = b[0, k] - b[2, k], b[1, k] - b[3, k], b[0, k] + b[2, k], b[1, k] + b[3, k]
                    r0[k] += s0 - d0
                    r1[k] += s0 + d0
                    r2[k] += s1 - d1
                    r3[k] += s1 + d1


@compiled
def inner(a: Any, b: Any) -> float:
    """The inner product of two flat arrays, summed in blocks so that rounding does not grow with their length."""
    total, block = 0.0, 0.0
    for i in range(len(a)):
        block += a[i] * b[i]
        if i % 256 == 255:
            total += block
            block = 0.0
    return total + block


@compiled
def step(along: Any, force: Any, length: Any, u: Any, residual: Any) -> float:
    """A step of conjugate gradients, in place: u += length * along, residual -= length * force. Gives |residual|^2."""
    total = 0.0
    for i in range(len(u)):
        u[i] += length * along[i]
        r = residual[i] - length * force[i]
        residual[i] = r
        total += r * r
    return total


@compiled
def turn(found: Any, local: Any, residual: Any, share: Any, along: Any) -> None:
    """The next direction, in place: along = found + local * residual + share * along; `local` for each node."""
    d, n = residual.shape
    for x in range(d):
        for i in range(n):
            along[x, i] = found[x, i] + local[i] * residual[x, i] + share * along[x, i]


@compiled
def product(found: Any, local: Any, residual: Any) -> float:
    """The inner product of residual (d, n) and found + local * residual."""
    d, n = residual.shape
    total, block = 0.0, 0.0
    for x in range(d):
        for i in range(n):
            block += residual[x, i] * (found[x, i] + local[i] * residual[x, i])
            if i % 256 == 255:
                total += block
                block = 0.0
    return total + block


@compiled
def answered(spectrum: Any, green: Any) -> None:
    """A spectrum (d, n) times the symmetric blocks (d (d + 1) / 2, n) of Green's operator, in place."""
    d, n = spectrum.shape
    if d == 1:
        for i in range(n):
            spectrum[0, i] *= green[0, i]
        return
    for i in range(n):
        x, y, z = spectrum[0, i], spectrum[1, i], spectrum[2, i]
        spectrum[0, i] = green[0, i] * x + green[1, i] * y + green[2, i] * z
        spectrum[1, i] = green[1, i] * x + green[3, i] * y + green[4, i] * z
        spectrum[2, i] = green[2, i] * x + green[4, i] * y + green[5, i] * z
