"""What a loop leaves on disk: a folder that can be read, replayed, and gone on from.

`loop.jsonl` has a first line of what the loop depends on, and one for each step; `step-000.npz` the density of a step
and the one that follows from it; `state-000.npz` what the next solution begins from, of the last step alone. Files
appear whole: a step counts once its line is there, so that an interruption loses the step at hand and nothing else.
What a disk or a copy damaged ends the record there: it is gone on with from the last step that is whole.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
import zipfile
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from porelang.atomic import replace_file, unwritable
from porelang.diagnostics import PoreError, fail

Array = NDArray[np.float64]
FORMAT = "porelang loop 1"
NAME = "loop.jsonl"
#: What loads a part: forces, or displacements that are prescribed.
Under = Literal["forces", "displacements"]
#: What is doubtful of a step: code, what is said, a label, a hint.
Doubtful = tuple[str, str, str, str]
#: What the file of a step holds, beside the samples of the param by its own name.
ARRAYS = frozenset({"density", "following", "origin", "spacing"})
_OWN = re.compile(r"(?:step|state)-\d{3,}\.npz")
_ANEW = "begin anew with --force, or name another folder"


def refuse_others(folder: Path, names: Collection[str] = ()) -> None:
    """Errors: E195 where a folder without a record holds files that one would write over: steps, or of some `names`."""
    if (folder / NAME).exists() or not folder.is_dir():
        return
    there = sorted(f.name for f in folder.iterdir() if f.name in names or _OWN.fullmatch(f.name))
    if there:
        listed = ", ".join(there[:3]) + (", ..." if len(there) > 3 else "")
        raise fail("E195", f"{folder} holds no record of a loop, and files that it would write over: {listed}",
                   hint="name another folder; or --force writes over them")  # fmt: skip


@dataclass(frozen=True, slots=True)
class Step:
    """A step of the history; step 0 is the start.

    `compliance` N mm and its relative `error`, where the analysis states one, `max_von_mises` MPa (macroscopic, of the
    homogenised material, or in the solid of the real lattice),
    `stress_per_density` MPa (von Mises' over the density, below which 99 % of the volume is), `max_displacement` mm,
    `porosity` 0..1, `change` of the compliance, relative to the step before, `spread` of what the rule looks at (its
    coefficient of variation), `noise`, the relative error of the energies, and `apart`, by which share the compliance
    may differ from what another mesh says, where there is one.

    `under` says what loads the part. Under displacements that are prescribed the compliance is the work that they take,
    of which more is stiffer; `softness` is what rises with compliance under both. `doubts` are those of the study.
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
    under: Under = "forces"
    doubts: tuple[Doubtful, ...] = ()
    apart: float | None = None

    @property
    def softness(self) -> float:
        """What is less of a stiffer part: to be compared with that of another step."""
        return self.compliance if self.under == "forces" else 1 / self.compliance


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

    def __init__(
        self, folder: Path, head: dict[str, Any], lines: list[dict[str, Any]], missed: str = "", old: bool = False
    ) -> None:
        self._folder, self._head, self._lines, self.missed, self._old = folder, head, lines, missed, old

    @classmethod
    def open(cls, folder: Path, head: dict[str, Any], resume: bool, anew: bool = False) -> Book:
        """Begin a record, or go on with one; `missed` then says what of it is not whole, if anything is.

        `anew` begins one where another is: that is kept until the first step of the new one is written. Errors: E195
        where another loop's is there, or one to be gone on with, or files of these names that are of none.
        """
        path = folder / NAME
        try:
            folder.mkdir(parents=True, exist_ok=True)
            found = path.exists()
        except OSError as error:
            raise unwritable(folder, error) from None
        if not found:
            if not anew:
                refuse_others(folder)
            return cls(folder, head, [])
        if anew:
            return cls(folder, head, [], old=True)
        if not resume:
            raise fail("E195", f"{folder} holds the record of a loop",
                       hint=f"--resume goes on with it; or {_ANEW}")  # fmt: skip
        known, lines, missed = _read(path)
        different = sorted(k for k in {*known, *head} if known.get(k) != head.get(k))
        if different:
            what = ", ".join("the part, its study or its law" if k == "analysis" else k for k in different)
            raise fail("E195", f"{folder} holds the record of another loop: {what} was different",
                       hint=f"ask for what it was begun with; or {_ANEW}")  # fmt: skip
        lines, missed = _whole(folder, lines, missed)
        return cls(folder, head, lines, missed, old=bool(missed))

    @property
    def steps(self) -> tuple[Step, ...]:
        return tuple(_step(line) for line in self._lines)

    def density(self, number: int) -> Array:
        """The density (m,) of a step."""
        return _arrays(self._folder, self._lines[number]["step"])["density"]

    def last(self) -> Last:
        """Where to go on."""
        line = self._lines[-1]
        state = _arrays(self._folder, line["state"])["state"] if "state" in line else None
        return Last(_arrays(self._folder, line["step"])["following"], state)

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
        if self._old:
            self._clear()

    def _clear(self) -> None:
        """Remove the files of steps that are not on record any more; nothing else is the loop's own."""
        mine = {line[kind]["file"] for line in self._lines for kind in ("step", "state") if kind in line}
        for path in self._folder.iterdir():
            if _OWN.fullmatch(path.name) and path.name not in mine:
                with suppress(OSError):
                    path.unlink()
        self._old = False

    def _store(self, name: str, **arrays: Array) -> dict[str, str]:
        held = io.BytesIO()
        np.savez(held, **arrays)  # type: ignore[arg-type]  # NumPy's stubs take a name for its option
        data = held.getvalue()
        self._save(name, data)
        return {"file": name, "sha256": hashlib.sha256(data).hexdigest()}

    def _save(self, name: str, data: bytes) -> None:
        with replace_file(self._folder / name) as file:
            file.write(data)


def _read(path: Path) -> tuple[dict[str, Any], list[dict[str, Any]], str]:
    """The first line and those of the steps, up to one that is damaged, and what is wrong with that.

    Errors: E195 where the first one is.
    """
    try:
        first, *rest = path.read_bytes().splitlines() or [b""]
        head = json.loads(first)
        if head["format"] != FORMAT:
            raise _damaged(path, f"its format is {head['format']!r:.40}, and not {FORMAT!r}")
    except OSError as error:
        raise _damaged(path, (error.strerror or str(error)).lower()) from None
    except (ValueError, KeyError, TypeError):
        raise _damaged(path, "its first line is not what was written") from None
    lines: list[dict[str, Any]] = []
    for number, text in enumerate(rest):
        try:
            line = json.loads(text)
            names = [line[kind]["file"] for kind in ("step", "state") if kind in line]
            good = line["number"] == number and bool(np.isfinite(line["compliance"])) and "step" in line
            if not good or any(Path(name).name != name for name in names):
                raise ValueError
            _step(line)
        except (ValueError, KeyError, TypeError):
            return head, lines, f"line {number + 2} of {path.name} is not what was written"
        lines.append(line)
    return head, lines, ""


def _step(line: dict[str, Any]) -> Step:
    """A step of its line."""
    known: dict[str, Any] = {"apart": None} | line  # which older records have not
    known = {f.name: known[f.name] for f in fields(Step)}
    return Step(**{**known, "doubts": tuple((str(c), str(m), str(n), str(h)) for c, m, n, h in known["doubts"])})


def _whole(folder: Path, lines: list[dict[str, Any]], missed: str) -> tuple[list[dict[str, Any]], str]:
    """The lines up to a step whose file is not whole, and what is wrong with that."""
    for number, line in enumerate(lines):
        try:
            known = _arrays(folder, line["step"])
            if not {"density", "following"} <= set(known):
                raise _Broken(f"{line['step']['file']} lacks densities")
        except _Broken as broken:
            lines, missed = lines[:number], str(broken)
            break
    if missed:
        missed += f"; from step {len(lines)} on it is solved again"
    if lines and "state" in lines[-1]:
        try:
            _arrays(folder, lines[-1]["state"])
        except _Broken as broken:  # a solution can begin without it: it takes longer, and ends within its tolerance
            lines = [*lines[:-1], {k: v for k, v in lines[-1].items() if k != "state"}]
            missed = missed or str(broken)
    return lines, missed


class _Broken(Exception):  # noqa: N818 - it is a file that is broken
    """A file of a record that is not what was written: its text says which, and how."""


def _arrays(folder: Path, entry: dict[str, str]) -> dict[str, Array]:
    name = str(entry["file"])
    try:
        data = (folder / name).read_bytes()
    except OSError as error:
        raise _Broken(f"{name}: {(error.strerror or str(error)).lower()}") from None
    if hashlib.sha256(data).hexdigest() != entry["sha256"]:
        raise _Broken(f"{name} is not what was written")
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            return {key: np.asarray(file[key], np.float64) for key in file.files}
    except (ValueError, KeyError, zipfile.BadZipFile) as error:
        raise _Broken(f"{name}: {error}") from None


def _damaged(path: Path, why: str) -> PoreError:
    return fail("E195", f"cannot go on from {path}: {why}", hint=_ANEW)
