"""Tetrahedra straight from a field: volumes in closed form, angles as published, conforming meshes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from boxes import box

import porelang
from porelang.diagnostics import PoreError
from porelang.formula import Formula
from porelang.progress import CancelledError, watching
from porelang.solid import Solid
from porelang.tet.cut import Background, cut
from porelang.tet.direct import direct
from porelang.tet.frame import Frame
from porelang.tet.lattice import Lattice
from porelang.tet.octree import graded, uniform
from porelang.tet.quality import sound
from porelang.tet.slivers import without_kites
from porelang.tet.tetmesh import (
    CROWDED,
    TetMesh,
    boundary,
    components,
    dihedral_angles,
    interfaces,
    neighbours,
    taken,
    volumes,
)

BALL = 4 / 3 * math.pi * 10**3
CUBE = ((-10.0, -10.0, -10.0), (10.0, 10.0, 10.0))
#: Labelle & Shewchuk 2007, theorem 1: for the parameters that make the least angle largest.
LEAST, MOST = 10.7843, 164.7443


def solid_of(text: str, bounds: Any = None) -> Solid:
    design = porelang.compile(text).design()
    return Solid(design.of("part"), bounds or design.bounds("part"))


def field_of(text: str) -> Formula:
    program = porelang.compile(f"out f = {text}\nsphere(1)")
    return program.design().formula(*program.field_roots("f"))


def meshed(text: str, size: Any, bounds: Any = None, **more: Any) -> tuple[TetMesh, dict[str, Any]]:
    mesh, facts = direct(solid_of(text, bounds), size, **more)
    assert_sound(mesh)
    return mesh, facts


def assert_sound(mesh: TetMesh) -> None:
    """What a solver needs, by other means than `sound`: with NumPy's sorting."""
    at = mesh.vertices[mesh.tets]
    assert (np.linalg.det(at[:, 1:] - at[:, :1]) > 0).all()
    faces = np.sort(mesh.tets[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3), axis=1)
    _, count = np.unique(faces, axis=0, return_counts=True)
    assert count.max() == 2
    triangles, owner = boundary(mesh)
    assert len(triangles) == (count == 1).sum()
    ways = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    there = np.unique(ways, axis=0, return_counts=True)
    back = np.unique(ways[:, ::-1], axis=0, return_counts=True)
    assert (there[0] == back[0]).all()
    assert (there[1] == back[1]).all()
    corners = mesh.vertices[triangles]
    enclosed = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert enclosed == pytest.approx(volumes(mesh).sum(), rel=1e-9)  # so they are outward
    assert (owner >= 0).all()
    assert np.unique(mesh.tets).tolist() == list(range(len(mesh.vertices)))


# Meshes as data


def two() -> TetMesh:
    at = np.vstack([np.zeros(3), np.eye(3), np.ones(3)])
    return TetMesh(at, np.array([[0, 1, 2, 3], [1, 2, 3, 4]], np.int32), np.zeros(2, np.int8))


def test_two_tetrahedra_share_a_face() -> None:
    mesh = two()
    assert volumes(mesh).tolist() == pytest.approx([1 / 6, 1 / 3])
    assert neighbours(mesh).tolist() == [[1, -1, -1, -1], [-1, -1, -1, 0]]
    assert len(boundary(mesh)[0]) == 6
    assert components(mesh).tolist() == [0, 0]
    assert dihedral_angles(mesh)[1] == pytest.approx(np.degrees(math.acos(1 / 3)))  # a regular one
    assert dihedral_angles(mesh)[0, :3] == pytest.approx(90)


def test_two_phases_share_their_interface() -> None:
    mesh = TetMesh(two().vertices, two().tets, np.array([1, 0], np.int8), ("solid", "void"))
    triangles, owners = interfaces(mesh)
    assert sorted(triangles[0]) == [1, 2, 3]
    assert owners.tolist() == [[1, 0]]
    assert components(mesh).tolist() == [1, 0]  # the larger is the first


def test_what_is_not_sound_is_told() -> None:
    mesh = two()
    flat = TetMesh(mesh.vertices * [1, 1, 0], mesh.tets, mesh.phase)
    assert sound(flat).flat == 2
    crowded = TetMesh(
        np.vstack([mesh.vertices, [[2, 2, 2]]]), np.vstack([mesh.tets, [[1, 2, 3, 5]]]).astype(np.int32),
        np.zeros(3, np.int8),
    )  # fmt: skip
    assert (neighbours(crowded) == CROWDED).any()
    assert sound(crowded).faults
    assert sound(TetMesh(np.vstack([mesh.vertices, [[9, 9, 9]]]), mesh.tets, mesh.phase)).unused == 1
    assert not sound(mesh).faults
    alone = taken(mesh, np.array([False, True]))
    assert len(alone.vertices) == 4
    assert volumes(alone) == pytest.approx(1 / 3)


# Lattices


def frame_of(*counts: int) -> Frame:
    return Frame(np.zeros(3), np.ones(3), np.array(counts), np.ones((3, 2), np.bool_), True)


def near_ball(centre: tuple[float, ...], radius: float) -> Any:
    def decided(lo: Any, hi: Any) -> Any:
        near = np.linalg.norm(np.clip(centre, lo, hi) - centre, axis=1)
        far = np.linalg.norm(np.maximum(np.abs(lo - centre), np.abs(hi - centre)), axis=1)
        return np.where(near > radius, -1, np.where(far < radius, 1, 0)).astype(np.int8)

    return decided


def test_a_lattice_fills_its_frame() -> None:
    frame = frame_of(5, 4, 3)
    lattice = Lattice(uniform(frame, lambda lo, hi: np.zeros(len(lo), np.int8)), frame)
    mesh = TetMesh(lattice.vertices, lattice.tets, np.zeros(len(lattice.tets), np.int8))
    assert_sound(mesh)
    assert volumes(mesh).sum() == pytest.approx(60)
    assert (np.abs(dihedral_angles(mesh)[:, :, None] - [45, 60, 90]).min(axis=2) < 1e-9).all()


def test_cubes_of_several_sizes_fit_together() -> None:
    frame = frame_of(16, 16, 24)
    cells = graded(frame, near_ball((8, 8, 10.3), 6), lambda p: np.full(len(p), 8.0), 1.0, 3)
    assert np.unique(cells.level).tolist() == [0, 1, 2]
    lattice = Lattice(cells, frame)
    mesh = TetMesh(lattice.vertices, lattice.tets, np.zeros(len(lattice.tets), np.int8))
    assert_sound(mesh)
    assert volumes(mesh).sum() == pytest.approx(16 * 16 * 24)
    middles = mesh.vertices[boundary(mesh)[0]].mean(axis=1)
    assert np.minimum(middles, [16, 16, 24] - middles).min(axis=1) == pytest.approx(0, abs=1e-9)
    assert dihedral_angles(mesh).min() > 44.9


def test_planes_cut_a_lattice_within_the_published_angles() -> None:
    """Any plane through a lattice, and both of its sides: what smooth surfaces look like to small cubes."""
    frame = frame_of(7, 7, 7)
    lattice = Lattice(uniform(frame, lambda lo, hi: np.zeros(len(lo), np.int8)), frame)
    free = np.zeros(len(lattice.at), np.uint8)
    random = np.random.default_rng(0)
    for _ in range(25):
        normal = random.normal(size=3) * 10.0 ** -random.integers(0, 4, 3)
        normal /= np.linalg.norm(normal)
        centre = 3 + random.random(3)

        def value(points: Any, centre: Any = centre, normal: Any = normal) -> Any:
            return (points - centre) @ normal

        values = value(lattice.vertices)
        background = Background(lattice.vertices, lattice.tets, values, lattice.kind, lattice.rank, free)
        both = cut(background, value, both=True)
        mesh = TetMesh(both.vertices, both.tets, both.side, ("solid", "void"))
        angles = dihedral_angles(mesh)
        assert angles.min() > LEAST
        assert angles.max() < MOST
        assert volumes(mesh).min() > 0
        assert_sound(mesh)
        assert np.abs(value(mesh.vertices[interfaces(mesh)[0]])).max() < 1e-6
        alone = cut(background, value)
        assert volumes(TetMesh(alone.vertices, alone.tets, alone.side)).sum() == pytest.approx(
            volumes(mesh)[mesh.phase == 0].sum()
        )


# Parts


def test_the_volume_of_a_ball_converges_by_the_square_of_the_size() -> None:
    off = [meshed("sphere(10)", size, sharp=False)[1]["volume"] / BALL - 1 for size in (2.0, 1.0)]
    assert -0.015 < off[0] < 0
    assert off[0] / off[1] == pytest.approx(4, rel=0.15)


def test_the_volume_of_curved_walls_is_the_parts() -> None:
    """What flat triangles cut off a ball, and add to the hollow in it, is less by a hundred where vertices leave it."""
    text, volume = "sphere(10) \\ sphere(6)", BALL * (1 - 0.6**3)
    plain, _ = meshed(text, 1.0, sharp=False)
    mesh, facts = meshed(text, 1.0)
    assert abs(facts["volume"] / volume - 1) < 1e-4
    assert abs(volumes(plain).sum() / volume - 1) > 1e-3
    assert 0 < facts["moved"] < 0.05
    assert np.linalg.norm(mesh.vertices - plain.vertices, axis=1).max() == pytest.approx(facts["moved"])


@pytest.mark.parametrize("text", ["sphere(10)", "torus(10, 4)", "smooth_intersection(gyroid(20) * 3, sphere(9), 3)"])
@pytest.mark.parametrize("size", [0.83, 1.0])
def test_smooth_surfaces_have_angles_as_published(text: str, size: float) -> None:
    mesh, facts = meshed(text, size)
    assert facts["min_dihedral"] == pytest.approx(dihedral_angles(mesh).min())
    assert facts["min_dihedral"] > LEAST
    assert facts["max_dihedral"] < MOST
    assert sum(facts["dihedral_histogram"]) == 6 * len(mesh.tets)


def test_a_box_is_exact() -> None:
    mesh, facts = meshed("box([7, 5, 3])", 0.9)
    assert facts["volume"] == pytest.approx(105, rel=1e-9)
    assert mesh.vertices.max(axis=0) == pytest.approx([3.5, 2.5, 1.5], abs=1e-9)
    assert facts["min_dihedral"] > 35  # 45 in cubes; here they are stretched by a tenth


@pytest.mark.parametrize("text", [
    "schwarz_p(8) & (box([8, 8, 8]) | translate(box([8, 8, 8]), [0, 0, 8]))",
    "box([8, 6, 8]) | translate(box([6, 8, 4]), [0, 0, 6])",
])  # fmt: skip
def test_no_crack_runs_through_solids_that_share_a_face(text: str) -> None:
    mesh, _ = meshed(text, 2)
    triangles, _ = boundary(mesh)
    _, count = np.unique(mesh.vertices[triangles].mean(axis=1).round(6), axis=0, return_counts=True)
    assert count.max() == 1  # two in one place were the sides of a crack
    assert components(mesh).max() == 0


@pytest.mark.parametrize("size", [2.0, 1.4, 1.0])
@pytest.mark.parametrize("at", ["0, 0, 6", "0.37, 0.61, 6", "0.37, 0.61, 6.2"])
def test_a_neck_between_what_only_touches_is_told(size: float, at: str) -> None:
    """A ball on a plate, or a little above it: elements join them, wherever the grid lies, or part them."""
    plate = "translate(box([20, 20, 4]), [0, 0, -2])"
    mesh, facts = meshed(f"translate(sphere(6), [{at}]) | {plate}", size, keep_islands=True)
    told = [d.message for d in facts["told"] if d.code == "W254"]
    assert told or components(mesh).max() == 1
    assert all(" mm wide is closed over " in message for message in told)
    assert not (told and at.endswith("6.2") and size == 1.0)  # which is narrow enough to part them


def test_a_slit_narrower_than_a_cube_is_opened_by_smaller_ones() -> None:
    """A saw cut of which no corner of a cube knows: those round it are halved until it is there."""
    _, facts = meshed("box([20, 10, 10]) \\ translate(box([0.4, 11, 8]), [0.5, 0, 2])", 2)
    assert "W254" not in {d.code for d in facts["told"]}
    assert facts["volume"] == pytest.approx(2000 - 7 * 10 * 0.4, rel=1e-3)
    assert facts["min_dihedral"] > LEAST


def test_of_several_gaps_the_largest_is_told_and_how_many_there_are() -> None:
    cuts = " ".join(f"\\ translate(box([0.04, 24, {deep}]), [{x}, 0, 10])" for x, deep in ((1.505, 12), (13.505, 16)))
    _, facts = meshed(f"box([60, 20, 20]) {cuts}", 3)
    (told,) = (d for d in facts["told"] if d.code == "W254")
    assert told.message.startswith("2 gaps are closed: the largest, 0.04 mm wide over 20 x ")
    assert "as at (13.5" in told.message


@pytest.mark.parametrize(("part", "deep", "x"), [
    ("box([20, 10, 10])", (10, 7.0), 0.35),
    ("box([20, 10, 10])", (10, 7.0), 0.505),  # just beside a plane of corners
    ("box([120, 20, 20])", (20, 16.0), 0.35),  # the slit is a small share of its surface
])  # fmt: skip
def test_a_slit_that_stays_closed_is_told(part: str, deep: tuple[float, float], x: float) -> None:
    """One of .05 mm, in cubes that are .5 mm when they are halved: how wide it is, over how much, and where."""
    across, down = deep
    top = float(part.split(",")[2].rstrip("])")) / 2
    _, facts = meshed(f"{part} \\ translate(box([0.05, 30, {2 * down + 0.01}]), [{x}, 0, {top}])", 2)
    (told,) = (d for d in facts["told"] if d.code == "W254")
    assert told.message.startswith("a gap 0.05 mm wide is closed over ")
    found = [float(n) for n in told.message.split(" over ")[1].split(" mm")[0].split(" x ")]
    assert found == pytest.approx([max(across, down), min(across, down)], rel=0.1)
    assert f"as at ({x}, " in told.message
    assert "W252" not in {d.code for d in facts["told"]}
    assert "--surface-size" in told.hint


@pytest.mark.parametrize("text", [
    "box([20, 10, 10]) \\ translate(box([3, 11, 8]), [0.5, 0, 2])",  # wide enough
    "box([40, 20, 10]) \\ translate(rotate(box([8, 30, 8]), [0, 1, 0], 45deg), [0, 0, 5])",  # a notch of 90 degrees
    "gyroid(8) & cylinder(10, 16)",
    "schwarz_p(8) & box([16, 16, 16])",
])  # fmt: skip
def test_of_gaps_that_are_open_nothing_is_said(text: str) -> None:
    _, facts = meshed(text, 2)
    assert "W254" not in {d.code for d in facts["told"]}


def test_a_cylinder_ends_flat_with_sharp_rims() -> None:
    """Where vertices stay on it, all that lacks are the segments of its circles, by the square of the size."""
    off = [meshed("cylinder(10, 30)", size, sharp=False)[1]["volume"] / (math.pi * 100 * 30) - 1 for size in (2.0, 1.0)]
    assert abs(off[0]) < 0.004
    assert off[0] / off[1] == pytest.approx(4, rel=0.15)
    mesh, facts = meshed("cylinder(10, 30)", 2.0)
    assert facts["volume"] == pytest.approx(math.pi * 3000, rel=1e-4)
    assert np.abs(mesh.vertices[:, 2]).max() == pytest.approx(15, abs=1e-9)


def turned_box(at: Any) -> Any:
    """The distance of points from the surface of a box of 7, 5, 3 mm turned by 30 degrees about (1, 2, 3), outside."""
    axis = np.array([1, 2, 3]) / math.sqrt(14)
    back = math.radians(-30)
    cross = np.cross(axis, at)
    local = at * math.cos(back) + cross * math.sin(back) + np.outer(at @ axis, axis) * (1 - math.cos(back))
    return (np.abs(local) - [3.5, 2.5, 1.5]).max(axis=1), local


def test_rims_and_corners_of_a_turned_box_are_sharp() -> None:
    text = "box([7, 5, 3]) |> rotate([1, 2, 3], 30deg)"
    chamfered, _ = meshed(text, 0.5, sharp=False)
    mesh, facts = meshed(text, 0.5)
    assert volumes(chamfered).sum() < 0.99 * 105
    assert facts["volume"] == pytest.approx(105, rel=2e-3)
    assert facts["min_dihedral"] > 8
    assert facts["rim_vertices"] > 100
    off, local = turned_box(mesh.vertices)
    assert off.max() < 1e-5  # nothing lies outside
    near = np.sort(np.abs(np.abs(local) - [3.5, 2.5, 1.5]), axis=1) < 1e-5
    assert (near[:, 1] & ~near[:, 2]).sum() > 80  # on an edge of the box
    assert near[:, 2].sum() >= 6  # of its eight corners
    assert facts["rim_triangles_left"] < 0.1 * facts["rim_vertices"]


def test_a_drilled_ball_has_its_volume_in_closed_form() -> None:
    """A ball with a hole through it: 4/3 pi h^3, with h half the length of the hole (the napkin ring)."""
    ring = 4 / 3 * math.pi * (100 - 16) ** 1.5
    plain = volumes(meshed("sphere(10) \\ cylinder(4, 30)", 1.0, sharp=False)[0]).sum()
    mesh, facts = meshed("sphere(10) \\ cylinder(4, 30)", 1.0)
    assert abs(facts["volume"] / ring - 1) < 3e-4
    assert abs(plain / ring - 1) > 3e-3
    rim = np.abs(np.linalg.norm(mesh.vertices, axis=1) - 10) + np.abs(np.hypot(*mesh.vertices.T[:2]) - 4) < 1e-5
    assert rim.sum() >= 60
    assert facts["min_dihedral"] > 8


def test_a_lattice_cut_at_its_box_has_sharp_rims() -> None:
    """A period of a Schwarz P: half of it is solid, by its symmetry, whatever the size."""
    for size in (1.0, 2.0):
        mesh, facts = meshed("schwarz_p(20)", size, CUBE)
        assert facts["volume"] / 8000 == pytest.approx(0.5, abs=1e-3)
        assert facts["min_dihedral"] > 8
        assert np.abs(mesh.vertices).max() <= 10 + 1e-9


def test_phases_fill_the_box_and_share_their_triangles() -> None:
    mesh, facts = meshed("gyroid(20) |> shell(1.5)", 1.0, CUBE, phases=("solid", "void"), sharp=False)
    assert mesh.phases == ("solid", "void 1", "void 2")
    assert facts["volume"] / 8000 == pytest.approx(1, abs=1e-3)
    assert facts["volume"] / 8000 == pytest.approx(1 - facts["dropped_volume_fraction"], abs=1e-3)
    triangles, owners = interfaces(mesh)
    assert {tuple(p) for p in np.unique(mesh.phase[owners], axis=0).tolist()} == {(0, 1), (0, 2)}
    on = solid_of("gyroid(20) |> shell(1.5)", CUBE)
    inner = (np.abs(mesh.vertices) < 10 - 1e-6).all(axis=1)
    some = np.unique(triangles)
    assert np.abs(on.value(mesh.vertices[some[inner[some]]])).max() < 1e-4
    alone, _ = meshed("gyroid(20) |> shell(1.5)", 1.0, CUBE, sharp=False)
    assert volumes(mesh)[mesh.phase == 0].sum() == pytest.approx(volumes(alone).sum(), rel=1e-9)


def test_void_alone_has_one_name_where_it_is_one() -> None:
    mesh, _ = meshed("schwarz_p(20)", 2.0, CUBE, phases=("solid", "void"))
    assert mesh.phases == ("solid", "void")
    assert volumes(mesh).sum() == pytest.approx(8000)


def test_phases_within_an_envelope_have_sharp_rims_too() -> None:
    mesh, facts = meshed("gyroid(10) |> shell(1.5) & cylinder(6, 8)", 1.0, phases=("solid", "void"), keep_islands=True)
    assert volumes(mesh).sum() == pytest.approx(12 * 12 * 8)
    assert facts["min_dihedral"] > 7
    assert facts["rim_vertices"] > 100


def within(mesh: TetMesh, points: Any) -> Any:
    """Which points (n, 3) are in some tetrahedron: each of them against those whose boxes hold it."""
    at = mesh.vertices[mesh.tets]
    low, high = at.min(axis=1), at.max(axis=1)
    inverse = np.linalg.inv((at[:, 1:] - at[:, :1]).transpose(0, 2, 1))
    found = np.zeros(len(points), np.bool_)
    for i, p in enumerate(points):
        some = np.flatnonzero(((low <= p) & (p <= high)).all(axis=1))
        part = np.einsum("nij,nj->ni", inverse[some], p - at[some, 0])
        found[i] = ((part >= -1e-9).all(axis=1) & (part.sum(axis=1) <= 1 + 1e-9)).any()
    return found


def test_tongues_at_an_envelope_are_not_lost() -> None:
    """Where a gyroid meets a cylinder at a small angle it ends in tongues thinner than the cubes; struts hang by it."""
    text = "gyroid(10) & cylinder(7, 15)"
    solid = solid_of(text)
    mesh, facts = meshed(text, 1.2)
    points = np.random.default_rng(0).uniform(-7.5, 7.5, (25_000, 3))
    value, slope = solid.slope(points)
    depth = -value / np.linalg.norm(slope, axis=1)
    deep = (depth > 0.25) & (depth < 0.6)
    assert deep.sum() > 800
    assert not (~within(mesh, points[deep])).any()
    assert not within(mesh, points[(depth < -0.25) & (depth > -0.6)]).any()
    assert facts["missing"] + facts["extra"] < 2e-3 * facts["volume"]
    assert 10.7 < facts["min_dihedral"] < facts["max_dihedral"] < 164.8
    assert facts["halved"] > 100
    assert facts["finest_cube"] == pytest.approx(facts["cube"][0] / 4, rel=0.05)


@pytest.mark.parametrize(
    ("text", "solid"),
    [
        ("gyroid(10) & cylinder(10, 10)", 0.5),
        ("gyroid(10) |> shell(1.5) & cylinder(10, 10)", None),
        ("schwarz_p(10) & cylinder(5, 10)", None),
        ("iwp(10) & cylinder(10, 5)", None),
    ],
)
def test_lattices_in_a_cylinder_have_their_volume(text: str, solid: float | None) -> None:
    """At ten cubes to a cell within 0.3 %, against points by chance in the cells of a grid, known to 0.1 %."""
    part, rng, n = solid_of(text), np.random.default_rng(1), 80
    cells = np.stack(np.meshgrid(*[np.arange(n)] * 3, indexing="ij"), -1).reshape(-1, 3)
    lo, hi = np.array(part.lo), np.array(part.hi)
    held = part.holds(lo + (cells + rng.random(cells.shape)) / n * (hi - lo)).mean() * np.prod(hi - lo)
    if solid is not None:
        assert held == pytest.approx(solid * math.pi * 100 * 10, rel=2e-3)
    mesh, facts = meshed(text, 1.0, keep_islands=True)
    assert volumes(mesh).sum() == pytest.approx(held, rel=3e-3)
    assert facts["min_dihedral"] > 8


def test_kites_on_the_surface_are_left_out() -> None:
    """A flat tetrahedron across two triangles of a side: gone, and the side is closed by its other two triangles."""
    plain = box((3, 3, 3))
    triangles, _ = boundary(plain)
    on_top = triangles[(plain.vertices[triangles][:, :, 2] > 1 - 1e-9).all(axis=1)]
    one = on_top[0]
    shared = [len(np.intersect1d(one, other)) == 2 for other in on_top]
    other = on_top[int(np.argmax(shared))]
    across = np.setdiff1d(other, one)[0]
    vertices = plain.vertices.copy()
    vertices[across, 2] += 1e-3  # the fold between the two is hollow by a hair: the kite fills it
    kite = np.array([[one[0], one[1], one[2], across]], np.int32)
    for tet in (kite, kite[:, [1, 0, 2, 3]]):
        tets = np.concatenate([plain.tets, tet]).astype(np.int32)
        whole = TetMesh(vertices, tets, np.zeros(len(tets), np.int8))
        if volumes(whole)[-1] > 0:
            break
    assert not sound(whole).faults
    mended, beside, left = without_kites(whole, neighbours(whole))
    assert not len(left)
    assert len(mended.tets) == len(plain.tets)
    assert not sound(mended, beside).faults
    assert dihedral_angles(mended).min() > 30
    filled = TetMesh(whole.vertices, whole.tets, whole.phase, ("solid", "void"))  # then it would be a hole
    same, _, left = without_kites(filled, neighbours(filled))
    assert same is filled
    assert left.tolist() == whole.tets[-1:].tolist()


def test_a_line_or_a_circle_of_touch_is_no_end() -> None:
    """A box touches a cylinder in lines and a torus in circles: the part ends there, but not flat."""
    mesh, _ = meshed("gyroid(10) & cylinder(7, 15)", 0.8)
    assert np.hypot(*mesh.vertices.T[:2]).max() < 7.06  # it was 7.17
    mesh, facts = meshed("torus(10, 4)", 1.0)
    assert facts["volume"] == pytest.approx(2 * math.pi**2 * 10 * 16, rel=2e-4)


def test_a_solid_that_touches_itself_is_told() -> None:
    _, facts = meshed("box([4, 4, 4]) | translate(box([4, 4, 4]), [4, 4, 0])", 1.0, keep_islands=True)
    assert facts["touching_edges"] >= 4
    told = {d.code: d.message for d in facts["told"]}
    assert "(2, 2, " in told["W252"]


def test_what_is_too_coarse_for_a_part_is_told() -> None:
    _, facts = meshed("gyroid(10) & cylinder(10, 20)", 6.0, keep_islands=True)
    told = {d.code: d.message for d in facts["told"]}
    assert "lacks" in told["W253"]


def test_islands_in_the_void_become_void() -> None:
    """Left out they would be holes: the box is full without them."""
    mesh, facts = meshed("gyroid(20) |> shell(1)", 1.0, CUBE, phases=("solid", "void"))
    assert facts["islands"] > 0
    assert volumes(mesh).sum() == pytest.approx(8000, rel=1e-12)
    assert [d.code for d in facts["told"]].count("W251") == 1
    pieces = components(mesh)
    assert len(np.unique(pieces)) == len(mesh.phases)


def test_islands_are_dropped_and_named() -> None:
    text = "sphere(5) | translate(sphere(2), [12, 0, 0])"
    mesh, facts = meshed(text, 0.8)
    (told,) = facts["told"]
    assert told.code == "W251"
    assert "(12, " in told.message
    assert facts["islands"] == 1
    assert facts["dropped_volume_fraction"] == pytest.approx(8 / 133, rel=0.05)
    assert mesh.vertices[:, 0].max() < 6
    kept, facts = meshed(text, 0.8, keep_islands=True)
    assert facts["dropped_volume_fraction"] == 0
    assert facts["islands"] == 1
    assert kept.vertices[:, 0].max() > 13


def test_sizes_are_finer_at_the_surface() -> None:
    fine, of_fine = meshed("sphere(10)", 0.7)
    mesh, facts = meshed("sphere(10)", 4.0, surface_size=0.7)
    assert facts["volume"] == pytest.approx(of_fine["volume"], rel=1e-6)  # the surface is the same
    assert len(mesh.tets) < 0.7 * len(fine.tets)
    assert facts["min_dihedral"] > LEAST
    depth = 10 - np.linalg.norm(mesh.vertices[mesh.tets].mean(axis=1), axis=1)
    assert volumes(mesh)[depth > 6].mean() > 7 * volumes(mesh)[depth < 1].mean()


def test_sizes_follow_a_field() -> None:
    size = field_of("max(0.5, abs(z) / 4)")
    mesh, facts = meshed("box([12, 12, 24])", size)
    assert facts["volume"] == pytest.approx(12 * 12 * 24, rel=1e-9)
    middle = np.abs(mesh.vertices[mesh.tets].mean(axis=1)[:, 2])
    edge = np.cbrt(12 * volumes(mesh))
    asked = np.maximum(0.5, middle / 4)
    assert (edge < 1.3 * asked + 0.1).all()
    assert edge[middle > 9].mean() > 2.5 * edge[middle < 2].mean()
    assert facts["min_dihedral"] > 20


def test_a_wall_thinner_than_two_cubes_is_told_with_its_place() -> None:
    _, facts = meshed("box([20, 20, 1.5])", 1.0)
    (told,) = facts["told"]
    assert told.code == "W250"
    assert "1.5 mm thick" in told.message
    assert "0.5 mm" in told.hint  # three across, as is chosen where no size is given
    assert not meshed("box([20, 20, 2.5])", 1.0)[1]["told"]


@pytest.mark.parametrize(
    ("size", "more", "code"),
    [
        (0, {}, "E160"),
        (-1.0, {}, "E160"),
        (float("nan"), {}, "E160"),
        (True, {}, "E160"),
        (1.0, {"surface_size": 2.0}, "E160"),
        (1.0, {"phases": ("void",)}, "E160"),
        (0.01, {}, "E161"),
        (2.0, {"surface_size": 0.005}, "E161"),
        (50.0, {}, "E162"),
    ],
)
def test_what_cannot_be_is_refused_with_a_way_out(size: Any, more: dict[str, Any], code: str) -> None:
    with pytest.raises(PoreError) as error:
        direct(solid_of("translate(sphere(10), [3, 2, 1])"), size, **more)
    (found,) = error.value.diagnostics
    assert found.code == code
    assert found.hint


def test_walls_that_fall_between_the_cubes_are_refused() -> None:
    with pytest.raises(PoreError, match="E162"):
        direct(solid_of("gyroid(10) |> shell(0.6) & cube(30)"), 1.0)


def test_sizes_that_are_none_are_refused_with_their_place() -> None:
    with pytest.raises(PoreError, match=r"E160.*mm at \("):
        direct(solid_of("sphere(10)"), field_of("z / 5"))


def test_a_field_without_a_number_is_refused_with_its_place() -> None:
    with pytest.raises(PoreError, match="E110"):
        direct(solid_of("max(sphere(5), sqrt(x - 100) - 1)", CUBE), 1.0)


def test_the_same_again() -> None:
    one, _ = meshed("gyroid(10) |> shell(1.5) & sphere(5)", 1.0)
    other, _ = meshed("gyroid(10) |> shell(1.5) & sphere(5)", 1.0)
    assert one.tets.tobytes() == other.tets.tobytes()
    assert one.vertices.tobytes() == other.vertices.tobytes()


def test_it_tells_how_far_it_is_and_can_be_ended() -> None:
    seen: list[str] = []
    with watching(lambda what, done, total: seen.append(what)):
        direct(solid_of("sphere(10)"), 2.0)
    assert set(seen) == {"meshing", "sharpening"}
    with watching(cancel=lambda: True), pytest.raises(CancelledError):
        direct(solid_of("sphere(10)"), 2.0)
