"""A part as voxels, what holds it and what loads it: the homogenised problem, in which a voxel has a density.

The part is immersed: a voxel that the boundary cuts counts by the share of it that is filled.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from porelang.diagnostics import PoreError, fail

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
#: Which of the places (n, 3) mm are meant.
Where = Callable[[Array], Flags]
AXES = "xyz"
#: Filled by less than this, a voxel is left out: it would only make the equations stiff.
LEAST_FILL = 1e-3


@dataclass(frozen=True, eq=False)
class Grid:
    """Voxels in a box: `fill` (nx, ny, nz), the share of each that belongs to the part; `origin` and `spacing` in mm.

    >>> Grid(np.ones((4, 2, 2)), (0, 0, 0), (0.5, 0.5, 0.5)).volume
    2.0
    """

    fill: Array
    origin: tuple[float, float, float]
    spacing: tuple[float, float, float]

    @classmethod
    def of(cls, inside: Callable[[Array], Array], low: Sequence[float], high: Sequence[float], size: float) -> Grid:
        """Voxels of at most `size` mm in a box; `inside` is a field (n, 3) -> (n,), negative in the part.

        A voxel is filled as 4 x 4 x 4 points in it say.
        """
        ends = np.array([low, high], float)
        counts = np.maximum(1, np.ceil((ends[1] - ends[0]) / size - 1e-9)).astype(int)
        step = (ends[1] - ends[0]) / counts
        fine = [ends[0, a] + (np.arange(4 * counts[a]) + 0.5) * step[a] / 4 for a in range(3)]
        fill = np.empty(tuple(counts))
        for i in range(counts[0]):  # one layer at a time, for memory
            points = np.stack(np.meshgrid(fine[0][4 * i : 4 * i + 4], fine[1], fine[2], indexing="ij"), -1)
            hit = (inside(points.reshape(-1, 3)) < 0).reshape(4, counts[1], 4, counts[2], 4)
            fill[i] = hit.mean((0, 2, 4))
        fill[fill < LEAST_FILL] = 0
        x, y, z = ends[0].tolist()
        dx, dy, dz = step.tolist()
        return cls(fill, (x, y, z), (dx, dy, dz))

    @cached_property
    def mask(self) -> Flags:
        """The voxels (nx, ny, nz) that count."""
        return self.fill > 0

    @property
    def shape(self) -> tuple[int, int, int]:
        nx, ny, nz = self.fill.shape
        return nx, ny, nz

    @cached_property
    def weights(self) -> Array:
        """The volume (m,), mm3, of each voxel that counts, in the order of `fill[mask]`."""
        weights: Array = self.fill[self.mask] * float(np.prod(self.spacing))
        return weights

    @property
    def volume(self) -> float:
        """The volume of the part as voxels, mm3."""
        return float(self.weights.sum())

    @cached_property
    def centres(self) -> Array:
        """The middles (m, 3) of the voxels that count, mm."""
        places: Array = np.array(self.origin) + (np.argwhere(self.mask) + 0.5) * np.array(self.spacing)
        return places

    def nearest(self, places: Array) -> NDArray[np.intp]:
        """The voxel that counts (0..m-1) in or nearest to each place (n, 3) mm."""
        at = np.floor((places - np.array(self.origin)) / np.array(self.spacing)).astype(np.intp)
        at = np.clip(at, 0, np.array(self.shape) - 1)
        number = np.zeros(self.shape, np.intp)
        number[self.mask] = np.arange(len(self.weights))
        index = distance_transform_edt(~self.mask, return_distances=False, return_indices=True)
        found: NDArray[np.intp] = number[tuple(index)][tuple(at.T)]
        return found

    def node_places(self, nodes: NDArray[np.intp]) -> Array:
        """The places (n, 3) mm of nodes, given by their numbers in the grid (nx+1, ny+1, nz+1)."""
        nx, ny, nz = self.shape
        index = np.stack(np.unravel_index(nodes, (nx + 1, ny + 1, nz + 1)), -1)
        places: Array = np.array(self.origin) + index * np.array(self.spacing)
        return places

    @cached_property
    def faces(self) -> tuple[NDArray[np.intp], Array, Array]:
        """The faces between a voxel that counts and none: their nodes (f, 4), middles (f, 3) mm, areas (f,) mm2."""
        nx, ny, nz = self.shape
        step = np.array(self.spacing)
        nodes, centres, areas = [], [], []
        padded = np.pad(self.mask, 1)
        for axis in range(3):
            others = [a for a in range(3) if a != axis]
            for side in (0, 1):
                beyond = np.roll(padded, 1 - 2 * side, axis)[1:-1, 1:-1, 1:-1]
                cells = np.argwhere(self.mask & ~beyond)
                corner = cells.copy()
                corner[:, axis] += side
                ring = []
                for p in (0, 1):
                    for q in (0, 1):
                        at = corner.copy()
                        at[:, others[0]] += p
                        at[:, others[1]] += q
                        ring.append(np.ravel_multi_index(tuple(at.T), (nx + 1, ny + 1, nz + 1)))
                nodes.append(np.stack(ring, 1))
                middle = corner + 0.5
                middle[:, axis] -= 0.5
                centres.append(np.array(self.origin) + middle * step)
                areas.append(step[others].prod() * self.fill[tuple(cells.T)])
        return np.concatenate(nodes), np.concatenate(centres), np.concatenate(areas)

    def surface_nodes(self, where: Where, what: str) -> NDArray[np.intp]:
        """The numbers of the nodes on the surface for which `where` holds. Errors: E191 where there are none."""
        nodes = np.unique(self.faces[0])
        places = self.node_places(nodes)
        chosen = np.asarray(where(places), bool)
        if not chosen.any():
            raise self._nothing(what, places)
        found: NDArray[np.intp] = nodes[chosen]
        return found

    def surface_faces(self, where: Where, what: str) -> tuple[NDArray[np.intp], Array]:
        """The nodes (f, 4) and areas (f,) of the faces whose middles fulfil `where`. Errors: E191."""
        nodes, centres, areas = self.faces
        chosen = np.asarray(where(centres), bool)
        if not chosen.any():
            raise self._nothing(what, centres)
        return nodes[chosen], areas[chosen]

    def _nothing(self, what: str, places: Array) -> PoreError:
        low, high = places.min(0), places.max(0)
        box = ", ".join(f"{AXES[a]} {low[a]:.6g} to {high[a]:.6g}" for a in range(3))
        return fail("E191", f"{what} selects nothing of the surface: the grid of voxels spans {box} mm",
                    hint="a plane is met with some room: `z < -149mm` for an end at -150 mm")  # fmt: skip


@dataclass(frozen=True, slots=True)
class Support:
    """Nodes of the surface that do not move along the axes named."""

    where: Where
    axes: tuple[bool, bool, bool] = (True, True, True)
    name: str = "a support"


@dataclass(frozen=True, slots=True)
class Force:
    """A force (3,) N in all, spread evenly over the faces of the surface where `where` holds."""

    where: Where
    total: tuple[float, float, float]
    name: str = "a force"


@dataclass(frozen=True, slots=True)
class Moment:
    """A couple (3,) N mm in all about the middle of the faces of the surface where `where` holds: forces that grow with
    the distance from it, and add up to none."""

    where: Where
    total: tuple[float, float, float]
    name: str = "a torque"


@dataclass(frozen=True, slots=True)
class Platen:
    """A stiff plate that pushes with `force` N along `axis`: the nodes under it move alike along that axis.

    `bonded`: they do not move across it. A problem with a platen has no other force.
    """

    where: Where
    force: float
    axis: int = 2
    bonded: bool = False
    name: str = "a platen"


@dataclass(frozen=True, slots=True)
class Problem:
    """A grid, what holds it, and what loads it: forces and couples, or one platen."""

    grid: Grid
    supports: tuple[Support, ...]
    loads: tuple[Force | Moment | Platen, ...]
