"""How fine the elements of a study are, and what that costs: found from the walls of a part before it is meshed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from porelang.analysis.branches import switches
from porelang.diagnostics import fail
from porelang.solid import Solid
from porelang.walls import Thinnest, rounded, triangles, walls_of

#: Walls are to be so many elements thick.
THROUGH = 2.0
#: Elements through the least side of a part without walls.
ACROSS = 10.0
#: Elements of order 2 are found so fine that there are no more unknowns than this: a minute or so. More are for who
#: gives a size, up to the most that a machine with 8 GB takes; and some where walls would fall into pieces otherwise.
AFFORDABLE, HOLDING, MOST = 800_000, 2_500_000, 4_000_000
#: Elements and unknowns of the first and of the second order: for every cube of an edge in the part, and for every
#: square of it on its surface (measured: cylinders, boxes, gyroids).
_TETRAHEDRA = 12.0, 3.0
_UNKNOWNS = {1: (6.0, 3.0), 2: (48.0, 18.0)}
#: Triangles of marching cubes for every square of the voxel on a surface: the mean of |n|_1 is 3/2.
_TRIANGLES = 3.0
#: How many times as many as that parts have at most whose rims ask for smaller elements (measured: IWPs in a
#: cylinder, walls of two elements and less, 3.5 and 5.4).
HALVED = 6.0
#: Seconds for an unknown: meshing, assembly and solution (measured, two cores).
_SECONDS = {1: 4e-5, 2: 5e-5}


@dataclass(frozen=True)
class Sized:
    """Elements of an edge `size` (mm) for a part of a volume (mm3) and an area (mm2), of which walls ask for `wanted`
    (mm); the thinnest `wall` that bears, None where there are none. Of a graded mesh `size` is that of the largest, and
    `finest` that of the smallest; where rims ask for smaller ones there may be `rims` times as many, else 0; so many
    cubes are `halved` there, to `least` (mm)."""

    size: float
    wanted: float
    wall: Thinnest | None
    volume: float
    area: float
    order: int
    finest: float = 0.0
    rims: float = 0.0
    halved: int = 0
    least: float = 0.0

    @property
    def span(self) -> str:
        """From which size to which elements are, without the unit."""
        return f"{f'{self.finest:.3g} to ' if self.finest else ''}{self.size:.3g}"

    @property
    def finer(self) -> str:
        """What to do where elements are too coarse for walls, and what that takes."""
        if self.wall is None or self.wall.wall >= THROUGH * self.size:
            return f"take finer elements, `size={rounded(self.size / 2)}mm`"
        return for_walls(self.wall.wall, lambda size: unknowns(size, self.volume, self.area, self.order))

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
        return seconds(self.unknowns, self.order)


def for_walls(wall: float, unknowns: Callable[[float], float]) -> str:
    """What to do where the thinnest walls (mm) are thinner than two elements: which size makes two, and how many
    `unknowns` that takes; where these are too many, which size holds the walls together."""
    two = float(rounded(wall / THROUGH))
    said = f"`size={two:g}mm` makes two through walls of {wall:.2g} mm: some {many(unknowns(two))} unknowns"
    if unknowns(two) <= MOST:
        return said
    said += f", and {MOST / 1e6:g} million are the most: "
    one = float(rounded(wall))
    if unknowns(one) > MOST:
        return f"{said}take a part of it"
    return f"{said}take a part of it, or `size={one:g}mm`, one element through them, some {many(unknowns(one))}"


def many(count: float) -> str:
    """A number of things to two figures."""
    return f"{float(f'{count:.2g}'):,.0f}"


def unknowns(size: float, volume: float, area: float, order: int) -> float:
    """About how many unknowns elements of a size (mm) have in a part of a volume (mm3) and an area (mm2)."""
    return _count(_UNKNOWNS[order], size, volume, area)


def seconds(unknowns: float, order: int) -> float:
    """About how long a study of so many unknowns takes."""
    return _SECONDS[order] * unknowns


def duration(seconds: float) -> str:
    """A time in words."""
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} minutes"


def sized(part: Solid, size: float, order: int) -> Sized:
    """The size of elements: the one that is given (mm), or found (0). Errors: E187 for one that makes too many, or
    none that has to do with the part."""
    sides = part.hi - part.lo
    if size > float(sides.max()) * (1 + 1e-9):
        reach = " x ".join(f"{s:.4g}" for s in sides)
        raise fail("E187", f"elements of {size:.4g} mm are larger than the part, which has {reach} mm",
                   hint=f"give a size in mm, such as `size={rounded(float(sides.min()) / ACROSS)}mm`, or leave it out: "
                   "one is found")  # fmt: skip
    volume = part.guess[0]
    # what is found by itself is finer where a shape cuts a lattice to feathers: a minute's elements are affordable
    narrow, wall = walls_of(part)
    least = float(sides.min()) / ACROSS
    wanted = least if narrow is None else min(least, narrow.wall / THROUGH)
    area = triangles(part, wanted / 2) / _TRIANGLES
    enough = _edge(_UNKNOWNS[order], MOST, volume, area)
    if size and size < enough:
        too_many = many(_count(_UNKNOWNS[order], size, volume, area))
        raise fail("E187", f"elements of {size:.3g} mm make some {too_many} unknowns of this part",
                   hint=f"take some of {1.05 * enough:.2g} mm or more, or a part of it")  # fmt: skip
    affordable = _edge(_UNKNOWNS[order], AFFORDABLE, volume, area)
    if narrow is not None and _edge(_UNKNOWNS[order], HOLDING, volume, area) <= narrow.wall:
        affordable = min(affordable, narrow.wall)  # elements that are larger than a wall do not hold it together
    rims = HALVED if switches(part.formula) else 0.0
    return Sized(size or max(wanted, affordable), wanted, wall, volume, area, order, rims=rims)


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
