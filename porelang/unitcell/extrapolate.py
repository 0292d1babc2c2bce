"""From several resolutions to none: the limit of vanishing voxels, and how far it may be from the truth.

A quantity on voxels of the size h goes as q + c h^p (W. L. Oberkampf and C. J. Roy, Verification and Validation in
Scientific Computing, 2010, ch. 8). Full elements on smooth walls have p = 2, and so have cells that were solved on up
to 128 voxels; thin walls and cut voxels make it less, and uneven: an order that is fitted to four grids wanders, and
put the limit of a network off by more than its error. So the limit is that of order 2 through the two finest grids.

The error is the most of three: what order 1 would give instead; what coarser pairs give; and how far each single grid
is from the limit, less by order 1. The last is for struts that lie with the voxels: what two grids find may cross
there by chance, so that nothing seems to change from one to the next, but all four do not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
#: The order that is taken, and the one that it may be.
ORDER, LEAST = 2.0, 1.0
#: Modes of a stiffness below this share of the stiffest are none, and so are those below this, of a solid of 1.
_NO_MODE, _NOTHING = 1e-9, 1e-10
#: A mode that the limit makes less than this share of what the finest grid has is extrapolated by its logarithm.
_FAR = 0.5


@dataclass(frozen=True, slots=True)
class Limit:
    """What values tend to, and its error: the truth is expected within `value +- error`."""

    value: Floats
    error: Floats


def limit(sizes: Floats, values: Floats) -> Limit:
    """The limit of values (k, ...) on voxels of the sizes (k,).

    With one resolution nothing is known of the error: it is infinite.

    >>> h = np.array([1 / 24, 1 / 32, 1 / 48, 1 / 64])
    >>> found = limit(h, 2 + 3 * h**2)
    >>> round(float(found.value), 9), 0 < float(found.error) < 0.003
    (2.0, True)
    """
    by_size = np.argsort(-np.asarray(sizes))
    h, q = np.asarray(sizes)[by_size], np.asarray(values)[by_size]
    if len(h) == 1:
        return Limit(q[0], np.full(q[0].shape, np.inf))
    found = _through(h[-1], h[-2], q[-1], q[-2], ORDER)
    others = [_through(h[-1], h[-2], q[-1], q[-2], LEAST) - found]
    if len(h) > 2:
        others += [_through(h[a], h[-3], q[a], q[-3], ORDER) - found for a in (-1, -2)]
    others += [(at - found) * (h[-1] / size) ** LEAST for size, at in zip(h, q, strict=True)]
    return Limit(found, np.max(np.abs(others), axis=0))


def definite_limit(sizes: Floats, values: Floats) -> Limit:
    """The limit of symmetric matrices (k, n, n), each of which resists in every mode or not at all, with one that does
    not reward a deformation either.

    Entries that are extrapolated one by one may make such a matrix: of struts of a voxel, whose shear on the finest
    grids goes as 10 to 5. In the modes in which the last two grids differ from each other the limit is that of `limit`,
    which entries give as well; but where it is less than half of what the finest grid has it is the limit of the
    logarithm, and positive. Modes that the finest grid has not are none.

    >>> h = np.array([1 / 3, 1 / 4])
    >>> found = definite_limit(h, np.array([np.diag([1.0, 9e-3, 0]), np.diag([1.0, 4e-3, 0])]))
    >>> found.value.diagonal().round(5).tolist(), float(limit(h, np.array([9e-3, 4e-3])).value) < 0
    ([1.0, 0.00141, 0.0], True)
    """
    plain = limit(sizes, values)
    if len(sizes) < 2:
        return plain
    by_size = np.argsort(-np.asarray(sizes))
    h, fine, coarse = np.asarray(sizes)[by_size], values[by_size[-1]], values[by_size[-2]]
    size, modes = np.linalg.eigh(fine)
    kept = size > max(_NO_MODE * float(size.max()), _NOTHING)
    if not kept.any():
        return Limit(np.zeros_like(fine), np.maximum(plain.error, np.abs(plain.value)))
    narrow = modes[:, kept] / np.sqrt(size[kept])
    ratio, turned = np.linalg.eigh(narrow.T @ coarse @ narrow)
    ahead = 1 / ((h[-2] / h[-1]) ** ORDER - 1)
    straight = 1 - ahead * (ratio - 1)
    with np.errstate(divide="ignore"):
        share = np.where(straight >= _FAR, straight, np.maximum(ratio, 1.0) ** -ahead)
    basis = (modes[:, kept] * np.sqrt(size[kept])) @ turned
    found = (basis * share) @ basis.T
    return Limit(found, np.maximum(plain.error, np.abs(found - plain.value)))


def _through(fine: float, coarse: float, at_fine: Floats, at_coarse: Floats, order: float) -> Floats:
    """What two values of an order tend to (L. F. Richardson, Phil. Trans. R. Soc. A 210, 1911)."""
    return np.asarray(at_fine + (at_fine - at_coarse) / ((coarse / fine) ** order - 1))
