"""What a solve refuses, doubts, writes and tells on the way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from boxes import box, mesh_of, octant

from porelang.diagnostics import PoreError
from porelang.fea import BodyForce, Force, Moment, Pressure, Problem, Support, Weight, refined_sizes, solve, write
from porelang.progress import CancelledError, watching
from porelang.tet.tetmesh import TetMesh

MESH = box((2, 2, 2))
FOOT = Support(lambda p: p[:, 2] < 1e-9, name="foot")
PUSH = Force(lambda p: p[:, 2] > 0.99, (0.0, 0.0, -1.0), name="push")
GOOD = Problem(MESH, 2000.0, 0.3, supports=(FOOT,), loads=(PUSH,))

SLEEVE = Support(lambda p: p[:, 2] < 0.51, name="sleeve")


def with_support(**changes: Any) -> Problem:
    return replace(GOOD, supports=(replace(FOOT, **changes),))


def with_force(**changes: Any) -> Problem:
    return replace(GOOD, loads=(replace(PUSH, **changes),))


def apart(a: TetMesh, b: TetMesh, shift: tuple[float, float, float]) -> TetMesh:
    """Two meshes as one; vertices at the same place are one."""
    points = np.concatenate([a.vertices, b.vertices + shift])
    tets = np.concatenate([a.tets, b.tets + len(a.vertices)])
    _, first, same = np.unique(np.round(points, 9), axis=0, return_index=True, return_inverse=True)
    return mesh_of(points[first], same.ravel()[tets].astype(np.int64))


NAN = np.full(48, np.nan)
REFUSED: dict[str, tuple[Problem, str, str]] = {
    "no node": (with_support(where=lambda p: p[:, 2] < -0.2), "E170", "the support `foot` selects no node"),
    "how near": (with_force(where=lambda p: p[:, 2] > 1.2), "E170", "0.2 mm from what is selected"),
    "where it ends": (
        with_support(where=lambda p: p[:, 2] < 0),
        "E170",
        "it ends at the boundary, at (",
    ),
    "load on what is held": (
        replace(with_support(where=lambda p: p[:, 2] < 9), loads=(PUSH,)),
        "E173",
        "the force `push` does nothing: every node that it acts on is held against it",
    ),
    "load along what is held": (
        replace(GOOD, supports=(FOOT, Support(PUSH.where, (False, False, True)))),
        "E173",
        "does nothing",
    ),
    "load on little but what is held": (
        replace(GOOD, supports=(SLEEVE,), loads=(replace(PUSH, where=lambda p: abs(p[:, 2] - 0.27) < 0.25),)),
        "E173",
        "% of it is on nodes that are held against it",
    ),
    "far away": (with_force(where=lambda p: p[:, 2] > 90), "E170", "89 mm from what is selected"),
    "nothing at all": (with_force(where=lambda p: p[:, 2] > 9e9), "E170", "nor anything near"),
    "no pressure": (
        replace(GOOD, loads=(Pressure(lambda p: p[:, 0] > 2, 1.0, "oil"),)),
        "E170",
        "the pressure `oil` selects no area",
    ),
    "no moment": (replace(GOOD, loads=(Moment(lambda p: p[:, 0] > 2, (1.0, 0, 0)),)), "E170", "the moment number 1"),
    "slides": (
        with_support(axes=(False, False, True)),
        "E171",
        "translation along x, translation along y and rotation about z",
    ),
    "no support": (replace(GOOD, supports=()), "E171", "translation along z"),
    "driven": (
        replace(with_support(axes=(False, False, True)), balanced=True, loads=(replace(PUSH, total=(1.0, 0.0, 0.0)),)),
        "E171",
        "the loads drive a motion",
    ),
    "hinge about an edge": (
        with_support(where=lambda p: np.hypot(p[:, 0], p[:, 2]) < 1e-9),
        "E171",
        "rotation about y through (0, ",
    ),
    "negative modulus": (replace(GOOD, young=-1.0), "E172", "Young's modulus is -1 MPa"),
    "modulus nan": (replace(GOOD, young=NAN), "E172", "Young's modulus is nan MPa at ("),
    "modulus too short": (replace(GOOD, young=np.ones(3)), "E172", "has the shape (3,) for 48"),
    "incompressible": (replace(GOOD, poisson=0.5), "E172", "Poisson's ratio is 0.5"),
    "poisson": (replace(GOOD, poisson=-1.0), "E172", "Poisson's ratio is -1"),
    "density": (replace(GOOD, density=-1.0), "E172", "the density is -1 g/cm3"),
    "zero force": (with_force(total=(0.0, 0.0, 0.0)), "E173", "all its loads are 0"),
    "no load": (replace(GOOD, loads=()), "E173", "it has no load"),
    "force nan": (with_force(total=(np.nan, 0.0, 0.0)), "E173", "the force `push` is no number"),
    "force of two": (with_force(total=(1.0, 0.0)), "E173", "no three components"),
    "no axis": (with_support(axes=(False, False, False)), "E173", "holds no axis"),
    "numbers": (with_support(where=lambda p: p[:, 2]), "E174", "where True or False is wanted"),
    "field nan": (with_support(where=lambda p: p[:, 2] / 0 * np.nan), "E174", "is no number at ("),
    "wrong shape": (with_support(where=lambda p: True), "E174", "the shape ()"),
    "breaks": (with_support(where=lambda p: p[:, 7] > 0), "E174", "cannot be evaluated"),
    "displacement nan": (
        with_support(displacement=(0.0, np.nan, 0.0)),
        "E174",
        "the displacement of the support `foot`",
    ),
    "body force nan": (replace(GOOD, loads=(BodyForce(lambda p: p * np.nan),)), "E174", "the body force number 1"),
    "contradiction": (
        replace(GOOD, supports=(FOOT, replace(FOOT, displacement=(0.0, 0.0, 1.0), name="top"))),
        "E177",
        "the support `top` by 1 mm",
    ),
    "no tetrahedra": (
        replace(GOOD, mesh=replace(MESH, tets=MESH.tets[:0], phase=MESH.phase[:0])),
        "E175",
        "no tetrahedron",
    ),
    "island": (
        replace(GOOD, mesh=apart(MESH, MESH, (0.0, 0.0, 3.0)), loads=(Weight((0, 0, -1.0)),)),
        "E178",
        "is held nowhere",
    ),
}


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("name", REFUSED)
def test_is_refused(name: str) -> None:
    problem, code, words = REFUSED[name]
    with pytest.raises(PoreError) as caught:
        solve(problem)
    (told,) = caught.value.diagnostics
    assert told.code == code
    assert words in told.message
    assert told.hint


def test_meshes_that_are_none_are_refused() -> None:
    for change, words in (
        ({"tets": MESH.tets[:, [1, 0, 2, 3]]}, "flat or inside out"),
        ({"vertices": MESH.vertices * [1, 1, 0]}, "flat or inside out"),
        ({"tets": MESH.tets + 100}, "a vertex that is not there"),
        ({"vertices": np.vstack([MESH.vertices, [9, 9, 9]])}, "belong to no tetrahedron"),
        ({"vertices": np.where(MESH.vertices > 0.9, np.nan, MESH.vertices)}, "at no place"),
    ):
        arrays = {"vertices": MESH.vertices, "tets": MESH.tets, **change}
        with pytest.raises(PoreError, match="E175") as caught:
            solve(replace(GOOD, mesh=type("Mesh", (), arrays)()))
        assert words in str(caught.value)


def test_parts_that_hang_on_an_edge_are_refused() -> None:
    """Two blocks that share one edge turn about it, though every point is connected."""
    mesh = apart(MESH, MESH, (1.0, 0.0, 1.0))
    with pytest.raises(PoreError, match="meet only in an edge or a vertex"):
        solve(replace(GOOD, mesh=mesh, loads=(Weight((0, 0, -1.0)),)))
    held = (FOOT, Support(lambda p: p[:, 2] > 2 - 1e-9))
    assert solve(replace(GOOD, mesh=mesh, supports=held, loads=(Weight((0, 0, -1.0)),))).residual < 1.5e-8


def test_screw_motions_are_named() -> None:
    """A point held, and one axis at others: what is left is found by rank, not by a list of cases."""
    corner = Support(lambda p: np.linalg.norm(p, axis=1) < 1e-9)
    far = Support(lambda p: np.linalg.norm(p - 1.0, axis=1) < 1e-9)
    with pytest.raises(PoreError, match=r"rotation about \(0.577, 0.577, 0.577\) through"):
        solve(replace(GOOD, supports=(corner, far)))


def codes(problem: Problem) -> set[str]:
    found = solve(problem)
    assert all(d.severity == "warning" and d.hint for d in found.doubts)
    return {d.code for d in found.doubts}


def test_what_is_doubtful_is_said() -> None:
    plain = Problem(
        box((4, 4, 4)), 2000.0, 0.3, supports=(replace(FOOT, axes=(False, False, True)),), loads=(PUSH,), balanced=True
    )
    assert codes(plain) == set()
    two = apart(plain.mesh, plain.mesh, (3.0, 0.0, 0.0))  # type: ignore[arg-type]
    assert codes(replace(plain, mesh=two)) == {"W255"}
    assert "W256" in codes(
        replace(plain, mesh=box((6, 6, 1), (1.0, 1.0, 0.2)), loads=(Pressure(lambda p: p[:, 2] > 0.2 - 1e-9, 1.0),))
    )
    point = Support(
        lambda p: np.linalg.norm(p - [0.5, 0.5, 1.0], axis=1) < 1e-9, displacement=(0.0, 0.0, -0.1), name="tip"
    )
    assert {"W257", "W258"} <= codes(replace(plain, supports=(FOOT, point), loads=(), order=1, mesh=box((2, 2, 4))))
    half = Force(lambda p: (p[:, 2] > 0.2) & (p[:, 2] < 0.8), (0.0, 0.0, -1.0))
    assert "W286" in codes(replace(plain, supports=(SLEEVE,), loads=(half,)))
    beyond = replace(half, where=lambda p: p[:, 2] > 0.55)
    assert "W286" not in codes(replace(plain, supports=(SLEEVE,), loads=(beyond,)))
    strip = Support(lambda p: (p[:, 2] < 1e-9) & (p[:, 0] < 0.45), name="strip")  # a row of elements, .25 of .45
    assert codes(replace(plain, supports=(strip,), balanced=False)) - {"W257"} == {"W288"}
    assert codes(replace(plain, poisson=0.499)) == {"W259"}
    assert codes(replace(plain, poisson=0.46, order=1)) == {"W259"}


@pytest.mark.parametrize("gap", [0.4, 0.02, 3e-5])
def test_the_distance_to_a_selection_is_that_of_its_end(gap: float) -> None:
    """Not that of the points in which it is asked: of a half-space, and of a ball off a corner."""
    for where in (
        lambda p: p[:, 0] < -gap,
        lambda p: np.linalg.norm(p - (1 + (gap + 0.4) / np.sqrt(3)), axis=1) < 0.4,
    ):
        with pytest.raises(PoreError, match="E170") as caught:
            solve(with_support(where=where))
        said = float(caught.value.diagnostics[0].message.split(", and ")[1].split(" mm")[0])
        assert said == pytest.approx(gap, rel=0.02)


def test_a_pressure_on_a_ragged_area_is_doubted() -> None:
    """Inside a hollow sphere the middles of faces lie nearer to its centre than their corners."""
    mesh = octant(1.0, 2.0, 3, 2)
    inside = [Pressure(lambda q, r=r: np.linalg.norm(q, axis=1) < r, 3.0, "oil") for r in (0.99, 1.01)]
    planes = tuple(Support(lambda p, i=i: p[:, i] < 1e-9, tuple(i == k for k in range(3))) for i in range(3))
    ragged, whole = (solve(Problem(mesh, 100.0, 0.3, supports=planes, loads=(load,))) for load in inside)
    assert [d.code for d in ragged.doubts if d.code == "W280"] == ["W280"]
    assert "the pressure `oil` acts on a ragged area" in next(d.message for d in ragged.doubts if d.code == "W280")
    assert not [d for d in whole.doubts if d.code == "W280"]
    assert whole.loads[0].area == pytest.approx(4 * np.pi / 8, rel=0.05)
    assert whole.loads[0].force == pytest.approx([3 * np.pi / 4] * 3, rel=0.05)
    assert ragged.loads[0].area < 0.8 * whole.loads[0].area
    half = Pressure(lambda q: (q[:, 0] < 0.37) & (q[:, 2] > 0.99), 1.0)  # a cut through faces is none of that
    assert "W280" not in codes(replace(GOOD, loads=(half,)))


def soft(modulus: float) -> Problem:
    """A bar whose half next to its support is soft."""
    mesh = box((8, 3, 3), (8.0, 3.0, 3.0), jitter=0.2)
    young = np.where(mesh.vertices[mesh.tets].mean(axis=1)[:, 0] > 4, 2000.0, modulus)
    foot = Support(lambda p: p[:, 0] < 1e-9)
    return Problem(mesh, young, 0.3, supports=(foot,), loads=(Force(lambda p: p[:, 0] > 8 - 1e-9, (0.0, 0.0, -1.0)),))


def test_a_slender_bar_bends_as_it_does_and_says_how_sure_that_is() -> None:
    """Euler's and Timoshenko's cantilever of 1 : 200, in elements four times as long as wide: rounding ends iterations
    above what is asked, and the displacement is right within what is said."""
    long, force = 200.0, 1e-3
    foot, push = Support(lambda p: p[:, 2] < 1e-9), Force(lambda p: p[:, 2] > long - 1e-9, (force, 0.0, 0.0))
    found = solve(Problem(box((1, 1, 50), (1.0, 1.0, long)), 2000.0, 0.0, supports=(foot,), loads=(push,)))
    deflection = force * (long**3 / (3 * 2000 / 12) + long / (5 / 6 * 1000))
    assert found.compliance == pytest.approx(force * deflection, rel=1e-4)
    assert 1e-8 < found.residual < found.unsure < 1e-4
    (told,) = [d for d in found.doubts if d.code == "W281"]
    assert "displacements are sure to" in told.message


def test_what_rounding_ends_early_is_said_or_refused() -> None:
    """A stiff half on a soft one moves as a whole, by much: forces are differences of what is larger by orders."""
    stiff, rounded = solve(soft(1.0)), solve(soft(2e-3))
    assert not [d for d in stiff.doubts if d.code == "W281"]
    assert 1e-8 < rounded.residual < 1e-6
    assert [d.code for d in rounded.doubts if d.code == "W281"] == ["W281"]
    assert rounded.compliance * 2e-3 == pytest.approx(stiff.compliance, rel=2e-3)  # it is the soft half's
    with pytest.raises(PoreError, match="E176") as caught:
        solve(soft(1e-8))
    (told,) = caught.value.diagnostics
    assert "came no further than a residual of" in told.message
    assert told.hint is not None
    assert "leave out of the part what is softest, 1e-08 MPa at (" in told.hint
    assert "give it 0.2 MPa or more" in told.hint


def test_refinement_wants_a_share() -> None:
    found = solve(GOOD)
    for target in (0.0, 1.0, np.nan):
        with pytest.raises(PoreError, match="E173"):
            refined_sizes(found, target)
    with pytest.raises(PoreError, match="E173"):
        found.scaled(np.inf)


def test_moduli_of_a_wide_range_and_units_of_any_size() -> None:
    """Between 1 and 1e5 MPa; a part of 1e-3 mm and one of 1e4 mm: the same shares."""
    young = np.where(np.arange(48) % 7 == 0, 1e5, 1.0)
    base = solve(replace(GOOD, young=young))
    for size in (1e-3, 1e4):
        mesh = replace(MESH, vertices=MESH.vertices * size)
        found = solve(replace(GOOD, mesh=mesh, young=young, supports=(Support(lambda p, s=size: p[:, 2] < 1e-9 * s),),
                              loads=(Force(lambda p, s=size: p[:, 2] > 0.99 * s, (0.0, 0.0, -1.0)),)))  # fmt: skip
        np.testing.assert_allclose(
            found.displacement * size, base.displacement, atol=1e-6 * np.abs(base.displacement).max()
        )


def test_results_are_written(tmp_path: Path) -> None:
    """What ParaView reads: a point for each site, tensors in its order, directions as vectors."""
    centres = MESH.vertices[MESH.tets].mean(axis=1)
    found = solve(replace(GOOD, young=np.where(centres[:, 0] > 0.5, 9000.0, 2000.0)))
    path = tmp_path / "result.vtu"
    write(found, path)
    read = meshio.read(path)
    assert len(read.points) == len(found.stress) > len(MESH.vertices)
    np.testing.assert_array_equal(read.cells_dict["tetra"], found.sites.corners)
    np.testing.assert_allclose(read.points[found.sites.corners], MESH.vertices[MESH.tets])
    np.testing.assert_allclose(read.point_data["displacement"], found.at_vertices[found.sites.vertex])
    np.testing.assert_allclose(read.point_data["stress"], found.stress)
    values, axes = found.principal()
    np.testing.assert_allclose(read.point_data["principal3"], values[:, 2])
    np.testing.assert_allclose(read.point_data["direction1"], axes[:, 0])
    np.testing.assert_allclose(read.cell_data["error"][0], found.error.of_tets)
    energy = read.cell_data["energy_of_tet"][0].sum()
    assert 0.5 * found.compliance > energy > 0.2 * found.compliance
    before = path.read_bytes()
    with pytest.raises(PoreError, match="E113"):
        write(found, tmp_path / "result.txt")
    with pytest.raises(PoreError, match="E113"):
        write(found, tmp_path / "nowhere" / "result.vtu")
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["result.vtu"]


def test_progress_is_told_and_a_solve_can_be_ended() -> None:
    told: list[str] = []
    with watching(lambda what, done, total: told.append(what)):
        solve(GOOD)
    assert list(dict.fromkeys(told)) == ["assembling", "solving", "recovering stresses"]
    asked = 0

    def cancel() -> bool:
        nonlocal asked
        asked += 1
        return asked > stop

    stop = 0
    problem = replace(GOOD, mesh=box((6, 6, 6)))
    for limit in (0, 6):
        asked, stop = 0, limit
        with pytest.raises(CancelledError), watching(cancel=cancel):
            solve(problem)


def test_results_do_not_depend_on_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    results = []
    for threads in (1, 3):
        count: Callable[..., int] = lambda *_, t=threads: t  # noqa: E731
        monkeypatch.setattr("porelang.fea.assemble.workers", count)
        monkeypatch.setattr("porelang.fea.assemble._ROWS", 100)
        results.append(solve(replace(GOOD, mesh=box((5, 5, 5)))))
    np.testing.assert_array_equal(results[0].displacement, results[1].displacement)
    np.testing.assert_array_equal(results[0].stress, results[1].stress)
