"""What engineers read off a stiffness: moduli by direction, isotropic averages, bounds, and how cubic it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import fail

Floats = NDArray[np.float64]
#: Directions by the names of their Miller indices.
NAMED = {"100": (1, 0, 0), "010": (0, 1, 0), "001": (0, 0, 1), "110": (1, 1, 0), "111": (1, 1, 1)}
#: A stiffness further than this from a cubic one (relative) has no ratio of Zener's.
CUBIC = 0.01
#: A modulus below this (of the solid's) is none: what is left of a cell that hangs by nothing.
NOTHING = 1e-9
#: A mode of the stiffness below this share of the stiffest is none, and so is one below the second, of a solid of 1:
#: what a solver leaves of plates, tilted or not, is up to 1.3e-9 of the stiffest; of bending struts of .005 of their
#: cell G is 2e-5 of E.
_NO_MODE, _LEAST_MODE = 1e-8, 1e-10
#: A stress of which more than this share (of its square) is in modes that nothing resists is not resisted: a direction
#: is so along a fibre as far as 1e-4 beside it.
_APART = 1e-8
#: Shears by Voigt in units of those whose squares add up as those of a tensor's entries do (P. M. Theocaris and
#: D. P. Sokolis, Acta Mech. 150, 2001): only there are modes those of the material, whatever way it is turned.
_TENSOR = np.array([1.0, 1.0, 1.0, 2**0.5, 2**0.5, 2**0.5])


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


def _modes(stiffness: Any) -> tuple[Floats, Floats, Floats]:
    """The modes (6, k) that resist, their stiffnesses (k,), and those that do not (6, 6 - k); in `_TENSOR`'s units."""
    size, modes = np.linalg.eigh(_TENSOR[:, None] * np.asarray(stiffness, np.float64) * _TENSOR)
    there = size > max(_NO_MODE * float(size.max()), _LEAST_MODE)
    return modes[:, there], size[there], modes[:, ~there]


def compliance(stiffness: Any, faint: float = 0.0) -> Floats:
    """The inverse (6, 6) of a stiffness in the modes that resist; in others 0, for which see `resisted`, or that of a
    share of the stiffest mode, `faint`, where it is given."""
    modes, size, none = _modes(stiffness)
    found = (modes / size) @ modes.T
    if faint:
        found = found + none @ none.T / (faint * (float(size.max(initial=0.0)) or NOTHING))
    return np.asarray(_TENSOR[:, None] * found * _TENSOR)


def free(stiffness: Any) -> int:
    """How many modes nothing resists, of six."""
    return 6 - len(_modes(stiffness)[1])


def resisted(stiffness: Any, stresses: Any) -> NDArray[np.bool_]:
    """Whether stresses (n, 6) by Voigt are held: no mode that nothing resists takes part in them.

    >>> resisted(np.diag([0, 1.0, 1, 1, 1, 1]), np.eye(6)[:2]).tolist()
    [False, True]
    """
    none, pulls = _modes(stiffness)[2], _TENSOR * np.asarray(stresses, np.float64)
    return np.asarray(((pulls @ none) ** 2).sum(axis=1) <= _APART * (pulls**2).sum(axis=1))


def young(stiffness: Any, directions: Any) -> Floats:
    """Young's modulus (n,) along directions (n, 3), of any length; 0 where a mode that nothing resists takes part.

    Errors: E108 for what is no direction.

    >>> from porelang.unitcell.hexahedron import isotropic
    >>> young(isotropic(0.2), [[1, 2, 3]]).round(12).tolist()
    [1.0]
    """
    pull = pulls(directions)
    bends = np.einsum("ni,ij,nj->n", pull, compliance(stiffness), pull)
    held = resisted(stiffness, pull) & (bends > 0)
    found = 1 / np.where(held, bends, np.inf)
    return np.where(found > NOTHING, found, 0.0)


def pulls(directions: Any) -> Floats:
    """Unit stresses (n, 6) by Voigt along directions (n, 3), of any length. Errors: E108 for what is no direction."""
    try:
        n = np.atleast_2d(np.asarray(directions, np.float64))
    except (TypeError, ValueError):
        n = np.zeros((1, 0))
    if n.ndim != 2 or n.shape[1] != 3 or not np.isfinite(n).all() or not n.any(axis=1).all():
        raise fail("E108", f"{directions!r:.60} are no directions",
                   hint="give three numbers to each, not all of them 0: [[1, 1, 0], [1, 2, 3]]")  # fmt: skip
    n = n / np.abs(n).max(axis=1, keepdims=True)
    x, y, z = (n / np.linalg.norm(n, axis=1, keepdims=True)).T
    return np.stack([x * x, y * y, z * z, y * z, x * z, x * y], axis=1)


def averages(stiffness: Any) -> Averages:
    """The averages after Voigt and Reuss, for any symmetry (Hill 1952)."""
    c, s = np.asarray(stiffness, np.float64), compliance(stiffness)
    diagonal, beside, shears = c[:3, :3].trace(), c[0, 1] + c[0, 2] + c[1, 2], c[3:, 3:].trace()
    d, b, t = s[:3, :3].trace(), s[0, 1] + s[0, 2] + s[1, 2], s[3:, 3:].trace()
    pressure = np.array([[1.0, 1, 1, 0, 0, 0]])
    held = bool(resisted(c, pressure)[0])
    # the modes that nothing resists, but for what they have of a pressure, are of shears
    shared = float(((pressure @ _modes(c)[2]) ** 2).sum()) / 3
    bulk = 1 / (d + 2 * b) if held and d + 2 * b > 0 else 0.0
    shear = 15 / (4 * d - 4 * b + 3 * t) if free(c) - shared < _APART else 0.0
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
