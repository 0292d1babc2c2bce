"""Struts in cells: the cells against what is known of them, and what `truss` makes of them against every bar."""

from __future__ import annotations

import json
from collections import Counter
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import porelang
from porelang.assist import complete
from porelang.data import Segments
from porelang.diagnostics import PoreError
from porelang.ir import show
from porelang.ops import segments as ops
from porelang.ops.strut_cells import CELLS
from porelang.session import Session

Values = NDArray[Any]
RNG = np.random.default_rng(31)
P = RNG.uniform(-25, 25, (2000, 3))


def bars_of(name: str) -> Values:
    """The bars of a cell (n, 2, 3) in its parts."""
    return np.array(CELLS[name].bars)


def distance(ends: Values, points: Values, period: Any = 1.0, reach: int = 2) -> Values:
    """The distance in mm of points (n, 3) to the axes of bars, in 5^3 copies of the cell about each."""
    w = np.broadcast_to(np.asarray(period, float), 3)
    at = points - np.floor(points / w) * w
    best = np.full(len(at), np.inf)
    for (a, b), k in product(ends * w, product(range(-reach, reach + 1), repeat=3)):
        v, e = at - a - np.array(k) * w, b - a
        t = np.clip(v @ e / (e @ e), 0, 1)
        best = np.minimum(best, ((v - t[:, None] * e) ** 2).sum(axis=1))
    return np.sqrt(best)


# ---- the cells -------------------------------------------------------------------------------------------------------
#: An eighth of each cell of the reference tool: ends of struts, in halves of the cell from its middle to a corner
#: (Axolotl 1.0, primitives/lattice.py; the last of compas_vol, where its inner ends lie at 0.2 of the cell).
CUBE = {0: (0, 0, 0), 1: (1, 0, 0), 2: (1, 1, 0), 3: (0, 1, 0), 4: (0, 0, 1), 5: (1, 0, 1), 6: (1, 1, 1), 7: (0, 1, 1),
        8: (0.5, 0, 0), 11: (0, 0.5, 0), 13: (1, 0, 0.5), 15: (0, 1, 0.5), 17: (1, 0.5, 1), 18: (0.5, 1, 1),
        20: (0.4, 0, 0), 21: (0, 0.4, 0), 22: (0, 0, 0.4)}  # fmt: skip
GRID, BIGX, CROSS = [(6, 2), (6, 5), (6, 7)], [(0, 6)], [(1, 6), (3, 6), (4, 6)]
OCTAGON, DUAL = [(1, 3), (3, 4), (4, 1)], [(0, 1), (0, 3), (0, 4)]
EIGHTHS = {
    "bigx": BIGX, "grid": GRID, "star": GRID + BIGX, "cross": CROSS, "octagon": OCTAGON, "octet": CROSS + OCTAGON,
    "vintile": [(8, 13), (13, 17), (17, 18), (18, 15), (15, 11), (11, 8)], "dual": DUAL, "interlock": GRID + DUAL,
    "isotrop": [(0, 1), (2, 1), (5, 1), (7, 1), (3, 7), (6, 7), (4, 7)], "hextruss": [(6, 20), (6, 21), (6, 22)],
}  # fmt: skip


@pytest.mark.parametrize("name", EIGHTHS)
def test_the_reference_tools_cells_are_its_own(name: str) -> None:
    points = RNG.uniform(-2, 2, (500, 3))
    folded = 2 * np.abs(points % 1.0 - 0.5)  # in the eighth that the tool mirrors
    best = np.full(len(points), np.inf)
    for i, j in EIGHTHS[name]:
        a, b = np.array(CUBE[i], float), np.array(CUBE[j], float)
        t = np.clip((folded - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        best = np.minimum(best, np.linalg.norm(folded - a - t[:, None] * (b - a), axis=1) / 2)
    np.testing.assert_allclose(distance(bars_of(name), points), best, atol=1e-9)


@pytest.mark.parametrize("name", CELLS)
def test_as_many_bars_meet_as_is_said(name: str) -> None:
    met = Counter(tuple(np.round(end % 1.0, 6) % 1.0) for end in bars_of(name).reshape(-1, 3))
    assert set(met.values()) == CELLS[name].met
    assert CELLS[name].source
    assert CELLS[name].doc


@pytest.mark.parametrize("name", CELLS)
def test_each_net_goes_on_through_every_face(name: str) -> None:
    """From any node one comes along bars to the same node in the next cell along x, y and z."""
    ends = bars_of(name)
    nodes: dict[tuple[float, ...], tuple[int, ...]] = {}
    place: dict[int, tuple[int, Values]] = {}  # a node's root, and the cells between the two
    loops: dict[int, list[Values]] = {}
    numbers, cells = [], []
    for end in ends.reshape(-1, 3):
        cell = np.floor(end + 1e-6)
        key = tuple(np.round(end - cell, 6))
        nodes.setdefault(key, (len(nodes),))
        numbers.append(nodes[key][0])
        cells.append(cell.astype(int))

    def root(i: int) -> tuple[int, Values]:
        shift = np.zeros(3, int)
        while i in place:
            i, step = place[i][0], place[i][1]
            shift = shift + step
        return i, shift

    for k in range(len(ends)):
        (a, da), (b, db) = root(numbers[2 * k]), root(numbers[2 * k + 1])
        step = (cells[2 * k + 1] + db) - (cells[2 * k] + da)
        if a == b:
            loops.setdefault(a, []).append(step)
        else:
            place[b] = (a, -step)
            loops[a] = loops.get(a, []) + loops.pop(b, [])
    roots = {root(i)[0] for i in range(len(nodes))}
    assert len(roots) == (2 if name == "interlock" else 1)
    for r in roots:
        found = np.array(loops[r])
        assert np.linalg.matrix_rank(found) == 3
        assert abs(np.gcd.reduce([round(abs(np.linalg.det(found[list(c)]))) for c in triples(len(found))])) >= 1


def triples(n: int) -> list[tuple[int, int, int]]:
    return [(0, 0, 0)] if n < 3 else [(i, j, k) for i in range(n) for j in range(i) for k in range(j)][:2000]


@pytest.mark.parametrize("name", CELLS)
def test_thin_struts_fill_what_their_lengths_say(name: str) -> None:
    """pi r^2 times the sum of lengths, less what joints share, which grows as r^3."""
    ends = bars_of(name)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()
    bars = Segments(ends[:, 0], ends[:, 1], np.zeros(len(ends)), (1.0, 1.0, 1.0))
    (d,) = ops.nearest(bars, *np.random.default_rng(5).random((3, 500_000)), wanted=("distance",))
    r = np.array([0.04, 0.08])
    missing = 1 - np.array([(d < v).mean() for v in r]) / (np.pi * r**2 * length)
    slope = missing / r  # the same for both, to the first order
    assert slope[1] == pytest.approx(slope[0], rel=0.3, abs=0.6)
    assert 0.4 < slope[1] < 9


# ---- the language ----------------------------------------------------------------------------------------------------
def value(text: str, points: Values = P, folder: Path | None = None, **settings: float) -> Values:
    program = porelang.compile(text, folder=folder) if folder is not None else porelang.compile(text)
    return program.field("part", **settings)(points)


@pytest.mark.parametrize("name", CELLS)
def test_struts_are_as_far_as_the_nearest_bar(name: str) -> None:
    points = P[:300]
    want = distance(bars_of(name), points, 9.0) - 0.6
    np.testing.assert_allclose(value(f'truss("{name}", 9mm, 0.6mm)', points), want, atol=1e-9)


def test_sizes_are_one_or_three_and_may_be_params() -> None:
    text = 'param w = 8mm in 4mm..20mm\nparam r = 0.5mm in 0.1mm..2mm\ntruss("fcc", [w, 2 * w, 5mm], r)'
    for w, r in ((8.0, 0.5), (4.5, 1.25)):
        want = distance(bars_of("fcc"), P[:300], (w, 2 * w, 5), 4) - r
        np.testing.assert_allclose(value(text, P[:300], w=w, r=r), want, atol=1e-9)


def test_the_radius_may_vary() -> None:
    want = distance(bars_of("octet"), P[:300], 10.0) - (1 + P[:300, 0] / 100)
    np.testing.assert_allclose(value('truss("octet", 10mm, 1mm + x / 100)', P[:300]), want, atol=1e-9)


def test_a_cell_may_be_a_list() -> None:
    ends = np.array([[[0, 0, 0], [0.5, 0.5, 0.5]], [[0.5, 0.5, 0.5], [1, 0, 1.25]]])
    text = "truss([[[0, 0, 0], [1, 1, 1] / 2], [[0.5, 0.5, 0.5], [1, 0, 1.25]]], [6, 8, 7], r=0.4)"
    np.testing.assert_allclose(value(text, P[:300]), distance(ends, P[:300], (6, 8, 7)) - 0.4, atol=1e-9)


def test_a_cell_may_be_a_file_with_radii_of_its_own(tmp_path: Path) -> None:
    nodes = [[0, 0, 0], [0.5, 0.5, 0.5], [1, 0, 0]]
    ends = np.array([[nodes[0], nodes[1]], [nodes[0], nodes[2]]], float)
    program = 'param w = 8mm in 4mm..20mm\nparam r = 1mm in 0.1mm..2mm\ntruss("mine.json", w, r)'
    (tmp_path / "part.pore").write_text(program)
    (tmp_path / "mine.json").write_text(json.dumps({"nodes": nodes, "bars": [[0, 1], [0, 2]], "radii": [1, 0.5]}))
    thick, thin = (distance(ends[i : i + 1], P[:300], 10.0) for i in range(2))
    found = porelang.compile(path=tmp_path / "part.pore").field("part", w=10, r=0.8)(P[:300])
    np.testing.assert_allclose(found, np.minimum(thick - 0.8, thin - 0.4), atol=1e-9)
    (tmp_path / "mine.json").write_text(json.dumps({"nodes": nodes, "bars": [[0, 1], [0, 2]]}))
    (tmp_path / "even.pore").write_text('truss("mine.json", phase=p / 10, r=0.8mm + x / 100)')
    found = porelang.compile(path=tmp_path / "even.pore").field("part")(P[:300])
    np.testing.assert_allclose(found, np.minimum(thick, thin) - 0.8 - P[:300, 0] / 100, atol=1e-9)


def test_a_phase_of_even_cells_gives_the_same_struts() -> None:
    want = value('truss("kelvin", 10mm, 0.5mm)')
    np.testing.assert_allclose(value('truss("kelvin", phase=p / 10, r=0.5mm)'), want, atol=1e-9)
    turned = 'truss("kelvin", phase=[y, z, x] / 10 + [2, 0, 5], r=0.5mm)'
    np.testing.assert_allclose(value(turned), value('truss("kelvin", 10mm, 0.5mm)', P[:, [1, 2, 0]]), atol=1e-9)


def test_a_phase_measures_by_the_volume_of_its_cells() -> None:
    found = value('truss("bcc", phase=[x / 5, y / 10, z / 20], r=0.5mm)', P[:300])
    cells = P[:300] / np.array([5, 10, 20])
    np.testing.assert_allclose(found, 10 * distance(bars_of("bcc"), cells) - 0.5, atol=1e-9)


def test_a_field_as_size_is_the_phase_of_places_over_it() -> None:
    found = value('truss("bcc", 10 + z / 8, 0.5)', P[:300])
    np.testing.assert_allclose(found, value('truss("bcc", phase=p / (10 + z / 8), r=0.5)', P[:300]), atol=1e-9)
    w = 10 + P[:300, 2] / 8  # det of the derivatives of p / w: (w - z w') / w^4
    size = (w**4 / (w - P[:300, 2] / 8)) ** (1 / 3)
    np.testing.assert_allclose(found, size * distance(bars_of("bcc"), P[:300] / w[:, None]) - 0.5, atol=1e-7)


def test_coordinates_bend_struts_as_any_field() -> None:
    a = np.arctan2(P[:, 1], P[:, 0])
    there = np.stack([np.hypot(P[:, 0], P[:, 1]), a * 60 / (2 * np.pi), P[:, 2]], -1)
    np.testing.assert_allclose(
        value('polar(truss("bcc", 10mm, 0.6mm), 60mm)'), value('truss("bcc", 10mm, 0.6mm)', there), atol=1e-9
    )


def test_a_truss_is_bounded_by_what_it_is_cut_with() -> None:
    program = porelang.compile('truss("octet", 10mm, 0.6mm) & cylinder(15mm, 20mm)')
    box = program.bounds("part")
    assert box.size == pytest.approx([30, 30, 20], abs=0.5)
    with pytest.raises(PoreError) as refused:
        porelang.compile('truss("octet", 10mm, 0.6mm)').bounds("part")
    assert [d.code for d in refused.value.diagnostics] == ["E102"]


def test_a_mesh_of_a_cell_has_the_volume_of_its_struts() -> None:
    program = porelang.compile('truss("octet", 10mm, 0.8mm) & cube(20mm)')
    mesh = program.mesh("part", voxel="0.25mm")
    want = (value('truss("octet", 10mm, 0.8mm)', RNG.uniform(0, 10, (400_000, 3))) < 0).mean() * 8000
    assert mesh.volume == pytest.approx(want, rel=0.02)
    assert mesh.is_watertight


def test_names_of_cells_are_completed() -> None:
    for text in ('truss("oc', 'truss(cell="oc', 'let a = 3\ntruss("'):
        found = complete.completions(Session(folder="").update("a.pore", text), len(text))
        assert {"octet", "octahedral", "octagon"} <= {item.label for item in found}
    other = 'truss("octet", w="oc'
    found = complete.completions(Session(folder="").update("a.pore", other), len(other))
    assert "octet" not in {item.label for item in found}


def test_what_is_shown_of_a_truss() -> None:
    named = porelang.compile('truss("octet", 10mm, 0.6mm) & cube(9)')
    assert "cell.octet" in show({"part": named.roots("part")[0]})
    listed = porelang.compile("truss([[[0, 0, 0], [1, 1, 1] / 2]], 10mm, 0.6mm) & cube(9)")
    assert "cell.1 bars" in show({"part": listed.roots("part")[0]})


def test_a_truss_may_be_chosen() -> None:
    text = 'param kind = "bcc" in {"bcc", "kelvin"}\ntruss(kind, 10mm, 0.6mm)'
    program = porelang.compile(text)
    for name in ("bcc", "kelvin"):
        found = program.field("part", kind=name)(P[:200])
        np.testing.assert_allclose(found, distance(bars_of(name), P[:200], 10.0) - 0.6, atol=1e-9)


def test_a_cell_is_known_to_be_the_period() -> None:
    from porelang.homogenize.cell import sides_of

    one = porelang.compile('param w = 8mm in 4mm..20mm\ntruss("octet", w, 0.6mm)').design(w=9)
    assert sides_of(one, "part", None).tolist() == [9, 9, 9]
    with pytest.raises(PoreError, match="not one period"):
        sides_of(porelang.compile('truss("octet", [8mm, 8mm, 9mm], 0.6mm)').design(), "part", None)
