"""What cells are to stand along: directions (3, ...) of length 1, or the first two axes (6, ...) of frames, one of them
above the other. A cell may stand along the opposite of each as well: neighbours have to agree, or it would be torn.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

Values = NDArray[np.float64]
#: The cosine of two that are nearly opposite: of directions by 45 degrees, of frames, whose quaternions are, by 90.
ALIKE = 0.7
#: Pairs of neighbours that cannot be made to agree, by the cells to the power of 2/3: a wall through a part is more.
SEAM = 0.05


def has_all(directions: Values) -> NDArray[np.bool_]:
    """Where directions have a length: they are 0 where there is none."""
    sizes = (directions.reshape(-1, 3, *directions.shape[1:]) ** 2).sum(1)
    return np.asarray((sizes > 0).all(0))


def everywhere(directions: Values) -> Values:
    """Directions, and where there are none x, or one at right angles to the first."""
    x = np.array([1.0, 0, 0]).reshape(3, *(1,) * (directions.ndim - 1))
    known = (directions[:3] ** 2).sum(0) > 0
    first = np.where(known, directions[:3], x)
    if len(directions) == 3:
        return first
    known &= (directions[3:] ** 2).sum(0) > 0
    return np.concatenate([first, np.where(known, directions[3:], beside(first))])


def extended(directions: Values, within: NDArray[np.bool_], spacing: Sequence[float]) -> Values:
    """Directions in the cells of a grid; beyond the part, and where there are none, those of the nearest cell that has
    some: what a field is there, as in a hole, nobody has asked for."""
    known = within & has_all(directions)
    if known.all() or not known.any():
        return everywhere(directions)
    nearest_one = distance_transform_edt(~known, sampling=spacing, return_distances=False, return_indices=True)
    return np.asarray(directions[(slice(None), *nearest_one)])


def beside(directions: Values) -> Values:
    """A direction at right angles to each of some (3, ...)."""
    x, y = (np.array(e).reshape(3, *(1,) * (directions.ndim - 1)) for e in ([1.0, 0, 0], [0, 1.0, 0]))
    across = np.cross(directions, np.where(np.abs(directions[0]) < 0.6, x, y), axis=0)
    return np.asarray(across / np.sqrt((across**2).sum(0)))


def axes_of(directions: Values) -> Values:
    """Right-handed axes (3, 3, ...) of frames; of directions alone one is as near as can be to the axis of the part
    that is least along them: the third to z, as with `align`, or the second to x or y."""
    first = directions[:3]
    if len(directions) == 6:
        return np.stack([first, directions[3:], np.cross(first, directions[3:], axis=0)])
    least = int(np.argmin((first.reshape(3, -1) ** 2).mean(axis=1)))
    other = np.eye(3)[least].reshape(3, *(1,) * (first.ndim - 1)) - first[least] * first
    size = np.sqrt((other**2).sum(0))
    other = np.where(size > 1e-3, other / np.maximum(size, 1e-3), beside(first))
    last = np.cross(first, other, axis=0)
    return np.stack([first, -last, other] if least == 2 else [first, other, last])


def nearest(matrices: Values, frames: Values) -> Values:
    """Of the four right-handed frames with the axes of one, or their opposites, those nearest to matrices."""
    axes = axes_of(frames)
    one, two, three = (matrices * axes).sum(1)
    signs = [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]
    best = np.argmax(np.stack([a * one + b * two + c * three for a, b, c in signs]), axis=0)
    return np.asarray(np.moveaxis(np.array(signs, np.float64)[best], -1, 0)[:, None] * axes)


def combed(directions: Values, within: NDArray[np.bool_]) -> Values:
    """Directions in the cells of a grid, or their opposites, so that neighbours agree, first those that lie `within`
    and are nearly parallel; as they are given where these agree."""
    return np.concatenate([_combed(directions[k : k + 3], within)[0] for k in range(0, len(directions), 3)])


def turn_round(directions: Values, within: NDArray[np.bool_]) -> float:
    """By how much of a turn combed directions turn round a line, or a hole: 0, 0.5 or 1. No phase can follow that.

    They cannot be combed after half a turn; after a whole one their frames can, but not the quaternions of these, as a
    frame turns into itself by twice as much as a quaternion into its opposite.
    """
    from scipy.spatial.transform import Rotation

    many = SEAM * np.count_nonzero(within) ** (2 / 3)
    if any(_torn(directions[k : k + 3], within) > many for k in range(0, len(directions), 3)):
        return 0.5
    axes = axes_of(directions)
    turns = Rotation.from_matrix(axes.reshape(3, 3, -1).transpose(2, 0, 1)).as_quat()
    return float(_combed(turns.T.reshape(4, *within.shape), within)[1] > many)


def _combed(v: Values, within: NDArray[np.bool_]) -> tuple[Values, int]:
    """Vectors (k, cells) or their opposites, so that neighbours agree, and how many pairs `within` cannot."""
    number = np.arange(within.size).reshape(within.shape)
    one, other, apart = [], [], []
    agreed = True
    for axis in range(3):
        low, high = ((slice(None),) * axis + (end,) for end in (slice(None, -1), slice(1, None)))
        dots = (v[(slice(None), *low)] * v[(slice(None), *high)]).sum(0)
        both = within[low] & within[high]
        agreed &= bool((dots[both] >= 0).all())
        one.append(number[low].reshape(-1))
        other.append(number[high].reshape(-1))
        apart.append((1.001 - np.abs(dots) + 2.0 * ~both).reshape(-1))
    if agreed:
        return v, 0
    pairs = np.concatenate(one), np.concatenate(other)
    graph = coo_matrix((np.concatenate(apart), pairs), (within.size, within.size))
    first = int(np.argmax(within.reshape(-1)))
    order, before = breadth_first_order(minimum_spanning_tree(graph), first, directed=False)
    flat, sign = v.reshape(len(v), -1), np.ones(within.size)
    same = np.where((flat[:, order[1:]] * flat[:, before[order[1:]]]).sum(0) < 0, -1.0, 1.0)
    for cell, by in zip(order[1:].tolist(), same.tolist(), strict=True):
        sign[cell] = sign[before[cell]] * by
    if sign[within.reshape(-1)].sum() < 0:
        sign = -sign
    found = v * sign.reshape(within.shape)
    return found, _torn(found, within)


def _torn(v: Values, within: NDArray[np.bool_]) -> int:
    """How many pairs of neighbours `within` are nearly opposite."""
    torn = 0
    for axis in range(3):
        low, high = ((slice(None),) * axis + (end,) for end in (slice(None, -1), slice(1, None)))
        dots = (v[(slice(None), *low)] * v[(slice(None), *high)]).sum(0)
        torn += int(np.count_nonzero((dots < -ALIKE) & within[low] & within[high]))
    return torn
