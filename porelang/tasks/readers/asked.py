"""What all readers of samples share: what was asked for, what is said of it, and which numbers can be used."""

from __future__ import annotations

import struct
import zipfile
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.data import FARTHEST, LARGEST_VALUE, NEAREST, Triple, coordinates
from porelang.diagnostics import PoreError, fail, suggest
from porelang.ops.tasks import TASK_TABLE
from porelang.source import Span

Array = NDArray[Any]
#: Bytes of an array in memory, and of a file that is read as a whole.
LARGEST = 2_000_000_000
#: What damaged files make of those who read them.
BROKEN = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    struct.error,
    ValueError,
    TypeError,
    OverflowError,
    NotImplementedError,
    RuntimeError,
    LookupError,
    SyntaxError,
)


@dataclass(frozen=True, slots=True)
class Asked:
    """What was asked for and where, for what is said of it; `hint` is said where nothing better is known.

    `lengths` is how many mm a length of the file is, None where the program does not say; `masked` whether it is asked
    what holds where there are no data.
    """

    path: str
    name: str
    span: Span | None
    hint: str
    lengths: float | None = None
    masked: bool = False

    @property
    def mm(self) -> float:
        """How many mm a length is of a file that does not say."""
        return self.lengths or 1.0

    @property
    def scale(self) -> str:
        """What lengths of the file are, for what is said of ones that no part has."""
        if self.lengths is None:
            return "lengths are in mm, unless `lengths=m` says what they are"
        return f"`lengths` says that one of the file is {self.lengths:g} mm"

    def fail(self, code: str, message: str, hint: str = "") -> PoreError:
        return fail(code, message, self.span, hint=hint or self.hint)

    def damaged(self, why: str, hint: str = "") -> PoreError:
        """E131: the file is not what its name says, or not all of it."""
        return self.fail("E131", f"`{self.path}` is damaged: {shown(why)}", hint)

    def too_large(self, what: str, hint: str = "keep a part of it, or float32 in place of float64") -> PoreError:
        return self.fail("E135", f"`{self.path}` is too large: {what}", hint)

    def no_array(self, held: Iterable[str], where: str = "") -> PoreError:
        """E132: it holds no array of that name, but others."""
        names = list(dict.fromkeys(held))
        listed = ", ".join(f"`{shown(n)}`" for n in names[:12]) + (", ..." if len(names) > 12 else "")
        has = f"it holds {listed}{where}" if names else "it holds no arrays"
        near = suggest(self.name, names)
        hint = f"did you mean `{shown(near)}`? {has}" if near else has
        array, comma, option = self.name.partition(",")
        if comma and array.strip() in names:  # of a `--bind` with a word behind the array that is none
            options = TASK_TABLE["load"].parameters[2:]
            word = suggest(option.partition("=")[0].strip(), options)
            meant = f"did you mean `{word}=`? " if word else ""
            some = ", ".join(f"`{o}=`" for o in options)
            hint = f"{meant}it holds `{shown(array.strip())}`; how that is read is said by {some}"
        return self.fail("E132", f"`{self.path}` holds no array `{shown(self.name)}`", hint)


def lower(error: BaseException) -> str:
    """The text of another's error, on one line, to stand after a colon."""
    text = " ".join(str(error).split()) or type(error).__name__
    return shown(text[:1].lower() + text[1:])


def shown(text: str) -> str:
    text = "".join(c if c.isprintable() else "?" for c in text)
    return text if len(text) <= 120 else text[:117] + "..."


def usable(asked: Asked, array: Array, what: str, places: Array | None = None) -> None:
    """Errors: E134 where a number is not finite, or float32 has no room for it.

    Numbers are those of `what` (nodes, points or cells), which are counted by the first axes, or lie at `places`.
    """
    bad = ~np.isfinite(array)
    if bad.any():
        first = tuple(int(v) for v in np.argwhere(bad)[0][: array.ndim - 1])
        count = int(bad.sum())
        are = (
            "1 value is not a finite number, at"
            if count == 1
            else f"{count:,} values are not finite numbers, the first at"
        )
        number = f"{first}" if len(first) > 1 else f"{first[0]}"
        at = "" if places is None else f", ({coordinates(places[first[0]])})"
        hint = "say what holds there, `outside=0`, or fill them with the nearest value that is known"
        hint = hint if not asked.masked else "fill them with the nearest value that is known before they are written"
        raise asked.fail("E134", f"`{asked.name}` in `{asked.path}`: {are} {what} {number}{at}", hint)
    if (largest := max(float(array.max()), -float(array.min()))) > LARGEST_VALUE:
        hint = "shaders and float32 have no room for more: store it in a larger unit"
        raise asked.fail(
            "E134", f"`{asked.name}` in `{asked.path}` goes to {largest:.2g}, beyond {LARGEST_VALUE:g}", hint
        )


def placed(asked: Asked, shape: Sequence[int], origin: Triple, spacing: Triple) -> None:
    """Errors: E134 where a grid has no size, or lies where there are no parts."""
    step = ", ".join(f"{v:g}" for v in spacing)
    if not np.isfinite([*origin, *spacing]).all():
        raise asked.fail("E134", f"the grid of `{asked.path}` begins at ({coordinates(origin)}), in steps of ({step})")
    if min(spacing) <= 0:
        hint = "it must be above 0: for an axis that runs backwards flip the array (numpy.flip)"
        raise asked.fail("E134", f"`spacing` in `{asked.path}` is ({step})", hint)
    if min(spacing) < NEAREST:
        raise asked.fail("E134", f"`spacing` in `{asked.path}` is ({step}), below a nanometre", asked.scale)
    for axis, start, width, count in zip("xyz", origin, spacing, shape, strict=False):
        end = start + width * (count - 1)
        if max(abs(start), abs(end)) > FARTHEST:
            text = f"the grid of `{asked.path}` goes from {start:g} to {end:g} mm along {axis}"
            raise asked.fail("E134", text, f"parts lie within {FARTHEST:,.0f} mm of the origin: {asked.scale}")


def layered(asked: Asked, shape: Sequence[int], what: str = "nodes") -> None:
    """Errors: E133 where a grid has less than two layers along an axis."""
    for axis, count in zip("xyz", shape, strict=False):
        if count < 2:
            nodes = f"1 {what[:-1]}" if count == 1 else f"no {what}"
            hint = f"two {what} at least along each axis: repeat the layer for what does not change along {axis}"
            raise asked.fail("E133", f"`{asked.name}` in `{asked.path}` has {nodes} along {axis}", hint)


def floats(array: Array) -> Array:
    """Numbers as float32 where they are, else as float64, contiguous and not to be written."""
    single = array.dtype.kind == "f" and array.dtype.itemsize == 4
    with np.errstate(over="ignore"):  # of long doubles, which are then not finite
        out = np.array(array, np.float32 if single else np.float64, order="C")
    out.setflags(write=False)
    return out
