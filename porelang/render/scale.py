"""From numbers to colours: around zero, or from a least value to a greatest; both readable for the colour-blind."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float32]
#: RdYlBu of ColorBrewer (Brewer 2003), nine classes.
COLOURS = np.array([
    (215, 48, 39), (244, 109, 67), (253, 174, 97), (254, 224, 144), (255, 255, 191),
    (224, 243, 248), (171, 217, 233), (116, 173, 209), (69, 117, 180),
], dtype=np.float32) / 255  # fmt: skip
#: Viridis (van der Walt and Smith 2015), nine of its colours.
VIRIDIS = np.array([
    (68, 1, 84), (71, 44, 122), (59, 81, 139), (44, 113, 142), (33, 144, 141), (39, 173, 129), (92, 200, 99),
    (170, 220, 50), (253, 231, 37),
], dtype=np.float32) / 255  # fmt: skip
UNDEFINED = np.array((0.6, 0.6, 0.6), np.float32)
#: Steps of the numbers are these times a power of ten, and there are about so many on either side of zero.
ROUND, NUMBERS = (1.0, 2.0, 5.0, 10.0), 3


@dataclass(frozen=True, slots=True)
class Scale:
    """Around zero: red is full at `-low`, yellow is zero, blue is full at `high`; both numbers are above 0."""

    low: float
    high: float

    @property
    def ends(self) -> tuple[float, float]:
        return -self.low, self.high

    def __str__(self) -> str:
        return f"red {-self.low:.3g}, yellow 0, blue {self.high:.3g}"


@dataclass(frozen=True, slots=True)
class Ramp:
    """From the least value, which is violet, over green to the greatest, which is yellow."""

    least: float
    greatest: float

    @property
    def ends(self) -> tuple[float, float]:
        return self.least, self.greatest

    def __str__(self) -> str:
        return f"violet {self.least:.4g}, yellow {self.greatest:.4g}"


Colouring = Scale | Ramp


def around_zero(values: NDArray[np.float64]) -> Scale:
    """The scale that takes in values on either side of zero, in two digits."""
    values = values[np.isfinite(values)]
    if not len(values) or not values.any():
        return Scale(1.0, 1.0)
    low, high = _round_up(float(-values.min())), _round_up(float(values.max()))
    return Scale(low if low > 0 else high, high if high > 0 else low)


def fitting(values: NDArray[np.float64]) -> Colouring:
    """A scale around zero for values of both signs, else a ramp from the least to the greatest, in three digits."""
    values = values[np.isfinite(values)]
    if not len(values):
        return Ramp(0.0, 1.0)
    least, greatest = float(values.min()), float(values.max())
    if least < 0 < greatest:
        return around_zero(values)
    largest = max(abs(least), abs(greatest))
    # a field that is the same everywhere, but for what is rounded
    if greatest - least <= 1e-5 * largest or largest == 0:
        more = 0.05 * largest or 1.0
        return Ramp(least - more, greatest + more)
    unit = 10.0 ** (math.floor(math.log10(greatest - least)) - 2)
    return Ramp(math.floor(least / unit) * unit, math.ceil(greatest / unit) * unit)


def wished(low: float, high: float, on_planes: bool) -> Colouring:
    """The scale of a range that is asked for. On planes zero is yellow wherever it lies in the range, or at its end."""
    if low < 0 < high or (on_planes and low <= 0 <= high):
        return Scale(-low or high, high or -low)
    return Ramp(low, high)


def _round_up(value: float) -> float:
    """To two digits, away from zero: 51.8 is 52. Samples seldom meet the extreme itself, and 9.98 says 10."""
    if value <= 0:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.ceil(value / unit * (1 - 1e-3)) * unit


def scale_colours(values: Values | NDArray[np.float64], scale: Colouring) -> Values:
    """Red, green and blue (..., 3) in 0..1 of values; grey where they are not numbers."""
    with np.errstate(all="ignore"):
        if isinstance(scale, Scale):
            table = COLOURS
            place: NDArray[Any] = (np.where(values < 0, values / scale.low, values / scale.high) + 1) / 2
        else:
            table = VIRIDIS
            place = (values - scale.least) / (scale.greatest - scale.least)
        place = np.clip(place, 0, 1) * (len(table) - 1)
    known = np.isfinite(place)
    place = np.where(known, place, 0.0).astype(np.float32)
    below = np.minimum(place.astype(np.intp), len(table) - 2)
    share = (place - below)[..., None]
    out: Values = (table[below] * (1 - share) + table[below + 1] * share).astype(np.float32)
    out[~known] = UNDEFINED
    return out


def line_step(scale: Colouring) -> float:
    """The step between lines of equal value: half of that of the numbers."""
    found = numbers(scale)
    low, high = scale.ends
    return (found[1] - found[0] if len(found) > 1 else high - low) / 2


def numbers(scale: Colouring) -> list[float]:
    """The round numbers of a scale, lowest first; zero is among them where it lies in it."""
    low, high = scale.ends
    longest = max(-low, high) if isinstance(scale, Scale) else (high - low) / 2
    power = 10.0 ** np.floor(np.log10(longest / NUMBERS))
    step = next(r * power for r in ROUND if longest / (r * power) <= NUMBERS + 0.5)
    return [float(step * k) for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]
