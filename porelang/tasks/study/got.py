"""What a study has come to: kept with its samples, told by the commands that read it, and the numbers that it gives."""

from __future__ import annotations

from dataclasses import astuple, dataclass, fields

from porelang.data import Reduced, SampledField, coordinates, figures
from porelang.materials import DENSEST, STIFFEST
from porelang.ops.studies import NUMBERS
from porelang.tasks.study.sized import THROUGH, for_walls
from porelang.tasks.told import Doubt, Told

#: A result that is estimated to err by so much, in the energy of its stresses, is doubted.
ERRS = 0.1
#: Displacements of so much of a part, and strains of as much, are not small.
SMALL = 0.1
#: Pieces that are left out, of so much of the volume, are doubted.
_LOST = 0.001
#: Facts that count.
_WHOLE = 3
#: Numbers of stiffness that may err by so much for what elements miss of a part, or for two materials in one, are
#: doubted.
_FORM, _SHARED = 0.06, 0.01
#: Lookups that miss the elements by so much of the greatest stress are doubted, where one in twenty does.
_COARSE = 0.1


@dataclass(frozen=True, slots=True)
class Got:
    """What is known of a study: in `SampledField.facts`, in this order.

    Elements and unknowns; iterations of the solver and the residual that they left; the size of elements in mm, of
    the smallest where it is graded (0: it is not), and near the thinnest wall; how thick the thinnest walls are, in mm
    (0: none are found), and a place on one; how many unknowns there are with two elements through these; the greatest
    displacement over the longest side of the part, and the mean strain (in energy); the greatest Young's modulus (MPa)
    and density (g/cm3) of those that the text does not show (0: it does); where the material yields (MPa, 0: it is not
    known); which
    share of the volume was left out, in how many pieces; the spacing of samples, in mm; by how much lookups of von
    Mises' stress miss the elements, 95 % of them by less; by which share numbers of stiffness err for what elements
    miss of the part: what they lack of it and hold beyond it in mm3, by how many holes they differ from how many, and
    where it is worst; by which share they err for two materials in one element, and where; then the numbers of
    `porelang.ops.studies`, and their errors.
    """

    elements: int
    unknowns: int
    iterations: int
    residual: float
    size: float
    finest: float
    beside: float
    wall: float
    wall_x: float
    wall_y: float
    wall_z: float
    through: float
    moved: float
    strain: float
    stiffest: float
    densest: float
    yields: float
    lost: float
    pieces: int
    voxel: float
    off: float
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


def told(found: SampledField) -> Told:
    """What a study tells of itself: a line, and what is doubtful about it."""
    got = Got.of(found)
    error = got.number("error").value
    span = f"{f'{got.finest:.3g} to ' if got.finest else ''}{got.size:.3g}"
    note = (
        f"{got.elements:,} elements of {span} mm, {got.unknowns:,} unknowns, {got.iterations} iterations to a "
        f"residual of {got.residual:.1g}; stresses err by {error:.2%} in energy (Zienkiewicz and Zhu); sampled every "
        f"{got.voxel:.3g} mm, and beyond the part as at the nearest place of it"
    )
    doubts: list[Doubt] = []
    finer = _smaller(got)
    if error > ERRS:
        said = f"stresses of this study err by about {error:.0%}"
        doubts.append(Doubt("W264", said, "estimated from how they jump between elements", finer))
    if got.wall and got.wall < THROUGH * got.beside * (1 - 1e-9):
        at = ", ".join(f"{v:.4g}" for v in (got.wall_x, got.wall_y, got.wall_z))
        said = f"walls {got.wall:.3g} mm thick, as at ({at}), are thinner than two elements of {got.beside:.3g} mm"
        hint = for_walls(got.wall, got.through)
        doubts.append(Doubt("W265", said, "stiffness and stresses are unsure there", hint))
    if got.lost > _LOST:
        said = f"{got.pieces} pieces that hang on nothing, {got.lost:.1%} of the part, are left out of this study"
        hint = "a lattice that is cut by a shape leaves such: thicken it, or see `pore measure` for its pieces"
        doubts.append(Doubt("W266", said, "only the largest piece is loaded", hint))
    doubts += _of_form(got)
    most = got.number("max_von_mises").value
    if got.off > _COARSE * most:
        said = f"a lookup in twenty misses the stress in the elements by {got.off / most:.0%} of the greatest or more"
        hint = "elements are finer than its samples can be: take a part of it, or `pore fea` for the elements"
        doubts.append(Doubt("W267", said, f"sampled every {got.voxel:.3g} mm", hint))
    return Told(note, (*doubts, *_beyond(got)))


def _of_form(got: Got) -> list[Doubt]:
    """What is doubtful about what elements stand for: the part, and its materials."""
    doubts = []
    if got.form > _FORM:
        at = coordinates((got.form_x, got.form_y, got.form_z))
        said = f"elements lack {got.lacking:.3g} mm3 of the part and hold {got.beyond:.3g} mm3 beyond it, as at ({at})"
        if got.handles:
            said += f"; by {got.handles:.0f} of {got.holes:.0f} holes they are joined otherwise"
        label = f"its stiffness may be off by {got.form:.0%} for that, and is stated so"
        doubts.append(Doubt("W282", said, label, f"{_smaller(got)}, or refine there, `pore fea --refine`"))
    if got.shared > _SHARED:
        at = coordinates((got.seam_x, got.seam_y, got.seam_z))
        said = f"the material changes within elements, as at ({at}): each has that of its middle"
        label = f"its stiffness may be off by {got.shared:.1%} for that, and stresses there by more"
        doubts.append(Doubt("W283", said, label, f"{_smaller(got)}, or let it change over a width, as with `mix`"))
    return doubts


def _smaller(got: Got) -> str:
    return f"take finer elements, `size={got.size / 1.5:.2g}mm`"


def _beyond(got: Got) -> list[Doubt]:
    """What the numbers of a study are too large for: a material, small displacements, what it bears."""
    doubts: list[Doubt] = []
    for limit, value in ((STIFFEST, got.stiffest), (DENSEST, got.densest)):
        if value > limit.value:
            doubts.append(Doubt("W273", limit.said(value), limit.why, limit.hint(value)))
    if max(got.moved, got.strain) > SMALL:
        longest = got.number("max_displacement").value / got.moved
        said = f"the part is displaced by {got.number('max_displacement').value:.3g} mm, and is {longest:.3g} mm long"
        if got.strain > got.moved:
            said = f"the part is strained by {got.strain:.3g} in the mean"
        hint = "bare numbers are N, MPa and mm: look at the units; a smaller load has proportional results"
        doubts.append(Doubt("W274", said, "linear elasticity does not hold where shapes change so much", hint))
    most = got.number("max_von_mises")
    if got.yields and most.value - most.error > got.yields:
        said = f"von Mises' stress is {figures(most.value, most.error)} MPa, and this material yields at {got.yields:g}"
        hint = "give it more section or less load; of another grade give `E`, `nu` and `density` in place of `material`"
        doubts.append(Doubt("W275", said, "what yields is not elastic", hint))
    return doubts
