"""Means over the volume: of the length of a displacement, and of its share in a motion."""

from __future__ import annotations

import numpy as np

from porelang.fea.elements import shape_values, tet_rule
from porelang.fea.nodes import EDGES, Nodes
from porelang.fea.problem import Floats

#: Degrees of two rules of quadrature: what they differ by is what the first may be off.
_DEGREES = 5, 3
_AT_ONCE = 20_000


def mean_length(nodes: Nodes, displacement: Floats) -> tuple[float, float]:
    """The mean over the volume of the length of a displacement (k, 3) of all nodes, and by how much it may be off.

    Between nodes it is that of the elements, so the mean is not that of its lengths at nodes. Length has a kink where
    nothing moves, which a rule of quadrature sees only as a finer one differs from it.
    """
    edges = EDGES if nodes.order == 2 else None
    found = []
    for degree in _DEGREES:
        points, weights = tet_rule(degree)
        shapes = shape_values(points, edges)
        total = 0.0
        for first in range(0, len(nodes.elements), _AT_ONCE):
            part = slice(first, first + _AT_ONCE)
            moved = np.einsum("qw,mwd->mqd", shapes, displacement[nodes.elements[part]], optimize=True)
            total += float(np.linalg.norm(moved, axis=2) @ weights @ nodes.volumes[part])
        found.append(total / float(nodes.volumes.sum()))
    return found[0], abs(found[0] - found[1])


def weighed(nodes: Nodes, fields: Floats) -> Floats:
    """What nodes (k, 3) count in the integral of a displacement times each of some fields (r, k, 3), over the volume:
    of a mean of nodes, which lie closer where elements are small, that would be another."""
    points, weights = tet_rule(2 * nodes.order)
    shapes = shape_values(points, EDGES if nodes.order == 2 else None)
    mass = np.einsum("q,qv,qw->vw", weights, shapes, shapes)
    found = np.empty_like(fields)
    for r, field in enumerate(fields):
        at = np.einsum("vw,mwd->mvd", mass, field[nodes.elements]) * nodes.volumes[:, None, None]
        for d in range(3):
            found[r, :, d] = np.bincount(nodes.elements.ravel(), at[..., d].ravel(), len(field))
    return found
