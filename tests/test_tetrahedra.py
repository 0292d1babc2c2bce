"""`pore tet` and `program.tet`: reports, files as other programs read them, fTetWild in its process, and what goes
wrong."""

from __future__ import annotations

import doctest
import itertools
import json
import math
import os
import pickle
import signal
import subprocess
import sys
from collections import defaultdict
from collections.abc import Callable
from concurrent.futures import CancelledError
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import trimesh

import porelang.program
from porelang.children import Running
from porelang.cli import main
from porelang.data import Reduced
from porelang.diagnostics import Diagnostic, PoreError, PoreWarning
from porelang.progress import watching
from porelang.solid import Solid
from porelang.tet import ftetwild as wild
from porelang.tet.described import described, distances
from porelang.tet.export import WRITERS, to_meshio, write
from porelang.tet.ftetwild import defects_of, ftetwild
from porelang.tet.patches import patches
from porelang.tet.tetmesh import TetMesh, volumes
from porelang.tetrahedra import tetrahedra
from porelang.tetrahedra.doubts import volume_doubts
from porelang.tetrahedra.fineness import Fineness, fineness

ROOT = Path(__file__).resolve().parent.parent
POSIX = pytest.mark.skipif(os.name != "posix", reason="signals and limits")
BALL = "sphere(10)\n"


def boxes(n: int = 2, phases: tuple[str, ...] = ("solid", "void 1"), edge: float = 3.0) -> TetMesh:
    """A cube of `edge` mm as n^3 cubes of six tetrahedra each (H. Kuhn), half of it of either phase: volumes and areas
    are those of boxes."""
    number = np.arange((n + 1) ** 3).reshape(n + 1, n + 1, n + 1)
    at = np.stack(np.meshgrid(*[np.linspace(0, edge, n + 1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    tets = []
    for way in itertools.permutations(range(3)):
        step = np.zeros(3, int)
        corners = []
        for axis in (None, *way):
            step[axis if axis is not None else 0] += axis is not None
            a, b, c = step
            corners.append(number[a : n + a, b : n + b, c : n + c].ravel())
        cells = np.stack(corners, axis=1)
        odd = sum(way[i] > way[j] for i in range(3) for j in range(i + 1, 3)) % 2
        tets.append(cells[:, [0, 2, 1, 3]] if odd else cells)
    cells = np.concatenate(tets).astype(np.int32)
    phase = (at[cells].mean(axis=1)[:, 0] > edge / 2) * (len(phases) - 1)
    return TetMesh(at + np.array([-1 / 7, -7.5, 1e-9 / 3]), cells, phase.astype(np.int8), phases)


def positive(points: Any, tets: Any) -> np.ndarray[Any, Any]:
    corners = np.asarray(points)[np.asarray(tets)]
    found: np.ndarray[Any, Any] = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6
    assert (found > 0).all()
    return found


def area(points: Any, triangles: Any) -> float:
    corners = np.asarray(points)[np.asarray(triangles)]
    return float(
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    )


def told(do: Callable[[], object]) -> Diagnostic:
    with pytest.raises(PoreError) as caught:
        do()
    (found,) = caught.value.diagnostics
    assert found.hint
    return found


# ---- surfaces


def test_surfaces_have_the_areas_of_the_boxes_and_turn_outward() -> None:
    mesh = boxes()
    assert volumes(mesh).sum() == pytest.approx(27)
    found = {patch.name: patch for patch in patches(mesh)}
    assert list(found) == ["solid_outside", "void_1_outside", "solid_void_1"]
    areas = {name: area(mesh.vertices, patch.triangles) for name, patch in found.items()}
    assert areas == pytest.approx({"solid_outside": 9 + 4 * 4.5, "void_1_outside": 9 + 4 * 4.5, "solid_void_1": 9})
    for patch in found.values():
        corners = mesh.vertices[patch.triangles]
        out = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        owner = mesh.vertices[mesh.tets[patch.owners]]
        assert (np.einsum("ij,ij->i", out, corners[:, 0] - owner.mean(axis=1)) > 0).all()
        apex = mesh.tets[patch.owners, patch.sides]
        assert not (patch.triangles == apex[:, None]).any()
    meet = mesh.vertices[found["solid_void_1"].triangles]
    assert np.allclose(meet[..., 0], 1.5 - 1 / 7)
    assert (mesh.phase[found["solid_void_1"].owners] == 0).all()


def test_report_of_boxes_is_that_of_boxes() -> None:
    found = described(boxes())
    assert found["tets"] == 48
    assert found["vertices"] == 27
    assert found["volume"] == pytest.approx(13.5)
    assert found["phases"]["void_1"] == {"tets": 24, "volume": pytest.approx(13.5), "components": 1}
    assert found["surfaces"]["solid_void_1"] == {"triangles": 8, "area": pytest.approx(9)}
    assert (found["min_dihedral"], found["max_dihedral"]) == pytest.approx((45, 90))  # Kuhn's simplex
    assert sum(found["dihedral_histogram"]["angles"]) == 6 * 48
    assert found["components"] == 1


def test_distance_is_how_far_the_field_says() -> None:
    mesh = boxes(1, ("solid",), 3.0)
    mesh = TetMesh(mesh.vertices - mesh.vertices.mean(axis=0), mesh.tets, mesh.phase)
    formula = porelang.compile("sphere(2)").design().of()
    found = distances(mesh, Solid(formula, ((-9, -9, -9), (9, 9, 9))))
    assert found["max"] == pytest.approx(1.5 * math.sqrt(3) - 2)  # a corner; the middles are nearer
    middle = math.sqrt(1.5**2 + 0.5**2 + 0.5**2)
    corner = 1.5 * math.sqrt(3)
    assert found["rms"] == pytest.approx(math.sqrt(((corner - 2) ** 2 + (middle - 2) ** 2) / 2))
    assert found["unknown"] == 0


# ---- files


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("files")
    notes = {"program": "a b.pore", "output": "part", "param.w": "30.0", "odd": "-- \u00e4\n<&"}
    return {ending: write(boxes(), folder / f"a b\u00f6{ending.upper()}", notes) for ending in WRITERS}


@pytest.mark.parametrize("ending", WRITERS)
def test_meshio_reads_back_what_was_written(ending: str, files: dict[str, Path]) -> None:
    mesh = boxes()
    kind = {".vtu": "vtu", ".msh": "gmsh", ".inp": "abaqus", ".nas": "nastran", ".mesh": "medit"}[ending]
    found = meshio.read(files[ending], file_format=kind)
    assert np.allclose(found.points, mesh.vertices, rtol=5e-10 if ending == ".nas" else 1e-15, atol=1e-22)
    cells = np.concatenate([block.data for block in found.cells if block.type == "tetra"])
    assert sorted(map(tuple, cells.tolist())) == sorted(map(tuple, mesh.tets.tolist()))  # corners in their order
    assert positive(found.points, cells).sum() == pytest.approx(27)


def test_vtu_says_the_phase_of_each_tetrahedron(files: dict[str, Path]) -> None:
    found = meshio.read(files[".vtu"], file_format="vtu")
    assert list(found.cell_data) == ["phase"]
    assert found.cell_data["phase"][0].tolist() == boxes().phase.tolist()
    text = files[".vtu"].read_text(encoding="ascii")
    assert "phase 1: void 1" in text
    assert "program: a b.pore" in text


def test_porelang_reads_its_own_vtu(files: dict[str, Path], tmp_path: Path) -> None:
    path = tmp_path / "part.vtu"
    path.write_bytes(files[".vtu"].read_bytes())
    program = porelang.compile(f'let f = load("{path}", "phase")\nout part = sphere(1)\nout f_ = f')
    values = program.field("f_")([[0.3, -6, 1.5], [2.6, -6, 1.5]])
    assert values.tolist() == pytest.approx([0, 1])


def test_msh_has_physical_groups(files: dict[str, Path]) -> None:
    """Read without meshio, as the format's manual has it: version 2.2, names, then each element with its two tags."""
    lines = files[".msh"].read_text(encoding="ascii").splitlines()
    assert lines[1] == "2.2 0 8"
    at = lines.index("$PhysicalNames")
    names = {}
    for line in lines[at + 2 : at + 2 + int(lines[at + 1])]:
        dimension, tag, name = line.split()
        names[name.strip('"')] = int(dimension), int(tag)
    assert {name: d for name, (d, _) in names.items()} == {
        "solid": 3, "void_1": 3, "solid_outside": 2, "void_1_outside": 2, "solid_void_1": 2,
    }  # fmt: skip
    assert len({tag for _, tag in names.values()}) == 5
    at = lines.index("$Nodes")
    points = np.array([[float(v) for v in line.split()[1:]] for line in lines[at + 2 : at + 2 + int(lines[at + 1])]])
    at = lines.index("$Elements")
    of: dict[int, list[list[int]]] = defaultdict(list)
    for line in lines[at + 2 : at + 2 + int(lines[at + 1])]:
        _, kind, tags, physical, _, *corners = map(int, line.split())
        assert (tags, len(corners)) == (2, {2: 3, 4: 4}[kind])
        of[physical].append([c - 1 for c in corners])
    assert positive(points, of[names["solid"][1]]).sum() == pytest.approx(13.5)
    assert positive(points, of[names["void_1"][1]]).sum() == pytest.approx(13.5)
    assert area(points, of[names["solid_void_1"][1]]) == pytest.approx(9)
    assert area(points, of[names["solid_outside"][1]]) == pytest.approx(27)


#: The corners of the faces of a tetrahedron as the manuals of Abaqus and CalculiX name them (C3D4), from 0.
ABAQUS = {"S1": (0, 1, 2), "S2": (0, 3, 1), "S3": (1, 3, 2), "S4": (2, 3, 0)}


def keywords(path: Path) -> list[tuple[str, dict[str, str], list[list[str]]]]:
    """A file of Abaqus' as CalculiX reads it: keywords, their parameters, and the data lines below each."""
    found: list[tuple[str, dict[str, str], list[list[str]]]] = []
    for line in path.read_text(encoding="ascii").splitlines():
        assert len(line) <= 256  # what Abaqus reads of a line
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            name, *params = [word.strip() for word in line[1:].split(",")]
            found.append((name.upper(), dict(p.upper().split("=", 1) for p in params), []))
            assert all(len(value) <= 80 for value in found[-1][1].values())
        else:
            found[-1][2].append([word.strip() for word in line.split(",")])
            assert len(found[-1][2][-1]) <= 16
    return found


def test_inp_has_sets_and_surfaces_that_abaqus_and_calculix_know(files: dict[str, Path]) -> None:
    found = keywords(files[".inp"])
    points, tets, sets, nodes, surfaces = {}, {}, {}, {}, {}
    for name, params, rows in found:
        if name == "NODE":
            points = {int(n): [float(v) for v in at] for n, *at in rows}
        elif name == "ELEMENT":
            assert params["TYPE"] == "C3D4"
            sets[params["ELSET"]] = [int(n) for n, *_ in rows]
            tets |= {int(n): [int(c) for c in corners] for n, *corners in rows}
        elif name == "NSET":
            nodes[params["NSET"]] = [int(n) for row in rows for n in row]
        elif name == "SURFACE":
            assert params["TYPE"] == "ELEMENT"
            surfaces[params["NAME"]] = [(int(n), side) for n, side in rows]
        else:
            assert name == "HEADING"
    assert sorted(tets) == list(range(1, 49))
    place = np.array([points[n] for n in range(1, len(points) + 1)])
    for name in ("SOLID", "VOID_1"):
        assert positive(place, np.array([tets[n] for n in sets[name]]) - 1).sum() == pytest.approx(13.5)
    assert set(surfaces) == set(nodes) == {"SOLID_OUTSIDE", "VOID_1_OUTSIDE", "SOLID_VOID_1"}
    for name, faces in surfaces.items():
        corners = np.array([[tets[n][c] for c in ABAQUS[side]] for n, side in faces]) - 1
        assert area(place, corners) == pytest.approx(9 if name == "SOLID_VOID_1" else 27)
        assert set(nodes[name]) == set((corners + 1).ravel().tolist())
    assert np.allclose(place[np.array(nodes["SOLID_VOID_1"]) - 1, 0], 1.5 - 1 / 7)


def test_nas_has_properties_in_fixed_fields(files: dict[str, Path]) -> None:
    text = files[".nas"].read_text(encoding="ascii")
    names = {line.split(": ")[1]: int(line.split()[2].strip(":")) for line in text.splitlines() if "$ PID" in line}
    bulk = text[text.index("BEGIN BULK") :].splitlines()
    place, cards = [], defaultdict(list)
    for first, second in itertools.pairwise(bulk):
        fields = [first[i : i + 8].strip() for i in range(0, len(first), 8)]
        if fields[0] == "GRID*":
            wide = [first[i : i + 16] for i in range(40, 72, 16)] + [second[8:24]]
            assert int(first[8:24]) == len(place) + 1
            place.append([float(v) for v in wide])
        elif fields[0] in ("CTETRA", "CTRIA3"):
            cards[int(fields[2])].append([int(n) - 1 for n in fields[3:] if n])
    assert bulk[-1] == "ENDDATA"
    assert positive(place, cards[names["solid"]]).sum() == pytest.approx(13.5)
    assert area(place, cards[names["solid_void_1"]]) == pytest.approx(9)
    assert area(place, cards[names["void_1_outside"]]) == pytest.approx(27)


def test_mesh_has_references(files: dict[str, Path]) -> None:
    words = files[".mesh"].read_text(encoding="ascii").split()
    assert words[:4] == ["MeshVersionFormatted", "2", "Dimension", "3"]

    def rows(name: str, width: int) -> np.ndarray[Any, Any]:
        at = words.index(name)
        count = int(words[at + 1])
        return np.array(words[at + 2 : at + 2 + count * width], float).reshape(count, width)

    place, triangles, tets = (
        rows("Vertices", 4)[:, :3],
        rows("Triangles", 4).astype(int),
        rows("Tetrahedra", 5).astype(int),
    )
    for reference in (1, 2):
        assert positive(place, tets[tets[:, 4] == reference, :4] - 1).sum() == pytest.approx(13.5)
    areas = [area(place, triangles[triangles[:, 3] == n, :3] - 1) for n in (3, 4, 5)]
    assert areas == pytest.approx([27, 27, 9])


def test_meshio_object_has_sets() -> None:
    found = to_meshio(boxes())
    assert [block.type for block in found.cells] == ["tetra", "triangle"]
    assert {name: [len(some) for some in sets] for name, sets in found.cell_sets.items()} == {
        "solid": [24, 0], "void_1": [24, 0],
        "solid_outside": [0, 24], "void_1_outside": [0, 24], "solid_void_1": [0, 8],
    }  # fmt: skip


@pytest.mark.parametrize(
    ("name", "says"),
    [("a.stl", "`pore mesh`"), ("a.vtuu", "did you mean .vtu"), ("a", "end the name"), ("a.unv", ".vtu .msh .inp")],
)
def test_other_endings_are_refused(name: str, says: str, tmp_path: Path) -> None:
    found = told(lambda: write(boxes(), tmp_path / name))
    assert found.code == "E112"
    assert says in found.hint
    assert not list(tmp_path.iterdir())


@POSIX
def test_a_disk_that_fills_leaves_what_was_there(tmp_path: Path) -> None:
    for ending in WRITERS:
        (tmp_path / f"a{ending}").write_bytes(b"old")
    code = """
import resource, signal, sys
sys.path.insert(0, sys.argv[2])
from test_tetrahedra import WRITERS, PoreError, boxes, write
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
mesh = boxes(4)
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
for ending in WRITERS:
    try:
        write(mesh, f"{sys.argv[1]}/a{ending}")
    except PoreError as error:
        print(ending, error.diagnostics[0].code)
"""
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path), str(Path(__file__).parent)], capture_output=True,
                          text=True, env={**os.environ, "PYTHONPATH": str(ROOT)}, check=False)  # fmt: skip
    assert done.stdout.splitlines() == [f"{ending} E113" for ending in WRITERS], done.stderr
    assert all(path.read_bytes() == b"old" for path in tmp_path.iterdir())
    assert len(os.listdir(tmp_path)) == len(WRITERS)


def test_an_interruption_leaves_what_was_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(mesh: TetMesh, path: Path, notes: Any) -> None:
        path.write_bytes(b"half")
        raise KeyboardInterrupt

    monkeypatch.setitem(WRITERS, ".msh", interrupted)
    path = tmp_path / "a.msh"
    path.write_bytes(b"old")
    with pytest.raises(KeyboardInterrupt):
        write(boxes(), path)
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["a.msh"]


# ---- fTetWild


def ball(subdivisions: int = 2, radius: float = 10.0) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    made = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return np.array(made.vertices, np.float64), np.array(made.faces, np.int32)


def test_ftetwild_fills_a_ball(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    vertices, faces = ball()
    seen: list[tuple[str, int, int]] = []
    with watching(lambda *what: seen.append(what)):
        mesh, facts = ftetwild(vertices, faces, 6.0)
    inside = trimesh.Trimesh(vertices, faces).volume
    assert volumes(mesh).min() > 0
    assert volumes(mesh).sum() == pytest.approx(inside, rel=0.02)
    assert facts["epsilon"] == pytest.approx(0.3)
    off = np.abs(np.linalg.norm(mesh.vertices[np.unique(patches(mesh)[0].triangles)], axis=1) - 10)
    assert off.max() < 10 - 10 * np.cos(np.radians(9.3)) + 0.3  # the facets' own sagitta, and epsilon
    assert trimesh.Trimesh(mesh.vertices, patches(mesh)[0].triangles, process=False).is_watertight
    assert facts["passes"] >= 1
    assert facts["max_energy"] <= 10
    assert {name for name, *_ in seen} == {wild.ACTIVITY}
    assert max(done for _, done, total in seen if total > 1) >= 3
    assert os.listdir(tmp_path) == []  # fTetWild leaves files where it works


BAD: dict[str, tuple[Callable[[Any, Any], tuple[Any, Any]], str]] = {
    "empty": (lambda v, f: (v, f[:0]), "no triangles"),
    "no_vertices": (lambda v, f: (v[:0], f), "no triangles"),
    "nan": (lambda v, f: (np.where(v == v.max(), np.nan, v), f), "not a number"),
    "infinite": (lambda v, f: (np.where(v == v.max(), np.inf, v), f), "not a number"),
    "index": (lambda v, f: (v, np.where(f == 0, 9999, f)), "does not exist"),
    "negative": (lambda v, f: (v, np.where(f == 0, -1, f)), "does not exist"),
    "open": (lambda v, f: (v, f[1:]), "open"),
    "turned": (lambda v, f: (v, np.vstack([f[:1, ::-1], f[1:]])), "open"),
    "inside_out": (lambda v, f: (v, f[:, ::-1]), "encloses -"),
    "flat": (lambda v, f: (v * [1, 1, 0], f), "encloses 0"),
    "zeros": (lambda v, f: (v * 0, f), "encloses 0"),
    "repeated": (lambda v, f: (v, np.vstack([f, [[0, 0, 1]]])), "twice"),
    "shape": (lambda v, f: (v[:, :2], f), "three numbers"),
    "texts": (lambda v, f: (v.astype(str), f), "not a number"),
}


@pytest.mark.parametrize("what", BAD)
def test_ftetwild_is_given_no_surface_that_harms_it(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wild, "_made", None)
    damage, says = BAD[what]
    vertices, faces = damage(*ball(1))
    found = told(lambda: ftetwild(vertices, faces, 5.0))
    assert found.code == "E165"
    assert says in found.message


@pytest.mark.parametrize(
    "wish",
    [{"size": s} for s in (0, -1.0, math.nan, math.inf, True, "1mm", None, 0.02)]
    + [{"epsilon": e} for e in (0, -1e-3, math.nan)] + [{"time_limit": t} for t in (0, -1, math.nan)],
)  # fmt: skip
def test_ftetwild_is_asked_nothing_that_harms_it(wish: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wild, "_made", None)
    found = told(lambda: ftetwild(*ball(1), **{"size": 5.0, **wish}))
    assert found.code == "E165"


def test_a_sound_surface_has_no_defects() -> None:
    vertices, faces = ball(1)
    assert defects_of(vertices, faces) == ""
    two = np.vstack([vertices, vertices + 30]), np.vstack([faces, faces + len(vertices)])
    assert defects_of(*two) == ""


@POSIX
def test_a_crash_of_ftetwild_is_told() -> None:
    """A real one: pytetwild 0.4.2 ends with a signal where there are no faces. A later one may refuse it in words."""
    wish = wild.Wish(5.0, 0.25, 60.0)
    found = told(lambda: wild._made(ball(1)[0], np.zeros((0, 3), np.int32), wish, {}))
    assert found.code == "E164"


@POSIX
@pytest.mark.parametrize(
    ("how", "says"), [(signal.SIGSEGV, "crashed (SIGSEGV)"), (signal.SIGKILL, "not enough memory")]
)
def test_death_of_the_process_is_told(how: signal.Signals, says: str, monkeypatch: pytest.MonkeyPatch) -> None:
    ended = wild.ended

    def killed(child: Running, *more: Any) -> int:
        os.kill(child.pid, how)
        return ended(child, *more)

    monkeypatch.setattr(wild, "ended", killed)
    found = told(lambda: ftetwild(*ball(1), 5.0))
    assert found.code == "E164"
    assert says in found.message


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[Running]:
    """The processes that were started for fTetWild."""
    found: list[Running] = []
    ended = wild.ended
    monkeypatch.setattr(wild, "ended", lambda child, *more: (found.append(child), ended(child, *more))[1])
    return found


@POSIX
def test_a_time_limit_ends_it(started: list[Running]) -> None:
    found = told(lambda: ftetwild(*ball(4), 0.5, time_limit=0.5))
    assert found.code == "E164"
    assert "stopped after 0.5 s" in found.message
    assert started[0].returncode == -signal.SIGKILL


@POSIX
def test_cancelling_ends_it(started: list[Running]) -> None:
    reports: list[int] = []
    with watching(lambda *_: reports.append(1), lambda: len(reports) > 3), pytest.raises(CancelledError):
        ftetwild(*ball(4), 0.5)
    assert started[0].returncode == -signal.SIGKILL


@POSIX
def test_the_process_ends_with_the_one_that_started_it(tmp_path: Path) -> None:
    """Also in the middle of native code, which holds Python's lock."""
    vertices, faces = ball(5)
    with open(tmp_path / "in.npz", "wb") as file:
        np.savez(file, vertices=vertices, faces=faces)
    with open(tmp_path / "in.npz", "rb") as source, open(tmp_path / "out.npz", "wb") as target:
        both = source.fileno(), target.fileno()
        words = ["-P", "-m", "porelang.tet.wildchild", "0.2", "0.001", "3", "80", "1", *map(str, both)]
        child = subprocess.Popen([sys.executable, *words], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                 pass_fds=both, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)})  # fmt: skip
        with child:
            assert child.stdout is not None
            assert child.stdin is not None
            try:
                assert child.stdout.readline()  # fTetWild has begun, and says so
                child.stdin.close()
                assert child.wait(timeout=20) == -signal.SIGIO
            finally:
                child.kill()
    assert (tmp_path / "out.npz").read_bytes() == b""


def test_without_pytetwild_it_is_said_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(wild, "find_spec", lambda name: None)
    (tmp_path / "a.pore").write_text(BALL)
    monkeypatch.chdir(tmp_path)
    assert main(["tet", "a.pore", "-o", "a.vtu", "--mesher", "ftetwild"]) == 3
    said = capsys.readouterr().err
    assert "E163" in said
    assert "pip install 'porelang[ftetwild]'" in said
    assert os.listdir(tmp_path) == ["a.pore"]


def test_a_surface_that_is_too_coarse_is_told_in_words_of_tetrahedra() -> None:
    program = porelang.compile("gyroid(20) |> shell(1.53) & cylinder(15, 30)")
    found = told(lambda: program.tet(size="4mm", surface_size="6mm", mesher="ftetwild"))
    assert found.code == "E118"
    assert "--surface-size 0." in found.hint
    assert "--voxel" not in found.hint


@pytest.mark.slow
def test_a_part_by_ftetwild(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a.pore").write_text("box([10, 10, 10])\n")
    monkeypatch.chdir(tmp_path)
    words = [
        "tet",
        "a.pore",
        "-o",
        "a.vtu",
        "--mesher",
        "ftetwild",
        "--size",
        "5mm",
        "--surface-size",
        "2.5mm",
        "--json",
    ]
    assert main(words) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["mesher"] == "ftetwild"
    assert found["surface_voxel"] == 2.5
    assert found["warnings"] == []
    assert found["volume"] == pytest.approx(1000, rel=2e-3)
    assert found["distance"]["max"] <= found["epsilon"] * 1.01
    assert sorted(os.listdir(tmp_path)) == ["a.pore", "a.vtu"]


# ---- the command and the door


@pytest.fixture
def work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "a.pore").write_text(BALL)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_report_as_json(work: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tet", "a.pore", "-o", "a b.vtu", "--size", "2mm", "--json", "-q"]) == 0
    out = capsys.readouterr()
    found = json.loads(out.out)
    assert out.err == ""
    keys = "tets vertices volume min_dihedral max_dihedral components dropped_volume_fraction seconds"
    assert set(keys.split()) <= set(found)
    read = meshio.read(work / "a b.vtu")
    assert (len(read.cells[0].data), len(read.points)) == (found["tets"], found["vertices"])
    assert positive(read.points, read.cells[0].data).sum() == pytest.approx(found["volume"])
    exact = 4 / 3 * math.pi * 1000
    assert abs(found["field_volume"] - exact) <= found["field_volume_error"]
    assert found["volume_error"] == pytest.approx(found["volume"] / found["field_volume"] - 1)
    assert abs(found["volume_error"]) < 0.003  # curved walls keep their volume
    radii = np.linalg.norm(read.points, axis=1)
    assert radii.max() <= 10 + found["distance"]["max"] + 1e-6
    assert found["components"] == 1
    assert found["dropped_volume_fraction"] == 0
    assert found["wall"] == pytest.approx(20, rel=0.01)
    assert (found["warnings"], found["notes"]) == ([], [])


def test_report_as_text(work: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tet", "a.pore", "-o", "a.inp", "--size", "3mm"]) == 0
    out = capsys.readouterr().out.splitlines()
    assert out[0] == "a.inp"
    for name in ("tetrahedra", "size", "volume", "surface", "angles", "pieces", "time"):
        assert [line for line in out if line.startswith(f"  {name} ")], name
    shares = [float(line.split()[1].strip("%")) for line in out if "%" in line and line.split()[0][:1].isdigit()]
    assert sum(shares) == pytest.approx(100, abs=0.1)
    assert main(["tet", "a.pore", "-o", "a.inp", "--size", "3mm", "-q"]) == 0
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("words", "says", "status"),
    [
        ("-o a.stl", "`pore mesh` writes it", 2),
        ("-o a", "end the name", 2),
        ("-o nowhere/a.vtu", "mkdir", 2),
        ("-o a.pore", "no format", 2),
        ("--size 1mm", "needs --output", 2),
        ("-o a.vtu --size 0", "above 0", 2),
        ("-o a.vtu --size -3mm", "above 0", 2),
        ("-o a.vtu --size 3kg", "no length", 2),
        ("-o a.vtu --size nowhere", "no number called `nowhere`", 2),
        ("-o a.vtu --mesher tetgen", "direct, ftetwild", 2),
        ("-o a.vtu --phases solid,gas", "solid,void", 2),
        ("-o a.vtu --phases void", "come with those of the solid", 2),
        ("-o a.vtu --phases solid,void --mesher ftetwild", "leave --mesher out", 2),
        ("-o a.vtu --time-limit 5min", "ftetwild", 2),
        ("-o a.vtu --mesher ftetwild --time-limit soon", "5min", 2),
        ("-o a.vtu --mesher ftetwild --size part", "one size", 2),
        ("-o a.vtu --elements 7", "has no option", 2),
        ("-o a.vtu --size 1mm --size 2mm", "given twice", 2),
        ("-o a.vtu --out q", "no output `q`", 2),
    ],
)
def test_what_cannot_be_is_refused_in_words(
    words: str, says: str, status: int, work: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["tet", "a.pore", *words.split()]) == status
    said = capsys.readouterr()
    assert says in said.err
    assert "hint" in said.err
    assert said.out == ""
    assert os.listdir(work) == ["a.pore"]


@pytest.mark.parametrize(
    ("more", "code"),
    [
        ({"size": 0}, "E114"), ({"size": math.nan}, "E114"), ({"size": True}, "E114"), ({"size": [1]}, "E114"),
        ({"surface_size": -1}, "E114"), ({"mesher": "gmsh"}, "E108"), ({"phases": "gas"}, "E108"),
        ({"phases": ("void",)}, "E108"), ({"size": "thick"}, "E100"), ({"bounds": (0, 0, 0, 1, 1)}, "E107"),
        ({"time_limit": "soon", "mesher": "ftetwild"}, "E108"), ({"time_limit": -1}, "E114"),
        ({"time_limit": 5}, "E108"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_in_python(more: dict[str, Any], code: str) -> None:
    assert told(lambda: porelang.compile(BALL).tet(**more)).code == code


def test_the_door_gives_arrays_surfaces_and_files(tmp_path: Path) -> None:
    program = porelang.compile("param r = 10mm in 5mm..20mm\nsphere(r)")
    found = program.tet(size="3mm", r="8mm")
    assert found.vertices.shape[1] == 3
    assert found.tets.shape == (len(found.tets), 4)
    assert found.phases == ("solid",)
    assert not found.phase.any()
    assert positive(found.vertices, found.tets).sum() == pytest.approx(found.report["volume"])
    (surface,) = found.surfaces().values()
    assert surface.is_watertight
    assert surface.volume == pytest.approx(found.report["volume"])
    assert found.write(tmp_path / "a.inp").name == "a.inp"
    assert "param.r: 8.0" in (tmp_path / "a.inp").read_text()
    assert f"{len(found.tets):,} tetrahedra of solid" in repr(found)
    assert "min_dihedral" in found._repr_html_()
    assert np.array_equal(pickle.loads(pickle.dumps(found)).tets, found.tets)
    assert len(found.to_meshio().cells[0].data) == len(found.tets)


def test_the_example_of_the_door_runs() -> None:
    (example,) = doctest.DocTestFinder().find(porelang.program.Program.tet, "tet", globs={})
    assert doctest.DocTestRunner().run(example).failed == 0
    assert len(example.examples) >= 4


def test_a_check_that_fails_refuses_tetrahedra(work: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (work / "a.pore").write_text('param r = 5mm in 1mm..9mm\ncheck r > 6mm, "too small"\nsphere(r)\n')
    assert main(["tet", "a.pore", "-o", "a.vtu"]) == 1
    assert "too small" in capsys.readouterr().err
    assert os.listdir(work) == ["a.pore"]
    program = porelang.compile(path="a.pore")
    with pytest.raises(PoreError, match="E068"):
        program.tet(size=2)
    assert program.tet(size=2, check=False).report["components"] == 1


def test_the_program_is_not_written_over(work: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (work / "b.vtu").symlink_to("a.pore")
    assert main(["tet", "a.pore", "-o", "b.vtu"]) == 2
    assert "which is read for it" in capsys.readouterr().err
    assert (work / "a.pore").read_text() == BALL


# ---- how fine, and what is doubtful


def fine(text: str, size: Any = None, mesher: str = "direct") -> Fineness:
    design = porelang.compile(text).design()
    return fineness(design, Solid(design.of(), design.bounds()), size, mesher)


def test_three_tetrahedra_lie_across_the_thinnest_wall() -> None:
    found = fine("box([40, 40, 3])")
    assert found.size == pytest.approx(1, rel=0.01)
    assert "the thinnest walls are about 3 mm" in found.told()


def test_a_thick_part_has_twenty_along_its_side() -> None:
    found = fine("sphere(10)")
    assert found.size == pytest.approx(1, rel=0.01)
    assert "1/20 of the longest side" in found.told()


def test_a_size_that_nobody_can_afford_is_not_chosen() -> None:
    found = fine("box([400, 400, 3])")
    assert isinstance(found.size, float)
    assert found.wanted == pytest.approx(1, rel=0.02)
    assert found.size == pytest.approx((400 * 400 * 3 * 12 / 1e6) ** (1 / 3), rel=0.2)
    assert "coarse" in found.told()
    assert "--size 0.9" in found.told() or "--size 1" in found.told()
    wild_one = fine("box([400, 400, 3])", mesher="ftetwild")
    assert isinstance(wild_one.size, float)
    assert wild_one.size > 2 * found.size


def test_a_field_may_say_the_size() -> None:
    coarse = porelang.compile("let h = 1.5mm\nsphere(10)").tet(size="h").report["tets"]
    graded = porelang.compile("let h = if x < 0 then 1.5mm else 6mm\nsphere(10)").tet(size="h")
    right = graded.vertices[graded.tets].mean(axis=1)[:, 0] > 0
    assert right.sum() < 0.5 * (~right).sum()
    assert graded.report["tets"] < coarse


def test_both_phases_fill_the_box_and_share_their_triangles(work: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Two voids that do not meet, either side of a wall: each has a name, and volumes are those of boxes."""
    (work / "a.pore").write_text("box([20, 20, 4])\n")
    words = ["--bounds=-10,-10,-5,10,10,7", "--phases", "void,solid", "--size", "2mm", "--json", "-q"]
    assert main(["tet", "a.pore", "-o", "a.msh", *words]) == 0
    found = json.loads(capsys.readouterr().out)
    held = {name: phase["volume"] for name, phase in found["phases"].items()}
    assert held == pytest.approx({"solid": 1600, "void_1": 2000, "void_2": 1200}, rel=1e-3)
    assert found["volume"] == pytest.approx(1600, rel=1e-3)
    areas = {name: patch["area"] for name, patch in found["surfaces"].items()}
    assert areas == pytest.approx(
        {"solid_outside": 320, "void_1_outside": 800, "void_2_outside": 640, "solid_void_1": 400, "solid_void_2": 400},
        rel=1e-3,
    )
    read = meshio.read(work / "a.msh")
    names = {int(tag): name for name, (tag, d) in read.field_data.items() if d == 3}
    cells = np.concatenate([block.data for block in read.cells if block.type == "tetra"])
    tags = np.concatenate(
        [tag for block, tag in zip(read.cells, read.cell_data["gmsh:physical"], strict=True) if block.type == "tetra"]
    )
    for tag, name in names.items():
        assert positive(read.points, cells[tags == tag]).sum() == pytest.approx(held[name])
    faces = np.sort(np.concatenate([cells[:, list(f)] for f in itertools.combinations(range(4), 3)]), axis=1)
    assert np.unique(faces, axis=0, return_counts=True)[1].max() == 2
    solid, void = (np.unique(cells[tags == tag]) for tag in sorted(names)[:2])
    on = read.points[np.intersect1d(solid, void)]
    assert np.allclose(on[:, 2], 2, atol=1e-6)


def test_two_bodies_are_not_halved_without_a_word() -> None:
    text = "translate(sphere(5), [-8, 0, 0]) | translate(sphere(4.9), [8, 0, 0])"
    found = told(lambda: porelang.compile(text).tet(size=1.5))
    assert (found.code, "--keep-islands" in found.hint) == ("E118", True)
    assert "keep them, keep_islands=True" in str(PoreError(found))
    with pytest.warns(PoreWarning, match="W251"):
        both = porelang.compile(text).tet(size=1.5, keep_islands=True)
    assert both.report["components"] == 2
    assert both.report["dropped_volume_fraction"] == 0
    with pytest.warns(PoreWarning, match="W251"):
        one = porelang.compile(text).tet(size=1.5, force=True)
    assert one.report["components"] == 1
    assert one.report["dropped_volume_fraction"] == pytest.approx(4.9**3 / (5**3 + 4.9**3), abs=0.01)


def test_another_volume_is_doubtful_and_then_useless() -> None:
    size = Fineness(2.0, 1.0, None, False)
    true = Reduced(1000.0, 5.0)
    assert volume_doubts(975.0, true, size, False, None) == []
    (found,) = volume_doubts(940.0, true, size, False, None)
    assert (found.code, "6.0% less" in found.message) == ("W202", True)
    assert found.hint == "give a smaller --size, 1mm"  # what three across the walls take, as the report says
    (found,) = volume_doubts(940.0, true, size, False, None, 20.0)
    assert "6.0% less, 20 mm3 of it in islands" in found.message
    assert told(lambda: volume_doubts(700.0, true, size, False, None)).code == "E118"
    assert volume_doubts(700.0, true, size, True, None)[0].code == "W202"


def test_bounds_cut_the_part_flat() -> None:
    found = tetrahedra(porelang.compile(BALL).design(), size=1.5, bounds=(0, -10, -10, 10, 10, 10))
    assert found.report["volume"] == pytest.approx(2 / 3 * math.pi * 1000, rel=0.02)
    assert found.vertices[:, 0].min() >= -1e-9
    flat = found.surfaces()["solid_outside"]
    cap = np.abs(flat.triangles_center[:, 0]) < 1e-6
    assert flat.area_faces[cap].sum() == pytest.approx(math.pi * 100, rel=0.02)
    assert found.report["distance"]["max"] < 0.3
