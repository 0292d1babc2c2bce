"""Finds the phase of a lattice in a box: from a coarse grid to finer ones, and kept fine enough for its smallest cell.

The phase is smoother than the lattice that it drives: of a period that changes slowly, what is solved with 32 cells
along the longest side and interpolated from there has the periods of a solution with 128, in a tenth of the time. Along
an axis on which the period changes within such a cell, there are twice as many, or four times, and so on.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from porelang.data import NEAREST, SampledField, Triple, coordinates
from porelang.diagnostics import fail
from porelang.ops.grid import lookup_cubic
from porelang.tasks.phase.frames import axes_of, combed, extended, turn_round
from porelang.tasks.phase.got import ASKEW, Fold, Got, got, why_not
from porelang.tasks.phase.grids import on_grid
from porelang.tasks.phase.look import EDGE, Field, Look, averaged, components, look, unseen, with_nodes
from porelang.tasks.phase.poisson import FAR, OUTSIDE
from porelang.tasks.phase.turning import Wanted, first_fold, mean_rotation, turned

Values = NDArray[np.float64]
#: Cells along the longest side on each grid that is solved on, and at least along each side.
LEVELS = (16, 32)
FEWEST = 4
#: Of the longest side: so much more than the box is found on each side, for what reaches beyond the part.
MARGIN = 1 / 16
#: Small cells in a cell of the finest grid that is solved on, along each axis: in each is looked what is asked for
#: (`look`), and in its middle what was got (`got`).
LOOKED = 3
#: Turns by which a phase may be off for what varies within a cell of the grid that it is solved on, and the cells that
#: there may be.
UNSEEN, MOST_CELLS = 0.03, 130_000
#: Nodes of what is kept: 1.5 GB.
MOST_NODES = 64_000_000


def find(
    period: Field,
    inside: Field,
    low: Triple,
    high: Triple,
    free: bool,
    volume: bool = False,
    direction: Field | None = None,
    apart: bool = False,
    cells: Fit | None = None,
    axes: int = 7,
    of_data: Sequence[Sequence[Values]] = (),
) -> tuple[SampledField, Got]:
    """The phase (3 components, in turns, 0 at the place nearest to the origin) over a box, and what it got.

    `period` is in mm: one number at each point, or three (3, ...) for the axes of the cells; `inside` is negative
    within the part. `free` lets cells turn, or they stand along a `direction` (3, ...); `volume` gives up shape for
    size. With `apart` each of the three periods varies along its own axis alone: no equation is solved, as each
    component of the phase is an integral along its axis.
    `cells` says how many there are to be along the sides of the box; then they begin at its lower end. `axes` are those
    that the period depends on, as bits, and `of_data` the nodes of data that it reads, along each axis, all looked at.
    Errors: E092 where the box holds no part, E096 for cells so small that too many samples are needed, E147 where the
    period is none, E148 where cells would fold.
    """
    sides = np.array(high) - np.array(low)
    margin = MARGIN * float(sides.max())
    corner, sides = np.array(low) - margin, sides + 2 * margin

    def seen(counts: NDArray[np.int64]) -> Look:
        found = look(period, inside, low, high, [LOOKED * int(n) for n in counts], axes)
        if found is None:
            raise _empty()
        return found

    known = [[v[(v >= a) & (v <= b)] for v, a, b in zip(n, low, high, strict=True)] for n in of_data]
    levels = [_counts(sides, float(sides.max()) / level) for level in LEVELS]
    of = with_nodes(seen(levels[-1]), period, inside, known)
    while (finer := _finer(of, levels[-1], sides)) is not None:
        levels[-1] = finer
        of = replace(seen(finer), least=of.least, most=of.most)
    grids = [
        replace(_wanted(of, corner, sides / counts, counts, direction), free=free)
        for counts in (levels[-1:] if apart else levels)
    ]
    # of the shape that is as near as can be volumes may be nearer than of what they lead to: the better one is kept
    solved = [] if apart else [_solved(grids, corner)]
    if volume and solved:
        solved.append(_solved([replace(w, volume=True) for w in grids], corner, solved[0]))
    wanted = grids[-1]
    coarse, least = wanted.period.shape[1:], _smallest(wanted)
    counts = np.maximum(_counts(sides, least / 2), coarse)
    if math.prod(int(n) + 1 for n in counts) > MOST_NODES:
        raise fail("E096", f"cells of {least:.3g} mm need {math.prod(int(n) + 1 for n in counts):.2g} samples here",
                   hint="ask for larger cells, or for a smaller part `within`")  # fmt: skip
    nodes = [corner[a] + sides[a] * np.arange(counts[a] + 1) / counts[a] for a in range(3)]
    asked = _for_axes(period)

    def told_of(kept: Values) -> tuple[SampledField, Got | Fold]:
        phase, grown, fits = _sampled(kept, corner, sides / counts), 1.0, 0.0
        if cells is None:
            phase = _anchored(phase, asked, low, high)
        else:
            phase, grown, fits = _fitted(phase, cells, low, high)
        return phase, got(phase, of, free, direction, volume, grown, fits)

    phases = [told_of(on_grid(found[-1], nodes)) for found in solved]
    phases = phases or [told_of(_integrals(asked, nodes, low, high))]
    phase, told = min(phases, key=lambda p: math.inf if isinstance(p[1], Fold) else p[1].volume_95)
    turns = 0.0
    if wanted.direction is not None and (isinstance(told, Fold) or told.askew_95 > ASKEW):
        turns = turn_round(wanted.direction, wanted.within)
    if isinstance(told, Fold):
        hint = "their period changes too fast there: blur it, or give it less range"
        if wanted.direction is not None:
            hint = why_not("frame" if len(wanted.direction) == 6 else "direction", turns)
        raise fail("E148", f"the cells of this phase would fold at ({coordinates(told.place)})", hint=hint)
    told = replace(told, round=turns)
    return SampledField(phase.values, phase.origin, phase.spacing, told.facts), told


def _solved(
    grids: Sequence[Wanted], corner: Values, instead: Sequence[SampledField] | None = None
) -> list[SampledField]:
    """The phase on each of some grids, from that on the one before; where that would fold, from even cells or others.

    Those that volumes begin at are of the right shape: from even cells the first step may fold however short it is, and
    would be the last.
    """
    found: list[SampledField] = []
    for level, wanted in enumerate(grids):
        spacing = np.array(wanted.spacing)
        nodes = [corner[a] + spacing[a] * np.arange(wanted.period.shape[a + 1] + 1) for a in range(3)]
        start = on_grid(found[-1], nodes) if found else None
        if start is None or first_fold(start, wanted) is not None:
            start = _even(wanted, nodes) if instead is None else on_grid(instead[level], nodes)
        found.append(_sampled(turned(wanted, start), corner, spacing))
    return found


@dataclass(frozen=True, slots=True)
class Fit:
    """How many cells there are to be along the sides of a box: so many along each (0: as it comes), as many as are
    nearest (`whole`), or so many along its longest side, with one factor for all three (`longest`)."""

    how: Literal["each", "whole", "longest"]
    counts: Triple


def _fitted(phase: SampledField, fit: Fit, low: Triple, high: Triple) -> tuple[SampledField, float, float]:
    """A phase whose periods are all changed by a factor, so that so many cells lie between the middles of two sides;
    by how much those grow that change most; and the number along the longest that fits best, 0 for several."""
    ends = []
    for axis in range(3):
        at = [np.array([a, b]) if i == axis else np.array([(a + b) / 2] * 2)
              for i, (a, b) in enumerate(zip(low, high, strict=True))]  # fmt: skip
        x, y, z = at
        ends.append(lookup_cubic(phase, x, y, z, (axis, 0, 0, 0)))
    fits = 0.0
    first, found = np.array([e[0] for e in ends]), np.array([e[1] - e[0] for e in ends])
    if fit.how == "whole":
        factors = np.maximum(np.round(found), 1) / found
    elif fit.how == "longest":
        longest = int(np.argmax(np.array(high) - np.array(low)))
        factors = np.full(3, fit.counts[longest] / found[longest])
        fits = max(round(found[longest]), 1)
    else:
        factors = np.array([n / f if n else 1.0 for n, f in zip(fit.counts, found, strict=True)])
    most = factors[np.argmax(np.abs(np.log(factors)))]
    return SampledField.from_array((phase.values - first) * factors, phase.origin, phase.spacing), 1 / float(most), fits


def _finer(of: Look, counts: NDArray[np.int64], sides: Values) -> NDArray[np.int64] | None:
    """Twice as many cells along the axis along which a phase would err most; None where it errs by little, or where its
    cells are finer than those of the lattice, or too many."""
    off = [unseen(of, a, LOOKED) if sides[a] / counts[a] > of.least / 2 else 0.0 for a in range(3)]
    axis = int(np.argmax(off))
    finer = counts * np.where(np.arange(3) == axis, 2, 1)
    return finer if off[axis] > UNSEEN and math.prod(int(n) for n in finer) <= MOST_CELLS else None


def _for_axes(period: Field) -> Field:
    """A field of periods as one that gives three everywhere (3, ...)."""

    several = components(period)

    def at(x: Values, y: Values, z: Values) -> Values:
        values = several(x, y, z)
        return np.broadcast_to(values, (3, *values.shape[1:]))

    return at


def _integrals(period: Field, nodes: Sequence[Values], low: Triple, high: Triple) -> Values:
    """The phase of which each component is the integral of 1 / w along its axis: by Gauss's rule between the nodes."""
    points, weights = np.polynomial.legendre.leggauss(24)
    middle = [np.array([(a + b) / 2]) for a, b in zip(low, high, strict=True)]
    along = []
    for axis, ends in enumerate(nodes):
        half = np.diff(ends) / 2
        inner = np.clip(ends[:-1, None] + half[:, None] * (1 + points), low[axis], high[axis]).reshape(-1)
        asked = period(*(inner if a == axis else middle[a] for a in range(3)))[axis]
        steps = half * (weights / asked.reshape(-1, len(points))).sum(1)
        along.append(np.concatenate([[0.0], np.cumsum(steps)]))
    return np.stack(np.meshgrid(*along, indexing="ij"))


def _counts(sides: Values, spacing: float) -> NDArray[np.int64]:
    return np.maximum(np.ceil(sides / spacing - 1e-9).astype(np.int64), FEWEST)


def _wanted(of: Look, corner: Values, spacing: Values, counts: NDArray[np.int64], direction: Field | None) -> Wanted:
    """What is asked for in the cells; beyond the part, where its field may be anything, a period like those within."""
    ends = [corner[a] + spacing[a] * np.arange(counts[a] + 1) for a in range(3)]
    share, asked = averaged(of, ends)
    within = share > 0
    for c, fits in enumerate(np.isfinite(asked)):
        good = asked[c][within & fits]
        asked[c] = np.where(fits, asked[c], np.exp(np.log(good).mean())).clip(good.min(), good.max())
    steps: Triple = (float(spacing[0]), float(spacing[1]), float(spacing[2]))
    way = None
    if direction is not None:
        low, high = (np.array([e[i] for e in of.ends]) for i in (0, -1))
        thin = EDGE * (high - low)
        middles = [
            np.clip(e[:-1] + h / 2, a, b) for e, h, a, b in zip(ends, spacing, low + thin, high - thin, strict=True)
        ]
        way = combed(extended(direction(*np.meshgrid(*middles, indexing="ij")), within, steps), within)
    about = _about(within)
    weights = np.maximum(share, OUTSIDE if direction is None else np.where(about, OUTSIDE, FAR))
    return Wanted(np.broadcast_to(asked, (3, *share.shape)), weights, about, steps, direction=way)


def _about(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The cells and those about them: the cubic between the nodes of a cell reads theirs."""
    for axis in range(3):
        wide = np.pad(cells, [(int(a == axis),) * 2 for a in range(3)])
        wide = np.moveaxis(wide, axis, 0)
        cells = np.moveaxis(wide[:-2] | wide[1:-1] | wide[2:], 0, axis)
    return cells


def _empty() -> Exception:
    return fail("E092", "the region `within` of this phase holds no material", hint="solid is negative: check its sign")


def _smallest(wanted: Wanted) -> float:
    return float(wanted.period[:, wanted.within].min())


def _even(wanted: Wanted, nodes: Sequence[Values]) -> Values:
    """Cells of one size, which fold nowhere, that stand as the directions do in the mean."""
    mean = np.exp(np.log(wanted.period[:, wanted.within]).mean(axis=1))
    phi = np.stack(np.meshgrid(*nodes, indexing="ij"))
    if wanted.direction is not None:
        phi = np.tensordot(mean_rotation(axes_of(wanted.direction), wanted.weights), phi, 1)
    return np.asarray(phi / mean[:, None, None, None])


def _sampled(phi: Values, corner: Values, spacing: Values) -> SampledField:
    return SampledField.from_array(np.moveaxis(phi, 0, -1), corner.tolist(), spacing.tolist())


def _anchored(phase: SampledField, period: Field, low: Triple, high: Triple) -> SampledField:
    """Moved so that it is q / w at the place q of the box that is nearest to the origin: a constant w gives p / w."""
    x, y, z = (np.array([min(max(0.0, a), b)]) for a, b in zip(low, high, strict=True))
    asked = [w if w >= NEAREST else math.inf for w in period(x, y, z)[:, 0].tolist()]
    here = [float(lookup_cubic(phase, x, y, z, (c, 0, 0, 0))[0]) for c in range(3)]
    move = [float(q[0]) / w - u for q, w, u in zip((x, y, z), asked, here, strict=True)]
    return SampledField.from_array(phase.values + np.array(move), phase.origin, phase.spacing)
