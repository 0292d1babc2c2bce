"""How fine the elements of a study are, and what that costs: found from the walls of a part before it is meshed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from porelang.diagnostics import fail
from porelang.solid import Solid
from porelang.tasks.study.got import THROUGH
from porelang.walls import Thinnest, on_surface, triangles, walls_at

#: Elements through the least side of a part without walls.
ACROSS = 10.0
#: Elements of order 2 are found so fine that there are no more unknowns than this: a minute or so. More are for who
#: gives a size, up to the most that a machine with 8 GB takes.
AFFORDABLE, MOST = 800_000, 4_000_000
#: Elements and unknowns of the first and of the second order: for every cube of an edge in the part, and for every
#: square of it on its surface (measured: cylinders, boxes, gyroids).
_TETRAHEDRA = 12.0, 3.0
_UNKNOWNS = {1: (6.0, 3.0), 2: (48.0, 18.0)}
#: Triangles of marching cubes for every square of the voxel on a surface: the mean of |n|_1 is 3/2.
_TRIANGLES = 3.0
#: Seconds for an unknown: meshing, assembly and solution (measured, two cores).
_SECONDS = {1: 4e-5, 2: 5e-5}


@dataclass(frozen=True)
class Sized:
    """Elements of an edge `size` (mm) for a part of a volume (mm3) and an area (mm2), of which walls ask for `wanted`
    (mm); the thinnest of them, None where there are none."""

    size: float
    wanted: float
    wall: Thinnest | None
    volume: float
    area: float
    order: int

    @cached_property
    def elements(self) -> int:
        """About how many there are."""
        return _count(_TETRAHEDRA, self.size, self.volume, self.area)

    @cached_property
    def unknowns(self) -> int:
        """About how many there are."""
        return _count(_UNKNOWNS[self.order], self.size, self.volume, self.area)

    @cached_property
    def seconds(self) -> float:
        """About how long a study takes."""
        return _SECONDS[self.order] * self.unknowns


def sized(part: Solid, size: float, order: int) -> Sized:
    """The size of elements: the one that is given (mm), or found (0). Errors: E187 for one that makes too many."""
    volume = part.guess[0]
    wall = walls_at(part, on_surface(part))
    least = float((part.hi - part.lo).min()) / ACROSS
    wanted = least if wall is None else min(least, wall.wall / THROUGH)
    area = triangles(part, wanted / 2) / _TRIANGLES
    enough = _edge(_UNKNOWNS[order], MOST if size else AFFORDABLE, volume, area)
    if size and size < enough:
        many = _count(_UNKNOWNS[order], size, volume, area)
        raise fail("E187", f"elements of {size:.3g} mm make some {float(f'{many:.2g}'):,.0f} unknowns of this part",
                   hint=f"take some of {1.05 * enough:.2g} mm or more, or a part of it")  # fmt: skip
    return Sized(size or max(wanted, enough), wanted, wall, volume, area, order)


def _count(of: tuple[float, float], size: float, volume: float, area: float) -> int:
    inside, on = of
    return round(inside * volume / size**3 + on * area / size**2)


def _edge(of: tuple[float, float], most: int, volume: float, area: float) -> float:
    """The least size (mm) that makes no more than so many."""
    low, high = 1e-9, 1e9
    for _ in range(100):
        middle = (low * high) ** 0.5
        low, high = (middle, high) if _count(of, middle, volume, area) > most else (low, middle)
    return high
