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
    def called(self) -> str:
        """The unit as engineers call it: `MPa`, where `unit` is `N/mm^2`."""
        return _CALLED.get(self.unit, self.unit)

    @property
    def unit(self) -> str:
        """The dimension in base units: `mm`, `N/mm^2`."""
        parts = (("mm", self.length), ("rad", self.angle), ("N", self.force))
        above = [_power(u, e) for u, e in parts if e > 0]
        below = [_power(u, -e) for u, e in parts if e < 0]
        return ("*".join(above) or "1") + "".join(f"/{b}" for b in below)


#: Of base units, what has a name of its own.
_CALLED = {"N/mm^2": "MPa"}


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

#: Our units by the words that others have for them.
SPELT = {
    **dict.fromkeys(("inch", "inches"), "in"),
    **dict.fromkeys(("degree", "degrees"), "deg"),
    **dict.fromkeys(("radian", "radians"), "rad"),
    **dict.fromkeys(("millimeter", "millimetre", "millimeters", "millimetres"), "mm"),
    **dict.fromkeys(("micron", "microns", "micrometer", "micrometre"), "um"),
    **dict.fromkeys(("turns", "rev", "revs"), "turn"),
}
#: A pound-force on a square inch, in Pa (NIST SP 811, B.8: 4.448 221 615 260 5 N and 25.4 mm, exactly).
_PSI = 4.4482216152605e6 / 25.4**2
#: Units of elsewhere: how many of one of ours each is, and of which.
ELSEWHERE: dict[str, tuple[float, str]] = {
    "nm": (1e-6, "mm"),
    "dm": (100, "mm"),
    "km": (1e3, "m"),
    **dict.fromkeys(("ft", "foot", "feet"), (304.8, "mm")),
    **dict.fromkeys(("yd", "yard"), (914.4, "mm")),
    **dict.fromkeys(("mil", "mils", "thou"), (0.0254, "mm")),
    **{f"{u}2": (scale**2, "mm^2") for u, scale in (("mm", 1.0), ("cm", 10.0), ("m", 1e3), ("in", 25.4))},
    **{f"{u}3": (scale**3, "mm^3") for u, scale in (("mm", 1.0), ("cm", 10.0), ("m", 1e3), ("in", 25.4))},
    **dict.fromkeys(("L", "l", "liter", "litre", "liters", "litres"), (1e6, "mm^3")),
    **dict.fromkeys(("dl", "dL"), (1e5, "mm^3")),
    **dict.fromkeys(("cl", "cL"), (1e4, "mm^3")),
    **dict.fromkeys(("ml", "mL", "cc", "ccm"), (1e3, "mm^3")),
    "bar": (0.1, "MPa"),
    **dict.fromkeys(("mbar", "hPa"), (0.1, "kPa")),
    "atm": (0.101325, "MPa"),
    "psi": (0.001 * _PSI, "kPa"),
    "ksi": (0.001 * _PSI, "MPa"),
    "TPa": (1e3, "GPa"),
    "mN": (1e-3, "N"),
    "MN": (1e3, "kN"),
    "lbf": (4.4482216152605, "N"),
    "kgf": (9.80665, "N"),
    **dict.fromkeys(("gon", "grad", "grads"), (0.9, "deg")),
    "arcmin": (1 / 60, "deg"),
    "arcsec": (1 / 3600, "deg"),
}  # fmt: skip
#: What has no unit in the language.
WITHOUT = {
    **dict.fromkeys(("g", "kg", "mg", "t", "lb", "lbs", "oz", "gram", "grams", "tonne"), "mass"),
    **dict.fromkeys(("s", "sec", "ms", "min", "h", "hr", "Hz", "kHz"), "time"),
    **dict.fromkeys(("K", "C", "degC", "degF"), "temperature"),
    **dict.fromkeys(("J", "kJ", "W", "kW", "mW"), "energy"),
    **dict.fromkeys(("A", "mA", "V", "mV", "ohm"), "electricity"),
}


def written(unit: str) -> str:
    """A unit as it stands alone in a program: `in` is a word of the language, so that inches are `1in`."""
    return "1in" if unit == "in" else unit


def converted(count: float, unit: str) -> str:
    """So many of a unit of elsewhere, as the language writes it."""
    factor, ours = ELSEWHERE[unit]
    number = f"{count * factor:.9g}"
    return f"({number} * 1{ours})" if "^" in ours and number != "1" else f"{number}{ours}"
