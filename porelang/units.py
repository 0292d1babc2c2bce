"""Dimensions and unit suffixes; the base units are mm, rad, N and so MPa = N/mm^2."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction


@dataclass(frozen=True, slots=True)
class Dimension:
    """Exponents of length, angle and force. `None` in its place means *not known*: a bare number fits anywhere."""

    length: Fraction = Fraction(0)
    angle: Fraction = Fraction(0)
    force: Fraction = Fraction(0)

    def __mul__(self, other: Dimension) -> Dimension:
        return Dimension(self.length + other.length, self.angle + other.angle, self.force + other.force)

    def __truediv__(self, other: Dimension) -> Dimension:
        return Dimension(self.length - other.length, self.angle - other.angle, self.force - other.force)

    def __pow__(self, exponent: Fraction) -> Dimension:
        return Dimension(self.length * exponent, self.angle * exponent, self.force * exponent)

    def __str__(self) -> str:
        """The dimension in a user's words: `a length`, `an angle`, `a stress`, `mm^2`."""
        return NAMES.get(self) or f"a quantity in {self.unit}"

    @property
    def unit(self) -> str:
        """The dimension in base units: `mm`, `N/mm^2`."""
        parts = (("mm", self.length), ("rad", self.angle), ("N", self.force))
        above = [_power(u, e) for u, e in parts if e > 0]
        below = [_power(u, -e) for u, e in parts if e < 0]
        return ("*".join(above) or "1") + "".join(f"/{b}" for b in below)


def _power(unit: str, exponent: Fraction) -> str:
    return unit if exponent == 1 else f"{unit}^{exponent}"


RATIO = Dimension()
LENGTH = Dimension(length=Fraction(1))
ANGLE = Dimension(angle=Fraction(1))
FORCE = Dimension(force=Fraction(1))
STRESS = FORCE / LENGTH / LENGTH
AREA = LENGTH * LENGTH
VOLUME = AREA * LENGTH

NAMES = {
    RATIO: "a ratio",
    LENGTH: "a length",
    ANGLE: "an angle",
    FORCE: "a force",
    STRESS: "a stress",
    AREA: "an area",
    VOLUME: "a volume",
}


@dataclass(frozen=True, slots=True)
class Unit:
    """A suffix of the language: its dimension and its size in base units."""

    name: str
    dimension: Dimension
    scale: float


UNITS = {
    u.name: u
    for u in (
        Unit("um", LENGTH, 1e-3),
        Unit("mm", LENGTH, 1.0),
        Unit("cm", LENGTH, 10.0),
        Unit("m", LENGTH, 1000.0),
        Unit("in", LENGTH, 25.4),
        Unit("deg", ANGLE, math.pi / 180),
        Unit("rad", ANGLE, 1.0),
        Unit("turn", ANGLE, math.tau),
        Unit("N", FORCE, 1.0),
        Unit("kN", FORCE, 1e3),
        Unit("Pa", STRESS, 1e-6),
        Unit("kPa", STRESS, 1e-3),
        Unit("MPa", STRESS, 1.0),
        Unit("GPa", STRESS, 1e3),
        Unit("%", RATIO, 0.01),
    )
}
