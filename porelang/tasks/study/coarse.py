"""Whether the elements of a study are too coarse for it, for what, and which size would do: one warning, one size."""

from __future__ import annotations

import numpy as np

from porelang.data import coordinates
from porelang.tasks.study.got import Got
from porelang.tasks.study.sized import AFFORDABLE, HALVED, MOST, THROUGH, duration, many, seconds, unknowns
from porelang.tasks.told import Doubt
from porelang.tet.gap import OPEN, Gap
from porelang.tet.gap import told as said_of
from porelang.walls import rounded

#: A result that is estimated to err by so much, in the energy of its stresses, is doubted.
ERRS = 0.1
#: Numbers of stiffness that may err by so much for what elements miss of a part are doubted.
FORM = 0.06
#: What is proposed does a little more than it has to, and no estimate is followed farther than to this share of a size.
_ROOM, _FARTHEST = 0.95, 1 / 4
#: A size that is less than so much finer helps too little; counts are estimates, and so much more is still affordable.
_HELPS, _ABOUT = 1.15, 1.5
#: A length rounded to two figures, and not up, is no more than so much shorter.
_UP = 1.1


def coarse(got: Got) -> list[Doubt]:
    """W284 where elements miss the part, close its gaps, are too large for its walls, or do not show its stresses: all
    that is so of these in one, with a size that mends it, or the finest that helps and can be had."""
    found = [*_gaps(got), *_form(got), *_walls(got), *_stresses(got)]
    if not found:
        return []
    whats, labels = [what for what, _ in found], [label for _, label in found]
    return [Doubt("W284", f"elements of {got.span} mm are too coarse: {'; '.join(whats)}", labels[0], finer(got))]


def finer(got: Got) -> str:
    """Which size of elements to take, and what that takes: the one proposal, whatever it is that asks for it."""
    said = _finer(got)
    if got.gap_tapers:
        said += "; what narrows to nothing stays closed near its end at any size: separate it, or join it"
    return said


def _finer(got: Got) -> str:
    size = float(rounded(_wanted(got)))
    count = _unknowns(got, size)
    if count <= _ABOUT * AFFORDABLE:
        return f"take finer elements: `size={size:g}mm` makes some {many(count)} unknowns, {_time(got, count)}"
    if got.gap and not (got.gap_tapers or _form(got) or _walls(got) or _stresses(got)):  # a gap is open or not
        return f"to open it takes `size={size:g}mm` and some {many(count)} unknowns: leave it out, or take a part of it"
    least = float(rounded(_UP * _least(got)))
    if got.size >= _HELPS * least:
        few = _unknowns(got, least)
        return (
            f"take finer elements: `size={least:g}mm` helps, with some {many(few)} unknowns, {_time(got, few)}; to "
            f"mend all of it takes {size:g} mm and {many(count)}"
        )
    if count <= MOST:
        return f"`size={size:g}mm` takes some {many(count)} unknowns, {_time(got, count)}"
    return (
        f"finer elements in all of it are more than {MOST / 1e6:g} million unknowns: take a part of it, or make them "
        "finer where they err, `pore fea --refine`"
    )


def _form(got: Got) -> list[tuple[str, str]]:
    if got.form <= FORM:
        return []
    at = coordinates((got.form_x, got.form_y, got.form_z))
    said = f"they lack {got.lacking:.3g} mm3 of the part and hold {got.beyond:.3g} mm3 beyond it, as at ({at})"
    if got.handles and not got.gap:  # which makes holes where cubes leave it open in places
        said += f", and are joined otherwise: their holes are {got.handles:.0f} more or less than its {got.holes:.0f}"
    stated = "is stated so" if not got.gap else "by more for the gap"
    return [(said, f"its stiffness may be off by {got.form:.0%} for what they miss, and {stated}")]


def _gaps(got: Got) -> list[tuple[str, str]]:
    """What elements join is stiffer by an amount that they do not know."""
    if not got.gap:
        return []
    gap = Gap(got.gap, (got.gap_long, got.gap_across), np.array([got.gap_x, got.gap_y, got.gap_z]),
              got.gap_tapers > 0, int(got.gap_of))  # fmt: skip
    return [(said_of(gap), "what they fill there is stiffer, and no error that is stated says by how much")]


def _walls(got: Got) -> list[tuple[str, str]]:
    if not got.wall or got.wall >= THROUGH * got.beside * (1 - 1e-9):
        return []
    at = coordinates((got.wall_x, got.wall_y, got.wall_z))
    of = f"elements of {got.beside:.3g} mm there" if got.finest else "of them"
    return [(f"walls {got.wall:.3g} mm thick, as at ({at}), are thinner than two {of}",
             "stiffness and stresses are unsure where walls are thin")]  # fmt: skip


def _stresses(got: Got) -> list[tuple[str, str]]:
    error = got.number("error").value
    if error <= ERRS:
        return []
    return [(f"stresses err by about {error:.0%}", "estimated from how stresses jump between elements")]


def _wanted(got: Got) -> float:
    """The size (mm) that mends what is too coarse, as far as that can be told.

    The estimate of the error goes by the size where edges and rims are sharp, as those of a lattice in its envelope
    are (measured: 32.5, 23.6, 17.8, 12.6 % of a gyroid in a box at 2.6, 1.9, 1.4, 1 mm). What is missed goes so at
    least.
    """
    share = min(_ROOM * ERRS / max(got.number("error").value, 1e-9), _ROOM * FORM / max(got.form, 1e-9), 1 / 1.5)
    size = max(share, _FARTHEST) * got.size
    size = min(size, OPEN * got.gap) if got.gap and not got.gap_tapers else size
    return min(size, got.wall / THROUGH) if _walls(got) else size


def _unknowns(got: Got, size: float) -> float:
    """About how many unknowns there are at another size (mm). Estimates do not know of what is halved at rims, which
    is less of finer elements: measured, of lattices in cylinders, unknowns go by the inverse of the size at least."""
    volume = got.number("volume").value
    now = max(unknowns(got.size, volume, got.area, int(got.order)), 1)
    halved = min(max(got.unknowns / now, 1.0), HALVED)
    estimated = unknowns(size, volume, got.area, int(got.order)) * halved**0.5
    return float(max(estimated, got.unknowns * got.size / size))


def _least(got: Got) -> float:
    """The finest size (mm) that is affordable."""
    low, high = 1e-3 * got.size, 1e3 * got.size
    for _ in range(60):
        middle = (low * high) ** 0.5
        low, high = (middle, high) if _unknowns(got, middle) > AFFORDABLE else (low, middle)
    return high


def _time(got: Got, count: float) -> str:
    """About how long so many unknowns take, in words."""
    return f"about {duration(seconds(count, int(got.order)))}"
