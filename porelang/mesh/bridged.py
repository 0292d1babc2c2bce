"""Narrow gaps that a mesh has bridged, and thin walls that it has holes in, in places all over them.

Points on the surface look across the gaps and walls of the part. Of one that is narrower than the diagonal of a cell
the samples may have nothing, or what they have is cut in two where they stand at an angle to it: a mesh goes by what is
linear between eight samples, and where that has the other sign in the middle of a gap the mesh crosses it. Each bridge
is short, and of the volume little is off; but the mesh is another body.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.grid import Grid, place
from porelang.solid import Solid
from porelang.walls import ALIKE, PARALLEL, SCAN, least, on_surface

Floats = NDArray[np.float64]
#: Fewer places, or a smaller share of those looked at, are where a gap ends or a wall runs out.
MANY, SHARE = 8, 0.05


@dataclass(frozen=True, slots=True)
class Bridged:
    """Gaps (or walls, where they are `solid`) that a mesh has nothing of in a share of the places looked at: how wide
    they are (mm), and the middle (3,) mm of one where it has nothing."""

    solid: bool
    width: float
    at: Floats

    @property
    def told(self) -> str:
        """What the mesh has made of them, with a place."""
        where = f"in many places, as at {place(self.at)}"
        if self.solid:
            return f"walls about {self.width:.2g} mm thick have holes {where}"
        return f"gaps about {self.width:.2g} mm wide are bridged {where}"


def bridged(grid: Grid, part: Solid) -> tuple[Bridged, ...]:
    """The narrowest gaps and the thinnest walls of a part that its mesh on a grid has nothing of in many places."""
    at, found, most = on_surface(part), [], math.sqrt(3) * grid.spacing
    for solid in (False, True):
        wide, facing, far = part.walls(at, most / ALIKE, SCAN, void=not solid)
        across = facing < PARALLEL
        width = least(np.sort(wide[across]), len(at), most)
        if width is None:
            continue
        across &= (wide > ALIKE * width) & (wide < width / ALIKE)
        middle = (at[across] + far[across]) / 2
        lacks = _lacks(grid, part, middle, solid)
        if lacks.sum() >= MANY and lacks.mean() >= SHARE:
            found.append(Bridged(solid, width, middle[int(lacks.argmax())]))
    return tuple(found)


def _lacks(grid: Grid, part: Solid, points: Floats, solid: bool) -> NDArray[np.bool_]:
    """Which points (n, 3) mm, `solid` or void, the mesh has the other way, by what is linear between its samples."""
    at = (points - np.array(grid.origin)) / grid.spacing
    cells = np.floor(at).astype(np.int64)
    value = np.zeros(len(points))
    for step in np.ndindex(2, 2, 2):
        weight = np.where(step, at - cells, 1 - (at - cells)).prod(axis=1)
        with np.errstate(all="ignore"):  # beyond what numbers hold nothing is told
            value += weight * part.value(np.array(grid.origin) + (cells + step) * grid.spacing)
    lacks: NDArray[np.bool_] = (value > 0) if solid else (value < 0)
    return lacks
