"""How stiff a lattice is at a density, and how thick its walls are then.

Density is the share of solid, 0..1, over a volume of one cell or more. A law gives the stiffness of a voxel as a sum of
`bases`, tensors (6, 6) in MPa, weighted by functions of the density.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from porelang.diagnostics import fail
from porelang.optimize.element import cubic

Array = NDArray[np.float64]


class Law(Protocol):
    """The stiffness of a lattice: `bases` (k, 6, 6) MPa, and for densities (m,) their weights (m, k) and slopes."""

    @property
    def bases(self) -> Array: ...
    def weights(self, density: Array) -> Array: ...
    def slopes(self, density: Array) -> Array: ...


@dataclass(frozen=True, eq=False)
class Power:
    """C = coefficient * density^exponent * `solid`, the tensor (6, 6) MPa of the material (Gibson and Ashby, 1997).

    Its anisotropy does not depend on the density, and is that of `solid`.

    >>> Power(np.eye(6), 0.754, 1.49).weights(np.array([1.0])).tolist()
    [[0.754]]
    """

    solid: Array
    coefficient: float = 1.0
    exponent: float = 1.0

    @property
    def bases(self) -> Array:
        return self.solid[None]

    def weights(self, density: Array) -> Array:
        return (self.coefficient * density**self.exponent)[:, None]

    def slopes(self, density: Array) -> Array:
        return (self.coefficient * self.exponent * density ** (self.exponent - 1))[:, None]


@dataclass(frozen=True, eq=False)
class Cubic:
    """The three constants of a cubic lattice, interpolated: `densities` (n,), rising, and `constants` (n, 3) MPa.

    The constants are c11, c12, c44. Between the densities monotone cubics go (Fritsch and Carlson, 1980), beyond them
    their logarithms go on straight over the logarithm of the density, as a power law does. Errors: E192.
    """

    densities: Array
    constants: Array

    def __post_init__(self) -> None:
        c11, c12, c44 = self.constants.T
        if len(self.densities) < 3 or (np.diff(self.densities) <= 0).any():
            raise fail("E192", "a law needs three densities or more, each above the one before",
                       hint="homogenise the lattice at more densities")  # fmt: skip
        sound = (c11 > np.abs(c12)) & (c11 + 2 * c12 > 0) & (c44 > 0) & (self.densities > 0)
        if not sound.all():
            at = float(self.densities[~sound][0])
            raise fail("E192", f"the stiffness at the density {at:.4g} is that of no material: c11 > |c12|, "
                       "c11 + 2 c12 > 0 and c44 > 0 must hold",
                       hint="the lattice may be in pieces there: begin at a higher density")  # fmt: skip

    @property
    def bases(self) -> Array:
        return np.array([cubic(*row) for row in np.eye(3)])

    def weights(self, density: Array) -> Array:
        return self._curve(density)[0]

    def slopes(self, density: Array) -> Array:
        return self._curve(density)[1]

    def _curve(self, density: Array) -> tuple[Array, Array]:
        # c12 may be near 0 where others are not: bulk and shear moduli are positive, so these are what is interpolated
        c11, c12, c44 = self.constants.T
        x = np.log(density)
        known = np.log(self.densities)
        near = np.clip(x, known[0], known[-1])
        values, rates = [], []
        for moduli in (c11 + 2 * c12, c11 - c12, c44):
            curve = PchipInterpolator(known, np.log(moduli))
            rate = curve(near, 1)
            value = np.exp(curve(near) + (x - near) * rate)
            values.append(value)
            rates.append(value * rate / density)
        (bulk, shear, c44), (bulk_, shear_, c44_) = values, rates
        return (
            np.stack([(bulk + 2 * shear) / 3, (bulk - shear) / 3, c44], 1),
            np.stack([(bulk_ + 2 * shear_) / 3, (bulk_ - shear_) / 3, c44_], 1),
        )


def fitted(densities: Array, moduli: Array) -> tuple[float, float, float]:
    """(coefficient, exponent, error): coefficient * density^exponent nearest to relative moduli, and its largest miss.

    By least squares of the logarithms; the miss is relative. A fit is worth what its range is: of a gyroid sheet one on
    .2 to .5 alone is a quarter too low at .8.

    >>> c, n, e = fitted(np.array([.2, .4, .8]), .7 * np.array([.2, .4, .8]) ** 1.5)
    >>> round(c, 9), round(n, 9), e < 1e-12
    (0.7, 1.5, True)
    """
    exponent, constant = np.polyfit(np.log(densities), np.log(moduli), 1)
    miss = np.exp(constant) * densities**exponent / moduli - 1
    return float(np.exp(constant)), float(exponent), float(np.abs(miss).max())


@dataclass(frozen=True, eq=False)
class Thickness:
    """What gives a lattice its density: pairs of a density and a thickness (or any such number), both strictly rising.

    Between them monotone cubics go, so that one is the inverse of the other; nothing is said beyond. Errors: E192.

    >>> law = Thickness(np.array([.1, .5, .9]), np.array([.3, 1.5, 2.6]))
    >>> float(law.density(law.thickness(np.array([.3])))[0].round(6))
    0.3
    """

    densities: Array
    values: Array

    def __post_init__(self) -> None:
        rising = (np.diff(self.densities) > 0).all() and (np.diff(self.values) > 0).all()
        if len(self.densities) < 2 or not rising:
            raise fail("E192", "the density of the lattice does not rise with its thickness all along",
                       hint="narrow the limits to where it does: beyond, more thickness is no more solid")  # fmt: skip

    @property
    def limits(self) -> tuple[float, float]:
        """The least and the greatest density."""
        return float(self.densities[0]), float(self.densities[-1])

    def thickness(self, density: Array) -> Array:
        """The thickness (m,) at densities (m,), each within the limits."""
        out: Array = PchipInterpolator(self.densities, self.values)(np.clip(density, *self.limits))
        return out

    def density(self, thickness: Array) -> Array:
        """The density (m,) at thicknesses: the inverse of `thickness`, by bisection."""
        low = np.full(np.shape(thickness), self.densities[0])
        high = np.full(np.shape(thickness), self.densities[-1])
        curve = PchipInterpolator(self.densities, self.values)
        for _ in range(60):
            middle = (low + high) / 2
            less = curve(middle) < thickness
            low, high = np.where(less, middle, low), np.where(less, high, middle)
        out: Array = (low + high) / 2
        return out
