"""Regular grids as readers hand them on."""

from __future__ import annotations

from dataclasses import astuple, dataclass, replace

import numpy as np

from porelang.data import SampledField, Triple
from porelang.tasks.readers.asked import Array, Asked, floats, placed, usable
from porelang.tasks.readers.got import Got


@dataclass(frozen=True, slots=True)
class Grid:
    """Samples, and at each node how far outside of what was sampled it lies, in mm, below 0 inside (nx, ny, nz).

    Without `depth` what was sampled is the box of the nodes.
    """

    samples: SampledField
    depth: Array | None = None

    def part(self, masked: bool) -> SampledField:
        """The samples, where `masked` with the depth as one component more."""
        samples = self.samples
        if not masked:
            return samples
        depth = np.full(samples.shape, -min(samples.spacing)) if self.depth is None else self.depth
        values = floats(np.concatenate([samples.values, depth[..., None].astype(samples.values.dtype)], axis=3))
        return SampledField(values, samples.origin, samples.spacing, samples.facts)


def grid_of(
    asked: Asked, values: Array, origin: Triple, spacing: Triple, cells: bool = False, named: bool = False
) -> Grid:
    """The grid of values (nx, ny, nz, k) at nodes, of which `origin` is the first; or in `cells`, where it is the first
    corner. Where it is asked what holds outside of the data, nodes that are not a number lie there.

    Errors: E134.
    """
    placed(asked, values.shape, origin, spacing)
    values, depth = _without_gaps(values, spacing) if asked.masked else (values, None)
    usable(asked, values, "cell" if cells else "node")
    found = Grid(SampledField(floats(values), origin, spacing), depth)
    grid = _in_cells(found) if cells else found
    low = np.array(origin)
    high = low + np.array(spacing) * (np.array(values.shape[:3]) - (not cells))
    got = Got(0, 0, min(spacing), 0.0, 0.0, float(values.min()), float(values.max()), 0.0, 0, named, *low, *high)
    return replace(grid, samples=replace(grid.samples, facts=tuple(map(float, astuple(got)))))


def _without_gaps(values: Array, spacing: Triple) -> tuple[Array, Array | None]:
    """Values that go on where there are none, and how far outside of those there are each node lies; it begins half a
    step from them."""
    gaps = np.isnan(values).any(axis=3) if values.dtype.kind == "f" else np.zeros(1, np.bool_)
    if not gaps.any() or gaps.all():
        return values, None
    from scipy.ndimage import distance_transform_edt

    half = min(spacing) / 2
    away, nearest = distance_transform_edt(gaps, spacing, return_indices=True)
    depth = np.where(gaps, away - half, half - distance_transform_edt(~gaps, spacing))
    return values[tuple(nearest)], np.clip(depth, -4 * half, 4 * half)


def _in_cells(cells: Grid) -> Grid:
    """A grid of values in cells (of which `origin` is the first corner) as one of nodes in their middles.

    A layer more on each side carries on what the cells at the border have, as far as these go.
    """
    spacing = cells.samples.spacing
    first = np.array(cells.samples.origin) - np.array(spacing) / 2
    values = floats(np.pad(cells.samples.values, [(1, 1)] * 3 + [(0, 0)], mode="edge"))
    # in steps of each axis, from which the border is half a step to either side: along each axis the 0 lies there
    away = [np.clip(np.abs(np.arange(n) - (n - 1) / 2) - (n - 2) / 2, -0.5, 0.5) for n in values.shape[:3]]
    depth = min(spacing) * np.maximum(np.maximum(away[0][:, None, None], away[1][:, None]), away[2])
    if cells.depth is not None:
        depth = np.maximum(depth, np.pad(cells.depth, 1, mode="edge"))
    x, y, z = first.tolist()
    return Grid(SampledField(values, (x, y, z), spacing), depth)
