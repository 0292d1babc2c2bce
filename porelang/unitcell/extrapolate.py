"""From several resolutions to none: the limit of vanishing voxels, and how far it may be from the truth.

A quantity on voxels of the size h goes as q + c h^p (W. L. Oberkampf and C. J. Roy, Verification and Validation in
Scientific Computing, 2010, ch. 8). Where walls are smooth p is 2. Along an edge that leads into the solid, as where two
struts meet, the stress is singular, and p is twice the exponent of that: from 1 for a crack, by 1.09 for a right angle,
up to 2 (M. L. Williams, J. Appl. Mech. 19, 1952; G. Strang and G. Fix, An Analysis of the Finite Element Method, 1973,
ch. 8). How voxels lie in walls makes each grid stray by some hundredths of what the grids differ by, so that four of
them do not tell p alone, and tell it a little.

So every p of a range is fitted, by least squares in which finer grids count more (L. Eca and M. Hoekstra, J. Comput.
Phys. 262, 2014), and has the weight of how well it fits. The limit is the mean of theirs. Its error is two deviations
of that mean: what the limits differ by, and what each is uncertain by.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
#: The orders that are fitted: of smooth walls, and of walls with edges that lead into the solid.
SMOOTH, CREASED = (1.5, 1.75, 2.0, 2.25, 2.5), (1.0, 1.25, 1.5, 1.75, 2.0)
#: What a grid strays by at least, as a share of the most that one differs from the finest, and where walls lie with the
#: voxels, so that all of a wall is cut alike; and the deviations of an error: what 17 lattices of 24 to 64 voxels ask
#: for (docs/decisions/0018).
STRAYS, ALIGNED, _DEVIATIONS = 0.04, 0.4, 2.0
#: Modes of a stiffness below this share of the stiffest are none, and so are those below this, of a solid of 1.
_NO_MODE, _NOTHING = 1e-9, 1e-10
#: A mode that the limit makes less than this share of what the finest grid has is extrapolated by its logarithm.
_FAR = 0.5


@dataclass(frozen=True, slots=True)
class Limit:
    """What values tend to, and its error: the truth is expected within `value +- error`."""

    value: Floats
    error: Floats


def limit(sizes: Floats, values: Floats, orders: tuple[float, ...] = SMOOTH, strays: float = STRAYS) -> Limit:
    """The limit of values (k, ...) on voxels of the sizes (k,), which goes with one of the `orders`,
    each of which may stray by a share of what they differ by.

    With one resolution nothing is known of the error: it is infinite. With two it is what the lowest order would give.

    >>> h = np.array([1 / 24, 1 / 32, 1 / 48, 1 / 64])
    >>> found = limit(h, 2 + 3 * h**2)
    >>> abs(float(found.value) - 2) < float(found.error) < 0.001
    True
    """
    by_size = np.argsort(-np.asarray(sizes))
    h, q = np.asarray(sizes, np.float64)[by_size], np.asarray(values, np.float64)[by_size]
    if len(h) == 1:
        return Limit(q[0], np.full(q[0].shape, np.inf))
    h, shape, q = h / h[-1], q.shape[1:], q.reshape(len(h), -1)
    many = len(h) - 2
    weight = 1 / h
    weight *= len(h) / weight.sum()
    least_missed = (strays * np.abs(q - q[-1]).max(axis=0)) ** 2
    limits, missed, known = [], [], []
    for p in orders:
        basis = np.stack([np.ones(len(h)), h**p], axis=1)
        inverse = np.linalg.inv(basis.T @ (weight[:, None] * basis))
        fitted = inverse @ basis.T @ (weight[:, None] * q)
        limits.append(fitted[0])
        missed.append(least_missed + (weight @ (q - basis @ fitted) ** 2 / max(many, 1)) * (many > 0))
        known.append(float(inverse[0, 0]))
    tend, variance = np.array(limits), np.array(missed)
    least = np.maximum(variance.min(axis=0), np.finfo(float).tiny)
    share = (np.maximum(variance, least) / least) ** (-len(h) / 2)
    share /= share.sum(axis=0)
    found = (share * tend).sum(axis=0)
    spread = (share * ((tend - found) ** 2 + np.array(known)[:, None] * variance)).sum(axis=0)
    error = _DEVIATIONS * np.sqrt(spread)
    if not many:
        error = np.maximum(error, np.abs(tend - found).max(axis=0))
    return Limit(found.reshape(shape), error.reshape(shape))


def definite_limit(
    sizes: Floats, values: Floats, orders: tuple[float, ...] = SMOOTH, strays: float = STRAYS
) -> Limit:  # fmt: skip
    """The limit of symmetric matrices (k, n, n), each of which resists in every mode or not at all, with one that does
    not reward a deformation either.

    Entries that are extrapolated one by one may make such a matrix: of struts of a voxel, whose shear on the finest
    grids goes as 10 to 5. In the modes in which the last two grids differ from each other the limit is that of `limit`;
    but where it is less than half of what the finest grid has it is the limit of the logarithm, and positive. Modes
    that the finest grid has not are none.

    >>> h = np.array([1 / 3, 1 / 4])
    >>> found = definite_limit(h, np.array([np.diag([1.0, 9e-3, 0]), np.diag([1.0, 4e-3, 0])]))
    >>> bool(0 < found.value[1, 1] < 2e-3), float(limit(h, np.array([9e-3, 4e-3])).value) < 0
    (True, True)
    """
    plain = limit(sizes, values, orders, strays)
    if len(sizes) < 2:
        return plain
    by_size = np.argsort(-np.asarray(sizes))
    fine, coarse = values[by_size[-1]], values[by_size[-2]]
    size, modes = np.linalg.eigh(fine)
    kept = size > max(_NO_MODE * float(size.max()), _NOTHING)
    if not kept.any():
        return Limit(np.zeros_like(fine), np.maximum(plain.error, np.abs(plain.value)))
    narrow = modes[:, kept] / np.sqrt(size[kept])
    _, turned = np.linalg.eigh(narrow.T @ coarse @ narrow)
    into, basis = narrow @ turned, (modes[:, kept] * np.sqrt(size[kept])) @ turned
    # each mode on each grid, that of the finest being 1
    series = np.array([np.einsum("ai,ab,bi->i", into, at, into) for at in values])
    straight = limit(sizes, series, orders, strays).value
    by_log = np.exp(limit(sizes, np.log(np.maximum(series, _NO_MODE)), orders, strays).value)
    share = np.where(straight >= _FAR, straight, np.minimum(by_log, 1.0))
    found = (basis * share) @ basis.T
    return Limit(found, np.maximum(plain.error, np.abs(found - plain.value)))
