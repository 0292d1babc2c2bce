"""How fine the elements of a study are, and what that costs: found from the walls of a part before it is meshed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from porelang.diagnostics import fail
from porelang.solid import Solid
from porelang.tasks.study.got import THROUGH
from porelang.walls import Thinnest, on_surface, walls_at

#: Elements through the least side of a part without walls.
ACROSS = 10.0
#: Elements of order 2 are found so fine that there are no more unknowns than this: a minute or so. More are for who
#: gives a size, up to the most that a machine with 16 GB takes.
AFFORDABLE, MOST = 250_000, 3_000_000
#: Unknowns of elements of the first and of the second order, for every cube of an edge (measured: a cylinder, a gyroid).
_UNKNOWNS = {1: 7.0, 2: 50.0}
_TETRAHEDRA = 12.0
#: Seconds for an unknown: meshing, assembly and solution (measured, two cores).
_SECONDS = {1: 1e-4, 2: 1.2e-4}


@dataclass(frozen=True)
class Sized:
    """Elements of an edge `size` (mm) for a part of a volume (mm3), of which walls ask for `wanted` (mm); the thinnest
    of them, None where there are none."""

    size: float
    wanted: float
    wall: Thinnest | None
    volume: float
    order: int

    @cached_property
    def elements(self) -> int:
        """About how many there are."""
        return round(_TETRAHEDRA * self.volume / self.size**3)

    @cached_property
    def unknowns(self) -> int:
        """About how many there are."""
        return round(_UNKNOWNS[self.order] * self.volume / self.size**3)

    @cached_property
    def seconds(self) -> float:
        """About how long a study takes."""
        return _SECONDS[self.order] * self.unknowns


def sized(part: Solid, size: float, order: int) -> Sized:
    """The size of elements: the one that is given (mm), or found (0). Errors: E188 for one that makes too many."""
    volume = part.guess[0]
    wall = walls_at(part, on_surface(part))
    least = float((part.hi - part.lo).min()) / ACROSS
    wanted = least if wall is None else min(least, wall.wall / THROUGH)
    if size:
        found = Sized(size, wanted, wall, volume, order)
        if found.unknowns > MOST:
            enough = _edge(volume, MOST, order)
            raise fail("E188", f"elements of {size:.3g} mm make some {found.unknowns:,} unknowns of this part",
                       hint=f"take some of {1.05 * enough:.2g} mm or more, or a part of it")  # fmt: skip
        return found
    return Sized(max(wanted, _edge(volume, AFFORDABLE, order)), wanted, wall, volume, order)


def _edge(volume: float, unknowns: int, order: int) -> float:
    return float((_UNKNOWNS[order] * volume / unknowns) ** (1 / 3))
