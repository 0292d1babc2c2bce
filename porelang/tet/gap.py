"""A gap that a mesh closes, and what is said of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.data import coordinates

Floats = NDArray[np.float64]
#: A gap of which so many widths make an element is open, with cubes round it halved (measured: slits of .4 mm in cubes
#: of 1.2 mm, at 3 places and in 2 directions; of 2 mm two of six are).
OPEN = 3.0


@dataclass(frozen=True, slots=True)
class Gap:
    """A gap that is closed: up to how `wide` it is there, over how much (`reach`, the longer side first) and where its
    middle is (mm); whether it `tapers`. It is the largest of `of`, which have a `volume` (mm3) together."""

    wide: float
    reach: tuple[float, float]
    at: Floats
    tapers: bool
    of: int = 1
    volume: float = 0.0


def told(gap: Gap) -> str:
    """What is said of a gap that is closed."""
    long, wide = gap.reach
    over = f"{long:.2g} x {wide:.2g} mm" if wide > gap.wide else f"{long:.2g} mm"
    width = f"{'up to ' if gap.tapers else ''}{gap.wide:.3g} mm"
    where = f"{over}, as at ({coordinates(gap.at)}) mm"
    if gap.of > 1:
        return f"{gap.of} gaps are closed: the largest, {width} wide over {where}"
    return f"a gap {width} wide is closed over {where}"
