"""What a study tells of itself: a line, and what is doubtful about it."""

from __future__ import annotations

from math import prod

from porelang.data import SampledField, coordinates, figures
from porelang.materials import DENSEST, STIFFEST
from porelang.tasks.study.coarse import coarse, finer
from porelang.tasks.study.got import Got
from porelang.tasks.told import Doubt, Told

#: Displacements of so much of a part, and strains of as much, are not small.
SMALL = 0.1
#: Pieces that are left out, of so much of the volume, are doubted.
_LOST = 0.001
#: Numbers of stiffness that may err by so much for two materials in one element are doubted.
_SHARED = 0.01
#: Lookups that miss the elements by so much of the greatest stress are doubted, where one in twenty does.
_COARSE = 0.1
#: More than this share of lookups that miss are the reason why.
_HALF = 0.5
#: Samples of more than this share of the nodes that there may be are as fine as they can be.
_FULL = 0.8


def told(found: SampledField) -> Told:
    """What a study tells of itself: a line, and what is doubtful about it."""
    got = Got.of(found)
    error = got.number("error").value
    note = (
        f"{got.elements:,} elements of {got.span} mm, {got.unknowns:,} unknowns, {got.iterations} iterations to a "
        f"residual of {got.residual:.1g}; stresses err by {error:.2%} in energy (Zienkiewicz and Zhu); sampled every "
        f"{got.voxel:.3g} mm, and beyond the part as at the nearest place of it"
    )
    doubts = coarse(got)
    if got.lost > _LOST:
        said = f"{got.pieces} pieces that hang on nothing, {got.lost:.1%} of the part, are left out of this study"
        hint = "a lattice that is cut by a shape leaves such: thicken it, or see `pore measure` for its pieces"
        doubts.append(Doubt("W266", said, "only the largest piece is loaded", hint))
    doubts += _of_materials(got)
    most = got.number("max_von_mises").value
    if got.off > _COARSE * most:
        said = f"a lookup in twenty misses the stress in the elements by {got.off / most:.0%} of the greatest or more"
        doubts.append(Doubt("W267", said, f"sampled every {got.voxel:.3g} mm", _why_missed(got, found)))
    return Told(note, (*doubts, *_beyond(got)))


def _why_missed(got: Got, found: SampledField) -> str:
    """What to do where lookups miss the stress in the elements, by what the reason is."""
    if got.jumps > _HALF:
        return (
            "stress jumps where the material does, and a sample beside that lies between both sides: read none there, "
            "or let the material change over a width, as with `mix`; `pore fea` writes the elements"
        )
    from porelang.tasks.study.samples import NODES

    if prod(found.shape) > _FULL * NODES:
        return "elements are finer than its samples can be: take a part of it, or `pore fea` for the elements"
    return f"stress changes much within an element: {finer(got)}"


def _of_materials(got: Got) -> list[Doubt]:
    """What is doubtful about elements that stand for two materials."""
    if got.shared <= _SHARED:
        return []
    at = coordinates((got.seam_x, got.seam_y, got.seam_z))
    said = f"the material changes within elements, as at ({at}): each has that of its middle"
    label = f"its stiffness may be off by {got.shared:.1%} for that, and stresses there by more"
    return [Doubt("W283", said, label, f"{finer(got)}; or let it change over a width, as with `mix`")]


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
