"""`load(path, name)`: samples that were measured or computed elsewhere, by the ending of their file.

Whoever wrote a file is not trusted: sizes are compared with what it claims before anything is allocated, nothing is
unpickled, and no other file is opened that it names. Cells are rasterised (`raster`), the rest are grids already.
"""

from __future__ import annotations

import hashlib
import importlib
import os
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import BinaryIO

from porelang import store
from porelang.data import SampledField
from porelang.diagnostics import fail
from porelang.source import Span
from porelang.tasks.datafile import remembered
from porelang.tasks.identity import code_digest
from porelang.tasks.readers.asked import Asked, floats
from porelang.tasks.readers.cells import Cells
from porelang.tasks.readers.grid import Grid

_EXPORT = "export it anew, with ParaView, VTK or meshio"
#: The module that reads each kind of file (`read(asked, file, size)`), and what to say where nothing better is known.
READERS: Mapping[str, tuple[str, str]] = {
    ".npz": ("npz", "write it with numpy.savez(path, {name}=values, origin=[0, 0, 0], spacing=0.5), lengths in mm"),
    ".vtu": ("vtu", _EXPORT),
    ".vtk": ("vtk", _EXPORT),
    ".vti": ("vti", _EXPORT),
    ".nrrd": ("nrrd", "write it anew, with 3D Slicer, ITK or pynrrd"),
}
#: Those that may hold cells, whose samples are kept.
OF_CELLS = (".vtu", ".vtk")
_CHUNK = 1 << 20


def read_grid(path: str, name: str, span: Span | None = None, voxel: float = 0.0, masked: bool = False) -> SampledField:
    """The array `name` of a file as a grid of one number a node, three (a vector) or six (a symmetric tensor).

    `voxel` is the spacing in mm that cells are rasterised with, found from them unless given (0). With `masked` one
    component more says how far outside of what the file covers each node lies, in mm, below 0 inside.
    Errors: E130-E135 and E150-E152, placed at `span`.
    """
    endings = tuple(READERS)
    part = f"{voxel!r} {masked} {name}"
    return remembered(path, endings, "a file of samples", span, partial(_read, path, name, span, voxel, masked), part)


def _read(
    path: str, name: str, span: Span | None, voxel: float, masked: bool, file: BinaryIO, size: int
) -> SampledField:
    ending = Path(path).suffix.lower()
    module, hint = READERS[ending]
    asked = Asked(path, name, span, hint.format(name=name))
    key = _key(file, ending, name, voxel) if ending in OF_CELLS else ""
    kept = store.get(key) if key else None
    if isinstance(kept, SampledField):
        return _part(kept, masked)
    # each kind of file is read by a module that is imported when one is
    found = importlib.import_module(f"{__name__}.{module}").read(asked, file, size)
    if isinstance(found, Cells):
        from porelang.tasks.readers.raster import rasterised

        whole = rasterised(asked, found, voxel).part(masked=True)
        store.put(key, whole, label=f"{os.path.basename(path)}: {name}")
        return _part(whole, masked)
    if voxel:
        text = f"`{path}` is a grid already, and has no cells to be sampled every {voxel:g} mm"
        raise fail("E152", text, span, hint="leave `voxel` out")
    assert isinstance(found, Grid)
    return found.part(masked)


def _key(file: BinaryIO, ending: str, name: str, voxel: float) -> str:
    """What samples of cells are kept by: what is in the file, what of it was asked for, and the code that samples."""
    digest = hashlib.sha256(f"{code_digest()} {ending} {voxel!r} {name}".encode())
    while chunk := file.read(_CHUNK):
        digest.update(chunk)
    file.seek(0)
    return digest.hexdigest()


def _part(whole: SampledField, masked: bool) -> SampledField:
    """Samples whose last component is their depth, with it or without."""
    if masked:
        return whole
    return SampledField(floats(whole.values[..., :-1]), whole.origin, whole.spacing, whole.facts)
