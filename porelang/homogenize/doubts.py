"""What is doubtful of a homogenised period: pieces that hang by nothing, and voxels that are too coarse."""

from __future__ import annotations

import math
from collections.abc import Sequence

from porelang.diagnostics import Diagnostic
from porelang.homogenize.cell import place
from porelang.homogenize.found import Homogenized
from porelang.unitcell.extrapolate import SMOOTH
from porelang.unitcell.moduli import NAMED
from porelang.unitcell.pieces import Piece

#: A relative error above which is said that the voxels are too coarse, and how many a wall wants.
COARSE, TO_A_WALL = 0.1, 3.0
#: What an error is told of at least, as shares: of the greatest E, whatever modulus it is; and of the greatest E along
#: the axes, for E across them and G. Of struts along the axes G is a hundredth of E, and what it errs by moves nothing.
SMALL, ACROSS = 0.1, 0.5
#: Walls of fewer samples may come apart between them.
_SURE = 2.0


def doubts_of(
    found: Homogenized, by_signs: Sequence[Piece], samples: tuple[int, int, int], most: int
) -> list[Diagnostic]:
    """Warnings about what was found. `by_signs` are the pieces of samples that are solid, those with a common face
    being one; `samples` are those of the cell along each axis, `most` the voxels that there can be along one.

    What hangs together as voxels do, by common nodes, is what resists; samples tell a narrow gap that voxels bridge,
    and may miss a thin wall that voxels have. Only where both agree, or walls are thick enough, is it sure.
    """
    islands = [p for p in found.pieces if not any(p.leads)]
    closed = _closed(found.pieces)
    spacing = max(c / n for c, n in zip(found.cell, samples, strict=True) if n > 2) if max(samples) > 2 else 0.0
    sure = found.wall is None or found.wall >= _SURE * spacing
    out = []
    if islands and sure:
        out.append(_apart(found, islands))
    if closed:
        out.append(Diagnostic(
            "W262", f"no solid leads from one cell to the next along {' and '.join(closed)}: there is no stiffness "
            "that way", severity="warning",
            hint="a thicker wall may join them; or the cell is not the period that is meant"))  # fmt: skip
    return out + _coarse(found, islands, closed, by_signs, sure, most)


def _closed(pieces: Sequence[Piece]) -> list[str]:
    return [axis for i, axis in enumerate("xyz") if not any(p.leads[i] for p in pieces)]


def _apart(found: Homogenized, islands: list[Piece]) -> Diagnostic:
    share = sum(p.share for p in islands)
    at = place(found.place(islands[0].at))
    if len(islands) == len(found.pieces):
        what = "all of the solid hangs by nothing" + (f", in {len(islands)} pieces" if len(islands) > 1 else "")
    else:
        many, hang = ("a piece", "hangs") if len(islands) == 1 else (f"{len(islands)} pieces", "hang")
        what = f"{many} of the solid, {share:.2g} of it, {hang} by nothing"
    return Diagnostic("W261", f"{what}: the largest at {at}", severity="warning",
                      hint="it carries nothing and counts as density; take it off, or join it to the rest")  # fmt: skip


def _coarse(
    found: Homogenized, islands: list[Piece], closed: list[str], by_signs: Sequence[Piece], sure: bool, most: int
) -> list[Diagnostic]:
    """That voxels are too coarse: for what hangs together, or for a number that is printed."""
    finest = max(found.levels[-1].voxels)
    share = "half, as the solid has edges inwards" if min(found.orders) < min(SMOOTH) else "a quarter"
    wanted, why = 2 * finest, f"of twice as many the error is about {share}"
    if found.through is not None and found.through < TO_A_WALL:
        wanted = max(wanted, 8 * math.ceil(TO_A_WALL * finest / found.through / 8))
        why = f"a wall wants three voxels, and has {found.through:.2g} here"
    hint = f"use --resolution {min(most, wanted)}: {why}" if finest < most else f"{why}; take a cell of one period"
    out = []
    loose = [p for p in by_signs if not any(p.leads)]
    if (len(loose) > len(islands) or _closed(by_signs) != closed) or (islands and not sure):
        seen = (
            f"{len(loose)} pieces hang by nothing"
            if loose
            else f"nothing leads on along {' and '.join(_closed(by_signs))}"
        )
        out.append(Diagnostic(
            "W263", f"{finest} voxels along the cell do not tell whether the solid hangs together: as samples see it "
            f"{seen}, as voxels {_together(islands, closed)}", severity="warning",
            hint=f"{hint}; if gaps are there, the moduli are too high"))  # fmt: skip
    worst, most_off = "", COARSE
    stiffest, along = (max(found.numbers[f"E.{key}"] for key in keys) for keys in (NAMED, ("100", "010", "001")))
    for name, value in found.numbers.items():
        if name[0] not in "EGbc" or not value > 0:
            continue
        least = 0.0 if name == "conductivity" else SMALL * stiffest
        if name[0] == "G" or name in ("E.110", "E.111"):
            least = max(least, ACROSS * along)
        off = found.errors[name] / max(value, least)
        if off > most_off:
            worst, most_off = name, off
    if worst:
        what = {"E": "E along ", "G": "G in "}.get(worst[0], "the ") + (worst[2:] if worst[0] in "EG" else worst)
        error = found.errors[worst]
        out.append(Diagnostic(
            "W263", f"{finest} voxels along the cell are too coarse: {what} is {found.numbers[worst]:.3g} "
            f"+- {error:.2g}", severity="warning", hint=hint))  # fmt: skip
    return out


def _together(islands: list[Piece], closed: list[str]) -> str:
    if not islands and not closed:
        return "all of it is one"
    apart = f"{len(islands)} do" if islands else "none do"
    return f"{apart}, and {'nothing leads on along ' + ' and '.join(closed) if closed else 'it leads on along x, y, z'}"
