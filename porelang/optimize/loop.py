"""The loop: solve, map what is borne to a density, restore its mean, and again, until it settles.

It knows nothing of what solves: voxels of a homogenised lattice, or tetrahedra of the real one, are an `Analysis`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import Diagnostic, PoreError, fail
from porelang.optimize import elasticity, record
from porelang.optimize.grid import Grid, Problem
from porelang.optimize.laws import Law
from porelang.optimize.record import Step
from porelang.optimize.rules import Answer, Frame, Rule, spread_of
from porelang.optimize.spread import averaged, restored
from porelang.progress import activity, tell

Array = NDArray[np.float64]
#: What varies by less than this, relative to its mean, is the same all over, however well it is resolved.
UNIFORM = 0.01
Reason = Literal["settled", "uniform", "rising", "most", "failed"]
#: Each reason for an end in words.
REASONS: dict[Reason, str] = {
    "settled": "the stiffness changes by less than was asked",
    "uniform": "what is borne is uniform within the noise: nothing to adapt to",
    "rising": "it became softer twice in a row",
    "most": "there were as many steps as were allowed",
    "failed": "a step could not be solved",
}


class Analysis(Protocol):
    """What is asked of a density (m,) of the voxels that count; `key` is a digest of all that it depends on, `cell`
    (mm) what it averages over itself, 0 if it leaves that to the loop."""

    @property
    def grid(self) -> Grid: ...
    @property
    def key(self) -> str: ...
    @property
    def cell(self) -> float: ...
    def solve(self, density: Array, state: Array | None) -> Answer: ...


@dataclass(frozen=True, slots=True)
class Plan:
    """What a loop keeps to: the mean density, its limits, the size of a cell (mm) over which all is averaged.

    It ends where the compliance changes by less than `until` (a ratio), or after `most` steps. `damping` is the share
    of each change that is made. There are `least` steps at any rate.
    """

    mean: float
    low: float
    high: float
    cell: float
    until: float = 0.005
    most: int = 15
    damping: float = 1.0
    least: int = 0


@dataclass(frozen=True, eq=False)
class Outcome:
    """How a loop went: its steps, which of them is the best (the stiffest), its density (m,), why it ended.

    `failed` is what was wrong with the step after the last, if that could not be solved, and `missed` what of the
    record that was gone on with was not whole.
    """

    steps: tuple[Step, ...]
    best: int
    density: Array
    reason: Reason
    failed: tuple[Diagnostic, ...] = ()
    missed: str = ""

    @property
    def gain(self) -> float:
        """The best compliance over that of the start, under equal forces."""
        return self.steps[self.best].softness / self.steps[0].softness


class Homogenised:
    """The analysis on voxels: a problem, and the law of its lattice. Errors: those of `elasticity.prepare`."""

    def __init__(self, problem: Problem, law: Law, tolerance: float = elasticity.TOLERANCE) -> None:
        self._model = elasticity.prepare(problem)
        self._law, self._tolerance = law, tolerance
        count, sample = len(problem.grid.weights), np.linspace(*law.range, 20)
        self._key = digest(
            problem.grid.fill, np.array([problem.grid.origin, problem.grid.spacing]), self._model.fixed,
            self._model.forces, np.array(self._model.pushed[2] if self._model.pushed else 0.0), law.bases,
            sample, np.array([law.weights(np.full(count, s)) for s in sample]), np.array(tolerance),
        )  # fmt: skip

    @property
    def grid(self) -> Grid:
        return self._model.problem.grid

    @property
    def key(self) -> str:
        return self._key

    @property
    def cell(self) -> float:
        return 0.0

    def solve(self, density: Array, state: Array | None) -> Answer:
        law = self._law
        found = elasticity.solve(self._model, law.weights(density), law.bases, state, self._tolerance)
        saved = (found.shares * law.slopes(density)).sum(1)
        return Answer(
            found.compliance, found.largest, found.energy, saved, found.von_mises, found.noise, found.state
        )  # fmt: skip


def digest(*arrays: NDArray[np.generic]) -> str:
    """SHA-256 of arrays, with their shapes and types."""
    out = hashlib.sha256()
    for array in arrays:
        out.update(f"{array.dtype.str}{array.shape}".encode())
        out.update(np.ascontiguousarray(array).tobytes())
    return out.hexdigest()


def iterate(
    analysis: Analysis,
    rule: Rule,
    plan: Plan,
    start: Array | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
    told: Callable[[Step], None] | None = None,
    anew: bool = False,
    seen: Callable[[list[Step], int, Answer, Array], None] | None = None,
) -> Outcome:
    """Run the loop from a density `start` (m,), the uniform one unless given, whose mean is first made the plan's.

    With a `folder` each step is written there as it is found, and `resume` goes on from the last one that is whole, to
    the very result of a run without interruption; `anew` begins in a folder that holds another loop's record. `told` is
    called with each step, `seen` with all of them, the number of the best, the last answer and its density. A step that
    cannot be solved ends the loop if it is not the first. Errors: E192 for limits that leave no room, E194, and E195
    for a folder that holds something else.
    """
    grid = analysis.grid
    frame = _frame(grid, plan)
    lows, highs = np.full(len(frame.weights), plan.low), np.full(len(frame.weights), plan.high)
    first = np.full(len(frame.weights), plan.mean) if start is None else np.asarray(start, float)
    density = restored(lambda s: first + s, lows, highs, frame.weights, plan.mean)
    content = record.content(
        analysis.key, rule.name, plan.mean, plan.low, plan.high, plan.cell or analysis.cell, plan.damping,
        digest(density),
    )  # fmt: skip
    book = None if folder is None else record.Book.open(Path(folder), content, resume, anew)
    missed = "" if book is None else book.missed
    steps: list[Step] = []
    state: Array | None = None
    best = density
    if book is not None and book.steps:
        steps = list(book.steps)
        last = book.last()
        best = book.density(_best(steps))
        density, state = last.following, last.state
        reason = _reason(steps, plan)
        if reason is not None:
            return Outcome(tuple(steps), _best(steps), best, reason, missed=missed)
    with activity("adapting"):
        while True:
            tell(len(steps), plan.most + 1)
            try:
                answer = analysis.solve(density, state)
            except PoreError as error:
                if not steps:
                    raise
                return Outcome(tuple(steps), _best(steps), best, "failed", tuple(error.diagnostics), missed)
            state = answer.state
            step = _step(len(steps), density, answer, rule, frame, steps)
            wanted = rule.next(density, answer, frame)
            following = density + plan.damping * (wanted - density)
            steps.append(step)
            if _best(steps) == step.number:
                best = density
            if book is not None:
                book.write(step, density, following, state, answer.samples)
            if told is not None:
                told(step)
            if seen is not None:
                seen(steps, _best(steps), answer, density)
            reason = _reason(steps, plan)
            if reason is not None:
                return Outcome(tuple(steps), _best(steps), best, reason, missed=missed)
            density = following


def _frame(grid: Grid, plan: Plan) -> Frame:
    if not 0 < plan.low < plan.high <= 1:
        raise fail("E192", f"the limits of the density are {plan.low:g} and {plan.high:g}",
                   hint="a density is a share of solid: 0 < least < greatest <= 1")  # fmt: skip
    if not 0 < plan.damping <= 1:
        raise fail("E192", f"a damping of {plan.damping:g} makes no loop",
                   hint="it lies in 0..1, where 1 takes every change whole, as in --damping 0.5")  # fmt: skip
    if not plan.most >= 0:
        raise fail("E192", f"{plan.most} steps at most make no loop", hint="0 or more: 0 solves the start alone")
    if not 0 < plan.until < np.inf:
        raise fail("E192", f"a loop cannot end where the compliance changes by less than {plan.until:g}",
                   hint="a small share of it, above 0: 0.5% is usual")  # fmt: skip
    if not 0 <= plan.cell < np.inf:
        raise fail("E192", f"a cell of {plan.cell:g} mm cannot be averaged over", hint="0 or more, in mm")
    return Frame(plan.mean, plan.low, plan.high, grid.weights, averaged(grid, plan.cell))


def _step(
    number: int, density: Array, answer: Answer, rule: Rule, frame: Frame, before: list[Step]
) -> Step:  # fmt: skip
    weights = frame.weights
    change = None if not before else answer.compliance / before[-1].compliance - 1
    per_density = answer.von_mises / density
    order = np.argsort(per_density)
    above = np.cumsum(weights[order]) >= 0.99 * weights.sum()
    nearly_all = float(per_density[order][above.argmax()])
    return Step(
        number, answer.compliance, answer.error, answer.peak or float(answer.von_mises.max()), nearly_all,
        answer.largest, 1 - float(np.average(density, weights=weights)) if answer.porosity is None else answer.porosity,
        change, spread_of(rule.driver(density, answer, frame), weights), answer.noise, answer.under,
        tuple((d.code, d.message, d.label, d.hint) for d in answer.doubts), answer.apart,
    )  # fmt: skip


def _best(steps: list[Step]) -> int:
    """The stiffest step; the start, where none gained more than is noise."""
    start = steps[0]
    better = [s for s in steps[1:] if 1 - s.softness / start.softness > ratio_error(start, s)]
    return min([start, *better], key=lambda step: step.softness).number


def ratio_error(start: Step, step: Step) -> float:
    """By which share the ratio of two compliances may be wrong: each mesh strays by itself (`real.apart_of`). What both
    err by alike cancels, so that it is less than what either is known to."""
    return float(np.hypot(start.apart or 0.0, step.apart or 0.0))


def _reason(steps: list[Step], plan: Plan) -> Reason | None:
    """Why to stop after these steps, or None."""
    last = steps[-1]
    if last.number < min(plan.least, plan.most):
        return None
    # the energies of cells are known far better than a stiffness is: what both err by does not tell cells apart
    known = max(UNIFORM, last.noise)
    if last.spread < known:
        return "uniform"
    if last.change is not None and abs(last.change) < plan.until:
        return "settled"
    if len(steps) > 2 and steps[-1].softness > steps[-2].softness > steps[-3].softness:
        return "rising"
    return "most" if last.number >= plan.most else None
