"""Where a solid is: the cells of its box that enclosures prove to be inside, and those they leave undecided."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.backwards import UNIVERSE
from porelang.analysis.bounds import Points, box_test
from porelang.analysis.box import Box, part_box, reach, unbounded_axes
from porelang.analysis.enclose import EXACT, enclose, everywhere
from porelang.backends.numpy import Dtype, NumpyField
from porelang.data import WORLD, coordinates
from porelang.diagnostics import PoreError, fail
from porelang.formula import Formula
from porelang.progress import tell

_CELLS = 24  # along the longest side of the box
#: Cells are halved while there are fewer: a thin part gets cells of its own thickness.
ENOUGH = 6000
_LEVELS = 16
_AT_ONCE = 1 << 19  # points
_DOUBTFUL = 20_000
_INFINITE = 0.5  # of the values in a box
_AROUND = 0.01  # of a box
SEED = 20230611


@dataclass(frozen=True, slots=True)
class Region:
    """The cells of a box, of equal size: corners of those decided to be inside, and of those undecided.

    `certain` is the volume (mm^3) of larger cells that are inside and were left out when the undecided were halved.
    """

    box: Box
    size: NDArray[np.float64]
    inside: Points
    undecided: Points
    certain: float = 0.0

    @property
    def cell(self) -> float:
        """The volume of a cell, in mm^3."""
        return float(np.prod(self.size))

    @property
    def cells(self) -> Points:
        """Every cell that may hold a part of the solid."""
        return np.concatenate([self.inside, self.undecided])


def seed(round_: int) -> int:
    """The seed of a round of samples: the same in every run, so that a program has the same numbers every time."""
    return SEED + round_


def region(solid: Formula, what: str = "the region", apart: bool = False) -> Region:
    """Where a solid is; `apart` keeps the sides of cells off the faces of shapes that end where the box does.

    Errors: E091 where it has no end, E092 where it is empty, E093 where it is not a number.
    """
    box = part_box(solid)
    refuse_undefined(solid, box)
    if (box is None or unbounded_axes(box)) and (end := reach(solid)) is not None:
        raise fail("E091", f"{what} of this number lies more than 100 m from the origin, as far as {end:,.0f} mm",
                   hint=WORLD)  # fmt: skip
    if box is None:
        raise empty(what)
    if axes := unbounded_axes(box):
        raise fail(
            "E091",
            f"{what} of this number has no end along {axes}: it goes on beyond {UNIVERSE / 1000:g} m from the origin",
            hint="intersect it with a shape: `... & cylinder(75, 300)`; larger parts are measured in another unit",
        )
    if apart:
        room = [(0.0037 * s, 0.0061 * s) for s in box.size]
        ends = [(a - r[0], b + r[1]) for a, b, r in zip(box.lo, box.hi, room, strict=True)]
        box = Box(*((e[0][k], e[1][k], e[2][k]) for e in [ends] for k in (0, 1)))
    size = np.array(box.size)
    if not size.min() > 0:
        raise empty(what)
    counts = np.maximum(1, np.ceil(_CELLS * size / size.max())).astype(int)
    step = size / counts
    index = np.stack(np.meshgrid(*(np.arange(c) for c in counts), indexing="ij"), -1).reshape(-1, 3)
    return sorted_out(solid, Region(box, step, np.empty((0, 3)), np.array(box.lo) + index * step))


def refuse_undefined(solid: Formula, box: Box | None) -> None:
    """Refuse a field that is not a number somewhere in a box, and a little around it, as a mesh does: it is no solid
    and no void there. Where there is no box it is looked at far and wide. One that is infinite nearly everywhere was
    divided by 0: it tells a sign, and nothing of a surface. Errors: E093."""
    if not bool(np.any(enclose(solid, everywhere())[0].range.nan)):
        return
    random = np.random.default_rng(3)
    if box is None:
        points = np.concatenate([random.uniform(-r, r, (_DOUBTFUL // 4, 3)) for r in (1.0, 10.0, 100.0, 1000.0)])
    else:
        margin = _AROUND * np.array(box.size)
        points = random.uniform(np.array(box.lo) - margin, np.array(box.hi) + margin, (_DOUBTFUL, 3))
    values = NumpyField(solid, "f64").at(points)
    if np.isnan(values).any() or np.isinf(values).mean() > _INFINITE:
        raise undefined(points, values)


def undefined(points: Points, values: NDArray[np.float64]) -> PoreError:
    """What is said of a field that is no finite number somewhere among points, with the place nearest the origin."""
    bad = np.isnan(values) if np.isnan(values).any() else ~np.isfinite(values)
    at = min(points[bad], key=lambda p: float(np.abs(p).max()))
    return fail(
        "E093",
        f"the field is {'not a number' if np.isnan(values).any() else 'infinite'} at ({coordinates(at)}) mm",
        hint="look for a division by zero, or a root, logarithm or power of a negative number there",
    )


def empty(what: str) -> PoreError:
    return fail("E092", f"{what} of this number holds no material", hint="solid is negative: check its sign")


def sorted_out(solid: Formula, where: Region) -> Region:
    """The region with its undecided cells looked at: inside, void (and gone), or still undecided."""
    low = where.undecided
    least, most = box_test(solid, EXACT)(low, low + where.size)
    inside = np.concatenate([where.inside, low[most < 0]])
    return replace(where, inside=inside, undecided=low[(least < 0) & (most >= 0)])


def finer(solid: Formula, where: Region, enough: int = ENOUGH) -> Region:
    """The region with its undecided cells halved until there are `enough`; those inside are counted and left out."""
    for _ in range(_LEVELS):
        certain = where.certain + where.cell * len(where.inside)
        where = replace(where, inside=np.empty((0, 3)), certain=certain)
        if not 0 < len(where.undecided) < enough:
            break
        undecided = halves(where.undecided, where.size)
        where = sorted_out(solid, replace(where, size=where.size / 2, undecided=undecided))
    return where


def finer_throughout(solid: Formula, where: Region, enough: int = ENOUGH) -> Region:
    """The region with all of its cells halved until there are `enough`: what is inside a thin solid can be sampled."""
    for _ in range(_LEVELS):
        if not 0 < len(where.cells) < enough:
            break
        inside, undecided = (halves(c, where.size) for c in (where.inside, where.undecided))
        where = sorted_out(solid, replace(where, size=where.size / 2, inside=inside, undecided=undecided))
    return where


def halves(low: Points, size: NDArray[np.float64]) -> Points:
    """The eight halves of each cell, by their low corners."""
    corners = np.stack(np.meshgrid(*([0, 1],) * 3, indexing="ij"), -1).reshape(1, 8, 3)
    return np.asarray((low[:, None, :] + corners * (size / 2)).reshape(-1, 3))


def pairs(low: Points, size: NDArray[np.float64], m: int) -> Iterator[tuple[Points, Points]]:
    """Two independent random points in each of the m^3 strata of every cell, in pieces; the same in every run."""
    random = np.random.Generator(np.random.SFC64(seed(m)))  # drawing numbers takes longer than evaluating a lattice
    index = np.stack(np.meshgrid(*(np.arange(m),) * 3, indexing="ij"), -1).reshape(1, -1, 3)
    step = size / m
    each = max(1, _AT_ONCE // m**3)
    for start in range(0, len(low), each):
        tell(start, len(low))
        base = low[start : start + each, None, :] + index * step
        first, second = (base + random.random(base.shape, np.float32) * step for _ in range(2))
        yield first.reshape(-1, 3), second.reshape(-1, 3)


def fast_enough(solid: Formula, where: Region) -> Dtype:
    """f32 where it tells inside from outside as f64 does; f64 elsewhere: far from the origin, in tiny parts, where
    f32 has no such numbers."""
    random = np.random.default_rng(5)
    pick = random.integers(0, len(where.undecided), _DOUBTFUL)
    points = where.undecided[pick] + random.random((_DOUBTFUL, 3)) * where.size
    single, double = (NumpyField(solid, dtype).at(points) for dtype in ("f32", "f64"))
    if (np.isfinite(double) & ~np.isfinite(single)).any():
        return "f64"
    return "f32" if np.count_nonzero((single < 0) != (double < 0)) <= 1 else "f64"
