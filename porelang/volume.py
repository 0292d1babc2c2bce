"""The values of fields on a regular grid, straight into a file: .vti for ParaView and other programs, .npz for NumPy.

Values are computed and written slab by slab: memory goes with a slab and not with the volume. `load` reads both.
"""

from __future__ import annotations

import math
import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import Box
from porelang.atomic import replace_file
from porelang.backends.numpy import Dtype
from porelang.diagnostics import fail
from porelang.expression import expression
from porelang.field import Backend, Bounds, Field, checked_bounds, make_field, number_type
from porelang.mesh.grid import chosen_voxel
from porelang.program import Design
from porelang.progress import activity, tell

WRITING = "writing the volume"
ENDINGS = (".vti", ".npz")
MOST_NODES = 2**36
AT_ONCE = 2**22  # samples of a slab
#: A box that is a whole number of voxels long, but for rounding, has no further node.
SLACK = 1e-6


@dataclass(frozen=True, slots=True)
class Nodes:
    """Nodes at `origin + index * spacing`, in mm, `shape` of them along x, y, z."""

    origin: tuple[float, ...]
    spacing: float
    shape: tuple[int, ...]

    def axes(self, axis: int, start: int, stop: int) -> list[NDArray[Any]]:
        """The coordinates of a slab: along one axis those of some nodes, along the others of all."""
        ends = [(0, n) for n in self.shape]
        ends[axis] = (start, stop)
        return [o + np.arange(a, b) * self.spacing for o, (a, b) in zip(self.origin, ends, strict=True)]


@dataclass(frozen=True, slots=True)
class _Array:
    """What is written under a name: a field, or the three of a vector."""

    name: str
    fields: tuple[Field, ...]


def write_volume(
    design: Design,
    path: str | Path,
    *,
    name: str | None = None,
    fields: Sequence[str] = (),
    voxel: float | None = None,
    resolution: int | None = None,
    bounds: Bounds | None = None,
    backend: Backend = "numpy",
    dtype: Dtype = "f32",
) -> dict[str, Any]:
    """Write an output, and further `fields` (outputs, lets or expressions of these), at nodes `voxel` mm apart, or with
    `resolution` voxels along the longest side (128 where neither is given).

    The nodes begin a voxel outside the box of the output and end as far beyond, or cover the `bounds` that are given.
    The file appears whole or not at all. Returns how many nodes there are, and where.
    Errors: E112 for another ending, E113 for a file that cannot be written, E114 for too many nodes, those of fields.
    """
    ending = Path(path).suffix.lower()
    if ending not in ENDINGS:
        raise fail(
            "E112",
            f"{path}: volumes are written as {' or '.join(ENDINGS)}",
            hint="end the name with one of them; `pore volume FILE -o part.3mf` writes the function of a part",
        )
    box = checked_bounds(bounds) if bounds is not None else design.bounds(name)
    nodes = nodes_of(box, voxel, 128 if voxel is None and resolution is None else resolution, bounds is None)
    ranges = design.program.ranges
    arrays = []
    for given in dict.fromkeys([design.program.output(name), *fields]):
        roots = expression(design.program, given, "--field").roots
        formulas = [design.formula(root) for root in roots]
        kinds = [number_type(f, box, nodes.spacing, backend, dtype) for f in formulas]
        kind: Dtype = "f64" if "f64" in kinds else "f32"
        arrays.append(_Array(given, tuple(make_field(f, ranges, backend, kind) for f in formulas)))
    real = np.float64 if dtype == "f64" else np.float32
    with replace_file(path) as file, activity(WRITING):
        (_vti if ending == ".vti" else _npz)(file, nodes, arrays, real)
    return {
        "nodes": list(nodes.shape),
        "origin": list(nodes.origin),
        "spacing": nodes.spacing,
        "fields": [a.name for a in arrays],
        "dtype": dtype,
    }


def nodes_of(box: Box, voxel: float | None, resolution: int | None, around: bool) -> Nodes:
    """Nodes that cover a box, with one more `around` it. Errors: E114."""
    spacing = chosen_voxel(max(box.size), voxel, resolution)
    lo = tuple(a - spacing for a in box.lo) if around else tuple(box.lo)
    more = 2 if around else 0
    counts = [max(2, math.ceil(s / spacing + more - SLACK) + 1) for s in box.size]
    if math.prod(counts) > MOST_NODES:
        raise fail("E114", f"{counts[0]:,} x {counts[1]:,} x {counts[2]:,} nodes are too many",
                   hint="use a larger --voxel, or --bounds for a part of it")  # fmt: skip
    return Nodes(lo, spacing, tuple(counts))


def _slabs(array: _Array, nodes: Nodes, axis: int, share: tuple[int, int]) -> Iterator[NDArray[Any]]:
    """The values of an array in slabs across an axis, (x, y, z, components); `share` counts arrays, for progress."""
    across = math.prod(nodes.shape) // nodes.shape[axis]
    several = max(1, AT_ONCE // across)
    for start in range(0, nodes.shape[axis], several):
        axes = nodes.axes(axis, start, min(start + several, nodes.shape[axis]))
        shape = tuple(len(a) for a in axes)
        yield np.stack([f.on_grid(axes).block((0, 0, 0), shape) for f in array.fields], axis=-1)
        tell(share[0] * nodes.shape[axis] + start + shape[axis], share[1] * nodes.shape[axis])


def _npz(file: BinaryIO, nodes: Nodes, arrays: Sequence[_Array], real: type) -> None:
    with zipfile.ZipFile(file, "w") as archive:
        for k, array in enumerate(arrays):
            several = len(array.fields) > 1
            shape = (*nodes.shape, len(array.fields)) if several else nodes.shape

            def written(into: Any, array: _Array = array, shape: tuple[int, ...] = shape, k: int = k) -> None:
                header = {"descr": np.dtype(real).str, "fortran_order": False, "shape": shape}
                np.lib.format.write_array_header_2_0(into, header)
                for slab in _slabs(array, nodes, 0, (k, len(arrays))):
                    into.write(np.ascontiguousarray(slab, real).tobytes())

            _member(archive, array.name, written)
        for name, values in (("origin", nodes.origin), ("spacing", [nodes.spacing] * 3)):
            _member(archive, name, lambda into, v=values: np.lib.format.write_array(into, np.array(v)))  # type: ignore[misc]  # a default binds now


def _member(archive: zipfile.ZipFile, name: str, write: Callable[[Any], None]) -> None:
    with archive.open(f"{name}.npy", "w", force_zip64=True) as into:
        write(into)


def _vti(file: BinaryIO, nodes: Nodes, arrays: Sequence[_Array], real: type) -> None:
    """ImageData with its values appended as they are in memory, x running fastest."""
    extent = " ".join(f"0 {n - 1}" for n in nodes.shape)
    origin, spacing = (" ".join(f"{v!r}" for v in values) for values in (nodes.origin, [nodes.spacing] * 3))
    size = np.dtype(real).itemsize
    kind = "Float64" if size == 8 else "Float32"
    lines, offset = [], 0
    for array in arrays:
        count = len(array.fields)
        lines.append(
            f'<DataArray type="{kind}" Name={quoteattr(array.name)} NumberOfComponents="{count}" '
            f'format="appended" offset="{offset}"/>'
        )
        offset += 8 + size * count * math.prod(nodes.shape)
    file.write(
        (
            '<?xml version="1.0"?>\n'
            '<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'
            f'<ImageData WholeExtent="{extent}" Origin="{origin}" Spacing="{spacing}">\n<Piece Extent="{extent}">\n'
            f"<PointData Scalars={quoteattr(arrays[0].name)}>\n" + "\n".join(lines) + "\n</PointData>\n</Piece>\n"
            '</ImageData>\n<AppendedData encoding="raw">\n_'
        ).encode()
    )
    for k, array in enumerate(arrays):
        file.write(np.uint64(size * len(array.fields) * math.prod(nodes.shape)).astype("<u8").tobytes())
        for slab in _slabs(array, nodes, 2, (k, len(arrays))):
            turned = slab.transpose(2, 1, 0, 3)
            file.write(np.ascontiguousarray(turned, np.dtype(real).newbyteorder("<")).tobytes())
    file.write(b"\n</AppendedData>\n</VTKFile>\n")
