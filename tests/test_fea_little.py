"""Little things under load: supports of a few nodes, areas that are narrow beside elements, what is left of balance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from boxes import Floats, box

import porelang
from porelang.diagnostics import PoreError
from porelang.fea import Force, Pressure, Problem, Support, Weight, solve
from porelang.fea.assemble import lame, stiffness
from porelang.fea.chords import area_off
from porelang.fea.covered import covered
from porelang.fea.loads import applied
from porelang.fea.narrow import pressed
from porelang.fea.nodes import number
from porelang.fea.surface import surface

CUBE = box((4, 4, 4), (20.0, 20.0, 20.0))
FOOT = Support(lambda p: p[:, 2] < 1e-9, name="foot")
TOP = Force(lambda p: p[:, 2] > 20 - 1e-9, (0.0, 0.0, 1.0), name="top")


def said(problem: Problem) -> dict[str, str]:
    return {d.code or "": f"{d.message}; {d.hint}" for d in solve(problem).doubts}


# ---- supports


def test_a_support_of_a_corner_and_middles_of_edges_holds() -> None:
    """Without such middles the corners alone could turn. The reference is elimination."""
    mesh = box((2, 2, 2), (10.0, 10.0, 10.0))
    spot = Support(lambda p: (p[:, 0] < 1e-9) & (np.hypot(p[:, 1] - 6.25, p[:, 2] - 6.25) < 2))
    load = Force(lambda p: p[:, 0] > 10 - 1e-9, (0.0, 1.0, 1.0))
    found = solve(Problem(mesh, 2000.0, 0.3, supports=(spot,), loads=(load,)), 1e-10)
    (held,) = found.held
    assert sorted(held < found.nodes.vertices) == [False, False, False, True]
    nodes = found.nodes
    constants = lame(np.full(len(mesh.tets), 2000.0), np.full(len(mesh.tets), 0.3))
    matrix = stiffness(nodes, constants).to_scipy().toarray()
    forces = applied(load, 0, nodes, surface(nodes), np.ones(len(mesh.tets))).forces.ravel()
    free = np.ones(nodes.points.shape, bool)
    free[held] = False
    moved = np.zeros(free.size)
    some = np.flatnonzero(free.ravel())
    moved[some] = np.linalg.solve(matrix[np.ix_(some, some)], forces[some])
    np.testing.assert_allclose(found.displacement.ravel(), moved, atol=1e-7 * np.abs(moved).max())
    assert found.iterations < 60


def test_a_support_without_area_is_doubted_unless_it_is_meant_as_a_line() -> None:
    """A strip of 2 mm in elements of 5 holds one row of nodes."""
    row = Support(lambda p: (p[:, 2] < 1e-9) & (np.abs(p[:, 0] - 10) < 1), name="strip")
    far = Support(lambda p: p[:, 2] > 20 - 1e-9, name="top")
    problem = Problem(CUBE, 2000.0, 0.3, supports=(row, far), loads=(Weight((0, 0, -9810.0)),))
    told = said(problem)["W288"]
    assert "the support `strip` holds nodes of a line or a point, no area, where 40 mm2 are selected" in told
    assert told.startswith("the support `strip`")
    line = replace(row, where=lambda p: (p[:, 2] < 1e-9) & (np.abs(p[:, 0] - 10) < 0.01))
    assert "W288" not in said(replace(problem, supports=(line, far)))


def test_a_support_that_is_smaller_than_elements_is_refused_as_such() -> None:
    spot = Support(lambda p: (p[:, 2] < 1e-9) & (np.hypot(p[:, 0] - 11.3, p[:, 1] - 12.1) < 0.3), name="pin")
    with pytest.raises(PoreError, match="E170") as caught:
        solve(Problem(CUBE, 2000.0, 0.3, supports=(spot,), loads=(TOP,)))
    (told,) = caught.value.diagnostics
    assert "the support `pin` selects 0.282 mm2 of the boundary, at (11.3, 12.1, 0) mm, and no node" in told.message
    assert "take elements of some 0.1 mm" in (told.hint or "")


# ---- areas

NARROW: dict[str, tuple[Callable[[Floats], Floats], float]] = {
    "spot": (lambda p: np.hypot(p[:, 0] - 11.3, p[:, 1] - 12.1) < 0.1, np.pi * 0.01),
    "disc": (lambda p: np.hypot(p[:, 0] - 11.3, p[:, 1] - 12.1) < 0.5, np.pi * 0.25),
    "strip": (lambda p: np.abs(p[:, 0] - 11.3) < 0.05, 2.0),
    "slanted strip": (lambda p: np.abs(p[:, 0] - 11.3 + 0.3 * (p[:, 1] - 10)) < 0.05, 2.0),
}


@pytest.mark.parametrize("which", NARROW)
def test_the_area_of_what_is_narrow_beside_elements_is_its_own(which: str) -> None:
    """In elements of 5 mm, to what they have of the sides beside the top."""
    where, area = NARROW[which]
    nodes = number(CUBE.vertices, CUBE.tets, 2)
    on = covered(lambda p: (p[:, 2] > 20 - 1e-6) & where(p), nodes, surface(nodes), "it")
    assert on.area == pytest.approx(area, rel=5e-3)
    assert on.all_seen


@pytest.mark.parametrize("slope", [0.0, 0.3])
def test_a_load_of_which_only_some_can_be_seen_is_refused(slope: float) -> None:
    thin = Pressure(lambda p: (p[:, 2] > 20 - 1e-6) & (np.abs(p[:, 0] - 11.3 + slope * (p[:, 1] - 10)) < 0.005), 1.0)
    with pytest.raises(PoreError, match="E170") as caught:
        solve(Problem(CUBE, 2000.0, 0.3, supports=(FOOT,), loads=(thin,)))
    (told,) = caught.value.diagnostics
    assert ("cannot be seen" if slope else "is looked at every 0.88 mm") in told.message
    assert "make it wider" in (told.hint or "")


@pytest.mark.parametrize("radius", [0.3, 0.5, 1.0])
def test_what_a_load_smaller_than_an_element_lacks_is_in_the_error(radius: float) -> None:
    """The mean displacement of a disc on a half-space is 16 (1 - nu2) F / (3 pi2 E a) [Timoshenko and Goodier, 139]."""

    def disc(p: Floats) -> Floats:
        return (p[:, 2] > 20 - 1e-6) & (np.hypot(p[:, 0] - 11.3, p[:, 1] - 12.1) < radius)

    problem = Problem(CUBE, 2000.0, 0.3, supports=(FOOT,), loads=(Force(disc, (0.0, 0.0, -1.0), name="pin"),))
    found = solve(problem)
    exact = 16 * (1 - 0.3**2) / (3 * np.pi**2 * 2000 * radius) + 20 / (2000 * 400)  # and the cube below it
    assert found.compliance < 0.5 * exact
    stated = (2 * found.error.relative**2 + found.unsure) * found.compliance
    assert exact - found.compliance < stated < 1.2 * exact
    assert "`pin` acts on" in said(problem)["W291"]
    assert "W291" not in said(replace(problem, loads=(TOP,)))


def strip(p: Floats) -> Floats:
    return (p[:, 2] > 20 - 1e-6) & (np.abs(p[:, 0] - 10.7) < 0.05)


def spots(p: Floats) -> Floats:
    return (p[:, 2] > 20 - 1e-6) & (np.hypot(np.abs(p[:, 0] - 10) - 5, np.abs(p[:, 1] - 10) - 5) < 0.5)


@pytest.mark.parametrize(("where", "exact"), [
    # plane strain and stress with 165,000 unknowns: 9.5 and 10.5e-5; four quarters of the cube with elements of 1.2 mm
    (strip, 1.0e-4),
    (spots, 1.2e-4),
])  # fmt: skip
def test_a_load_is_narrow_by_its_width_and_by_its_pieces(where: Callable[[Floats], Floats], exact: float) -> None:
    """A strip has more area than a face, and so have four spots together."""
    load = Force(where, (0.0, 0.0, -1.0), name="pin")
    problem = Problem(CUBE, 2000.0, 0.3, supports=(FOOT,), loads=(load,))
    found = solve(problem)
    stated = (2 * found.error.relative**2 + found.unsure) * found.compliance
    assert exact - found.compliance < stated < 2 * exact
    assert "`pin` acts on" in said(problem)["W291"]


def test_a_rectangle_on_a_half_space() -> None:
    """Means of 1 / r over pairs of places by chance, and a strip by its logarithm."""
    random = np.random.default_rng(0)
    for a, b in ((1.0, 1.0), (5.0, 0.5), (0.3, 2.0)):
        one, other = random.uniform(size=(2, 2_000_000, 2)) * (a, b)
        mean = float((1 / np.linalg.norm(one - other, axis=1)).mean())
        assert pressed(a, b) == pytest.approx(mean / np.pi, rel=5e-3)
    assert pressed(100, 0.1) - pressed(100, 0.2) == pytest.approx(2 * np.log(2) / (100 * np.pi), rel=1e-2)


# ---- balance


def pulled(reach: float, force: float = 1.0) -> Problem:
    """A cube that two forces pull on, of which the lower one is on what lies below x = `reach` alone."""
    low = Force(lambda p: (p[:, 2] < 1e-9) & (p[:, 0] < reach), (0.0, 0.0, -force))
    return Problem(CUBE, 2000.0, 0.3, loads=(TOP, low), balanced=True)


def test_what_elements_make_of_areas_is_balanced_and_said() -> None:
    """The middle of one area is .1 mm aside: what is left is .1 N mm, about y."""
    found = solve(pulled(19.8))
    (told,) = (d for d in found.doubts if d.code == "W289")
    assert "they add up to (0, 0, 0) N and (0, -0.1, 0) N mm about (10, 10, 10) mm" in told.message
    points = found.nodes.points - 10
    np.testing.assert_allclose(found.applied.sum(axis=0), 0, atol=1e-12)
    np.testing.assert_allclose(np.cross(points, found.applied).sum(axis=0), 0, atol=1e-10)
    assert found.unsure > 0.1 / 10 / 4  # of 2 N, at 10 mm
    whole = solve(pulled(20.1))
    assert "W289" not in {d.code for d in whole.doubts}
    np.testing.assert_allclose(found.displacement, whole.displacement, atol=0.1 * np.abs(whole.displacement).max())


@pytest.mark.parametrize(("text", "size", "area"), [
    ("cylinder(10, 16)", 3.0, 100 * np.pi),
    ("box([20, 20, 16])", 3.0, 400.0),
    ("gyroid(8) & box([16, 16, 16])", 1.5, 128.0),
])  # fmt: skip
def test_how_far_an_area_in_elements_may_be_off_is_seen_at_its_rim(text: str, size: float, area: float) -> None:
    """Closed forms: a disc, a square, and half of a square, which this section of a gyroid is."""
    mesh = porelang.compile(text).tet(size=size)
    nodes = number(mesh.vertices, mesh.tets, 1)
    on = covered(lambda p: p[:, 2] > 8 - 1e-6, nodes, surface(nodes), "it")
    off = area_off(nodes, np.unique(on.faces))
    assert abs(on.area - area) <= off + 1e-9 < 0.05 * area
    assert (off < 1e-9) is text.startswith("box")


def test_pressures_on_equal_ends_of_a_lattice_balance() -> None:
    """Their areas in elements differ by half a per cent; those of a box do not, and there the same is a mistake."""

    def ends(text: str, size: float, other: float) -> str:
        mesh = porelang.compile(text).tet(size=size)
        low, high = (Pressure(lambda p, s=s: s * p[:, 0] > 7.99, v) for s, v in ((-1, 1.0), (1, other)))  # type: ignore[misc]
        return said(Problem(mesh, 2000.0, 0.3, loads=(low, high), balanced=True, order=1)).get("W289", "")

    round_ = "rotate(gyroid(8) & cylinder(8, 16), [0, 1, 0], 90deg)"  # whose rims lean, to all sides
    for lattice, size in (("gyroid(8) & box([16, 16, 16])", 2.5), (round_, 3)):
        assert "do not quite balance" in ends(lattice, size, 1.0)
    rod, tube = (
        f"rotate({body}, [0, 1, 0], 90deg)" for body in ("cylinder(8, 16)", "cylinder(8, 16) \\ cylinder(4, 17)")
    )
    for text, other in (("box([16, 16, 16])", 1.005), (rod, 0.99), (tube, 0.97)):
        with pytest.raises(PoreError, match="E171"):
            ends(text, 4, other)


@pytest.mark.parametrize(("below", "wrong"), [(1.0, 0.0), (0.95, 10.05)])
def test_how_much_of_what_is_wrong_elements_do_not_tell_is_told(below: float, wrong: float) -> None:
    """A stem on a disc, pressed on both steps and from below: the ragged area of the stem may hide a slip of 5 %."""
    mesh = porelang.compile("cylinder(8, 20) | translate(cylinder(4, 20), [0, 0, 15])").tet(size=4)
    tops = [Pressure(lambda p, z=z: np.abs(p[:, 2] - z) < 0.01, 1.0) for z in (10, 25)]  # type: ignore[misc]
    under = Pressure(lambda p: p[:, 2] < -9.99, below)
    told = {d.code: d for d in solve(Problem(mesh, 2000.0, 0.3, loads=(*tops, under), balanced=True)).doubts}["W289"]
    assert told.hint is not None
    share = float(told.hint.split("wrong by less than ")[1].split(" ")[0])
    assert wrong / (2 * np.pi * 64) < share < 0.1


@pytest.mark.parametrize(
    ("problem", "motion", "left"),
    [
        (pulled(18.6), "(rotation about y through (10, 10, 10) mm)", "(0, -0.7, 0) N mm"),
        (pulled(16.0), "(rotation about y through (10, 10, 10) mm)", "(0, -2, 0) N mm"),
        (pulled(20.1, 1.002), "(translation along z)", "(0, 0, -0.002) N and (0, 0, 0) N mm"),
    ],
)
def test_what_loads_drive_is_named_and_no_other_motion(problem: Problem, motion: str, left: str) -> None:
    """Forces are given, and have no error: a part in a thousand too much of one is more than elements make."""
    with pytest.raises(PoreError, match="E171") as caught:
        solve(problem)
    (told,) = caught.value.diagnostics
    assert f"the loads drive a motion that nothing holds {motion}: they add up to" in told.message
    assert left in told.message


def test_a_poisson_ratio_next_to_a_half_is_said_as_it_is() -> None:
    told = said(Problem(box((2, 2, 2)), 2000.0, 0.499999, supports=(FOOT,), loads=(Weight((0, 0, -9810.0)),)))
    assert "Poisson's ratio is 0.499999:" in told["W259"]
