"""How far parts reach: against closed forms, proven from outside and witnessed from inside; what is shown are these."""

from __future__ import annotations

import itertools
import json
import math
from pathlib import Path

import numpy as np
import pytest

import porelang
from porelang.analysis import backwards
from porelang.analysis.bounds import rounding
from porelang.analysis.box import extent_of, has_ends
from porelang.analysis.kin import kin_of
from porelang.cli import main
from porelang.field import number_type, rounding_doubts
from porelang.formula import Formula
from porelang.measure import measure
from porelang.mesh.part import grid_of, surface_of

Corners = tuple[tuple[float, float, float], tuple[float, float, float]]


def both_ways(*half: float) -> Corners:
    x, y, z = half
    return (-x, -y, -z), (x, y, z)


def turned_box(half: tuple[float, float, float], axis: tuple[float, float, float], angle: float) -> Corners:
    """The box round a box that is turned about an axis through its middle (Rodrigues)."""
    k = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    turn = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
    corners = np.array(list(itertools.product(*((-h, h) for h in half)))) @ turn.T
    return tuple(corners.min(axis=0).tolist()), tuple(corners.max(axis=0).tolist())


def turned_cylinder(r: float, h: float, axis: tuple[float, float, float]) -> Corners:
    """The box round a cylinder along a direction u: r sqrt(1 - u_i^2) + h/2 |u_i| on each axis."""
    u = np.array(axis) / np.linalg.norm(axis)
    x, y, z = (r * np.sqrt(1 - u * u) + h / 2 * np.abs(u)).tolist()
    return both_ways(x, y, z)


def turned_balls(n: int, axis: tuple[float, float, float] = (0, 0, 1), angle: float = 0.0) -> Corners:
    """Balls of radius 1 on a circle of radius 10 in the xy plane, turned about an axis (Rodrigues)."""
    k = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    turn = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
    turns = 2 * math.pi * np.arange(n) / n
    at = 10 * np.stack([np.cos(turns), np.sin(turns), 0 * turns], 1) @ turn.T
    return tuple((at.min(axis=0) - 1).tolist()), tuple((at.max(axis=0) + 1).tolist())


def mirrored(corners: Corners) -> Corners:
    """In the plane x = 0."""
    (a, b, c), (d, e, f) = corners
    return (-d, b, c), (-a, e, f)


def twisted_box(half: tuple[float, float, float], tilt: float, rate: float) -> Corners:
    """The box round a box, tilted about x, then twisted about z: of its edges, where its cuts have corners."""
    along = np.linspace(-1, 1, 20001)
    c, s = math.cos(tilt), math.sin(tilt)
    edges = []
    for axis in range(3):
        for ends in itertools.product((-1.0, 1.0), repeat=2):
            edge = np.insert(np.broadcast_to(ends, (len(along), 2)), axis, along, axis=1) * half
            x, y, z = edge[:, 0], c * edge[:, 1] - s * edge[:, 2], s * edge[:, 1] + c * edge[:, 2]
            u, v = np.cos(rate * z), np.sin(rate * z)
            edges.append(np.stack([x * u + y * v, y * u - x * v, z], axis=1))
    found = np.concatenate(edges)
    return tuple(found.min(axis=0).tolist()), tuple(found.max(axis=0).tolist())


def moved(corners: Corners, by: tuple[float, float, float]) -> Corners:
    lo, hi = (np.add(corner, by).tolist() for corner in corners)
    return tuple(lo), tuple(hi)


TILTED = twisted_box((5, 5, 20), math.radians(20), math.radians(90) / 50)
BANGLE = """
let a = hypot(x, y) - 32
let k = atan(y, x) * 3 / 4
let u = a * cos(k) - z * sin(k)
let v = a * sin(k) + z * cos(k)
"""


def test_a_turn_by_an_angle_that_varies_keeps_lengths() -> None:
    """However a twist is written and whatever it is cut with, the part has an end: a turned circle is a torus."""
    for text in (
        "circle(3) @ [u, v, 0] & gyroid(5)",
        "circle(3) @ [u, v, 0] & shell(iwp(5), 3)",
        "rect(4, 4) @ [u, v, 0] & shell(iwp(5), 3)",
        "smooth_union(circle(3) @ [u, v, 0], sphere(3), 1)",
        "rotate(circle(3) @ [-v, u, 0], [1, 2, 3], 40deg)",
    ):
        box = porelang.compile(BANGLE + text).bounds()
        assert np.abs([box.lo, box.hi]).max() < 35.2
    box = porelang.compile(BANGLE + "circle(3) @ [u, v, 0]").bounds()
    assert np.allclose(box.hi, (35, 35, 3), atol=1)


ENDED = {  # the radius about the z axis, and half the height, that the twisted shape keeps to
    "twist(rotate(cylinder(2, 4), [0, 1, 0], 30deg), 0.2)": (2.74, math.sqrt(3) + 1),
    "twist(rotate(cone(2, 1, 4), [0, 1, 0], 30deg), 0.2)": (2.74, math.sqrt(3) + 1),
    "smooth_union(twist(rotate(box([2, 2, 4]), [1, 0, 0], 20deg), 0.1), sphere(1), 0.5)": (2.3, 2.4),
    "twist(rotate(twist(rotate(box([2, 2, 4]), [1, 0, 0], 20deg), 0.1), [0, 1, 0], 40deg), 0.2)": (2.9, 2.9),
    "(twist(rotate(cylinder(2, 4), [0, 1, 0], 30deg), 0.2) | sphere(1)) & gyroid(2)": (2.74, math.sqrt(3) + 1),
}


@pytest.mark.parametrize(("text", "most"), ENDED.items(), ids=list(ENDED))
def test_what_is_turned_and_then_twisted_has_an_end(text: str, most: tuple[float, float]) -> None:
    radius, height = most
    program = porelang.compile(text)
    box = program.bounds()
    assert np.abs([box.lo[:2], box.hi[:2]]).max() < 1.1 * radius
    assert max(-box.lo[2], box.hi[2]) < 1.1 * height
    points = np.random.default_rng(1).uniform(-4, 4, (100_000, 3))
    solid = points[program.field()(points) < 0]
    assert len(solid) > 100
    assert np.all((solid > box.lo) & (solid < box.hi))


def test_each_axis_has_its_own_error() -> None:
    """A film of 50 um on a plate of 2 m is not 50 um +- 20."""
    extent = extent_of(Formula.of(porelang.compile("box([2000, 2000, 0.05])").solid()))
    assert extent is not None
    assert extent.outer.size[2] == pytest.approx(0.05, abs=1e-12)
    assert extent.errors[2] < 1e-5
    # near the true ends where what is known of the formula alone is far larger
    text = "mirror(torus(3.21, 1.24), [1, 0, 0]) | translate(scale(sphere(2.98), [2, 2, 2]), [2.31, -3.25, -3.77])"
    box = porelang.compile(text).bounds()
    assert np.allclose(box, [[-4.45, -9.21, -9.73], [8.27, 4.45, 2.19]], atol=0.01)


def test_measures_tell_the_error_of_each_axis() -> None:
    design = porelang.compile("box([200, 200, 0.05])").design()
    found = design.measure(resolution=16)
    errors = found["error"]["bounds_by_axis"]
    assert found["error"]["bounds"] == max(errors)
    assert errors[2] < 1e-5
    assert "bounds_by_axis" not in [name for name, *_ in found.rows()]


COVERED = [
    r"cylinder(10, 50) \ cylinder(10, 60)",
    r"sphere(5) \ box([10, 10, 10])",
    r"rotate(cube(10), [1, 2, 3], 20deg) \ rotate(box([10, 12, 10]), [1, 2, 3], 20deg)",
    r"cone(5, 0, 9) \ cone(5, 0, 9)",
    r"(gyroid(5) & sphere(10)) \ sphere(10)",
]


@pytest.mark.parametrize("text", COVERED)
def test_what_is_cut_away_as_a_whole_is_told_so(text: str) -> None:
    with pytest.raises(porelang.PoreError, match="E103") as refused:
        porelang.compile(text).bounds()
    (found,) = refused.value.diagnostics
    assert found.label == "the second solid covers the first"
    assert found.span is not None
    assert found.span.text == "\\"
    assert found.span.start == text.rindex("\\")


@pytest.mark.parametrize(
    "text", ["gyroid(5) |> shell(0.4)", "hypot(x, y) - 5", "rotate(hypot(x, y) - 5, [1, 2, 3], 0.3)"]
)
def test_it_is_said_to_be_solid_far_out_only_where_it_is(text: str) -> None:
    with pytest.raises(porelang.PoreError, match=r"E102.*has no end along") as refused:
        porelang.compile(text).bounds()
    assert refused.value.diagnostics[0].label == "solid as far as one looks (100 m)"


#: A box that is turned by an angle which no cosine tells of: its end cannot be proven.
UNPROVEN = (
    "let t = 100 * z\nlet c = 1 / sqrt(1 + t^2)\nlet s = t * c\nbox([4, 4, 6]) @ [x * c - y * s, x * s + y * c, z]"
)


@pytest.mark.parametrize("at", [(0, 0, 0), (500, 20, 30)])
def test_where_no_end_is_proven_bounds_are_proposed_that_hold_the_part(at: Corners) -> None:
    program = porelang.compile(f"{UNPROVEN.replace('box', 'translate(box', 1)}, {list(at)})")
    with pytest.raises(porelang.PoreError, match=r"E102.*no end of `part` was proven along x, y") as refused:
        program.bounds()
    (found,) = refused.value.diagnostics
    assert "samples found none of it beyond" in found.label
    assert found.hint is not None
    proposed = [float(v) for v in found.hint.partition("--bounds=")[2].partition(" ")[0].strip(",").split(",")]
    lo, hi = np.array(proposed[:3]) - at, np.array(proposed[3:]) - at
    assert np.all(lo <= (-2, -2, -3))
    assert np.all(hi >= (2, 2, 3))
    assert np.abs([lo, hi]).max() < 4
    mesh = program.mesh(bounds=proposed, voxel=0.25)
    assert mesh.volume == pytest.approx(96, rel=0.1)


LENS = math.sqrt(100 - 7.5**2)
#: Programs and the true corners of their parts, by elementary geometry.
CLOSED: dict[str, Corners] = {
    "union([for i in range(7): translate(box([1, 1, 1]), [2*i, 0, 0.5])])": ((-0.5, -0.5, 0), (12.5, 0.5, 1)),
    "union([for i in range(8): translate(box([1, 1, 1]), [2*i, 0, 0.5])])": ((-0.5, -0.5, 0), (14.5, 0.5, 1)),
    "union([for i in range(200): translate(box([1, 2, 3], round=0.2), [2*i, 0, i / 10])])": (
        (-0.5, -1, -1.5),
        (398.5, 1, 21.4),
    ),
    "union([for i in range(9): translate(cylinder(1 + i / 10, 4), [5*i, 0, 0])])": ((-1, -1.8, -2), (41.8, 1.8, 2)),
    "union([for i in range(9): rotate(box([20, 2, 2]), [0, 0, 1], i * 20deg)]) & box([50, 50, 1])": both_ways(
        max(10 * math.cos(a) + math.sin(a) for a in np.radians([0, 20])),
        max(10 * math.sin(a) + abs(math.cos(a)) for a in np.radians([80, 100])),
        0.5,
    ),
    "rotate(box([10, 20, 30]), [1, 1, 0], 30deg)": turned_box((5, 10, 15), (1, 1, 0), math.pi / 6),
    "rotate(box([10, 20, 30]), [1, 2, 3], 35deg)": turned_box((5, 10, 15), (1, 2, 3), math.radians(35)),
    "rotate(cylinder(5, 30), [1, 0, 0], 90deg)": both_ways(5, 15, 5),
    "rotate(cylinder(5, 30), [1, 0, 0], 37deg)": turned_cylinder(
        5, 30, (0, -math.sin(math.radians(37)), math.cos(math.radians(37)))
    ),
    "twist(box([20, 10, 60]), 90deg / 60mm)": both_ways(
        math.hypot(10, 5), max(10 * math.sin(a) + 5 * math.cos(a) for a in np.linspace(0, math.pi / 4, 10001)), 30
    ),
    "smooth_union(sphere(10), translate(sphere(10), [12, 0, 0]), 4)": ((-10, -10, -10), (22, 10, 10)),
    "ring(translate(box([4, 2, 3]), [10, 0, 0]), 4)": both_ways(12, 12, 1.5),
    **{f"ring(translate(sphere(1), [10, 0, 0]), {n})": turned_balls(n) for n in (3, 4, 5, 6, 7, 12, 30)},
    "rotate(ring(translate(sphere(1), [10, 0, 0]), 5), [1, 2, 3], 40deg)": turned_balls(5, (1, 2, 3), math.radians(40)),
    "mirror(ring(translate(sphere(1), [10, 0, 0]), 3), [1, 0, 0])": mirrored(turned_balls(3)),
    "shell(ring(translate(sphere(0.8), [10, 0, 0]), 3), 0.4)": turned_balls(3),
    "ring(translate(ring(translate(sphere(1), [3, 0, 0]), 2), [20, 0, 0]), 2)": ((-24, -1, -1), (24, 1, 1)),
    "rotate(repeat(sphere(3), 10, counts=[3, 2, 1]), [0, 0, 1], 45deg)": both_ways(
        15 / math.sqrt(2) + 3, 15 / math.sqrt(2) + 3, 3
    ),
    "twist(rotate(box([10, 10, 40]), [1, 0, 0], 20deg), 90deg / 50mm)": TILTED,
    "translate(twist(rotate(box([10, 10, 40]), [1, 0, 0], 20deg), 90deg / 50mm), [10, 20, 30])": moved(
        TILTED, (10, 20, 30)
    ),
    "cone(20, 0, 30)": both_ways(20, 20, 15),
    "cone(10, 5, 30)": both_ways(10, 10, 15),
    "torus(20, 4)": both_ways(24, 24, 4),
    "ellipsoid([30, 20, 10])": both_ways(30, 20, 10),
    "tetrahedron(10)": both_ways(*3 * [10 * math.sqrt(3)]),
    "octahedron(10)": both_ways(*3 * [10 * math.sqrt(3)]),
    "prism(6, 10, 30)": both_ways(10, 10 * math.sin(math.pi / 3), 15),
    "sphere(10) & translate(sphere(10), [15, 0, 0])": ((5, -LENS, -LENS), (10, LENS, LENS)),
    "box([20, 20, 20]) \\ translate(box([20, 20, 20]), [5, 0, 0])": ((-10, -10, -10), (-5, 10, 10)),
    "sphere(10) \\ translate(sphere(20), [15, 0, 0])": (
        (-10, -math.sqrt(100 - (75 / 30) ** 2), -math.sqrt(100 - (75 / 30) ** 2)),
        (-75 / 30, math.sqrt(100 - (75 / 30) ** 2), math.sqrt(100 - (75 / 30) ** 2)),
    ),
    "translate(sphere(0.1), [90000, 0, 0])": ((89999.9, -0.1, -0.1), (90000.1, 0.1, 0.1)),
    "cube(0.002)": both_ways(0.001, 0.001, 0.001),
}


def _operations_read(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many operations each reading of a formula backwards takes."""
    looked: list[int] = []
    pushed_back = backwards._pushed_back

    def counted(kin, bound, times):  # type: ignore[no-untyped-def]
        looked.append(times * len(kin.formula.tape))
        return pushed_back(kin, bound, times)

    monkeypatch.setattr(backwards, "_pushed_back", counted)
    return looked


def test_a_bundle_of_tubes_is_bounded_without_its_bores(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each of 37 tubes was bounded together with all 37 bores, by every clamp in them: 2.5 minutes, now 1.3 s."""
    looked = _operations_read(monkeypatch)
    text = (
        "let spots = [for i in range(-3, 4) for j in range(-3, 4) if abs(i + j) <= 3: [12 * (i + j / 2), 10 * j, 0]]\n"
    )
    text += "let tubes = union([for q in spots: translate(cylinder(4, 200), q)])\n"
    text += "let sheets = union([for s in [-1, 1]: translate(cylinder(45, 6), [0, 0, 97 * s])])\n"
    text += "(tubes | sheets) \\ union([for q in spots: translate(cylinder(3.5, 202), q)])"
    found = porelang.compile(text).design().extent()
    assert found.outer == both_ways(45, 45, 100)
    assert sum(looked) < 100_000  # of 2 500 000


#: A helix of one turn, by nine points and as many between them.
HELIX = "let axis = spline([for i in range(9): [60 * cos(i * 45deg), 60 * sin(i * 45deg), 15 * i]], 2)\n"


def test_a_lattice_along_a_curve_ends_with_the_rod_that_cuts_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """The pieces of the rod were read one by one, and with each the whole of the lattice: 40 s, now 0.2 s."""
    looked = _operations_read(monkeypatch)
    program = porelang.compile(HELIX + "along(gyroid(8), axis, w=8mm) |> shell(0.8) & pipe(axis, 8mm)")
    assert has_ends(Formula.of(program.solid("part")))
    assert sum(looked) < 30_000  # of 1 200 000


def test_branches_of_a_field_without_an_end_are_not_followed_for_long(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each of sixteen corners is a choice, in which are those of the others: 20 s before, now less than one."""
    looked = _operations_read(monkeypatch)
    program = porelang.compile(HELIX + "along(gyroid(8), axis, w=8mm) |> shell(0.8)")
    assert not has_ends(Formula.of(program.solid("part")))
    assert sum(looked) < 100_000  # of 650 000


@pytest.mark.parametrize(("text", "corners"), CLOSED.items(), ids=list(CLOSED))
def test_the_extent_is_that_of_the_part(text: str, corners: Corners) -> None:
    """The true end lies between what is proven and what is witnessed, and these are near each other."""
    extent = extent_of(Formula.of(porelang.compile(text).solid("part")))
    assert extent is not None
    assert extent.inner is not None
    lo, hi = np.array(corners)
    longest = float((hi - lo).max())
    rounding = 1e-9 * (longest + np.abs([lo, hi]).max())
    assert np.all(np.array(extent.outer.lo) <= lo + rounding)
    assert np.all(np.array(extent.outer.hi) >= hi - rounding)
    assert np.all(np.array(extent.inner.lo) >= lo - rounding)
    assert np.all(np.array(extent.inner.hi) <= hi + rounding)
    off = max(float((lo - extent.outer.lo).max()), float((extent.outer.hi - hi).max()))
    assert off <= extent.error + rounding
    assert extent.error <= longest / 128, "wider than a voxel"


def test_copies_beside_their_sector_are_the_part_all_the_same() -> None:
    """A copy that does not fit in its sector is cut off there, and the box holds what is left and no more."""
    extent = extent_of(Formula.of(porelang.compile("ring(translate(box([2, 60, 2]), [10, 0, 0]), 3)").solid()))
    assert extent is not None
    # bars 60 long meet at the corners of a triangle round the circle of 11: 22 from the middle, the sector ends there
    corners = 22 * np.exp(2j * np.pi * (np.arange(3) + 0.5) / 3)
    lo, hi = np.array([corners.real.min(), corners.imag.min()]), np.array([corners.real.max(), corners.imag.max()])
    hi[0] = 11.0
    assert np.allclose(extent.outer.lo[:2], lo, atol=0.2)
    assert np.allclose(extent.outer.hi[:2], hi, atol=0.2)
    assert extent.error < 0.2


def test_a_part_that_is_void_is_told_from_one_that_is_thin() -> None:
    """Two shapes that touch in a face enclose nothing; a wall of a thousandth of the part is one."""
    with pytest.raises(porelang.PoreError, match="E103"):
        porelang.compile("box([10, 10, 10]) & translate(box([10, 10, 10]), [10, 0, 0])").bounds()
    thin = extent_of(Formula.of(porelang.compile('shell(box([20, 20, 20]), 0.02, side="inside")').solid()))
    assert thin is not None
    assert thin.outer.size == (20, 20, 20)
    assert thin.error < 0.01


def test_measures_are_relative_to_the_part_s_own_box() -> None:
    text = "union([for i in range(7): translate(box([1, 1, 1]), [2*i, 0, 0.5])])"
    found = measure(porelang.compile(text).design(), resolution=64)
    assert np.allclose(found["bounds"], [[-0.5, -0.5, 0], [12.5, 0.5, 1]], atol=1e-6)
    assert abs(found["porosity"] - (1 - 7 / 13)) <= found["error"]["porosity"] < 1e-3
    assert abs(found["envelope_volume"] - 13) <= found["error"]["envelope_volume"] < 0.02


def test_measures_within_bounds_tell_the_size_of_what_is_in_them() -> None:
    found = measure(porelang.compile("sphere(10)").design(), resolution=32, bounds=(-50, -50, 0, 50, 50, 50))
    assert np.allclose(found["bounds"], [[-10, -10, 0], [10, 10, 10]], atol=1e-6)
    with pytest.raises(porelang.PoreError, match="E103"):
        measure(porelang.compile("sphere(10)").design(), bounds=(20, 20, 20, 50, 50, 50))


@pytest.mark.parametrize("count", [7, 8])
def test_layers_begin_and_end_with_the_part(count: int, tmp_path: Path) -> None:
    path = tmp_path / "boxes.pore"
    path.write_text(f"union([for i in range({count}): translate(box([1, 1, 1]), [2*i, 0, 0.5])])\n")
    out = tmp_path / "layers"
    assert main(["slices", str(path), "-o", str(out), "--step", "0.1", "-q"]) == 0
    found = json.loads((out / "layers.json").read_text())
    assert found["layers"] == 10
    assert np.allclose(found["z"], 0.05 + 0.1 * np.arange(10), atol=1e-3)
    assert np.allclose(found["area"], count, rtol=0.05)


def test_closed_voids_and_separate_pieces_are_told_with_place_and_volume() -> None:
    text = (
        "let hollow = box([30, 20, 20]) \\ translate(sphere(6), [7, 0, 0]) \\ translate(sphere(4), [-8, 0, 1])\n"
        "(hollow \\ translate(cylinder(1, 20), [0, 8, 0])) | translate(sphere(2), [0, 0, 20])"
    )
    found = measure(porelang.compile(text).design(), resolution=96)
    large, small = found["voids"]
    for void, radius, middle in ((large, 6, (7, 0, 0)), (small, 4, (-8, 0, 1))):
        assert void["certain"]
        assert abs(void["volume"] - 4 / 3 * math.pi * radius**3) <= void["error"] < 0.1 * void["volume"]
        assert np.linalg.norm(np.subtract(void["at"], middle)) < 1
        assert np.allclose(void["size"], 2 * radius, atol=1)
    body, ball = found["pieces"]
    assert abs(ball["volume"] - 4 / 3 * math.pi * 8) <= ball["error"]
    assert np.linalg.norm(np.subtract(ball["at"], (0, 0, 20))) < 1
    solid = 12000 - 4 / 3 * math.pi * (216 + 64) - math.pi * 20
    assert abs(body["volume"] - solid) <= body["error"] < 0.05 * solid
    assert body["certain"] and ball["certain"]  # noqa: PT018


def test_a_drained_void_is_not_closed_and_one_piece_is_one() -> None:
    text = "sphere(10) \\ sphere(6) \\ translate(cylinder(1.5, 20), [0, 0, 10])"
    found = measure(porelang.compile(text).design(), resolution=64)
    assert found["voids"] == []
    assert len(found["pieces"]) == 1


@pytest.mark.usefixtures("roughly")
def test_the_text_says_what_is_not_certain(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "part.pore"
    path.write_text("sphere(10) \\ sphere(6)\n")
    assert main(["measure", str(path), "--resolution", "48"]) == 0
    told = capsys.readouterr().out
    assert "closed voids     1, where powder or resin stays: 90" in told
    assert "separate pieces" not in told
    path.write_text("shell(gyroid(10), 0.6) & sphere(15)\n")
    assert main(["measure", str(path), "--resolution", "20"]) == 0
    told = capsys.readouterr().out
    assert "not certain at this voxel" in told or "not known" in told
    assert not [line for line in told.splitlines() if "pieces of" in line and "+-" in line]


@pytest.mark.parametrize("far", [100_000, 200_000, 1e6])
def test_what_lies_beyond_the_world_is_told_in_one_way(far: float) -> None:
    """Whether it crosses the border, lies behind it, or is asked for there by bounds."""
    design = porelang.compile(f"translate(sphere(10), [{far}, 0, 0])").design()
    said = rf"E117.*lies more than 100 m from the origin, as far as {far + 10:,.0f} mm"
    with pytest.raises(porelang.PoreError, match=said):
        design.bounds()
    with pytest.raises(porelang.PoreError, match=r"E117.*100 m"):
        grid_of(design, bounds=(far - 20, -20, -20, far + 20, 20, 20))
    with pytest.raises(porelang.PoreError, match=r"E091.*lies more than 100 m from the origin"):
        porelang.compile(f'check volume(translate(sphere(10), [{far}, 0, 0])) > 1, "a"\nsphere(1)').reduced()
    with pytest.raises(porelang.PoreError, match=r"E102.*no end along x, y, z"):
        porelang.compile(f"gyroid(10) | translate(sphere(10), [{far}, 0, 0])").bounds()


@pytest.mark.parametrize("text", ["translate(sphere(0.1), [90000, 0, 0])", "translate(sphere(0.1), [0, -90000, 500])"])
def test_far_parts_are_computed_in_numbers_that_can_place_them(text: str) -> None:
    """At 90 m float32 has steps of 0.008 mm: the area of the ball came out 5 % too large."""
    design = porelang.compile(text).design()
    surface = surface_of(design, None, grid_of(design, resolution=64))
    assert abs(surface.area / (4 * math.pi * 0.01) - 1) < 1e-3
    assert abs(surface.volume / (4 / 3 * math.pi * 0.001) - 1) < 2e-3
    part, box = design.of(), design.bounds()
    assert number_type(part, box, 0.2 / 64, "numpy", "f32") == "f64"
    assert [d.code for d in rounding_doubts(part, box, 0.2 / 64, "glsl", "f32")] == ["W204"]
    off = rounding(part, box.lo, box.hi)
    assert 2**-9 < off < 2**-4  # half a step of float32 there is 2^-8 mm


def test_no_other_numbers_than_asked_for_where_float32_does() -> None:
    for text in (
        "gyroid(30) |> shell(1.53) & cylinder(75, 300)",
        "cube(0.002)",
        "rotate(cone(20, 5, 9), [1, 2, 3], 1)",
    ):
        design = porelang.compile(text).design()
        box = design.bounds()
        assert number_type(design.of(), box, max(box.size) / 1000, "numpy", "f32") == "f32"
        assert rounding_doubts(design.of(), box, max(box.size) / 1000, "glsl", "f32") == []


@pytest.mark.parametrize("radius", [5, 200_000])
def test_what_is_nowhere_negative_is_empty_and_not_far_away(radius: float) -> None:
    """A square is 0 on the sphere and nowhere below: as far as 5 mm is not beyond 100 m, nor is what is not there."""
    text = f"(x^2 + y^2 + z^2 - {radius}^2)^2"
    with pytest.raises(porelang.PoreError, match="E103"):
        porelang.compile(text).bounds()
    with pytest.raises(porelang.PoreError, match="E092"):
        porelang.compile(f'check volume({text}) > 1, "a"\nsphere(1)').reduced()
    with pytest.raises(porelang.PoreError, match="E092"):
        porelang.compile(f"sample(x, voxel=1, within={text}) & sphere(1)").bounds()


@pytest.mark.parametrize(
    ("text", "deep"),
    [
        ("offset(sphere(5mm), -5mm)", 5),  # a point, where the field is 0
        ("offset(sphere(5mm), -6mm)", 5),
        ("translate(offset(sphere(5mm), -6mm), [1, 0, 0])", 5),
        ("offset(torus(20, 4), -4.5)", 4),
        ("offset(box([80, 40, 6]), -8mm)", 3),
    ],
)
def test_a_part_that_its_offset_takes_away_is_told_at_the_offset_and_once(text: str, deep: float) -> None:
    program = porelang.compile(text)
    assert [d.code for d in program.warnings] == []
    with pytest.raises(porelang.PoreError) as refused:
        program.bounds()
    (found,) = refused.value.diagnostics
    assert (found.code, found.span.text) == ("E103", text[text.index("offset") :].split(", [1")[0])
    assert f"take away less than {deep} mm" in found.hint


def test_a_lattice_along_principal_directions_ends_with_what_it_is_cut_to() -> None:
    """A tensor's values and directions are one operation with several results, which is no number itself."""
    text = (
        "let T = tensor(x, y, z, x + y, y - z, z * x / 9mm)\n"
        "metric(gyroid(8) |> align(principal(T, 1).direction), steps=1) |> shell(0.8mm) & sphere(20)"
    )
    formula = porelang.compile(text).field().evaluator.formula
    assert has_ends(formula)
    (part,) = kin_of(formula)
    lo, hi = backwards.rough_boxes(part)
    assert np.allclose([lo[0], hi[0]], [[-20] * 3, [20] * 3], atol=1e-6)


def test_a_lattice_that_follows_data_is_there(tmp_path: Path) -> None:
    """Where data have no slope sums of products are 0, and ends that rounding set apart leave nothing of them."""
    x, _, z = np.meshgrid(np.arange(0, 61, 2), np.arange(0, 21, 2), np.arange(0, 17, 2), indexing="ij")
    u = np.stack([1 + 0.01 * x, 0.2 + 0 * x, 0.1 + 0.03 * z], -1)
    np.savez(tmp_path / "vec.npz", u=u, origin=np.zeros(3), spacing=2.0)
    (tmp_path / "part.pore").write_text(
        'let u = load_vector("vec.npz", "u")\n'
        "metric(gyroid(8) |> align(u)) |> shell(0.8mm) & (box([60, 20, 16]) |> translate([30, 10, 8]))"
    )
    formula = porelang.compile(path=tmp_path / "part.pore").field().evaluator.formula
    (part,) = kin_of(formula)
    lo, hi = backwards.rough_boxes(part)
    assert np.allclose([lo[0], hi[0]], [[0, 0, 0], [60, 20, 16]], atol=1e-6)


def test_ends_that_miss_each_other_by_a_rounding_leave_what_is_there() -> None:
    """0.1 e^a + 0.2 e^b where a and b are 0 is 0.30000000000000004, less 0.2 more than 0.1."""
    text = (
        "let a = max(min(x, 0mm), 0mm) / 1mm\nlet b = max(min(y, 0mm), 0mm) / 1mm\n"
        "sphere(10) & ((exp(a) * 0.1 + exp(b) * 0.2) * 1mm - 1mm)"
    )
    (part,) = kin_of(porelang.compile(text).field().evaluator.formula)
    lo, hi = backwards.rough_boxes(part)
    assert np.allclose([lo[0], hi[0]], [[-10] * 3, [10] * 3])
