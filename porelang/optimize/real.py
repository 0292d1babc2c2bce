"""The analysis of the real lattice: a study of the program, solved in tetrahedra for each density in turn.

A density becomes thickness by the lattice's own law, all of it moved by one number until the porosity, as it is
measured, is that of the plan. What elements bear is gathered in voxels, and averaged over a cell as energy of the solid
over its volume: the walls that a cell happens to be cut at count for neither.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from porelang.data import SampledField
from porelang.optimize.adapting import Adapting
from porelang.optimize.grid import Grid
from porelang.optimize.laws import Thickness
from porelang.optimize.loop import digest
from porelang.optimize.rules import Answer
from porelang.optimize.spread import averaged
from porelang.program import Design
from porelang.tasks.resolve import named
from porelang.tasks.study.asked import question
from porelang.tasks.study.found import doubts_of
from porelang.tasks.study.numbers import form_error
from porelang.tasks.study.sized import Sized
from porelang.tasks.study.solved import Solved, solved
from porelang.tasks.told import Doubt

Array = NDArray[np.float64]
#: By how much a porosity may miss its target, and how often thickness is moved for it at most.
POROSITY, _MOVES = 2e-4, 12
#: How much of what elements leave of stresses (twice the square of the estimate) a mesh strays by, as it cuts walls in
#: its own way. Of 14 lattices (networks of gyroid, diamond and P, uniform and adapted) that join as their parts do a
#: compliance moved by .17 of it at most where elements became finer by 1.3 to 1.5 (docs/decisions/0019).
_STRAYS = 0.17
#: What the solver doubts of loads and elements, and a study does not say itself: a force on a point, locking.
_OF_THE_SOLVER = frozenset({"W258", "W259"})


class Real:
    """A study in tetrahedra, for densities (m,) of the voxels of a grid: `thickness` makes these, `sign` times the
    param of the program. `cell` (mm) is what is averaged over, `mean` the density to be kept; `begun` is told of the
    elements of the first that is solved, before they are made."""

    def __init__(
        self, adapting: Adapting, grid: Grid, thickness: Thickness, sign: float, cell: float, mean: float,
        begun: Callable[[Sized], None] | None = None,
    ) -> None:  # fmt: skip
        self._begun = begun
        self.adapting, self._grid, self._thickness, self._sign = adapting, grid, thickness, sign
        self._mean, self._cell = mean, cell
        self._average: Callable[[Array], Array] = averaged(grid, cell)
        uniform = sign * float(thickness.thickness(np.array([mean]))[0])
        self._key = digest(
            np.frombuffer(_identity(adapting, uniform).encode(), np.uint8), grid.fill,
            np.array([grid.origin, grid.spacing]), thickness.densities, thickness.values, np.array([sign, cell, mean]),
        )  # fmt: skip

    @property
    def grid(self) -> Grid:
        return self._grid

    @property
    def key(self) -> str:
        return self._key

    @property
    def cell(self) -> float:
        return self._cell

    def solve(self, density: Array, state: Array | None) -> Answer:
        """Errors: those of the study."""
        samples, share = self.samples(density)
        begun, self._begun = self._begun, None
        found = study_of(self.adapting.with_samples(samples), self.adapting.study, begun)
        return self._answer(density, found, samples, share)

    def samples(self, density: Array) -> tuple[SampledField, float]:
        """Samples for the param that make these densities, and the share of solid that the part then has."""
        share_of = self.adapting.density
        moved, before, missed = 0.0, 0.0, 0.0
        samples = self._sampled(density)
        share = share_of(samples)
        for count in range(_MOVES):
            off = share - self._mean
            if abs(off) < POROSITY:
                break
            # regula falsi with what the last move did; at first a step of density moves the share as much
            rate = 1.0 if not count or missed == off else (missed - off) / (before - moved)
            before, missed = moved, off
            moved -= off / (rate if 0.2 < rate < 5 else 1.0)
            samples = self._sampled(density + moved)
            share = share_of(samples)
        return samples, share

    def _sampled(self, density: Array) -> SampledField:
        return sampled(self._grid, self._sign * self._thickness.thickness(density))

    def _answer(self, density: Array, found: Solved, samples: SampledField, share: float) -> Answer:
        mesh, fields = found.mesh, found.fields
        corners = mesh.vertices[mesh.tets]
        volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
        there = self._grid.nearest(corners.mean(axis=1))
        solid = self._average(_gathered(there, volumes, self._grid) / self._grid.weights)
        energy, stress = (
            self._average(_gathered(there, volumes * values[mesh.tets].mean(axis=1), self._grid) / self._grid.weights)
            for values in (fields.energy, fields.von_mises)
        )
        some = np.maximum(solid, 1e-3)  # no voxel is without a wall within a cell
        noise = float(np.sqrt(np.average((solid / self._average(density) - 1) ** 2, weights=self._grid.weights)))
        numbers = found.numbers
        compliance = numbers["compliance"]
        return Answer(
            abs(compliance.value), numbers["max_displacement"].value, density * energy / some, np.zeros_like(density),
            density * stress / some, noise, None, compliance.error / abs(compliance.value),
            numbers["max_von_mises"].value, 1 - share,
            {self.adapting.param: samples.values[..., 0].astype(np.float64), "origin": np.array(samples.origin),
             "spacing": np.array(samples.spacing)},
            self.adapting.under, self._doubts(found, share), apart_of(found),
        )  # fmt: skip

    def _doubts(self, found: Solved, share: float) -> tuple[Doubt, ...]:
        more = [Doubt(d.code, d.message, d.label, d.hint) for d in found.solution.doubts if d.code in _OF_THE_SOLVER]
        if abs(share - self._mean) >= POROSITY:
            said = f"the porosity is {1 - share:.2%}, where {1 - self._mean:.2%} was to be kept"
            hint = f"`{self.adapting.param}` does not reach it within the limits: widen them, as in --limits 0.1..0.9"
            more.append(Doubt("W278", said, "what is gained is not at equal mass", hint))
        return (*doubts_of(found), *more)


def apart_of(found: Solved) -> float:
    """By which share the compliance of a study may differ from what another mesh says: what elements miss of the part,
    or join otherwise, is of each mesh alone; what they leave of stresses is for the most part alike."""
    compliance = found.numbers["compliance"]
    form = form_error(found.missed)
    return float(np.hypot(form, _STRAYS * max(compliance.error / abs(compliance.value) - form, 0.0)))


def sampled(grid: Grid, values: Array) -> SampledField:
    """Values (m,) of the voxels that count as samples in their middles; outside they go on as at the nearest voxel."""
    whole = np.zeros(grid.shape)
    whole[grid.mask] = values
    nearest = distance_transform_edt(~grid.mask, return_distances=False, return_indices=True)
    whole = whole[tuple(nearest)]
    origin = np.array(grid.origin) + np.array(grid.spacing) / 2
    for axis in range(3):  # samples have two nodes at least
        if whole.shape[axis] == 1:
            whole = np.repeat(whole, 2, axis)
            origin[axis] -= grid.spacing[axis] / 2
    return SampledField.from_array(whole, origin.tolist(), grid.spacing)


def study_of(design: Design, study: str, begun: Callable[[Sized], None] | None = None) -> Solved:
    """A study of a design that a `let` names, solved; `begun` is as `solved` has it."""
    task = design.program.studies[study]
    return solved(question(design.formula(*task.args).taken), begun)


def _gathered(there: NDArray[np.intp], values: Array, grid: Grid) -> Array:
    return np.asarray(np.bincount(there, values, len(grid.weights)), np.float64)


def _identity(adapting: Adapting, value: float) -> str:
    """What the study of a design is, by content: renaming changes nothing of it, another force does."""
    design = adapting.with_samples(adapting.same_all_over(value))
    task = design.program.studies[adapting.study]
    return named(task, design.formula(*task.args).bindings)
