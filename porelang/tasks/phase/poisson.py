"""The weighted Poisson equation on the nodes of a grid, with natural boundaries.

For weights m of the cells it is the normal equation of: minimise, over phi, the sum over cells and axes a of
m |d_a phi - g_a|^2, where the derivative along an axis is taken at each of a cell's four edges. For m = 1 it is solved
exactly by the discrete cosine transform (DCT-I: the boundary's nodes count half); for others that solution, scaled by
the root of the weights, preconditions conjugate gradients (P. Concus, G. Golub, Use of fast direct methods for the
efficient numerical solution of nonseparable elliptic equations, SIAM J. Numer. Anal. 10, 1973).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]
#: A cell outside the part counts this much: enough to carry the phase smoothly to where a skin or a hull may read it,
#: too little to bend the cells within (measured: with 1, periods near the rim err by what lies outside).
OUTSIDE = 0.02
#: A cell away from the part, where cells are to stand along directions: those on both sides of a gap may differ by many
#: turns, and what joins them must not hold them (measured: with 0.02 cells of three quarters of a ring fold at its
#: ends; with this they are within 2 degrees of its frame).
FAR = 1e-4


@dataclass(frozen=True, eq=False)
class Poisson:
    """The equation for the weights of the cells (nx-1, ny-1, nz-1) of a grid of nodes `spacing` mm apart."""

    weights: Values
    spacing: tuple[float, float, float]
    edges: tuple[Values, Values, Values]
    into: Values
    scale: Values
    inverse: Values


def poisson(weights: Values, spacing: Sequence[float]) -> Poisson:
    """The equation for positive weights of the cells; `spacing` along each axis, in mm."""
    steps = (float(spacing[0]), float(spacing[1]), float(spacing[2]))
    edges = tuple(to_edges(weights, a) / steps[a] ** 2 for a in range(3))
    nodes = weights
    for axis in range(3):
        nodes = _outer_mean(nodes, axis)
    counts = [n + 1 for n in weights.shape]
    eigenvalues = np.zeros(counts)
    half = np.ones(counts)
    for axis, count in enumerate(counts):
        shape = [-1 if a == axis else 1 for a in range(3)]
        turn = np.pi * np.arange(count) / (count - 1)
        eigenvalues = eigenvalues + ((2 - 2 * np.cos(turn)) / steps[axis] ** 2).reshape(shape)
        ends = np.ones(count)
        ends[[0, -1]] = 0.5
        half = half * ends.reshape(shape)
    eigenvalues[0, 0, 0] = np.sort(eigenvalues, axis=None)[1]  # a constant is free: any positive number does
    # `nodes` holds half, a quarter, an eighth of the weights on faces, edges and corners, as `half` does: what is left
    # is the mean weight of the cells about a node
    scale = np.sqrt(half / nodes)
    return Poisson(weights, steps, (edges[0], edges[1], edges[2]), scale / half, scale, 1 / eigenvalues)


def apply(equation: Poisson, phi: Values) -> Values:
    """The equation's left side for fields (k, nx, ny, nz)."""
    out = np.zeros_like(phi)
    for axis, weights in enumerate(equation.edges):
        lower, upper = _ends(axis)
        flow = weights * (phi[upper] - phi[lower])
        out[upper] += flow
        out[lower] -= flow
    return out


def pull(equation: Poisson, gradients: Sequence[Values]) -> Values:
    """The right side for the gradients that are wanted: along each axis (k, cells)."""
    k, *cells = gradients[0].shape
    out = np.zeros((k, *(n + 1 for n in cells)))
    for axis, wanted in enumerate(gradients):
        lower, upper = _ends(axis)
        flow = to_edges(equation.weights * wanted, axis) / equation.spacing[axis]
        out[upper] += flow
        out[lower] -= flow
    return out


def solve(equation: Poisson, right: Values, start: Values, tolerance: float, most: int = 200) -> tuple[Values, int]:
    """Fields (k, nx, ny, nz) for right sides of sum 0, up to a constant each, and the number of steps taken.

    Ends where the residual, as the preconditioner measures it, has fallen by `tolerance` against that of 0.
    """
    phi = start.copy()
    residual = right - apply(equation, phi)
    ahead = _precondition(equation, residual)
    size = _dot(residual, ahead)
    enough = tolerance**2 * _dot(right, _precondition(equation, right))
    direction = ahead
    for step in range(most):
        if (size <= enough).all():
            return phi, step
        bent = apply(equation, direction)
        length = _ratio(size, _dot(direction, bent))
        phi += length * direction
        residual -= length * bent
        ahead = _precondition(equation, residual)
        new = _dot(residual, ahead)
        direction = ahead + _ratio(new, size) * direction
        size = new
    return phi, most


def to_edges(cells: Values, axis: int) -> Values:
    """The mean of the cells' values, given to each of the four edges along an axis: summed where cells share one."""
    for other in range(-3, 0):
        if other != axis - 3:
            cells = _outer_mean(cells, other)
    return cells


def to_cells(edges: Values, axis: int) -> Values:
    """The mean over each cell of its four edges along an axis, of fields (k, ...)."""
    for other in range(3):
        if other != axis:
            lower, upper = _ends(other)
            edges = 0.5 * (edges[lower] + edges[upper])
    return edges


def along(phi: Values, axis: int, step: float) -> Values:
    """The derivative along an axis at the edges along it of fields (k, nx, ny, nz)."""
    lower, upper = _ends(axis)
    return np.asarray((phi[upper] - phi[lower]) / step)


def _outer_mean(values: Values, axis: int) -> Values:
    """Between values along an axis, the mean of two; at both ends half of the last."""
    pads = [(0, 0)] * values.ndim
    pads[axis] = (1, 1)
    wide = np.moveaxis(np.pad(values, pads), axis, 0)
    return np.moveaxis(0.5 * (wide[:-1] + wide[1:]), 0, axis)


def _ends(axis: int) -> tuple[Any, Any]:
    """The lower and the upper nodes of the edges along an axis, of fields (k, nx, ny, nz)."""
    return (
        (slice(None), *(slice(None, -1) if a == axis else slice(None) for a in range(3))),
        (slice(None), *(slice(1, None) if a == axis else slice(None) for a in range(3))),
    )


def _precondition(equation: Poisson, residual: Values) -> Values:
    from scipy.fft import dctn, idctn

    axes = (1, 2, 3)
    found = dctn(residual * equation.into, type=1, axes=axes) * equation.inverse
    return np.asarray(idctn(found, type=1, axes=axes)) * equation.scale


def _dot(a: Values, b: Values) -> Values:
    return np.asarray(np.einsum("kxyz,kxyz->k", a, b)[:, None, None, None])


def _ratio(a: Values, b: Values) -> Values:
    return np.divide(a, b, out=np.zeros_like(a), where=b > 0)
