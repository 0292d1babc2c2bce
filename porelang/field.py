"""Fields ready to be evaluated at points, by whichever backend: what `program.field` and `design.field` give."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.bounds import overflows, rounding
from porelang.analysis.box import Box
from porelang.analysis.enclose import F32
from porelang.backends.numpy import Dtype, GridField, NumpyField
from porelang.data import FARTHEST, WORLD
from porelang.diagnostics import Diagnostic, PoreError, fail
from porelang.formula import Formula

if TYPE_CHECKING:
    from porelang.gpu.fields import DeviceField, DeviceGrid

Backend = Literal["auto", "numpy", "glsl"]
Points = NDArray[np.float64]
Bounds = tuple[float, float, float, float, float, float]
#: Of a voxel: where float32 may place a surface further than this from where it is, float64 is used.
_COARSEST = 1 / 8


class Field:
    """A field ready to be evaluated. `backend` is the one that runs; `note` says why, where `auto` had to choose."""

    def __init__(self, evaluator: NumpyField | DeviceField, backend: str, note: str = ""):
        self.evaluator = evaluator
        self.backend = backend
        self.note = note
        self.of: tuple[Any, str] | None = None  # the design that was asked, and what for

    def __call__(self, points: Any) -> NDArray[Any]:
        """Values at points (n, 3) in mm: (n,), or (n, 3) for a vector. Errors: E104 for what is no place."""
        return self.evaluator.at(checked_points(points))

    def on_grid(self, axes: Sequence[NDArray[Any]]) -> GridField | DeviceGrid:
        """The field (of a number) on the grid of three coordinate axes in mm."""
        return self.evaluator.on_grid(axes)

    def __repr__(self) -> str:
        return f"<a field of {len(self.evaluator.formula.tape)} operations on {self.backend}>"

    def _repr_png_(self) -> bytes | None:
        """A slice of it, for a notebook; None where there is none."""
        from porelang.notebook.slice import shown

        return shown(self)


def checked_points(points: Any) -> Points:
    """Points as an array (n, 3) of float64, or of float32 if they are. Errors: E104."""
    try:
        given = np.asarray(points)
        if given.dtype.kind not in "fiubO":  # no texts, dates or complex numbers
            raise TypeError
        array = np.atleast_2d(given.astype(np.float32 if given.dtype == np.float32 else np.float64, copy=False))
    except (TypeError, ValueError, OverflowError):
        raise fail("E104", "points must be numbers", hint="give an array of shape (n, 3)") from None
    if array.size == 0 and array.shape in ((1, 0), (0, 3)):
        return np.empty((0, 3))
    if array.ndim != 2 or array.shape[1] != 3:
        raise fail(
            "E104", f"points have the shape {array.shape}, not (n, 3)", hint="give x, y, z of each point in a row"
        )
    if array.min() >= -FARTHEST and array.max() <= FARTHEST:  # what is no number fails both
        return array
    bad = ~np.isfinite(array).all(axis=1)
    if bad.any():
        row = int(np.argmax(bad))
        raise fail(
            "E104",
            f"point {row} is ({', '.join(f'{v:g}' for v in array[row])}), which is no place",
            hint="coordinates are finite numbers, in mm",
        )
    row = int(np.argmax(np.abs(array).max(axis=1)))
    raise fail("E104", f"point {row} lies more than 100 m from the origin", hint=f"coordinates are in mm; {WORLD}")


def checked_bounds(bounds: Bounds) -> Box:
    """Six numbers as a box. Errors: E107."""
    try:
        flat = [float(v) for v in np.ravel(bounds)]
    except (TypeError, ValueError):
        flat = []
    if len(flat) != 6 or not np.isfinite(flat).all():
        raise fail("E107", "bounds are six finite numbers", hint="give x0, y0, z0, x1, y1, z1 in mm, or two corners")
    if max(map(abs, flat)) > FARTHEST:
        raise fail("E117", "the bounds reach more than 100 m from the origin", hint=WORLD)
    lo, hi = flat[:3], flat[3:]
    if not all(a < b for a, b in zip(lo, hi, strict=True)):
        raise fail("E107", f"the bounds {', '.join(f'{v:g}' for v in flat)} hold no volume",
                   hint="give x0,y0,z0,x1,y1,z1 with each first corner below the second")  # fmt: skip
    return Box((lo[0], lo[1], lo[2]), (hi[0], hi[1], hi[2]))


def number_type(formula: Formula, box: Box, voxel: float, backend: Backend, dtype: Dtype) -> Dtype:
    """The numbers to sample a part with: `dtype`, or float64 where float32 cannot place its surface to a part of the
    voxel (mm), as far from the origin, or cannot hold its values. GLSL has no other numbers than float32 (W204)."""
    if dtype == "f64" or backend == "glsl":
        return dtype
    fits = rounding(formula, box.lo, box.hi) <= _COARSEST * voxel and not overflows(formula, box.lo, box.hi)
    return dtype if fits else "f64"


def rounding_doubts(formula: Formula, box: Box, voxel: float, backend: Backend, dtype: Dtype) -> list[Diagnostic]:
    """A warning (W204) where the numbers that a part is sampled with cannot place its surface as well as the voxel."""
    if dtype == "f64" or backend != "glsl":  # NumPy has taken what does (`number_type`)
        return []
    hint = "use --backend numpy, which takes float64 where it has to"
    off = rounding(formula, box.lo, box.hi)
    if overflows(formula, box.lo, box.hi):
        message = f"values of the field are too large for float32, which ends at {F32.huge:.1e}"
    elif off > _COARSEST * voxel:
        message = f"float32 may place the surface {off:.1g} mm from where it is, and the voxel is {voxel:.3g} mm"
        hint += "; or move the part to the origin"
    else:
        return []
    return [Diagnostic("W204", message, None, hint=hint, severity="warning")]


def make_field(
    formula: Formula,
    params: Mapping[str, tuple[float, float]],
    backend: Backend = "numpy",
    dtype: Dtype = "f64",
    threads: int | None = None,
) -> Field:
    """The field of a formula: of one root, or of three as a vector. `params` are the ranges of the program's params.

    `auto` is GLSL for float32 where there is a GPU, else NumPy.
    Errors: E120 where GLSL is asked for and there is no OpenGL, E123 where it is asked for in float64.
    """
    note = ""
    for what, given, known in (("backend", backend, ("auto", "numpy", "glsl")), ("dtype", dtype, ("f32", "f64"))):
        if given not in known:
            raise fail("E108", f"there is no {what} `{given}`", hint=f"choose from {', '.join(known)}")
    if backend == "glsl" and dtype == "f64":
        raise fail("E123", "GLSL computes in float32", hint="ask for f32, or for NumPy where float64 is needed")
    if backend == "glsl" or (backend == "auto" and dtype == "f32"):
        from porelang.gpu.fields import DeviceField, gpu  # `pore check` starts without it

        try:
            return Field(DeviceField(formula, params, gpu()), "glsl")
        except PoreError as error:
            if backend == "glsl":
                raise
            note = f"NumPy is used: {error.diagnostics[0].message}"
    return Field(NumpyField(formula, dtype, threads), "numpy", note)
