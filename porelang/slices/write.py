"""Layers as files in a folder, with a manifest: pictures or contours; or all in one file. Whole or not at all."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import Box, extent_of
from porelang.atomic import replace_file
from porelang.backends.numpy import Dtype, NumpyField
from porelang.diagnostics import fail
from porelang.field import Backend, Bounds, Field, checked_bounds, make_field, number_type
from porelang.formula import Formula
from porelang.program import Design
from porelang.progress import activity, tell
from porelang.slices import layer_interface
from porelang.slices.folder import MANIFEST, digest_of, layers_folder, replace_folder
from porelang.slices.outline import Ring, area_of, outlines
from porelang.slices.stack import SLACK, Band, Format, Stack, check_lengths, layers, stack_of

SLICING = "slicing"
#: A field (n,) at places (n, 3).
At3 = Callable[[NDArray[np.float64]], NDArray[Any]]


def write_slices(
    design: Design,
    folder: str | Path,
    step: float,
    *,
    name: str | None = None,
    form: Format = "png",
    pixel: float | None = None,
    bounds: Bounds | None = None,
    backend: Backend = "numpy",
    dtype: Dtype = "f32",
) -> dict[str, Any]:
    """Write a layer every `step` mm into a folder, with a manifest, and return the manifest.

    PNG: white is solid, y points up, one pixel is `pixel` mm (by default the step). SVG: closed contours in mm, from
    samples as far apart. The manifest names each layer's file, height and area. The folder appears whole or not at
    all; an older folder of layers is replaced, one that holds anything else is left alone.
    Errors: E111 where no layer holds anything, E113 for a folder that is in the way or cannot be written, E114 for too
    many layers, those of the output.
    """
    layers_folder(folder)  # what is refused is refused before anything is computed
    stack, field, exact = _sampled(design, step, name, pixel, bounds, backend, dtype)
    digits = max(4, len(str(len(stack.z))))
    with replace_folder(folder) as draft, activity(SLICING):
        areas: list[float] = []
        digests: list[str] = []
        files = [f"layer_{k:0{digits}}.{form}" for k in range(len(stack.z))]
        for k, bands in layers(field, stack, frame=form == "svg"):
            path = draft / files[k]
            areas.append(_svg(path, bands, stack, k, exact) if form == "svg" else _png(path, bands, stack))
            digests.append(digest_of(path))
            tell(k + 1, len(stack.z))
        _look_for_material(areas, stack)
        manifest = {**_found(form, stack, areas), "files": files, "sha256": digests}
        (draft / MANIFEST).write_text(json.dumps(manifest))
    return manifest


def write_layer_file(
    design: Design,
    path: str | Path,
    step: float,
    *,
    name: str | None = None,
    pixel: float | None = None,
    bounds: Bounds | None = None,
    backend: Backend = "numpy",
    dtype: Dtype = "f32",
) -> dict[str, Any]:
    """Write a layer every `step` mm into one file, as the Common Layer Interface (2.0, ASCII) has them, and return what
    a manifest says of layers.

    Contours are those of the SVG, in mm and in the part's own coordinates, from samples `pixel` mm apart (by default
    the step). Errors: those of `write_slices`.
    """
    stack, field, exact = _sampled(design, step, name, pixel, bounds, backend, dtype)
    areas: list[float] = []
    with replace_file(path) as file, activity(SLICING):
        file.write(layer_interface.head(stack, design.program.output(name)).encode())
        for k, bands in layers(field, stack, frame=True):
            rings = _rings(bands, stack, k, exact)
            file.write(layer_interface.layer(stack, k, rings).encode())
            areas.append(area_of(rings))
            tell(k + 1, len(stack.z))
        file.write(layer_interface.END.encode())
        _look_for_material(areas, stack)
    return _found("cli", stack, areas)


def _sampled(
    design: Design, step: float, name: str | None, pixel: float | None, bounds: Bounds | None, backend: Backend,
    dtype: Dtype,
) -> tuple[Stack, Field, At3]:  # fmt: skip
    """The layers of an output, its field, and its values at points."""
    pixel = step if pixel is None else pixel
    check_lengths(step, pixel)  # a box as tight as such a step asks for would take long
    formula = design.of(name)
    box = checked_bounds(bounds) if bounds is not None else _box_of(design, formula, name, step)
    stack = stack_of(box, step, pixel)
    dtype = number_type(formula, box, stack.pixel, backend, dtype)
    field = make_field(formula, design.program.ranges, backend, dtype)
    return stack, field, NumpyField(formula.taken, dtype).at


def _look_for_material(areas: list[float], stack: Stack) -> None:
    if not any(areas):
        raise fail(
            "E111",
            f"no layer holds material: pixels of {stack.pixel:g} mm, a layer every {stack.step:g} mm",
            hint="use a smaller --step or --voxel: a few to the thinnest wall",
        )


def _found(form: str, stack: Stack, areas: list[float]) -> dict[str, Any]:
    return {
        "layers": len(stack.z),
        "format": form,
        "step": stack.step,
        "pixel": stack.pixel,
        "bounds": [list(stack.box.lo), list(stack.box.hi)],
        "z": [float(v) for v in stack.z],
        "area": areas,
        "volume": float(np.array(areas) @ stack.thickness),
    }


def _rings(bands: Iterable[Band], stack: Stack, k: int, exact: At3) -> list[Ring]:
    """The contours of a layer; lines between samples misplace them where a field bends, so that it is asked."""
    return outlines(bands, stack, lambda at: exact(np.column_stack([at, np.full(len(at), stack.z[k])])))


def _box_of(design: Design, formula: Formula, name: str | None, step: float) -> Box:
    """The box of an output, so tight that no layer lies outside the part."""
    extent = design.extent(name)
    if extent.errors[2] > SLACK * step:
        extent = extent_of(formula, near=SLACK * step) or extent
    return extent.outer


def _png(path: Path, bands: Iterable[Band], stack: Stack) -> float:
    """Write a picture, a bit for a pixel, and return the area of what is white."""
    from PIL import Image

    solid = np.concatenate([band < 0 for band in bands])
    bits = np.packbits(solid.T[::-1], axis=1)
    per_inch = 25.4 / stack.pixel
    Image.frombytes("1", solid.shape, bits.tobytes()).save(path, dpi=(per_inch, per_inch))
    return float(np.count_nonzero(solid)) * stack.pixel**2


def _svg(path: Path, bands: Iterable[Band], stack: Stack, k: int, exact: At3) -> float:
    """Write the contours as one filled path, and return the area that they enclose."""
    rings = _rings(bands, stack, k, exact)
    (x0, y0, _), (sx, sy, _) = stack.box.lo, stack.box.size
    with open(path, "w", encoding="ascii") as file:
        file.write(
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{sx:.10g}mm" height="{sy:.10g}mm" '
            f'viewBox="{x0:.10g} {-(y0 + sy):.10g} {sx:.10g} {sy:.10g}">\n'
            f"<title>layer {k} of {len(stack.z)}, z = {stack.z[k]:.10g} mm</title>\n"
        )
        if rings:
            # y points down in SVG
            file.write('<path fill-rule="evenodd" d="')
            file.writelines("M" + "L".join(f"{x:.4f},{-y:.4f}" for x, y in ring.tolist()) + "Z" for ring in rings)
            file.write('"/>\n')
        file.write("</svg>\n")
    return area_of(rings)
