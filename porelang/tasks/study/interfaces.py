"""Where a material changes within elements, which have one each: what that leaves open.

Between the mean of moduli and the inverse mean of their inverses lies what an element is that is made of both (Voigt
1889, Reuss 1929, Hill 1952), however they lie in it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.backends.numpy import NumpyField
from porelang.fea.elements import tet_rule
from porelang.formula import Formula
from porelang.tet.tetmesh import TetMesh

Floats = NDArray[np.float64]
#: The degree of the rule of quadrature whose points in an element are asked.
_DEGREE = 3
_AT_ONCE = 50_000


@dataclass(frozen=True, slots=True)
class Interfaces:
    """Of each element (m,): by which share its moduli may be lower than their mean (`gap`), and how far the largest and
    the least of them are from the middle of both (`spread`), as a share of it."""

    gap: Floats
    spread: Floats


def interfaces(mesh: TetMesh, young: Formula, poisson: Formula) -> Interfaces:
    """How much the material changes within elements. Where it is none at some point, that is left out: the material of
    an element is the one in its middle."""
    count = len(mesh.tets)
    if not young.root.axes and not poisson.root.axes:
        return Interfaces(np.zeros(count), np.zeros(count))
    points, weights = tet_rule(_DEGREE)
    gap, spread = np.zeros(count), np.zeros(count)
    for first in range(0, count, _AT_ONCE):
        part = slice(first, first + _AT_ONCE)
        at = np.einsum("qk,mkd->mqd", points, mesh.vertices[mesh.tets[part]])
        e, nu = (_asked(field, at) for field in (young, poisson))
        there = (e > 0) & np.isfinite(e) & (nu > -1) & (nu < 0.5)
        weight = np.where(there, weights, 0.0)
        weight /= np.maximum(weight.sum(axis=1), 1e-300)[:, None]
        with np.errstate(all="ignore"):
            moduli = (e / (1 + nu), e / (1 - 2 * nu))  # twice the shear modulus, three times that of compression
        for modulus in moduli:
            known = np.where(there, modulus, 1.0)
            mean, inverse = (weight * known).sum(axis=1), (weight / known).sum(axis=1)
            gap[part] = np.maximum(gap[part], 1 - 1 / np.maximum(mean * inverse, 1.0))
            most = np.where(there, modulus, -np.inf).max(axis=1)
            least = np.where(there, modulus, np.inf).min(axis=1)
            some = there.any(axis=1)
            apart = (most[some] - least[some]) / (most[some] + least[some])
            spread[part][some] = np.maximum(spread[part][some], apart)
    return Interfaces(gap, spread)


def _asked(field: Formula, at: Floats) -> Floats:
    """A field at points (m, q, 3), (m, q)."""
    if not field.root.axes:
        return np.full(at.shape[:2], float(field.numbers[0]))
    with np.errstate(all="ignore"):
        return np.asarray(NumpyField(field, "f64").at(at.reshape(-1, 3)), np.float64).reshape(at.shape[:2])
