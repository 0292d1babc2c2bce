"""Data that are handed to a program for params that take some: what they have to be, how they become samples."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.data import FARTHEST, LARGEST_VALUE, MOST_COUNTED, NEAREST, WORLD, SampledField, coordinates
from porelang.diagnostics import Diagnostic, PoreError, fail, suggest
from porelang.elaborate.results import DataInfo, ParamInfo
from porelang.progress import tell
from porelang.values import Unreadable, array_of, length

#: A function of points (n, 3), samples, an array of values at nodes, or `"FILE:ARRAY"`.
Bindable = Callable[[NDArray[np.float64]], Any] | SampledField | NDArray[Any] | Sequence[Any] | str
#: The corners of a box, in mm.
Corners = Sequence[Sequence[float]]
Within = Corners | str
#: Nodes of what is sampled from a function: 2 GB for one number in each; and bytes of an array.
_MOST, LARGEST = 256_000_000, 2_048_000_000
_AT_ONCE = 1 << 18
#: How many numbers there are in each place, in words; a tensor's are xx, yy, zz, xy, yz, xz.
_COUNTED = {1: "one number", 3: "three numbers", 6: "six numbers (xx, yy, zz, xy, yz, xz)"}
_BOX = "the corners of a box in mm, `within=((-20, -20, 0), (20, 20, 60))`, or the name of a solid of the program"


def no_such_data(name: str, data: Mapping[str, DataInfo], params: Mapping[str, ParamInfo]) -> Diagnostic:
    """E155: what is bound is no param that takes data."""
    if name in params:
        hint = f"set it: `--set {name}=...`, in Python `design({name}=...)`"
        return Diagnostic("E155", f"`{name}` is a number, and takes no data", params[name].span, "declared here",
                          hint=hint)  # fmt: skip
    near = suggest(name, data)
    has = f"it has {', '.join(f'`{n}`' for n in data)}" if data else "declare it: `param stress: field = 0MPa`"
    hint = f"did you mean `{near}`?" if near else has
    return Diagnostic("E155", f"the program has no param `{name}` that takes data", hint=hint)


def array_bound(info: DataInfo, given: str) -> tuple[str, str, str]:
    """The file, the array and the options of a text that is bound. Errors: E155."""
    try:
        file, array, options = array_of(given)
    except Unreadable as error:
        hint = (
            'a text is "FILE:ARRAY", as in "result.vtu:von_mises,unit=Pa"; what is the same everywhere is the default'
        )
        raise _wrong(info, str(error), f"{hint}: `param {info.name}: {info.kind} = {given:.20}`") from None
    return os.path.abspath(file), array, options


def no_idle_options(
    data: Mapping[str, DataInfo], given: Mapping[str, Bindable], voxel: float | str | None, within: Within | None
) -> None:
    """E155 where `voxel` or `within` is given, and nothing that is bound takes it: files say it themselves."""
    idle = [word for word, said in (("within", within), ("voxel", voxel)) if said is not None]
    if not (idle and given and all(isinstance(d, str | SampledField) for d in given.values())):
        return
    name, first = next(iter(given.items()))
    what = "a file" if isinstance(first, str) else "a SampledField"
    hint = f"leave `{idle[0]}` out: it is for a function or an array"
    if isinstance(first, str):
        hint += ', and how a file is read stands in its text, `"FILE:ARRAY,voxel=1mm"`'
    raise _wrong(data[name], f"{what} says itself where its samples lie, and `{idle[0]}` is given", hint)


def samples_of(info: DataInfo, given: Bindable, voxel: float | str | None, within: Corners | None) -> SampledField:
    """What is bound to a param, as samples. Errors: E155 at its declaration."""
    try:
        if isinstance(given, SampledField):
            found = given
        elif callable(given):
            found = _sampled(info, given, *_spaced(info, voxel, _box(info, within, "a function")))
        elif isinstance(given, np.ndarray | Sequence) or hasattr(given, "__array__"):
            found = _spanning(info, given, within, voxel)
        else:
            hint = f"what is the same everywhere is the default: `param {info.name}: field = {given}`"
            hint = hint if isinstance(given, int | float | np.number) else ""
            raise _wrong(info, f"it is {given!r:.40}, which is no data", hint)
    except ValueError as error:  # of `SampledField.from_array`
        raise _wrong(info, str(error)) from None
    except MemoryError:
        raise _wrong(info, "there is no memory for it", "keep every second node, or float32") from None
    if found.components != info.components:
        has = "one number" if found.components == 1 else f"{found.components} numbers"
        belong = "belongs" if info.components == 1 else "belong"
        text = f"it has {has} in each place, where {_COUNTED[info.components]} {belong}"
        raise _wrong(info, text, f"it is declared as a `{info.kind}`")
    if (largest := float(np.abs(found.values).max())) > LARGEST_VALUE:
        raise _wrong(info, f"it goes to {largest:.2g}, beyond {LARGEST_VALUE:g}", "give it in a larger unit")
    if max(map(abs, (*found.origin, *found.end))) > FARTHEST:
        raise _wrong(info, f"it reaches to ({coordinates(found.end)}) mm", WORLD)
    return found


def _wrong(info: DataInfo, why: str, hint: str = "") -> PoreError:
    form = "(nx, ny, nz)" if info.components == 1 else f"(nx, ny, nz, {info.components})"
    forms = f'a SampledField, an array {form} with `within`, a function of points (n, 3) with `voxel` too, "FILE:ARRAY"'
    hint = hint or f"give {forms}"
    return fail("E155", f"`{info.name}` cannot be bound to this: {why}", info.span, label="declared here", hint=hint)


def _box(info: DataInfo, within: Corners | None, what: str) -> NDArray[np.float64]:
    """The corners (2, 3) of the box that data lie in."""
    if within is None:
        raise _wrong(info, f"{what} does not say where it lies", f"give {_BOX}")
    try:
        corners = np.array(within, np.float64)
    except (TypeError, ValueError):
        corners = np.empty(0)
    if corners.shape != (2, 3) or not np.isfinite(corners).all() or not (corners[1] - corners[0] > NEAREST).all():
        raise _wrong(info, f"`within` is {within!r:.80}", f"give {_BOX}; the lower corner comes first")
    return corners


def _spaced(
    info: DataInfo, voxel: float | str | None, box: NDArray[np.float64]
) -> tuple[NDArray[np.float64], tuple[int, int, int]]:
    """The numbers of nodes over a box along each axis, the first and the last of them on its faces."""
    if voxel is None:
        raise _wrong(info, "a function has no samples", 'say how far apart they are to lie: `voxel="0.5mm"`')
    try:
        step = length(voxel) if isinstance(voxel, str) else float(voxel)
    except (Unreadable, TypeError, ValueError) as error:
        hint = "it is a length in mm, or a text with a unit"
        raise _wrong(info, f"`voxel` is {voxel!r:.40}: {error}", hint) from None
    if not NEAREST <= step <= FARTHEST:
        raise _wrong(info, f"`voxel` is {step:g} mm", "it is a length above 0")
    size = box[1] - box[0]
    nx, ny, nz = (max(math.ceil(s / step - 1e-9), 1) + 1 for s in size.tolist())
    if nx * ny * nz * info.components > _MOST or max(nx, ny, nz) > MOST_COUNTED:
        enough = max(float(np.prod(size) * info.components / _MOST) ** (1 / 3), float(size.max()) / MOST_COUNTED)
        hint = f"one of {1.1 * enough:.2g} mm would do"
        raise _wrong(info, f"a voxel of {step:g} mm makes {nx * ny * nz:.2g} samples", hint)
    return box, (nx, ny, nz)


def _sampled(
    info: DataInfo,
    function: Callable[[NDArray[np.float64]], Any],
    box: NDArray[np.float64],
    shape: tuple[int, int, int],
) -> SampledField:
    """A function at the nodes of a grid, asked for some of them at a time."""
    nx, ny, nz = shape
    values = np.empty((nx * ny * nz, info.components))
    x, y, z = (np.linspace(low, high, n) for low, high, n in zip(*box.tolist(), shape, strict=True))
    for start in range(0, len(values), _AT_ONCE):
        tell(start, len(values))
        number = np.arange(start, min(start + _AT_ONCE, len(values)))
        points = np.stack([x[number // (ny * nz)], y[number // nz % ny], z[number % nz]], axis=1)
        try:
            found = np.asarray(function(points), np.float64)
        except Exception as error:  # whatever a function of somebody else's does
            text = " ".join(str(error).split())[:120]
            what = f"the function fails at {len(points):,} points (n, 3): {type(error).__name__}: {text}"
            lie = f"from ({coordinates(points.min(axis=0))}) to ({coordinates(points.max(axis=0))}) mm"
            hint = f"it is called with an array of points, a row each, here {lie}"
            raise _wrong(info, what, hint) from error
        wanted = (len(points),) if info.components == 1 else (len(points), info.components)
        if found.shape != wanted and found.shape != (len(points), info.components):
            what = f"the function gives {found.shape} for points {points.shape}"
            raise _wrong(info, what, f"it gives {_COUNTED[info.components]} for each point")
        bad = ~np.isfinite(found).reshape(len(points), -1).all(axis=1)
        if bad.any():
            raise _wrong(info, f"the function is not a number at ({coordinates(points[int(np.argmax(bad))])})",
                         "look for a division by zero there; an interpolator has no values outside its points: give "
                         "it the nearest there, or a `fill_value`")  # fmt: skip
        values[number] = found.reshape(len(points), info.components)
    spacing = (box[1] - box[0]) / (np.array(shape) - 1)
    return SampledField.from_array(values.reshape(*shape, info.components), box[0].tolist(), spacing.tolist())


def _spanning(info: DataInfo, given: Any, within: Corners | None, voxel: float | str | None) -> SampledField:
    """An array whose first and last nodes lie on the faces of a box."""
    values = np.ma.asarray(given) if isinstance(given, np.ma.MaskedArray) else np.asarray(given)
    if isinstance(values, np.ma.MaskedArray) and values.mask.any():
        hint = "fill it: `a.filled(0)`, or with the nearest value that is known"
        raise _wrong(info, f"{int(values.mask.sum()):,} of its values are masked", hint)
    if 8 * math.prod(values.shape) > LARGEST:
        hint = "keep every second node, or a part of it"
        raise _wrong(info, f"its {math.prod(values.shape):,} numbers are too many", hint)
    if values.dtype.kind == "f" and (bad := ~np.isfinite(values)).any():
        first = ", ".join(str(i) for i in np.argwhere(bad)[0])
        hint = "fill them: `np.nan_to_num(a, nan=0)`, or with the nearest value that is known"
        raise _wrong(info, f"{int(bad.sum()):,} of its values are not finite numbers, the first at [{first}]", hint)
    if values.ndim == 0:
        raise _wrong(info, f"it is {given!r:.40}, which is no data")
    box = _box(info, within, "an array")
    if voxel is not None:
        raise _wrong(info, "an array has its own spacing", "leave `voxel` out: its nodes span `within`")
    if values.ndim not in (3, 4) or min(values.shape[:3]) < 2:
        raise _wrong(info, f"its shape is {values.shape}")
    spacing = (box[1] - box[0]) / (np.array(values.shape[:3]) - 1)
    return SampledField.from_array(values, box[0].tolist(), spacing.tolist())
