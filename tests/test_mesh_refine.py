"""Vertices on the field, sharp rims and fewer triangles: against closed forms, and sound after each."""

from __future__ import annotations

import contextlib
import json

import numpy as np
import pytest

import porelang
from porelang.cli import main
from porelang.mesh.simplify import distance
from porelang.surface import grid_of, mesh_output, refine


def refined(text, resolution, bounds=None, dtype="f32", backend="numpy", **how):
    """The mesh before and after, the facts, and the voxel."""
    program = porelang.compile(text)
    surface = mesh_output(program, resolution=resolution, bounds=bounds, dtype=dtype, backend=backend)
    grid, cut = grid_of(program, resolution=resolution, bounds=bounds)
    done = refine(surface, program, None, grid, cut, **how)
    assert done.surface.check() == []
    return surface, done.surface, done.facts, grid.spacing


def gyroid(v, w):
    x, y, z = (2 * np.pi / w * v).T
    return np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)


def to_segments(points, starts, ends):
    """The distance of each point (n, 3) from the nearest of the segments."""
    side = ends - starts
    least = np.full(len(points), np.inf)
    for i, p in enumerate(points):
        part = np.clip(np.einsum("ij,ij->i", p - starts, side) / np.einsum("ij,ij->i", side, side), 0, 1)
        least[i] = np.linalg.norm(p - starts - part[:, None] * side, axis=1).min()
    return least


def edges_near(surface, points, reach):
    """The edges of triangles that lie within `reach` of the box round some points."""
    v = surface.vertices[surface.faces]
    lo, hi = points.min(axis=0) - reach, points.max(axis=0) + reach
    v = v[((v >= lo) & (v <= hi)).all(axis=2).all(axis=1)]
    return v.reshape(-1, 3), np.roll(v, -1, axis=1).reshape(-1, 3)


# --- smooth ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", ["f32", "f64"])
def test_vertices_of_a_sphere_lie_on_it_to_rounding(dtype):
    raw, smooth, facts, h = refined("sphere(10)", 20, dtype=dtype, smooth=True)
    assert np.abs(np.linalg.norm(raw.vertices, axis=1) - 10).max() > 1e-3 * h
    assert np.abs(np.linalg.norm(smooth.vertices, axis=1) - 10).max() < 1e-12
    assert facts["off_surface"] < 1e-12
    assert facts["kept"] == 0
    assert np.array_equal(raw.faces, smooth.faces)


def test_the_error_at_the_vertices_falls_faster_than_the_cube_of_the_voxel():
    """The square of the voxel before; on the torus itself, to rounding, after."""

    def off(surface):
        v = surface.vertices
        return np.abs(np.hypot(np.hypot(v[:, 0], v[:, 1]) - 8, v[:, 2]) - 3).max()

    found = [refined("torus(8, 3)", n, dtype="f64", smooth=True) for n in (16, 24, 36, 54)]
    sizes = [h for *_, h in found]
    before, after = [off(raw) for raw, *_ in found], [off(smooth) for _, smooth, *_ in found]
    assert 1.5 < np.polyfit(np.log(sizes), np.log(before), 1)[0] < 2.5
    assert max(after) < 1e-12 < 1e-3 * sizes[-1] ** 3


def test_a_gyroid_cut_by_a_box_is_met_but_for_vertices_that_are_counted():
    raw, smooth, facts, _ = refined("gyroid(10)", 24, bounds=(-7, -7, -7, 7, 7, 7), smooth=True)
    free = np.abs(raw.vertices).max(axis=1) < 7
    off = np.abs(gyroid(smooth.vertices[free], 10))
    # By the caps the triangles are a hair wide, and their vertices stay lest they turn over.
    assert (off > 1e-9).sum() <= facts["kept"] < 0.2 * len(raw.vertices)
    assert off[np.abs(raw.vertices[free]).max(axis=1) < 6].max() < 1e-9
    assert np.median(np.abs(gyroid(raw.vertices[free], 10))) > 1e-4


def test_caps_stay_flat_and_on_the_bound():
    raw, smooth, _, _ = refined("gyroid(10)", 24, bounds=(-7, -7, -7, 7, 7, 7), smooth=True)
    on = np.abs(raw.vertices) == 7
    assert on.any(axis=0).all()
    assert np.array_equal(raw.vertices[on], smooth.vertices[on])
    assert np.abs(smooth.vertices).max() == 7


def test_no_triangle_turns_over():
    raw, smooth, _, _ = refined("gyroid(10) |> shell(0.6) & cylinder(9, 12)", 40, smooth=True)
    assert (np.einsum("ij,ij->i", raw.normals(), smooth.normals()) > 0).all()


# --- sharp -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("resolution", [20, 33])
def test_the_rim_of_a_cylinder_is_edges_of_the_mesh_within_a_tenth_of_a_voxel(resolution):
    raw, sharp, facts, h = refined("cylinder(10, 20)", resolution, sharp=True)
    turn = np.linspace(0, 2 * np.pi, 500)
    for end in (-10, 10):
        rim = np.stack([10 * np.cos(turn), 10 * np.sin(turn), np.full_like(turn, end)], axis=1)
        off = to_segments(rim, *edges_near(sharp, rim, h))
        assert off.max() < h / 10
        assert to_segments(rim, *edges_near(raw, rim, h)).max() > h / 10  # which it is not without
    assert facts["rim_edges"] > 2 * np.pi * 10 / h
    # What is left is the volume between a circle and its polygons: its curvature, not its rim.
    assert 0 < 2000 * np.pi - sharp.volume < 0.5 * (2000 * np.pi - raw.volume)


@pytest.mark.parametrize("backend", ["numpy", "glsl"])
def test_the_rim_between_a_lattice_and_its_envelope(backend):
    _, sharp, _, h = refined("gyroid(10) & cylinder(10, 20)", 40, backend=backend, sharp=True)
    rim = []
    for turn in np.linspace(0.01, 2 * np.pi, 60):  # where the gyroid changes sign along a line of the cylinder
        z = np.linspace(-8, 8, 4001)
        line = np.stack([np.full_like(z, 10 * np.cos(turn)), np.full_like(z, 10 * np.sin(turn)), z], axis=1)
        value = gyroid(line, 10)
        at = np.flatnonzero(np.sign(value[1:]) != np.sign(value[:-1]))
        rim += [line[i] + (line[i + 1] - line[i]) * value[i] / (value[i] - value[i + 1]) for i in at]
    rim = np.array(rim)
    steps = 1e-4 * np.eye(3)
    slope = np.stack([gyroid(rim + s, 10) - gyroid(rim - s, 10) for s in steps], axis=1)
    outward = rim * [0.1, 0.1, 0]
    # Where the two surfaces meet at less than 40 degrees a chamfer is told from a curve with less certainty.
    angle = np.einsum("ij,ij->i", slope, outward) / np.linalg.norm(slope, axis=1)
    rim = rim[angle < np.cos(np.radians(40))]
    off = to_segments(rim, *edges_near(sharp, rim, h))
    assert len(rim) > 80
    assert np.quantile(off, 0.85) < h / 10
    assert off.max() < h


@pytest.mark.parametrize("text", ["box([10, 12, 14])", "box([10, 12, 14]) |> rotate([1, 2, 3], 40deg)"])
def test_a_box_gets_its_volume_back(text):
    raw, sharp, facts, _ = refined(text, 30, sharp=True)
    assert sharp.volume == pytest.approx(1680, rel=2e-4)
    assert raw.volume < 1680 * 0.997
    assert facts["corners"] <= 8


def test_smooth_surfaces_have_no_rims():
    for text in ("sphere(10)", "torus(8, 3)", "gyroid(10) |> smooth_intersection(sphere(9), 4)"):
        assert refined(text, 32, sharp=True)[2]["rim_edges"] == 0, text


def test_caps_stay_flat_when_rims_are_cut():
    _, sharp, _, _ = refined("cylinder(5, 40)", 30, bounds=(-8, -8, -8, 8, 8, 8), sharp=True)
    assert np.abs(sharp.vertices[:, 2]).max() == 8
    assert sharp.volume == pytest.approx(16 * 25 * np.pi, rel=5e-3)


# --- simplify --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("deviation", [0.02, 0.1])
def test_a_simpler_sphere_stays_within_the_deviation(deviation):
    raw, simple, facts, _ = refined("sphere(10)", 30, smooth=True, deviation=deviation)
    assert len(simple.faces) < len(raw.faces) * 0.6
    assert facts["triangles_before"] == len(raw.faces)
    assert facts["deviation"] <= deviation
    # Against the sphere itself: the mesh before was already off by its chords.
    rng = np.random.default_rng(1)
    weights = rng.dirichlet(np.ones(3), len(simple.faces))
    points = np.einsum("nk,nki->ni", weights, simple.vertices[simple.faces])
    chord = 10 - np.linalg.norm(raw.vertices[raw.faces].mean(axis=1), axis=1).min()
    assert np.abs(np.linalg.norm(points, axis=1) - 10).max() < deviation + chord
    assert simple.euler == 2


def test_a_sharp_box_becomes_a_few_triangles():
    _, simple, facts, _ = refined("box([10, 12, 14])", 30, sharp=True, deviation=0.01)
    assert len(simple.faces) < 100
    assert simple.volume == pytest.approx(1680, rel=2e-3)
    assert facts["deviation"] <= 0.01


def test_the_distance_of_two_spheres_is_the_difference_of_their_radii():
    one, other = (refined(f"sphere({r})", 24, smooth=True)[1] for r in (10, 10.5))
    assert distance(one, other) == pytest.approx(0.5, abs=0.03)


# --- the command -----------------------------------------------------------------------------------------------------


def test_the_command_reports_what_it_did(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.pore").write_text("cylinder(10, 20)")
    words = ["mesh", "a.pore", "-o", "a.3mf", "--resolution", "20", "--sharp", "--simplify", "0.2mm", "--json"]
    assert main(words) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["deviation"] <= 0.2
    assert found["triangles"] < found["triangles_before"]
    assert found["off_surface"] < 1e-9
    assert found["rim_edges"] > 100
    assert main(["mesh", "a.pore", "-o", "b.stl", "--simplify=-1mm"]) == 2
    assert "above 0" in capsys.readouterr().err
    assert not (tmp_path / "b.stl").exists()


def test_ctrl_c_leaves_no_file(tmp_path, monkeypatch):
    import porelang.surface as world

    def stop(*args):
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.pore").write_text("cylinder(10, 20)")
    monkeypatch.setattr(world, "simplify", stop)
    with contextlib.suppress(KeyboardInterrupt):
        main(["mesh", "a.pore", "-o", "a.stl", "--resolution", "20", "--simplify", "0.2mm"])
    assert [p.name for p in tmp_path.iterdir()] == ["a.pore"]
