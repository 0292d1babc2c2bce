"""What a loop leaves on disk: a folder that can be read, replayed, and gone on from.

`loop.jsonl` has a first line of what the loop depends on, and one for each step; `step-000.npz` the density of a step
and the one that follows from it; `state-000.npz` what the next solution begins from, of the last step alone. Files
appear whole: a step counts once its line is there, so that an interruption loses the step at hand and nothing else.
"""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.atomic import replace_file, unwritable
from porelang.diagnostics import PoreError, fail

Array = NDArray[np.float64]
FORMAT = "porelang loop 1"
NAME = "loop.jsonl"


@dataclass(frozen=True, slots=True)
class Step:
    """A step of the history; step 0 is the start.

    `compliance` N mm and its relative `error`, where the analysis states one, `max_von_mises` MPa (macroscopic, of the
    homogenised material, or in the solid of the real lattice),
    `stress_per_density` MPa (von Mises' over the density, below which 99 % of the volume is), `max_displacement` mm,
    `porosity` 0..1, `change` of the compliance, relative to the step before, `spread` of what the rule looks at (its
    coefficient of variation), and `noise`, the relative error of the analysis.
    """

    number: int
    compliance: float
    error: float | None
    max_von_mises: float
    stress_per_density: float
    max_displacement: float
    porosity: float
    change: float | None
    spread: float
    noise: float


@dataclass(frozen=True, eq=False)
class Last:
    """Where a loop goes on: the density that comes next, and what its solution begins from."""

    following: Array
    state: Array | None


def content(
    key: str, rule: str, mean: float, low: float, high: float, cell: float, damping: float, start: str
) -> dict[str, Any]:
    """The first line: all that the steps depend on, and not when they end."""
    return {"format": FORMAT, "analysis": key, "rule": rule, "mean": mean, "low": low, "high": high, "cell": cell,
            "damping": damping, "start": start}  # fmt: skip


class Book:
    """The folder of a loop, open for its next step."""

    def __init__(self, folder: Path, head: dict[str, Any], lines: list[dict[str, Any]]) -> None:
        self._folder, self._head, self._lines = folder, head, lines

    @classmethod
    def open(cls, folder: Path, head: dict[str, Any], resume: bool) -> Book:
        """Begin a record, or go on with one. Errors: E195 where another loop's is there, or one to be gone on with."""
        path = folder / NAME
        try:
            folder.mkdir(parents=True, exist_ok=True)
            found = path.exists()
        except OSError as error:
            raise unwritable(folder, error) from None
        if not found:
            return cls(folder, head, [])
        if not resume:
            raise fail("E195", f"{folder} holds the record of a loop",
                       hint="--resume goes on with it; for a new one name another folder")  # fmt: skip
        known, lines = _read(path)
        different = sorted(k for k in {*known, *head} if known.get(k) != head.get(k))
        if different:
            what = ", ".join("the part, its study or its law" if k == "analysis" else k for k in different)
            raise fail("E195", f"{folder} holds the record of another loop: {what} was different",
                       hint="name another folder, or ask for what it was begun with")  # fmt: skip
        return cls(folder, head, lines)

    @property
    def steps(self) -> tuple[Step, ...]:
        names = [f.name for f in fields(Step)]
        return tuple(Step(**{name: line[name] for name in names}) for line in self._lines)

    def density(self, number: int) -> Array:
        """The density (m,) of a step. Errors: E195 where its file is not what was written."""
        return self._arrays(self._lines[number], "step")["density"]

    def last(self) -> Last:
        """Where to go on."""
        line = self._lines[-1]
        state = self._arrays(line, "state")["state"] if "state" in line else None
        return Last(self._arrays(line, "step")["following"], state)

    def write(
        self, step: Step, density: Array, following: Array, state: Array | None, samples: Mapping[str, Array]
    ) -> None:
        """Add a step, with more arrays for its file. Errors: E113 where the disk is full: what was there is kept."""
        line: dict[str, Any] = asdict(step)
        line["step"] = self._store(f"step-{step.number:03}.npz", density=density, following=following, **samples)
        if state is not None:
            line["state"] = self._store(f"state-{step.number:03}.npz", state=state)
        lines = [*self._lines, line]
        text = "".join(json.dumps(one, allow_nan=False) + "\n" for one in [self._head, *lines])
        self._save(NAME, text.encode())
        if self._lines and "state" in self._lines[-1]:
            with suppress(OSError):
                (self._folder / self._lines[-1]["state"]["file"]).unlink()
        self._lines = lines

    def _store(self, name: str, **arrays: Array) -> dict[str, str]:
        held = io.BytesIO()
        np.savez(held, **arrays)  # type: ignore[arg-type]  # NumPy's stubs take a name for its option
        data = held.getvalue()
        self._save(name, data)
        return {"file": name, "sha256": hashlib.sha256(data).hexdigest()}

    def _save(self, name: str, data: bytes) -> None:
        with replace_file(self._folder / name) as file:
            file.write(data)

    def _arrays(self, line: dict[str, Any], kind: str) -> dict[str, Array]:
        place = self._folder / str(line[kind]["file"])
        try:
            data = place.read_bytes()
        except OSError as error:
            raise _damaged(place, (error.strerror or str(error)).lower()) from None
        if hashlib.sha256(data).hexdigest() != line[kind]["sha256"]:
            raise _damaged(place, "it is not what was written")
        try:
            with np.load(io.BytesIO(data), allow_pickle=False) as file:
                return {name: np.asarray(file[name], np.float64) for name in file.files}
        except (ValueError, KeyError, zipfile.BadZipFile) as error:
            raise _damaged(place, str(error)) from None


def _read(path: Path) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    try:
        head, *lines = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
        if head["format"] != FORMAT:
            raise _damaged(path, f"its format is {head['format']!r:.40}, and not {FORMAT!r}")
        for number, line in enumerate(lines):
            if line["number"] != number or not np.isfinite(line["compliance"]):
                raise _damaged(path, f"line {number + 2} is not step {number}")
            names = [line[kind]["file"] for kind in ("step", "state") if kind in line]
            if any(Path(name).name != name for name in names):
                raise _damaged(path, f"line {number + 2} names a file elsewhere")
            Step(**{f.name: line[f.name] for f in fields(Step)})
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise _damaged(path, str(error)) from None
    return head, lines


def _damaged(path: Path, why: str) -> PoreError:
    return fail("E195", f"cannot go on from {path}: {why}", hint="name another folder, to begin anew")
