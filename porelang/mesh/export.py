"""Surfaces to files: `.stl .obj .ply .3mf .glb .vtp` by ending, written whole or not at all."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path
from typing import BinaryIO

import numpy as np

from porelang.atomic import save
from porelang.diagnostics import fail, suggest
from porelang.mesh.exchange import METRE, lines, raw, write_3mf, write_glb, write_vtp
from porelang.mesh.surface import AT_ONCE, Surface, decimal, single
from porelang.threemf.package import DIGITS, NUMBER, Notes

Writer = Callable[[Surface, BinaryIO, Notes], None]
#: Formats that keep every bit.
EXACT = frozenset({".ply", ".vtp"})
#: The others: how a message names them, what of a surface's places they store, and how that is called.
STORED = {
    ".stl": ("STL", single(1.0), "32-bit numbers"),
    ".glb": ("GLB", single(METRE), "32-bit numbers"),
    ".obj": ("OBJ", decimal(DIGITS), f"{DIGITS} digits"),
    ".3mf": ("3MF", decimal(DIGITS), f"{DIGITS} digits"),
}


def write(surface: Surface, path: str | Path, notes: Notes | None = None) -> Path:
    """Write a surface (mm) in the format that the path's ending names, and give the path.

    `notes` are texts by name (params, the hash of the program) for the formats that have room for them: all but STL.
    The file appears when it is complete: until then it has another name in the same folder, and after a failure or an
    interruption nothing is left. E112: the ending is not known. E113: the file cannot be written there. E115: the
    format's numbers are too coarse for the surface, or its size too small. E119: the surface is not sound itself.
    """
    path = Path(path)
    writer = writer_of(path)
    ending = path.suffix.lower()
    if defects := surface.check_vertices():
        raise fail(
            "E119",
            f"{path.name}: the mesh is not sound: {'; '.join(defects)}",
            hint="use another voxel, or leave out --sharp, --smooth or --simplify",
        )
    if ending not in EXACT:
        name, stored, what = STORED[ending]
        if defects := surface.check_vertices(stored):
            raise fail(
                "E115",
                f"{path.name}: the mesh is too fine for {name}, which stores {what}: {'; '.join(defects)}",
                hint="write .ply or .vtp, use a larger voxel, or move the part nearer to the origin",
            )
    save(path, lambda file: writer(surface, file, notes or {}))
    return path


def writer_of(path: str | Path) -> Writer:
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


def write_stl(surface: Surface, file: BinaryIO, notes: Notes) -> None:
    """Binary STL: float32, one normal and three corners a triangle."""
    # A header that begins with "solid" would be taken for a text file.
    file.write(b"binary STL, mm".ljust(80) + np.array(len(surface.faces), "<u4").tobytes())
    form = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    for i in range(0, len(surface.faces), AT_ONCE):
        corners = surface.vertices[surface.faces[i : i + AT_ONCE]].astype(np.float32)
        exact = corners.astype(np.float64)
        normals = np.cross(exact[:, 1] - exact[:, 0], exact[:, 2] - exact[:, 0])
        length = np.sqrt(np.einsum("ij,ij->i", normals, normals))[:, None]
        records = np.zeros(len(corners), form)
        records["normal"] = np.divide(normals, length, out=normals, where=length > 0)
        records["corners"] = corners
        file.write(records.tobytes())


def write_ply(surface: Surface, file: BinaryIO, notes: Notes) -> None:
    """Binary PLY with vertices in float64; notes as comments."""
    header = (
        "ply\nformat binary_little_endian 1.0\ncomment mm\n"
        + "".join(f"comment {line}\n" for line in _comments(notes))
        + f"element vertex {len(surface.vertices)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(surface.faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    file.write(header.encode("ascii"))
    for piece in raw(surface.vertices, "<f8"):
        file.write(piece)
    form = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
    for i in range(0, len(surface.faces), AT_ONCE):
        corners = surface.faces[i : i + AT_ONCE]
        records = np.empty(len(corners), form)
        records["count"] = 3
        records["corners"] = corners
        file.write(records.tobytes())


def write_obj(surface: Surface, file: BinaryIO, notes: Notes) -> None:
    """Wavefront OBJ: vertices in decimal digits that keep the mesh sound, faces counted from 1; notes as comments."""
    file.write("".join(f"# {line}\n" for line in ("mm", *_comments(notes))).encode("ascii"))
    for text in chain(lines(f"v {NUMBER} {NUMBER} {NUMBER}\n", surface.vertices), _counted(surface)):
        file.write(text)


def _counted(surface: Surface) -> Iterator[bytes]:
    for i in range(0, len(surface.faces), AT_ONCE):
        yield from lines("f %d %d %d\n", surface.faces[i : i + AT_ONCE] + 1)


def _comments(notes: Notes) -> list[str]:
    """Notes as lines of plain ASCII, which is all that a PLY header may hold: other characters by their numbers."""
    return [f"{name} {''.join(map(_plain, text))}" for name, text in notes.items()]


def _plain(character: str) -> str:
    """A character that can be printed in ASCII as it is, any other escaped."""
    return character if " " <= character <= "~" else ascii(character)[1:-1]


WRITERS: dict[str, Writer] = {
    ".stl": write_stl,
    ".obj": write_obj,
    ".ply": write_ply,
    ".3mf": write_3mf,
    ".glb": write_glb,
    ".vtp": write_vtp,
}
