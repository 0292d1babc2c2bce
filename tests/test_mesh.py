"""From samples to a sound mesh: closed, outward, where the field says, whatever the bricks; and whole files or none."""

from __future__ import annotations

import errno
import io
import os
from concurrent.futures import CancelledError
from pathlib import Path

import numpy as np
import pytest
import trimesh

from porelang.diagnostics import PoreError
from porelang.mesh import Grid, Surface, extract, write
from porelang.mesh.bricks import split
from porelang.mesh.export import WRITERS
from porelang.mesh.layers import clip
from porelang.progress import watching

RNG = np.random.default_rng(7)


def sampler(grid, f, dtype=np.float64):
    def sample(lo, hi):
        x, y, z = grid.axes(dtype, lo, hi)
        values = f(x[:, None, None], y[None, :, None], z[None, None, :])
        return np.broadcast_to(values, tuple(b - a for a, b in zip(lo, hi, strict=True))).astype(dtype)

    return sample


def mesh(f, half, voxel, dtype=np.float64, **more):
    """The surface of f in the box of the half sides `half`, centred on the origin."""
    hi = tuple(np.broadcast_to(np.asarray(half, float), 3).tolist())
    lo = tuple(-c for c in hi)
    grid = Grid.cover(lo, hi, voxel)
    return extract(grid, (lo, hi), sampler(grid, f, dtype), **more)


def mesh_of_cells(f, n, voxel):
    """The surface of a lattice of period 10 in a block of n^3 cells."""
    half = 5.0 * n
    return mesh(lambda x, y, z: f(x + half, y + half, z + half), half, voxel)


def of_array(values, **more):
    """The surface of an array of values on nodes 1 mm apart."""
    grid = Grid((0.0, 0.0, 0.0), 1.0, values.shape)
    hi = tuple(float(n - 1) for n in values.shape)

    def sample(a, b):
        return values[a[0] : b[0], a[1] : b[1], a[2] : b[2]]

    return extract(grid, ((0.0, 0.0, 0.0), hi), sample, **more)


def sphere(r):
    return lambda x, y, z: np.sqrt(x * x + y * y + z * z) - r


def torus(big, small):
    return lambda x, y, z: np.hypot(np.hypot(x, y) - big, z) - small


def gyroid(w):
    k = 2 * np.pi / w

    def f(x, y, z):
        return np.sin(k * x) * np.cos(k * y) + np.sin(k * y) * np.cos(k * z) + np.sin(k * z) * np.cos(k * x)

    return f


def schwarz_p(w):
    k = 2 * np.pi / w
    return lambda x, y, z: np.cos(k * x) + np.cos(k * y) + np.cos(k * z)


def edges_are_shared_by_two(faces):
    """Independent of `Surface.check`: every directed edge once, and its opposite once."""
    edges = [(a, b) for t in faces.tolist() for a, b in ((t[0], t[1]), (t[1], t[2]), (t[2], t[0]))]
    once = set(edges)
    return len(once) == len(edges) and all((b, a) in once for a, b in edges)


def sound(surface):
    assert surface.check() == []
    assert surface.rounded().check() == []
    if len(surface.faces) < 20000:
        assert edges_are_shared_by_two(surface.faces)
    assert surface.areas().min() > 0
    assert surface.volume > 0
    return surface


def triangles(surface):
    """The triangles in an order of their own: each begins with its least corner, and they are sorted."""
    corners = surface.vertices[surface.faces]
    rank = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)[1].reshape(-1, 3)
    first = rank.argmin(axis=1)
    turned = np.stack([corners[np.arange(len(corners)), (first + i) % 3] for i in range(3)], axis=1).reshape(-1, 9)
    return turned[np.lexsort(turned.T)]


def rate(sizes, errors):
    return np.polyfit(np.log(sizes), np.log(errors), 1)[0]


# --- shapes and lattices ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize(
    ("f", "half", "voxel", "euler"),
    [
        (sphere(4.0), 5, 0.4, 2),
        (torus(5.0, 2.0), (7.5, 7.5, 2.5), 0.4, 0),
        (sphere(4.0), 4, 0.5, 2),  # touches its bounds
        (lambda x, y, z: np.abs(sphere(4.0)(x, y, z)) - 0.5, 5, 0.25, 4),  # a hollow ball has two surfaces
        (lambda x, y, z: np.maximum(np.maximum(np.abs(x), np.abs(y)), np.abs(z)) - 2, 3, 0.5, 2),
    ],
)
def test_shapes_are_sound_and_of_their_genus(f, half, voxel, euler, dtype):
    assert sound(mesh(f, half, voxel, dtype)).euler == euler


def test_a_gyroid_shell_in_a_cylinder_is_sound():
    def f(x, y, z):
        shell = np.abs(gyroid(10)(x, y, z)) - 0.4
        return np.maximum(shell, np.maximum(np.hypot(x, y) - 9, np.abs(z) - 12))

    sound(mesh(f, (9.5, 9.5, 12.5), 0.5, np.float32))


@pytest.mark.parametrize(("f", "per_cell"), [(schwarz_p, -4), (gyroid, -8)])
def test_the_euler_number_per_cell_is_that_of_the_minimal_surface(f, per_cell):
    """Schoen 1970: genus 3 per primitive cell, so -4; the gyroid's cubic cell holds two. Caps count in lower powers."""
    numbers = [sound(mesh_of_cells(f(10.0), n, 0.9)).euler for n in (1, 2, 3, 4)]
    assert np.diff(numbers, 3)[0] / 6 == per_cell


@pytest.mark.parametrize("n", [1, 2, 3])
def test_a_block_of_schwarz_p_has_the_genus_of_its_graph(n):
    """Solid junctions in the middle of n^3 cells, joined through faces: a handle for each cycle of that graph."""
    handles = 3 * n * n * (n - 1) - n**3 + 1
    assert sound(mesh_of_cells(schwarz_p(10.0), n, 0.7)).euler == 2 - 2 * handles


# --- nodes on the surface, ties, noise -------------------------------------------------------------------------------


@pytest.mark.parametrize("voxel", [1.0, 0.5, 1.25])
@pytest.mark.parametrize("f", [gyroid(10.0), schwarz_p(10.0), lambda x, y, z: np.abs(x) + np.abs(y) + np.abs(z) - 5])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_nodes_exactly_on_the_surface(f, voxel, dtype):
    n = int(20 / voxel) + 1
    grid = Grid((-10.0, -10.0, -10.0), voxel, (n, n, n))
    sound(extract(grid, ((-10.0,) * 3, (10.0,) * 3), sampler(grid, f, dtype), brick=7))


def test_a_box_on_the_nodes_has_its_own_volume():
    grid = Grid((-3.0, -3.0, -3.0), 0.5, (13, 13, 13))

    def f(x, y, z):
        return np.maximum(np.maximum(np.abs(x), np.abs(y)), np.abs(z)) - 2

    surface = sound(extract(grid, ((-2.0,) * 3, (2.0,) * 3), sampler(grid, f)))
    assert surface.volume == pytest.approx(64, rel=1e-5)
    assert np.abs(surface.vertices).max() == 2


NOISE = {
    "normal": lambda shape: RNG.normal(size=shape),
    "float32": lambda shape: RNG.normal(size=shape).astype(np.float32),
    "ties": lambda shape: RNG.choice([-1.0, 1.0], size=shape),
    "few": lambda shape: RNG.choice([-2.0, -1.0, 1.0, 2.0], size=shape),
    "zeros": lambda shape: RNG.choice([-1.0, 0.0, -0.0, 1.0], size=shape),
    "tiny": lambda shape: RNG.normal(size=shape) * 1e-300,
    "huge": lambda shape: (RNG.uniform(-3e38, 3e38, size=shape)).astype(np.float32),
    "wide": lambda shape: RNG.normal(size=shape) * 10.0 ** RNG.integers(-30, 30, size=shape),
    "infinite": lambda shape: RNG.choice([-np.inf, -1.0, 1.0, np.inf], size=shape),
    "sparse": lambda shape: np.where(RNG.random(shape) < 0.1, -1.0, 1e-9),
    "dense": lambda shape: np.where(RNG.random(shape) < 0.9, -1.0, 1e-9),
}


@pytest.mark.parametrize("kind", NOISE)
@pytest.mark.slow
def test_noise_of_any_kind_gives_a_sound_mesh_whatever_the_bricks(kind):
    values = NOISE[kind]((19, 17, 23))
    whole = sound(of_array(values, brick=1000))
    for brick, threads in ((5, 1), (16, 2), (17, 1)):  # 17 leaves bricks of one cell, at the bounds
        assert np.array_equal(triangles(whole), triangles(of_array(values, brick=brick, threads=threads)))


def test_what_outgrows_the_memory_goes_to_disk_and_is_the_same(tmp_path: Path):
    values = NOISE["normal"]((31, 29, 37))
    kept = of_array(values, brick=8)
    spilled = of_array(values, brick=8, memory=4096, folder=tmp_path)
    assert isinstance(spilled.vertices.base, np.memmap) or isinstance(spilled.vertices, np.memmap)
    assert np.array_equal(kept.vertices, spilled.vertices)
    assert np.array_equal(kept.faces, spilled.faces)
    assert list(tmp_path.iterdir()) == []  # the file has no name: it goes however the run ends


def test_a_disk_that_is_full_is_an_error_not_a_wrong_mesh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    class Full(io.BytesIO):
        def write(self, piece):
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("porelang.mesh.weld.tempfile.TemporaryFile", lambda dir: Full())
    said = complaint("E113", of_array, NOISE["normal"]((19, 17, 23)), brick=8, memory=4096, folder=tmp_path)
    assert str(tmp_path) in said
    assert "no space left" in said


@pytest.mark.parametrize("seed", range(5))
def test_random_smooth_fields_are_sound(seed):
    rng = np.random.default_rng(seed)
    waves, phases = rng.normal(size=(6, 3)) * 1.5, rng.uniform(0, 6.28, 6)

    def f(x, y, z):
        return sum(np.sin(k[0] * x + k[1] * y + k[2] * z + p) for k, p in zip(waves, phases, strict=True))

    sound(mesh(f, (4, 3, 5), 0.3, np.float32))


@pytest.mark.parametrize("thickness", [0.02, 0.1, 0.9, 1.1])
def test_thin_sheets_are_sound(thickness):
    normal = np.array([0.3, 0.5, 0.81])
    sound(mesh(lambda x, y, z: np.abs(x * normal[0] + y * normal[1] + z * normal[2]) - thickness / 2, 6, 1.0))


@pytest.mark.parametrize(("solid", "void", "euler"), [(-3.0, 1.0, 2), (-1.0, 3.0, 4), (-1.0, 1.0, 4)])
@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("axes", [(0, 1, 2), (1, 2, 0), (2, 0, 1)])
def test_a_face_with_a_solid_diagonal_follows_the_bilinear_interpolant(solid, void, euler, mirrored, axes):
    """Two solid columns that touch at a diagonal are one body where the saddle between them is solid, else two."""
    values = np.full((6, 6, 6), void)
    values[2, 2, 1:5] = values[3, 3, 1:5] = solid
    values = values[::-1] if mirrored else values
    assert sound(of_array(values.transpose(axes))).euler == euler


def test_a_part_far_from_the_origin_is_sound():
    f = sphere(3.0)
    lo, hi = (1e4 - 4, -4.0, -4.0), (1e4 + 4, 4.0, 4.0)
    grid = Grid.cover(lo, hi, 0.25)
    sound(extract(grid, (lo, hi), sampler(grid, lambda x, y, z: f(x - 1e4, y, z))))


# --- accuracy --------------------------------------------------------------------------------------------------------

VOXELS = np.array([0.8, 0.4, 0.2])


def test_the_sphere_converges_with_the_square_of_the_voxel():
    off, volume, area = [], [], []
    for h in VOXELS:
        s = mesh(sphere(5.0), 6, h)
        off.append(np.abs(np.linalg.norm(s.vertices, axis=1) - 5).max())
        volume.append(abs(s.volume - 4 / 3 * np.pi * 125))
        area.append(abs(s.area - 4 * np.pi * 25))
    assert off[-1] < VOXELS[-1] ** 2 / (8 * 5) * 1.1  # the sagitta of an edge, h^2 / 8r
    assert 1.85 < rate(VOXELS, off) < 2.2
    assert 1.9 < rate(VOXELS, volume) < 2.1
    assert 1.8 < rate(VOXELS, area) < 2.2


def test_the_gyroid_converges_with_the_square_of_the_voxel():
    k = 2 * np.pi / 10

    def value_and_gradient(p):
        s, c = np.sin(k * p), np.cos(k * p)
        x, y, z = 0, 1, 2
        f = s[:, x] * c[:, y] + s[:, y] * c[:, z] + s[:, z] * c[:, x]
        g = k * np.stack(
            [c[:, a] * c[:, b] - s[:, d] * s[:, a] for a, b, d in ((x, y, z), (y, z, x), (z, x, y))], axis=1
        )
        return f, g

    off = []
    for h in VOXELS:
        start = mesh(gyroid(10.0), 5, h).vertices
        start = start[np.abs(start).max(axis=1) < 5]  # not the caps
        p = start.copy()
        for _ in range(8):
            f, g = value_and_gradient(p)
            p -= (f / (g * g).sum(axis=1))[:, None] * g
        assert np.abs(value_and_gradient(p)[0]).max() < 1e-12
        off.append(np.linalg.norm(p - start, axis=1).max())
    assert 1.8 < rate(VOXELS, off) < 2.2


def test_normals_point_from_solid_to_void():
    s = mesh(sphere(5.0), 6, 0.5)
    a, b, c = (s.vertices[s.faces[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    outward = (a + b + c) / np.linalg.norm(a + b + c, axis=1, keepdims=True)
    good = s.areas() > 1e-3 * s.areas().max()
    assert (normal * outward).sum(axis=1)[good].min() > 0.9
    assert s.to_trimesh().is_winding_consistent
    assert s.to_trimesh().volume == pytest.approx(s.volume, rel=1e-12)


# --- caps ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("voxel", [0.31, 0.5, 1.0, 3.0])
@pytest.mark.parametrize("cut", [0.0, 1.3, -2.1])
def test_a_half_space_is_capped_exactly(voxel, cut):
    s = sound(mesh(lambda x, y, z: x - cut + 0 * y * z, (4, 3, 2), voxel))
    assert s.volume == pytest.approx((cut + 4) * 6 * 4, rel=2e-5)
    assert np.array_equal(s.vertices.min(axis=0), [-4, -3, -2])
    assert np.array_equal(s.vertices.max(axis=0)[1:], [3, 2])


def test_an_oblique_cut_through_a_cube_halves_it_and_its_caps_are_flat():
    s = sound(mesh(lambda x, y, z: x + y + z, 3, 0.37))
    assert s.volume == pytest.approx(108, rel=1e-4)
    assert s.area == pytest.approx(3 * 36 + 3 * np.sqrt(3) / 2 * 18, rel=1e-3)  # half the faces, and a hexagon
    a, b, c = (s.vertices[s.faces[:, i]] for i in range(3))
    normal = np.abs(np.cross(b - a, c - a)) / 2
    flat = [normal[(np.abs(s.vertices[s.faces][:, :, i]) == 3).all(axis=1), i].sum() for i in range(3)]
    assert flat == pytest.approx([36] * 3, rel=1e-3)


def test_caps_lie_on_the_bound_for_a_lattice():
    s = sound(mesh(gyroid(10.0), (5, 6, 7), 0.6, np.float32))
    near = np.abs(np.abs(s.vertices) - [5, 6, 7]) < 0.0005
    assert near.any(axis=0).all()
    on = np.abs(s.vertices) == [5, 6, 7]
    edge = near.sum(axis=1) > 1  # the edges of the box are cut off by a hair of a voxel
    assert np.array_equal(near[~edge], on[~edge])
    assert (np.abs(s.vertices) <= [5, 6, 7]).all()


def test_a_field_that_ends_at_the_bounds_is_capped_there():
    def f(x, y, z):
        with np.errstate(invalid="ignore"):
            return np.sqrt(4 - np.abs(x)) - 1 + 0 * y * z

    s = sound(mesh(f, (4, 1, 1), 0.4))
    assert s.volume == pytest.approx(2 * 1 * 4, rel=0.02)


# --- bricks ----------------------------------------------------------------------------------------------------------


def enclose_sphere(r):
    def enclose(lo, hi):
        near = np.linalg.norm(np.maximum(np.maximum(lo, -hi), 0), axis=1)
        far = np.linalg.norm(np.maximum(np.abs(lo), np.abs(hi)), axis=1)
        return near - r, far - r

    return enclose


@pytest.mark.parametrize("half", [4.0, 6.0, 25.0])
def test_pruning_changes_nothing_but_the_work(half):
    plain = mesh(sphere(5.0), half, 0.5, np.float32)
    seen = []
    hi, lo = (half,) * 3, (-half,) * 3
    grid = Grid.cover(lo, hi, 0.5)
    sample = sampler(grid, sphere(5.0), np.float32)

    def counted(a, b):
        seen.append(np.prod(np.subtract(b, a)))
        return sample(a, b)

    pruned = extract(grid, (lo, hi), counted, enclose_sphere(5.0), brick=8)
    assert np.array_equal(triangles(plain), triangles(pruned))
    if half == 25:
        assert sum(seen) < 0.05 * np.prod(grid.shape)


def test_an_enclosure_that_says_nothing_rules_nothing_out():
    grid = Grid.cover((-1.0,) * 3, (1.0,) * 3, 0.1)
    layers = clip(grid, (-1.0,) * 3, (1.0,) * 3)
    nothing = split(layers, 8, lambda lo, hi: (np.full(len(lo), np.nan), np.full(len(lo), np.nan)))
    assert {(b.lo, b.hi) for b in nothing.bricks} == {(b.lo, b.hi) for b in split(layers, 8).bricks}


def test_a_large_empty_box_costs_few_enclosures():
    boxes = []

    def enclose(lo, hi):
        boxes.append(len(lo))
        return enclose_sphere(5.0)(lo, hi)

    s = mesh(sphere(5.0), 200, 0.5, enclose=enclose)
    assert s.volume == pytest.approx(4 / 3 * np.pi * 125, rel=0.01)
    assert sum(boxes) < 17**3 / 2


def test_progress_counts_up_and_cancelling_stops():
    steps = []
    with watching(lambda what, done, total: steps.append((done, total))):
        mesh(sphere(5.0), 6, 0.5, brick=8)
    assert steps == [(i + 1, len(steps)) for i in range(len(steps))]
    with watching(cancel=lambda: True), pytest.raises(CancelledError):
        mesh(sphere(5.0), 6, 0.5, brick=8, threads=2)


# --- what cannot be meshed -------------------------------------------------------------------------------------------


def complaint(code, call, *args, **more):
    with pytest.raises(PoreError) as caught:
        call(*args, **more)
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == code
    return f"{diagnostic.message} {diagnostic.hint}"


@pytest.mark.parametrize("enclose", [None, lambda lo, hi: (enclose_sphere(0.0)(lo, hi)[0] + 2, np.full(len(lo), 99.0))])
def test_an_empty_part_is_explained(enclose):
    text = complaint("E111", mesh, lambda x, y, z: sphere(-2.0)(x, y, z), 5, 0.5, enclose=enclose)
    assert "void" in text
    assert f"{2 + 0.185 * 3**0.5:.4g}" in text  # the grid starts 0.37 of a voxel off, so a node lies 0.185 from 0
    assert "(-0.185, -0.185, -0.185) mm" in text


def test_a_part_that_is_solid_everywhere_is_explained():
    text = complaint("E111", mesh, lambda x, y, z: gyroid(10.0)(x, y, z) - 5, 5, 0.5)
    assert "solid" in text
    assert "intersect" in text
    assert "-3.5" in text  # the gyroid reaches 1.5


def test_a_shape_that_ends_at_its_bounds_is_a_part():
    # Not solid everywhere: beyond the bounds it is void.
    s = mesh(lambda x, y, z: np.maximum(np.maximum(np.abs(x), np.abs(y)), np.abs(z)) - 5, 5, 0.7, np.float32)
    assert sound(s).volume == pytest.approx(1000, rel=0.02)


def test_a_field_that_is_not_a_number_is_named_with_its_place():
    def f(x, y, z):
        values = sphere(3.0)(x, y, z)
        return np.where((x > 1) & (y > 0) & (z > 2), np.nan, values)

    text = complaint("E110", mesh, f, 4, 0.5, threads=2)
    point = [float(c) for c in text.partition("(")[2].partition(")")[0].split(",")]
    assert 1 < point[0] < 1.5
    assert 0 < point[1] < 0.5
    assert 2 < point[2] < 2.5


def test_an_infinite_field_away_from_the_surface_is_a_part():
    s = mesh(lambda x, y, z: np.where(sphere(4.0)(x, y, z) > 0, np.inf, sphere(3.0)(x, y, z)), 5, 0.25)
    assert sound(s).volume == pytest.approx(4 / 3 * np.pi * 27, rel=0.01)


@pytest.mark.parametrize(
    ("lo", "hi", "more"),
    [
        ((0, 0, 0), (1, 1, 0), {"spacing": 0.1}),
        ((0, 0, 0), (1, 1, -1), {"spacing": 0.1}),
        ((0, 0, 0), (1, 1, float("inf")), {"spacing": 0.1}),
        ((0, 0, 0), (1, 1, 1), {"spacing": -0.1}),
        ((0, 0, 0), (1, 1, 1), {"spacing": float("nan")}),
        ((0, 0, 0), (1, 1, 1), {"resolution": 0}),
        ((0, 0, 0), (1, 1, 1), {"spacing": 1e-6}),
    ],
)
def test_bounds_and_voxels_that_make_no_grid_are_refused(lo, hi, more):
    complaint("E114", Grid.cover, lo, hi, **more)


def test_the_hint_for_a_voxel_that_is_too_fine_can_be_followed():
    text = complaint("E114", Grid.cover, (0, 0, 0), (100, 100, 10), spacing=1e-4)
    Grid.cover((0, 0, 0), (100, 100, 10), spacing=float(text.split("voxel of ")[-1].split(" mm")[0]))


def test_a_grid_covers_its_box_with_a_layer_to_spare():
    for size in (1.0, 1.37, 2.63, 9.99):
        grid = Grid.cover((-size, 0.0, 5.0), (size, 2 * size, 5 + size), 0.37)
        for axis, lo, hi in zip(grid.axes(), (-size, 0.0, 5.0), (size, 2 * size, 5 + size), strict=True):
            assert axis[0] < lo < axis[1]
            assert axis[-2] <= hi < axis[-1]
    assert max(Grid.cover((0, 0, 0), (4, 8, 2), resolution=64).shape) == 66
    assert np.array_equal(
        grid.points(lo=(1, 2, 3), hi=(2, 3, 5))[1], [grid.axes()[0][1], grid.axes()[1][2], grid.axes()[2][4]]
    )


# --- what check() finds ----------------------------------------------------------------------------------------------


def test_check_finds_what_is_wrong():
    good = mesh(sphere(4.0), 5, 1.0)
    v, f = good.vertices, good.faces
    assert any("no triangle on one side" in d for d in Surface(v, f[1:]).check())
    assert any("inside out" in d for d in Surface(v, f[:, ::-1]).check())
    assert Surface(v, np.vstack([f[1:], f[:1, ::-1]])).check()
    assert Surface(v, np.vstack([f, f[:1]])).check()
    flat = v.copy()
    flat[f[0, 0]] = flat[f[0, 1]]
    assert any("no area" in d for d in Surface(flat, f).check())
    assert any("lie exactly on another" in d for d in Surface(flat, f).check())
    broken = v.copy()
    broken[0, 0] = np.nan
    assert any("not a number" in d for d in Surface(broken, f).check())
    other = np.where(f == 0, 0, f + len(v) - 1)  # a second ball that shares a vertex with the first
    both = Surface(np.vstack([v, 2 * v[0] - v[1:]]), np.vstack([f, other[:, ::-1]]))
    assert any("touches itself" in d for d in both.check())


# --- files -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ending", [".stl", ".obj", ".ply", ".STL"])
def test_a_file_comes_back_as_it_was(tmp_path, ending):
    surface = mesh(gyroid(10.0), 6, 0.7)
    path = write(surface, tmp_path / f"part{ending}")
    back = trimesh.load(path)
    assert back.is_watertight
    assert back.volume == pytest.approx(surface.volume, rel=1e-6)
    assert len(back.faces) == len(surface.faces)
    assert back.euler_number == surface.euler
    assert np.abs(back.bounds - [[-6] * 3, [6] * 3]).max() < 1e-6
    if ending in (".obj", ".ply"):
        assert (
            np.abs(
                np.sort(back.triangles_center, axis=0) - np.sort(surface.to_trimesh().triangles_center, axis=0)
            ).max()
            < 1e-9
        )
    assert os.listdir(tmp_path) == [path.name]


@pytest.mark.parametrize("failure", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()])
def test_a_failure_half_way_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch, failure):
    surface = mesh(sphere(4.0), 5, 1.0)
    path = tmp_path / "part.ply"
    path.write_bytes(b"before")

    def half(surface, file, notes):
        file.write(b"ply\n" * 10000)
        raise failure

    monkeypatch.setitem(WRITERS, ".ply", half)
    with pytest.raises((PoreError, KeyboardInterrupt)) as caught:
        write(surface, path)
    if isinstance(failure, OSError):
        assert caught.value.diagnostics[0].code == "E113"
        assert "no space left" in caught.value.diagnostics[0].message
    assert path.read_bytes() == b"before"
    assert os.listdir(tmp_path) == ["part.ply"]


def test_names_that_cannot_be_written_are_refused_with_a_way_out(tmp_path):
    surface = mesh(sphere(4.0), 5, 1.0)
    assert ".stl" in complaint("E112", write, surface, tmp_path / "part.stll")
    assert ".ply" in complaint("E112", write, surface, tmp_path / "part")
    (tmp_path / "folder.stl").mkdir()
    assert "folder" in complaint("E113", write, surface, tmp_path / "folder.stl")
    assert "mkdir" in complaint("E113", write, surface, tmp_path / "nowhere" / "part.stl")
    complaint("E113", write, surface, tmp_path / ("long" * 100 + ".stl"))
    assert os.listdir(tmp_path) == ["folder.stl"]


def test_a_link_is_written_through_and_permissions_stay(tmp_path: Path):
    surface = mesh(sphere(4.0), 5, 1.0)
    real = tmp_path / "real.stl"
    real.write_bytes(b"")
    real.chmod(0o640)
    (tmp_path / "link.stl").symlink_to(real)
    write(surface, tmp_path / "link.stl")
    assert (tmp_path / "link.stl").is_symlink()
    assert real.stat().st_mode & 0o777 == 0o640
    assert len(trimesh.load(real).faces) == len(surface.faces)


def test_a_mesh_too_fine_for_stl_is_refused_and_fits_a_ply(tmp_path):
    ball = mesh(sphere(4.0), 5, 1.0)
    far = Surface(ball.vertices * 1e-3 + 1e5, ball.faces)
    assert ".ply" in complaint("E115", write, far, tmp_path / "far.stl")
    assert os.listdir(tmp_path) == []
    write(far, tmp_path / "far.ply")
    assert trimesh.load(tmp_path / "far.ply", process=False).is_watertight
