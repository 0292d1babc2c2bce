"""What a phase got of what was asked for: periods, stretch, turns and folds, from the Jacobian of what is looked up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.data import SampledField, Triple
from porelang.progress import checkpoint
from porelang.tasks.phase.frames import everywhere, has_all, nearest
from porelang.tasks.phase.grids import on_grid
from porelang.tasks.phase.look import Field, Look
from porelang.tasks.phase.turning import cofactors, rotations

Values = NDArray[np.float64]
#: A cell of this volume, against a cube of its size, is as good as folded: between the points looked at it may be.
FLAT = 0.02
#: Of so many points spread among them it is looked at how cells are turned: that varies slowly.
TURNED = 60_000
#: What is doubted: the stretch of 5 % of the cells, and by how much 5 % of them miss their size.
STRETCHED, MISSED = 1.15, 0.10
#: The same of the worst one: a narrow place is less than one cell in twenty of a long part.
WORST_STRETCHED, WORST_MISSED = 1.5, 0.5
#: How many times larger or smaller the smallest cells may be than the smallest that are asked for; so the largest.
LOST = 1.2
#: A direction that 5 % of the cells miss by more, in degrees.
ASKEW = 10.0
#: The share of a part in which there is no direction to stand along: at single places, as on an axis, may be none.
UNDIRECTED = 0.01


@dataclass(frozen=True, slots=True)
class Got:
    """Of the points looked at within a part: periods in mm, angles in degrees.

    `off` is by how much the size of a cell along one of its axes, 1 / |grad u|, misses w, relative to w; `volume` the
    same of volumes, where cells were to keep them (`sized`); `stretch` how much longer a cell is one way than another,
    against what was asked for (the largest by the smallest singular value of w times the Jacobian, 1 for cells of the
    right shape); `turn` the angle by which cells are turned from the axes of the part. `askew` is by how much the cells
    miss the direction that they were to stand along, or are turned from the frame; `undirected` the share of the part
    in which that is none, `round` the turns that it takes round a line. `turned` is 1 where cells may turn, `directed`
    where a direction is given, 2 for a frame. `grown` is by how much cells grew that were to be so many, `fits` the
    number that fits best: of those along the longest side, or 0 where each side has its own.
    """

    asked_least: float
    asked_most: float
    least: float
    most: float
    off_median: float
    off_95: float
    off_most: float
    stretch_95: float
    stretch_most: float
    turn_median: float
    turn_most: float
    turned: float = 1.0
    directed: float = 0.0
    askew_95: float = 0.0
    askew_most: float = 0.0
    sized: float = 0.0
    volume_95: float = 0.0
    grown: float = 1.0
    undirected: float = 0.0
    round: float = 0.0
    fits: float = 0.0

    @property
    def facts(self) -> tuple[float, ...]:
        """As numbers, in the order of the fields above."""
        return tuple(float(v) for v in astuple(self))

    @property
    def given(self) -> str:
        """What cells were to stand along."""
        return "frame" if self.directed > 1 else "direction"

    def __str__(self) -> str:
        asked, found = _range(self.asked_least, self.asked_most), _range(self.least, self.most)
        turn = f"turned by up to {self.turn_most:.0f} degrees" if self.turn_most >= 0.5 else "not turned"
        if self.directed:
            turn = f"within {self.askew_95:.0f} degrees of the {self.given} given (95 %), {self.askew_most:.0f} at most"
        volume = f"volume within {100 * self.volume_95:.0f} % (95 %); " if self.sized else ""
        return f"asked {asked} mm, got {found}; {volume}stretch at most {self.stretch_most:.2f}; {turn}; no folds"


def told(facts: Sequence[float]) -> tuple[str, str, str]:
    """In words: the note of a phase, what is doubtful about it ("" where nothing is), and a hint, from its facts."""
    of = Got(*facts)
    wrong, hint = [], "let cells turn: leave `orientation` out" if not of.turned and not of.directed else ""
    if of.sized and of.volume_95 > MISSED:
        wrong.append(f"one cell in twenty misses its volume by {100 * of.volume_95:.0f} % or more")
    if not of.sized and of.off_95 > MISSED:
        most, one = (f"{100 * v:.0f}" for v in (of.off_95, of.off_most))
        wrong.append(f"one cell in twenty misses its size by {most} % or more" + f", one by {one} %" * (one != most))
    elif not of.sized and of.off_most > WORST_MISSED:
        wrong.append(f"one cell misses its size by {100 * of.off_most:.0f} %")
    fitted = max(of.grown, 1 / of.grown) > 1 + MISSED  # all cells are smaller then, or larger
    lost = [f"cells of {_mm(a)} mm are asked for, and the {how} are {_mm(b)} mm" for a, b, how, by in (
        (of.asked_least, of.least, "smallest", of.least / of.asked_least),
        (of.asked_most, of.most, "largest", of.asked_most / of.most),
    ) if by > LOST]  # fmt: skip
    beyond = [f"cells of {_mm(a)} mm at {how} are asked for, and some are {_mm(b)} mm" for a, b, how, by in (
        (of.asked_least, of.least, "least", of.asked_least / of.least),
        (of.asked_most, of.most, "most", of.most / of.asked_most),
    ) if by > LOST and not of.sized and not fitted]  # fmt: skip
    wrong += lost + beyond
    if of.directed:
        hint = why_not(of.given, of.round)
    if lost and not hint:
        hint = "a size that is asked for over no more than a few cells cannot be had: let it vary over a longer way"
    if of.stretch_95 > STRETCHED:
        wrong.append(f"one in twenty is {of.stretch_95:.2f} times as long as it should be against its width, or more")
    elif of.stretch_most > WORST_STRETCHED:
        wrong.append(f"one is {of.stretch_most:.2f} times as long as it should be against its width")
    if of.askew_95 > ASKEW:
        wrong.append(f"one in twenty lies {of.askew_95:.0f} degrees or more off the {of.given} given")
    if of.undirected > UNDIRECTED:
        none = "0, or its two lie along each other," if of.directed > 1 else "0"
        wrong.append(f"the {of.given} given is {none} in {100 * of.undirected:.0f} % of the part")
        if of.askew_95 <= ASKEW:
            hint = "cells there stand as those beside them: give one there, as in `if length(v) > 0 then v else "
            hint += "[1, 0, 0]`" + "; of a frame, two at an angle" * (of.directed > 1)
    if wrong and fitted:
        change = f"{of.grown:.2g} times larger" if of.grown > 1 else f"{1 / of.grown:.2g} times smaller"
        other = f"give {of.fits:.0f}, the number that fits best" if of.fits else "change the length of that side"
        hint = f"`cells` makes them {change} than they are asked for: {other}, or leave it out"
    hint = hint or "let the period vary more slowly, or by less; or `crossfade` lattices of one period each"
    return str(of), "; ".join(wrong), hint


def why_not(given: str, round_: float) -> str:
    """Why cells do not stand along a direction or in a frame that turns, and what would do; `round_` as in `Got`."""
    if round_:
        turn = "half a turn" if round_ < 1 else "a whole turn"
        return (
            f"the {given} turns by {turn} round a line or a hole, and no phase does without a seam: open the part "
            "there, or round an axis take `cylinder_map`, `polar` or `wedges`"
        )
    return (
        f"a {given} that turns needs cells that differ: give each axis a period of its own, as r / 3 round an axis; "
        "or blur it; or round an axis take `cylinder_map`, `polar` or `wedges`"
    )


def _range(low: float, high: float) -> str:
    one, other = f"{low:.1f}", f"{high:.1f}"
    if low < 1:
        one, other = f"{low:.3g}", f"{high:.3g}"
    return one if one == other else f"{one}..{other}"


def _mm(size: float) -> str:
    return f"{size:.3g}" if size < 1 else f"{size:.1f}"


@dataclass(frozen=True, slots=True)
class Fold:
    """A place within the part where a phase folds: its cells would be turned inside out there."""

    place: Triple


def got(
    phase: SampledField,
    of: Look,
    free: bool = True,
    direction: Field | None = None,
    sized: bool = False,
    grown: float = 1.0,
    fits: float = 0.0,
) -> Got | Fold:
    """What a phase got in the small cells within a part, at their centres. Each is looked at for folds."""
    from porelang.tasks.phase.loops import shapes

    keep, centres = of.inside, of.centres
    cells = np.flatnonzero(keep)

    def places(cells: NDArray[np.int64]) -> list[Values]:
        return [c[i] for c, i in zip(centres, np.unravel_index(cells, keep.shape), strict=True)]

    checkpoint()
    slopes = np.empty((3, 3, len(cells)))
    for a in range(3):
        slopes[:, a] = on_grid(phase, centres, (int(a == 0), int(a == 1), int(a == 2)))[:, keep]
    asked = of.asked
    numbers = np.empty(asked.shape)
    stretch, flat, volume = (np.empty(len(cells)) for _ in range(3))
    shapes(slopes, asked, numbers, stretch, flat, volume)
    folded = ~(flat > FLAT)
    if folded.any():
        x, y, z = (float(c[0]) for c in places(cells[folded][:1]))
        return Fold((x, y, z))
    checkpoint()
    off = np.abs(1 / (numbers * asked) - 1)
    few = max(1, len(asked[0]) // TURNED)
    turns = rotations(asked[:, None, ::few] * slopes[..., ::few])
    turn = _degrees((turns[0, 0] + turns[1, 1] + turns[2, 2] - 1) / 2)
    found = [
        *(of.least, of.most, 1 / numbers.max(), 1 / numbers.min()),
        *(np.median(off), np.quantile(off, 0.95), off.max()),
        *(np.quantile(stretch, 0.95), stretch.max(), np.median(turn), turn.max()),
        float(free),
    ]
    undirected = 0.0
    if direction is not None:
        given = direction(*places(cells[::few]))
        wanted, known = everywhere(given), has_all(given)
        undirected = 1 - float(known.mean())
        axes = nearest(turns, wanted) if len(wanted) == 6 else wanted[None]
        askew = _askew(slopes[..., ::few], axes)
        askew = askew[known] if known.any() else np.zeros(1)
        found += [len(wanted) / 3, np.quantile(askew, 0.95), askew.max()]
    else:
        found += [0.0, 0.0, 0.0]
    found += [1.0, np.quantile(np.abs(1 / volume - 1), 0.95)] if sized else [0.0, 0.0]
    found += [grown, undirected, 0.0, fits]
    return Got(*(float(v) for v in found))


def _askew(slopes: Values, axes: Values) -> Values:
    """The greatest angle, in degrees, between the first axes of cells and those wanted (k, 3, n), or their opposites:
    an axis is the normal of layers of cells, and the edges from one to the next, which shear sets apart."""
    cosine = np.ones(slopes.shape[2:])
    for of in (slopes, cofactors(slopes)):
        rows = of[: len(axes)]
        cosine = np.minimum(cosine, np.abs((rows * axes).sum(1) / np.sqrt((rows**2).sum(1))).min(0))
    return _degrees(cosine)


def _degrees(cosine: Values) -> Values:
    return np.asarray(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
