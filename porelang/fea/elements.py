"""Shape functions of order 1 and 2 on tetrahedra and triangles, and rules of quadrature in barycentric coordinates."""

from __future__ import annotations

import numpy as np

from porelang.fea.nodes import EDGES
from porelang.fea.problem import Floats, Ints

_A, _B = (5 - np.sqrt(5)) / 20, (5 + 3 * np.sqrt(5)) / 20
#: Four points of equal weight, exact to degree 2 (Hammer, Marlowe and Stroud, 1956).
TET_4 = np.full((4, 4), _A) + (_B - _A) * np.eye(4)
TET_1 = np.full((1, 4), 0.25)


def tet_rule(degree: int) -> tuple[Floats, Floats]:
    """Points (q, 4) and weights (q,) on a tetrahedron: a conical product of Gauss-Jacobi rules (Stroud 1971)."""
    from scipy.special import roots_jacobi

    n = degree // 2 + 1
    axes = [roots_jacobi(n, power, 0) for power in (2, 1, 0)]
    (u, p), (v, q), (w, r) = [((x + 1) / 2, weight / weight.sum()) for x, weight in axes]
    a, b, c = (s.ravel() for s in np.meshgrid(u, v, w, indexing="ij"))
    x, y, z = a, b * (1 - a), c * (1 - a) * (1 - b)
    weights = np.einsum("i,j,k->ijk", p, q, r).ravel()
    return np.stack([1 - x - y - z, x, y, z], axis=1), weights


def triangle_rule(degree: int) -> tuple[Floats, Floats]:
    """Points (q, 3) and weights (q,) on a triangle, the same way."""
    from scipy.special import roots_jacobi

    n = degree // 2 + 1
    (u, p), (v, q) = [
        ((x + 1) / 2, weight / weight.sum()) for x, weight in (roots_jacobi(n, 1, 0), roots_jacobi(n, 0, 0))
    ]
    a, b = (s.ravel() for s in np.meshgrid(u, v, indexing="ij"))
    x, y = a, b * (1 - a)
    return np.stack([1 - x - y, x, y], axis=1), np.einsum("i,j->ij", p, q).ravel()


def shape_values(points: Floats, edges: Floats | None) -> Floats:
    """Shape functions (q, w) at barycentric points: those of order 1, or of order 2 with the middles of these edges."""
    if edges is None:
        return points
    middle = 4 * points[:, edges[:, 0]] * points[:, edges[:, 1]]
    return np.concatenate([points * (2 * points - 1), middle], axis=1)


TRIANGLE_EDGES = np.array([[0, 1], [1, 2], [0, 2]])


def slopes_at(points: Floats, order: int) -> Floats:
    """The factors (q, w, 2) of grad L at barycentric points (q, 4), for the corners that `terms` names."""
    corners, _ = terms(order)
    out = np.zeros((len(points), len(corners), 2))
    out[:, :4, 0] = 1.0 if order == 1 else 4 * points - 1
    if order == 2:
        for e, (i, j) in enumerate(EDGES):
            out[:, 4 + e, 0], out[:, 4 + e, 1] = 4 * points[:, i], 4 * points[:, j]
    return out


def terms(order: int) -> tuple[Ints, Floats]:
    """For each node of an element the corners (w, 2) whose gradients its own is made of (-1: none), and c (w, 2, w, 2).

    grad N = (4 L_k - 1) grad L_k at a corner, 4 (L_i grad L_j + L_j grad L_i) at the middle of an edge; the mean over a
    tetrahedron of L_i L_j is (1 + delta_ij) / 20, of L_i 1/4.
    """
    if order == 1:
        corners = np.array([[k, -1] for k in range(4)], np.int32)
        factors = np.zeros((4, 2, 5))
        factors[:, 0, 4] = 1.0
    else:
        corners = np.array([[k, -1] for k in range(4)] + [[j, i] for i, j in EDGES], np.int32)
        factors = np.zeros((10, 2, 5))  # of L_0 .. L_3 and 1
        for k in range(4):
            factors[k, 0, [k, 4]] = 4.0, -1.0
        for e, (i, j) in enumerate(EDGES):
            factors[4 + e, 0, i] = factors[4 + e, 1, j] = 4.0
    means = np.full((5, 5), 1 / 20)
    means[np.arange(4), np.arange(4)] = 1 / 10
    means[4], means[:, 4], means[4, 4] = 1 / 4, 1 / 4, 1.0
    return corners, np.einsum("aki,ij,blj->akbl", factors, means, factors)
