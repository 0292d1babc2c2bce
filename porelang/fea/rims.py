"""The faces of a part, which end at its sharp rims, and what of a selection only reaches over one.

`z > 149mm` is said of the end of a part at z = 150 mm: it holds that face whole, and of the walls beside it a strip.
"""

from __future__ import annotations

import numpy as np

from porelang.fea.assemble import Longs
from porelang.fea.nodes import Nodes
from porelang.fea.problem import Floats, Mask

#: The cosine of the angle by which a surface turns at a rim that is sharp.
_SHARP = 0.7
#: A face of which more is held is held whole; of one that is not meant less is.
_WHOLE, _SLIGHT = 1 - 1e-5, 0.05


def faces_of(nodes: Nodes, normals: Floats) -> Longs:
    """The face (f,) of the part that each triangle of the boundary, with its outward normal (f, 3), belongs to."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    triangles = nodes.faces[:, :3].astype(np.int64)
    ends = np.sort(triangles[:, [[0, 1], [1, 2], [0, 2]]].reshape(-1, 2), axis=1)
    keys = ends[:, 0] * nodes.vertices + ends[:, 1]
    order = np.argsort(keys, kind="stable")
    same = np.flatnonzero(keys[order][1:] == keys[order][:-1])
    a, b = order[same] // 3, order[same + 1] // 3
    smooth = np.einsum("nd,nd->n", normals[a], normals[b]) > _SHARP
    graph = coo_matrix((np.ones(smooth.sum(), np.int8), (a[smooth], b[smooth])), shape=(len(triangles),) * 2)
    return np.asarray(connected_components(graph, directed=False)[1], np.int64)


def over_rims(nodes: Nodes, normals: Floats, areas: Floats, held: Floats) -> Mask:
    """Which triangles (f,) of the boundary are held, of their `areas` as much as `held` (f,) mm2, for what holds a face
    whole reaches over its rim: by less than a twentieth of the face beyond."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    none = np.zeros(len(areas), bool)
    if not ((held > 0) & (held < areas * _WHOLE)).any():
        return none
    face = faces_of(nodes, normals)
    of_face = np.bincount(face, areas)
    whole = (np.bincount(face, held) > _WHOLE * of_face)[face]
    some = np.flatnonzero((held > 0) & ~whole)
    if not whole.any() or not len(some):
        return none
    # pieces that hang together on one face: triangles, joined over the corners that they share on it
    corners = nodes.faces[some, :3]
    keys = face[some, None] * nodes.vertices + corners
    numbers, place = np.unique(keys, return_inverse=True)
    rows = np.repeat(np.arange(len(some)), 3)
    size = len(some) + len(numbers)
    graph = coo_matrix((np.ones(len(rows), np.int8), (rows, len(some) + place.ravel())), shape=(size, size))
    piece = connected_components(graph, directed=False)[1][: len(some)]
    slight = np.bincount(piece, held[some])[piece] < _SLIGHT * of_face[face[some]]
    touches = np.bincount(piece, np.isin(corners, nodes.faces[whole, :3]).any(axis=1))[piece] > 0
    none[some] = slight & touches
    return none
