"""The loop of a program: what adapts is found, the lattice measured, the study solved again and again.

In its folder stand the record of the loop, the samples of the best step for `--bind`, a table and a picture.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
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
from porelang.optimize.real import Real
from porelang.optimize.record import Step
from porelang.optimize.rules import Energy, Rule, VonMises
from porelang.program import Design

RULES: dict[str, Callable[[], Rule]] = {"energy": Energy, "von_mises": VonMises}
#: Voxels of the density: so many to a cell. A lattice follows nothing finer.
_TO_A_CELL = 2
TABLE, PICTURE = "history.md", "history.png"


@dataclass(frozen=True, eq=False)
class Optimized:
    """How the loop of a program went: its steps, the best of them, and the `samples` of the param that adapts there.

    `reason` says why it ended; `design` has these samples bound, so that it can be meshed. `cell` is in mm, `told` what
    is to be said about it.
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

        return {"output": self.output, "adapts": self.param, "study": self.study, "rule": self.rule, "cell": self.cell,
                "steps": [asdict(s) for s in self.steps], "best": self.best, "gain": self.gain,
                "ended": self.reason}  # fmt: skip


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
    told: Callable[[Step], None] | None = None,
) -> Optimized:
    """Solve the study of an output, map what is borne to its thickness, restore its porosity, and again.

    `until` is a relative change of the compliance, `most` the greatest number of steps after the uniform start.
    `limits` are of the density, 0..1; `porosity` is to be kept, that of the program as it stands unless given, relative
    to the envelope (`within`, as `measure` has it). `cell` (mm) is what all is averaged over, the period of the lattice
    unless given. In `folder` a record is kept, which `resume` goes on from.

    Errors: those of `adapting`, of the study, and of the loop (E190-E195).
    """
    made = _rule(rule)
    what = adapting(design, output, adapt, study, within)
    size = what.cell() if cell is None else cell
    low, high = limits
    target = 1 - (what.as_it_stands() if porosity is None else 1 - porosity)
    mean = 1 - target
    if not 0 < low < mean < high <= 1:
        raise fail("E192", f"a porosity of {target:.1%} is no mean of densities between {low:g} and {high:g}",
                   hint="choose others, as in --limits 0.2..0.8, or a --porosity between")  # fmt: skip
    thickness, sign = what.law(low, high)
    grid = _grid(what, size)
    analysis = Real(what, grid, thickness, sign, size, mean)
    plan = loop.Plan(mean, low, high, 0.0, until, most, damping)  # the analysis averages over a cell itself
    found = loop.iterate(analysis, made, plan, folder=folder, resume=resume, told=told)
    samples, _ = analysis.samples(found.density)
    result = Optimized(
        what.output, what.param, what.study, made.name, size, found.steps, found.best, loop.REASONS[found.reason],
        samples, what.with_samples(samples), tuple(_doubts(what, found)),
    )  # fmt: skip
    if folder is not None:
        _write(result, Path(folder))
    return result


def _rule(rule: str | Rule) -> Rule:
    if not isinstance(rule, str):
        return rule
    if rule not in RULES:
        near = suggest(rule, RULES)
        raise fail("E193", f"`{rule}` is no rule of the loop",
                   hint=f"did you mean `{near}`?" if near else "there are `energy` and `von_mises`")  # fmt: skip
    return RULES[rule]()


def _grid(what: Adapting, cell: float) -> Grid:
    if not 0 < cell < np.inf:
        raise fail("E193", f"a cell of {cell:g} mm cannot be averaged over", hint="as in --cell 10mm")
    field = NumpyField(what.envelope, "f64")
    return Grid.of(lambda p: np.asarray(field.at(p)), what.box.lo, what.box.hi, cell / _TO_A_CELL)


def _doubts(what: Adapting, found: loop.Outcome) -> list[Diagnostic]:
    place = what.design.program.data[what.param].span
    first, best = found.steps[0], found.steps[found.best]
    out = []
    if found.reason == "uniform" and found.best == 0:
        out.append(Diagnostic(
            "W268", f"what `{what.output}` bears is uniform: it varies by {first.spread:.1%}, known to "
            f"{first.noise:.1%}",
            place, "there is nothing to adapt to", severity="warning",
            hint="a dense core in a light skin may still be stiffer at the same mass: docs/optimize.md"))  # fmt: skip
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
    for name, data in ((f"{result.param}.npz", held.getvalue()), (PICTURE, picture.getvalue()), (TABLE, text.encode())):
        with replace_file(folder / name) as file:
            file.write(data)
