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
_ONE = "it lists other files: name one of those"
_MESHIO = 'meshio reads it (pip install meshio): `meshio.read("{stem}{ending}").write("{stem}.vtu")`'
_SURFACE = "a surface has no inside: export the cells of the volume, as .vtu"
#: What to do with files of other endings, by these.
INSTEAD: Mapping[str, str] = {
    ".pvd": _ONE,
    ".pvtu": _ONE,
    ".pvti": _ONE,
    ".vtm": _ONE,
    ".vts": "write it as .vtu (in ParaView: the filter Append Datasets)",
    ".vtr": "write it as .vti or .vtu (in ParaView: the filters Resample To Image, Append Datasets)",
    ".vtp": _SURFACE,
    ".stl": _SURFACE + '; as a solid it is `mesh("{stem}.stl")`',
    ".nhdr": "write it in one file with its header, as .nrrd: `nrrd.write(...)`, or in 3D Slicer",
    ".mha": "write it as .nrrd: `SimpleITK.WriteImage(SimpleITK.ReadImage(...), ...)`, or in 3D Slicer",
    ".nii": "write it as .nrrd, with SimpleITK or in 3D Slicer",
    ".npy": "it does not say where it lies: write `numpy.savez(path, {name}=values, origin=[0, 0, 0], spacing=0.5)`",
    ".csv": "points alone have no cells: interpolate them on a grid with scipy.interpolate.griddata, as .npz",
    **dict.fromkeys((".msh", ".inp", ".xdmf", ".med", ".unv", ".bdf", ".exo", ".e", ".h5m", ".xdmf3"), _MESHIO),
    **dict.fromkeys((".frd", ".odb", ".rst", ".op2"), "export its cells with their values as .vtu or .vtk"),
}
#: Those that may hold cells, whose samples are kept.
OF_CELLS = (".vtu", ".vtk")
_CHUNK = 1 << 20


def read_grid(
    path: str,
    name: str,
    span: Span | None = None,
    voxel: float = 0.0,
    masked: bool = False,
    lengths: float | None = None,
) -> SampledField:
    """The array `name` of a file as a grid of one number a node, three (a vector) or six (a symmetric tensor).

    `voxel` is the spacing in mm that cells are rasterised with, found from them unless given (0). With `masked` one
    component more says how far outside of what the file covers each node lies, in mm, below 0 inside.
    `lengths` is how many mm a length of the file is, where the program says so.
    Errors: E130-E135 and E150-E152, placed at `span`.
    """
    endings = tuple(READERS)
    part = f"{voxel!r} {masked} {lengths!r} {name}"
    asked = Asked(path, name, span, READERS.get(Path(path).suffix.lower(), ("", ""))[1].format(name=name), lengths,
                  masked)  # fmt: skip
    known = Path(path)
    instead = INSTEAD.get(known.suffix.lower(), "").format(stem=known.stem, ending=known.suffix, name=name)
    return remembered(path, endings, "a file of samples", span, partial(_read, asked, voxel), part, instead)


def _read(asked: Asked, voxel: float, file: BinaryIO, size: int) -> SampledField:
    ending = Path(asked.path).suffix.lower()
    key = _key(asked, file, ending, voxel) if ending in OF_CELLS else ""
    kept = store.get(key) if key else None
    if isinstance(kept, SampledField):
        return _part(kept, asked.masked)
    # each kind of file is read by a module that is imported when one is
    found = importlib.import_module(f"{__name__}.{READERS[ending][0]}").read(asked, file, size)
    if isinstance(found, Cells):
        from porelang.tasks.readers.raster import rasterised

        whole = rasterised(asked, found, voxel).part(masked=True)
        store.put(key, whole, label=f"{os.path.basename(asked.path)}: {asked.name}")
        return _part(whole, asked.masked)
    if voxel:
        text = f"`{asked.path}` is a grid already, and has no cells to be sampled every {voxel:g} mm"
        raise asked.fail("E152", text, "leave `voxel` out")
    assert isinstance(found, Grid)
    return found.part(asked.masked)


def _key(asked: Asked, file: BinaryIO, ending: str, voxel: float) -> str:
    """What samples of cells are kept by: what is in the file, what of it was asked for, and the code that samples."""
    digest = hashlib.sha256(f"{code_digest()} {ending} {voxel!r} {asked.lengths!r} {asked.name}".encode())
    while chunk := file.read(_CHUNK):
        digest.update(chunk)
    file.seek(0)
    return digest.hexdigest()


def _part(whole: SampledField, masked: bool) -> SampledField:
    """Samples whose last component is their depth, with it or without."""
    if masked:
        return whole
    return SampledField(floats(whole.values[..., :-1]), whole.origin, whole.spacing, whole.facts)
