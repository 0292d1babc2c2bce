"""The law of a lattice: what it resists as a function of its density, from some cells that were homogenised.

Two forms. The samples themselves, joined by monotone cubic pieces (F. N. Fritsch and R. E. Carlson, SIAM J. Numer.
Anal. 17, 1980), which is what to compute with; and a power C rho^n (L. J. Gibson and M. F. Ashby, Cellular Solids,
1997), which is what to compare with others, and is no better than its fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import fail
from porelang.unitcell.moduli import away_from_cubic, cubic, cubic_matrix

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Power:
    """C rho^n, with the share of the variance of the logarithms that it explains, the largest relative miss of a
    sample, and the range of densities that it was fitted to."""

    factor: float
    exponent: float
    r2: float
    miss: float
    range: tuple[float, float]

    def __str__(self) -> str:
        lo, hi = self.range
        fit = f"R2 {self.r2:.4f}, within {self.miss:.0%}; rho {lo:.2f}..{hi:.2f}"
        return f"{self.factor:.3f} rho^{self.exponent:.2f} ({fit})"


def power(density: Any, values: Any) -> Power:
    """The power of the density through values, by least squares of the logarithms; those that are 0 have none.

    >>> str(power([0.2, 0.4, 0.8], [0.02, 0.08, 0.32]))
    '0.500 rho^2.00 (R2 1.0000, within 0%; rho 0.20..0.80)'
    """
    rho, found = np.asarray(density, np.float64), np.asarray(values, np.float64)
    kept = (rho > 0) & (found > 0)
    if len(np.unique(rho[kept])) < 2:
        raise fail("E183", "a power of the density needs two densities at least at which something resists",
                   hint="sweep over a wider range")  # fmt: skip
    x, y = np.log(rho[kept]), np.log(found[kept])
    exponent, offset = np.polyfit(x, y, 1)
    left = y - (exponent * x + offset)
    spread = float(((y - y.mean()) ** 2).sum())
    r2 = 1 - float((left**2).sum()) / spread if spread else 1.0
    miss = float(np.abs(np.expm1(-left)).max())
    return Power(float(np.exp(offset)), float(exponent), r2, miss, (float(rho[kept].min()), float(rho[kept].max())))


@dataclass(frozen=True)
class Law:
    """A lattice's cubic stiffness by its density, in units of the solid's Young's modulus.

    `density` (k,) ascends, `constants` (k, 3) are C11, C12, C44 and `errors` (k, 3) theirs; `nu` is Poisson's ratio of
    the solid that they are for. Between samples it is monotone where they are, and 0 at density 0; beyond the first
    sample it is a guess, and `range` says where that is.
    """

    density: Floats
    constants: Floats
    errors: Floats
    nu: float
    away: float = 0.0  # how far the least cubic of the samples was from it

    @property
    def range(self) -> tuple[float, float]:
        """The densities between which it was sampled."""
        return float(self.density[0]), float(self.density[-1])

    @cached_property
    def _through(self) -> Any:
        from scipy.interpolate import PchipInterpolator

        # of the eigenvalues of a cubic stiffness, each of which is at least 0 and grows with the density
        c11, c12, c44 = self.constants.T
        modes = np.stack([c11 + 2 * c12, c11 - c12, c44], axis=1)
        rho = np.concatenate([[0.0], self.density])
        return PchipInterpolator(rho, np.concatenate([np.zeros((1, 3)), modes]), axis=0)

    def cubic(self, density: Any) -> Floats:
        """C11, C12 and C44 (..., 3) at densities (...) from 0 to the last sample. Errors: E183 beyond it."""
        rho = np.asarray(density, np.float64)
        low, high = 0.0, self.range[1]
        if rho.size and not (rho.min() >= low and rho.max() <= high + 1e-9):
            raise fail("E183", f"a density of {rho.max() if rho.max() > high else rho.min():.4g} lies beyond this law",
                       hint=f"it was sampled from {self.range[0]:.3g} to {high:.3g}")  # fmt: skip
        bulk, shear, c44 = np.moveaxis(self._through(np.minimum(rho, high)), -1, 0)
        return np.stack([(bulk + 2 * shear) / 3, (bulk - shear) / 3, c44], axis=-1)

    def stiffness(self, density: Any) -> Floats:
        """The stiffness (..., 6, 6) at densities (...)."""
        found = self.cubic(density)
        out: Floats = np.apply_along_axis(lambda c: cubic_matrix(*c), -1, found)
        return out

    def young(self, density: Any) -> Floats:
        """Young's modulus along 100 at densities (...)."""
        c11, c12, _ = np.moveaxis(self.cubic(density), -1, 0)
        with np.errstate(invalid="ignore", divide="ignore"):
            found = (c11 - c12) * (c11 + 2 * c12) / (c11 + c12)
        return np.where(c11 + c12 > 0, found, 0.0)

    def slope(self, density: Any) -> Floats:
        """The derivatives (..., 3) of C11, C12 and C44 by the density."""
        bulk, shear, c44 = np.moveaxis(self._through(np.asarray(density, np.float64), 1), -1, 0)
        return np.stack([(bulk + 2 * shear) / 3, (bulk - shear) / 3, c44], axis=-1)

    @cached_property
    def power(self) -> Power:
        """The power through Young's modulus along 100."""
        return power(self.density, self.young(self.density))

    def error(self, density: Any) -> Floats:
        """The error of each of C11, C12, C44 (..., 3): that of the samples, and what leaving out every second of them
        would change there."""
        rho = np.asarray(density, np.float64)
        own = np.stack([np.interp(rho, self.density, e) for e in self.errors.T], axis=-1)
        if len(self.density) < 4:
            return (
                own + np.abs(self.slope(np.clip(rho, *self.range))) * float(np.diff(self.density).max(initial=0.0)) / 8
            )
        kept = np.unique(np.r_[np.arange(0, len(self.density), 2), len(self.density) - 1])
        coarse = Law(self.density[kept], self.constants[kept], self.errors[kept], self.nu)
        # the most in each piece and beside it, for ends and kinks are worse than the middle
        at = np.linspace(self.density[:-1], self.density[1:], 9)
        most = np.abs(coarse.cubic(at) - self.cubic(at)).max(axis=0)
        wide = np.concatenate([most[:1], most, most[-1:]])
        piece = np.clip(np.searchsorted(self.density, rho, side="right") - 1, 0, len(most) - 1)
        return np.asarray(own + np.max([wide[piece], wide[piece + 1], wide[piece + 2]], axis=0))


def law(density: Sequence[float], stiffness: Any, errors: Any = None, nu: float = 0.3) -> Law:
    """The law through stiffnesses (k, 6, 6) at densities (k,), with their errors (k, 6, 6).

    Errors: E183 for fewer than two densities, or two that are the same. How far the least cubic
    stiffness is from one is its `away`.

    >>> from porelang.unitcell.hexahedron import isotropic
    >>> found = law([0.5, 1.0], [0.2 * isotropic(0.3), isotropic(0.3)])
    >>> found.young([0.5, 1.0]).round(9).tolist()
    [0.2, 1.0]
    """
    rho = np.asarray(density, np.float64)
    order = np.argsort(rho)
    if len(rho) < 2 or np.diff(rho[order]).min() < 1e-6:
        raise fail("E183", "a law needs two different densities at least", hint="sweep over a param that changes it")
    matrices = np.asarray(stiffness, np.float64)[order]
    wrong = np.zeros_like(matrices) if errors is None else np.asarray(errors, np.float64)[order]
    return Law(rho[order], np.array([cubic(c) for c in matrices]), np.array([cubic(e) for e in wrong]), nu,
               max(map(away_from_cubic, matrices)))  # fmt: skip
