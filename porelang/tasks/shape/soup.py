"""The triangles of a file of whatever format: corners in mm, those at one place being one."""

from __future__ import annotations

import io
import re

import numpy as np
import trimesh

from porelang.data import FARTHEST
from porelang.tasks.shape.file import UnusableError, check_count, look_over, stl_length
from porelang.tasks.shape.surface import Faces, Points

METRE = 1000.0  # mm: glTF is in metres, by its standard


def soup(file: io.BytesIO, ending: str, unit: float) -> tuple[Points, Faces]:
    """The corners (n, 3) in mm and triangles (m, 3) of a file, all of its bodies together. A length of 1 in it is
    `unit` mm, what its format says where that is NaN. Errors: UnusableError."""
    text = file.getvalue()
    claimed = look_over(file, len(text), ending)
    if ending == ".stl" and claimed is not None:
        text = text[: stl_length(claimed)]
    if ending == ".obj" and (wrong := re.search(rb"^f[ \t](?:.*[ \t])?0(?:[/ \t\r].*)?$", text, re.MULTILINE)):
        raise UnusableError("E140", f"is damaged: `{wrong[0].decode('latin-1').strip()[:60]}` names corner 0, and the "
                            "first of an .obj file is 1", "export it again")  # fmt: skip
    try:
        scene = trimesh.load_scene(io.BytesIO(text), file_type=ending[1:], process=False)
        mesh = scene.to_mesh()
        vertices, faces = np.array(mesh.vertices, np.float64), np.array(mesh.faces, np.int64)
    except MemoryError:
        raise
    except Exception as error:  # readers of files that are damaged raise whatever they like
        words = " ".join(str(error).split())[:120] or type(error).__name__
        raise UnusableError("E140", f"is damaged or no {ending} file: {words}", "export it again") from None
    if faces.size == 0 or vertices.size == 0:
        raise UnusableError("E140", "holds no triangles", "export the part as a mesh of triangles")
    check_count(len(faces))
    if claimed is not None and len(faces) < claimed:
        raise UnusableError("E140", f"is damaged: it says that it holds {claimed:,} triangles, not {len(faces):,}",
                            "export it again")  # fmt: skip
    if faces.min() < 0 or faces.max() >= len(vertices):
        wrong = faces.min() if faces.min() < 0 else faces.max()
        raise UnusableError("E140", f"is damaged: a triangle names corner {wrong:,} of {len(vertices):,}",
                            "export it again")  # fmt: skip
    vertices *= unit if np.isfinite(unit) else METRE if ending == ".glb" else 1.0
    used = np.zeros(len(vertices), np.bool_)
    used[faces] = True
    here = vertices[used]
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
        raise UnusableError("E140", "holds no triangles that have an area", "export it again")
    return places, np.ascontiguousarray(faces[apart])


def merged(vertices: Points) -> tuple[Points, Faces]:
    """The places (m, 3) at which corners (n, 3) lie, and the place of each: those with the same numbers are one."""
    vertices = vertices + 0.0  # -0 is 0
    ordered = np.lexsort(vertices.T)
    other = np.ones(len(vertices), np.bool_)
    other[1:] = (vertices[ordered[1:]] != vertices[ordered[:-1]]).any(axis=1)
    numbers = np.empty(len(vertices), np.int64)
    numbers[ordered] = np.cumsum(other) - 1
    return np.ascontiguousarray(vertices[ordered[other]]), numbers
