"""Regular grids as readers hand them on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from porelang.data import SampledField
from porelang.tasks.readers.asked import Array, floats


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


def in_cells(cells: SampledField) -> Grid:
    """A grid of values in cells (of which `origin` is the first corner) as one of nodes in their middles.

    A layer more on each side carries on what the cells at the border have, as far as these go.
    """
    step = np.array(cells.spacing)
    first = np.array(cells.origin) - step / 2
    values = floats(np.pad(cells.values, [(1, 1)] * 3 + [(0, 0)], mode="edge"))
    # in steps of each axis, from which the border is half a step to either side: along each axis the 0 lies there
    away = [np.clip(np.abs(np.arange(n) - (n - 1) / 2) - (n - 2) / 2, -0.5, 0.5) for n in values.shape[:3]]
    depth = min(cells.spacing) * np.maximum(np.maximum(away[0][:, None, None], away[1][:, None]), away[2])
    x, y, z = first.tolist()
    return Grid(SampledField(values, (x, y, z), cells.spacing), depth)
