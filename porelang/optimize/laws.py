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
from porelang.unitcell import law as cells
from porelang.unitcell.moduli import turned

Array = NDArray[np.float64]


class Law(Protocol):
    """The stiffness of a lattice: `bases` (k, 6, 6) MPa, and for densities (m,) of its `range` their weights (m, k) and
    slopes."""

    @property
    def range(self) -> tuple[float, float]: ...
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
    def range(self) -> tuple[float, float]:
        return 0.01, 1.0

    @property
    def bases(self) -> Array:
        return self.solid[None]

    def weights(self, density: Array) -> Array:
        return (self.coefficient * density**self.exponent)[:, None]

    def slopes(self, density: Array) -> Array:
        return (self.coefficient * self.exponent * density ** (self.exponent - 1))[:, None]


@dataclass(frozen=True, eq=False)
class Lattice:
    """The law of a lattice that was homogenised, of a solid of Young's modulus `young`: a number or (m,), MPa.

    `turn` (3, 3) brings the axes of its cells to where they are in the part. Errors: E192 for what is no material.
    """

    law: cells.Law
    young: float | Array
    turn: Array | None = None

    def __post_init__(self) -> None:
        sound = is_material(self.law.constants) & (self.law.density > 0)
        if not sound.all():
            at = float(self.law.density[~sound][0])
            raise fail("E192", f"the stiffness at the density {at:.4g} is that of no material: c11 > |c12|, "
                       "c11 + 2 c12 > 0 and c44 > 0 must hold",
                       hint="the lattice may be in pieces there: begin at a higher density")  # fmt: skip

    @property
    def range(self) -> tuple[float, float]:
        return self.law.range

    @property
    def bases(self) -> Array:
        upright = np.array([cubic(*row) for row in np.eye(3)])
        return upright if self.turn is None else np.array([turned(base, self.turn) for base in upright])

    def weights(self, density: Array) -> Array:
        return np.reshape(self.young, (-1, 1)) * self.law.cubic(density)

    def slopes(self, density: Array) -> Array:
        return np.reshape(self.young, (-1, 1)) * self.law.slope(density)


def is_material(constants: Array) -> NDArray[np.bool_]:
    """Which of C11, C12, C44 (k, 3) are those of a material: every strain takes energy."""
    c11, c12, c44 = constants.T
    return np.asarray((c11 > np.abs(c12)) & (c11 + 2 * c12 > 0) & (c44 > 0))


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
