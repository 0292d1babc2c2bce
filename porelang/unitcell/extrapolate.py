"""From several resolutions to none: the limit of vanishing voxels, and how far it may be from the truth.

A quantity on voxels of the size h goes as q + c h^p (W. L. Oberkampf and C. J. Roy, Verification and Validation in
Scientific Computing, 2010, ch. 8). Full elements on smooth walls have p = 2, and so have cells that were solved on up
to 128 voxels; thin walls and cut voxels make it less, and uneven: an order that is fitted to four grids wanders, and
put the limit of a network off by more than its error. So the limit is that of order 2 through the two finest grids,
and the error the most of what order 1 would give, and of what coarser pairs give.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
#: The order that is taken, and the one that it may be.
ORDER, LEAST = 2.0, 1.0


@dataclass(frozen=True, slots=True)
class Limit:
    """What values tend to, its error (the truth is expected within `value +- error`), and the order that was taken."""

    value: Floats
    error: Floats
    order: float


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
        return Limit(q[0], np.full(q[0].shape, np.inf), ORDER)
    found = _through(h[-1], h[-2], q[-1], q[-2], ORDER)
    others = [_through(h[-1], h[-2], q[-1], q[-2], LEAST)]
    if len(h) > 2:
        others += [_through(h[a], h[-3], q[a], q[-3], ORDER) for a in (-1, -2)]
    return Limit(found, np.max([np.abs(other - found) for other in others], axis=0), ORDER)


def _through(fine: float, coarse: float, at_fine: Floats, at_coarse: Floats, order: float) -> Floats:
    """What two values of an order tend to (L. F. Richardson, Phil. Trans. R. Soc. A 210, 1911)."""
    return np.asarray(at_fine + (at_fine - at_coarse) / ((coarse / fine) ** order - 1))
