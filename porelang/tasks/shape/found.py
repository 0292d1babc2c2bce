"""What is known of a mesh that was measured, and what is told of it."""

from __future__ import annotations

from dataclasses import dataclass

from porelang.data import SampledField, Triple, coordinates
from porelang.tasks.told import Doubt, Told

#: Longest sides of parts, in mm: what is smaller or larger may be in another unit.
USUAL = (0.5, 3000.0)
#: More than this share of the surface without samples on both sides of it is no matter of a few sharp tips.
LOST = 0.005
#: An error that is larger than the one asked for by more than this factor is no matter of some seams.
COARSE = 1.25


@dataclass(frozen=True, slots=True)
class Found:
    """What is known of a mesh: in `SampledField.facts`, in this order.

    Its triangles; edges at which no triangle follows, the holes that they make, and the middle of the largest, in mm;
    by how much lookups err at most within some cells of the surface, and by how much nodes err farther away, measured,
    in mm; the corners of the mesh's box; the share of the surface that samples are too far apart for, and a place of
    it; the unit of the file in mm, as it was given or its format says, 0 where neither is so; the triangles
    that stood there again, or had no size, and were left out; by how much lookups were to err, in mm; the flat sheets
    that were left out; the shells within others that are turned as those are; and whether holes are filled by triangles
    that touch nobody.
    """

    triangles: int
    open_edges: int
    holes: int
    largest_hole: Triple
    error: float
    error_beyond: float
    low: Triple
    high: Triple
    lost: float
    lost_at: Triple
    unit: float
    repeated: int = 0
    asked: float = 0.0
    sheets: int = 0
    within: int = 0
    filled: bool = False

    @classmethod
    def of(cls, field: SampledField) -> Found:
        n, edges, holes, x, y, z, error, beyond, a, b, c, d, e, f, lost, p, q, r, unit, *more = field.facts
        repeated, asked, sheets, within, filled = more
        return cls(
            int(n),
            int(edges),
            int(holes),
            (x, y, z),
            error,
            beyond,
            (a, b, c),
            (d, e, f),
            lost,
            (p, q, r),
            unit,
            int(repeated),
            asked,
            int(sheets),
            int(within),
            bool(filled),
        )

    @property
    def size(self) -> Triple:
        x, y, z = (b - a for a, b in zip(self.low, self.high, strict=True))
        return x, y, z


def told_of(field: SampledField) -> Told:
    """How large a mesh is and how well it is known, and what is doubtful about it."""
    found = Found.of(field)
    size = " x ".join(f"{side:.4g}" for side in found.size)
    repeated = f" ({found.repeated:,} of them repeated and left out)" if found.repeated else ""
    note = f"{size} mm, {found.triangles:,} triangles{repeated}, to within {found.error:.2g} mm near its surface"
    if found.sheets:
        what = "a flat sheet that encloses nothing is" if found.sheets == 1 else f"{found.sheets} flat sheets are"
        note += f"; {what} left out"
    if found.within:
        lie = "a shell lies within another, is turned as it is" if found.within == 1 else \
            f"{found.within} shells lie within others, are turned as those are"  # fmt: skip
        note += f"; {lie}, and no cavity: turn its triangles where it is to be one"
    return Told(note, (*_holes(found), *_unit(found), *_lost(found), *_coarse(found)))


def _holes(found: Found) -> list[Doubt]:
    if not found.open_edges:
        return []
    edges = f"{found.open_edges:,} open {'edge' if found.open_edges == 1 else 'edges'}"
    where = f"a hole about ({coordinates(found.largest_hole)})"
    if found.holes > 1:
        where = f"{found.holes:,} holes, the largest about ({coordinates(found.largest_hole)})"
    return [
        Doubt(
            "W232",
            f"this mesh is not watertight: {edges}, round {where}",
            "they are filled by triangles that touch nobody: inside is what these and all others go round"
            if found.filled
            else "closed from the middle of each rim, which is flat for a flat rim",
            "look at the place in a section; where its shape matters, close it in the program that made the mesh",
        )
    ]


def _unit(found: Found) -> list[Doubt]:
    longest = max(found.size)
    if USUAL[0] <= longest <= USUAL[1] or found.unit:
        return []
    small = longest < USUAL[0]
    other = f"`unit=1m` for metres ({1000 * longest:.3g} mm), `unit=1in` for inches" if small else "as `unit=1um`"
    return [
        Doubt(
            "W233",
            f"this mesh is {longest:.3g} mm long: its lengths may be in another unit",
            "lengths in the file are read as mm",
            f"say which: {other}; `unit=1mm` where it is right",
        )
    ]


def _coarse(found: Found) -> list[Doubt]:
    if found.error <= COARSE * found.asked:
        return []
    return [
        Doubt(
            "W242",
            f"this mesh is known to within {found.error:.2g} mm, and {found.asked:.2g} mm are asked for",
            "its triangles cross each other in too many places to be taken apart",
            "unite its shells in the program that made it; walls are to be much thicker than that",
        )
    ]


def _lost(found: Found) -> list[Doubt]:
    if found.lost < LOST:
        return []
    return [
        Doubt(
            "W233",
            f"walls or gaps of this mesh are thinner than its samples, at {found.lost:.0%} of the surface",
            f"at ({coordinates(found.lost_at)}), for one",
            f"give half the thinnest wall as error: it is {found.error:.2g} mm now",
        )
    ]
