"""Stresses recovered at vertices: a polynomial through those of the tetrahedra round each, fitted by least squares.

O. Zienkiewicz and J. Zhu, The superconvergent patch recovery and a posteriori error estimates, Int. J. Numer. Meth.
Engng 33
(1992): quadratic for order 2, through the four points of quadrature of each tetrahedron; linear for order 1, through
centroids. Where
there are few tetrahedra, and at the boundary, those round them join. Patches end where the material jumps: there a
vertex has a
value in each material (a *site* for each).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.fea.assemble import Longs, incidence, over_rows
from porelang.fea.elements import TET_1, TET_4
from porelang.fea.nodes import Nodes
from porelang.fea.problem import Floats, Ints

#: Neighbours whose moduli differ by more than this factor, or Poisson's ratios by more than that, are two materials.
JUMP, JUMP_OF_POISSON = 1.5, 0.05
#: Tetrahedra that a patch is to have before no further ones join.
_ENOUGH = {1: 8, 2: 14}


@dataclass(frozen=True, slots=True)
class Sites:
    """Where values are kept: a vertex in a material. The first n sites are the mesh's vertices, each in the stiffest
    material there.

    `vertex` (p,) and `corners` (m, 4): the sites of the corners of each tetrahedron.
    """

    vertex: Ints
    corners: Ints


def regions(nodes: Nodes, young: Floats, poisson: Floats) -> Ints:
    """The material (m,) of each tetrahedron: neighbours are of one unless their moduli jump."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    m = len(young)
    if np.ptp(young) <= 0 and np.ptp(poisson) <= 0:
        return np.zeros(m, np.int32)
    a, b = nodes.pairs.T
    alike = (np.abs(np.log(young[a] / young[b])) <= np.log(JUMP)) & (np.abs(poisson[a] - poisson[b]) <= JUMP_OF_POISSON)
    graph = coo_matrix((np.ones(alike.sum(), np.int8), (a[alike], b[alike])), shape=(m, m))
    return np.asarray(connected_components(graph, directed=False)[1], np.int32)


def sites(nodes: Nodes, region: Ints, young: Floats) -> Sites:
    """The sites of a mesh whose tetrahedra are of these materials (m,)."""
    if not region.any():
        return Sites(np.arange(nodes.vertices, dtype=np.int32), np.ascontiguousarray(nodes.corners))
    keys = (nodes.corners.astype(np.int64) * (int(region.max()) + 1) + region[:, None]).ravel()
    found, place = np.unique(keys, return_inverse=True)
    vertex = (found // (int(region.max()) + 1)).astype(np.int32)
    stiffness = np.zeros(len(found))
    np.maximum.at(stiffness, place.ravel(), np.repeat(young, 4))
    order = np.lexsort((-stiffness, vertex))
    first = np.ones(len(found), bool)
    first[1:] = vertex[order][1:] != vertex[order][:-1]
    rows = np.concatenate([order[first], order[~first]])
    number = np.empty(len(found), np.int32)
    number[rows] = np.arange(len(found))
    return Sites(vertex[rows], number[place].reshape(-1, 4))


def means(where: Sites, volumes: Floats, values: Floats) -> Floats:
    """The means (p, c), by volume, of values (m, c) of the tetrahedra round each site."""
    flat = where.corners.ravel()
    weights = np.bincount(flat, np.repeat(volumes, 4), len(where.vertex))
    columns = [np.bincount(flat, np.repeat(volumes * v, 4), len(where.vertex)) / weights for v in values.T]
    return np.stack(columns, axis=1)


@dataclass(frozen=True, slots=True)
class Fitted:
    """A polynomial for each site: `factors` (p, 4 or 10, 6) of 1, x, y, z, xx, yy, zz, xy, yz, xz in (point - vertex)
    / scale (p,)."""

    factors: Floats
    scale: Floats


def fit(nodes: Nodes, where: Sites, stress: Floats) -> Fitted:
    """Fit stresses (m, 4 or 1, 6), at the corners of tetrahedra or constant there, round each site."""
    order = nodes.order
    rule = TET_4 if order == 2 else TET_1
    samples = np.einsum("qk,mkc->mqc", rule, stress) if order == 2 else stress
    places = np.einsum("qk,mkd->mqd", rule, nodes.points[nodes.corners])
    count = len(where.vertex)
    starts, items = incidence(where.corners, count)
    outside = np.zeros(nodes.vertices, bool)
    outside[nodes.faces[:, :3]] = True
    wide = outside[where.vertex]
    factors = np.zeros((count, 4 if order == 1 else 10, 6))
    scale = np.ones(count)
    over_rows(count, lambda r: fit_rows(r[0], r[1], starts, items, where.corners, nodes.points[where.vertex], wide,
                                        _ENOUGH[order], places, samples, factors, scale))  # fmt: skip
    return Fitted(factors, scale)


@compiled
def fit_rows(
    first: int, last: int, starts: Longs, items: Longs, corners: Ints, centres: Floats, wide: NDArray[np.bool_],
    enough: int, places: Floats, samples: Floats, factors: Floats, scale: Floats,
) -> None:  # fmt: skip
    """The polynomials of the sites from `first` to `last`."""
    seen = np.full(len(corners), -1, np.int32)
    patch = np.empty(4096, np.int64)
    most = factors.shape[1]
    width = samples.shape[1]
    row, normal, right = np.empty(most), np.empty((most, most)), np.empty((most, 6))
    for site in range(first, last):
        size = 0
        for s in range(starts[site], starts[site + 1]):
            e = items[s] // 4
            seen[e] = site
            if size < len(patch):
                patch[size] = e
                size += 1
        if wide[site] or size < enough:
            ring = size
            for k in range(ring):
                for c in range(4):
                    other = corners[patch[k], c]
                    for s in range(starts[other], starts[other + 1]):
                        e = items[s] // 4
                        if seen[e] != site and size < len(patch):
                            seen[e] = site
                            patch[size] = e
                            size += 1
        x, y, z = centres[site, 0], centres[site, 1], centres[site, 2]
        far = 0.0
        for k in range(size):
            for q in range(width):
                p = places[patch[k], q]
                far = max(far, (p[0] - x) ** 2 + (p[1] - y) ** 2 + (p[2] - z) ** 2)
        h = np.sqrt(far) if far > 0 else 1.0
        scale[site] = h
        for i in range(most):
            for j in range(most):
                normal[i, j] = 0.0
            for c in range(6):
                right[i, c] = 0.0
        for k in range(size):
            for q in range(width):
                p = places[patch[k], q]
                monomials((p[0] - x) / h, (p[1] - y) / h, (p[2] - z) / h, row)
                for i in range(most):
                    for j in range(i + 1):
                        normal[i, j] += row[i] * row[j]
                    for c in range(6):
                        right[i, c] += row[i] * samples[patch[k], q, c]
        terms = most
        while terms > 1 and not (size * width >= terms and factor(normal, terms)):
            terms = 4 if terms > 4 else 1
            for i in range(most):
                for j in range(i + 1):
                    normal[i, j] = 0.0
            for k in range(size):
                for q in range(width):
                    p = places[patch[k], q]
                    monomials((p[0] - x) / h, (p[1] - y) / h, (p[2] - z) / h, row)
                    for i in range(most):
                        for j in range(i + 1):
                            normal[i, j] += row[i] * row[j]
        if terms == 1:
            factor(normal, 1)
        for c in range(6):
            for i in range(terms):
                value = right[i, c]
                for j in range(i):
                    value -= normal[i, j] * right[j, c]
                right[i, c] = value / normal[i, i]
            for i in range(terms - 1, -1, -1):
                value = right[i, c]
                for j in range(i + 1, terms):
                    value -= normal[j, i] * right[j, c]
                right[i, c] = value / normal[i, i]
                factors[site, i, c] = right[i, c]


@compiled
def monomials(x: float, y: float, z: float, row: Floats) -> None:
    """1, x, y, z, xx, yy, zz, xy, yz, xz, as many as there is room for."""
    row[0], row[1], row[2], row[3] = 1.0, x, y, z
    if len(row) > 4:
        row[4], row[5], row[6], row[7], row[8], row[9] = x * x, y * y, z * z, x * y, y * z, x * z


@compiled
def factor(normal: Floats, terms: int) -> bool:
    """Cholesky's factor of the first rows and columns, in the lower half; False where they depend on each other."""
    for i in range(terms):
        whole = normal[i, i]
        for j in range(i + 1):
            value = normal[i, j]
            for k in range(j):
                value -= normal[i, k] * normal[j, k]
            if i == j:
                if not value > 1e-6 * whole:
                    return False
                normal[i, i] = np.sqrt(value)
            else:
                normal[i, j] = value / normal[j, j]
    return True


@compiled
def misfit(
    first: int, last: int, corners: Ints, centres: Floats, scale: Floats, factors: Floats, vertices: Floats,
    numbers: Ints, stress: Floats, rule: Floats, weights: Floats, young: Floats, poisson: Floats, volumes: Floats,
    out: Floats,
) -> None:  # fmt: skip
    """Twice the energy (m,) N mm of what recovered stresses have beyond those of the tetrahedra from `first` to `last`.

    Within a tetrahedron the polynomials of its corners are blended by the barycentric coordinates.
    """
    row = np.empty(factors.shape[1])
    difference, point = np.empty(6), np.empty(3)
    linear = stress.shape[1] == 4
    for e in range(first, last):
        total = 0.0
        for q in range(len(rule)):
            for d in range(3):
                point[d] = 0.0
                for k in range(4):
                    point[d] += rule[q, k] * vertices[numbers[e, k], d]
            for c in range(6):
                difference[c] = -stress[e, 0, c]
                if linear:
                    difference[c] = 0.0
                    for k in range(4):
                        difference[c] -= rule[q, k] * stress[e, k, c]
            for k in range(4):
                s = corners[e, k]
                h = scale[s]
                monomials(
                    (point[0] - centres[s, 0]) / h, (point[1] - centres[s, 1]) / h, (point[2] - centres[s, 2]) / h, row
                )
                for c in range(6):
                    value = 0.0
                    for i in range(len(row)):
                        value += row[i] * factors[s, i, c]
                    difference[c] += rule[q, k] * value
            squares = 0.0
            for c in range(6):
                squares += difference[c] ** 2 * (1 if c < 3 else 2)
            trace = difference[0] + difference[1] + difference[2]
            total += weights[q] * ((1 + poisson[e]) * squares - poisson[e] * trace**2) / young[e]
        out[e] = total * volumes[e]
