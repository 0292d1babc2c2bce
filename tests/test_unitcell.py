"""Unit cells: against closed forms, an independent finite-element code, published theory, and themselves turned."""

from __future__ import annotations

import json
import re
import warnings
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import porelang
from porelang import store
from porelang.cli import main
from porelang.diagnostics import PoreError, PoreWarning
from porelang.homogenize.cell import sides_of
from porelang.homogenize.found import _error
from porelang.progress import CancelledError, watching
from porelang.unitcell import moduli
from porelang.unitcell.effective import conducted, homogenized, is_cyclic
from porelang.unitcell.extrapolate import CREASED, SMOOTH, definite_limit, limit
from porelang.unitcell.fractions import creases, fractions
from porelang.unitcell.grids import grids
from porelang.unitcell.hexahedron import isotropic
from porelang.unitcell.law import law, power
from porelang.unitcell.pieces import pieces_of

Floats = NDArray[np.float64]


def laminate(youngs: Floats, nu: float) -> Floats:
    """The stiffness of equal layers across z, by G. W. Milton, The Theory of Composites, 2002, ch. 9: averages of what
    is continuous across (stresses zz, yz, xz) or along (strains xx, yy, xy)."""
    across, along = [2, 3, 4], [0, 1, 5]
    n = {"inverse": np.zeros((3, 3)), "mixed": np.zeros((3, 3)), "rest": np.zeros((3, 3))}
    for e in youngs:
        c = e * isotropic(nu)
        nn, nt, tt = c[np.ix_(across, across)], c[np.ix_(across, along)], c[np.ix_(along, along)]
        inverse = np.linalg.inv(nn)
        n["inverse"] += inverse / len(youngs)
        n["mixed"] += inverse @ nt / len(youngs)
        n["rest"] += (tt - nt.T @ inverse @ nt) / len(youngs)
    out = np.zeros((6, 6))
    nn = np.linalg.inv(n["inverse"])
    out[np.ix_(across, across)] = nn
    out[np.ix_(across, along)] = nn @ n["mixed"]
    out[np.ix_(along, across)] = out[np.ix_(across, along)].T
    out[np.ix_(along, along)] = n["rest"] + n["mixed"].T @ nn @ n["mixed"]
    return out


#: Where strains go as axes are exchanged so that z becomes the named one.
ORDERS = {2: [0, 1, 2, 3, 4, 5], 0: [2, 1, 0, 5, 4, 3], 1: [0, 2, 1, 3, 5, 4]}


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_laminate_has_its_closed_form_in_all_constants(axis: int) -> None:
    youngs = np.array([1.0, 0.2, 0.2, 0.7, 0.7, 0.05])
    shape = [3, 4, 5]
    shape[axis] = 6
    density = np.moveaxis(np.broadcast_to(youngs, (shape[(axis + 1) % 3], shape[(axis + 2) % 3], 6)), -1, axis)
    cell = np.array([2.0, 3.0, 5.0])
    found = homogenized(np.ascontiguousarray(density), cell, 0.31, 1e-10)
    turn = ORDERS[axis]
    np.testing.assert_allclose(found.matrix, laminate(youngs, 0.31)[np.ix_(turn, turn)], atol=1e-9)
    heat = conducted(np.ascontiguousarray(density), cell, 1e-10).matrix
    series, parallel = 1 / np.mean(1 / youngs), youngs.mean()
    expected = np.diag([series if a == axis else parallel for a in range(3)])
    np.testing.assert_allclose(heat, expected, atol=1e-9)


def test_a_homogeneous_cell_is_its_solid() -> None:
    found = homogenized(np.full((3, 5, 4), 0.6), (1, 7, 2), 0.2)
    np.testing.assert_allclose(found.matrix, 0.6 * isotropic(0.2), atol=1e-13)
    assert found.steps == 0


def element(sides: Floats, stiffness: Floats) -> tuple[Floats, Floats]:
    """Stiffness and load of a trilinear brick by Gauss points, written anew: nodes with x fastest, displacements by
    component."""
    nodes = [(i, j, k) for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    points = (0.5 - 0.5 / 3**0.5, 0.5 + 0.5 / 3**0.5)
    k, f = np.zeros((24, 24)), np.zeros((24, 6))
    for at in product(points, repeat=3):
        b = np.zeros((6, 24))
        for n, corner in enumerate(nodes):
            factor = [at[a] if corner[a] else 1 - at[a] for a in range(3)]
            slope = [(1 if corner[a] else -1) / sides[a] for a in range(3)]
            dx, dy, dz = (slope[a] * factor[(a + 1) % 3] * factor[(a + 2) % 3] for a in range(3))
            b[:, [n, 8 + n, 16 + n]] = [[dx, 0, 0], [0, dy, 0], [0, 0, dz], [0, dz, dy], [dz, 0, dx], [dy, dx, 0]]
        weight = float(np.prod(sides)) / 8
        k += weight * b.T @ stiffness @ b
        f += weight * b.T @ stiffness
    return k, f


def assembled(density: Floats, cell: Floats, nu: float) -> Floats:
    """The effective stiffness by an assembled sparse matrix, factored."""
    from scipy import sparse
    from scipy.sparse.linalg import splu

    shape, c = density.shape, isotropic(nu)
    ke, fe = element(cell / shape, c)
    index = np.arange(density.size).reshape(shape)
    corners = [np.roll(index, (-i, -j, -k), (0, 1, 2)).ravel() for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    dofs = np.stack([3 * n + a for a in range(3) for n in corners], axis=1)
    rho, n = density.ravel(), 3 * density.size
    values = rho[:, None, None] * ke
    rows, cols = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
    k = sparse.csc_matrix((values.ravel(), (rows.ravel(), cols.ravel())), shape=(n, n))
    f = np.zeros((n, 6))
    for case in range(6):
        np.add.at(f[:, case], dofs, rho[:, None] * fe[:, case])
    u = np.zeros((n, 6))
    u[3:] = splu(k[3:, 3:]).solve(-f[3:])
    volume = float(np.prod(cell))
    return np.asarray(c * rho.mean() + f.T @ u / volume)


def test_an_assembled_code_finds_the_same() -> None:
    density = np.random.default_rng(3).uniform(0.01, 1, (8, 7, 6)) ** 3
    cell = np.array([2.0, 3.0, 1.0])
    found = homogenized(density, cell, 0.33, 1e-7)
    expected = assembled(density, cell, 0.33)
    assert np.abs(found.matrix - expected).max() < 1e-6 * expected.max()
    assert found.solved == 6


def sphere(n: int, radius: float) -> Floats:
    x = (np.arange(2 * n) + 0.5) / (2 * n) - 0.5
    return fractions(radius - np.sqrt(x[:, None, None] ** 2 + x[:, None] ** 2 + x**2), 2)


def test_few_spherical_voids_weaken_as_eshelby_has_it() -> None:
    """Bulk and shear modulus by J. D. Eshelby, Proc. R. Soc. A 241, 1957, for a share c of voids, to the order of c^2;
    the conductivity by Maxwell, to the order of c^(10/3)."""
    nu, k, g = 0.25, 1 / 1.5, 1 / 2.5
    share = 0.0
    sizes, found, heat = [], [], []
    for n in (16, 24, 32):
        density = sphere(n, 0.18)
        sizes.append(1 / n)
        found.append(homogenized(density, (1, 1, 1), nu).matrix)
        heat.append(conducted(density, (1, 1, 1)).matrix[0, 0])
        share = 1 - density.mean()
    assert share == pytest.approx(4 / 3 * np.pi * 0.18**3, rel=2e-3)
    mean = moduli.averages(limit(np.array(sizes), np.array(found)).value)
    bulk = 1 - share * (3 * k + 4 * g) / (4 * g)
    shear = 1 - share * 5 * (3 * k + 4 * g) / (9 * k + 8 * g)
    assert mean.bulk / k == pytest.approx(bulk, abs=4 * share**2)
    assert mean.shear / g == pytest.approx(shear, abs=4 * share**2)
    assert float(limit(np.array(sizes), np.array(heat)).value) == pytest.approx(2 * (1 - share) / (2 + share), abs=1e-3)


def waves(n: int, kind: str) -> Floats:
    """A gyroid or Schwarz P at the middles of n^3 parts of a period."""
    x = 2 * np.pi * (np.arange(n) + 0.5) / n
    a, b, c = np.meshgrid(x, x, x, indexing="ij")
    if kind == "gyroid":
        return np.asarray(np.sin(a) * np.cos(b) + np.sin(b) * np.cos(c) + np.sin(c) * np.cos(a))
    return np.asarray(np.cos(a) + np.cos(b) + np.cos(c))


def test_cases_that_a_rotation_gives_are_what_solving_all_gives(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a field that has the rotation about 111 and nothing else, so that all six shear couplings count."""
    field = waves(24, "gyroid")
    lean = np.sin(np.arange(24) * 2 * np.pi / 24)
    parts = [lean[:, None, None] * np.roll(lean, 5)[None, :, None] ** 2 * np.ones(24)]
    parts += [parts[0].transpose(2, 0, 1), parts[0].transpose(1, 2, 0)]
    density = fractions(field - 0.3 + 0.4 * sum(parts), 2)
    assert is_cyclic(density, np.ones(3))
    few = homogenized(density, (1, 1, 1), 0.3, 1e-7), conducted(density, (1, 1, 1), 1e-7)
    assert (few[0].solved, few[1].solved) == (2, 1)
    monkeypatch.setattr("porelang.unitcell.effective.is_cyclic", lambda *_: False)
    all_of_them = homogenized(density, (1, 1, 1), 0.3, 1e-7), conducted(density, (1, 1, 1), 1e-7)
    assert np.abs(few[0].matrix[:3, 3:]).max() > 1e-3  # it is no cubic cell
    for a, b in zip(few, all_of_them, strict=True):
        np.testing.assert_allclose(a.matrix, b.matrix, atol=1e-10)


def test_a_cell_turned_by_a_quarter_has_its_constants_turned() -> None:
    density = np.random.default_rng(1).uniform(0, 1, (6, 8, 4))
    here = homogenized(density, (3, 2, 1), 0.3, 1e-8).matrix
    there = homogenized(np.rot90(density, 1, (0, 1)).copy(), (2, 3, 1), 0.3, 1e-8).matrix
    # x becomes y and y becomes -x: xz becomes yz, yz becomes -xz, xy changes its sign
    turn, sign = [1, 0, 2, 4, 3, 5], np.array([1, 1, 1, -1, 1, -1])
    np.testing.assert_allclose(there, (sign[:, None] * here * sign)[np.ix_(turn, turn)], atol=1e-8)


@pytest.mark.parametrize("kind", ["gyroid", "schwarz_p"])
def test_thin_sheets_of_minimal_surfaces_near_the_bounds(kind: str) -> None:
    """Shells of minimal surfaces attain the bounds of the conductivity and the bulk modulus as they grow thin, the
    first to the third order of the density: D. Zhang and L. Liu, arXiv:2506.22319 and arXiv:2506.18910 (2025)."""
    k, g = 1 / 1.2, 1 / 2.6
    for t, off_heat, off_bulk in ((0.6, 0.09, 0.2), (0.25, 0.02, 0.06)):
        density = fractions(np.abs(waves(80, kind)) - t, 2)
        stiff = homogenized(density, (1, 1, 1), 0.3, 1e-4).matrix
        rho = float(density.mean())
        bounds = moduli.upper_bounds(rho, 0.3)
        bulk, heat = moduli.averages(stiff).bulk, conducted(density, (1, 1, 1)).matrix[0, 0]
        assert bulk < bounds["bulk"]
        assert heat < bounds["conductivity"]
        assert bulk == pytest.approx(4 * k * g / (4 * g + 3 * k) * rho, rel=off_bulk)
        assert heat == pytest.approx(2 / 3 * rho, rel=off_heat)


@pytest.mark.parametrize(("orders", "true"), [(SMOOTH, 2.0), (CREASED, 1.09), (CREASED, 1.5)])
def test_a_limit_is_known_to_what_its_order_is_known_to(orders: tuple[float, ...], true: float) -> None:
    """Of q + c h^p with grids that stray by a hundredth of what they differ by; and it is no wider than it must be."""
    h, random = 1 / np.array([24, 32, 48, 64]), np.random.default_rng(1)
    change = 10 * h[:, None] ** true
    values = 1 + change * (1 + 0.03 * random.normal(size=(4, 200)))
    found = limit(h, values, orders)
    off = np.abs(found.value - 1) / found.error
    assert (off <= 1).mean() > 0.95
    assert np.median(off) > 0.05
    # orders 1 and 2 through the two finest differ by 1.3 of what the finest is away by, where it goes as the square
    assert (found.error < 1.2 * change[-1]).all()
    assert limit(h, values, (true,)).error.mean() < found.error.mean()


def test_edges_are_seen_where_struts_meet_and_not_in_lattices_of_waves() -> None:
    """One cylinder has none, two that cross have; a gyroid, a sphere's void and a rounded crossing have none."""
    x = (np.arange(64) + 0.5) / 64 * 10 - 5
    a, b, c = x[:, None, None], x[None, :, None], x[None, None, :]
    one, two = np.hypot(a, b) - 1 + 0 * c, np.hypot(a, c) - 1 + 0 * b
    wave = waves(64, "gyroid")
    fields = {
        "one": one, "two": np.minimum(one, two), "sheet": np.abs(wave) - 0.4, "net": wave + 0.5,
        "void": 3 - np.sqrt(a**2 + b**2 + c**2), "round": -np.log(np.exp(-2 * one) + np.exp(-2 * two)) / 2,
        "meet from outside": np.maximum(one, two), "plates": np.abs(a) - 2 + 0 * (b + c),
    }  # fmt: skip
    share = {}
    for name, field in fields.items():
        cut, creased, flat = creases(np.concatenate([field[-1:], field, field[:1]]))
        assert cut > 500
        share[name] = creased / cut
        assert (flat / cut > 0.2) == (name == "plates")
    assert share.pop("two") > 5e-3
    assert set(share.values()) == {0.0}


def test_stated_errors_hold_what_finer_voxels_find() -> None:
    for t in (0.7,):
        values = {n: homogenized(fractions(np.abs(waves(2 * n, "gyroid")) - t, 2), (1, 1, 1), 0.3, 1e-4).matrix[0, 0]
                  for n in (12, 16, 24, 32, 48)}  # fmt: skip
        coarse = limit(1 / np.array([12, 16, 24, 32]), np.array([values[n] for n in (12, 16, 24, 32)]))
        # what 48 voxels find is above the truth, by 0.8 of its distance to 32 if errors go as the square
        truth = values[48] - np.array([0.0, 0.8]) * (values[32] - values[48])
        assert np.all(np.abs(coarse.value - truth) <= coarse.error)
        assert coarse.error < 0.04 * values[48]


def test_shares_of_voxels_are_those_of_planes_and_balls() -> None:
    normal, offset = np.array([0.3, -0.8, 0.52]), 0.05
    x = (np.arange(16) + 0.5) / 16 - 0.5
    plane = x[:, None, None] * normal[0] + x[:, None] * normal[1] + x * normal[2] - offset
    inside = fractions(plane, 4)[1:3, 1:3, 1:3]  # away from where the plane does not repeat
    points = (np.arange(200) + 0.5) / 200 / 2 - 0.25
    a, b, c = np.meshgrid(points, points, points, indexing="ij", sparse=True)
    counted = (a * normal[0] + b * normal[1] + c * normal[2] < offset).mean()
    assert inside.mean() == pytest.approx(counted, abs=2e-4)
    assert 1 - sphere(24, 0.4).mean() == pytest.approx(4 / 3 * np.pi * 0.4**3, rel=1e-3)


def test_pieces_are_joined_through_faces() -> None:
    solid = np.zeros((8, 8, 8), bool)
    solid[:, 2, 2] = True  # a rod along x
    solid[[0, 7], 5, 5] = True  # an island across the face
    solid[4, 4, 6] = True
    pieces = pieces_of(solid)
    assert [(round(p.share * solid.sum()), p.axes) for p in pieces] == [(8, ["x"]), (2, []), (1, [])]
    around = np.zeros((4, 4, 4), bool)
    for i in range(4):  # a staircase that comes back to itself one cell further along x and y
        around[i, i, 0] = around[(i + 1) % 4, i, 0] = True
    assert [p.axes for p in pieces_of(around)] == [["x", "y"]]


def test_moduli_are_those_of_a_crystal() -> None:
    """Copper by C11 168.4, C12 121.4, C44 75.4 GPa (J. F. Nye, Physical Properties of Crystals, 1985): the formulas for
    cubic crystals there."""
    c11, c12, c44 = 168.4, 121.4, 75.4
    c = moduli.cubic_matrix(c11, c12, c44)
    s11, s12 = (c11 + c12) / (c11 - c12) / (c11 + 2 * c12), -c12 / (c11 - c12) / (c11 + 2 * c12)
    s44 = 1 / c44
    for n in ((1, 0, 0), (1, 1, 0), (1, 1, 1), (3, 1, 2)):
        x, y, z = np.array(n) / np.linalg.norm(n)
        expected = 1 / (s11 - 2 * (s11 - s12 - s44 / 2) * (x * x * y * y + y * y * z * z + z * z * x * x))
        assert moduli.young(c, n)[0] == pytest.approx(expected)
    mean = moduli.averages(c)
    assert mean.bulk_voigt == pytest.approx((c11 + 2 * c12) / 3) == mean.bulk_reuss
    assert mean.shear_reuss == pytest.approx(5 * (c11 - c12) * c44 / (4 * c44 + 3 * (c11 - c12)))
    assert moduli.zener(c) == pytest.approx(2 * c44 / (c11 - c12))
    assert np.isnan(moduli.zener(np.diag([1.0, 2, 3, 1, 1, 1])))


def strains_turned(turn: Floats) -> Floats:
    """What makes strains by Voigt of those that are turned by a rotation; stresses go with its inverse's transpose."""
    pairs, out = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)], np.zeros((6, 6))
    for i, (a, b) in enumerate(pairs):
        for j, (c, d) in enumerate(pairs):
            both = turn[a, c] * turn[b, d] + (turn[a, d] * turn[b, c] if c != d else 0)
            out[i, j] = both * (1 if a == b else 2) / (1 if c == d else 2)
    return out


def plates_across(normal: Floats, share: float, nu: float) -> Floats:
    """The stiffness of plates of a share of the volume with nothing between: plane stress, in axes of the part."""
    flat = np.zeros((6, 6))
    flat[:2, :2] = share / (1 - nu**2) * np.array([[1, nu], [nu, 1]])
    flat[5, 5] = share / 2 / (1 + nu)
    first = np.cross(normal, [0.3, 0.5, 0.9])
    first /= np.linalg.norm(first)
    back = np.linalg.inv(strains_turned(np.stack([first, np.cross(normal, first), normal], axis=1)))
    return np.asarray(back.T @ flat @ back)


@pytest.mark.parametrize("normal", [(0, 0, 1), (1, 1, 0), (1, 1, 1), (3, 1, 2)])
def test_plates_that_lie_askew_have_e_along_them_and_none_across(normal: tuple[int, int, int]) -> None:
    n = np.array(normal) / np.linalg.norm(normal)
    c = plates_across(n, 0.37, 0.3)
    c += 1e-10 * np.diag([1, -1, 1, -1, 1, 1.0])  # what a solver leaves
    along = np.cross(n, [[1, 0, 0], [0, 1, 0.2], [0.3, 0.4, 1]])
    assert moduli.young(c, along) == pytest.approx([0.37] * 3, rel=1e-6)
    across = n + 0.001 * along
    assert moduli.young(c, [n, *across, n + along[1]]).tolist() == [0] * 5
    assert (moduli.averages(c).bulk_reuss, moduli.averages(c).shear_reuss) == (0, 0)
    assert moduli.free(c) == 3


@pytest.mark.parametrize("wrong", [[1, 0], [[0, 0, 0]], "x", [[1, 0, np.nan]], [[[1, 0, 0]]]])
def test_what_is_no_direction_is_refused(wrong: Any) -> None:
    with pytest.raises(PoreError, match=r"E108.*no directions"):
        moduli.young(np.eye(6), wrong)


def test_a_law_is_monotone_and_errs_as_it_says() -> None:
    rho = np.linspace(0.2, 0.8, 5)
    truth = lambda r: (0.75 * r**1.5)[:, None, None] * isotropic(0.3)  # noqa: E731
    found = law(rho, truth(rho), nu=0.3)
    between = np.linspace(0.2, 0.8, 41)
    off = np.abs(found.cubic(between) - np.array([moduli.cubic(c) for c in truth(between)]))
    assert (off <= found.error(between) + 1e-12).all()
    assert off.max() < 0.005
    assert (np.diff(found.young(np.linspace(0, 0.8, 81))) > 0).all()
    step = 1e-6
    numeric = (found.cubic(between[1:-1] + step) - found.cubic(between[1:-1] - step)) / 2 / step
    np.testing.assert_allclose(found.slope(between[1:-1]), numeric, rtol=1e-5)
    assert found.power.exponent == pytest.approx(1.5)
    with pytest.raises(PoreError, match="E183"):
        found.young(0.9)
    with pytest.raises(PoreError, match="E183"):
        law([0.3, 0.3], truth(np.array([0.3, 0.3])))
    with pytest.raises(PoreError, match="E183"):
        power([0.1, 0.2], [0.0, 0.1])


# ---- programs


def told(text: str, **more: Any) -> str:
    with pytest.raises(PoreError) as caught:
        porelang.compile(text).homogenize(**{"resolution": 8, **more})
    return str(caught.value)


@pytest.mark.parametrize(
    ("code", "text", "more"),
    [
        ("E180", "sphere(3)", {}),
        ("E180", "gyroid([10, 12, 14])", {}),
        ("E180", "gyroid(10) | schwarz_p(15)", {}),
        ("E108", "gyroid(10)", {"cell": (10, 10)}),
        ("E108", "gyroid(10)", {"cell": "0,10,10"}),
        ("E180", "gyroid(10)", {"cell": (10, 1000, 1000)}),
        ("E180", "gyroid(10)", {"resolution": 4}),
        ("E180", "let b = box([20mm, 10mm, 10mm])\ngyroid(phase=phase(5mm + x / 9, b)) & b", {}),
        ("E108", "param t = 1 in 0.2..2\ngyroid(10) |> shell(t)", {"sweep": "t=1..1:4"}),
        ("E181", "gyroid(10)", {"cell": "10,10,12"}),
        ("E181", "rotate(gyroid(10), [0, 0, 1], 30deg)", {}),
        # graded evenly, so that opposite faces agree; and only beyond the cell
        ("E181", "gyroid(10) |> shell(0.3 + 0.1 * hypot(x, y) / 1mm)", {}),
        ("E181", "gyroid(10) |> thicken(-ramp(hypot(x, y), 0mm, 7mm), 0.4) |> shell(0.5)", {}),
        ("E181", "(gyroid(10) |> shell(0.5 + 0.3 * ramp(hypot(x, y), 20mm, 60mm))) & cylinder(75, 100)", {}),
        ("E182", "gyroid(30) & sphere(20)", {}),
        ("E182", "translate(sphere(2), [50, 0, 0])", {"cell": "5"}),
        ("E182", "gyroid(10) + sqrt(x - 20)", {"cell": "5"}),
        ("E183", "gyroid(10)", {"nu": 0.5}),
        ("E183", "gyroid(10)", {"nu": -1}),
    ],
)
def test_what_is_no_cell_is_refused(code: str, text: str, more: dict[str, Any]) -> None:
    found = told(text, **more)
    assert f"error[{code}]" in found
    assert "hint:" in found


@pytest.mark.parametrize(
    ("phase", "length"),
    [("phase(1cm, b)", 10.0), ("phase(w, b)", 12.0), ("phase([1cm, 1cm, 2cm], b)", None), ("phase(9 + z / 9, b)", None),
     ('phase(1cm, b, cells="whole")', None)],
)  # fmt: skip
def test_a_phase_of_one_size_is_a_lattice_of_that_period(phase: str, length: float | None) -> None:
    text = f"param w = 12mm in 5mm..20mm\nlet b = box([20mm, 20mm, 20mm])\ngyroid(phase={phase}) |> shell(1) & b"
    design = porelang.compile(text).design()
    if length is not None:
        assert sides_of(design, "part", None).tolist() == [length] * 3
        return
    with pytest.raises(PoreError, match="E180"):
        sides_of(design, "part", None)


def test_what_strays_is_shown_where_it_is_nearest_to_the_cell() -> None:
    """And of a union it is said how an envelope of all of it is written."""
    found = told("gyroid(10) |> shell(0.3 + 0.1 * hypot(x, y) / 1mm)")
    places = [float(v) for v in re.findall(r"-?[\d.]+", found.split(" at (")[1].split(")")[0])]
    assert max(map(abs, places)) < 15
    assert "(a | b) & body" not in found
    assert "(a | b) & body" in told("schwarz_p(10) | gyroid(20) & cylinder(40, 60)")


def test_a_mismatch_names_its_place_and_numbers() -> None:
    found = told("gyroid(10)", cell="10,10,12")
    assert "across z" in found
    assert "cell" in found
    assert found.count(" mm and ") == 1


@pytest.mark.parametrize(
    ("code", "text", "cell"),
    [
        ("W260", "gyroid(10)", "10,10,10.002"),
        ("W261", "(abs(z) - 1) | sphere(0.5, [0, 0, 3.5])", "10"),
        ("W262", "abs(z) - 2", "10"),
        ("W263", "gyroid(10) |> shell(0.2)", "10"),
    ],
)
def test_what_is_doubtful_of_a_cell_is_told(code: str, text: str, cell: str) -> None:
    if code == "W261":
        text = "(abs(z) - 1) | translate(sphere(1), [0, 0, 3])"
    with pytest.warns(PoreWarning, match=code):
        porelang.compile(text).homogenize(cell=cell, resolution=16)


def test_plates_and_balls_come_apart() -> None:
    plates = porelang.compile("abs(z) - 2").homogenize(cell="10", resolution=10)
    assert plates.numbers["E.100"] == pytest.approx(0.4)
    assert plates.numbers["E.001"] == 0
    np.testing.assert_allclose(plates.conductivity, np.diag([0.4, 0.4, 0]), atol=1e-9)
    balls = porelang.compile("sphere(3)").homogenize(cell="10", resolution=12)
    assert [balls.numbers[f"E.{n}"] for n in moduli.NAMED] == [0] * 5
    assert np.isnan(balls.report()["zener"])
    full = porelang.compile("sphere(30)").homogenize(cell="10", resolution=8)
    assert full.density == pytest.approx(1)
    np.testing.assert_allclose(full.stiffness, isotropic(0.3), atol=1e-12)


@pytest.mark.parametrize(
    ("text", "normal", "resolution"),
    [("sin(tau*(x+z)/10mm) + 0.3", (1, 0, 1), 16), ("sin(tau*(x+y+z)/10mm) + 0.4", (1, 1, 1), 24)],
)  # fmt: skip
def test_laminates_that_lie_askew_are_exact(text: str, normal: tuple[int, int, int], resolution: int) -> None:
    found = porelang.compile(text).homogenize(cell=10, resolution=resolution)
    n = np.array(normal) / np.linalg.norm(normal)
    share = 0.5 - np.arcsin(float(text.split("+ ")[1]) if "+ " in text else 0.0) / np.pi
    assert found.density == pytest.approx(share, abs=max(found.density_error, 2e-4))
    expected = plates_across(n, found.density, 0.3)
    assert (np.abs(found.stiffness - expected) <= found.stiffness_error + 1e-9).all()
    np.testing.assert_allclose(found.stiffness, expected, atol=2e-3 * expected.max())
    for key, along in moduli.NAMED.items():
        truth = share if np.dot(along, n) == 0 else 0.0
        assert abs(found.numbers[f"E.{key}"] - truth) <= found.errors[f"E.{key}"] + 2e-4 * truth, key
    report = found.report()
    assert [v for v in (report["bulk"], report["shear"], found.numbers["bulk"]) if not np.isnan(v)] == []
    assert "nothing resists in some mode" in str(found)
    pixels = np.asarray(found.picture().pixels)[100:-120, :700, :3].astype(int)
    assert (np.ptp(pixels, axis=2) > 40).mean() > 0.1  # a disc, not an empty picture


def test_a_period_cut_by_its_own_box_is_that_period() -> None:
    free = porelang.compile("gyroid(10) |> shell(1.2)").homogenize(resolution=16)
    cut = porelang.compile("translate((gyroid(10) |> shell(1.2)) & cube(10), [7, 0, -3])").homogenize(
        cell="10", resolution=16
    )
    np.testing.assert_allclose(cut.low, [2, -5, -8], atol=1e-2)
    np.testing.assert_allclose(cut.stiffness, free.stiffness, atol=2e-3)


def test_an_envelope_beyond_the_cell_changes_nothing() -> None:
    free = porelang.compile("gyroid(10) |> shell(1.2)").homogenize(resolution=8)
    cut = porelang.compile("(gyroid(10) |> shell(1.2)) & cylinder(40, 60)").homogenize(resolution=8)
    np.testing.assert_allclose(cut.stiffness, free.stiffness, atol=1e-12)


def test_a_cell_that_is_long_where_nothing_varies_is_refined_where_something_does() -> None:
    """Tubes along z that touch nothing: E along them is the density, and nothing resists across."""
    text = "let k = tau/10mm\ncos(k*x)*cos(k*y) + 0.3*(cos(2*k*x)+cos(2*k*y)) |> shell(0.4)"
    cube, long = (porelang.compile(text).homogenize(cell=cell, resolution=16) for cell in ("10", "10,10,150"))
    assert [level.voxels for level in long.levels] == [(6, 6, 2), (8, 8, 2), (12, 12, 2), (16, 16, 2)]
    np.testing.assert_allclose(long.stiffness, cube.stiffness, atol=1e-9)
    assert long.density == pytest.approx(cube.density)
    assert long.numbers["E.001"] == pytest.approx(long.density, abs=long.errors["E.001"])
    assert long.numbers["E.100"] == 0
    # something varies along z: then the short sides have 24 voxels, and errors that are known
    found = grids(np.array([10.0, 10, 100]), (True, True, True), 64)
    assert found.voxels == ((9, 9, 90), (12, 12, 120), (18, 18, 180), (24, 24, 240))
    assert all(s % v == 0 for voxels in found.voxels for s, v in zip(found.samples, voxels, strict=True))


#: Struts of a radius on the axes.
STRUT = "capsule([{}, {}, {}], [{}, {}, {}], {{0}})"
STRUTS = " | ".join(STRUT.format(*-along, *along) for along in 10 * np.eye(3, dtype=int))
#: Struts along the diagonals of a cell of 10.
DIAGONALS = " | ".join(STRUT.format(-5, -b, -c, 5, b, c) for b in (5, -5) for c in (5, -5))
#: Moduli by quadratic tetrahedra on an eighth of the cell between mirror planes, scikit-fem, 27 to 104 thousand
#: unknowns, meshed by `pore tet`; for a cell of 10 mm, a solid of nu 0.3. (Diagonals: 370 thousand, `porelang.fea`.)
TETRAHEDRA = {
    "metric(schwarz_p(10)) |> shell(0.6667mm)": {"C11": 0.06381, "C12": 0.04217, "nu.100": 0.39789, "bulk": 0.04938,
                                                 "conductivity": 0.10509},
    "metric(iwp(10)) |> shell(0.6667mm)": {"C11": 0.10569, "C12": 0.03074, "conductivity": 0.15584},
    "schwarz_p(10) + 0.7": {"C11": 0.12369, "bulk": 0.04930, "conductivity": 0.13114},
    DIAGONALS.format(0.8): {"C11": 0.01986, "C12": 0.01805, "E.100": 0.00268, "bulk": 0.018653},
    STRUTS.format(0.5): {"E.100": 0.00807, "nu.100": 0.02452, "bulk": 0.00283, "conductivity": 0.00818},
}  # fmt: skip


def test_rods_along_111_have_their_density_along_them() -> None:
    """E along fibres with nothing between is their share, and none across; 32 voxels made .042 +- .036 of .078."""
    at = [(0, 0, 0), (10, 0, 0), (0, 10, 0), (0, 0, 10), (-10, 0, 0), (0, -10, 0), (0, 0, -10)]
    text = " | ".join(STRUT.format(*(v - 15 for v in a), *(v + 15 for v in a)).format(1.2) for a in at)
    found = porelang.compile(text).homogenize(cell=10, resolution=16)
    share = np.pi * 1.2**2 * 10 * 3**0.5 / 1000
    assert abs(found.numbers["E.111"] - share) <= found.errors["E.111"] < 0.05 * share
    assert [found.numbers[f"E.{key}"] for key in ("100", "010", "001", "110")] == [0] * 4
    assert found.young([[1, -1, 0], [1, 1, 1.01]]).tolist() == [0, 0]


@pytest.mark.parametrize(
    ("text", "resolution"), [("schwarz_p(10) + 0.7", 32)] + [(t, 32 if "iwp" in t else 16) for t in TETRAHEDRA]
)
def test_stated_errors_hold_what_tetrahedra_find(text: str, resolution: int) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PoreWarning)
        found = porelang.compile(text).homogenize(cell=10, resolution=resolution)
    numbers = found.numbers | {"C11": found.stiffness[0, 0], "C12": found.stiffness[0, 1]}
    errors = found.errors | {"C11": found.stiffness_error[0, 0], "C12": found.stiffness_error[0, 1]}
    for name, expected in TETRAHEDRA[text].items():
        assert abs(numbers[name] - expected) <= errors[name] + 2e-4 * expected, name


@pytest.mark.parametrize(("radius", "resolution"), [(0.5, 24), (1.0, 24), (0.05, 8)])
def test_struts_on_the_axes_have_a_density_in_closed_form_and_resist_in_every_mode(
    radius: float, resolution: int
) -> None:
    """Three cylinders less what they share: V = 3 pi r^2 a - 8 sqrt(2) r^3 (Steinmetz), for a cell of the side a."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = porelang.compile(STRUTS.format(radius)).homogenize(cell=10, resolution=resolution)
    density = (3 * np.pi * radius**2 * 10 - 8 * 2**0.5 * radius**3) / 1000
    assert abs(found.density - density) <= found.density_error
    assert np.linalg.eigvalsh(found.stiffness).min() > 0
    assert np.linalg.eigvalsh(found.conductivity).min() > 0
    assert found.numbers["zener"] > 0
    # a strut that is cut free of the others carries its share of the face, and those around it add little to that
    alone = np.pi * radius**2 / 100
    for name in ("E.100", "conductivity"):
        assert alone < found.numbers[name] + found.errors[name]
        assert found.numbers[name] - found.errors[name] < alone * (1 + radius)
    # G is a seventieth of E, and known to nine tenths of itself: that moves nothing, and is not warned of
    assert found.errors["G.xy"] > 0.5 * found.numbers["G.xy"]
    assert any("W263" in str(w.message) for w in caught) == (radius < 1)


def test_a_thin_sheet_is_told_to_be_coarse_and_not_to_be_islands() -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        porelang.compile("gyroid(30) |> shell(0.04)").homogenize(resolution=16)
    said = [str(w.message) for w in caught]
    assert not any("W261" in text or "W262" in text for text in said)
    assert sum("W263" in text for text in said) == 2


def test_a_mode_that_nothing_resists_stays_without() -> None:
    h = 8 / np.array([3, 4, 6, 8])
    rod = np.zeros((4, 6, 6))
    rod[:, 2, 2] = 1 + 0.1 * h**2
    found = definite_limit(h, rod)
    assert abs(found.value[2, 2] - 1) <= found.error[2, 2] < 0.15
    assert np.count_nonzero(found.value) == 1
    turned = np.linalg.qr(np.random.default_rng(0).normal(size=(6, 6)))[0]
    modes = np.array([1.0, 0.5, 0.3, 0.2, 0.1, 1e-6]) * (1 + np.array([0.01, 0.02, 0.1, 0.1, 0.2, 5]) * h[:, None] ** 2)
    mixed = turned @ (modes[:, :, None] * np.eye(6)) @ turned.T
    assert 0 < np.linalg.eigvalsh(definite_limit(h, mixed).value).min() < 6e-6
    modes[:, 5] = 1e-6 * np.array([40, 20, 10, 3])  # falls faster than any order: below 0 entry by entry
    mixed = turned @ (modes[:, :, None] * np.eye(6)) @ turned.T
    assert np.linalg.eigvalsh(limit(h, mixed).value).min() < 0
    found = definite_limit(h, mixed)
    assert 0 < np.linalg.eigvalsh(found.value).min() < 3e-6
    truth = turned @ np.diag([1.0, 0.5, 0.3, 0.2, 0.1, 0]) @ turned.T
    assert (found.error >= np.abs(found.value - truth)).all()


def test_python_reads_what_commands_read(lattice: Path) -> None:
    program = porelang.compile(path=str(lattice))
    one = program.homogenize("cell", resolution="8", nu="0.3", cell="10")
    for cell in (10, ["10mm", "1cm", 10], np.array([10.0, 10, 10])):
        assert (program.homogenize("cell", resolution=8, cell=cell).stiffness == one.stiffness).all()
    with pytest.raises(PoreError, match="E108"):
        program.homogenize("cell", nu=None)
    with pytest.raises(PoreError, match=r"(?s)E108.*no whole number.*resolution=64"):
        program.homogenize("cell", resolution=16.5)
    with pytest.raises(PoreError, match=r"(?s)E108.*is no sweep.*t=0\.2"):
        program.homogenize("cell", sweep={"t": (0.4, 2)})
    text = str(one)
    assert "E 100" in text
    assert "Zener ratio" in text
    assert len(repr(one)) < 500


@pytest.mark.parametrize(
    "words",
    [
        ["--nu", "0.5"],
        ["--resolution", "1000"],
        ["--cell", "1e-9"],
        ["--cell", "-3,3,3"],
        ["--cell", "0,10,10"],
        ["--sweep", "t=0.4..1:0"],
        ["--sweep", "t=0.4..1:99999"],
        ["--sweep", "t=0.5..0.5:3"],
        ["--sweep", "t=2..0.4:4"],
    ],
)
def test_wrong_usage_ends_with_2(words: list[str], lattice: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["homogenize", str(lattice), "--out", "cell", *words]) == 2
    assert "needs a value" not in capsys.readouterr().err


def test_a_sweep_is_not_of_what_is_set(lattice: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["homogenize", str(lattice), "--out", "cell", "--set", "t=1", "--sweep", "t=0.4..1:2"]) == 2
    assert "`t` is swept, and set to one value as well" in capsys.readouterr().err
    with pytest.raises(PoreError, match="is swept, and set"):
        porelang.compile(path=str(lattice)).homogenize("cell", sweep="t=0.4..1:2", t=1)


def test_the_table_of_a_sweep_has_columns_and_its_warnings_their_values(
    lattice: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--out", "cell", "--resolution", "8", "--sweep", "t=0.5..1.5:3"]
    assert main(["homogenize", str(lattice), *words]) == 0
    told = capsys.readouterr()
    rows = told.out.splitlines()[1:5]
    assert len({len(row) for row in rows}) == 1
    assert [len([cell for cell in row.split("  ") if cell]) for row in rows] == [7] * 4
    assert "with t = 0.5, 8 voxels" in told.err


def test_what_was_solved_is_kept(lattice: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = porelang.compile(path=str(lattice))
    first = program.homogenize("cell", resolution=8, t=0.77)
    store.forget()  # what is in memory; on disk it stays

    def never(*_: Any, **__: Any) -> Any:
        raise AssertionError("it is solved again")

    monkeypatch.setattr("porelang.homogenize.kept.homogenized", never)
    again = program.homogenize("cell", resolution=8, t=0.77)
    assert (again.stiffness == first.stiffness).all()
    assert (again.conductivity_error == first.conductivity_error).all()
    assert [level.stiffness.steps for level in again.levels] == [level.stiffness.steps for level in first.levels]
    with pytest.raises(AssertionError, match="solved again"):
        program.homogenize("cell", resolution=8, t=0.77, nu=0.31)


def test_a_law_of_what_is_not_cubic_is_refused() -> None:
    text = "param t = 0.5 in 0.3..1.2\ngyroid([10, 12, 15]) |> shell(t)"
    swept = porelang.compile(text).homogenize(cell="10,12,15", sweep="t=0.6..1.2:2", resolution=8)
    with pytest.raises(PoreError, match=r"E183.*away from a cubic"):
        _ = swept.law
    assert "E 010" in str(swept)
    assert "nu xz" in str(swept.found[0])


def test_a_sweep_of_plates_has_the_powers_that_there_are() -> None:
    swept = porelang.compile("param t = 2 in 1..4\nabs(x) - t").homogenize(
        cell="10", sweep="t=1.25..2.5:2", resolution=16
    )
    assert set(swept.fits) == {"conductivity"}
    assert swept.fits["conductivity"].exponent == pytest.approx(1, abs=0.01)
    assert "none" in str(swept)
    assert [row["E.010"] for row in swept.rows()] == pytest.approx(swept.density)


def test_numbers_that_some_grids_lack_have_no_known_error() -> None:
    assert np.isnan(_error(float("nan"), np.array([1.0, 1, 1, 1]), 0, SMOOTH, 0.04))
    assert _error(1.0, np.array([1.0, 1, 1, np.nan]), 0, SMOOTH, 0.04) == np.inf
    assert 0.01 < _error(1.0, np.array([np.nan, 1.2, 1.1, 1]), 0, SMOOTH, 0.04) < np.inf


def test_a_longer_cell_of_the_same_lattice_is_the_same_material() -> None:
    one = porelang.compile("gyroid([6, 9, 12]) |> shell(1.4)").homogenize(cell="6,9,12", resolution=16)
    two = porelang.compile("gyroid([6, 9, 12]) |> shell(1.4)").homogenize(cell="12,9,12", resolution=16)
    assert [level.stiffness.solved for level in one.levels] == [6] * 4
    # 16 along the shortest side make 32 along the longest, and that is told
    assert one.levels[-1].voxels == (16, 24, 32)
    assert "16 were asked for" in str(one)
    assert "were asked for" not in str(porelang.compile("gyroid(10)").homogenize(resolution=8))
    np.testing.assert_allclose(one.stiffness, two.stiffness, atol=float(one.stiffness_error.max() + 1e-3))
    assert len({round(one.numbers[f"E.{n}"], 3) for n in ("100", "010", "001")}) == 3


def test_a_cancelled_run_ends() -> None:
    with pytest.raises(CancelledError), watching(cancel=lambda: True):
        porelang.compile("gyroid(10)").homogenize(resolution=16)


@pytest.fixture
def lattice(tmp_path: Path) -> Path:
    path = tmp_path / "lattice.pore"
    path.write_text("param t = 1 in 0.3..2\nout cell = gyroid(10) |> shell(t)\nout part = cell & cylinder(20, 30)\n")
    return path


def test_the_command_prints_and_writes(lattice: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = [lattice.with_suffix(ending) for ending in (".png", ".csv", ".json")]
    outputs = [word for file in files for word in ("-o", str(file))]
    assert main(["homogenize", str(lattice), "--out", "cell", "--resolution", "12", "--json", *outputs]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found) >= {"density", "stiffness", "E", "nu", "zener", "bulk", "shear", "conductivity", "error",
                          "hashin_shtrikman"}  # fmt: skip
    assert np.shape(found["stiffness"]) == (6, 6)
    assert 0.2 < found["density"] < 0.5
    assert found["E"]["100"] < found["hashin_shtrikman"]["E"]
    assert files[0].read_bytes().startswith(b"\x89PNG")
    table = np.genfromtxt(files[1], delimiter=",", names=True)
    along_x = table[(table["azimuth_deg"] == 0) & (table["elevation_deg"] == 0)]
    assert along_x["E"][0] == pytest.approx(found["E"]["100"])
    assert json.loads(files[2].read_text()) == found
    assert main(["homogenize", str(lattice), "--out", "cell", "--resolution", "8", "-q"]) == 0
    told = capsys.readouterr()  # a result all the same
    assert "Zener ratio" in told.out
    assert not told.err
    assert main(["homogenize", str(lattice), "-o", str(lattice.with_suffix(".txt"))]) == 2


def test_a_sweep_has_a_power_and_a_law(lattice: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = lattice.with_suffix(".csv")
    words = ["--out", "cell", "--resolution", "10", "--sweep", "t=0.8..2:3"]
    assert main(["homogenize", str(lattice), *words, "--json", "-o", str(table), "-o", str(table)[:-3] + "png"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [row["t"] for row in found["rows"]] == [0.8, 1.4, 2.0]
    assert found["fits"]["E"]["r2"] > 0.98
    assert 1 < found["fits"]["E"]["exponent"] < 3  # ten voxels, and dense sheets
    _, *rows = table.read_text().splitlines()
    assert [float(row.split(",")[0]) for row in rows] == [0.8, 1.4, 2.0]
    assert all(float(cell) >= 0 for row in rows for cell in row.split(","))
    swept = porelang.compile(path=str(lattice)).homogenize("cell", resolution=8, sweep="t=0.8..2:3")
    rho = swept.density[1]
    assert swept.law.young([rho])[0] == pytest.approx(swept.found[1].numbers["E.100"], rel=1e-2)
