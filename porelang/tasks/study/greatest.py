"""The greatest displacement of a part: read on its own surface, next to the nodes of its elements that move the most.

Corners of elements stand out of a round wall so that the volume is that of the part, and what turns with it moves more
there than the part does.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from porelang.fea.elements import shape_values
from porelang.fea.nodes import EDGES, Nodes

Floats = NDArray[np.float64]
#: Nodes that move by more than this share of the most, and so many of them, are looked at.
_AMONG, _SOME = 0.98, 1000


def greatest(nodes: Nodes, displacement: Floats, nearest: Callable[[Floats], Floats]) -> tuple[float, float]:
    """The greatest length (mm) of a displacement (k, 3) of nodes, at the places on a part's surface that are `nearest`
    to them; and by how much those of the nodes differ."""
    lengths = np.linalg.norm(displacement, axis=1)
    outside = np.unique(nodes.faces)
    most = float(lengths.max())
    some = outside[lengths[outside] > _AMONG * most]
    some = some[np.argsort(-lengths[some], kind="stable")[:_SOME]]
    if not len(some):
        return most, 0.0
    points = nodes.points[some]
    at = nearest(points)
    moves = (at != points).any(axis=1)
    found = lengths[some]
    found[moves] = np.linalg.norm(_continued(nodes, displacement, some[moves], at[moves]), axis=1)
    value = max(float(found.max()), float(np.delete(lengths, outside).max(initial=0.0)))
    return value, abs(most - value)


def _continued(nodes: Nodes, displacement: Floats, some: NDArray[np.int32], at: Floats) -> Floats:
    """The displacement (n, 3) at places (n, 3) next to some nodes (n,), as an element of each goes on."""
    rows, columns = np.nonzero(np.isin(nodes.elements, some))
    first = np.full(len(nodes.points), -1, np.int64)
    first[nodes.elements[rows, columns]] = rows
    elements = first[some]
    corners = nodes.points[nodes.corners[elements]]
    inside = np.einsum("nkd,nd->nk", nodes.gradients[elements], at - corners.mean(axis=1)) + 0.25
    shapes = shape_values(inside, None if nodes.order == 1 else EDGES)
    return np.asarray(np.einsum("nw,nwd->nd", shapes, displacement[nodes.elements[elements]]))
