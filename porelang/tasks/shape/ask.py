"""`mesh("part.stl")`: the signed distance to a mesh of triangles, sampled on a grid, negative inside.

It is measured in a process of its own (`child`): what a damaged file does to a reader, or a mesh to libigl, ends
that process, and becomes a diagnostic here.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import signal
import tempfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import IO, BinaryIO

import numpy as np

from porelang import store
from porelang.children import child, ended
from porelang.data import SampledField
from porelang.diagnostics import PoreError, fail
from porelang.progress import tell
from porelang.source import Span
from porelang.tasks.datafile import looked_at, remembered
from porelang.tasks.identity import code_digest
from porelang.tasks.shape.file import ENDINGS, STEP, UnusableError, look_over

_CHUNK = 1 << 20
_WORDS = 300  # characters of a child's last words that are worth showing


def read_shape(
    path: str,
    error: float | None = None,
    margin: float | None = None,
    unit: float | None = None,
    span: Span | None = None,
) -> SampledField:
    """The signed distance to the mesh of a file, in mm, on a grid over its box and `margin` mm more on each side.

    `error` is by how many mm a trilinear lookup near the surface errs at most, 1/128 of the longest side unless given;
    `margin` is 1/16 of it, and `unit` the mm that a length of 1 in the file is: 1, and 1000 for glTF. Holes are closed
    by fans of triangles; `Found.of` tells of them.
    Errors: E130, E131 and E135 as of any data file, and E140-E144, placed at `span`.
    """
    for name, given in (("error", error), ("margin", margin), ("unit", unit)):
        if given is not None and not (given > 0 and math.isfinite(given)):
            raise fail("E143", f"`{name}` of a mesh is a length above 0, not {given:g} mm", span, hint="as in 0.1mm")
    ending = _ending(path)
    if unit is not None and ending in STEP:
        raise fail("E143", f"`{path}` says its unit itself", span, hint="leave `unit` out")
    error, margin, unit = (math.nan if number is None else number for number in (error, margin, unit))
    asked = _Asked(path, ending, error, margin, unit, span)
    part = f"{asked.error!r} {asked.margin!r} {asked.unit!r}"
    return remembered(path, ENDINGS, "a mesh", span, partial(_read, asked), part)


def look_at_shape(path: str) -> None:
    """Say what is plainly wrong with the file of a mesh, of which only the beginning is read. Errors: as `read_shape`,
    but those that take measuring."""
    asked = _Asked(path, _ending(path))
    looked_at(path, ENDINGS, "a mesh", None, partial(_look, asked))


def _ending(path: str) -> str:
    ending = Path(path).suffix.lower()
    return ending if ending in ENDINGS else ENDINGS[0]


def corners_of(field: SampledField) -> SampledField:
    """The place of each corner of a grid, in mm: looked up, it is the nearest place in the grid's box."""
    ends = np.stack(np.meshgrid(*zip(field.origin, field.end, strict=True), indexing="ij"), axis=-1)
    size = np.array(field.end) - np.array(field.origin)
    return SampledField.from_array(ends, field.origin, size.tolist())


@dataclass(frozen=True, slots=True)
class _Asked:
    path: str
    ending: str
    error: float = math.nan
    margin: float = math.nan
    unit: float = math.nan
    span: Span | None = None

    def fail(self, code: str, message: str, hint: str) -> PoreError:
        return fail(code, f"`{self.path}` {message}", self.span, hint=hint)


def _look(asked: _Asked, file: BinaryIO, size: int) -> None:
    try:
        look_over(file, size, asked.ending)
    except UnusableError as reason:
        raise asked.fail(*reason.args) from None


def _read(asked: _Asked, file: BinaryIO, size: int) -> SampledField:
    """The distances, as they were measured before of a file with this content, or measured now."""
    _look(asked, file, size)
    file.seek(0)
    with tempfile.TemporaryFile() as source:
        content = hashlib.sha256()
        while chunk := file.read(_CHUNK):
            content.update(chunk)
            source.write(chunk)
        source.seek(0)
        numbers = (n.hex() for n in (asked.error, asked.margin, asked.unit))
        about = "\n".join((code_digest(), content.hexdigest(), asked.ending, *numbers))
        key = hashlib.sha256(about.encode()).hexdigest()
        known = store.get(key)
        if isinstance(known, SampledField):
            return known
        made = _made(asked, source)
    store.put(key, made, label=f'mesh("{os.path.basename(asked.path)}")')
    return made


def _made(asked: _Asked, source: IO[bytes]) -> SampledField:
    with tempfile.TemporaryFile() as target, tempfile.TemporaryFile() as words:
        code = _measured(asked, source.fileno(), target.fileno(), words)
        if code:
            words.seek(0)
            raise _died(asked, code, words.read().decode(errors="replace"))
        target.seek(0)
        with np.load(target, allow_pickle=False) as found:
            if "refused" in found:
                raise asked.fail(*json.loads(str(found["refused"])))
            values, facts = found["values"], found["facts"]
            origin, spacing = found["origin"], float(found["spacing"])
    made = SampledField.from_array(values, origin, spacing)
    return SampledField(made.values, made.origin, made.spacing, tuple(facts.tolist()))


def _measured(asked: _Asked, source: int, target: int, words: IO[bytes]) -> int:
    """Have the child measure; how it ended. It is killed where the answer is no longer wanted."""
    numbers = (asked.ending, asked.error, asked.margin, asked.unit, source, target)
    try:
        with child("porelang.tasks.shape.child", numbers, (source, target), words) as working:
            return ended(working, _heard)
    except OSError as error:
        raise asked.fail(
            "E144", f"was not measured: no process can be started: {error.strerror}", "end some others"
        ) from None


def _heard(lines: list[str]) -> None:
    """Hand on how far the child says it is."""
    numbers = lines[-1].split() if lines else []
    if len(numbers) == 2 and all(n.isdigit() for n in numbers):
        tell(int(numbers[0]), int(numbers[1]))


def _died(asked: _Asked, code: int, words: str) -> PoreError:
    last = (words.strip().splitlines() or [""])[-1][:_WORDS]
    if "MemoryError" in last or -code == signal.SIGKILL:
        return asked.fail("E144", "was not measured: there was not enough memory, or its process was killed",
                          "give a larger `error`, or simplify the mesh")  # fmt: skip
    how = f"crashed ({signal.Signals(-code).name})" if code < 0 else f"failed: {last}"
    return asked.fail("E144", f"was not measured: the process that did so {how}",
                      "mend the mesh where it was made, and export it again")  # fmt: skip
