"""What the homogenised lattice promises: its own law, found by homogenising it, and the loop on voxels with that.

Where stiffness rises faster than density the uniform density is stationary and not the best, so optimality criteria
begin twice: from the uniform density and from a dense core.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from porelang.diagnostics import Diagnostic, PoreError, fail
from porelang.homogenize import Homogenized, material
from porelang.homogenize.cell import lattice_of
from porelang.optimize import loop
from porelang.optimize.adapting import Adapting
from porelang.optimize.grid import Grid, Problem
from porelang.optimize.laws import Lattice, Thickness, is_material
from porelang.optimize.posed import posed
from porelang.optimize.rules import Optimum, Rule
from porelang.optimize.spread import averaged, restored
from porelang.progress import activity, tell
from porelang.tasks.study.asked import POISSON, YOUNG, Question, question, valued
from porelang.unitcell.law import Law, law
from porelang.unitcell.moduli import cubic

Array = NDArray[np.float64]
#: How many densities of the lattice are homogenised, and the voxels along its cell.
DENSITIES, VOXELS = 7, 32
#: A lower limit that the density of whole cells misses by no more is reached: below its first sample a law goes to 0.
NEAR = 0.005
#: When optimality criteria end: they leave the uniform density by less than a percent a step.
UNTIL, MOST = 3e-4, 60
#: What a lattice of few cells differs by from one of many, times the cells across, and times those across what is
#: loaded. Walls that the sides cut carry little, and a face of few cells gives way between its walls: of eight
#: lattices, 2 to 4 cells across, bent and pulled, the softest were softer by .63 over the cells; a patch of 1.2 cells
#: on a thick cylinder gave way by .2 more (docs/decisions/0019).
SIDES, LOADED = 0.65, 0.25
#: What is further than this (relative) from cubic is doubted as such.
CUBIC = 0.05


@dataclass(frozen=True, eq=False)
class Promise:
    """A density (m,) of the voxels of a grid, found on the homogenised lattice by `rule` in so many `steps`.

    `path` are the compliances (N mm) of all steps of the run that found it, from the density where it began; `voxel` is
    the side (mm) of the voxels. `uniform`
    and `best` are compliances with their relative errors: what the voxels and the law err by, and what is not known of
    so few cells, `few`, as there are `across` the part.
    """

    rule: str
    law: Law
    density: Array
    uniform: float
    best: float
    errors: tuple[float, float]
    across: float
    few: float
    steps: int
    path: tuple[float, ...]
    doubts: tuple[Diagnostic, ...]
    voxel: float = 0.0

    @property
    def gain(self) -> float:
        """The compliance over that of the uniform lattice."""
        return self.best / self.uniform

    @property
    def is_uniform(self) -> bool:
        """Whether the best density is the same all over."""
        return bool(np.ptp(self.density) < 1e-12)

    @property
    def gain_error(self) -> float:
        """How far the gain may be off for so few cells; what else both compliances err by is alike, and cancels."""
        return self.few * self.gain

    @property
    def report(self) -> dict[str, Any]:
        """What `pore optimize --json` prints of it."""
        first, last = self.errors
        return {"rule": self.rule, "steps": self.steps, "uniform": self.uniform, "uniform_error": first,
                "best": self.best, "best_error": last, "gain": self.gain, "gain_error": self.gain_error,
                "path": list(self.path),
                "cells_across": self.across, "few_cells_error": self.few,
                "law": {"density": self.law.density.tolist(), "constants": self.law.constants.tolist(),
                        "nu": self.law.nu}}  # fmt: skip

    def __str__(self) -> str:
        first, last = (
            f"{c:.5g}{f' +- {e:.1%}' if np.isfinite(e) else ''}"
            for c, e in zip((self.uniform, self.best), self.errors, strict=True)
        )
        begun = f"homogenised, {self.rule}, {self.steps} steps: "
        known = f" +- {self.gain_error:.2g}" if np.isfinite(self.errors).all() else ""
        text = f"from {first} to {last} N mm, {self.gain:.3f}{known} of the uniform compliance"
        if self.is_uniform:
            text = f"{first} N mm, and no density is stiffer than the uniform one"
        if not known:
            return (f"{begun}{text}; how far that is off cannot be judged: what is held or loaded is too small for "
                    f"voxels of {2 * self.voxel:.3g} mm, which would tell")  # fmt: skip
        where = "" if self.few == SIDES / self.across else " what is loaded"
        many = (LOADED if where else SIDES) / self.few
        of = f"{self.few:.0%} for the {many:.2g} cell{'s' * (f'{many:.2g}' != '1')} across{where}"
        return f"{begun}{text}; each error has {of}"


def promise(
    what: Adapting, thickness: Thickness, sign: float, grid: Grid, cell: float, plan: loop.Plan, rule: Rule
) -> Promise:
    """The loop of a design on voxels; `thickness` and `sign` make its densities, `cell` (mm) is its period.

    Errors: those of the cell (E180-E183), of what the homogenised part cannot take (E193), of the solution (E190-E194).
    """
    asked = question(what.design.formula(*what.design.program.studies[what.study].args).taken)
    nu = _poisson(asked, grid)
    found, doubts = law_of(what, thickness, sign, cell, nu, plan.low, plan.high)
    if found.range[1] < plan.high:
        reached = np.floor(100 * found.range[1] - 1e-6) / 100
        raise fail("E192", f"whole cells of `{what.output}` reach a density of {found.range[1]:.3f}, and not the "
                   f"{plan.high:g} that the part has with the same `{what.param}`",
                   hint=f"narrow the limits, as in --limits {plan.low:g}..{reached:g}" if reached > plan.mean else
                   "take the rule `energy`, which solves the lattice alone")  # fmt: skip
    problem = posed(asked, grid)
    analysis = loop.Homogenised(problem, _lattice(found, asked, grid))
    optimal = isinstance(rule, Optimum)
    until, most = (UNTIL, MOST) if optimal else (plan.until, plan.most)
    inner = replace(plan, cell=cell, until=until, most=most)
    starts = [None, core(grid, plan)] if optimal else [None]
    uniform = np.full(len(grid.weights), plan.mean)
    with activity("adapting the homogenised part"):
        runs = [loop.iterate(analysis, rule, inner, start) for start in starts]
    for run in runs:
        if run.failed:  # half a promise is none
            raise PoreError(run.failed)
    best = min(runs, key=lambda run: run.steps[run.best].compliance)
    first, last = runs[0].steps[0].compliance, best.steps[best.best].compliance
    rough = _coarser(asked, grid, found, (uniform, best.density), plan)
    slack = float(np.max(found.error(plan.mean) / np.maximum(np.abs(found.cubic(plan.mean)), 1e-12)))
    across = cells_across(grid, cell)
    few = max(SIDES / across, LOADED / loaded_across(problem, cell))
    errors = [abs(r / c - 1) + slack + few for r, c in zip(rough, (first, last), strict=True)]
    return Promise(rule.name, found, best.density, first, last, (errors[0], errors[1]), across, few, best.best,
                   tuple(step.compliance for step in best.steps), tuple(doubts), max(grid.spacing))  # fmt: skip


def law_of(
    what: Adapting, thickness: Thickness, sign: float, cell: float, nu: float, low: float, high: float
) -> tuple[Law, list[Diagnostic]]:  # fmt: skip
    """The law of a design's lattice between two limits of its density, and what is doubtful of it.

    Whole cells have another density than a part that cuts them: where those of a limit do not reach it, the next that
    the thickness has beyond is taken too; below the lower one only if it is a material. Errors: those of the cell,
    E192 for a density within the limits at which it is none.
    """
    asked = np.linspace(low, high, DENSITIES)
    least, most = thickness.limits
    cells = _Cells(what, thickness, sign, cell, nu)
    with activity("homogenising the lattice"):
        found = []
        for i, density in enumerate(asked):
            tell(i, DENSITIES)
            found.append(cells.at(float(density)))
        _refuse_pieces(what, asked, is_material(np.array([cubic(f.stiffness) for f in found])))
        if found[-1].density < high and most > high:
            found.append(cells.at(most))
        if found[0].density > low + NEAR and least < low:
            found = [*cells.sound(least), *found]
    made = law([f.density for f in found], [f.stiffness for f in found], [f.stiffness_error for f in found], nu)
    doubts = []
    if made.away > CUBIC:
        doubts.append(Diagnostic(
            "W271", f"the cell of `{what.output}` is {made.away:.0%} away from a cubic one", severity="warning",
            hint="what is promised is of the cubic lattice that is nearest: trust what elements say"))  # fmt: skip
    return made, doubts


@dataclass(frozen=True, eq=False)
class _Cells:
    """The lattice of a design, homogenised with the thickness that gives a density, for a solid of Poisson's ratio
    `nu`."""

    what: Adapting
    thickness: Thickness
    sign: float
    cell: float
    nu: float

    @cached_property
    def _own(self) -> bool:
        """Whether the cell is the period of the lattice itself."""
        return abs(self.what.cell() / self.cell - 1) < 1e-6

    def at(self, density: float) -> Homogenized:
        """Errors: those of the cell, with the value of the param."""
        what, value = self.what, self.sign * float(self.thickness.thickness(np.array([density]))[0])
        middle = np.mean([what.box.lo, what.box.hi], axis=0).tolist()  # a phase is known there, and not everywhere
        part = what.part(what.same_all_over(value))
        # where the param is the size of the cells, each has its own
        sides = np.full(3, what.cell(part) if self._own else self.cell)
        try:
            return material(lattice_of(part), what.output, sides, self.nu, VOXELS, middle=middle, reach=what.box)
        except PoreError as error:
            told = f"with {what.param} = {value:.4g}, for the law of the lattice, whose cells are "
            told += "as long as its waves are" if self._own else "said to be so long"
            raise PoreError([replace(d, message=f"{d.message}, {told}") for d in error.diagnostics]) from None

    def sound(self, density: float) -> list[Homogenized]:
        """The same at a density that nobody asked for: nothing where it is no material, as a law goes on to 0 there."""
        try:
            found = self.at(density)
        except PoreError:
            return []
        return [found] if is_material(np.array([cubic(found.stiffness)])).all() else []


def _refuse_pieces(what: Adapting, asked: Array, sound: NDArray[np.bool_]) -> None:
    """Errors: E192 where the lattice is no material at one of the densities, with limits within which it is."""
    if sound.all():
        return
    at = asked[~sound]
    first = int(np.flatnonzero(~sound).max()) + 1
    hint = "take a lattice that holds together there, or the rule `energy`"
    if first < len(asked) - 1:
        hint = (
            f"narrow the limits, as in --limits {np.ceil(100 * asked[first] - 1e-6) / 100:g}..{asked[-1]:g}, or {hint}"
        )
    raise fail("E192", f"`{what.output}` is no material at the density {at.max():.3g}: there its cells are in pieces, "
               "or hang together by necks that some strain does not feel", hint=hint)  # fmt: skip


def cells_across(grid: Grid, cell: float) -> float:
    """How many cells (of the side in mm) the largest sphere in a part has across, or its box if that is less."""
    sides = np.array(grid.shape) * np.array(grid.spacing)
    return float(min(2 * _depth(grid).max(), sides.min()) / cell)


def loaded_across(problem: Problem, cell: float) -> float:
    """How many cells (of the side in mm) the smallest of what is loaded has across: the root of its area."""
    _, middles, areas = problem.grid.faces
    return float(min(np.sqrt(areas[load.where(middles)].sum()) for load in problem.loads) / cell)


def _depth(grid: Grid) -> Array:
    """How far (mm) voxels are from the surface."""
    found = distance_transform_edt(np.pad(grid.mask, 1), sampling=grid.spacing)[1:-1, 1:-1, 1:-1]
    return np.asarray(found[grid.mask], np.float64)


def core(grid: Grid, plan: loop.Plan) -> Array:
    """A density that is greater in the middle of a part than near its surface."""
    deep = _depth(grid)
    wanted = plan.mean * deep / np.average(deep, weights=grid.weights)
    low, high = np.full(len(deep), plan.low), np.full(len(deep), plan.high)
    return restored(lambda s: wanted * np.exp(s), low, high, grid.weights, plan.mean)


def _poisson(asked: Question, grid: Grid) -> float:
    """Poisson's ratio of the solid. Errors: E193 where it varies."""
    values = valued(asked.poisson, grid.centres, *POISSON)
    if np.ptp(values) > 1e-9:
        raise fail("E193", f"Poisson's ratio of the solid varies, from {values.min():.3g} to {values.max():.3g}",
                   hint="a lattice is homogenised for one of them; or take the rule `energy`")  # fmt: skip
    return float(values[0])


def _lattice(found: Law, asked: Question, grid: Grid) -> Lattice:
    return Lattice(found, valued(asked.young, grid.centres, *YOUNG))


def _coarser(
    asked: Question, grid: Grid, found: Law, densities: tuple[Array, Array], plan: loop.Plan
) -> list[float]:  # fmt: skip
    """The compliances of densities on voxels twice as large, where these can be had; infinite where not."""
    fill = grid.fill
    fill = np.pad(fill, [(0, n % 2) for n in fill.shape])
    x, y, z = (n // 2 for n in fill.shape)
    whole = fill.reshape(x, 2, y, 2, z, 2).mean((1, 3, 5))
    dx, dy, dz = grid.spacing
    coarse = Grid(whole, grid.origin, (2 * dx, 2 * dy, 2 * dz))
    out = []
    try:
        analysis = loop.Homogenised(posed(asked, coarse), _lattice(found, asked, coarse))
    except PoreError:  # too coarse for what holds it
        return [np.inf] * len(densities)
    for density in densities:
        near = averaged(grid, 1.5 * max(grid.spacing))(density)[grid.nearest(coarse.centres)]
        low, high = np.full(len(near), plan.low), np.full(len(near), plan.high)
        kept = restored(lambda s, near=near: near + s, low, high, coarse.weights, plan.mean)  # type: ignore[misc]  # a default binds now
        out.append(analysis.solve(kept, None).compliance)
    return out
