"""Surfaces to files: `.stl`, `.obj`, `.ply` by ending, written whole or not at all."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import PoreError, fail, suggest
from porelang.mesh.surface import AT_ONCE, Surface


def write(surface: Surface, path: str | Path) -> Path:
    """Write a surface (mm) in the format that the path's ending names, and give the path.

    The file appears when it is complete: until then it has another name in the same folder, and after a failure or an
    interruption nothing is left. E112: the ending is not known. E113: the file cannot be written there. E115: an STL
    file's 32-bit numbers are too coarse for the surface.
    """
    path = Path(path)
    writer = writer_of(path)
    if path.suffix.lower() == ".stl":
        defects = surface.rounded().check_vertices()
        if defects:
            raise fail(
                "E115",
                f"{path.name}: the mesh is too fine for STL, which stores 32-bit numbers: {'; '.join(defects)}",
                hint="write .ply or .obj, use a larger voxel, or move the part nearer to the origin",
            )
    save(path, lambda file: writer(surface, file))
    return path


def writer_of(path: str | Path) -> Callable[[Surface, BinaryIO], None]:
    """The writer for a path's ending; E112 if there is none."""
    ending = Path(path).suffix.lower()
    if ending in WRITERS:
        return WRITERS[ending]
    near = suggest(ending, WRITERS)
    names = " ".join(WRITERS)
    raise fail(
        "E112",
        f"{Path(path).name}: {f'no mesh format is called {ending}' if ending else 'the name has no ending'}",
        hint=f"did you mean {near}? The formats are {names}" if near else f"end the name with one of {names}",
    )


def save(path: str | Path, write_to: Callable[[BinaryIO], None]) -> None:
    """Write a file whole or not at all: under another name in the same folder, then renamed. E113 if that fails."""
    target = Path(os.path.realpath(path))
    if os.path.isdir(target):
        raise fail("E113", f"cannot write {path}: it is a folder", hint=f"name a file: {Path(path) / 'part.stl'}")
    if not os.path.isdir(target.parent):
        hint = f"make it first: mkdir -p {target.parent}"
        raise fail("E113", f"cannot write {path}: there is no folder {target.parent}", hint=hint)
    draft = target.with_name(f".{target.name[:64]}.{secrets.token_hex(4)}.part")
    try:
        try:
            with open(draft, "xb") as file:
                write_to(file)
                file.flush()
                os.fsync(file.fileno())
            if target.exists():
                shutil.copymode(target, draft)
            os.replace(draft, target)
        finally:
            if os.path.lexists(draft):
                draft.unlink()
    except OSError as error:
        raise _unwritable(path, error) from error


def _unwritable(path: str | Path, error: OSError) -> PoreError:
    reason = (error.strerror or str(error)).lower()
    return fail("E113", f"cannot write {path}: {reason}", hint="choose a folder with room that you may write to")


def write_stl(surface: Surface, file: BinaryIO) -> None:
    """Binary STL: float32, one normal and three corners a triangle."""
    # A header that begins with "solid" would be taken for a text file.
    file.write(b"binary STL, mm".ljust(80) + np.array(len(surface.faces), "<u4").tobytes())
    form = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    vertices, rounded = surface.vertices.astype(np.float32), surface.rounded()
    for i in range(0, len(surface.faces), AT_ONCE):
        part = Surface(rounded.vertices, surface.faces[i : i + AT_ONCE])
        normals = part.normals()
        length = np.sqrt(np.einsum("ij,ij->i", normals, normals))[:, None]
        records = np.zeros(len(part.faces), form)
        records["normal"] = np.divide(normals, length, out=normals, where=length > 0)
        records["corners"] = vertices[part.faces]
        file.write(records.tobytes())


def write_ply(surface: Surface, file: BinaryIO) -> None:
    """Binary PLY with vertices in float64."""
    header = (
        "ply\nformat binary_little_endian 1.0\ncomment mm\n"
        f"element vertex {len(surface.vertices)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(surface.faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    records = np.zeros(len(surface.faces), np.dtype([("count", "u1"), ("corners", "<i4", 3)]))
    records["count"] = 3
    records["corners"] = surface.faces
    file.write(header.encode("ascii"))
    file.write(surface.vertices.astype("<f8").tobytes())
    file.write(records.tobytes())


def write_obj(surface: Surface, file: BinaryIO) -> None:
    """Wavefront OBJ: vertices in decimal digits that keep the mesh sound, faces counted from 1."""
    file.write(b"# mm\n")
    for text in chain(_lines("v %.12g %.12g %.12g\n", surface.vertices), _lines("f %d %d %d\n", surface.faces + 1)):
        file.write(text.encode("ascii"))


def _lines(form: str, rows: NDArray[np.float64] | NDArray[np.int32]) -> Iterator[str]:
    for i in range(0, len(rows), AT_ONCE):
        some = rows[i : i + AT_ONCE]
        yield form * len(some) % tuple(some.ravel().tolist())


WRITERS: dict[str, Callable[[Surface, BinaryIO], None]] = {".stl": write_stl, ".obj": write_obj, ".ply": write_ply}
