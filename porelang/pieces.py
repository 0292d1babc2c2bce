"""The separate pieces of a part and the voids that it encloses: where each is, and how much it holds.

A closed void keeps powder or resin in a printed part until somebody drills a hole for it. Both are found among samples
in the middle of voxels, solid joined by faces, edges and corners, void by faces; what is also found among voxels 1.5
times as large, in the same place and about as large, is certain if its error leaves something of it; the rest may be a
crumb that sampling makes.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import Box
from porelang.diagnostics import fail
from porelang.field import Field

Labels = NDArray[np.int32]
MOST_NODES = 400_000_000
#: Pieces that are described one by one, the largest first; the others are counted.
MOST_DESCRIBED = 100
#: A void is where it was among coarser voxels if its volume there is within this factor.
_ALIKE = 1.5


@dataclass(frozen=True, slots=True)
class Piece:
    """A piece of solid or of void: its volume (mm3) and the error of that, a point in it, its size (mm), and whether
    coarser voxels have it too."""

    volume: float
    error: float
    at: tuple[float, float, float]
    size: tuple[float, float, float]
    certain: bool

    def told(self) -> dict[str, Any]:
        """As in `pore measure --json`."""
        return asdict(self) | {"at": list(self.at), "size": list(self.size)}


@dataclass(frozen=True, slots=True)
class Pieces:
    """The pieces of one kind, the largest first; `count` is of all, also of those that are not described."""

    count: int
    described: tuple[Piece, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """Labels of voxels (0: of neither kind), the volume of each label, and where the first voxel's middle lies."""

    labels: Labels
    volumes: NDArray[np.float64]
    origin: NDArray[np.float64]
    voxel: float


def pieces_of(part: Field, box: Box, voxel: float, coarser: float) -> tuple[Pieces, Pieces]:
    """The pieces of solid and the closed voids of a part in its box, at a voxel (mm). Errors: E114."""
    both = [(*sampled(part, box, h), h) for h in (voxel, coarser)]  # labels take more room: one kind at a time
    pieces = _described(*(_solid(*taken) for taken in both))
    return pieces, _described(*(_voids(*taken) for taken in both))


def sampled(part: Field, box: Box, voxel: float) -> tuple[NDArray[np.bool_], list[NDArray[np.float64]]]:
    """Whether the middles of voxels are solid, over a box and a layer of voxels more on every side, and their axes.

    Errors: E114.
    """
    refuse_too_many(box, voxel)
    axes = [np.arange(lo - 1.5 * voxel, hi + 2 * voxel, voxel) for lo, hi in zip(box.lo, box.hi, strict=True)]
    return np.asarray(part.on_grid(axes).all() < 0), axes


def refuse_too_many(box: Box, voxel: float) -> None:
    """Refuse a voxel (mm) of which a box holds too many. Errors: E114."""
    nodes = float(np.prod([s / voxel + 3.5 for s in box.size]))
    if nodes > MOST_NODES:
        raise fail(
            "E114",
            f"a voxel of {voxel:g} mm makes {nodes:.2g} samples, too many to count components among",
            hint=f"use a voxel of {1.1 * (box.volume / MOST_NODES) ** (1 / 3):.2g} mm or more",
        )


def _solid(solid: NDArray[np.bool_], axes: list[NDArray[np.float64]], voxel: float) -> _Found:
    from scipy import ndimage

    labels, _ = ndimage.label(solid, np.ones((3, 3, 3)))
    return _sorted_out(labels, np.zeros(0, np.int64), axes, voxel)


def _voids(solid: NDArray[np.bool_], axes: list[NDArray[np.float64]], voxel: float) -> _Found:
    from scipy import ndimage

    labels, _ = ndimage.label(~solid)
    border = [np.unique(labels.take(end, axis=axis)) for axis in range(3) for end in (0, -1)]
    return _sorted_out(labels, np.unique(np.concatenate(border)), axes, voxel)


def _sorted_out(labels: Labels, without: NDArray[np.integer[Any]], axes: list[Any], voxel: float) -> _Found:
    """The labels but for some, the largest first."""
    counts = np.bincount(labels.ravel())
    counts[0] = 0
    counts[without] = 0
    ranks = np.argsort(-counts, kind="stable")[: np.count_nonzero(counts)]
    number = np.zeros(len(counts), np.int32)
    number[ranks] = np.arange(1, len(ranks) + 1)
    volumes = np.concatenate([[0.0], counts[ranks] * voxel**3])
    return _Found(number[labels], volumes, np.array([a[0] for a in axes]), voxel)


def _described(fine: _Found, coarse: _Found) -> Pieces:
    from scipy import ndimage

    places = ndimage.find_objects(fine.labels, max_label=min(MOST_DESCRIBED, len(fine.volumes) - 1))
    return Pieces(len(fine.volumes) - 1, tuple(_piece(fine, coarse, k + 1, place) for k, place in enumerate(places)))


def _piece(fine: _Found, coarse: _Found, label: int, place: tuple[slice, slice, slice]) -> Piece:
    mine = np.pad(fine.labels[place] == label, 1)
    inner = mine.copy()
    for axis in range(3):
        for step in (1, -1):
            inner &= np.roll(mine, step, axis)
    edge = int(np.count_nonzero(mine & ~inner))
    voxels = np.argwhere(mine[1:-1, 1:-1, 1:-1])
    nearest = voxels[np.square(voxels - voxels.mean(axis=0)).sum(axis=1).argmin()]
    first = np.array([s.start for s in place])
    at = fine.origin + (first + nearest) * fine.voxel
    size = fine.voxel * np.array([s.stop - s.start for s in place])
    volume = float(fine.volumes[label])
    x, y, z = at.tolist()
    width, depth, height = size.tolist()
    change = _change(coarse, at, volume)
    # each voxel at the edge is in or out by chance: twice the spread of their sum; or all alike, along flat faces
    error = max(2 * float(np.sqrt(edge)) * fine.voxel**3, change if np.isfinite(change) else volume)
    return Piece(volume, error, (x, y, z), (width, depth, height), bool(np.isfinite(change) and error < volume))


def _change(found: _Found, at: NDArray[np.float64], volume: float) -> float:
    """By how much a piece about as large at a place, or a voxel from it, differs in volume; infinite if none is."""
    middle = np.rint((at - found.origin) / found.voxel).astype(int)
    near = found.labels[tuple(slice(max(m - 1, 0), m + 2) for m in middle)]
    there = found.volumes[np.unique(near[near > 0])]
    alike = there[(there < _ALIKE * volume) & (there > volume / _ALIKE)]
    return float(np.abs(alike - volume).min(initial=np.inf))
