"""Vertices on the field, sharp rims and fewer triangles: against closed forms, and sound after each."""

from __future__ import annotations

import contextlib
import json
from concurrent.futures import CancelledError

import numpy as np
import pytest
from scipy.spatial import cKDTree
from trimesh.triangles import closest_point

import porelang
from porelang.analysis.branches import Branches
from porelang.cli import main
from porelang.mesh.part import grid_of, refine, surface_of
from porelang.mesh.simplify import simplify
from porelang.mesh.surface import Surface, single
from porelang.mesh.within import within
from porelang.progress import watching


def refined(text, resolution, bounds=None, dtype="f32", backend="numpy", **how):
    """The mesh before and after, the facts, and the voxel."""
    design = porelang.compile(text).design()
    placed = grid_of(design, resolution=resolution, bounds=bounds)
    surface = surface_of(design, None, placed, backend, dtype)
    done = refine(surface, design, None, placed, **how)
    assert done.surface.check() == []
    return surface, done.surface, done.facts, placed.grid.spacing


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
    """Before, a chord's: h^2 / 8 over the radius of the tube, less where the bend is asked for; to rounding after."""

    def off(surface):
        v = surface.vertices
        return np.abs(np.hypot(np.hypot(v[:, 0], v[:, 1]) - 8, v[:, 2]) - 3).max()

    found = [refined("torus(8, 3)", n, dtype="f64", smooth=True) for n in (16, 24, 36, 54)]
    sizes = np.array([h for *_, h in found])
    before, after = np.array([off(raw) for raw, *_ in found]), [off(smooth) for _, smooth, *_ in found]
    share = before / (sizes**2 / 24)
    assert (share < 1.01).all()
    assert (share[-2:] > 0.9).all()
    assert max(after) < 1e-12 < 1e-3 * sizes[-1] ** 3


def test_the_error_between_the_vertices_falls_with_the_square_of_the_voxel():
    off, sizes = [], []
    for n in (16, 24, 36, 54):
        _, smooth, _, h = refined("torus(8, 3)", n, dtype="f64", smooth=True)
        v = smooth.vertices[smooth.faces].mean(axis=1)
        off.append(np.abs(np.hypot(np.hypot(v[:, 0], v[:, 1]) - 8, v[:, 2]) - 3).max())
        sizes.append(h)
    assert 1.7 < np.polyfit(np.log(sizes), np.log(off), 1)[0] < 2.3


def test_a_gyroid_cut_by_a_box_is_met_but_for_vertices_that_are_counted():
    raw, smooth, facts, h = refined("gyroid(10)", 24, bounds=(-7, -7, -7, 7, 7, 7), smooth=True)
    off = np.abs(gyroid(smooth.vertices, 10))
    free = np.abs(raw.vertices).max(axis=1) < 7
    assert (off[free] > 1e-9).sum() <= facts["kept"] < 0.01 * len(raw.vertices)
    # In a cap nothing is to be met; on its rim, where its triangles end, the gyroid is.
    for axis in range(3):
        on = np.abs(raw.vertices[:, axis]) == 7
        flat = on[raw.faces].all(axis=1)
        rim = np.intersect1d(raw.faces[flat], raw.faces[~flat])
        rim = rim[(np.abs(raw.vertices[rim]) > 6.9).sum(axis=1) == 1]
        assert len(rim) > 50
        assert np.quantile(off[rim], 0.9) < 1e-9 < np.median(np.abs(gyroid(raw.vertices[rim], 10)))
        assert off[rim].max() < 0.02 * h  # the root was beyond the end of the edge


def test_caps_stay_flat_and_on_the_bound():
    raw, smooth, _, _ = refined("gyroid(10)", 24, bounds=(-7, -7, -7, 7, 7, 7), smooth=True)
    on = np.abs(raw.vertices) == 7
    assert on.any(axis=0).all()
    assert np.array_equal(raw.vertices[on], smooth.vertices[on])
    assert np.abs(smooth.vertices).max() == 7


@pytest.mark.parametrize("text", ["gyroid(10) |> shell(0.6) & cylinder(9, 12)", "gyroid(10) & cylinder(9, 12)"])
def test_where_surfaces_meet_no_vertex_stays_off_the_field(text):
    _, smooth, facts, _ = refined(text, 40, smooth=True)
    assert facts["kept"] == 0
    assert np.abs(porelang.compile(text).field(dtype="f64")(smooth.vertices)).max() < 1e-9


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


W, T, R, H = 30, 1.53, 45, 75  # a sheet in a cylinder of half the height H


def slope_of_gyroid(v):
    x, y, z = (2 * np.pi / W * v).T
    return (2 * np.pi / W) * np.stack([
        np.cos(x) * np.cos(y) - np.sin(z) * np.sin(x),
        np.cos(y) * np.cos(z) - np.sin(x) * np.sin(y),
        np.cos(z) * np.cos(x) - np.sin(y) * np.sin(z),
    ], axis=1)  # fmt: skip


def true_rims():
    """Points on the rims of the sheet in the cylinder, by Newton's method on two closed forms at once."""
    rng = np.random.default_rng(2)
    turn, high, far = rng.uniform(0, 2 * np.pi, 6000), rng.uniform(-H, H, 6000), R * np.sqrt(rng.uniform(0, 1, 6000))
    around = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    found = {"wall": [], "cap": [], "circle": []}
    for side in (-1, 1):
        for kind, p in (("wall", R * around + high[:, None] * up), ("cap", far[:, None] * around + side * H * up)):
            for sign in (-1, 1) if kind == "cap" else (side,):
                p = p.copy()
                for _ in range(30):
                    r = np.hypot(p[:, 0], p[:, 1])
                    other = r - R if kind == "wall" else p[:, 2] - side * H
                    normal = p * [1, 1, 0] / r[:, None] if kind == "wall" else np.tile(up, (len(p), 1))
                    off = np.stack([gyroid(p, W) - sign * T / 2, other], axis=1)
                    rows = np.stack([slope_of_gyroid(p), normal], axis=1)
                    p -= np.einsum("nij,nj->ni", np.linalg.pinv(rows), off)
                good = (np.abs(off).max(axis=1) < 1e-9) & (np.abs(p[:, 2]) < H + 1e-9) & (r < R + 1e-9)
                found[kind].append(p[good])
        circle = R * around + side * H * up
        found["circle"].append(circle[np.abs(gyroid(circle, W)) < T / 2])
    return {kind: np.concatenate(points) for kind, points in found.items()}


def creases(surface, one, other):
    """The edges of a mesh whose ends lie on two surfaces, both given as what is 0 on them at its vertices."""
    on = (np.abs(one) < 1e-7) & (np.abs(other) < 1e-7)
    ends = np.concatenate([surface.faces[:, [i, (i + 1) % 3]] for i in range(3)])
    ends = ends[(ends[:, 0] < ends[:, 1]) & on[ends].all(axis=1)]
    return surface.vertices[ends[:, 0]], surface.vertices[ends[:, 1]]


def off_rim(points, starts, ends):
    """The distance of each point from the nearest of the segments whose middles are nearest."""
    tree = cKDTree((starts + ends) / 2)
    _, near = tree.query(points, k=8)
    side = ends - starts
    to = points[:, None] - starts[near]
    part = np.clip(np.einsum("nki,nki->nk", to, side[near]) / (side[near] ** 2).sum(axis=2), 0, 1)
    return np.linalg.norm(to - part[:, :, None] * side[near], axis=2).min(axis=1)


@pytest.fixture(scope="module")
def sheet():
    """The sheet in the cylinder at 20 voxels a period, and what is 0 on its three surfaces at the vertices."""
    raw, sharp, facts, h = refined(f"gyroid({W}) |> shell({T}) & cylinder({R}, {2 * H})", 100, sharp=True)
    v = sharp.vertices
    lattice = np.abs(gyroid(v, W)) - T / 2
    return raw, sharp, facts, h, lattice, np.hypot(v[:, 0], v[:, 1]) - R, np.abs(v[:, 2]) - H


@pytest.mark.slow
def test_the_rims_of_a_lattice_in_its_envelope_are_creases_within_a_tenth_of_a_voxel(sheet):
    _, sharp, facts, h, lattice, wall, cap = sheet
    assert h == pytest.approx(W / 20)
    rims = true_rims()
    pairs = {"wall": (lattice, wall), "cap": (lattice, cap), "circle": (wall, cap)}
    for kind, points in rims.items():
        assert len(points) > 1000
        if kind == "circle":  # a sheet that is thinner than a voxel there leaves no trace on the grid
            room = (T / 2 - np.abs(gyroid(points, W))) / np.linalg.norm(slope_of_gyroid(points), axis=1)
            points = points[room > h]
        near = off_rim(points, *creases(sharp, *pairs[kind])) < h / 10
        assert near.mean() > (0.98 if kind == "circle" else 0.99), kind
    corner = (np.abs(np.stack([lattice, wall, cap])) < 1e-7).all(axis=0)
    turn = np.linspace(0, 2 * np.pi, 200001)
    circle = np.stack([R * np.cos(turn), R * np.sin(turn), np.full_like(turn, H)], axis=1)
    true = sum((np.diff(np.sign(np.abs(gyroid(circle * [1, 1, s], W)) - T / 2)) != 0).sum() for s in (-1, 1))
    assert abs(corner.sum() - true) <= 0.05 * true
    assert abs(facts["corners"] - true) <= 0.05 * true


@pytest.mark.slow
def test_sharp_triangles_face_the_surface_that_they_are_on(sheet):
    _, sharp, _, _, *offs = sheet
    corners = sharp.vertices[sharp.faces]
    middle = corners.mean(axis=1)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sizes = np.linalg.norm(normal, axis=1)
    outward = (
        np.sign(gyroid(middle, W))[:, None] * slope_of_gyroid(middle),
        middle * [1, 1, 0],
        np.sign(middle[:, 2])[:, None] * [0, 0, 1],
    )
    for off, away in zip(offs, outward, strict=True):
        mine = (np.abs(off[sharp.faces]) < 1e-7).all(axis=1)
        assert mine.sum() > 500
        turned = np.einsum("ij,ij->i", normal[mine], away[mine]) <= 0
        assert turned.mean() < 1e-3  # between three points of one curved rim a triangle may face anywhere
        assert sizes[mine][turned].sum() < 1e-5 * sizes.sum()
    assert sharp.check_vertices(single(1.0)) == []  # in a file of 32-bit numbers too


def test_a_hole_has_a_rim_too():
    """max(a, -b): outside b its distance is a root of squares, and that branch goes on smoothly past its edge."""
    _, sharp, _, _ = refined("box([20, 20, 10]) \\ box([8, 10, 30])", 40, sharp=True)
    assert sharp.volume == pytest.approx(10 * (400 - 80), rel=1e-4)


@pytest.mark.parametrize(
    ("text", "circles"),
    [
        ("cone(10, 3, 20)", [(10, -10), (3, 10)]),  # whose distance has no sign of its own
        ("sphere(10) \\ cylinder(6, 40)", [(6, 8), (6, -8)]),
        ("translate(sphere(10), [0, 0, 6]) | translate(sphere(10), [0, 0, -6])", [(8, 0)]),  # not convex
        ("sphere(10) & slab([0, 0, 1], 10)", [(75**0.5, 5), (75**0.5, -5)]),
    ],
)
def test_circles_where_shapes_meet_are_creases(text, circles):
    _, sharp, facts, h = refined(text, 40, sharp=True)
    assert facts["kept"] == 0
    turn = np.linspace(0, 2 * np.pi, 500)
    for radius, height in circles:
        rim = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.full_like(turn, height)], axis=1)
        v = sharp.vertices
        assert off_rim(rim, *creases(sharp, np.hypot(v[:, 0], v[:, 1]) - radius, v[:, 2] - height)).max() < h / 10


def test_a_branch_is_the_field_where_it_is_taken_and_smooth_beyond():
    program = porelang.compile("(gyroid(10) |> shell(0.6)) & cylinder(9, 12) \\ box([4, 4, 20])")
    branches = Branches(program.design().of())
    points = np.random.default_rng(5).uniform(-10, 10, (5000, 3))
    value, gradient = branches.slope(points)
    numbers = branches.of(points)
    own = branches.held(points, numbers)
    assert np.allclose(own[0], value, atol=1e-12)
    assert np.allclose(own[1], gradient, atol=1e-9)
    assert np.allclose(value, program.field(dtype="f64")(points), atol=1e-12)
    steps = np.linspace(-1, 1, 201)
    for at, number in zip(points[::500], numbers[::500], strict=True):
        line = at + steps[:, None] * [0.9, 0.3, 0.2]
        slopes = branches.held(line, np.full(len(line), number))[1]
        assert np.linalg.norm(np.diff(slopes, axis=0), axis=1).max() < 0.2  # a kink would leap by about 1


@pytest.mark.slow
def test_a_lattice_cut_by_bounds_has_sharp_rims():
    _, sharp, facts, h = refined("gyroid(10)", 40, bounds=(-7, -7, -7, 7, 7, 7), sharp=True)
    v = sharp.vertices
    line = np.linspace(-6.9, 6.9, 4001)
    for height in (-7, 7):
        cut = np.stack(np.meshgrid(np.linspace(-6.5, 6.5, 40), line, [height], indexing="ij"), axis=-1)[:, :, 0]
        value = gyroid(cut.reshape(-1, 3), 10).reshape(cut.shape[:2])
        i, j = np.nonzero(np.diff(np.sign(value), axis=1))
        rim = (cut[i, j] + cut[i, j + 1]) / 2
        off = off_rim(rim, *creases(sharp, gyroid(v, 10), v[:, 2] - height))
        assert (off < h / 10).mean() > 0.99
    assert facts["corners"] >= 8


def test_without_a_choice_in_the_field_nothing_is_cut():
    _, sharp, facts, _ = refined("torus(8, 3)", 24, sharp=True)
    _, same, _, _ = refined("torus(8, 3)", 24, smooth=True)
    assert np.array_equal(sharp.vertices, same.vertices)
    assert np.array_equal(sharp.faces, same.faces)
    assert facts["rim_edges"] == 0


@pytest.mark.parametrize("text", ["box([10, 12, 14])", "box([10, 12, 14]) |> rotate([1, 2, 3], 40deg)"])
def test_a_box_gets_its_volume_back(text):
    raw, sharp, facts, _ = refined(text, 30, sharp=True)
    assert sharp.volume == pytest.approx(1680, rel=2e-4)
    assert raw.volume < 1680 * 0.999
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
@pytest.mark.slow
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


def sampled(one, other, count=50_000):
    """The largest distance of points strewn over one mesh from the other, by trimesh's distance from a triangle."""
    rng = np.random.default_rng(3)
    area = one.areas()
    which = rng.choice(len(area), count, p=area / area.sum())
    points = np.einsum("nk,nki->ni", rng.dirichlet(np.ones(3), count), one.vertices[one.faces[which]])
    corners = other.vertices[other.faces]
    near = cKDTree(corners.mean(axis=1)).query(points, k=8)[1]
    least = np.full(count, np.inf)
    for k in range(near.shape[1]):
        least = np.minimum(least, np.linalg.norm(closest_point(corners[near[:, k]], points) - points, axis=1))
    worst = np.argsort(least)[-50:]  # the nearest triangle may have its centre far off: for these, all of them
    for i in worst:
        feet = closest_point(corners, np.tile(points[i], (len(corners), 1)))
        least[i] = np.linalg.norm(feet - points[i], axis=1).min()
    return least[worst].max()


def test_two_spheres_are_apart_by_the_difference_of_their_radii():
    one, other = (refined(f"sphere({r})", 24, smooth=True)[1] for r in (10, 10.5))
    for a, b in ((one, other), (other, one)):
        bound, far = within(a, b, 0.6)
        assert len(far) == 0
        assert 0.5 - 0.03 < bound <= 0.6
        assert len(within(a, b, 0.45)[1]) > 0.9 * len(a.faces)


def test_what_no_corner_middle_or_centre_shows_is_found_between_them():
    """A dent that the corners, middles and centre of a large triangle all miss."""
    flat = np.array([[0, 0, 0], [12, 0, 0], [0, 12, 0]], float)
    spike = np.array([2.0, 7.0, 0.0])
    n = 60
    i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
    number = np.full((n + 1, n + 1), -1)
    number[i + j <= n] = np.arange((i + j <= n).sum())
    points = np.stack([i, j, 0 * i], axis=2)[i + j <= n] * (12 / n)
    points[:, 2] = -0.5 * np.maximum(0, 1 - np.linalg.norm(points - spike, axis=1) / 0.6)
    lower, upper = [], []
    for a in range(n):
        for b in range(n - a):
            lower.append((number[a, b], number[a + 1, b], number[a, b + 1]))
            if a + b < n - 1:
                upper.append((number[a + 1, b], number[a + 1, b + 1], number[a, b + 1]))
    dented = Surface(points, np.array(lower + upper, np.int32))
    one = Surface(flat, np.array([[0, 1, 2]], np.int32))
    assert list(within(one, dented, 0.3)[1]) == [0]
    assert len(within(dented, one, 0.3)[1]) > 0
    bound, far = within(dented, one, 0.55)
    assert len(far) == 0
    assert bound >= -points[:, 2].min()


@pytest.mark.slow
def test_a_simpler_lattice_is_nowhere_further_than_its_bound():
    deviation = 0.02
    _, simple, facts, _ = refined("gyroid(10) |> shell(0.6) & cylinder(9, 12)", 60, sharp=True, deviation=deviation)
    _, sharp, _, _ = refined("gyroid(10) |> shell(0.6) & cylinder(9, 12)", 60, sharp=True)
    assert len(simple.faces) < 0.8 * len(sharp.faces)
    assert facts["deviation"] <= deviation
    assert 0 < sampled(simple, sharp) <= facts["deviation"]
    assert 0 < sampled(sharp, simple) <= facts["deviation"]
    r, z = np.hypot(simple.vertices[:, 0], simple.vertices[:, 1]), np.abs(simple.vertices[:, 2])
    assert ((np.abs(r - 9) < deviation) & (np.abs(z - 6) < deviation)).sum() > 20  # rims are still there


def test_a_cancelled_refinement_stops():
    design = porelang.compile("sphere(10)").design()
    placed = grid_of(design, resolution=20)
    surface = surface_of(design, placed=placed)
    with watching(cancel=lambda: True), pytest.raises(CancelledError):
        simplify(surface, 0.1)
    calls = []
    with watching(lambda *told: calls.append(told)):
        refine(surface, design, None, placed, deviation=0.1)
    assert calls[-1] == ("refining", 1, 1)
    assert len(calls) > 2


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
    import porelang.mesh.part as world

    def stop(*args):
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.pore").write_text("cylinder(10, 20)")
    monkeypatch.setattr(world, "simplify", stop)
    with contextlib.suppress(KeyboardInterrupt):
        main(["mesh", "a.pore", "-o", "a.stl", "--resolution", "20", "--simplify", "0.2mm"])
    assert [p.name for p in tmp_path.iterdir()] == ["a.pore"]
