"""What of a mesh is surface, and the distance to it: against closed forms, and trimesh asked for every triangle."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh

from porelang.tasks.shape import surface
from porelang.tasks.shape.distance import Sampled, distances
from porelang.tasks.shape.file import UnusableError
from porelang.tasks.shape.mend import distinct
from porelang.tasks.shape.soup import merged
from porelang.tasks.shape.surface import Closed, closed

pytestmark = pytest.mark.slow

Some = np.ndarray[Any, np.dtype[np.float64]]
ERROR = 0.3


def sampled(*bodies: trimesh.Trimesh, error: float = ERROR, margin: float = np.nan) -> Sampled:
    whole = trimesh.util.concatenate(bodies)
    places, numbers = merged(np.array(whole.vertices, np.float64))
    faces = numbers[np.array(whole.faces)]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    return distances(closed(places, np.ascontiguousarray(faces)), error, margin, lambda done, total: None)


def nodes(made: Sampled) -> Some:
    axes = [o + made.spacing * np.arange(n) for o, n in zip(made.origin, made.values.shape, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


def block(lo: Any, hi: Any) -> trimesh.Trimesh:
    return trimesh.creation.box(bounds=[lo, hi])


def to_block(p: Some, lo: Any, hi: Any) -> Some:
    """The distance to a block that may be flat, negative inside."""
    q = np.abs(p - 0.5 * np.add(lo, hi)) - 0.5 * np.subtract(hi, lo)
    return np.asarray(np.linalg.norm(np.maximum(q, 0), axis=-1) + np.minimum(q.max(axis=-1), 0))


def agrees(made: Sampled, known: Some) -> None:
    """Exact in the band, right in sign, and beyond the band never too little, nor too much by twice the error."""
    found = made.values.astype(np.float64)
    near = np.abs(known) <= 3 * made.spacing
    assert near.any()
    assert (~near).any()
    assert np.abs(found - known)[near].max() < 1e-5
    assert ((found < 0) == (known < 0))[np.abs(known) > 1e-5].all()
    excess = np.abs(found) - np.abs(known)
    assert excess.min() > -1e-5
    assert excess.max() <= 2 * made.error
    assert made.lost == 0


def test_blocks_that_overlap_or_touch_are_one_body() -> None:
    """Their ends lie within it, and are no surface: the whole is a block again."""
    whole = ([0, -3, -3], [16, 3, 3])
    for first, second in ((10, 6), (8, 8), (16, 4)):
        made = sampled(block(whole[0], [first, 3, 3]), block([second, -3, -3], whole[1]), error=0.5)
        agrees(made, to_block(nodes(made), *whole))


def cross(p: Some) -> Some:
    """The distance to two bars that cross, from its faces: all are rectangles."""
    flat = [([-10, -3, z], [10, 3, z]) for z in (-3, 3)] + [([-3, -10, z], [3, 10, z]) for z in (-3, 3)]
    for end in (-10, 10):
        flat += [([end, -3, -3], [end, 3, 3]), ([-3, end, -3], [3, end, 3])]
        for side in (-3, 3):
            low, high = min(end, np.sign(end) * 3), max(end, np.sign(end) * 3)
            flat += [([low, side, -3], [high, side, 3]), ([side, low, -3], [side, high, 3])]
    bars = np.minimum(to_block(p, [-10, -3, -3], [10, 3, 3]), to_block(p, [-3, -10, -3], [3, 10, 3]))
    away = np.min([to_block(p, *rectangle) for rectangle in flat], axis=0)
    return np.where(bars < 0, -away, away)


def test_what_crosses_is_cut_where_it_crosses() -> None:
    """Half of each bar's side walls lies within the other: large triangles are surface in part."""
    made = sampled(block([-10, -3, -3], [10, 3, 3]), block([-3, -10, -3], [3, 10, 3]), error=0.5)
    assert made.error == 0.5
    known, found = cross(nodes(made)), made.values
    near = np.abs(known) <= 3 * made.spacing
    assert np.abs(found - known)[near].max() < made.spacing / 32
    assert ((found < 0) == (known < 0))[np.abs(known) > 1e-5].all()
    assert (np.abs(found) - np.abs(known)).max() <= 2 * made.error


def test_foot_of_a_pin_in_a_wall() -> None:
    """What it covers of the wall is no surface, though that is hardly larger than the triangles looked at first."""
    wall = block([-6, -6, -6], [6, 6, 0])
    for x in (-3.0, -1.1, 2.0):
        made = sampled(wall, block([x - 0.15, 0.95, -3], [x + 0.15, 1.25, 3]))
        p = nodes(made)
        away = np.abs(p[..., :2] - [x, 1.1]).max(axis=-1)
        below = (away < 0.15) & (p[..., 2] < 0) & (p[..., 2] > -2.5 * made.spacing)
        known = -np.hypot(p[..., 2], 0.15 - away)[below]
        assert np.abs(made.values[below] - known).max(initial=0) < made.spacing / 32


def test_shells_that_are_turned_inwards() -> None:
    """One that crosses others is turned; one within another is a cavity if they are turned against each other."""
    bar, beside = block([-10, -3, -3], [10, 3, 3]), block([-3, -10, -3], [3, 10, 3])
    beside.invert()
    cavity, core = block([-8, -1, -1], [-6, 1, 1]), block([6, -1, -1], [8, 1, 1])
    cavity.invert()
    for turned in (False, True):
        bodies = [body.copy() for body in (bar, beside, cavity, core)]
        for body in bodies if turned else ():
            body.invert()
        made = sampled(*bodies, error=0.6)
        p = nodes(made)
        known = np.maximum(cross(p), -to_block(p, [-8, -1, -1], [-6, 1, 1]))
        assert ((made.values < 0) == (known < 0))[np.abs(known) > 1e-5].all()


def to_triangles(p: Some, mesh: trimesh.Trimesh) -> Some:
    """How far places (n, 3) are from a mesh, by trimesh, from every triangle."""
    triangles = np.asarray(mesh.triangles)
    least = np.full(len(p), np.inf)
    for triangle in triangles:
        foot = trimesh.triangles.closest_point(np.broadcast_to(triangle, (len(p), 3, 3)), p)
        least = np.minimum(least, np.linalg.norm(p - foot, axis=1))
    return least


@pytest.mark.parametrize(
    "mesh",
    [
        trimesh.creation.torus(6.0, 2.0, major_sections=24, minor_sections=12),
        trimesh.creation.icosphere(subdivisions=2, radius=6.0),
        trimesh.creation.cone(radius=4.0, height=9.0, sections=16),
        trimesh.creation.annulus(2.0, 5.0, 7.0, sections=20),
    ],
    ids=["torus", "ball", "cone", "tube"],
)
def test_distance_is_that_to_the_nearest_triangle(mesh: trimesh.Trimesh) -> None:
    made = sampled(mesh)
    some = np.random.default_rng(2).choice(made.values.size, 3000, replace=False)
    known = to_triangles(nodes(made).reshape(-1, 3)[some], mesh)
    found = np.abs(made.values.reshape(-1)[some].astype(np.float64))
    near = known <= 3 * made.spacing
    assert np.abs(found - known)[near].max() < 1e-5
    assert (found - known).min() > -1e-5
    assert (found - known).max() <= 2 * made.error
    assert made.lost == 0


def test_twice_the_error_is_not_far_from_what_happens() -> None:
    """The bound far from the surface is of use: in the middle of a ball values are too large by half of it."""
    made = sampled(trimesh.creation.icosphere(subdivisions=4, radius=10.0))
    known = np.linalg.norm(nodes(made), axis=-1) - 10
    excess = np.abs(made.values) - np.abs(known)
    assert 0.02 * made.error < made.beyond <= excess.max() + 0.05 < 2 * made.error


def test_triangles_without_area_and_those_that_stand_twice() -> None:
    box = block([-4, -5, -6], [4, 5, 6])
    corners = np.concatenate([box.vertices, box.vertices, [[0, 5, 6], [4, 5, 6], [-4, 5, 6]]])
    faces = np.concatenate([box.faces, box.faces[:5] + 8, [[16, 17, 18], [3, 3, 1], [2, 10, 2]]])
    for some in (faces, np.concatenate([box.faces, box.faces + 8])):
        made = sampled(trimesh.Trimesh(corners, some, process=False, validate=False))
        agrees(made, to_block(nodes(made), [-4, -5, -6], [4, 5, 6]))


def test_a_sheet_beside_a_body_is_none() -> None:
    sheet = trimesh.Trimesh([[-3, -3, 9], [3, -3, 9], [3, 3, 9], [-3, 3, 9]], [[0, 1, 2], [0, 2, 3]])
    made = sampled(block([-4, -5, -6], [4, 5, 6]), sheet)
    agrees(made, to_block(nodes(made), [-4, -5, -6], [4, 5, 6]))


def test_sign_of_a_ball_of_which_triangles_are_missing() -> None:
    """One in ten, each a hole of its own or together: flat rims are closed as they were, others nearly."""
    ball = trimesh.creation.icosphere(subdivisions=4, radius=10.0)
    ball.update_faces(np.random.default_rng(5).random(len(ball.faces)) > 0.1)
    made = sampled(ball)
    known = np.linalg.norm(nodes(made), axis=-1) - 10
    assert ((made.values < 0) == (known < 0))[np.abs(known) > 0.3].all()
    assert (np.abs(made.values - known)[np.abs(known) < 3 * made.spacing]).max() < 0.3


def test_walls_and_gaps_that_samples_miss_are_told_of() -> None:
    for thickness, lost in ((0.1, True), (1.0, False)):
        wall = sampled(block([0, 0, 0], [thickness, 20, 20]), error=0.5)
        assert (wall.lost > 0.5) == lost
        slit = sampled(block([0, 0, 0], [5, 20, 20]), block([5 + thickness, 0, 0], [9, 20, 20]), error=0.5)
        assert (slit.lost > 0.1) == lost


def repeats(ball: trimesh.Trimesh) -> dict[str, Some]:
    """Its triangles with some of them more than once."""
    faces = np.array(ball.faces)
    some = np.random.default_rng(1).permutation(len(faces))[:200]
    cap = np.flatnonzero(ball.triangles_center[:, 2] > 5)
    return {
        "some": np.concatenate([faces, faces[some]]),
        "some, turned": np.concatenate([faces, faces[some][:, ::-1]]),
        "some first": np.concatenate([faces[some][:, [1, 0, 2]], faces]),
        "a cap": np.concatenate([faces, faces[cap]]),
        "a cap, turned": np.concatenate([faces, faces[cap][:, ::-1]]),
        "a cap, three times": np.concatenate([faces, faces[cap], faces[cap]]),
        "all": np.concatenate([faces, faces]),
        "all, turned": np.concatenate([faces, faces[:, ::-1]]),
    }


@pytest.mark.parametrize("which", repeats(trimesh.creation.icosphere(subdivisions=1)))
def test_triangles_that_stand_more_than_once_change_nothing(which: str) -> None:
    ball = trimesh.creation.icosphere(subdivisions=4, radius=10.0)
    clean = sampled(ball, error=0.5)
    made = sampled(trimesh.Trimesh(ball.vertices, repeats(ball)[which], process=False), error=0.5)
    np.testing.assert_array_equal(made.values, clean.values)
    assert len(distinct(repeats(ball)[which])) == len(ball.faces)


def test_faces_in_common_are_kept_where_bodies_need_them() -> None:
    """Two blocks side by side: the face between them stands there and back. One in another: that in common, twice."""
    faces = {"beside": block([10, -3, -3], [20, 3, 3]), "within": block([4, -3, -3], [10, 3, 3])}
    for name, other in faces.items():
        first = block([0, -3, -3], [10, 3, 3])
        made = sampled(first, other)
        assert closed_of(first, other).holes == []
        agrees(made, to_block(nodes(made), [0, -3, -3], [20 if name == "beside" else 10, 3, 3]))


def closed_of(*bodies: trimesh.Trimesh, gap: float = 0.0) -> Closed:
    whole = trimesh.util.concatenate(bodies)
    places, numbers = merged(np.array(whole.vertices, np.float64))
    return closed(places, np.ascontiguousarray(numbers[np.array(whole.faces)]), gap)


def test_edges_that_meet_others_between_their_ends_are_no_holes() -> None:
    """Half of a ball is refined without its curvature: at the seam a large triangle meets two small ones."""
    ball = trimesh.creation.icosphere(subdivisions=4, radius=10.0)
    finer = ball.subdivide(np.flatnonzero(ball.triangles_center[:, 0] > 0))
    assert not finer.is_watertight
    assert closed_of(finer).holes == []
    clean, made = sampled(ball, error=0.5), sampled(finer, error=0.5)
    near = np.abs(clean.values) < 3 * made.spacing
    assert np.abs(clean.values - made.values)[near].max() < 1e-5
    assert ((clean.values < 0) == (made.values < 0)).all()
    assert made.error == 0.5


def test_seams_are_sewn() -> None:
    """A ball in two halves whose rims are a little apart and share no corner."""
    ball = trimesh.creation.icosphere(subdivisions=4, radius=10.0)
    middles = ball.triangles_center
    upper, lower = (
        ball.submesh([np.flatnonzero(side)], append=True) for side in (middles[:, 2] > 0, middles[:, 2] <= 0)
    )
    gap = 0.01
    lower = lower.subdivide(np.unique(np.flatnonzero(lower.triangles_center[:, 2] > -0.9)))
    lower.apply_translation([0, 0, -gap / 2])
    assert len(closed_of(upper, lower).holes) > 0
    assert closed_of(upper, lower, gap=gap).holes == []


def test_bits_are_limited_and_what_that_costs_is_stated(monkeypatch: pytest.MonkeyPatch) -> None:
    bars = block([-10, -3, -3], [10, 3, 3]), block([-3, -10, -3], [3, 10, 3])
    monkeypatch.setattr(surface, "MOST_BITS", 3000)
    made = sampled(*bars, error=0.4)
    assert made.error > 0.4
    known = cross(nodes(made))
    near = np.abs(known) <= 3 * made.spacing
    assert np.abs(made.values - known)[near].max() <= made.error


def test_triangles_at_random_are_refused() -> None:
    corners = np.random.default_rng(1).uniform(-50, 50, (1500, 3))
    faces = np.arange(len(corners)).reshape(-1, 3)
    with pytest.raises(UnusableError, match="E143"):
        distances(closed(corners, faces), 0.1, np.nan, lambda done, total: None)


def test_what_is_torn_or_crosses_itself_everywhere_is_refused_at_once() -> None:
    ball = trimesh.creation.icosphere(subdivisions=4, radius=10.0)
    random = np.random.default_rng(5)
    half = ball.copy()
    half.update_faces(random.random(len(ball.faces)) < 0.5)
    with pytest.raises(UnusableError, match="is torn"):
        closed_of(half)
    noisy = trimesh.Trimesh(ball.vertices + random.normal(0, 5, ball.vertices.shape), ball.faces, process=False)
    with pytest.raises(UnusableError, match="too many to be told apart"):
        distances(closed_of(noisy), 1.0, np.nan, lambda done, total: None)


def test_a_patch_whose_triangles_touch_nobody_fills_its_hole() -> None:
    """Closed one by one they would be flaps round nothing, and a fan over the hole would cut off what lies below."""
    ball = trimesh.creation.icosphere(subdivisions=4, radius=10.0)
    random = np.random.default_rng(5)
    loose = ball.triangles_center[:, 2] > 8
    corners = ball.triangles[loose] + random.normal(0, 0.05, (loose.sum(), 3, 3))
    patch = trimesh.Trimesh(corners.reshape(-1, 3), np.arange(3 * loose.sum()).reshape(-1, 3), process=False)
    ball.update_faces(~loose)
    made = sampled(ball, patch)
    known = np.linalg.norm(nodes(made), axis=-1) - 10
    assert ((made.values < 0) == (known < 0))[np.abs(known) > 0.3].all()
    assert (np.abs(made.values - known)[np.abs(known) < 3 * made.spacing]).max() < 0.3


def test_a_sheet_is_left_out_of_the_size_too() -> None:
    sheet = trimesh.Trimesh([[-3, -3, 90], [3, -3, 90], [3, 3, 90], [-3, 3, 90]], [[0, 1, 2], [0, 2, 3]])
    alone, beside = sampled(block([-4, -5, -6], [4, 5, 6])), sampled(block([-4, -5, -6], [4, 5, 6]), sheet)
    assert beside.values.shape == alone.values.shape
    assert (closed_of(block([-4, -5, -6], [4, 5, 6]), sheet).sheets, closed_of(sheet).sheets) == (1, 0)


def test_shells_within_others_that_are_no_cavities_are_counted() -> None:
    outer, inner = block([-4, -5, -6], [4, 5, 6]), block([-1, -1, -1], [1, 1, 1])
    assert closed_of(outer, inner).within == 1
    inner.invert()
    assert closed_of(outer, inner).within == 0
    assert closed_of(outer, block([5, 5, 5], [6, 6, 6])).within == 0


def test_fans_that_fold_are_no_walls() -> None:
    """Over a ragged rim a fan folds, and between its folds is outside: here a pillow 0.01 mm thick within a block."""
    whole = block([0, 0, 0], [20, 10, 10])
    ring = [[10, 2, 2], [10, 8, 2], [10, 8, 8], [10, 2, 8]]
    sides = [[a, (a + 1) % 4, 4] for a in range(4)] + [[(a + 1) % 4, a, 5] for a in range(4)]
    fold = trimesh.Trimesh([*ring, [10.005, 5, 5], [9.995, 5, 5]], sides, process=False)
    assert fold.volume > 0
    fold.invert()
    both = trimesh.util.concatenate([whole, fold])
    vertices, faces = np.array(both.vertices), np.ascontiguousarray(both.faces)
    depth = []
    for fans in (len(fold.faces), 0):  # as a cavity of the file it is kept
        made = distances(Closed(vertices, faces, [], fans), ERROR, np.nan, lambda done, total: None)
        middle = np.linalg.norm(nodes(made) - [10, 5, 5], axis=-1) < 1
        depth.append(float(-made.values[middle].max()))
    assert depth[0] > 3.9
    assert depth[1] < 1
