"""What is doubtful about a loop of a program, told at its end: what it gained, its record, its best step."""

from __future__ import annotations

from porelang.diagnostics import Diagnostic
from porelang.optimize import loop
from porelang.optimize.adapting import Adapting
from porelang.source import Span

#: What all is compared with is doubted where its mesh strays by more than this share, and by so many times that of the
#: best step: its elements are joined otherwise, and those of the best are not.
STRAYS, TIMES = 0.06, 2.0
#: What rises by more than these shares, and by so many times what was gained, is told: a greatest displacement, and a
#: greatest stress, which another mesh alone moves by some ten per cent.
MOVES, STRESSES, MUCH = 0.1, 0.5, 2.0
#: What varies by less than this over cells is nearly uniform: of columns of P and gyroid between frictionless platens,
#: uniform but for their few cells, it is .019 and .041, and a step gains .02 and .4 %.
NEARLY = 0.05


def doubts(what: Adapting, found: loop.Outcome, cell: float, until: float, optimal: bool) -> list[Diagnostic]:
    """Of a loop that averaged over a cell in mm, and was to end where a step changed less than `until`; `optimal` where
    it began with the optimum of the homogenised part."""
    return [
        *_gained(what, found, cell, until, optimal),
        *_ended(what, found),
        *_of_the_best(what, found),
        *_of_the_start(what, found),
    ]


def _gained(what: Adapting, found: loop.Outcome, cell: float, until: float, optimal: bool) -> list[Diagnostic]:
    place = what.design.program.data[what.param].span
    first = found.steps[0]
    stiffest = min(found.steps, key=lambda step: step.softness)
    gained, apart = 1 - stiffest.softness / first.softness, loop.ratio_error(first, stiffest)
    if found.reason == "uniform" and found.best == 0 and stiffest is first:
        known = max(first.noise, loop.UNIFORM)
        return [Diagnostic(
            "W268", f"what `{what.output}` bears is uniform: it varies by {first.spread:.1%} over cells of "
            f"{cell:.4g} mm, known to {known:.1%}", place, "there is nothing to adapt to", severity="warning",
            hint="finer elements may tell more; and a dense core in a light skin may still be stiffer: "
            "--rule optimum looks for it")]  # fmt: skip
    if found.best == 0 and len(found.steps) > 1 and gained < until and first.spread < NEARLY:
        said = f"a step gains {gained:.2%}" if gained > 0 else "no step gains anything"
        return [Diagnostic(
            "W268", f"what `{what.output}` bears is nearly uniform: it varies by {first.spread:.1%} over cells of "
            f"{cell:.4g} mm, and {said}", place, "there is nothing to adapt to", severity="warning",
            hint="leave it as it is: no finer elements change that" if optimal else
            "a dense core in a light skin may still be stiffer: --rule optimum looks for it")]  # fmt: skip
    if found.best == 0 and gained > 0:
        return [Diagnostic(
            "W270", f"the gain of {gained:.1%} in step {stiffest.number} is less than meshes of this part differ by, "
            f"{apart:.1%}", place, "the start is kept", severity="warning",
            hint="take finer elements: `size=` of the study")]  # fmt: skip
    if found.best == 0 and len(found.steps) > 1:
        return [Diagnostic(
            "W269", f"no step was stiffer than the uniform `{what.output}`", place, "the start is kept",
            severity="warning",
            hint="begin with --rule energy on the lattice itself: it sees the cells as they are, which the homogenised "
            "lattice does not" if optimal else
            "take less of each change, as in --damping 0.5, or wider limits")]  # fmt: skip
    return _worse(found, 1 - found.gain, place)


def _worse(found: loop.Outcome, gained: float, place: Span | None) -> list[Diagnostic]:
    """What became much more while the compliance became little less: the rules look at that alone."""
    first, best = found.steps[0], found.steps[found.best]
    if found.best == 0 or first.under != "forces":  # under displacements that are prescribed both are of other forces
        return []
    moved, stressed = (getattr(best, key) / getattr(first, key) - 1 for key in ("max_displacement", "max_von_mises"))
    said = [
        f"the greatest {name} rises by {rise:.0%}"
        for name, rise, least in (("displacement", moved, MOVES), ("von Mises' stress", stressed, STRESSES))
        if rise > max(least, MUCH * gained)
    ]
    if not said:
        return []
    return [Diagnostic(
        "W290", f"{' and '.join(said)} in step {best.number}, where the compliance falls by {gained:.1%}", place,
        "the rules make the work of the loads less, and nothing else", severity="warning",
        hint="look at it before it is made, `pore fea` of the part; narrower limits change less")]  # fmt: skip


def _ended(what: Adapting, found: loop.Outcome) -> list[Diagnostic]:
    out = []
    if found.missed:
        out.append(Diagnostic(
            "W272", f"the record was damaged: {found.missed}", None, severity="warning",
            hint="nothing is left to do: its files are whole again"))  # fmt: skip
    if found.reason == "failed":
        count = len(found.steps)
        place = what.design.program.places.get(what.design.program.studies[what.study])
        why = "; ".join(f"{d.code}: {d.message}" for d in found.failed)
        kept = "the start" if found.best == 0 else f"step {found.best}, the best so far,"
        out.append(Diagnostic(
            "W277", f"step {count} could not be solved, so that the loop ended: {why}", place, f"{kept} is kept",
            severity="warning",
            hint="take finer elements, `size=` of the study, or narrower limits, and begin anew with --force; --resume "
            "tries that step again"))  # fmt: skip
    return out


def _of_the_best(what: Adapting, found: loop.Outcome) -> list[Diagnostic]:
    """What the study of the best step doubts of itself."""
    place = what.design.program.places.get(what.design.program.studies[what.study])
    return [
        Diagnostic(code, f"in step {found.best}, which is kept: {said}", place, label, hint=hint, severity="warning")
        for code, said, label, hint in found.steps[found.best].doubts
    ]


def _of_the_start(what: Adapting, found: loop.Outcome) -> list[Diagnostic]:
    """What of the uniform part makes the ratio to it unsure, where the best step is known far better."""
    first, best = found.steps[0], found.steps[found.best]
    if found.best == 0 or (first.apart or 0.0) <= max(STRAYS, TIMES * (best.apart or 0.0)):
        return []
    place = what.design.program.places.get(what.design.program.studies[what.study])
    return [
        Diagnostic(code, f"in step 0, which all is compared with: {said}", place, label, hint=hint, severity="warning")
        for code, said, label, hint in first.doubts
        if code == "W284"
    ]
