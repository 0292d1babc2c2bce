"""Finds the phase of a lattice in a box: from a coarse grid to finer ones, and kept fine enough for its smallest cell.

The phase is much smoother than the lattice that it drives: solved with 32 cells along the longest side and
interpolated from there, its periods are those of a solution with 128, in a tenth of the time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from porelang.data import LARGEST_VALUE, NEAREST, SampledField, Triple, coordinates
from porelang.diagnostics import fail
from porelang.ops.grid import lookup_cubic
from porelang.tasks.phase.got import Field, Fold, Got, got
from porelang.tasks.phase.poisson import OUTSIDE
from porelang.tasks.phase.turning import Wanted, first_fold, turned

Values = NDArray[np.float64]
#: Cells along the longest side on each grid that is solved on, and at least along each side.
LEVELS = (16, 32)
FEWEST = 4
#: Of the longest side: so much more than the box is found on each side, for what reaches beyond the part.
MARGIN = 1 / 16
#: Nodes of what is kept: 1.5 GB.
MOST_NODES = 64_000_000


def find(period: Field, inside: Field, low: Triple, high: Triple, free: bool) -> tuple[SampledField, Got]:
    """The phase (3 components, in turns, 0 at the place nearest to the origin) over a box, and what it got.

    `period` is in mm, `inside` negative within the part; `free` lets cells turn. Errors: E092 where the box holds no
    part, E096 for cells so small that too many samples are needed, E097 where the period is none, or cells would fold.
    """
    sides = np.array(high) - np.array(low)
    margin = MARGIN * float(sides.max())
    corner, sides = np.array(low) - margin, sides + 2 * margin
    found: SampledField | None = None
    for level in LEVELS:
        counts = _counts(sides, float(sides.max()) / level)
        spacing = sides / counts
        wanted = _wanted(period, inside, corner, spacing, counts)
        nodes = [corner[a] + spacing[a] * np.arange(counts[a] + 1) for a in range(3)]
        start = _read(found, nodes) if found is not None else _even(wanted, nodes)
        if found is not None and first_fold(start, wanted) is not None:
            start = _even(wanted, nodes)
        found = _sampled(turned(wanted, start, free), corner, spacing)
    assert found is not None
    least, most = _smallest(wanted), 2 * np.array(wanted.period.shape)
    counts = np.maximum(_counts(sides, least / 2), wanted.period.shape)
    if math.prod(int(n) + 1 for n in counts) > MOST_NODES:
        raise fail("E096", f"cells of {least:.3g} mm need {math.prod(int(n) + 1 for n in counts):.2g} samples here",
                   hint="ask for larger cells, or for a smaller part `within`")  # fmt: skip
    nodes = [corner[a] + sides[a] * np.arange(counts[a] + 1) / counts[a] for a in range(3)]
    phase = _anchored(_sampled(_read(found, nodes), corner, sides / counts), period, low, high)
    at = [corner[a] + sides[a] * (np.arange(most[a]) + 0.5) / most[a] for a in range(3)]
    told = got(phase, period, inside, (at[0], at[1], at[2]))
    if isinstance(told, Fold):
        raise fail("E097", f"the cells of this phase would fold at ({coordinates(told.place)})",
                   hint="their period changes too fast there: blur it, or give it less range")  # fmt: skip
    if told is None:
        raise _empty()
    return SampledField(phase.values, phase.origin, phase.spacing, told.facts), told


def _counts(sides: Values, spacing: float) -> NDArray[np.int64]:
    return np.maximum(np.ceil(sides / spacing - 1e-9).astype(np.int64), FEWEST)


def _wanted(period: Field, inside: Field, corner: Values, spacing: Values, counts: NDArray[np.int64]) -> Wanted:
    """What is asked for in the cells; beyond the part, where its field may be anything, a period like those within."""
    nodes = np.meshgrid(*(corner[a] + spacing[a] * np.arange(counts[a] + 1) for a in range(3)), indexing="ij")
    centres = np.meshgrid(*(corner[a] + spacing[a] * (np.arange(counts[a]) + 0.5) for a in range(3)), indexing="ij")
    at_corners = np.broadcast_to(inside(*nodes), nodes[0].shape) < 0
    central = np.broadcast_to(inside(*centres), centres[0].shape) < 0
    within = central.copy()
    for i, j, k in np.ndindex(2, 2, 2):
        x, y, z = (slice(1, None) if n else slice(None, -1) for n in (i, j, k))
        within |= at_corners[x, y, z]
    if not within.any():
        raise _empty()
    asked = np.array(np.broadcast_to(period(*centres), within.shape), np.float64)
    right = (asked >= NEAREST) & (asked <= LARGEST_VALUE)
    if (central & ~right).any():
        i, j, k = (int(v) for v in np.argwhere(central & ~right)[0])
        place = coordinates(float(c[i, j, k]) for c in centres)
        raise fail("E097", f"the period that is asked for is {asked[i, j, k]:.3g} mm at ({place})",
                   hint="a period is a length above 0 everywhere within the part")  # fmt: skip
    good = asked[within & right]
    if not good.size:
        raise _empty()
    asked = np.where(right, asked, np.exp(np.log(good).mean())).clip(good.min(), good.max())
    steps: Triple = (float(spacing[0]), float(spacing[1]), float(spacing[2]))
    return Wanted(asked, np.where(within, 1.0, OUTSIDE), _about(within), steps)


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
    return float(wanted.period[wanted.within].min())


def _even(wanted: Wanted, nodes: Sequence[Values]) -> Values:
    """Cells of one size, which fold nowhere."""
    mean = float(np.exp(np.log(wanted.period[wanted.within]).mean()))
    return np.stack(np.meshgrid(*nodes, indexing="ij")) / mean


def _read(phase: SampledField, nodes: Sequence[Values]) -> Values:
    x, y, z = np.meshgrid(*nodes, indexing="ij", sparse=True)
    shape = tuple(len(n) for n in nodes)
    return np.stack([np.broadcast_to(lookup_cubic(phase, x, y, z, (c, 0, 0, 0)), shape) for c in range(3)])


def _sampled(phi: Values, corner: Values, spacing: Values) -> SampledField:
    return SampledField.from_array(np.moveaxis(phi, 0, -1), corner.tolist(), spacing.tolist())


def _anchored(phase: SampledField, period: Field, low: Triple, high: Triple) -> SampledField:
    """Moved so that it is q / w at the place q of the box that is nearest to the origin: a constant w gives p / w."""
    x, y, z = (np.array([min(max(0.0, a), b)]) for a, b in zip(low, high, strict=True))
    asked = float(np.asarray(period(x, y, z)).reshape(-1)[0])
    if not asked >= NEAREST:
        asked = math.inf
    move = [float(q[0]) / asked - float(lookup_cubic(phase, x, y, z, (c, 0, 0, 0))[0]) for c, q in enumerate((x, y, z))]
    return SampledField.from_array(phase.values + np.array(move), phase.origin, phase.spacing)
