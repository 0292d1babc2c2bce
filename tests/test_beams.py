"""Trusses and frames as beam lattices in 3MF files: the same solids, read by others."""

from __future__ import annotations

import json
from pathlib import Path

import igl
import numpy as np
import pytest
from threemf_reader import Bars, Package

import porelang
from porelang.analysis.box import Box
from porelang.cli import main
from porelang.data import Segments
from porelang.diagnostics import PoreError
from porelang.threemf import bars
from porelang.threemf.beams import write_beams

ROOT = Path(__file__).parent.parent
FRAME = f'frame("{ROOT / "examples" / "truss.json"}")'
T = 'truss("octet", 10mm, 0.6mm)'
BODY = "let body = box([30, 24, 18]) |> translate([2, 1, -3])\n"


@pytest.mark.parametrize(
    ("text", "box"),
    [
        (f"{BODY}{T} & body", True),
        (FRAME, None),
        (f"translate({FRAME}, [0, 20, 0]) | {FRAME}", None),
        (f"{BODY}({T} | ({FRAME} - 0.5mm)) & body", True),
        (f"{BODY}rotate({T}, [1, 2, 0], 30deg) & body", True),
        (f"{BODY}scale(translate({T}, [1, 2, 3]), 1.7) & body", True),
        (f"{BODY}mirror(({T}) - 0.3, [1, 1, 0]) & body", True),
        (f"{BODY}param r = 1mm in 0.5mm..2mm\ntruss(\"bcc\", [8mm, 9mm, 10mm], r) & body", True),
        (f"{BODY}(truss([[[0, 0, 0], [1, 1, 1] / 3], [[1, 1, 1] / 3, [1, 0, 0]]], 9mm, 0.5mm) + 0.1) & body", True),
        (f"{BODY}{T} & body & translate(body, [4, 3, 2])", True),
        (f"{BODY}{T} & cylinder(10mm, 24mm)", False),
        (f"{BODY}{T} & body \\ sphere(8mm)", False),
        (f"{FRAME} \\ sphere(20mm)", False),
    ],
)  # fmt: skip
def test_bars_are_the_part(text: str, box: bool | None, tmp_path: Path) -> None:
    """As many points as one likes: in the solid of the file where the field is below 0, and at the same depth."""
    program = porelang.compile(text)
    found = write_beams(program.design(), tmp_path / "a.3mf", name="part")
    read = Bars.read(Package.read(tmp_path / "a.3mf"))
    assert (found["bars"], found["nodes"]) == (len(read.radii), len(np.unique(read.ends.reshape(-1, 3), axis=0)))
    lo, hi = (np.array(end) for end in program.bounds("part"))
    points = np.random.default_rng(1).uniform(lo - 1, hi + 1, (6000, 3))
    wanted = program.field("part", dtype="f64")(points)
    distance = read.distance(points)
    if box is None:
        assert read.clip is None
        np.testing.assert_allclose(distance, wanted, atol=1e-9)
        return
    assert read.clip is not None
    corners, faces = np.unique(read.clip.reshape(-1, 3), axis=0, return_inverse=True)
    faces = faces.reshape(-1, 3)
    assert (len(faces) == 12) == box
    inside = igl.winding_number(corners, faces, points) > 0.5
    off = ((distance < 0) & inside) != (wanted < 0)
    if box:
        assert not off.any()
    elif off.any():  # the mesh that cuts lies off the solid by a part of its voxel
        far = np.sqrt(igl.point_mesh_squared_distance(points[off], corners, faces)[0])
        assert far.max() < found["clip"]["voxel"] / 2
    assert (wanted < 0).sum() > 50
    assert (distance <= wanted + 1e-9)[wanted < 0].all()


def test_bars_are_there_once(tmp_path: Path) -> None:
    """Those that a cell shares with its neighbours, too; and none that lies outside."""
    program = porelang.compile(f"{BODY}{T} & body")
    write_beams(program.design(), tmp_path / "a.3mf")
    read = Bars.read(Package.read(tmp_path / "a.3mf"))
    middles = np.round(read.ends.mean(axis=1), 6)
    assert len(np.unique(middles, axis=0)) == len(middles)
    lo, hi = (np.array(end) for end in program.bounds())
    low, high = read.ends.min(axis=1) - 0.6, read.ends.max(axis=1) + 0.6
    assert ((low <= hi) & (high >= lo)).all()


def test_of_bars_in_one_place_the_thickest_is_there() -> None:
    """Two edges of a cell that its neighbours have too, one of them twice, and the other way round."""
    starts = np.array([[0, 0, 0], [6, 5, 0], [0, 0, 4.0]])
    ends = np.array([[6, 0, 0], [0, 5, 0], [6, 0, 4.0]])
    found = Segments(starts, ends, np.array([0.5, 1.0, 0.7]), (6.0, 5.0, 4.0))
    made = bars.laid_out([bars.Laid(found, np.eye(3), np.zeros(3), 0.0)], Box((1, 2, 1), (5, 3, 3)), None)
    assert len(made.pairs) == 0  # all are farther away than they are thick
    made = bars.laid_out([bars.Laid(found, np.eye(3), np.zeros(3), 0.0)], Box((2, -1, 1), (4, 1, 3)), None)
    middles = made.places[made.pairs].mean(axis=1)
    np.testing.assert_allclose(middles[np.argsort(middles[:, 2])], [[3, 0, 0], [3, 0, 4]], atol=1e-12)
    np.testing.assert_array_equal(made.radii, 1.0)


def test_bars_beyond_a_round_clip_are_left_out(tmp_path: Path) -> None:
    design = porelang.compile(f"out ball = {T} & sphere(15)\nout part = {T} & cube(30)").design()
    ball, cube = (write_beams(design, tmp_path / "a.3mf", name=n)["bars"] for n in ("ball", "part"))
    assert ball < 0.75 * cube


def test_bounds_cut(tmp_path: Path) -> None:
    design = porelang.compile(T).design()
    with pytest.raises(PoreError, match="no end"):
        write_beams(design, tmp_path / "a.3mf")
    found = write_beams(design, tmp_path / "a.3mf", bounds=(0, 0, 0, 20, 10, 10))
    assert found["clip"] == {"lo": [0, 0, 0], "hi": [20, 10, 10]}
    assert found["radius"] == [0.6, 0.6]


@pytest.mark.parametrize(
    ("text", "why", "place"),
    [
        ('truss("octet", 9mm, 1mm, joint=1mm) & cube(20)', "bars with fillets", 'truss("octet", 9mm, 1mm, joint=1mm)'),
        ('truss("bcc", 9mm, 1mm + z / 90) & cube(20)', "bars whose radius varies", 'truss("bcc", 9mm, 1mm + z / 90)'),
        (f"({T} @ [x, y, z + sin(x)]) & cube(20)", "bars that are bent", None),
        (f"({T} @ [x, y, 2 * z]) & cube(20)", "bars that are stretched", None),
        (f"({T} & cube(20)) | sphere(4)", "more than bars", None),
        (f"shell({T}, 0.1) & cube(20)", "more than bars", None),
        (f"{T} & {FRAME}", "bars that are intersected with bars", None),
        ("sphere(8)", "no bars are in it", None),
        ('truss("octet", 0.05mm, 0.01mm) & cube(20)', "1.7e+09 bars, which are too many", None),
    ],
)  # fmt: skip
def test_what_is_no_union_of_bars_is_refused(text: str, why: str, place: str | None, tmp_path: Path) -> None:
    design = porelang.compile(text).design()
    with pytest.raises(PoreError) as error:
        write_beams(design, tmp_path / "a.3mf")
    (found,) = error.value.diagnostics
    assert (found.code, found.message) == ("E198", f"`part` is no union of bars: {why}")
    assert found.span is not None
    assert found.span.text == (place or text)
    assert "leave out --beams" in found.hint
    assert not list(tmp_path.iterdir())


def test_lib3mf_reads_bars(tmp_path: Path) -> None:
    lib3mf = pytest.importorskip("lib3mf")
    program = porelang.compile(f"{BODY}({T} | ({FRAME} - 0.5mm)) & body")
    found = write_beams(program.design(), tmp_path / "a.3mf")
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(tmp_path / "a.3mf"))
    assert reader.GetWarningCount() == 0
    meshes = model.GetMeshObjects()
    objects = []
    while meshes.MoveNext():
        objects.append(meshes.GetCurrentMeshObject())
    clip, lattice = objects
    assert (clip.GetTriangleCount(), clip.IsValid()) == (12, True)
    beams = lattice.BeamLattice()
    assert beams.GetBeamCount() == found["bars"]
    assert beams.GetClipping()[1] == clip.GetResourceID()
    own = Bars.read(Package.read(tmp_path / "a.3mf"))
    for k in range(0, found["bars"], 50):
        beam = beams.GetBeam(k)
        ends = [list(lattice.GetVertex(i).Coordinates) for i in beam.Indices]
        np.testing.assert_allclose(ends, own.ends[k], atol=1e-5)
        np.testing.assert_allclose(list(beam.Radii), own.radii[k])
        assert list(beam.CapModes) == [0, 0]  # spheres


def test_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.pore").write_text('param r = 1mm in 0.5mm..2mm\n(truss("bcc", 8mm, r)) & cylinder(9, 12)')
    asked = ["mesh", "a.pore", "-o", "a.3mf", "--beams", "--set", "r=0.8mm"]
    assert main([*asked, "--voxel", "0.5mm", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["clip"]["voxel"] == 0.5
    assert told["radius"] == [0.8, 0.8]
    assert main(asked) == 0
    assert "bars of the radius 0.8 mm" in capsys.readouterr().out
    for more in (["--smooth"], ["--sharp"], ["--simplify", "0.1mm"], ["--force"]):
        assert main([*asked, *more]) == 2
        assert f"{more[0]} is about triangles" in capsys.readouterr().err
    assert main(["mesh", "a.pore", "-o", "a.stl", "--beams"]) == 2
    assert "in .3mf alone" in capsys.readouterr().err


def test_a_cell_by_its_name_is_no_file() -> None:
    """Every command that writes asks which files are read, and ended in a bug report."""
    program = porelang.compile(f"{T} & cube(20)")
    assert program.files == (program.source.name,)
    listed = porelang.compile("truss([[[0, 0, 0], [1, 1, 1] / 2]], 9mm, 0.5mm) & cube(20)")
    assert listed.files == (listed.source.name,)


def test_most_bars_are_counted_before_they_are_made(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(bars, "MOST", 100)
    with pytest.raises(PoreError, match="too many"):
        write_beams(porelang.compile(f"{T} & cube(20)").design(), tmp_path / "a.3mf")
