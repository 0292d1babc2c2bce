"""The surface in one block of samples, by marching cubes.

Every vertex has the integer key of the grid edge it lies on, and its place is computed from the samples on the line of
that edge alone, so neighbouring blocks agree on it to the last bit. The loops are in `march`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.cells import table
from porelang.mesh.grid import Index
from porelang.mesh.kinks import Around, At, mend
from porelang.mesh.layers import Layers
from porelang.mesh.march import Cases, Frame, march


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """The triangles of a block: `vertices` (n, 3) mm and `faces` (m, 3) into them.

    `border` (b,) are the vertices that neighbouring blocks may share, and `keys` (b,) their keys: four times the number
    of a node plus the axis of the edge that starts there. No later block has a key below `first`.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]
    border: NDArray[np.int32]
    keys: NDArray[np.int64]
    first: int


def contour(around: Around, layers: Layers, shape: Index, field: At | None = None) -> Patch:
    """The surface where the field passes zero in a block of layers of a `shape`; negative is solid.

    Where the `field` itself is given, crossings that the samples misplace are put where it is 0 (`kinks`).
    """
    lo = around.lo
    x, y, z = (slice(a - s, a - s + n) for a, s, n in zip(lo, around.begin, shape, strict=True))
    values = np.ascontiguousarray(around.values[x, y, z])
    seats, least = np.zeros((2, 3, max(values.shape))), np.zeros((3, max(values.shape)))
    for n, (axis, start, count) in enumerate(zip(layers.axes, lo, values.shape, strict=True)):
        seats[0, n, :count] = axis.at[start : start + count]
        seats[1, n, :count] = axis.rim[start : start + count]
        least[n, : count - 1] = np.minimum(layers.hair / np.diff(seats[0, n, :count]), 0.25)
    box = np.array([[axis.lo for axis in layers.axes], [axis.hi for axis in layers.axes]])
    frame = Frame(seats, least, box, lo, layers.shape)
    vertices, faces, border, keys, edges = march(values, frame, _cases(), around.frame)
    if field is not None:
        mend(vertices, faces, edges, around, layers, least, field)
    return Patch(vertices, faces, border, keys, 4 * lo[0] * layers.shape[1] * layers.shape[2])


@cache
def _cases() -> Cases:
    t = table()
    return Cases(t.row, t.ambiguous, t.start, t.count, t.edges, t.centred)
