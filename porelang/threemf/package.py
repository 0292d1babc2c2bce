"""A 3MF package: a zip of one model in millimetres, with what it refers to. Nothing in it tells the time of day, so
that the same part gives the same file."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import BinaryIO
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray

Notes = Mapping[str, str]

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
RELATIONS = "http://schemas.openxmlformats.org/package/2006"
MICROSOFT = "http://schemas.microsoft.com/3dmanufacturing/2013/01"
OURS = "urn:porelang"
HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'
MODEL = "3D/3dmodel.model"
#: Decimal digits of a coordinate in a text.
DIGITS = 12
NUMBER = f"%.{DIGITS}g"
#: The faces of a box, whose corners are numbers with a bit for each axis.
_FACES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


@contextmanager
def package(
    file: BinaryIO,
    notes: Notes,
    build: int,
    extensions: Mapping[str, str] | None = None,
    required: Sequence[str] = (),
    pictures: Iterable[tuple[str, bytes]] = (),
) -> Iterator[BinaryIO]:
    """Where the resources of a model are written, of which the object `build` is built; with its notes as metadata
    `pore:NAME`, the namespaces of its extensions by prefix, those that are `required`, and its pictures (PNG) by name.
    """
    spaces = "".join(f' xmlns:{prefix}="{uri}"' for prefix, uri in (extensions or {}).items())
    needs = f' requiredextensions="{" ".join(required)}"' if required else ""
    metadata = "".join(
        f'<metadata name="pore:{_name(name)}" preserve="1" type="xs:string">{escape(printable(text))}</metadata>'
        for name, text in notes.items()
    )
    begin = (
        f'{HEAD}<model unit="millimeter" xml:lang="en-US" xmlns="{CORE}" xmlns:pore="{OURS}"{spaces}{needs}>'
        f'<metadata name="Application">porelang</metadata>{metadata}<resources>'
    )
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as made:
        shown = []
        for path, content in pictures:
            shown.append(path)
            made.writestr(_entry(path), content)
        made.writestr(_entry("[Content_Types].xml"), _types(bool(shown)))
        made.writestr(_entry("_rels/.rels"), _links([(MODEL, "3dmodel")]))
        if shown:
            made.writestr(_entry("3D/_rels/3dmodel.model.rels"), _links([(path, "3dtexture") for path in shown]))
        with made.open(_entry(MODEL), "w", force_zip64=True) as model:
            model.write(begin.encode())
            yield model  # type: ignore[misc]  # what a zip opens is written to as any file
            model.write(f'</resources><build><item objectid="{build}"/></build></model>\n'.encode())


def box_mesh(lo: Sequence[float], hi: Sequence[float]) -> str:
    """The mesh of a box, outward."""
    corners = [[float((lo, hi)[k >> axis & 1][axis]) for axis in range(3)] for k in range(8)]
    vertices = "".join(f'<vertex x="{x!r}" y="{y!r}" z="{z!r}"/>' for x, y, z in corners)
    halves = [(f[0], *f[i : i + 2]) for f in _FACES for i in (1, 2)]
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in halves)
    return f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>"


def grey(values: NDArray[np.uint16]) -> bytes:
    """A picture (rows, columns) of grey values in 16 bits, as PNG."""
    from io import BytesIO

    from PIL import Image

    made = BytesIO()
    Image.fromarray(np.ascontiguousarray(values)).save(made, "PNG")
    return made.getvalue()


def _types(pictures: bool) -> str:
    kinds = {
        "rels": "application/vnd.openxmlformats-package.relationships+xml",
        "model": "application/vnd.ms-package.3dmanufacturing-3dmodel+xml",
        **({"png": "image/png"} if pictures else {}),
    }
    listed = "".join(f'<Default Extension="{ending}" ContentType="{kind}"/>' for ending, kind in kinds.items())
    return f'{HEAD}<Types xmlns="{RELATIONS}/content-types">{listed}</Types>'


def _links(targets: Sequence[tuple[str, str]]) -> str:
    listed = "".join(
        f'<Relationship Target="/{path}" Id="{"model" if kind == "3dmodel" else f"r{k}"}" Type="{MICROSOFT}/{kind}"/>'
        for k, (path, kind) in enumerate(targets)
    )
    return f'{HEAD}<Relationships xmlns="{RELATIONS}/relationships">{listed}</Relationships>'


def _entry(path: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(path, (1980, 1, 1, 0, 0, 0))
    entry.compress_type = zipfile.ZIP_DEFLATED
    return entry


def _name(name: str) -> str:
    return re.sub(r"[^\w.-]", "_", name)


def printable(text: str) -> str:
    """The text without the control characters that XML cannot hold."""
    return "".join(c if c.isprintable() or c in "\t\n" else "\ufffd" for c in text)
