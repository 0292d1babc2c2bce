"""The triangles of a file of whatever format: corners in mm, those at one place being one."""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh

from porelang.data import FARTHEST
from porelang.tasks.shape.distance import DEFAULT
from porelang.tasks.shape.file import STEP, UnusableError, check_count, look_over, stl_length
from porelang.tasks.shape.mend import Faces, Points
from porelang.tasks.shape.threemf import triangles_of

METRE = 1000.0  # mm: glTF is in metres, by its standard, and what is made of .step files
#: How much of an error triangles in place of curved faces may take, and how much of that is asked for: those of a ball
#: are off by 1.7 times what Open CASCADE is asked for (cascadio 0.1.1).
CHORD, ASKED = 0.25, 0.5
_AGAIN = "export it again"


@dataclass(frozen=True, slots=True)
class Soup:
    """Corners (n, 3) in mm and triangles (m, 3), of all bodies of a file together.

    `unit` is what a length of 1 in the file is, in mm, 0 where nobody says; `chord` the share of the error that its
    triangles take, which stand for curved faces.
    """

    vertices: Points
    faces: Faces
    unit: float
    chord: float


def soup(file: io.BytesIO, ending: str, unit: float = np.nan, error: float = np.nan) -> Soup:
    """The triangles of a file. Its unit is what the format says where that is NaN. Errors: UnusableError.

    Curved faces become triangles that are off by CHORD of `error` at most, 1/128 of the longest side where that is NaN.
    """
    text = file.getvalue()
    claimed = look_over(file, len(text), ending)
    with _as_unusable(ending):
        vertices, faces, known = _read(text, ending, claimed, error)
    if faces.size == 0 or vertices.size == 0:
        raise UnusableError("E140", "holds no triangles", "export the part as a mesh of triangles")
    check_count(len(faces))
    if claimed is not None and len(faces) < claimed:
        raise UnusableError("E140", f"is damaged: it says that it holds {claimed:,} triangles, not {len(faces):,}",
                            _AGAIN)  # fmt: skip
    if faces.min() < 0 or faces.max() >= len(vertices):
        wrong = faces.min() if faces.min() < 0 else faces.max()
        raise UnusableError("E140", f"is damaged: a triangle names corner {wrong:,} of {len(vertices):,}", _AGAIN)
    known = unit if np.isfinite(unit) else known
    used = np.zeros(len(vertices), np.bool_)
    used[faces] = True
    here = vertices[used] * (known or 1.0)
    if bad := int((~np.isfinite(here)).any(axis=1).sum()):
        corners = "a corner that is" if bad == 1 else f"{bad:,} corners that are"
        raise UnusableError("E141", f"has {corners} no place: not a number, or infinite",
                            "export it again, or mend it where it was made")  # fmt: skip
    if (largest := float(np.abs(here).max())) > FARTHEST:
        raise UnusableError("E141", f"reaches {largest:g} mm from the origin; parts lie within {FARTHEST:,.0f} mm",
                            "check the unit of the file, as in `unit=1um`")  # fmt: skip
    places, numbers = merged(here)
    of_corner = np.zeros(len(vertices), np.int64)
    of_corner[used] = numbers
    faces = of_corner[faces]
    apart = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    if not apart.any():
        raise UnusableError("E140", "holds no triangles that have an area", _AGAIN)
    return Soup(places, np.ascontiguousarray(faces[apart]), known, CHORD if ending in STEP else 0.0)


@contextmanager
def _as_unusable(ending: str) -> Iterator[None]:
    """Readers of files that are damaged raise whatever they like."""
    try:
        yield
    except (MemoryError, UnusableError):
        raise
    except Exception as error:
        words = " ".join(str(error).split())[:120] or type(error).__name__
        raise UnusableError("E140", f"is damaged or no {ending} file: {words}", _AGAIN) from None


def _read(text: bytes, ending: str, claimed: int | None, error: float) -> tuple[Points, Faces, float]:
    """Corners, triangles, and the unit in mm that the format says, 0 where it says none."""
    if ending == ".3mf":
        return triangles_of(io.BytesIO(text))
    if ending == ".stl" and claimed is not None:
        text = text[: stl_length(claimed)]
    if ending == ".obj" and (wrong := re.search(rb"^f[ \t](?:.*[ \t])?0(?:[/ \t\r].*)?$", text, re.MULTILINE)):
        line = wrong[0].decode("latin-1").strip()[:60]
        raise UnusableError("E140", f"is damaged: `{line}` names corner 0, and the first of an .obj file is 1", _AGAIN)
    if ending == ".obj":
        text = _counted_from_one(text)
    mesh = _of_faces(text, error) if ending in STEP else _loaded(text, ending)
    unit = METRE if ending in (".glb", *STEP) else 0.0
    return np.array(mesh.vertices, np.float64), np.array(mesh.faces, np.int64), unit


def _counted_from_one(text: bytes) -> bytes:
    """An .obj file whose faces name no corner by how many lie between: -1 is the last that stands above the face, which
    readers take for the last of all (trimesh 4.5). Errors: UnusableError."""
    if not re.search(rb"^[ \t]*f[ \t].*-", text, re.MULTILINE):
        return text
    counts, lines = {b"v": 0, b"vt": 0, b"vn": 0}, []
    for line in re.sub(rb"\\\r?\n", b" ", text).splitlines():  # a line goes on after a backslash
        words = line.split()
        if words and words[0] in counts:
            counts[words[0]] += 1
        elif words and words[0] == b"f" and b"-" in line:
            line = b" ".join([b"f", *(_corner(word, counts.values(), line) for word in words[1:])])
        lines.append(line)
    return b"\n".join(lines)


def _corner(word: bytes, counts: Iterable[int], line: bytes) -> bytes:
    numbers = word.split(b"/")
    for k, (number, count) in enumerate(zip(numbers, counts, strict=False)):
        if number.startswith(b"-"):
            if not 0 < -int(number) <= count:
                said = line.decode("latin-1").strip()[:60]
                raise UnusableError("E140", f"is damaged: `{said}` names a corner before the first", _AGAIN)
            numbers[k] = str(count + 1 + int(number)).encode()
    return b"/".join(numbers)


def _loaded(text: bytes, ending: str, **how: Any) -> Any:
    return trimesh.load_scene(io.BytesIO(text), file_type=ending[1:], process=False, **how).to_mesh()


def _of_faces(text: bytes, error: float) -> Any:
    """Curved faces as triangles."""
    try:
        if not np.isfinite(error):
            rough = _loaded(text, ".step", tol_linear=1.0, tol_angular=1.0)
            error = METRE * float(np.ptp(rough.vertices, axis=0).max()) / DEFAULT
        return _loaded(text, ".step", tol_linear=ASKED * CHORD * error, tol_angular=0.5)
    except FileNotFoundError:  # which is how it tells of all that is wrong
        raise ValueError("Open CASCADE reads no part in it") from None


def merged(vertices: Points) -> tuple[Points, Faces]:
    """The places (m, 3) at which corners (n, 3) lie, and the place of each: those with the same numbers are one."""
    vertices = vertices + 0.0  # -0 is 0
    ordered = np.lexsort(vertices.T)
    other = np.ones(len(vertices), np.bool_)
    other[1:] = (vertices[ordered[1:]] != vertices[ordered[:-1]]).any(axis=1)
    numbers = np.empty(len(vertices), np.int64)
    numbers[ordered] = np.cumsum(other) - 1
    return np.ascontiguousarray(vertices[ordered[other]]), numbers
