"""What a study has come to: kept with its samples, and the numbers that it gives."""

from __future__ import annotations

from dataclasses import astuple, dataclass, fields

from porelang.data import Reduced, SampledField
from porelang.ops.studies import NUMBERS

#: Facts that count.
_WHOLE = 3


@dataclass(frozen=True, slots=True)
class Got:
    """What is known of a study: in `SampledField.facts`, in this order.

    Elements and unknowns; iterations of the solver and the residual that they left; the order of elements; their size
    in mm, that of the smallest where it is graded (0: it is not), and near the thinnest wall; how thick the thinnest
    walls are, in mm (0: none are found), and a place on one; how wide a gap is that elements close, in mm (0: they
    close none), over how much of it, whether it tapers (1), of how many it is the largest, and a place in it; the
    area of the surface in mm2; the greatest displacement over the longest side of the part, and the mean strain (in
    energy); the greatest Young's modulus (MPa) and density (g/cm3) of those that the text does not show (0: it does);
    where the material yields (MPa, 0: it is not known); which share of the volume was left out, in how many pieces;
    the spacing of samples, in mm; by how much lookups of von Mises' stress miss the elements, 95 % of them by less,
    and which share of the others lies at jumps of the material; by which share numbers of stiffness err for what
    elements miss of the part: what they lack of it and hold beyond it in mm3, by how many holes they differ from how
    many, and where it is worst; by which share they err for two materials in one element, and where; then the numbers
    of `porelang.ops.studies`, and their errors.
    """

    elements: int
    unknowns: int
    iterations: int
    residual: float
    order: float
    size: float
    finest: float
    beside: float
    wall: float
    wall_x: float
    wall_y: float
    wall_z: float
    gap: float
    gap_long: float
    gap_across: float
    gap_tapers: float
    gap_of: float
    gap_x: float
    gap_y: float
    gap_z: float
    area: float
    moved: float
    strain: float
    stiffest: float
    densest: float
    yields: float
    lost: float
    pieces: int
    voxel: float
    off: float
    jumps: float
    form: float
    lacking: float
    beyond: float
    handles: float
    holes: float
    form_x: float
    form_y: float
    form_z: float
    shared: float
    seam_x: float
    seam_y: float
    seam_z: float
    numbers: tuple[float, ...]
    errors: tuple[float, ...]

    @property
    def span(self) -> str:
        """From which size to which elements are, without the unit."""
        return f"{f'{self.finest:.3g} to ' if self.finest else ''}{self.size:.3g}"

    @property
    def facts(self) -> tuple[float, ...]:
        """All of it as numbers."""
        *head, numbers, errors = astuple(self)
        return tuple(map(float, (*head, *numbers, *errors)))

    @classmethod
    def of(cls, found: SampledField) -> Got:
        head, count = len(fields(cls)) - 2, len(NUMBERS)
        whole = [int(v) for v in found.facts[:_WHOLE]]
        known = dict(zip([f.name for f in fields(cls)][:head], [*whole, *found.facts[_WHOLE:head]], strict=True))
        known["pieces"] = int(known["pieces"])
        return cls(**known, numbers=found.facts[head : head + count], errors=found.facts[head + count :])  # type: ignore[arg-type]  # those that count are whole

    def number(self, name: str) -> Reduced:
        """A number of a study, with its error."""
        i = list(NUMBERS).index(name)
        return Reduced(self.numbers[i], self.errors[i])
