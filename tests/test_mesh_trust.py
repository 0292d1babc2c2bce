"""A mesh is the part: no crumbs, nothing lost in silence, promises kept on every option; against closed forms."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import porelang
from porelang.analysis.bounds import overflows
from porelang.cli import main
from porelang.diagnostics import PoreError
from porelang.field import make_field
from porelang.measure import measure
from porelang.mesh import Grid, crumbs, extract, write
from porelang.mesh.crossed import crossed
from porelang.mesh.crumbs import settle
from porelang.mesh.made import make
from porelang.mesh.mend import kept_sound
from porelang.mesh.part import grid_of, surface_of
from porelang.mesh.surface import Surface, decimal, single
from porelang.slices import write_slices
from porelang.solid import Solid
from porelang.walls import BEARING, MOST_TRIANGLES, TO_A_WALL, chosen, on_surface, thinnest, triangles, walls_at

CUBE = (-5, -5, -5, 5, 5, 5)
PINS = "union([box([40,20,2]), union([for i in range(8): translate(cylinder(0.1,15),[5*i-18,0,8])])])"


def made(text, **how):
    return make(porelang.compile(text).design(), **how)


def codes(found):
    return [d.code for d in found.doubts]


def settled(text, **how):
    design = porelang.compile(text).design()
    placed = grid_of(design, **how)
    surface = surface_of(design, None, placed)
    return settle(surface, placed.grid, Solid(design.of(), placed.cut))


# --- pieces ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("how", [{"voxel": 0.25}, {"resolution": 60}])
def test_a_lattice_in_one_piece_is_meshed_in_one_piece(how):
    """The sheet of a gyroid is connected, and a sphere of 3/2 periods cuts nothing off: there were 73 to 106 specks."""
    found = made("shell(gyroid(10mm), 0.6) & sphere(15mm)", **how)
    assert found.facts["components"] == 1
    assert found.facts["crumbs"]["removed"] > 10
    assert found.facts["crumbs"]["removed_volume"] < 1e-4 * found.surface.volume
    assert found.surface.check() == []
    assert codes(found) == []


@pytest.mark.slow
def test_a_sharp_mesh_has_no_crumbs_either():
    found = made("shell(gyroid(10mm), 0.6) & sphere(15mm)", resolution=60, sharp=True)
    assert found.surface.components == 1
    assert found.surface.check() == []


def test_pieces_that_are_pieces_stay_and_are_listed():
    """Even where they are a single sample: a ball of a third of a voxel is what it is."""
    text = "union([sphere(10), translate(sphere(1), [14, 0, 0]), translate(sphere(0.35), [0, 0.07, 13.7])])"
    found = made(text, bounds=(-15, -15, -15, 16, 15, 15), voxel=0.5)
    assert found.facts["solids"] == 3
    assert found.facts["voids"] == 0
    assert found.facts["crumbs"]["removed"] == 0
    one, two, three = found.facts["solid_pieces"]
    assert one["volume"] == pytest.approx(4 / 3 * np.pi * 1000, rel=0.01)
    assert two["volume"] == pytest.approx(4 / 3 * np.pi, rel=0.15)
    assert np.mean(three["bounds"], axis=0) == pytest.approx([0, 0.07, 13.7], abs=0.25)


def test_closed_voids_stay_and_bubbles_of_an_open_gap_are_filled():
    """A cavity is a cavity; a wedge of void that runs out between two bodies leaves samples of it alone."""
    found = made("sphere(10) & ~sphere(3)", voxel=0.5)
    assert (found.facts["solids"], found.facts["voids"]) == (1, 1)
    assert found.facts["closed_voids"][0]["volume"] == pytest.approx(36 * np.pi, rel=0.02)
    # the complement of the lattice whose specks are removed above
    found = made("box([32,32,32]) & ~(shell(gyroid(10mm), 0.6) & sphere(15mm))", voxel=0.25)
    assert (found.facts["solids"], found.facts["voids"]) == (1, 1)
    assert found.facts["crumbs"]["filled"] > 10
    assert found.surface.check() == []


def test_pieces_hold_their_material_without_the_voids_in_them():
    """Closed tubes were told with what is in them. A ball in a hollow one, and a void that another hides."""
    text = """let tube = cylinder(5, 20) \\ cylinder(4, 18)
    let holes = sphere(3) | translate(sphere(1.5), [6, 0, 0])
    let hollow = translate((sphere(8) \\ holes) | sphere(2), [0, 30, 0])
    tube | translate(tube, [12, 0, 0]) | hollow"""
    pieces = made(text, voxel=0.25).facts["solid_pieces"]
    tube, ball = np.pi * (25 * 20 - 16 * 18), 4 / 3 * np.pi
    exact = [ball * (8**3 - 3**3 - 1.5**3), tube, tube, ball * 2**3]
    assert [p["volume"] for p in pieces] == pytest.approx(exact, rel=0.02)


def test_a_piece_of_crumbs_alone_keeps_one():
    """A dumbbell by itself, its neck thinner than a voxel: of its two ends one stays, whatever else there is."""
    ends = "translate(sphere(0.3), [12.315, -0.185, -0.185]), translate(sphere(0.29), [13.815, -0.185, -0.185])"
    text = f"union([sphere(8), {ends}, translate(box([1.2, 0.06, 0.06]), [13.065, -0.05, -0.185])])"
    done = settled(text, voxel=0.5, bounds=(-10, -10, -10, 15, 10, 10))
    assert (done.removed, done.surface.components) == (1, 2)
    assert done.surface.pieces.high[:, 0].max() < 13  # the larger of the two


def test_pieces_that_are_closed_off_need_no_look(monkeypatch):
    """Enclosures prove that nothing passes the sides of their boxes; each of 64 balls was sampled three times."""

    def look(*_):
        raise AssertionError("a look that is not needed")

    monkeypatch.setattr(crumbs, "_Look", look)
    balls = "union([for i in range(4) for j in range(4) for k in range(4): translate(sphere(0.1), [i, j, k])])"
    found = settled(balls, voxel=0.05)
    assert found.surface.components == 64
    assert found.unknown == found.torn == found.removed == 0
    hollow = settled("sphere(10) \\ union([for i in range(-1, 2): translate(sphere(2), [5 * i, 0, 0])])", voxel=0.5)
    assert hollow.surface.components == 4
    assert hollow.unknown == hollow.filled == 0


@pytest.mark.usefixtures("roughly")
def test_more_pieces_than_there_is_time_to_look_at_are_told(monkeypatch):
    """The porous coat of a hip cup came in 1 684 surfaces without a word: 4 327 others had been found torn off."""
    monkeypatch.setattr(crumbs, "BUDGET", 0)  # as many samples as the grid has
    design = porelang.compile("shell(gyroid(10mm), 0.6) & sphere(15mm)").design()
    found = make(design, resolution=70)
    assert found.facts["crumbs"]["pending"] > 10
    (told,) = [d for d in found.doubts if d.code == "W205" and "may be torn off" in d.message]
    assert f"{found.facts['crumbs']['pending']:,} small pieces" in told.message
    error = measure(design, resolution=70)["error"]
    assert error["solid_components"] > 0
    assert error["euler"] == np.inf


def test_what_lies_in_the_box_of_a_piece_is_not_closed_off_with_it():
    """Two specks of one ring, in one box, are one with each other; the ring itself lies between the samples."""
    text = "union([torus(4, 0.06) |> translate([0, 0, 0.5]), translate(sphere(0.7), [4, 0, 0.5]), "
    text += "translate(sphere(0.7), [-4, 0, 0.5]), translate(sphere(9), [40, 0, 0])])"
    assert settled(text, bounds=(-6, -9.5, -9.5, 50, 9.5, 9.5), voxel=1).torn >= 1


def test_slivers_of_the_part_are_left_out_and_told(tmp_path, capsys, monkeypatch):
    """A part came with a second body of 0.005 x 0.005 x 0.016 mm at a voxel of 0.42 mm: real, and met by chance."""
    bounds, voxel = (-11, -11, -11, 15, 11, 11), 0.5
    grid = grid_of(porelang.compile("sphere(10)").design(), None, voxel, None, bounds).grid
    node = [grid.origin[n] + grid.spacing * (i - 2) for n, i in enumerate((grid.shape[0], 24, 24))]
    text = f"sphere(10) | translate(sphere({{}}), [{node[0]}, {node[1]}, {node[2]}])"
    found = made(text.format(0.02), bounds=bounds, voxel=voxel)
    assert found.facts["solids"] == 1
    assert found.facts["crumbs"]["slivers"] == 1
    assert 0 < found.facts["crumbs"]["slivers_volume"] < 4 / 3 * np.pi * 0.02**3
    assert found.facts["crumbs"]["removed"] == 0
    assert made(text.format(0.06), bounds=bounds, voxel=voxel).facts["solids"] == 2  # a quarter of a voxel
    monkeypatch.chdir(tmp_path)
    Path("part.pore").write_text(text.format(0.02), encoding="utf-8")
    box = ",".join(map(str, bounds))
    assert main(["mesh", "part.pore", "-o", "part.stl", "--voxel", "0.5mm", f"--bounds={box}"]) == 0
    assert "1 sliver of the part, less than 0.05 mm across, left out" in capsys.readouterr().out


def test_a_lost_mesh_is_refused_before_its_pieces_are_looked_at(monkeypatch):
    """Thousands of specks of a lattice: to look at them takes long, and volume tells it at a glance."""

    def look(*_):
        raise AssertionError("pieces are looked at")

    monkeypatch.setattr("porelang.mesh.made.settle", look)
    with pytest.raises(PoreError) as caught:
        made("shell(gyroid(3), 0.1) & cube(9)", voxel=0.4)
    assert caught.value.diagnostics[0].code == "E118"


def test_torn_walls_are_told():
    found = made("shell(sphere(10), 0.1)", voxel=0.5, force=True)
    assert codes(found)[:2] == ["W202", "W205"]
    assert found.facts["crumbs"]["torn"] > 100


def test_streamed_surfaces_lose_their_crumbs_too(tmp_path):
    design = porelang.compile("shell(gyroid(10mm), 0.6) & sphere(15mm)").design()
    placed = grid_of(design, resolution=60)
    part = Solid(design.of(), placed.cut)
    sample = make_field(design.of(), {}, "numpy", "f32").on_grid(placed.grid.axes()).block
    kept = extract(placed.grid, placed.cut, sample, memory=4096, folder=tmp_path)
    whole = extract(placed.grid, placed.cut, sample)
    one, other = settle(kept, placed.grid, part), settle(whole, placed.grid, part)
    assert one.removed == other.removed > 0
    assert one.surface.check() == []
    assert one.surface.volume == pytest.approx(other.surface.volume, rel=1e-12)


# --- promises --------------------------------------------------------------------------------------------------------

STEPPED = [
    "round(x/4) + round(y/4) + z",
    "floor(x) % 2 + floor(y) % 2 - 0.5 + 0*z",
    "round(x/2) * round(y/2) - z",
    "z - round(x)",
]


@pytest.mark.parametrize("how", [{}, {"smooth": True}, {"sharp": True}, {"sharp": True, "simplify": 0.1}])
@pytest.mark.parametrize("text", STEPPED)
def test_fields_that_jump_give_sound_meshes(text, how):
    found = made(text, bounds=CUBE, resolution=12, force=True, **how)
    assert found.surface.check() == []
    assert found.surface.check_vertices(single(1.0)) == []
    assert found.surface.check_vertices(decimal(12)) == []


@pytest.mark.parametrize("low", [-1, -2, -3])
def test_trilinear_fields_of_integers_give_sound_meshes(low):
    """Samples that are 0, and ties on every ambiguous face."""
    random = np.random.default_rng(7)
    for _ in range(20):
        values = random.integers(low, -low + 1, (9, 9, 9)).astype(float)
        grid = Grid((-1.0, -1.0, -1.0), 1.0, (9, 9, 9))
        surface = extract(grid, ((0.0,) * 3, (6.0,) * 3), lambda a, b, v=values: v[tuple(map(slice, a, b))])
        assert surface.check() == []
        assert surface.check_vertices(single(1.0)) == []


def pyramids(apart):
    """Two tetrahedra, the tip of one that far from a corner of the other."""
    tip = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.int32)
    other = -tip[[0, 2, 1, 3]] - [apart, 0, 0]
    return Surface(np.concatenate([tip, other]), np.concatenate([faces, faces + 4]).astype(np.int32))


def test_vertices_in_one_place_are_moved_apart():
    broken = pyramids(0.0)
    assert broken.check() != []
    mended = kept_sound(broken, 0.5, refined=True)
    assert mended.check() == []
    assert np.abs(mended.vertices - broken.vertices).max() < 0.05


@pytest.mark.parametrize("ending", [".stl", ".obj", ".ply", ".3mf", ".glb", ".vtp"])
def test_no_writer_takes_what_is_not_sound(ending, tmp_path):
    with pytest.raises(PoreError) as caught:
        write(pyramids(0.0), tmp_path / f"a{ending}")
    assert caught.value.diagnostics[0].code == "E119"
    assert list(tmp_path.iterdir()) == []


def test_digits_that_a_format_has_not_are_missed(tmp_path):
    far = Surface(pyramids(1e-9).vertices + np.array([1e5, 0, 0]), pyramids(1e-9).faces)
    assert far.check() == []
    write(far, tmp_path / "a.ply")
    for ending in (".stl", ".obj", ".3mf"):
        with pytest.raises(PoreError) as caught:
            write(far, tmp_path / f"a{ending}")
        assert caught.value.diagnostics[0].code == "E115"


# --- what is lost ----------------------------------------------------------------------------------------------------


def test_pins_that_the_voxel_does_not_hold_are_missed():
    found = made(PINS, voxel=1.0)
    assert codes(found) == ["W205"]
    assert "40 x 20 x 1" in found.doubts[0].message  # to 15.5 mm
    assert "0.2 mm thick" in found.doubts[0].message
    assert codes(made("box([40,20,2])", voxel=1.0)) == []


def test_wires_within_the_part_and_slots_are_missed():
    """The box of the part is full all the same, and so is its volume."""
    plates = "translate(box([40,20,2]), [0,0,11]), translate(box([40,20,2]), [0,0,-11])"
    wires = "union([for i in range(8): translate(cylinder(0.1, 21), [5*i - 18, 0, 0])])"
    assert "W205" in codes(made(f"union([{plates}, {wires}])", voxel=1.0))
    assert codes(made(f"union([{plates}])", voxel=1.0)) == []
    slots = "union([for i in range(6): translate(box([0.05, 16, 16]), [3*i - 7.5, 0, 0])])"
    assert "W205" in codes(made(f"box([20,20,20]) & ~{slots}", voxel=1.0))


def test_walls_thinner_than_the_voxel_are_no_empty_part():
    design = porelang.compile('shell(box([20,20,20]), 0.02, side="inside")').design()
    for how in ({}, {"voxel": 0.5}):
        with pytest.raises(PoreError) as caught:
            make(design, **how)
        told = caught.value.diagnostics[0]
        assert told.code == "E111"
        assert "about 0.02 mm" in told.message
        assert "--voxel 0.008mm" in told.hint
    with pytest.raises(PoreError) as caught:  # this one is
        make(porelang.compile("gyroid(10) + 5").design(), bounds=CUBE)
    assert "the part is empty" in caught.value.diagnostics[0].message


@pytest.mark.parametrize(
    ("text", "wall"),
    [
        ("shell(sphere(10), 0.3)", 0.3),
        ("box([30, 30, 0.7])", 0.7),
        ("union([box([30, 30, 2]), translate(cylinder(0.25, 20), [0, 0, 10])])", 0.5),
        ('shell(box([20,20,20]), 0.02, side="inside")', 0.02),
        ("sphere(10)", 20.0),
    ],
)
def test_the_thinnest_walls_are_found(text, wall):
    design = porelang.compile(text).design()
    assert thinnest(Solid(design.of(), design.bounds())) == pytest.approx(wall, rel=0.03)


def test_wedges_are_no_walls():
    """A half-space cuts a ball: its rim is as thin as one likes, and no voxel would do. The wall of a gyroid sheet in a
    ball is that of the sheet: 2 * 0.3 over the slope, which is 0.84 to 1.09 at a period of 10."""
    design = porelang.compile("shell(gyroid(10mm), 0.6) & sphere(15mm)").design()
    assert 0.45 < thinnest(Solid(design.of(), design.bounds())) < 0.75
    design = porelang.compile("sphere(10) & (z - 8)").design()
    found = thinnest(Solid(design.of(), design.bounds()))
    assert found is None or found > 1


@pytest.mark.parametrize(("lattice", "across"), [("gyroid", 3**0.5 / 4), ("diamond", 2**0.5 / 4)])
def test_feathers_are_no_walls_that_bear(lattice, across):
    """Where an envelope cuts a network at a small angle it leaves feathers, and bridges where it just touches it. The
    walls of the network are from flat point to flat point of its surface, which lie on a lattice of their own."""
    for envelope in ("cube(20mm)", "cylinder(10mm, 20mm)", "sphere(15mm)", "cube(20mm) @ [x + 2.5, y, z]"):
        design = porelang.compile(f"{lattice}(10mm) & {envelope}").design()
        part = Solid(design.of(), design.bounds())
        assert walls_at(part, on_surface(part), BEARING).wall == pytest.approx(10 * across, rel=0.01)
    for text, wall in (
        ("box([30, 30, 0.7])", 0.7),
        ("box([30, 4, 0.7]) | cube(9) @ [x - 9, y, z]", 0.7),
        ("shell(sphere(10), 0.3)", 0.3),
        ("metric(gyroid(10mm)) |> shell(0.5mm) & sphere(9mm)", 0.5),
    ):
        design = porelang.compile(text).design()
        part = Solid(design.of(), design.bounds())
        assert walls_at(part, on_surface(part), BEARING).wall == pytest.approx(wall, rel=0.03)


def test_the_voxel_holds_the_walls_where_nothing_is_asked():
    found = made("shell(sphere(10), 0.3)")
    assert found.facts["wall"] == pytest.approx(0.3, rel=0.02)
    assert found.facts["voxel"] == pytest.approx(0.3 / TO_A_WALL, rel=0.02)
    assert found.surface.volume == pytest.approx(4 / 3 * np.pi * (10.15**3 - 9.85**3), rel=0.02)
    assert made("shell(sphere(10), 0.3)", voxel="auto").facts["voxel"] == found.facts["voxel"]
    plain = made("sphere(10)")
    assert plain.facts["voxel"] == pytest.approx(20 / 128, rel=1e-6)


def test_a_mesh_that_lost_a_fifth_is_refused(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("a.pore").write_text("shell(sphere(10), 0.1)\n")
    asked = ["mesh", "a.pore", "-o", "a.stl", "--voxel", "0.5mm"]
    assert main(asked) == 1
    told = capsys.readouterr().err
    assert "E118" in told
    assert "--voxel 0.04mm" in told
    assert not Path("a.stl").exists()
    assert main([*asked, "--force", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["warnings"][0]["code"] == "W202"
    program = porelang.compile("shell(sphere(10), 0.1)")
    with pytest.raises(PoreError):
        program.mesh(voxel=0.5)
    with pytest.warns(UserWarning, match="W202"):
        program.mesh(voxel=0.5, force=True)


@pytest.mark.parametrize("text", ["length(p)^60 - 5^60", "exp(20 * length(p)) - exp(100)", "sphere(5) * 1e39"])
def test_values_beyond_float32_are_taken_in_float64(text, tmp_path):
    """They were infinite in float32: no number (E110), vertices half a voxel off, or layers of two thirds of a ball."""
    found = made(text, resolution=64)
    assert found.facts["dtype"] == "f64"
    assert found.surface.volume == pytest.approx(4 / 3 * np.pi * 125, rel=0.02)
    off = np.linalg.norm(found.surface.vertices, axis=1) - 5
    assert np.abs(off).max() < 0.1 * found.facts["voxel"]
    layers = write_slices(porelang.compile(text).design(), tmp_path / "layers", 0.25)
    assert layers["volume"] == pytest.approx(4 / 3 * np.pi * 125, rel=0.02)


def test_shaders_say_what_is_too_large_for_them(gpu):
    """GLSL has no float64: where infinities make no number of it that is what is said, else W204."""
    with pytest.raises(PoreError, match="too large for float32") as caught:
        made("length(p)^60 - 5^60", resolution=32, backend="glsl")
    assert caught.value.diagnostics[0].code == "E110"
    found = made("sphere(5) * 1e39", resolution=32, backend="glsl")
    assert "W204" in codes(found)


def test_what_ordinary_parts_compute_fits_float32():
    for text in (
        "shell(gyroid(10), 0.5) & sphere(20)",
        "1 / z & cube(10)",
        "twist(gyroid(9), 1deg / 1mm) & sphere(9)",
    ):
        design = porelang.compile(text).design()
        box = design.bounds()
        assert not overflows(design.of(), box.lo, box.hi)


def test_a_coarse_voxel_is_told_with_a_place_where_it_is():
    """The thinnest walls are those of the shell, 10 mm from its middle."""
    text = "translate(shell(sphere(10), 0.3), [30, 0, 0]) | box([4, 4, 4])"
    told = made(text, voxel=1, force=True).doubts[0].hint
    at = np.array([float(v) for v in re.search(r"about 0.3 mm thick, as at \((.*)\) mm", told)[1].split(",")])
    assert np.linalg.norm(at - [30, 0, 0]) == pytest.approx(10, abs=0.16)


def test_layers_of_curved_walls_are_not_said_to_be_thin(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("ball.pore").write_text("sphere(5)", encoding="utf-8")
    assert main(["slices", "ball.pore", "-o", "layers", "--step", "2.5mm"]) == 0
    told = capsys.readouterr().err
    assert "W202" in told
    assert "coarse steps" in told
    assert "thinner" not in told


def test_layers_of_walls_thinner_than_a_pixel_are_told(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("a.pore").write_text("shell(sphere(10), 0.05)\n")
    assert main(["slices", "a.pore", "-o", "layers", "--step", "1mm", "--voxel", "1mm"]) == 0
    assert "W202" in capsys.readouterr().err
    Path("a.pore").write_text("sphere(10)\n")
    assert main(["slices", "a.pore", "-o", "layers", "--step", "0.5mm", "--voxel", "0.25mm"]) == 0
    assert "W202" not in capsys.readouterr().err


BALLS = "sphere(10) | union([for i in range(30): translate(sphere(0.3), [12 + i, 0, 0])])"
VOIDS = r"sphere(10) \ union([for i in range(8): translate(sphere(0.2), [2*i - 7, 1, 0.3])])"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "resolution", "word"),
    [(BALLS, 64, "pieces"), (BALLS, 50, "pieces"), (VOIDS, 32, "voids"), (VOIDS, 64, "voids")],
)
def test_whole_pieces_between_the_samples_are_missed(text, resolution, word):
    """However little they are of all, and also where others of them, next to them, meet a sample."""
    found = made(text, resolution=resolution)
    assert codes(found) == ["W205"]
    assert f"whole {word}, one " in found.doubts[0].message
    across = float(re.search(r"one ([\d.]+) mm across", found.doubts[0].message)[1])
    assert across == pytest.approx(0.6 if word == "pieces" else 0.4, abs=0.03)
    voxel = float(found.doubts[0].hint.split()[2].removesuffix("mm"))
    mended = made(text, voxel=voxel)  # the way out is one
    assert codes(mended) == []
    assert mended.facts["components"] == (31 if text is BALLS else 9)


def test_a_thread_of_void_is_missed():
    """A bore of 0.2 mm from the middle of a ball to its surface: 0.3 % of the cells of the mesh."""
    found = made("sphere(20) & ~cylinder(0.1, 20)", voxel=1)
    assert codes(found) == ["W205"]
    assert "the part has a gap where the mesh has none" in found.doubts[0].message


@pytest.mark.parametrize(
    ("text", "width"),
    [
        (
            "torus(15, 1) | cylinder(13.95, 1)",
            0.05,
        ),  # a loose disc in a ring came out as one body, with 0.1 % more
        ("cylinder(5, 20) | translate(cylinder(5, 20), [10.02, 0, 0])", 0.02),
        ("cylinder(5, 10) | (cylinder(9, 10) \\ cylinder(5.03, 12))", 0.03),
    ],
)
def test_a_gap_that_the_mesh_has_closed_is_told_with_its_width(text, width):
    found = made(text, voxel=0.25)
    assert found.facts["components"] == 1
    assert codes(found) == ["W205"]
    told = re.search(r"gaps?(?:, one)? about ([\d.]+) mm wide and ([\d.]+) mm long", found.doubts[0].message)
    assert float(told[1]) == pytest.approx(width, rel=0.05)
    assert float(told[2]) > 1.5
    voxel = float(re.search(r"--voxel ([\d.]+)mm", found.doubts[0].hint)[1])
    assert voxel == pytest.approx(width / TO_A_WALL, rel=0.1)


@pytest.mark.parametrize(
    "text",
    [
        "cylinder(5, 20) | translate(cylinder(5, 20), [10, 0, 0])",
        "torus(15, 1) | cylinder(14, 1)",
        "rotate(cylinder(5, 20) | translate(box([10, 10, 20]), [10, 0, 0]), [1, 2, 3], 20deg)",
        "shell(gyroid(10), 0.8) & sphere(12) | shell(sphere(12), 0.8)",
    ],
)
def test_what_touches_has_no_gap(text):
    """Along a line of contact the void has all widths down to 0: no voxel would show them all."""
    assert not any("gap" in d.message for d in made(text, voxel=0.25).doubts)


@pytest.mark.slow
def test_what_a_boundary_cuts_off_a_lattice_is_no_missing_piece():
    """Corners of a lattice's walls, which are pieces of the part, are where it runs out; and so are its rims."""
    for name, resolution in (("fig01g_tpms", 48), ("fig04g_shell", 48), ("fig07d_aligned", 48)):
        path = Path(__file__).parent.parent / "examples" / "figures" / f"{name}.pore"
        design = porelang.compile(path=path).design()
        assert "W205" not in codes(make(design, resolution=resolution, force=True)), name
    assert codes(made("sphere(10) & (z - 8)", resolution=50)) == []


@pytest.mark.slow
def test_a_mesh_is_judged_as_it_is_written():
    """Rims that are cut sharp give back what chamfers took, and a ball of eight triangles is not the ball."""
    assert codes(made("cube(10)", resolution=3, sharp=True)) == []
    with pytest.raises(PoreError) as caught:
        made("sphere(3)", resolution=16, simplify=20)
    told = caught.value.diagnostics[0]
    assert told.code == "E118"
    assert "--simplify 20mm is larger than the part" in told.label
    assert told.hint.startswith("use a smaller --simplify")
    found = made("sphere(3)", resolution=16, simplify=20, force=True)
    assert codes(found) == ["W202"]
    assert "--simplify 20mm is larger than the part" in found.doubts[0].message
    assert codes(made("sphere(3)", resolution=30, simplify=0.02)) == []
    assert codes(made("cube(10)", resolution=10, sharp=True, simplify=1)) == []  # twelve triangles are the cube


@pytest.mark.parametrize("text", ["sphere(3)", "torus(5, 2)", "box([4, 4, 1])", "shell(sphere(10), 1)"])
def test_a_voxel_that_is_proposed_is_finer_and_mends_it(text):
    design = porelang.compile(text).design()
    voxel = max(design.bounds().size) / 3
    for _ in range(8):
        found = make(design, voxel=voxel, force=True)
        doubts = [d for d in found.doubts if d.code == "W202"]
        if not doubts:
            break
        proposed = float(doubts[0].hint.split()[2].removesuffix("mm:").removesuffix("mm"))
        assert proposed < voxel / 2
        voxel = proposed
    assert not doubts


def test_triangles_are_foreseen():
    """A vertex for each line of the grid that crosses the surface: 6 pi r^2 of a ball, and two triangles for each."""
    for text, count in (("sphere(10)", 12 * np.pi * 100), ("box([10, 20, 0.5])", 4 * (200 + 5 + 10))):
        design = porelang.compile(text).design()
        part = Solid(design.of(), design.bounds())
        assert triangles(part, thinnest(part) / 4) == pytest.approx(count, rel=0.1)
    ball = made("sphere(10)", voxel=0.25).surface
    assert len(ball.faces) == pytest.approx(12 * np.pi * 100 / 0.25**2, rel=0.02)


def test_the_voxel_makes_no_more_triangles_than_a_file_may_hold():
    """A foil has few samples and many triangles: 40 millions at 2.5 voxels to its 0.05 mm, which nobody asked for."""
    design = porelang.compile("box([100, 100, 0.05])").design()
    found = chosen(Solid(design.of(), design.bounds()))
    assert found.voxel > found.wanted
    assert 4 * 100 * 100 / found.voxel**2 == pytest.approx(MOST_TRIANGLES, rel=0.1)
    assert found.wanted == pytest.approx(0.02, rel=0.03)


BASKET = """let bowl = (sphere(30mm) \\ sphere(28.5mm)) & plane([0,0,1], 0mm)
let slots = ring(translate(box([20mm,0.4mm,60mm]), [15mm,0,-20mm]), 36)
bowl \\ (slots & plane([0,0,1], -15mm))"""


def test_the_voxel_holds_the_gaps_where_nothing_is_asked():
    """36 slots of 0.4 mm in a dome of 1.5 mm were partly bridged, without a word: the Euler number was -738. By hand it
    is 2 - 2 * 36 = -70: a dome is a ball, and each slot a handle."""
    found = made(BASKET)
    assert found.facts["gap"] == pytest.approx(0.4, rel=1e-6)
    assert found.facts["wall"] == pytest.approx(1.5, rel=0.03)
    assert found.facts["voxel_for_wall"] == pytest.approx(0.4 / TO_A_WALL, rel=1e-6)
    assert found.surface.euler == -70
    assert codes(found) == []


@pytest.mark.parametrize("voxel", [0.469, 0.6])
def test_gaps_that_are_bridged_in_many_places_are_told(voxel):
    """Each bridge is shorter than a voxel or two, and the volume is right to 0.6 %."""
    found = made(BASKET, voxel=voxel)
    assert codes(found) == ["W205"]
    told = re.search(r"gaps about 0.4 mm wide are bridged in many places, as at \((.*)\) mm", found.doubts[0].message)
    at = np.array([float(v) for v in told[1].split(",")])
    assert 28.4 < np.linalg.norm(at) < 30.1  # in the dome, in the middle of a slot
    assert at[2] < -14.9
    turned = np.arctan2(at[1], at[0]) / np.deg2rad(10)
    assert abs(turned - round(turned)) * np.deg2rad(10) * np.hypot(at[0], at[1]) < 0.05
    proposed = float(re.search(r"--voxel ([\d.]+)mm", found.doubts[0].hint)[1])
    assert proposed == pytest.approx(0.4 / TO_A_WALL, rel=0.1)


def test_walls_that_have_holes_in_many_places_are_told():
    """The solid that such gaps are in, turned inside out: 0.4 mm in a voxel of 0.469 mm."""
    combs = "rotate(union([for i in range(7): translate(box([0.4, 20, 20]), [3*i - 9, 0, 0])]), [0, 0, 1], 20deg)"
    found = made(f"box([30, 30, 30]) |> translate([0, 0, 24]) | {combs}", voxel=0.469)
    assert codes(found) == ["W205"]
    assert "walls about 0.4 mm thick have holes" in found.doubts[0].message


@pytest.mark.parametrize(
    ("text", "gap"),
    [
        ("box([20,20,20]) \\ box([0.15,30,30])", 0.15),  # two halves
        ("cylinder(5, 10) | (cylinder(9, 10) \\ cylinder(5.06, 12))", 0.06),
        ("box([20,20,2]) | translate(box([20,20,2]), [0,0,2.1])", 0.1),
        ("box([20,20,20]) \\ box([5,30,30])", None),  # wider than asks for anything
        ("gyroid(4) & cube(20)", None),  # pores
        ("shell(gyroid(5mm), 0.6) & sphere(10mm)", None),
        ("sphere(5) | translate(sphere(5), [10, 0, 0])", None),  # round a point of contact
        ("sphere(5) | translate(cube(5), [0, 0, 7.4])", None),
    ],
)
def test_the_narrowest_gaps_are_found(text, gap):
    design = porelang.compile(text).design()
    found = chosen(Solid(design.of(), design.bounds())).gap
    assert found == (None if gap is None else pytest.approx(gap, rel=0.03))


def test_a_gap_ends_at_the_part_and_not_at_its_box():
    """A cut next to a face of the bounds leaves void between the part and the box, which has one side."""
    part = Solid(porelang.compile("box([20,20,20])").design().of(), ((-11, -11, -11), (10.05, 11, 11)))
    at = np.array([[10.0, 1.0, 2.0]])
    assert np.isnan(part.walls(at, 1.0, 40, void=True)[0]).all()


def test_gaps_that_fill_a_mesh_are_named_and_not_walls():
    slots = "union([for i in range(9): translate(box([0.2, 30, 30]), [2*i - 7.5, 0, 0])])"
    told = made(f"box([20,20,20]) \\ {slots} | translate(box([20,20,1]), [0,0,10])", voxel=0.9).doubts[0]
    assert told.code == "W202"
    at = re.search(r"--voxel 0.08mm: the narrowest gaps are about 0.2 mm wide, as at \((.*)\) mm", told.hint)[1]
    x = float(at.split(",")[0])
    assert abs(abs((x + 7.5 + 1) % 2 - 1) - 0.1) < 1e-6  # on a side of a slot


# --- crossings -------------------------------------------------------------------------------------------------------


def crosses(surface):
    """Which triangles cross another, one pair after another (Moeller & Trumbore 1997)."""
    v, out = surface.vertices[surface.faces], np.zeros(len(surface.faces), np.bool_)

    def through(p, q, t):
        d, e, f = q - p, t[1] - t[0], t[2] - t[0]
        h = np.cross(d, f)
        a = e @ h
        if abs(a) < 1e-12:
            return False
        w = p - t[0]
        u, r = (w @ h) / a, np.cross(w, e)
        return u > 1e-9 and (d @ r) / a > 1e-9 and u + (d @ r) / a < 1 - 1e-9 and 1e-9 < (f @ r) / a < 1 - 1e-9

    for i in range(len(v)):
        for j in range(i + 1, len(v)):
            if len(set(surface.faces[i]) & set(surface.faces[j])) < 2 and any(
                through(v[a][k], v[a][(k + 1) % 3], v[b]) for a, b in ((i, j), (j, i)) for k in range(3)
            ):
                out[i] = out[j] = True
    return out


def test_crossings_are_those_of_every_pair():
    random = np.random.default_rng(3)
    for spread in (0.3, 0.6, 1.0):
        at = random.uniform(0, spread, (40, 1, 3)) + random.uniform(0, 0.4, (40, 3, 3))
        soup = Surface(at.reshape(-1, 3), np.arange(120, dtype=np.int32).reshape(-1, 3))
        assert crossed(soup).tolist() == crosses(soup).tolist()
        some = np.arange(0, 40, 7)
        assert crossed(soup, some)[some].tolist() == crosses(soup)[some].tolist()


def test_two_balls_cross_and_touching_pyramids_do_not():
    ball = made("sphere(5)", resolution=12).surface
    n = len(ball.vertices)
    both = Surface(
        np.concatenate([ball.vertices, ball.vertices + np.array([4.0, 0.1, 0.2])]),
        np.concatenate([ball.faces, ball.faces + n]),
    )
    found = crossed(both)
    assert 0 < found.sum() < 200
    assert not crossed(ball).any()
    assert not crossed(pyramids(0.0)).any()


@pytest.mark.parametrize("how", [{"smooth": True}, {"sharp": True}])
def test_thin_shells_do_not_cross_themselves(how):
    """Newton's method carried the two sides of a wall past each other: 41 of 300 triangles crossed others."""
    found = made("shell(sphere(10), 0.1)", voxel=0.5, force=True, **how)
    assert found.facts["crossed"] == 0
    assert not crossed(found.surface).any()
    assert "W207" not in codes(found)


@pytest.mark.slow
def test_sharp_wedges_do_not_cross_themselves():
    found = made("shell(gyroid(10mm), 0.6) & sphere(10mm)", resolution=27, sharp=True, force=True)
    assert found.facts["crossed"] == 0
    assert found.facts["rim_edges"] > 1000


def test_what_crosses_all_the_same_is_told():
    found = made("round(x/2) * round(y/2) - z", bounds=CUBE, resolution=10, sharp=True)
    assert found.facts["crossed"] == crossed(found.surface).sum() > 0
    assert codes(found) == ["W207"]


@pytest.mark.parametrize(
    "text",
    [
        "sphere(5) | translate(sphere(5), [10, 0, 0])",
        "ring(translate(sphere(3), [6, 0, 0]), 6)",
        "box([10, 10, 10]) | translate(sphere(4), [0, 0, 9])",
    ],
)
def test_solids_that_touch_have_no_gap_between_them(text):
    """Next to a point of contact they are as near as one likes: a voxel was proposed that makes 10^12 samples."""
    assert not [d for d in made(text).doubts if "gap" in d.message]
