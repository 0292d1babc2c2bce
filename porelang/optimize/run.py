"""The loop of a program: what adapts is found, the lattice measured, the study solved again and again.

In its folder stand the record of the loop, the samples of the best step for `--bind`, a table and a picture. They are
those of the best step so far from the first one on, so that a loop that is stopped, or fails, leaves a design.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.atomic import replace_file
from porelang.backends.numpy import NumpyField
from porelang.data import SampledField
from porelang.diagnostics import Diagnostic, fail, suggest
from porelang.html import table, title
from porelang.optimize import history, loop
from porelang.optimize.adapting import Adapting, adapting
from porelang.optimize.doubts import doubts
from porelang.optimize.grid import Grid
from porelang.optimize.promise import Promise, promise
from porelang.optimize.real import Real, sampled
from porelang.optimize.record import ARRAYS, Step, refuse_others
from porelang.optimize.rules import Answer, Energy, Given, Optimum, Rule, VonMises
from porelang.program import Design
from porelang.tasks.study.sized import Sized

RULES: dict[str, Callable[[], Rule]] = {"energy": Energy, "von_mises": VonMises, "optimum": Optimum}
#: Voxels of the density: so many to a cell. A lattice follows nothing finer.
_TO_A_CELL = 2
#: Voxels of the homogenised part: so many to a cell and through the part at least, so many in all at most.
_TO_SOLVE, _THROUGH, _MOST = 4, 8, 300_000
#: Where early steps may go.
EARLY = "homogenised"
#: The name of the density in the file of the samples.
DENSITY = "density"
TABLE, PICTURE = "history.md", "history.png"


@dataclass(frozen=True, eq=False, repr=False)
class Optimized:
    """How the loop of a program went: its steps, the best of them, and the `samples` of the param that adapts there,
    with the `density` that they make.

    `reason` says why it ended; `design` has these samples bound, so that it can be meshed. `cell` is in mm, `told` what
    is to be said about it. `failed` is what was wrong with the step after the last, if that could not be solved.
    `promise` is what the homogenised lattice promised, where it was asked.
    """

    output: str
    param: str
    study: str
    rule: str
    cell: float
    steps: tuple[Step, ...]
    best: int
    reason: str
    samples: SampledField
    density: SampledField
    design: Design
    told: tuple[Diagnostic, ...]
    failed: tuple[Diagnostic, ...] = ()
    promise: Promise | None = None

    @property
    def gain(self) -> float:
        """The best compliance over that of the uniform lattice, at the same porosity, under equal forces."""
        return self.steps[self.best].softness / self.steps[0].softness

    @property
    def gain_error(self) -> float:
        """How far the gain may be off: what meshes of two such parts differ by."""
        return loop.ratio_error(self.steps[0], self.steps[self.best]) * self.gain if self.best else 0.0

    @property
    def ended(self) -> str:
        """Why it ended, and what the best step is, in a line."""
        known = f" +- {self.gain_error:.2g}" if self.gain_error else ""
        text = f"ended: {self.reason}; step {self.best} has {self.gain:.3f}{known} of the uniform compliance"
        if self.steps[0].under == "displacements":
            text += f" under equal forces, and takes {1 / self.gain:.3f} of the work under these displacements"
        return text

    def __repr__(self) -> str:
        error = self.steps[self.best].error
        known = "" if error is None else f", each known to {error:.1%}"
        text = f"step {self.best} of {len(self.steps) - 1} has {self.gain:.3f} of the uniform compliance{known}"
        return f"<{self.output} adapted by {self.param}: {text}; {self.reason}>"

    def __str__(self) -> str:
        return f"{self.table}\n{self.ended}"

    def _repr_html_(self) -> str:
        heads, _, *rows = ([c.strip() for c in line.strip("|").split("|")] for line in self.table.splitlines())
        return title(f"{self.output} adapted by {self.param}: {self.study}, {self.rule}") + table(heads, rows) + title(
            self.ended
        )  # fmt: skip

    @property
    def table(self) -> str:
        """The history in Markdown."""
        return history.table(self.steps, self.best)

    def plot(self) -> Any:
        """The history as a picture (a `PIL.Image`)."""
        return history.plot(self.steps, self.best, f"{self.output}: {self.study}, {self.rule}, {self.param}")

    @property
    def report(self) -> dict[str, Any]:
        """What `pore optimize --json` prints."""
        from dataclasses import asdict

        promised = {} if self.promise is None else {"promise": self.promise.report}
        return {"output": self.output, "adapts": self.param, "study": self.study, "rule": self.rule, "cell": self.cell,
                "steps": [asdict(s) for s in self.steps], "best": self.best, "gain": self.gain,
                "gain_error": self.gain_error,
                "ended": self.reason, "failed": [d.to_json() for d in self.failed], **promised}  # fmt: skip


def optimize(
    design: Design,
    output: str | None = None,
    until: float = 0.005,
    most: int = 15,
    rule: str | Rule = "energy",
    limits: tuple[float, float] = (0.2, 0.8),
    porosity: float | None = None,
    adapt: str | None = None,
    study: str | None = None,
    within: str | None = None,
    cell: float | None = None,
    damping: float = 1.0,
    folder: str | Path | None = None,
    resume: bool = False,
    early: str | None = None,
    told: Callable[[Step], None] | None = None,
    force: bool = False,
    begun: Callable[[Sized, int], None] | None = None,
) -> Optimized:
    """Solve the study of an output, map what is borne to its thickness, restore its porosity, and again.

    `until` is a relative change of the compliance, `most` the greatest number of steps after the uniform start.
    `limits` are of the density, 0..1; `porosity` is to be kept, that of the program as it stands unless given, relative
    to the envelope (`within`, as `measure` has it). `cell` (mm) is what all is averaged over, the period of the lattice
    unless given. In `folder` a record is kept, which `resume` goes on from; `force` begins anew where another is.

    The rule "optimum", and any other that is `early` "homogenised", first goes its steps on voxels of the homogenised
    lattice. What it finds there is step 1; the optimum ends with that, the others go on from it.

    `begun` is told, before anything is solved in tetrahedra, of the size of the elements, about how many there are, and
    of how many solves there will be at most.

    Errors: those of `adapting`, of the study, and of the loop (E190-E195).
    """
    if resume and force:
        raise fail("E108", "to go on with a record and to begin anew exclude each other", hint="leave out one of them")
    if resume and folder is None:
        raise fail("E108", "there is no record to go on with: no folder is given", hint='name it: folder="part.loop"')
    made = _rule(rule)
    if early not in (None, EARLY):
        raise fail("E193", f"early steps are not to be had on `{early}`", hint=f"on `{EARLY}`, or leave it out")
    what = adapting(design, output, adapt, study, within)
    if folder is not None and what.param in ARRAYS:
        raise fail("E193", f"the param that adapts is called `{what.param}`, as an array of each record is",
                   hint="give it another name, such as `t`")  # fmt: skip
    if folder is not None and not force:
        refuse_others(Path(folder), {f"{what.param}.npz", TABLE, PICTURE})
    size = what.cell() if cell is None else cell
    _sized(what, size)
    low, high = limits
    target = 1 - (what.as_it_stands() if porosity is None else 1 - porosity)
    mean = 1 - target
    if not 0 < low < mean < high <= 1:
        held = f", as in --limits {mean / 3:.2g}..{(1 + mean) / 2:.2g}," if 0 < mean < 1 else ""
        raise fail("E192", f"a porosity of {target:.1%} is no mean of densities between {low:g} and {high:g}",
                   hint=f"choose others{held} or a --porosity between")  # fmt: skip
    thickness, sign = what.law(low, high)
    plan = loop.Plan(mean, low, high, 0.0, until, most, damping)  # the analysis averages over a cell itself
    promised = None
    if isinstance(made, Optimum) or early is not None:
        grid = _grid(what, size, solved=True)
        promised = promise(what, thickness, sign, grid, size, plan, made)
        after = None if isinstance(made, Optimum) else made
        made = Given(promised.density, f"{made.name}, homogenised", after)
        plan = replace(plan, least=1, most=most if after else min(1, most), damping=damping if after else 1.0)
        if promised.is_uniform and after is None:  # the start is the optimum: it need not be solved twice
            plan = replace(plan, most=0)
    else:
        grid = _grid(what, size)
    many = None if begun is None else lambda elements: begun(elements, plan.most + 1)
    analysis = Real(what, grid, thickness, sign, size, mean, many)
    shown = f"{what.output}: {what.study}, {made.name}, {what.param}"

    def keep(steps: Sequence[Step], best: int, answer: Answer, density: NDArray[np.float64]) -> None:
        """What is there of a loop that does not come to its end."""
        if folder is not None:
            if best == steps[-1].number:
                arrays = {DENSITY: sampled(grid, density).values[..., 0], **answer.samples}
                _save(Path(folder) / f"{what.param}.npz", arrays)
            _show(Path(folder), steps, best, shown, promised, f"not ended yet. The best so far is step {best}.")

    found = loop.iterate(analysis, made, plan, folder=folder, resume=resume, told=told, anew=force, seen=keep)
    samples, _ = analysis.samples(found.density)
    reason = loop.REASONS[found.reason]
    if promised and found.reason == "most" and isinstance(made, Given) and made.after is None and most:
        reason = f"the optimum is {'the uniform density' if promised.is_uniform else 'solved as a lattice'}"
    told_of = [*doubts(what, found, size, until, isinstance(made, Given)), *(promised.doubts if promised else ())]
    result = Optimized(
        what.output, what.param, what.study, made.name, size, found.steps, found.best, reason, samples,
        sampled(grid, found.density), what.with_samples(samples), tuple(told_of), found.failed, promised,
    )  # fmt: skip
    if folder is not None:
        _write(result, Path(folder))
    return result


def _rule(rule: str | Rule) -> Rule:
    if not isinstance(rule, str):
        if isinstance(rule, type) or not all(hasattr(rule, name) for name in ("name", "driver", "next")):
            raise fail("E193", f"{rule!r:.60} is no rule of the loop",
                       hint=f"name one: {', '.join(RULES)}; or make one of porelang.optimize.rules")  # fmt: skip
        return rule
    if rule not in RULES:
        near = suggest(rule, RULES)
        hint = f"did you mean `{near}`?" if near else "there are `energy`, `von_mises` and `optimum`"
        raise fail("E193", f"`{rule}` is no rule of the loop", hint=hint)
    return RULES[rule]()


def _sized(what: Adapting, cell: float) -> None:
    """Errors: E193 for a cell that is none, or larger than the part."""
    if not 0 < cell < np.inf:
        raise fail("E193", f"a cell of {cell:g} mm cannot be averaged over", hint="as in --cell 10mm")
    longest = max(h - lo for lo, h in zip(what.box.lo, what.box.hi, strict=True))
    if cell > longest * (1 + 1e-9):
        raise fail("E193", f"a cell of {cell:.4g} mm is larger than the part, which is {longest:.4g} mm long: averaged "
                   "over that, all of it bears the same",
                   hint="give the period of the lattice, or leave --cell out: it is found")  # fmt: skip


def _grid(what: Adapting, cell: float, solved: bool = False) -> Grid:
    """Voxels of a density; finer ones where displacements are `solved` on them."""
    field = NumpyField(what.envelope, "f64")
    size = cell / _TO_A_CELL
    if solved:
        sides = np.subtract(what.box.hi, what.box.lo)
        size = min(cell / _TO_SOLVE, float(sides.min()) / _THROUGH)
        size = max(size, float(sides.prod() / _MOST) ** (1 / 3))
    return Grid.of(lambda p: np.asarray(field.at(p)), what.box.lo, what.box.hi, size)


def _write(result: Optimized, folder: Path) -> None:
    samples = result.samples
    arrays = {
        DENSITY: result.density.values[..., 0],
        result.param: samples.values[..., 0],
        "origin": np.array(samples.origin),
        "spacing": np.array(samples.spacing),
    }
    _save(folder / f"{result.param}.npz", arrays)
    shown = f"{result.output}: {result.study}, {result.rule}, {result.param}"
    end = f"ended: {result.reason}. The best is step {result.best}."
    _show(folder, result.steps, result.best, shown, result.promise, end)


def _save(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    held = io.BytesIO()
    np.savez(held, **arrays)  # type: ignore[arg-type]  # NumPy's stubs take a name for its option
    with replace_file(path) as file:
        file.write(held.getvalue())


def _show(folder: Path, steps: Sequence[Step], best: int, shown: str, promised: Promise | None, end: str) -> None:
    """The table and the picture of a history."""
    picture = io.BytesIO()
    history.plot(steps, best, shown).save(picture, "PNG")
    text = f"{history.table(steps, best)}\n\n{shown}; {end}\n"
    text += f"\n{promised}\n" if promised else ""
    for name, data in ((PICTURE, picture.getvalue()), (TABLE, text.encode())):
        with replace_file(folder / name) as file:
            file.write(data)
