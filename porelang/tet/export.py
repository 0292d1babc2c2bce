"""Tetrahedra to files: `.vtu .msh .inp .nas .mesh` by ending, written whole or not at all, in mm.

What is named in them: the phases, and the surfaces of `patches`. meshio writes all but `.inp`: of Abaqus' surfaces it
knows nothing, and would make rigid elements (R3D3) of triangles. Gmsh's version is 2.2 in text, for that is the one
which Gmsh, FEniCS, MFEM, OpenFOAM and Elmer all read.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np
from numpy.typing import NDArray

from porelang.atomic import replace_path
from porelang.diagnostics import fail, suggest
from porelang.tet.patches import Patch, patches, set_name
from porelang.tet.tetmesh import TetMesh

if TYPE_CHECKING:
    import meshio

#: Texts by name (params, the hash of the program) for formats that have comments.
Notes = Mapping[str, str]
Writer = Callable[[TetMesh, Path, Notes], None]
#: What Abaqus calls the faces opposite the four corners.
_SIDES = np.array([3, 4, 2, 1])
_AT_ONCE = 1 << 14  # lines that are written together
_IN_A_LINE = 16  # members of a set, at most


def write(mesh: TetMesh, path: str | Path, notes: Notes | None = None) -> Path:
    """Write tetrahedra (mm) in the format that the path's ending names, and give the path.

    Errors: E112 where the ending is not known, E113 where the file cannot be written there; nothing is left then.
    """
    path = Path(path)
    writer = writer_of(path)
    with replace_path(path) as draft:
        writer(mesh, draft, notes or {})
    return path


def writer_of(path: str | Path) -> Writer:
    """The writer for a path's ending; E112 if there is none."""
    ending = Path(path).suffix.lower()
    if ending in WRITERS:
        return WRITERS[ending]
    near = suggest(ending, WRITERS) if ending else None
    names = " ".join(WRITERS)
    what = f"no format for tetrahedra is called {ending}" if ending else "the name has no ending"
    hint = f"did you mean {near}? The formats are {names}" if near else f"end the name with one of {names}"
    if ending in (".stl", ".obj", ".ply", ".3mf", ".glb", ".vtp"):
        hint = f"that is a format for surfaces: `pore mesh` writes it; the formats of tetrahedra are {names}"
    raise fail("E112", f"{Path(path).name}: {what}", hint=hint)


def to_meshio(mesh: TetMesh) -> meshio.Mesh:
    """The mesh as a `meshio.Mesh`: its tetrahedra with their `phase`, then the triangles of its surfaces with the phase
    that they bound; phases and surfaces are `cell_sets`."""
    import meshio

    found = patches(mesh)
    triangles = np.concatenate([patch.triangles for patch in found])
    owners = np.concatenate([patch.owners for patch in found])
    none = np.zeros(0, np.int64)
    sets = {set_name(name): [np.flatnonzero(mesh.phase == i), none] for i, name in enumerate(mesh.phases)}
    at = 0
    for patch in found:
        sets[patch.name] = [none, np.arange(at, at := at + len(patch.triangles))]
    phase = mesh.phase.astype(np.int32)
    return meshio.Mesh(
        mesh.vertices,
        [("tetra", mesh.tets), ("triangle", triangles)],
        cell_data={"phase": [phase, phase[owners]]},
        cell_sets=sets,
    )


def tags(mesh: TetMesh, found: list[Patch]) -> tuple[dict[str, int], dict[str, int]]:
    """The numbers of phases, from 1, and of surfaces, which go on counting, by their names in files."""
    phases = {set_name(name): i for i, name in enumerate(mesh.phases, 1)}
    return phases, {patch.name: i for i, patch in enumerate(found, len(phases) + 1)}


def _tagged(mesh: TetMesh, **names: str) -> Any:
    """The triangles, then the tetrahedra, with the numbers of what they belong to under some names."""
    import meshio

    found = patches(mesh)
    phases, surfaces = tags(mesh, found)
    triangles = np.concatenate([patch.triangles for patch in found])
    numbers = np.concatenate([np.full(len(patch.triangles), surfaces[patch.name], np.int32) for patch in found])
    data = {name: [numbers, mesh.phase.astype(np.int32) + 1] for name in names.values()}
    groups = {name: np.array([number, 3]) for name, number in phases.items()}
    groups |= {name: np.array([number, 2]) for name, number in surfaces.items()}
    return meshio.Mesh(
        mesh.vertices, [("triangle", triangles), ("tetra", mesh.tets)], cell_data=data, field_data=groups
    )


def _vtu(mesh: TetMesh, path: Path, notes: Notes) -> None:
    """Notes and the names of phases stand in a comment at the end: texts as field data are more than meshio reads."""
    import meshio

    phase = mesh.phase.astype(np.int32)
    meshio.Mesh(mesh.vertices, [("tetra", mesh.tets)], cell_data={"phase": [phase]}).write(path, file_format="vtu")
    told = [*_comments(notes), *(f"phase {i}: {name}" for i, name in enumerate(mesh.phases))]
    with open(path, "a", encoding="ascii") as file:
        file.write(f"<!--\n{chr(10).join(told).replace('--', '- -')}\n-->\n")


def _msh(mesh: TetMesh, path: Path, notes: Notes) -> None:
    made = _tagged(mesh, physical="gmsh:physical", geometrical="gmsh:geometrical")
    made.write(path, file_format="gmsh22", binary=False)


def _nas(mesh: TetMesh, path: Path, notes: Notes) -> None:
    made = _tagged(mesh, reference="nastran:ref")
    made.points = _rounded(mesh.vertices)
    with open(path, "x", encoding="ascii") as file:
        for line in _comments(notes):
            file.write(f"$ {line}\n")
        file.writelines(f"$ PID {number}: {name}\n" for name, (number, _) in made.field_data.items())
        made.write(file, file_format="nastran")


def _rounded(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Places with ten digits: with a sign and an exponent these fill the 16 columns of Nastran's wide fields. What does
    not fit fails an assertion of meshio (5.3)."""
    with np.errstate(divide="ignore"):
        power = np.where(places == 0, 0.0, 9 - np.floor(np.log10(np.abs(places))))
    scale = 10.0 ** np.minimum(power, 22)  # exact up to there; what is smaller is nothing
    return np.asarray(np.rint(places * scale) / scale)


def _medit(mesh: TetMesh, path: Path, notes: Notes) -> None:
    _tagged(mesh, reference="medit:ref").write(path, file_format="medit")


def _inp(mesh: TetMesh, path: Path, notes: Notes) -> None:
    """Abaqus' keywords that CalculiX knows too. Elements are numbered from 1, phase by phase."""
    number = np.empty(len(mesh.tets), np.int64)
    order = np.argsort(mesh.phase, kind="stable")
    number[order] = np.arange(1, len(order) + 1)
    with open(path, "x", encoding="ascii") as file:
        file.write("*HEADING\nTetrahedra by porelang, in mm\n")
        file.writelines(f"** {line}\n" for line in _comments(notes))
        file.write("*NODE, NSET=all_nodes\n")
        _rows(file, "%d, %.16g, %.16g, %.16g\n", np.arange(1, len(mesh.vertices) + 1), *mesh.vertices.T)
        for i, name in enumerate(mesh.phases):
            members = order[mesh.phase[order] == i]
            if len(members):
                file.write(f"*ELEMENT, TYPE=C3D4, ELSET={set_name(name)}\n")
                _rows(file, "%d, %d, %d, %d, %d\n", number[members], *(mesh.tets[members].T.astype(np.int64) + 1))
        for patch in patches(mesh):
            file.write(f"*NSET, NSET={patch.name}\n")
            file.writelines(_members(np.unique(patch.triangles).astype(np.int64) + 1))
            file.write(f"*SURFACE, NAME={patch.name}, TYPE=ELEMENT\n")
            _rows(file, "%d, S%d\n", number[patch.owners], _SIDES[patch.sides])


def _members(numbers: NDArray[np.int64]) -> Iterator[str]:
    texts = [str(n) for n in numbers.tolist()]
    return (f"{', '.join(texts[i : i + _IN_A_LINE])}\n" for i in range(0, len(texts), _IN_A_LINE))


def _rows(file: TextIO, form: str, *columns: NDArray[Any]) -> None:
    """A line for each row of some columns, many at once."""
    for i in range(0, len(columns[0]), _AT_ONCE):
        some = [column[i : i + _AT_ONCE].tolist() for column in columns]
        file.write(form * len(some[0]) % tuple(chain.from_iterable(zip(*some, strict=True))))


def _comments(notes: Notes) -> list[str]:
    """Notes as lines of ASCII, without line breaks of their own."""
    return ["mm", *(f"{name}: {text}".encode("unicode_escape").decode("ascii") for name, text in notes.items())]


WRITERS: dict[str, Writer] = {".vtu": _vtu, ".msh": _msh, ".inp": _inp, ".nas": _nas, ".mesh": _medit}
