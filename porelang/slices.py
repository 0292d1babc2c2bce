"""Layers for printing, straight from the field: pictures or contours, a few layers in memory at a time."""

from __future__ import annotations

import itertools
import json
import math
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from porelang.backends.numpy import Dtype
from porelang.diagnostics import fail
from porelang.passes.box import Box
from porelang.program import Backend, Program, make_field
from porelang.settings import Setting
from porelang.surface import Bounds, checked_bounds

Format = Literal["png", "svg"]
Plane = NDArray[Any]
MANIFEST = "layers.json"
_AT_ONCE = 1 << 24  # samples
_MOST_LAYERS = 100_000
_MOST_PIXELS = 1 << 28


@dataclass(frozen=True, slots=True)
class Stack:
    """Layers across z: pixel middles along x and y, and the height of the middle of each layer, all in mm."""

    box: Box
    step: float
    pixel: float
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    z: NDArray[np.float64]


def stack_of(box: Box, step: float, pixel: float) -> Stack:
    """The layers of a box; the pixels cover it, the last row and layer may reach beyond. Errors: E114."""
    counts = [math.ceil(s / h - 1e-9) for s, h in zip(box.size, (pixel, pixel, step), strict=True)]
    if counts[2] > _MOST_LAYERS or counts[0] * counts[1] > _MOST_PIXELS:
        raise fail(
            "E114",
            f"{counts[2]:,} layers of {counts[0]:,} x {counts[1]:,} pixels are too many",
            hint="use a larger --step or --voxel",
        )
    x, y, z = (
        np.asarray(lo + (np.arange(n) + 0.5) * h, np.float64)
        for lo, n, h in zip(box.lo, counts, (pixel, pixel, step), strict=True)
    )
    return Stack(box, step, pixel, x, y, z)


def write_slices(
    program: Program,
    folder: str | Path,
    step: float,
    *,
    name: str | None = None,
    form: Format = "png",
    pixel: float | None = None,
    bounds: Bounds | None = None,
    backend: Backend = "numpy",
    dtype: Dtype = "f32",
    settings: Mapping[str, Setting] | None = None,
    progress: Callable[[int, int], None] | None = None,
    cancel: Callable[[], bool] | None = None,
) -> dict[str, Any]:
    """Write a layer every `step` mm into a folder, with a manifest, and return the manifest.

    PNG: white is solid, y points up, one pixel is `pixel` mm (by default the step). SVG: closed contours in mm.
    The folder appears whole or not at all; an older folder of layers is replaced, any other is left alone.
    Errors: E113 for a folder that is in the way, E114 for too many layers, and those of the output.
    """
    settings = settings or {}
    target = Path(folder)
    _clear_for(target)
    root, values = program.solid(name), program.settle(**settings)
    box = checked_bounds(bounds) if bounds is not None else program.bounds(name, **settings)
    stack = stack_of(box, step, pixel or step)
    field = make_field((root,), values, program.graph.ranges, backend, dtype)
    sampled = field.on_grid([stack.x, stack.y, stack.z])
    write = _png if form == "png" else _svg
    digits = max(4, len(str(len(stack.z))))
    temporary = Path(tempfile.mkdtemp(prefix=f".{target.name}.", dir=target.resolve().parent))
    try:
        areas: list[float] = []
        for k, plane in _planes(sampled, stack):
            write(temporary / f"layer_{k:0{digits}}.{form}", plane, stack)
            areas.append(float(np.count_nonzero(plane < 0)) * stack.pixel**2)
            if progress is not None:
                progress(k + 1, len(stack.z))
            if cancel is not None and cancel():
                raise CancelledError
        manifest = {
            "layers": len(stack.z),
            "format": form,
            "step": step,
            "pixel": stack.pixel,
            "bounds": [list(box.lo), list(box.hi)],
            "z": [float(v) for v in stack.z],
            "area": areas,
            "volume": float(np.sum(areas)) * step,
        }
        (temporary / MANIFEST).write_text(json.dumps(manifest))
        temporary.chmod(0o755)
        if target.exists():
            shutil.rmtree(target)
        os.replace(temporary, target)
    except BaseException:
        shutil.rmtree(temporary, ignore_errors=True)
        raise
    return manifest


def _clear_for(target: Path) -> None:
    """Refuse a target that is not ours to replace. Errors: E113."""
    if not target.resolve().parent.is_dir():
        raise fail("E113", f"cannot write `{target}`: its folder does not exist", hint=f"mkdir -p {target.parent}")
    if target.exists() and not target.is_dir():
        raise fail("E113", f"`{target}` is a file, and layers need a folder", hint="name a new folder")
    if target.is_dir() and any(target.iterdir()) and not (target / MANIFEST).exists():
        raise fail(
            "E113", f"the folder `{target}` holds other things", hint="name a new folder, or an older one of layers"
        )


def _planes(sampled: Any, stack: Stack) -> Iterator[tuple[int, Plane]]:
    """The layers, computed a few at a time."""
    nx, ny, nz = len(stack.x), len(stack.y), len(stack.z)
    several = max(1, min(nz, _AT_ONCE // (nx * ny)))
    for start in range(0, nz, several):
        stop = min(start + several, nz)
        block = sampled.block((0, 0, start), (nx, ny, stop))
        for k in range(start, stop):
            yield k, block[:, :, k - start]


def _png(path: Path, plane: Plane, stack: Stack) -> None:
    from PIL import Image

    solid = np.ascontiguousarray((plane < 0).T[::-1])
    per_inch = 25.4 / stack.pixel
    Image.fromarray(solid.astype(np.uint8) * 255).convert("1").save(path, dpi=(per_inch, per_inch), optimize=False)


def _svg(path: Path, plane: Plane, stack: Stack) -> None:
    """Filled regions as closed paths; the layer is framed by void, so that what is cut at the bounds is closed
    there."""
    from contourpy import FillType, contour_generator

    framed = np.pad(np.asarray(plane, dtype=np.float64), 1, constant_values=stack.pixel)
    h = stack.pixel
    x = np.concatenate([[stack.x[0] - h], stack.x, [stack.x[-1] + h]])
    y = np.concatenate([[stack.y[0] - h], stack.y, [stack.y[-1] + h]])
    lowest = min(float(framed.min()), 0.0) - 1.0
    made = contour_generator(x, y, framed.T, fill_type=FillType.OuterOffset).filled(lowest, 0.0)
    paths: list[str] = []
    for points, offsets in zip(made[0], made[1], strict=True):
        if points is None or offsets is None:
            continue
        rings = [points[a:b] for a, b in itertools.pairwise(offsets)]
        paths.append("".join(_ring(ring) for ring in rings))
    (x0, y0, _), (sx, sy, _) = stack.box.lo, stack.box.size
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{sx:.6g}mm" height="{sy:.6g}mm" '
        f'viewBox="{x0:.6g} {-(y0 + sy):.6g} {sx:.6g} {sy:.6g}">\n'
        f'<g transform="scale(1,-1)" fill="black" fill-rule="evenodd">\n'
        + "".join(f'<path d="{d}"/>\n' for d in paths)
        + "</g>\n</svg>\n"
    )


def _ring(points: NDArray[np.float64]) -> str:
    """A closed path; the last point repeats the first and is left out."""
    return "M" + "L".join(f"{px:.4f},{py:.4f}" for px, py in points[:-1]) + "Z"
