"""Meshes as shapes: distances against closed forms, the sign of meshes with holes, and files that are no meshes."""

from __future__ import annotations

import dataclasses
import os
import re
import runpy
import signal
import subprocess
import sys
import zipfile
from collections.abc import Callable
from concurrent.futures import CancelledError
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from refused import refused

import porelang
from porelang import store
from porelang.children import Running
from porelang.cli import main
from porelang.data import SampledField
from porelang.diagnostics import Diagnostic, PoreError
from porelang.ir import order
from porelang.ops.grid import lookup
from porelang.progress import watching
from porelang.source import Source, Span
from porelang.tasks import datafile, shape
from porelang.tasks.shape import Found, ask, child, file, read_shape
from porelang.tasks.shape.found import told_of

SPAN = Span(Source("part.pore", 'mesh("part.stl")'), 0, 16)
BOX = np.array([4.0, 6.0, 10.0])  # half its sides, in mm
Some = np.ndarray[Any, np.dtype[np.float64]]


@pytest.fixture
def kept() -> None:
    """For a test that may find what others of the suite have measured."""


@pytest.fixture(autouse=True)
def _afresh(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each other test measures for itself: nothing is found that another one has kept."""
    forget()
    if "kept" not in request.fixturenames:
        monkeypatch.setattr(store, "_folder", lambda: None)


@pytest.fixture
def apart() -> None:
    """For tests of the process that measures; it takes a second to start."""


@pytest.fixture(autouse=True)
def _here(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """The others have the same measured in this one, from and to the same files."""
    if "apart" not in request.fixturenames:

        def measured(asked: Any, source: int, target: int, words: object) -> int:
            child.main(asked.ending, asked.error, asked.margin, asked.unit, os.dup(source), os.dup(target))
            return 0

        monkeypatch.setattr(ask, "_measured", measured)
        monkeypatch.setattr(child, "told", lambda done, total: None)


def forget() -> None:
    datafile.forget()
    store.forget()


def saved(mesh: trimesh.Trimesh, path: Path) -> str:
    mesh.export(path)
    return str(path)


def box(scale: float = 1.0) -> trimesh.Trimesh:
    return trimesh.creation.box(2 * scale * BOX)


def to_box(p: Some, half: Some = BOX) -> Some:
    """The signed distance to a box about the origin, in closed form."""
    q = np.abs(p) - half
    outside = np.linalg.norm(np.maximum(q, 0), axis=-1)
    return np.asarray(outside + np.minimum(q.max(axis=-1), 0))


def nodes(field: SampledField) -> Some:
    axes = [o + h * np.arange(n) for o, h, n in zip(field.origin, field.spacing, field.shape, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


def within(field: SampledField, count: int = 20_000) -> Some:
    """Points of its grid."""
    return np.random.default_rng(3).uniform(field.origin, field.end, (count, 3))


def at(field: SampledField, p: Some) -> Some:
    return np.asarray(lookup(field, *p.T, (0, 0, 0, 0)), np.float64)


def told(read: Callable[[], object]) -> Diagnostic:
    return refused(read, SPAN)


@pytest.mark.parametrize("ending", [".stl", ".obj", ".ply", ".off", ".glb"])
def test_box_of_every_format(ending: str, tmp_path: Path) -> None:
    mesh = box(1e-3 if ending == ".glb" else 1.0)  # glTF is in metres
    field = read_shape(saved(mesh, tmp_path / f"box{ending}"), error=0.4)
    known, found = to_box(nodes(field)), field.values[..., 0]
    near = np.abs(known) <= 3 * field.spacing[0]
    assert np.abs(found - known)[near].max() < 1e-5
    assert ((found < 0) == (known < 0))[np.abs(known) > 1e-5].all()
    facts = Found.of(field)
    assert (facts.triangles, facts.open_edges, facts.holes, facts.error) == (12, 0, 0, 0.4)
    np.testing.assert_allclose([facts.low, facts.high], [-BOX, BOX], atol=1e-6)
    assert np.abs(found - known).max() <= max(2 * facts.error_beyond, 1e-5)
    p = within(field)
    assert np.abs(at(field, p) - to_box(p)).max() <= 0.4 + facts.error_beyond


def test_stated_error_holds_near_the_surface(tmp_path: Path) -> None:
    for error in (0.8, 0.2):
        field = read_shape(saved(box(), tmp_path / "box.stl"), error=error)
        p = within(field)
        near = np.abs(to_box(p)) < 2 * field.spacing[0]
        assert np.abs(at(field, p) - to_box(p))[near].max() <= error
        assert field.spacing[0] == pytest.approx(error / (0.75**0.5 + 1 / 32))


@pytest.mark.slow
def test_sphere_and_torus(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(subdivisions=5, radius=10.0)
    field = read_shape(saved(ball, tmp_path / "ball.stl"))
    chord = 10.0 - float(np.linalg.norm(ball.triangles_center, axis=1).min())
    assert Found.of(field).error == pytest.approx(20 / 128, rel=1e-3)
    p = within(field)
    d = np.linalg.norm(p, axis=1) - 10
    near = np.abs(d) < 2 * field.spacing[0]
    assert np.abs(at(field, p) - d)[near].max() < 0.25 * Found.of(field).error + chord
    assert np.abs(at(field, p) - d).max() < Found.of(field).error + Found.of(field).error_beyond + chord
    ring = trimesh.creation.torus(10.0, 3.0, major_sections=200, minor_sections=80)
    field = read_shape(saved(ring, tmp_path / "ring.ply"))
    p = within(field)
    d = np.hypot(np.hypot(p[:, 0], p[:, 1]) - 10, p[:, 2]) - 3
    assert np.abs(at(field, p) - d).max() < Found.of(field).error + Found.of(field).error_beyond + 0.01
    assert ((at(field, p) < 0) == (d < 0))[np.abs(d) > 0.05].all()


def test_hole_is_closed_and_told_of(tmp_path: Path) -> None:
    """The box without its top: closed flat, by a fan in the plane of the rim, so the closed form is still the box's."""
    mesh = trimesh.creation.box(2 * BOX).subdivide().subdivide()
    mesh.update_faces(mesh.triangles_center[:, 2] < BOX[2] - 1e-6)
    field = read_shape(saved(mesh, tmp_path / "open.stl"), error=0.4)
    facts = Found.of(field)
    assert (facts.open_edges, facts.holes) == (16, 1)
    np.testing.assert_allclose(facts.largest_hole, (0, 0, BOX[2]), atol=1e-6)
    p = within(field)
    assert np.abs(at(field, p) - to_box(p)).max() <= 0.4 + facts.error_beyond
    assert ((at(field, p) < 0) == (to_box(p) < 0))[np.abs(to_box(p)) > 0.4].all()


def test_shells_inside_and_beside_each_other(tmp_path: Path) -> None:
    """A cavity is one where its shell is turned inwards; beside each other any shell is a solid."""
    hollow = trimesh.creation.box(BOX)
    hollow.invert()
    apart = trimesh.creation.box([4, 4, 4], trimesh.transformations.translation_matrix([14, 0, 0]))
    apart.invert()
    field = read_shape(saved(trimesh.util.concatenate([box(), hollow, apart]), tmp_path / "two.stl"), error=0.3)
    where = np.array([[0, 0, 0], [3.5, 0, 0], [14, 0, 0], [8, 0, 0], [0, 0, 7.5]], float)
    np.testing.assert_array_equal(at(field, where) < 0, [False, True, True, False, True])
    np.testing.assert_allclose(at(field, where)[[1, 2, 3]], [-0.5, -2, 4], atol=0.3)


def test_winding_is_mended(tmp_path: Path) -> None:
    turned = box()
    turned.invert()
    mixed = box()
    faces = mixed.faces.copy()
    faces[[0, 3, 7]] = faces[[0, 3, 7], ::-1]
    p = np.random.default_rng(2).uniform(-1.05 * BOX, 1.05 * BOX, (3000, 3))
    for mesh in (turned, trimesh.Trimesh(mixed.vertices, faces, process=False)):
        field = read_shape(saved(mesh, tmp_path / "turned.stl"), error=0.4)
        assert Found.of(field).open_edges == 0
        assert ((at(field, p) < 0) == (to_box(p) < 0))[np.abs(to_box(p)) > 0.4].all()


def sheet() -> trimesh.Trimesh:
    return trimesh.Trimesh([[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 0]], [[0, 1, 2], [0, 2, 3]])


def moved(value: float) -> trimesh.Trimesh:
    vertices = box().vertices.copy()
    vertices[3, 1] = value
    return trimesh.Trimesh(vertices, box().faces, process=False, validate=False)


def cut(path: Path) -> None:
    saved(trimesh.creation.icosphere(), path)
    path.write_bytes(path.read_bytes()[:-777])


def text_stl(path: Path) -> None:
    box().export(path, file_type="stl_ascii")
    path.write_bytes(path.read_bytes()[:700])


CORNERS = "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\n"


def obj(faces: str) -> Callable[[Path], int]:
    return lambda path: path.write_text(f"{CORNERS}{faces}")


def ply(vertices: int, faces: int, rest: str, kind: str = "ascii") -> Callable[[Path], int]:
    axes = "".join(f"property float {axis}\n" for axis in "xyz")
    listed = f"element face {faces}\nproperty list uchar int vertex_indices\n" if faces else ""
    text = f"ply\nformat {kind} 1.0\nelement vertex {vertices}\n{axes}{listed}end_header\n{rest}"
    return lambda path: path.write_text(text)


ONE, SELF = '<item objectid="1"/>', '<component objectid="1"/><component objectid="1"/>'
TETRA = (
    "<mesh><vertices><vertex x='0' y='0' z='0'/><vertex x='1' y='0' z='0'/><vertex x='0' y='1' z='0'/>"
    "<vertex x='0' y='0' z='1'/></vertices><triangles><triangle v1='0' v2='2' v3='1'/><triangle v1='0' v2='1' v3='3'/>"
    "<triangle v1='1' v2='2' v3='3'/><triangle v1='0' v2='3' v3='2'/></triangles></mesh>"
)

BROKEN = TETRA.replace("v2='2'", "v2='9'")


def three(objects: str, items: str = "", unit: str = "millimeter", head: str = "") -> Callable[[Path], None]:
    kind = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
    core = 'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"'

    def write(path: Path) -> None:
        link = f'<Relationship Id="r" Type="{kind}" Target="/3D/a.model"/>'
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("_rels/.rels", f"<Relationships>{link}</Relationships>")
            model = f'<model unit="{unit}" {core}><resources>{objects}</resources><build>{items}</build></model>'
            archive.writestr("3D/a.model", f'<?xml version="1.0"?>{head}{model}')

    return write


THREE = "0 0 0\n1 0 0\n0 1 0\n"


@pytest.mark.parametrize(
    ("code", "name", "write", "words"),
    [
        ("E130", "part.stl", lambda p: None, "no file"),
        ("E130", "part.stl", Path.mkdir, "is a folder"),
        ("E130", "part.stl", lambda p: p.symlink_to("/dev/zero"), "is a device"),
        ("E130", "part.stl", os.mkfifo, "is a pipe"),
        (
            "E131",
            "part.igs",
            lambda p: p.write_bytes(b"S      1"),
            "ends in `.igs`, where a mesh ends in `.stl`, `.obj`, ",
        ),
        ("E140", "part.step", lambda p: p.write_bytes(b"ISO-10303-21;\nHEADER;"), "it was cut short"),
        ("E140", "part.stp", lambda p: p.write_bytes(b"solid"), "does not begin with"),
        ("E140", "part.3mf", lambda p: p.write_bytes(b"PK\3\4" + b"\xff" * 99), "it was cut short"),
        ("E140", "part.3mf", lambda p: p.write_bytes(b"<model/>"), "no ZIP archive"),
        ("E140", "part.3mf", three(""), "no triangles"),
        ("E140", "part.3mf", three('<object id="1"><mesh>', '<item objectid="1"/>'), "mismatched tag"),
        ("E140", "part.3mf", three("", '<item objectid="7"/>'), "there is no object 7"),
        (
            "E140",
            "part.3mf",
            three(f'<object id="1">{BROKEN}</object>', ONE),
            "corner 9 of 4",
        ),
        ("E140", "part.3mf", three(f'<object id="1"><components>{SELF}</components></object>', ONE), "have no end"),
        ("E140", "part.3mf", three("", head="<!DOCTYPE model [<!ENTITY a 'b'>]>"), "has a DOCTYPE"),
        ("E140", "part.stl", lambda p: p.write_bytes(b""), "is empty"),
        ("E140", "part.stl", lambda p: p.write_bytes(b"\0" * 80 + b"\xff" * 60), "says that it holds 4,294,967,295"),
        ("E140", "part.stl", text_stl, "it was cut short"),
        ("E140", "part.stl", lambda p: p.write_text("version https://git-lfs.github.com/spec/v1\n"), "Git LFS"),
        ("E135", "part.stl", lambda p: os.truncate(p.open("wb").write(b"\0" * 80) and p, 10**9 + 1), "1,000,000,001"),
        ("E140", "part.ply", ply(10**9, 12, "", "binary_little_endian"), "1,000,000,000 of `vertex`"),
        ("E140", "part.ply", ply(3, 10**9, THREE), "1,000,000,000 of `face`"),
        ("E140", "part.ply", ply(-3, 1, THREE), "the number of `vertex` is none"),
        ("E140", "part.ply", ply(3, 0, THREE), "no triangles"),
        ("E140", "part.ply", ply(3, 2, THREE + "3 0 1 2\n"), "it holds 2 triangles, not 1"),
        ("E140", "part.ply", ply(3, 1, THREE + "3 0 1 7\n"), "names corner 7 of 3"),
        ("E140", "part.obj", obj("f 1 3 2\nf 1 2 4\nf 2 3 99\n"), "index 98 is out of bounds"),
        ("E140", "part.obj", obj("f -9 -2 -3\nf -4 -3 -1\n"), "`f -9 -2 -3` names a corner before the first"),
        ("E140", "part.obj", obj("f 1 3 2\nf 2/1 0/1 3/1\n"), "names corner 0"),
        ("E140", "part.off", lambda p: p.write_text("OFF\n9000000 9 0\n0 0 0\n"), "have no room"),
        ("E140", "part.off", lambda p: p.write_text("solid\n"), "does not begin with `OFF`"),
        ("E140", "part.stl", cut, "is damaged"),
        ("E140", "part.glb", lambda p: p.write_bytes(b"glTF" + b"\xff" * 99), "is damaged"),
        ("E140", "part.obj", lambda p: p.write_text("v 0 0 0\nv 1 0 0\n"), "no triangles"),
        ("E140", "part.off", lambda p: p.write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"), "is damaged"),
        ("E141", "part.stl", lambda p: saved(moved(np.nan), p), "corner"),
        ("E141", "part.obj", lambda p: p.write_text(CORNERS.replace("9", "1e400") + "f 1 2 3\n"), "2 corners"),
        ("E141", "part.stl", lambda p: saved(moved(1e6), p), "from the origin"),
        ("E142", "part.stl", lambda p: saved(sheet(), p), "encloses nothing"),
    ],
)
def test_what_is_no_mesh(code: str, name: str, write: Any, words: str, tmp_path: Path) -> None:
    write(tmp_path / name)
    found = told(lambda: read_shape(str(tmp_path / name), span=SPAN))
    assert (found.code, words in found.message) == (code, True), found


def test_too_many_triangles_are_refused_by_what_the_file_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(file, "MOST_TRIANGLES", 11)
    monkeypatch.setattr(ask, "_measured", never)
    path = saved(box(), tmp_path / "box.stl")
    found = told(lambda: read_shape(path, span=SPAN))
    assert (found.code, found.message) == ("E135", f"`{path}` is too large: 12 triangles of 11")


def test_files_that_are_odd_but_right(tmp_path: Path) -> None:
    """Corners counted from the last, squares, other lines between; bytes after the last triangle; several bodies."""
    (tmp_path / "odd.obj").write_text(
        "# by hand\nmtllib none.mtl\n"
        + CORNERS
        + "vt 0 0\nvn 0 0 1\nf -4/-1/-1 -2/-1/-1 -3/-1/-1\nf -4 -3 -1\nf 2//1 3//1 4//1\n"
        "f 1 4 3\n"
    )
    (tmp_path / "odd.off").write_text(
        "OFF # squares\n8 6 0\n0 0 0\n9 0 0\n9 9 0\n0 9 0\n0 0 9\n9 0 9\n9 9 9\n0 9 9\n"
        "4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n"
    )
    path = saved(box(9 / 20), tmp_path / "odd.stl")
    Path(path).write_bytes(Path(path).read_bytes() + b"\0\0")
    scene = trimesh.Scene()
    for x in (0.0, 0.005):
        scene.add_geometry(
            trimesh.creation.box([0.004] * 3), transform=trimesh.transformations.translation_matrix([x, 0, 0])
        )
    scene.export(str(tmp_path / "odd.glb"))
    for ending, triangles in ((".obj", 4), (".off", 12), (".stl", 12), (".glb", 24)):
        found = Found.of(read_shape(str(tmp_path / f"odd{ending}"), error=0.4))
        assert (found.triangles, found.open_edges, max(found.size)) == (triangles, 0, pytest.approx(9)), ending


def test_3mf_is_read_as_it_is_placed(tmp_path: Path) -> None:
    """One that we wrote; and one in inches, whose object is placed twice, moved, mirrored and scaled."""
    part = program("out part = cylinder(4mm, 12mm)", tmp_path)
    assert main(["mesh", str(tmp_path / "part.pore"), "--voxel", "1mm", "-o", str(tmp_path / "ours.3mf"), "-q"]) == 0
    field = read_shape(str(tmp_path / "ours.3mf"), error=0.3)
    p = within(field, 2000)
    assert np.abs(at(field, p) - part.field()(p)).max() < 0.9
    assert (Found.of(field).open_edges, Found.of(field).unit) == (0, 1.0)
    moved = '<component objectid="1" transform="-2 0 0 0 2 0 0 0 2 5 0 0"/><component objectid="1"/>'
    objects = f'<object id="1">{TETRA}</object><object id="2"><components>{moved}</components></object>'
    three(objects, '<item objectid="2" transform="1 0 0 0 1 0 0 0 1 0 0 3"/>', "inch")(tmp_path / "placed.3mf")
    field = read_shape(str(tmp_path / "placed.3mf"), error=0.5)
    found = Found.of(field)
    assert (found.triangles, found.open_edges, found.unit) == (8, 0, 25.4)
    np.testing.assert_allclose([found.low, found.high], 25.4 * np.array([[0, 0, 3], [5, 2, 5]]), atol=1e-4)
    inside = 25.4 * np.array([[0.2, 0.2, 3.2], [4.6, 0.4, 3.4], [3.4, 0.2, 3.1], [5, 1, 4], [0.6, 0.6, 3.2]])
    np.testing.assert_array_equal(at(field, inside) < 0, [True, True, True, False, False])


def test_3mf_holds_supports_that_are_no_part_and_only_known_units(tmp_path: Path) -> None:
    held = TETRA.replace('x="0"', 'x="-9"')
    objects = f'<object id="1">{TETRA}</object><object id="2" type="support">{held}</object>'
    items = '<item objectid="1"/><item objectid="2"/>'
    three(objects, items, "millimeter")(tmp_path / "held.3mf")
    found = Found.of(read_shape(str(tmp_path / "held.3mf"), error=0.1))
    assert (found.triangles, found.low[0]) == (4, 0)
    three(objects, items, "lightyear")(tmp_path / "held.3mf")
    refusal = told(lambda: read_shape(str(tmp_path / "held.3mf"), span=SPAN))
    assert "`lightyear`, which is no unit" in refusal.message
    assert "inch" in refusal.hint


BALL = Path(__file__).parent / "errors" / "data" / "ball.step"


def test_step_without_the_package_that_reads_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(file, "find_spec", lambda name: None)
    for ask_for in (read_shape, shape.look_at_shape):
        with pytest.raises(PoreError) as error:
            ask_for(str(BALL))
        (found,) = error.value.diagnostics
        assert (found.code, "package cascadio, which is not installed" in found.message) == ("E144", True)
        assert "pip install cascadio" in found.hint


def test_step_is_read_to_the_error_that_is_asked_for() -> None:
    """A ball of 10 mm, whose triangles take a quarter of the error."""
    pytest.importorskip("cascadio")
    for error in (0.4, None):
        field = read_shape(str(BALL), error=error)
        p = nodes(field)
        known = np.linalg.norm(p, axis=-1) - 10
        near = np.abs(known) < 3 * field.spacing[0]
        assert np.abs(field.values[..., 0] - known)[near].max() < Found.of(field).error / 4
    with pytest.raises(PoreError, match="says its unit itself"):
        read_shape(str(BALL), unit=25.4)


@pytest.mark.slow
def test_unit_of_a_file(tmp_path: Path) -> None:
    """What is said of the size, and doubted where nobody gave a unit."""
    path = saved(box(1 / 25.4), tmp_path / "inches.stl")
    field = read_shape(path, error=0.4, unit=25.4)
    assert np.abs(field.values[..., 0] - to_box(nodes(field))).max() <= 0.8
    assert Found.of(field).size == pytest.approx(2 * BOX)
    saved(box(1e-3), tmp_path / "box.glb")
    saved(box(1e-3), tmp_path / "metres.stl")
    for text, size, doubts in (
        ('"inches.stl", unit=1in', 20, []),
        ('"inches.stl"', 20 / 25.4, []),
        ('"box.glb"', 20, []),
        ('"box.glb", unit=1mm', 0.02, []),
        ('"metres.stl"', 0.02, ["W233"]),
        ('"metres.stl", unit=1m', 20, []),
    ):
        made = program(f"mesh({text}, error={size / 40}mm)", tmp_path)
        note, *others = made.design().told(*made.graph.roots)
        assert (note.severity, f"x {size:.4g} mm, 12 triangles" in note.message) == ("note", True), note
        assert [d.code for d in others] == doubts
    with pytest.raises(PoreError, match="from the origin"):
        read_shape(path, unit=1e6)


def test_error_that_takes_too_many_samples(tmp_path: Path) -> None:
    path = saved(box(), tmp_path / "box.stl")
    found = told(lambda: read_shape(path, error=1e-4, span=SPAN))
    assert found.code == "E143"
    enough = float(found.hint.split("`error=")[1].split("mm")[0])
    assert 0.01 < enough < 0.1
    for wrong in (0.0, -1.0, np.inf, np.nan):
        assert told(lambda wrong=wrong: read_shape(path, error=wrong, span=SPAN)).code == "E143"


@pytest.mark.usefixtures("apart")
def test_death_of_the_process_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = saved(box(), tmp_path / "box.stl")
    ended = ask.ended

    for how, words in ((signal.SIGSEGV, "crashed (SIGSEGV)"), (signal.SIGKILL, "not enough memory")):

        def killed(running: Running, heard: Any, how: signal.Signals = how) -> int:
            os.kill(running.pid, how)
            return ended(running, heard)

        monkeypatch.setattr(ask, "ended", killed)
        found = told(lambda: read_shape(path, span=SPAN))
        assert (found.code, words in found.message) == ("E144", True), found


@pytest.mark.slow
@pytest.mark.usefixtures("apart")
def test_cancelling_ends_the_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = saved(trimesh.creation.icosphere(subdivisions=4, radius=10.0), tmp_path / "ball.stl")
    started: list[Running] = []
    ended = ask.ended
    monkeypatch.setattr(ask, "ended", lambda running, heard: (started.append(running), ended(running, heard))[1])
    reports: list[tuple[int, int]] = []
    with (
        watching(lambda _, done, total: reports.append((done, total)), lambda: bool(reports)),
        pytest.raises(CancelledError),
    ):
        read_shape(path)
    assert started[0].returncode == -signal.SIGKILL
    assert all(0 <= done <= total for done, total in reports)
    assert read_shape(path).components == 1  # nothing was kept of what was cancelled


@pytest.mark.slow
def test_process_ends_with_the_one_that_started_it(tmp_path: Path) -> None:
    """Its standard input closes then, in whatever way that one ended."""
    path = saved(trimesh.creation.icosphere(subdivisions=6, radius=10.0), tmp_path / "ball.stl")
    python = [sys.executable, "-P", "-m", "porelang.tasks.shape.child", ".stl", "0.05", "nan", "nan"]
    with open(path, "rb") as source, open(tmp_path / "found.npz", "wb") as target:
        files = source.fileno(), target.fileno()
        running = subprocess.Popen(
            [*python, *map(str, files)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            pass_fds=files,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        )
        with running:
            assert running.stdout is not None
            assert running.stdin is not None
            assert re.fullmatch(rb"\d+ \d+\n", running.stdout.readline())
            running.stdin.close()
            assert running.wait(timeout=120) == 0
    assert (tmp_path / "found.npz").read_bytes() == b""


def never(*_: object) -> int:
    raise AssertionError("a mesh was measured")


@pytest.mark.usefixtures("apart")
def test_what_was_measured_is_kept_by_the_content_of_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store, "_folder", lambda: tmp_path / "kept")
    first = read_shape(saved(box(), tmp_path / "box.stl"), error=0.4)
    forget()
    with monkeypatch.context() as without:
        without.setattr(ask, "_measured", never)
        (tmp_path / "copy.stl").write_bytes((tmp_path / "box.stl").read_bytes())
        for name in ("box.stl", "copy.stl"):
            again = read_shape(str(tmp_path / name), error=0.4)
            assert (again.digest, again.facts) == (first.digest, first.facts)
        for change in ({"error": 0.5}, {"error": 0.4, "margin": 3.0}):
            with pytest.raises(AssertionError, match="was measured"):
                read_shape(str(tmp_path / "box.stl"), **change)
    assert [entry.label for entry in store.usage().entries] == ['mesh("box.stl")']
    assert Found.of(read_shape(saved(box(0.9), tmp_path / "box.stl"), error=0.4)).high == pytest.approx(0.9 * BOX)


def test_check_measures_only_when_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    saved(box(), tmp_path / "box.stl")
    (tmp_path / "part.pore").write_text('gyroid(5) & mesh("box.stl", error=0.4mm)')
    monkeypatch.chdir(tmp_path)
    with monkeypatch.context() as without:
        without.setattr(ask, "_measured", never)
        assert main(["check", "part.pore"]) == 0
        (tmp_path / "box.stl").write_bytes((tmp_path / "box.stl").read_bytes()[:-7])
        assert main(["check", "part.pore"]) == 1
        assert "`box.stl` is damaged: it says that it holds 12 triangles" in capsys.readouterr().err
    saved(sheet(), tmp_path / "box.stl")
    assert main(["check", "part.pore"]) == 0
    assert main(["check", "part.pore", "--measure"]) == 1
    assert "E142" in capsys.readouterr().err


# ---- in programs ----


def program(text: str, folder: Path) -> porelang.Program:
    (folder / "part.pore").write_text(text)
    return porelang.compile(path=folder / "part.pore")


def test_a_part_ends_where_its_mesh_does(tmp_path: Path) -> None:
    """A box: its own ends, moved, offset, cut by another; and of a plate as thin as its samples are apart."""
    saved(box(), tmp_path / "box.stl")
    saved(trimesh.creation.box([40.0, 30.0, 0.3]), tmp_path / "plate.stl")
    mesh = 'mesh("box.stl", error=0.4mm)'
    for text, lo, hi in (
        (mesh, -BOX, BOX),
        (f"translate({mesh}, [1, 2, 3])", [-3, -4, -7], [5, 8, 13]),
        (f"offset({mesh}, 0.5mm)", -BOX - 0.5, BOX + 0.5),
        (f"{mesh} & box([4, 4, 40])", [-2, -2, -10], [2, 2, 10]),
        (f"gyroid(3) & {mesh}", -BOX, BOX),
        ('mesh("plate.stl", error=0.15mm)', [-20, -15, -0.15], [20, 15, 0.15]),
    ):
        outer, inner = program(text, tmp_path).design().extent()
        np.testing.assert_allclose(outer, [lo, hi], atol=0.02, err_msg=text)
        assert inner is not None
        np.testing.assert_allclose(inner, [lo, hi], atol=0.02, err_msg=text)


@pytest.mark.slow
def test_mesh_is_a_solid_of_a_program(tmp_path: Path) -> None:
    saved(box(), tmp_path / "box.stl")
    field = program('mesh("box.stl", error=0.4mm)', tmp_path).field()
    p = np.random.default_rng(4).uniform(-BOX, BOX, (5000, 3))
    assert np.abs(field(p) - to_box(p)).max() < 0.45
    filled = program('mesh("box.stl", error=0.4mm) & gyroid(5)', tmp_path)
    part = filled.mesh(voxel=0.4)
    assert part.is_watertight
    np.testing.assert_allclose(part.bounds, [-BOX, BOX], atol=0.05)
    shell = program('shell(mesh("box.stl", error=0.2mm), 1mm, side="inside")', tmp_path)
    made = shell.mesh(voxel=0.2)
    assert made.volume == pytest.approx(np.prod(2 * BOX) - np.prod(2 * BOX - 2), rel=0.02)


def test_beyond_the_grid_the_distance_is_never_too_large(tmp_path: Path) -> None:
    saved(box(), tmp_path / "box.stl")
    field = program('mesh("box.stl", error=0.2mm, margin=1mm)', tmp_path).field()
    p = np.random.default_rng(5).uniform(-60, 60, (5000, 3))
    known, found = to_box(p), field(p)
    far = known > 3
    assert (found[far] <= known[far] + 0.2).all()
    assert (found[far] >= 0.7 * known[far] - 0.2).all()


def test_numbers_that_a_mesh_is_asked_for_with(tmp_path: Path) -> None:
    saved(box(), tmp_path / "box.stl")
    for text, code in (
        ('mesh("box.stl", error=0mm)', "E143"),
        ('mesh("box.stl", error=30deg)', "E062"),
        ('mesh("box.stl", error=x)', "E063"),
        ('param e = 0.4mm in 0.2mm..0.8mm\nmesh("box.stl", error=e)', "E063"),
        ("mesh(5)", "E060"),
    ):
        with pytest.raises(PoreError) as error:
            program(text, tmp_path)
        assert error.value.diagnostics[0].code == code, error.value


@pytest.mark.slow
@pytest.mark.usefixtures("kept")
def test_scan_of_the_example_is_what_was_scanned() -> None:
    """By the sign of what it was made from: noise and the closed holes lie within half a mm of its surface."""
    examples = Path(__file__).parent.parent / "examples"
    known = porelang.compile(runpy.run_path(str(examples / "scan.py"))["GRIP"]).field()
    program = porelang.compile(path=examples / "grip.pore")
    grip = program.design().formula(*(n for n in order(program.graph.roots) if n.op == "mesh"))
    (scan,) = [v for v in grip.bindings.values() if isinstance(v, SampledField) and v.facts]
    facts = Found.of(scan)
    assert (facts.holes, facts.error) == (3, 0.3)
    assert np.abs(np.array(facts.largest_hole) - [0, 0, 0.4]).max() < 1  # the foot, which was never seen
    p = within(scan)
    sure = np.abs(known(p)) > 0.6
    assert sure.mean() > 0.8
    np.testing.assert_array_equal((at(scan, p) < 0)[sure], (known(p) < 0)[sure])


def test_corners_of_an_obj_file_are_counted_back_from_where_they_are_named(tmp_path: Path) -> None:
    """A second box follows: by the specification -1 is the last corner above the face, not the last of the file."""
    first = box()
    lines = [f"v {x} {y} {z}" for x, y, z in first.vertices.tolist()]
    lines += ["vn 0 0 1", *("f " + " ".join(f"{k - 8}//-1" for k in face) for face in first.faces.tolist())]
    lines += [f"v {x + 30} {y} {z}" for x, y, z in first.vertices.tolist()]
    lines += ["f " + " ".join(str(k + 9) for k in face) for face in first.faces.tolist()]
    path = tmp_path / "two.obj"
    path.write_text("\n".join(lines), encoding="utf-8")
    field = read_shape(str(path), error=0.4)
    facts = Found.of(field)
    assert (facts.triangles, facts.open_edges) == (24, 0)
    np.testing.assert_array_equal(at(field, np.array([[0.0, 0, 0], [15, 0, 0], [30, 0, 0]])) < 0, [True, False, True])
    path.write_text("\n".join(lines).replace("f -", "f -9", 1), encoding="utf-8")
    assert told(lambda: read_shape(str(path), span=SPAN)).code == "E140"


def test_an_error_as_large_as_the_part_is_refused(tmp_path: Path) -> None:
    path = saved(box(), tmp_path / "box.stl")
    assert told(lambda: read_shape(path, error=100.0, span=SPAN)).code == "E143"


def test_repeated_triangles_are_told_of(tmp_path: Path) -> None:
    mesh = box()
    twice = trimesh.Trimesh(mesh.vertices, np.concatenate([mesh.faces, mesh.faces[:3]]), process=False)
    field = read_shape(saved(twice, tmp_path / "box.ply"), error=0.4)
    assert (Found.of(field).repeated, Found.of(field).open_edges) == (3, 0)
    assert "15 triangles (3 of them repeated and left out)" in shape.told_of(field).note


def test_an_error_that_was_not_reached_is_told() -> None:
    found = Found(100, 0, 0, (0, 0, 0), 3.2, 0.1, (0, 0, 0), (90, 90, 90), 0.0, (0, 0, 0), 1.0, 0, 1.0)
    numbers = [v for f in dataclasses.astuple(found) for v in (f if isinstance(f, tuple) else (f,))]
    field = SampledField(np.zeros((2, 2, 2, 1)), (0, 0, 0), (1, 1, 1), tuple(map(float, numbers)))
    (doubt,) = told_of(field).doubts
    assert doubt.code == "W242"
    assert "3.2 mm, and 1 mm" in doubt.message
    numbers[20] = 3.0
    assert told_of(dataclasses.replace(field, facts=tuple(map(float, numbers)))).doubts == ()


@pytest.mark.parametrize("eps", [1e-6, 1e-3])
def test_triangles_that_nearly_stand_twice_are_one(tmp_path: Path, eps: float) -> None:
    """Scans that were registered twice, or rounded: the ball is as without them."""
    ball = trimesh.creation.icosphere(4, radius=8)
    again = np.random.default_rng(0).permutation(len(ball.faces))[:200]
    points = np.random.default_rng(0).uniform(-8.4, 8.4, (5000, 3))
    values = []
    for more in (False, True):
        vertices = np.vstack([ball.vertices, ball.vertices + eps]) if more else ball.vertices
        faces = np.vstack([ball.faces, ball.faces[again] + len(ball.vertices)]) if more else ball.faces
        trimesh.Trimesh(vertices, faces, process=False).export(tmp_path / "ball.stl")
        (tmp_path / "a.pore").write_text('mesh("ball.stl", error=0.3mm)')
        program = porelang.compile(path=tmp_path / "a.pore")
        values.append(program.field()(points))
        (note,) = program.design().told(*program.graph.outputs["part"])
        assert ("200 of them repeated" in note.message) is more
    np.testing.assert_allclose(values[1], values[0], atol=2 * eps)


def test_a_wall_of_a_scaled_mesh_is_no_longer_as_thick_as_it_says(tmp_path: Path) -> None:
    saved(box(), tmp_path / "box.stl")
    for text, expected in (
        ('shell(scale(mesh("box.stl"), [1, 1, 1.8]), 0.8mm, side="inside")', ["W238"]),
        ('shell(mesh("box.stl"), 0.8mm, side="inside")', []),
    ):
        (tmp_path / "a.pore").write_text(text)
        program = porelang.compile(path=tmp_path / "a.pore")
        told = program.design().told(*program.graph.outputs["part"])
        assert [d.code for d in told if d.severity == "warning"] == expected
