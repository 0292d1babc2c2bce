"""From several resolutions to none: the limit of vanishing voxels, and how far it may be from the truth.

A quantity on voxels of the size h goes as q + c h^p. Full elements on smooth walls have p = 2; cut voxels, and walls of
a few voxels, pull it below (W. L. Oberkampf and C. J. Roy, Verification and Validation in Scientific Computing, 2010,
ch. 8). With so few grids the order cannot be told from the numbers alone, so it is looked for between 1 and 2, and
the error is what either of these would give.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
#: Between which orders the one is looked for, and in what steps.
ORDERS = np.linspace(1.0, 2.0, 21)


@dataclass(frozen=True, slots=True)
class Limit:
    """What values tend to, its error (the truth is expected within `value +- error`), and the order that was found."""

    value: Floats
    error: Floats
    order: float


def limit(sizes: Floats, values: Floats) -> Limit:
    """The limit of values (k, ...) on voxels of the sizes (k,), all of one order.

    With one resolution nothing is known of the error: it is infinite. With two the order is 1.5.

    >>> h = np.array([1 / 24, 1 / 32, 1 / 48, 1 / 64])
    >>> found = limit(h, 2 + 3 * h**1.5)
    >>> round(float(found.value), 6), round(found.order, 2)
    (2.0, 1.5)
    """
    by_size = np.argsort(-np.asarray(sizes))
    h, q = np.asarray(sizes)[by_size], np.asarray(values)[by_size]
    flat = q.reshape(len(h), -1)
    if len(h) == 1:
        return Limit(q[0], np.full(q[0].shape, np.inf), np.nan)
    if len(h) == 2:
        order, kept = 1.5, slice(None)
    else:
        kept = slice(-4, None)
        order = float(min(ORDERS, key=lambda p: float((_fit(h[kept], flat[kept], p)[1] ** 2).sum())))
    found, rest = _fit(h[kept], flat[kept], order)
    others = [_fit(h[-2:], flat[-2:], p)[0] for p in (1.0, 2.0)]
    far = np.max([np.abs(other - found) for other in others], axis=0)
    error = np.maximum(far, 2 * np.abs(rest).max(axis=0))
    return Limit(found.reshape(q.shape[1:]), error.reshape(q.shape[1:]), order)


def _fit(h: Floats, q: Floats, order: float) -> tuple[Floats, Floats]:
    """The limit of values (k, n) by least squares, the finer the heavier, and what is left (k, n)."""
    weights = (h.min() / h)[:, None]
    base = np.stack([np.ones_like(h), (h / h.max()) ** order], axis=1)
    found, *_ = np.linalg.lstsq(base * weights, q * weights, rcond=None)
    return found[0], q - base @ found
