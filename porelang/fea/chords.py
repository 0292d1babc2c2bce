"""How well elements have the area of a piece of their surface: its rim goes in chords, and the part's does not."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.fea.nodes import Nodes
from porelang.fea.problem import Floats

#: A rim that turns by more than this at a node, in radians, has a corner there, which elements have too.
_CORNER = 0.8
#: Segments of a rim lie in or out by chance, as the mesher makes up for what all of them have alike: so many times the
#: root of the sum of their squares is nearly always enough (measured: in 40 of 42 ends of lattices in cubes that are
#: at most half of their walls; 3 times in 38).
_SIGMAS = 4.0


def area_off(nodes: Nodes, faces: NDArray[np.intp]) -> float:
    """By how much the area (mm2) of some faces may be another than that of the part.

    A curve of which a chord of length l turns by an angle t to the next lies t l / 8 beyond its middle, which makes
    2/3 of that times l in area.
    """
    corners = nodes.faces[faces, :3]
    sides = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    owner = np.tile(np.arange(len(faces)), 3)
    pairs = np.sort(sides, axis=1)
    _, first, count = np.unique(pairs[:, 0] * np.int64(len(nodes.points)) + pairs[:, 1], return_index=True,
                                return_counts=True)  # fmt: skip
    rim = first[count == 1]
    start, end, owner = sides[rim, 0], sides[rim, 1], owner[rim]
    follows = np.full(len(nodes.points), -1)
    follows[start] = np.arange(len(rim))
    once = np.bincount(start, minlength=len(nodes.points)) == 1
    here = np.flatnonzero(once[end] & (follows[end] >= 0))
    there = follows[end[here]]
    along = nodes.points[end] - nodes.points[start]
    length = np.linalg.norm(along, axis=1)
    a, b = along[here] / length[here, None], along[there] / length[there, None]
    normal = np.cross(*(nodes.points[corners[owner[here], k]] - nodes.points[corners[owner[here], 0]] for k in (1, 2)))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    turn = np.arctan2((np.cross(a, b) * normal).sum(axis=1), (a * b).sum(axis=1))
    turn = np.where(np.abs(turn) < _CORNER, turn, 0.0)
    pieces: Floats = 2 / 3 * turn / 8 * ((length[here] + length[there]) / 2) ** 2
    return float(_SIGMAS * np.sqrt((pieces**2).sum()))
