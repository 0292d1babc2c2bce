"""What is asked for in a part: its period in small cells that tile the box, each as the mean of finer samples.

What counts of a period is how many cells of the lattice there are to be: the mean of 1 / w, however narrow a change of
it is. A field that varies along one axis, or two, is looked at so finely along those that its mean is as good as its
integral; where one that varies along three does so quickly, each small cell is looked at more closely.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.data import LARGEST_VALUE, NEAREST, Triple, coordinates
from porelang.diagnostics import fail
from porelang.progress import checkpoint

Values = NDArray[np.float64]
Flags = NDArray[np.bool_]
#: A field of x, y and z in mm, as arrays that broadcast.
Field = Callable[[Values, Values, Values], Values]
#: Of the box's sides: so far from its faces it is seen whether the part ends there.
EDGE = 1e-3
#: Samples of a period in all, and at most along an axis of a small cell.
SAMPLES, FINEST = 400_000, 201
#: By how much a period differs from that of the next small cell where a small cell is looked at more closely, at so
#: many points along each axis; and how many small cells are.
QUICK, CLOSE, MOST_CLOSE = 0.1, 3, 20_000


@dataclass(frozen=True, eq=False)
class Look:
    """A period in the small cells of a grid that tiles the box of a part, from `ends` to ends along each axis.

    `inside` are the cells whose centre lies in the part. `period` is that at the centres and `density` the mean of
    1 / w, NaN where it is none, of one component or three: (k, nx, ny, nz), but 1 along axes on which they do not
    depend. `least` and `most` are what is asked for at all within the part.
    """

    ends: tuple[Values, Values, Values]
    inside: Flags
    period: Values
    density: Values
    least: float
    most: float

    @property
    def centres(self) -> tuple[Values, Values, Values]:
        """The middles of the small cells along each axis."""
        x, y, z = ((e[:-1] + e[1:]) / 2 for e in self.ends)
        return x, y, z

    @property
    def asked(self) -> Values:
        """The period at the centres that lie in the part (3, n)."""
        k = len(self.period)
        here = np.broadcast_to(self.period, (k, *self.inside.shape))[:, self.inside]
        return np.broadcast_to(here, (3, here.shape[1]))


def look(period: Field, inside: Field, low: Triple, high: Triple, counts: Sequence[int], axes: int) -> Look | None:
    """A period in so many small cells along each side of a box; `axes` are those it depends on, as bits.

    None if no centre of a small cell lies in the part. Errors: E147 where the period is none.
    """
    x, y, z = (np.linspace(a, b, n + 1) for a, b, n in zip(low, high, counts, strict=True))
    ends = (x, y, z)
    about = [np.concatenate([[e[0] + EDGE * (e[-1] - e[0])], (e[:-1] + e[1:]) / 2, [e[-1] - EDGE * (e[-1] - e[0])]])
             for e in ends]  # fmt: skip
    wide = np.broadcast_to(np.asarray(inside(*_sparse(about))) < 0, tuple(n + 2 for n in counts))
    within = wide[1:-1, 1:-1, 1:-1]
    if not within.any():
        return None
    whole = _surrounded(wide)
    along = [n if axes >> a & 1 else 1 for a, n in enumerate(counts)]
    finer = _finer(along)
    places = [_samples(e if n > 1 else e[[0, -1]], f) for e, n, f in zip(ends, along, finer, strict=True)]
    values = components(period)(*_sparse(places))
    parts = values.reshape(len(values), *(v for n, f in zip(along, finer, strict=True) for v in (n, f)))
    parts = parts.transpose(0, 1, 3, 5, 2, 4, 6).reshape(len(values), *along, -1)
    at_centre = parts[..., parts.shape[-1] // 2]  # there is an odd number along each axis
    _check(at_centre, within, lambda cell, _: _place(ends, cell, (1, 1, 1), 0))
    first = np.argmax(~_is_period(parts), -1)

    def place_of_first(cell: Sequence[int], component: int) -> list[float]:
        here = (min(i, n - 1) for i, n in zip(cell, along, strict=True))
        return _place(ends, cell, finer, int(first[(component, *here)]))

    _check(np.take_along_axis(parts, first[..., None], -1)[..., 0], whole, place_of_first)
    density, least, most = _means(parts)
    if prod(finer) == 1 and tuple(along) == within.shape:
        _look_closer(period, ends, within, whole, at_centre, (density, least, most))
    extremes = []
    for values, cells in ((at_centre, within), (least, whole), (most, whole)):
        if cells.any():
            extremes.append(np.broadcast_to(values, (len(values), *within.shape))[:, cells])
    lowest, highest = min(float(v.min()) for v in extremes), max(float(v.max()) for v in extremes)
    return Look(ends, within, at_centre, density, lowest, highest)


def with_nodes(of: Look, period: Field, inside: Field, nodes: Sequence[Sequence[Values]]) -> Look:
    """What is seen with the nodes of grids of data looked at too, of which one may hold what none of its neighbours do:
    places along each axis, of each grid. Errors: E147.
    """
    least, most = of.least, of.most
    for x, y, z in nodes:
        thick = max(1, SAMPLES // max(1, len(y) * len(z)))
        for start in range(0, len(x), thick):
            checkpoint()
            here = (x[start : start + thick], y, z)
            asked = components(period)(*_sparse(here))
            keep = np.broadcast_to(np.asarray(inside(*_sparse(here))) < 0, asked.shape[1:])
            _check(asked, keep, _nodes_at(here))
            if keep.any():
                least, most = min(least, float(asked[:, keep].min())), max(most, float(asked[:, keep].max()))
    return replace(of, least=least, most=most)


def _nodes_at(axes: Sequence[Values]) -> Callable[[Sequence[int], int], list[float]]:
    return lambda at, _: [float(c[i]) for c, i in zip(axes, at, strict=True)]


def components(period: Field) -> Field:
    """A field of periods as one that gives one or three components everywhere (k, ...)."""

    def at(x: Values, y: Values, z: Values) -> Values:
        shape = np.broadcast_shapes(x.shape, y.shape, z.shape)
        values = np.asarray(period(x, y, z), np.float64)
        values = values if values.ndim > len(shape) else values[None]
        return np.broadcast_to(values, (len(values), *shape))

    return at


def unseen(of: Look, axis: int, every: int) -> float:
    """How many turns a phase is off, at most, where `every` so many small cells along an axis are taken for one; along
    one line in each such cell."""
    if of.density.shape[axis + 1] == 1:
        return 0.0
    each = [slice(None) if a == axis or n == 1 else slice(every // 2, None, every)
            for a, n in enumerate(of.density.shape[1:])]  # fmt: skip
    one = tuple(a for a in range(3) if of.density.shape[a + 1] == 1)
    values, inside = of.density[(slice(None), *each)], np.asarray(of.inside.any(axis=one, keepdims=True))[tuple(each)]
    known = np.isfinite(values) & inside
    known, density = (np.moveaxis(v, axis + 1, -1) for v in (known, np.where(known, values, 0.0)))
    blocks = (*known.shape[:-1], -1, every)
    count = known.reshape(blocks).sum(-1)
    mean = density.reshape(blocks).sum(-1) / np.maximum(count, 1)
    padded = [np.concatenate([v[..., :1], v, v[..., -1:]], -1) for v in (mean, count)]
    before, after = (np.where(padded[1][..., s] > 0, padded[0][..., s], mean) for s in (np.s_[:-2], np.s_[2:]))
    place = (np.arange(every) + 0.5) / every - 0.5  # of a small cell in the cell, from its middle
    beside = np.where(place < 0, before[..., None], after[..., None])
    line = mean[..., None] + np.abs(place) * (beside - mean[..., None])
    off = np.where(known.reshape(blocks), density.reshape(blocks) - line, 0.0)
    step = float(np.diff(of.ends[axis][:2])[0])
    return float(np.ptp(np.cumsum(off - off.mean(-1, keepdims=True), -1), axis=-1).max()) * step


def averaged(of: Look, ends: Sequence[Values]) -> tuple[Values, Values]:
    """In the cells of a coarser grid, from `ends` to ends along each axis: which share of each lies in the part, of the
    most that can, and its period (k, cells), the inverse of the mean of 1 / w; NaN where it is none.

    A cell that reaches beyond the box of the part is looked at within it: a plate may be thinner than a cell.
    """
    matrices, inner, most = [], [], 1.0
    for coarse, fine in zip(ends, of.ends, strict=True):
        overlap = np.clip(coarse[1:, None], fine[:-1], fine[1:]) - np.clip(coarse[:-1, None], fine[:-1], fine[1:])
        beyond = overlap.sum(1) <= 0
        edge = np.where(coarse[:-1] >= fine[-1], len(fine) - 2, 0)
        matrices.append(np.where(beyond[:, None], np.arange(len(fine) - 1) == edge[:, None], overlap))
        inner.append(~beyond)
        most *= overlap.sum(1).max()
    right = np.broadcast_to(np.isfinite(of.density), (len(of.density), *of.inside.shape))
    counted = right & of.inside
    total, sum_ = _contracted(matrices, counted), _contracted(matrices, np.where(counted, of.density, 0.0))
    share = np.where(np.logical_and.outer(np.logical_and.outer(inner[0], inner[1]), inner[2]), total.max(0) / most, 0.0)
    if (total == 0).any():  # beyond the part it is the field's own, where that is a period
        others = _contracted(matrices, right), _contracted(matrices, np.where(right, of.density, 0.0))
        total, sum_ = (np.where(total == 0, other, v) for v, other in zip((total, sum_), others, strict=True))
    return share, np.divide(total, sum_, out=np.full(total.shape, np.nan), where=total > 0)


def _contracted(matrices: Sequence[Values], values: NDArray[Any]) -> Values:
    """Fields (k, nx, ny, nz) with a matrix for each axis."""
    x, y, z = matrices
    values = y @ (values.astype(np.float64) @ z.T)
    k, nx, *others = values.shape
    return np.asarray((x @ values.reshape(k, nx, -1)).reshape(k, len(x), *others))


def _sparse(places: Sequence[Values]) -> list[Values]:
    return list(np.meshgrid(*places, indexing="ij", sparse=True))


def _samples(ends: Values, finer: int) -> Values:
    """The middles of the parts of cells that are cut into so many."""
    step = np.diff(ends)[:, None] / finer
    return np.asarray((ends[:-1, None] + step * (np.arange(finer) + 0.5)).reshape(-1))


def _finer(along: Sequence[int]) -> list[int]:
    """Into how many parts each cell is cut along the axes that count: an odd number, so that one is its middle."""
    most = FINEST
    while most > 1 and prod(n * most for n in along if n > 1) > SAMPLES:
        most -= 2
    return [most if n > 1 else 1 for n in along]


def _is_period(values: Values) -> Flags:
    return np.asarray((values >= NEAREST) & (values <= LARGEST_VALUE))


def _means(parts: Values) -> tuple[Values, Values, Values]:
    """Of the periods along the last axis the mean of 1 / w, NaN where none is one, and the least and the most."""
    right = _is_period(parts)
    count = right.sum(-1)
    sum_ = np.divide(1.0, parts, out=np.zeros(parts.shape), where=right).sum(-1)
    density = np.where(count > 0, sum_ / np.maximum(count, 1), np.nan)
    return density, np.where(right, parts, np.inf).min(-1), np.where(right, parts, -np.inf).max(-1)


def _look_closer(
    period: Field,
    ends: tuple[Values, Values, Values],
    within: Flags,
    whole: Flags,
    values: Values,
    into: tuple[Values, Values, Values],
) -> None:
    """Put the means of more samples, and the extremes of them, `into` the cells where a period varies quickly."""
    quick = np.zeros(values.shape[1:])
    with np.errstate(all="ignore"):
        logs = np.log(values)
        for axis in range(3):
            step = np.moveaxis(np.abs(np.diff(logs, axis=axis + 1)).max(0), axis, 0)
            here = np.moveaxis(quick, axis, 0)
            here[:-1], here[1:] = np.fmax(here[:-1], step), np.fmax(here[1:], step)
    quick = np.where(within, quick, 0.0) if quick.shape == within.shape else quick
    cells = np.flatnonzero(quick > QUICK)
    if len(cells) > MOST_CLOSE:
        cells = cells[np.argsort(quick.reshape(-1)[cells])[-MOST_CLOSE:]]
    if not len(cells):
        return
    at = tuple(np.unravel_index(cells, quick.shape))
    aside = np.stack(np.meshgrid(*[(np.arange(CLOSE) + 0.5) / CLOSE] * 3, indexing="ij"), -1).reshape(-1, 3)
    x, y, z = (
        e[i][:, None] + (e[i + 1] - e[i])[:, None] * aside[:, a] for a, (e, i) in enumerate(zip(ends, at, strict=True))
    )
    parts = components(period)(x, y, z)
    wrong = whole.reshape(-1)[cells][:, None] & ~_is_period(parts)
    if wrong.any():
        c, n, m = (int(v) for v in np.argwhere(wrong)[0])
        raise _none(float(parts[c, n, m]), (float(x[n, m]), float(y[n, m]), float(z[n, m])))
    for field, found in zip(into, _means(parts), strict=True):
        field.reshape(len(field), -1)[:, cells] = found


def _check(asked: Values, cells: Flags, place: Callable[[Sequence[int], int], Sequence[float]]) -> None:
    """Refuse periods (k, ...) that are none in some small cells. Errors: E147."""
    wrong = cells & ~_is_period(asked)
    if wrong.any():
        c, *at = (int(v) for v in np.argwhere(wrong)[0])
        raise _none(float(np.broadcast_to(asked, wrong.shape)[(c, *at)]), place(at, c))


def _place(ends: Sequence[Values], cell: Sequence[int], finer: Sequence[int], sample: int) -> list[float]:
    """Where a sample of a small cell lies."""
    parts = np.unravel_index(sample, tuple(finer))
    return [
        float(e[i] + (e[i + 1] - e[i]) * (j + 0.5) / f) for e, i, j, f in zip(ends, cell, parts, finer, strict=True)
    ]


def _none(asked: float, place: Sequence[float]) -> Exception:
    return fail("E147", f"the period that is asked for is {asked:.3g} mm at ({coordinates(place)})",
                hint="a period is a length above 0 everywhere within the part")  # fmt: skip


def _surrounded(cells: Flags) -> Flags:
    """The inner cells of which all neighbours are among them."""
    for axis in range(3):
        wide = np.moveaxis(cells, axis, 0)
        cells = np.moveaxis(wide[:-2] & wide[1:-1] & wide[2:], 0, axis)
    return cells
