"""Where along the values of a param the density of a part rises, or falls: the ways up that a loop can take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def about(values: Array, shares: Array, middle: float) -> tuple[float, float]:
    """The least and the greatest of shares on the widest way up or down through the value that is nearest to one."""
    at, ways = int(np.argmin(np.abs(values - middle))), []
    for sign in (1.0, -1.0):
        first = last = at
        while first > 0 and sign * (shares[first] - shares[first - 1]) > 0:
            first -= 1
        while last + 1 < len(shares) and sign * (shares[last + 1] - shares[last]) > 0:
            last += 1
        ways.append(sorted((float(shares[first]), float(shares[last]))))
    least, most = max(ways, key=lambda way: way[1] - way[0])
    return least, most


def climb(values: Array, shares: Array, low: float, high: float) -> tuple[float, float, float] | None:
    """The shortest way up, from at most `low` to at least `high`, along which shares do not fall: its ends, as they are
    after a sign that is the third; None where there is none."""
    ways = []
    for sign in (1.0, -1.0):
        x, y = (values, shares) if sign > 0 else (-values[::-1], shares[::-1])
        for i in np.flatnonzero(y <= low):
            j = i
            while j + 1 < len(y) and y[j + 1] >= y[j] and y[j] < high:
                j += 1
            if y[j] >= high:
                ways.append((float(x[j] - x[i]), float(x[i]), float(x[j]), sign))
    return None if not ways else min(ways)[1:]


@dataclass(frozen=True, slots=True)
class Refused:
    """Why limits of the density are none, and others within them, if there are any."""

    code: str
    message: str
    near: tuple[float, float] | None


def within_limits(least: float, most: float, low: float, high: float) -> tuple[float, float] | None:
    """Limits of the density, a little within those that were found, as values have steps; None where they are none."""
    some, more = max(low, np.ceil(100 * least + 1) / 100), min(high, np.floor(100 * most - 1) / 100)
    return (float(some), float(more)) if some < more and (some, more) != (low, high) else None
