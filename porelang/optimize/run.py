"""The loop of a program: what adapts is found, the lattice measured, the study solved again and again.

In its folder stand the record of the loop, the samples of the best step for `--bind`, a table and a picture.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from porelang.atomic import replace_file
from porelang.backends.numpy import NumpyField
from porelang.data import SampledField
from porelang.diagnostics import Diagnostic, fail, suggest
from porelang.optimize import history, loop
from porelang.optimize.adapting import Adapting, adapting
from porelang.optimize.grid import Grid
from porelang.optimize.promise import Promise, promise
from porelang.optimize.real import Real
from porelang.optimize.record import Step
from porelang.optimize.rules import Energy, Given, Optimum, Rule, VonMises
from porelang.program import Design

RULES: dict[str, Callable[[], Rule]] = {"energy": Energy, "von_mises": VonMises, "optimum": Optimum}
#: Voxels of the density: so many to a cell. A lattice follows nothing finer.
_TO_A_CELL = 2
#: Voxels of the homogenised part: so many to a cell and through the part at least, so many in all at most.
_TO_SOLVE, _THROUGH, _MOST = 4, 8, 300_000
#: Where early steps may go.
EARLY = "homogenised"
TABLE, PICTURE = "history.md", "history.png"


@dataclass(frozen=True, eq=False)
class Optimized:
    """How the loop of a program went: its steps, the best of them, and the `samples` of the param that adapts there.

    `reason` says why it ended; `design` has these samples bound, so that it can be meshed. `cell` is in mm, `told` what
    is to be said about it. `promise` is what the homogenised lattice promised, where it was asked.
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
    design: Design
    told: tuple[Diagnostic, ...]
    promise: Promise | None = None

    @property
    def gain(self) -> float:
        """The best compliance over that of the uniform lattice, at the same porosity."""
        return self.steps[self.best].compliance / self.steps[0].compliance

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
                "ended": self.reason, **promised}  # fmt: skip


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
) -> Optimized:
    """Solve the study of an output, map what is borne to its thickness, restore its porosity, and again.

    `until` is a relative change of the compliance, `most` the greatest number of steps after the uniform start.
    `limits` are of the density, 0..1; `porosity` is to be kept, that of the program as it stands unless given, relative
    to the envelope (`within`, as `measure` has it). `cell` (mm) is what all is averaged over, the period of the lattice
    unless given. In `folder` a record is kept, which `resume` goes on from.

    The rule "optimum", and any other that is `early` "homogenised", first goes its steps on voxels of the homogenised
    lattice. What it finds there is step 1; the optimum ends with that, the others go on from it.

    Errors: those of `adapting`, of the study, and of the loop (E190-E195).
    """
    made = _rule(rule)
    if early not in (None, EARLY):
        raise fail("E193", f"early steps are not to be had on `{early}`", hint=f"on `{EARLY}`, or leave it out")
    what = adapting(design, output, adapt, study, within)
    size = what.cell() if cell is None else cell
    low, high = limits
    target = 1 - (what.as_it_stands() if porosity is None else 1 - porosity)
    mean = 1 - target
    if not 0 < low < mean < high <= 1:
        raise fail("E192", f"a porosity of {target:.1%} is no mean of densities between {low:g} and {high:g}",
                   hint="choose others, as in --limits 0.2..0.8, or a --porosity between")  # fmt: skip
    thickness, sign = what.law(low, high)
    plan = loop.Plan(mean, low, high, 0.0, until, most, damping)  # the analysis averages over a cell itself
    promised = None
    if isinstance(made, Optimum) or early is not None:
        grid = _grid(what, size, solved=True)
        promised = promise(what, thickness, sign, grid, size, plan, made)
        after = None if isinstance(made, Optimum) else made
        made = Given(promised.density, f"{made.name}, homogenised", after)
        plan = replace(plan, least=1, most=most if after else min(1, most), damping=damping if after else 1.0)
    else:
        grid = _grid(what, size)
    analysis = Real(what, grid, thickness, sign, size, mean)
    found = loop.iterate(analysis, made, plan, folder=folder, resume=resume, told=told)
    samples, _ = analysis.samples(found.density)
    reason = "the optimum is real" if promised and plan.most == 1 else loop.REASONS[found.reason]
    doubts = (*_doubts(what, found), *(promised.doubts if promised else ()))
    result = Optimized(
        what.output, what.param, what.study, made.name, size, found.steps, found.best, reason, samples,
        what.with_samples(samples), doubts, promised,
    )  # fmt: skip
    if folder is not None:
        _write(result, Path(folder))
    return result


def _rule(rule: str | Rule) -> Rule:
    if not isinstance(rule, str):
        return rule
    if rule not in RULES:
        near = suggest(rule, RULES)
        hint = f"did you mean `{near}`?" if near else "there are `energy`, `von_mises` and `optimum`"
        raise fail("E193", f"`{rule}` is no rule of the loop", hint=hint)
    return RULES[rule]()


def _grid(what: Adapting, cell: float, solved: bool = False) -> Grid:
    """Voxels of a density; finer ones where displacements are `solved` on them."""
    if not 0 < cell < np.inf:
        raise fail("E193", f"a cell of {cell:g} mm cannot be averaged over", hint="as in --cell 10mm")
    field = NumpyField(what.envelope, "f64")
    size = cell / _TO_A_CELL
    if solved:
        sides = np.subtract(what.box.hi, what.box.lo)
        size = min(cell / _TO_SOLVE, float(sides.min()) / _THROUGH)
        size = max(size, float(sides.prod() / _MOST) ** (1 / 3))
    return Grid.of(lambda p: np.asarray(field.at(p)), what.box.lo, what.box.hi, size)


def _doubts(what: Adapting, found: loop.Outcome) -> list[Diagnostic]:
    place = what.design.program.data[what.param].span
    first, best = found.steps[0], found.steps[found.best]
    out = []
    if found.reason == "uniform" and found.best == 0:
        out.append(Diagnostic(
            "W268", f"what `{what.output}` bears is uniform: it varies by {first.spread:.1%}, known to "
            f"{first.noise:.1%}",
            place, "there is nothing to adapt to", severity="warning",
            hint="a dense core in a light skin may still be stiffer: --rule optimum looks for it"))  # fmt: skip
    elif found.best == 0:
        out.append(Diagnostic(
            "W269", f"no step was stiffer than the uniform `{what.output}`", place, "the start is kept",
            severity="warning",
            hint="take less of each change, as in --damping 0.5, or wider limits"))  # fmt: skip
    else:
        gained, error = 1 - best.compliance / first.compliance, max(first.error or 0.0, best.error or 0.0)
        if gained < error:
            out.append(Diagnostic(
                "W270", f"the gain of {gained:.1%} is less than the compliance is known to, {error:.1%}", place,
                severity="warning", hint="take finer elements: `size=` of the study"))  # fmt: skip
    return out


def _write(result: Optimized, folder: Path) -> None:
    samples = result.samples
    held = io.BytesIO()
    arrays = {
        result.param: samples.values[..., 0],
        "origin": np.array(samples.origin),
        "spacing": np.array(samples.spacing),
    }
    np.savez(held, **arrays)  # type: ignore[arg-type]  # NumPy's stubs take a name for its option
    picture = io.BytesIO()
    result.plot().save(picture, "PNG")
    text = f"{result.table}\n\n{result.rule}; ended: {result.reason}. The best is step {result.best}.\n"
    text += f"\n{result.promise}\n" if result.promise else ""
    for name, data in ((f"{result.param}.npz", held.getvalue()), (PICTURE, picture.getvalue()), (TABLE, text.encode())):
        with replace_file(folder / name) as file:
            file.write(data)
