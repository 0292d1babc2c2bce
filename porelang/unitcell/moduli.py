"""What engineers read off a stiffness: moduli by direction, isotropic averages, bounds, and how cubic it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
#: Directions by the names of their Miller indices.
NAMED = {"100": (1, 0, 0), "010": (0, 1, 0), "001": (0, 0, 1), "110": (1, 1, 0), "111": (1, 1, 1)}
#: A stiffness further than this from a cubic one (relative) has no ratio of Zener's.
CUBIC = 0.01
#: A modulus below this (of the solid's) is none: what is left of a cell that hangs by nothing.
NOTHING = 1e-9


@dataclass(frozen=True, slots=True)
class Averages:
    """Isotropic averages of a stiffness: of equal strain (Voigt, from above), of equal stress (Reuss, from below)."""

    bulk_voigt: float
    bulk_reuss: float
    shear_voigt: float
    shear_reuss: float

    @property
    def bulk(self) -> float:
        """The mean of both (R. Hill, The elastic behaviour of a crystalline aggregate, Proc. Phys. Soc. A 65, 1952)."""
        return (self.bulk_voigt + self.bulk_reuss) / 2

    @property
    def shear(self) -> float:
        return (self.shear_voigt + self.shear_reuss) / 2

    @property
    def anisotropy(self) -> float:
        """The universal index, 0 where isotropic (S. I. Ranganathan and M. Ostoja-Starzewski, PRL 101, 2008)."""
        if min(self.bulk_reuss, self.shear_reuss) <= NOTHING:
            return np.inf
        return 5 * self.shear_voigt / self.shear_reuss + self.bulk_voigt / self.bulk_reuss - 6


def compliance(stiffness: Any) -> Floats:
    """The inverse (6, 6) of a stiffness. Where a mode has no stiffness its compliance is 1 / NOTHING^2: moduli that it
    takes part in come out as none."""
    found = np.linalg.inv(np.asarray(stiffness, np.float64) + NOTHING**2 * np.eye(6))
    return np.asarray((found + found.T) / 2, np.float64)


def young(stiffness: Any, directions: Any) -> Floats:
    """Young's modulus (n,) along directions (n, 3), of any length.

    >>> from porelang.unitcell.hexahedron import isotropic
    >>> young(isotropic(0.2), [[1, 2, 3]]).round(12).tolist()
    [1.0]
    """
    n = np.atleast_2d(np.asarray(directions, np.float64))
    x, y, z = (n / np.linalg.norm(n, axis=1, keepdims=True)).T
    pull = np.stack([x * x, y * y, z * z, y * z, x * z, x * y], axis=1)
    found = 1 / np.einsum("ni,ij,nj->n", pull, compliance(stiffness), pull)
    return np.where(found > NOTHING, found, 0.0)


def averages(stiffness: Any) -> Averages:
    """The averages after Voigt and Reuss, for any symmetry (Hill 1952)."""
    c, s = np.asarray(stiffness, np.float64), compliance(stiffness)
    diagonal, beside, shears = c[:3, :3].trace(), c[0, 1] + c[0, 2] + c[1, 2], c[3:, 3:].trace()
    d, b, t = s[:3, :3].trace(), s[0, 1] + s[0, 2] + s[1, 2], s[3:, 3:].trace()
    bulk, shear = 1 / (d + 2 * b), 15 / (4 * d - 4 * b + 3 * t)
    return Averages(
        float(diagonal + 2 * beside) / 9, float(bulk) if bulk > NOTHING else 0.0,
        float(diagonal - beside + 3 * shears) / 15, float(shear) if shear > NOTHING else 0.0,
    )  # fmt: skip


def cubic(stiffness: Any) -> tuple[float, float, float]:
    """C11, C12 and C44 of the cubic stiffness nearest to one, its axes along x, y, z."""
    c = np.asarray(stiffness, np.float64)
    return float(c[:3, :3].trace() / 3), float((c[0, 1] + c[0, 2] + c[1, 2]) / 3), float(c[3:, 3:].trace() / 3)


def cubic_matrix(c11: float, c12: float, c44: float) -> Floats:
    """The stiffness (6, 6) of three cubic constants."""
    out = np.diag([c11 - c12] * 3 + [c44] * 3)
    out[:3, :3] += c12
    return out


def turned(stiffness: Any, turn: Any) -> Floats:
    """A stiffness (6, 6) whose material is turned by a rotation (3, 3).

    >>> quarter = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    >>> bool(np.allclose(turned(cubic_matrix(3, 1, 2), quarter), cubic_matrix(3, 1, 2)))
    True
    """
    pairs = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    r = np.asarray(turn, np.float64)
    strain = np.empty((6, 6))  # what is strained in the part, by Voigt, as the material has it: strains turn back
    for column, (i, j) in enumerate(pairs):
        tensor = np.zeros((3, 3))
        tensor[i, j] = tensor[j, i] = 1.0 if i == j else 0.5
        back = r.T @ tensor @ r
        strain[:, column] = [back[a, b] * (1 if a == b else 2) for a, b in pairs]
    return np.asarray(strain.T @ np.asarray(stiffness, np.float64) @ strain)


def away_from_cubic(stiffness: Any) -> float:
    """How far a stiffness is from the cubic one nearest to it, relative to its own size (0 to 1)."""
    c = np.asarray(stiffness, np.float64)
    size = float(np.linalg.norm(c))
    return float(np.linalg.norm(c - cubic_matrix(*cubic(c)))) / size if size > NOTHING else 0.0


def zener(stiffness: Any) -> float:
    """2 C44 / (C11 - C12): 1 where isotropic, above 1 where stiffest along 111, below 1 along 100; NaN where nothing
    resists, or it is not cubic along x, y, z."""
    c11, c12, c44 = cubic(stiffness)
    if away_from_cubic(stiffness) > CUBIC or c11 - c12 <= NOTHING:
        return float("nan")
    return 2 * c44 / (c11 - c12)


def upper_bounds(density: float, nu: float) -> dict[str, float]:
    """The bounds that no isotropic porous solid of this density exceeds, in units of the solid's Young's modulus and
    conductivity (Z. Hashin and S. Shtrikman, J. Mech. Phys. Solids 11, 1963, and J. Appl. Phys. 33, 1962).

    That of the bulk modulus holds for cubic cells as well. The lower bounds are 0, as voids may surround everything.

    >>> upper_bounds(1.0, 0.25)["E"]
    1.0
    """
    k, g = 1 / (3 * (1 - 2 * nu)), 1 / (2 * (1 + nu))
    void = 1 - density
    bulk = k * 4 * g * density / (4 * g + 3 * k * void)
    shear = g - void / (1 / g - 6 * density * (k + 2 * g) / (5 * g * (3 * k + 4 * g)))
    e = 9 * bulk * shear / (3 * bulk + shear) if density else 0.0
    return {"bulk": bulk, "shear": shear, "E": e, "conductivity": 2 * density / (3 - density)}
