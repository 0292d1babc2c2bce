"""Bars joined by fillets: against the one number that is said to be their joint, found by halving; their bounds, and
what they do to struts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from test_segments import FRAMES, around, of_each
from test_trusses import bars_of, value

import porelang
from porelang.data import Segments
from porelang.diagnostics import PoreError
from porelang.interval import interval
from porelang.ops import joints
from porelang.ops.segment_copies import copies
from porelang.tasks.truss import cell_of, laid_out

Values = NDArray[Any]
RNG = np.random.default_rng(41)
SOME = {name: FRAMES[name] for name in ("one", "nine", "crossing", "random", "lattice", "far")}


def agreed(d: Values, k: float) -> Values:
    """Where the sum of (1 - (d - f) / k)^3 over distances (n, bars) is 1, by halving."""
    lo, hi = d.min(axis=1) - k, d.min(axis=1)
    for _ in range(100):
        f = (lo + hi) / 2
        more = (np.maximum(1 - (d - f[:, None]) / k, 0) ** 3).sum(axis=1) > 1
        lo, hi = np.where(more, lo, f), np.where(more, f, hi)
    return (lo + hi) / 2


@pytest.mark.parametrize("name", SOME)
def test_the_joint_is_where_the_cubes_sum_to_one(name: str) -> None:
    bars, k = SOME[name], 0.7
    p = around(bars, 1500)
    (got,) = joints.joined(bars, *p, k, wanted=("distance",))
    d = of_each(bars, p)["distance"]
    np.testing.assert_allclose(got, agreed(d, k), atol=1e-9)
    alone = np.sort(d, axis=1)[:, 1] > d.min(axis=1) + k if len(bars) > 1 else np.ones(len(d), bool)
    np.testing.assert_allclose(got[alone], d.min(axis=1)[alone], atol=1e-12, err_msg="a bar alone is as it was")


def test_the_order_of_bars_does_not_matter() -> None:
    bars = FRAMES["random"]
    p = around(bars, 2000)
    order = RNG.permutation(len(bars))
    mixed = Segments(bars.ends[order], bars.starts[order], bars.radii[order])
    a, b = (joints.joined(v, *p, 1.5, wanted=("distance",))[0] for v in (bars, mixed))
    np.testing.assert_allclose(a, b, atol=1e-12)


def test_of_very_many_bars_the_nearest_are_joined() -> None:
    bars = FRAMES["lattice"]
    p = np.tile(np.array([[2.0], [2.0], [2.0]]), (1, 500)) + RNG.normal(size=(3, 500))
    (got,) = joints.joined(bars, *p, 5.0, wanted=("distance",))
    d = np.sort(of_each(bars, p)["distance"], axis=1)
    assert (d[:, 64] < d[:, 0] + 5).any()
    np.testing.assert_allclose(got, agreed(d[:, :64], 5.0), atol=1e-9)


@pytest.mark.parametrize("name", ["nine", "random", "lattice"])
def test_results_are_the_derivatives_that_they_are_called(name: str) -> None:
    bars, k, h = SOME[name], 0.7, 1e-5
    p = around(bars, 800)
    found = dict(zip(joints.RESULTS, joints.joined(bars, *p, k), strict=True))
    again = {"distance": ("nx", "ny", "nz", "dk"), "nx": ("hxx", "hxy", "hxz", "gx"), "ny": ("hxy", "hyy", "hyz", "gy"),
             "nz": ("hxz", "hyz", "hzz", "gz"), "dk": ("gx", "gy", "gz", "kk")}  # fmt: skip
    for axis in range(4):
        step = np.zeros((4, 1))
        step[axis] = h
        up, down = (
            dict(zip(joints.RESULTS, joints.joined(bars, *(p + s * step[:3]), k + s * step[3, 0]), strict=True))
            for s in (1, -1)
        )
        for of, slopes in again.items():
            off = np.abs((up[of] - down[of]) / (2 * h) - found[slopes[axis]])
            assert np.quantile(off, 0.93) < 1e-6, (of, axis)  # elsewhere a plane at an end lies between


@pytest.mark.parametrize("name", SOME)
def test_no_sample_leaves_its_bound(name: str) -> None:
    bars = SOME[name]
    count = 200
    side = 10 ** RNG.uniform(-6, 0.7, (3, count)) * RNG.integers(0, 2, (3, count))
    centre, k = around(bars, count), RNG.uniform(0.1, 2, count)
    sway = 10 ** RNG.uniform(-6, -1, count) * RNG.integers(0, 2, count)
    lo, hi = centre - side / 2, centre + side / 2
    x, y, z = (interval(a, b) for a, b in zip(lo, hi, strict=True))
    wide = interval(k - sway / 2, k + sway / 2)
    bounds = dict(zip(joints.RESULTS, joints.enclose_joined(bars, x, y, z, wide), strict=True))
    for t in RNG.uniform(-0.2, 1.2, (15, 3, 1)).clip(0, 1):
        p, own = lo + t * (hi - lo), k + (t[0] - 0.5) * sway
        got = dict(zip(joints.RESULTS, joints.joined(bars, *p, own), strict=True))
        for result, bound in bounds.items():
            assert (got[result] >= bound.lo - 1e-9 * (1 + np.abs(got[result]))).all(), result
            assert (got[result] <= bound.hi + 1e-9 * (1 + np.abs(got[result]))).all(), result
    small = (side.max(axis=0) < 1e-5) & (sway < 1e-5)
    assert (bounds["distance"].hi - bounds["distance"].lo)[small].max() < 5e-5


def test_cells_are_joined_across_their_faces() -> None:
    """Struts of one cell and of the next meet as those within: the joint is that of 5^3 copies."""
    own = 10 * bars_of("octet")
    bars = Segments(own[:, 0], own[:, 1], np.full(24, 0.6), (10.0, 10.0, 10.0), 6.0)
    steps = np.array(np.meshgrid(*[np.arange(-2, 3)] * 3, indexing="ij")).reshape(3, -1).T * 10
    every = (own[None] + steps[:, None, None, :]).reshape(-1, 2, 3)
    flat = Segments(every[:, 0], every[:, 1], np.full(len(every), 0.6))
    p = RNG.uniform(0, 10, (3, 400))
    p[:, ::2] = np.rint(p[:, ::2] / 5) * 5 + RNG.normal(size=(3, 200)) * 0.3
    for k in (0.8, 3.0, 5.0):
        (got,) = joints.joined(bars, *(p + 30), k, wanted=("distance",))
        (want,) = joints.joined(flat, *p, k, wanted=("distance",))
        np.testing.assert_allclose(got, want, atol=1e-9)
    # and over small boxes about faces of cells the bound is small
    on_faces = np.rint(RNG.uniform(-3, 3, (3, 300))) * 10 + RNG.normal(size=(3, 300)) * np.array([[0], [2], [2]])
    x, y, z = (interval(v - 1e-6, v + 1e-6) for v in on_faces)
    (bound,) = joints.enclose_joined(bars, x, y, z, interval(np.array(1.5)), ("distance",))
    assert (bound.hi - bound.lo < 4e-6).all()


# ---- the language ----------------------------------------------------------------------------------------------------
def test_a_fillet_has_its_radius_in_the_middle() -> None:
    """Between two planes at a right angle: the circle through three near places of it."""
    radius = 0.5
    k = radius * joints.WIDER

    def height(x: float) -> float:
        """Where above x the fillet between the planes x = 0 and y = 0 runs."""
        lo, hi = 0.0, 2 * k
        for _ in range(60):
            y = (lo + hi) / 2
            lo, hi = (y, hi) if agreed(np.array([[x, y]]), k)[0] < 0 else (lo, y)
        return lo

    middle, h = k * (1 - 2 ** (-1 / 3)), 1e-2 * k
    low, mid, high = (height(middle + s) for s in (-h, 0.0, h))
    slope, bend = (high - low) / (2 * h), (high - 2 * mid + low) / h**2
    assert mid == pytest.approx(middle, abs=1e-9)
    assert (1 + slope**2) ** 1.5 / bend == pytest.approx(radius, rel=1e-3)


def test_a_joint_swells_by_what_is_said() -> None:
    """At a node of N equal struts the surface lies k (1 - N^(-1/3)) farther out, nowhere more than k."""
    at = np.concatenate([np.zeros((1, 3)), RNG.uniform(-25, 25, (3000, 3))])
    thin, joined = (value(f'truss("octet", 20mm, 0.6mm{more})', at) for more in ("", ", joint=1mm"))
    swollen = thin - joined
    assert swollen[0] == pytest.approx(joints.WIDER * (1 - 12 ** (-1 / 3)), abs=1e-9)
    assert (swollen >= -1e-9).all()
    assert (swollen <= joints.WIDER).all()
    assert (swollen < 1e-12).mean() > 0.02


def test_a_frame_takes_a_joint(tmp_path: Path) -> None:
    (tmp_path / "cross.json").write_text(
        '{"nodes": [[-9, 0, 0], [9, 0, 0], [0, -9, 0], [0, 9, 0]], "bars": [[0, 1], [2, 3]], "radii": [1, 1]}'
    )
    (tmp_path / "a.pore").write_text('param j = 2mm in 0.5mm..3mm\nframe("cross.json", joint=j)')
    program = porelang.compile(path=tmp_path / "a.pore")
    p = RNG.uniform(-5, 5, (500, 3))
    d = np.stack([np.hypot(p[:, 1], p[:, 2]), np.hypot(p[:, 0], p[:, 2])], 1) - 1
    for j in (2.0, 0.7):
        np.testing.assert_allclose(program.field("part", j=j)(p), agreed(d, j * joints.WIDER), atol=1e-9)


@pytest.mark.parametrize("name", ["octet", "kelvin", "diamond"])
def test_a_truss_is_joined_to_all_of_its_copies(name: str) -> None:
    p = RNG.uniform(-20, 20, (300, 3))
    own = 10 * bars_of(name)
    steps = np.array(np.meshgrid(*[np.arange(-2, 3)] * 3, indexing="ij")).reshape(3, -1).T * 10
    every = (own[None] + steps[:, None, None, :]).reshape(-1, 2, 3)
    flat = Segments(every[:, 0], every[:, 1], np.full(len(every), 0.6))
    near = of_each(flat, (p % 10).T)["distance"]
    for joint in (1.0, 2.8):
        got = value(f'truss("{name}", 10mm, 0.6mm, joint={joint}mm)', p)
        np.testing.assert_allclose(got, agreed(near, joint * joints.WIDER), atol=1e-9)


def test_all_copies_are_kept_that_a_fillet_may_reach() -> None:
    own = bars_of("kelvin")
    bars = laid_out(cell_of(own), (10.0, 10.0, 10.0), 0.0, 5.0)
    assert bars.reach >= 5
    steps = np.array(np.meshgrid(*[np.arange(-2, 3)] * 3, indexing="ij")).reshape(3, -1).T
    every = 10 * (own[None] + steps[:, None, None, :]).reshape(-1, 2, 3)
    p = RNG.uniform(-5, 5, (3, 300))
    kept, all_ = (
        np.sort(of_each(b, p)["distance"], axis=1)
        for b in (copies(bars).bars, Segments(every[:, 0], every[:, 1], np.zeros(len(every))))
    )
    near = all_ <= all_[:, :1] + bars.reach
    for row, want, within in zip(kept, all_, near, strict=True):
        np.testing.assert_allclose(row[: within.sum()], want[within], atol=1e-9)


def test_a_phase_takes_a_joint() -> None:
    p = RNG.uniform(-20, 20, (400, 3))
    even = value('truss("bcc", 10mm, 0.6mm, joint=1mm)', p)
    np.testing.assert_allclose(value('truss("bcc", phase=p / 10, r=0.6mm, joint=1mm)', p), even, atol=1e-9)


def test_walls_of_a_joined_truss_are_true_where_metric_is_asked() -> None:
    program = porelang.compile('metric(truss("bcc", 10mm, 0.6mm, joint=1mm)) & cube(20mm)')
    p = RNG.uniform(-9, 9, (300, 3))
    assert np.isfinite(program.field("part")(p)).all()
    slopes = porelang.compile('let f = truss("bcc", 10mm, 0.6mm, joint=1mm)\nout part = length(grad(f))')
    assert (slopes.field("part")(p) <= 1 + 1e-9).all()
    bent = porelang.compile('out part = grad(grad(truss("bcc", 10mm, 0.6mm, joint=1mm)).x).y')
    h = np.array([0, 1e-5, 0])
    grad = porelang.compile('out part = grad(truss("bcc", 10mm, 0.6mm, joint=1mm)).x').field("part")
    off = np.abs(bent.field("part")(p) - (grad(p + h) - grad(p - h)) / 2e-5)
    assert np.quantile(off, 0.95) < 1e-6


def test_too_wide_a_fillet_is_refused() -> None:
    with pytest.raises(PoreError) as refused:
        porelang.compile('truss("bcc", 10mm, 0.6mm, joint=3mm) & cube(20mm)').bounds("part")
    assert [d.code for d in refused.value.diagnostics] == ["E138"]
    assert "2.81 mm" in refused.value.diagnostics[0].hint


def test_the_middle_of_a_joined_strut_of_a_wide_cell_is_the_strut() -> None:
    middle = (bars_of("kelvin")[0] * 40).mean(axis=0) + RNG.normal(size=(50, 3)) * 0.2
    a, b = (value(f'truss("kelvin", 40mm, 0.6mm{more})', middle) for more in ("", ", joint=2mm"))
    np.testing.assert_allclose(a, b, atol=1e-12)
