"""Surfaces in the formats that other programs exchange: 3MF for printers, glTF for viewers, VTK for analysis.

Each writer gives a stream of bytes in pieces of AT_ONCE rows, so that a mesh is never copied whole.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from typing import BinaryIO
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import fail
from porelang.mesh.surface import AT_ONCE, Surface
from porelang.threemf.package import NUMBER, Notes, package

Rows = NDArray[np.float64] | NDArray[np.int32]
METRE = 1e-3  # of a millimetre
# glTF's up is +y and ours +z: a turn by -90 degrees about x, as a quaternion.
UPRIGHT = [-(0.5**0.5), 0.0, 0.0, 0.5**0.5]
MOST_GLB = 2**32 - 1


def lines(form: str, rows: Rows) -> Iterator[bytes]:
    """Rows as text, a piece at a time, each row by the %-format `form`."""
    for i in range(0, len(rows), AT_ONCE):
        some = rows[i : i + AT_ONCE]
        yield (form * len(some) % tuple(some.ravel().tolist())).encode("ascii")


def raw(rows: Rows, dtype: str) -> Iterator[bytes]:
    """Rows as little-endian numbers, a piece at a time."""
    for i in range(0, len(rows), AT_ONCE):
        yield rows[i : i + AT_ONCE].astype(dtype).tobytes()


def write_3mf(surface: Surface, file: BinaryIO, notes: Notes) -> None:
    """3MF core: a zip of one model in millimetres, with the notes as metadata `pore:NAME`."""
    with package(file, notes, build=1) as model:
        write_mesh(model, 1, surface)


def write_mesh(model: BinaryIO, number: int, surface: Surface) -> None:
    """A surface as an object of a 3MF model, by its number there."""
    model.write(f'<object id="{number}" type="model"><mesh><vertices>\n'.encode())
    for piece in lines(f'<vertex x="{NUMBER}" y="{NUMBER}" z="{NUMBER}"/>\n', surface.vertices):
        model.write(piece)
    model.write(b"</vertices><triangles>\n")
    for piece in lines('<triangle v1="%d" v2="%d" v3="%d"/>\n', surface.faces):
        model.write(piece)
    model.write(b"</triangles></mesh></object>")


def write_glb(surface: Surface, file: BinaryIO, notes: Notes) -> None:
    """Binary glTF 2.0: float32 in metres (glTF's unit), and a node that turns our +z to its +y, up; notes as extras."""
    ends = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    lo, hi = ((METRE * end).astype(np.float32).tolist() for end in ends)
    points, indices = 12 * len(surface.vertices), 12 * len(surface.faces)
    size = points + indices
    scene = {
        "asset": {"version": "2.0", "generator": "porelang", "extras": dict(notes)},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "part", "mesh": 0, "rotation": UPRIGHT}],
        "meshes": [{"name": "part", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": 4}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": points // 12, "type": "VEC3", "min": lo, "max": hi},
            {"bufferView": 1, "componentType": 5125, "count": indices // 4, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": points, "target": 34962},
            {"buffer": 0, "byteOffset": points, "byteLength": indices, "target": 34963},
        ],
        "buffers": [{"byteLength": size}],
    }
    text = json.dumps(scene, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + size
    if total > MOST_GLB:
        raise fail("E115", f"the mesh takes {total / 2**30:.1f} GiB, and a .glb file holds at most 4 GiB",
                   hint="write .ply or .vtp, or use a larger voxel")  # fmt: skip
    file.write(struct.pack("<4sIIII", b"glTF", 2, total, len(text), 0x4E4F534A) + text)
    file.write(struct.pack("<II", size, 0x004E4942))
    for i in range(0, len(surface.vertices), AT_ONCE):
        file.write((METRE * surface.vertices[i : i + AT_ONCE]).astype("<f4").tobytes())
    for piece in raw(surface.faces, "<u4"):
        file.write(piece)


def write_vtp(surface: Surface, file: BinaryIO, notes: Notes) -> None:
    """VTK PolyData: XML with raw float64 points (mm) and int32 triangles appended; notes as field data."""
    n, m = len(surface.vertices), len(surface.faces)
    sizes = (24 * n, 12 * m, 8 * m)
    at = (0, 8 + sizes[0], 16 + sizes[0] + sizes[1])
    strings = "".join(
        f'<Array type="String" Name={quoteattr(name)} NumberOfTuples="1" format="ascii">'
        f"{' '.join(str(b) for b in (*text.encode(), 0))}</Array>"
        for name, text in notes.items()
    )
    begin = (
        '<?xml version="1.0"?>\n'
        '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'
        f"<PolyData><FieldData>{strings}</FieldData>\n"
        f'<Piece NumberOfPoints="{n}" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="{m}">\n'
        '<Points><DataArray type="Float64" Name="Points" NumberOfComponents="3" format="appended" '
        f'offset="{at[0]}"/></Points>\n'
        f'<Polys><DataArray type="Int32" Name="connectivity" format="appended" offset="{at[1]}"/>\n'
        f'<DataArray type="Int64" Name="offsets" format="appended" offset="{at[2]}"/></Polys>\n'
        '</Piece></PolyData>\n<AppendedData encoding="raw">\n_'
    )
    file.write(begin.encode())
    file.write(struct.pack("<Q", sizes[0]))
    for piece in raw(surface.vertices, "<f8"):
        file.write(piece)
    file.write(struct.pack("<Q", sizes[1]))
    for piece in raw(surface.faces, "<i4"):
        file.write(piece)
    file.write(struct.pack("<Q", sizes[2]))
    for i in range(0, m, AT_ONCE):
        file.write(np.arange(3 * i + 3, 3 * min(i + AT_ONCE, m) + 3, 3, dtype="<i8").tobytes())
    file.write(b"\n</AppendedData></VTKFile>\n")
