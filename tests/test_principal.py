"""Principal values and directions: against LAPACK in float64, where values meet, at the ends of the number range, in
the language, and through data."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import porelang
from porelang.analysis.enclose import F32, F64, enclose
from porelang.formula import Formula
from porelang.interval import Interval, interval
from porelang.ir import X, Y, Z, node
from porelang.ops import principal as ops

Array = NDArray[Any]
RNG = np.random.default_rng(5)
PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def matrices(parts: Array) -> Array:
    """Components (6, n) as matrices (n, 3, 3)."""
    out = np.empty((parts.shape[1], 3, 3), parts.dtype)
    for k, (i, j) in enumerate(PLACES):
        out[:, i, j] = out[:, j, i] = parts[k]
    return out


def components(m: Array) -> Array:
    return np.stack([m[:, i, j] for i, j in PLACES])


def with_values(*values: float, count: int = 5000) -> Array:
    """Tensors (6, count) with these principal values, turned at random."""
    q = np.linalg.qr(RNG.normal(size=(count, 3, 3)))[0]
    return components(q @ (np.array(values)[:, None] * q.transpose(0, 2, 1)))


def random_tensors(count: int = 5000) -> Array:
    m = RNG.normal(size=(count, 3, 3))
    return components(m + m.transpose(0, 2, 1))


TENSORS = {
    "random": random_tensors(),
    "one value apart": with_values(1, 1, -2),
    "nearly two": with_values(1, 1 + 1e-4, -2),
    "more nearly two": with_values(1, 1 + 1e-7, 3),
    "all nearly one": with_values(1, 1 + 1e-6, 1 + 3e-6),
    "one in all": with_values(1, 1, 1),
    "flat": with_values(1e6, 1, 0),
    "of a plane": RNG.normal(size=(6, 5000)) * np.array([1, 1, 0, 1, 0, 0])[:, None],
    "along the axes": RNG.integers(-2, 3, (6, 5000)) * np.array([1, 1, 1, 0, 0, 0])[:, None],
    "sheared": RNG.integers(-2, 3, (6, 5000)) * np.array([0, 0, 0, 1, 1, 1])[:, None],
    "whole": RNG.integers(-3, 4, (6, 5000)),
}


def found(parts: Array, dtype: Any) -> tuple[Array, Array]:
    """Values (n, 3), and directions as columns (n, 3, 3)."""
    out = np.array(ops.principal(*parts.astype(dtype)))
    assert out.dtype == dtype
    return out[:3].T.astype(np.float64), out[3:].T.reshape(-1, 3, 3).transpose(0, 2, 1).astype(np.float64)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("name", TENSORS)
def test_values_and_directions_are_lapacks(name: str, dtype: Any) -> None:
    """Values to 4 epsilons of the norm, however near they are to each other; directions to that over the gap."""
    eps = float(np.finfo(dtype).eps)
    parts = TENSORS[name].astype(dtype)
    values, directions = found(parts, dtype)
    m = matrices(parts.astype(np.float64))
    wanted, axes = np.linalg.eigh(m)
    wanted, axes = wanted[:, ::-1], axes[:, :, ::-1]
    norm = np.abs(wanted).max(1)[:, None]
    room = 4 if dtype == np.float32 else 16  # LAPACK itself errs by as much
    assert (np.abs(values - wanted) <= room * eps * norm).all()
    assert (np.diff(values, axis=1) <= 0).all()
    assert np.abs(directions.transpose(0, 2, 1) @ directions - np.eye(3)).max() < 32 * eps
    assert np.linalg.det(directions) == pytest.approx(np.ones(len(m)), abs=64 * eps)
    rest = np.abs(m @ directions - directions * values[:, None, :]).max(1)
    assert (rest <= 8 * eps * norm).all()
    gaps = -np.diff(wanted, axis=1)
    gap = np.stack([gaps[:, 0], gaps.min(1), gaps[:, 1]], 1)
    sine = np.linalg.norm(np.cross(directions, axes, axis=1), axis=1)
    plain = gap > 100 * eps * norm
    assert (sine * gap <= 8 * eps * norm)[plain].all()


def test_closed_forms_would_not_do() -> None:
    """In float32 the values by the angle of a cosine lose half of the digits near a double one, and these do not."""
    parts = with_values(1, 1 + 1e-5, -2).astype(np.float32)
    a, b, c, d, e, f = parts
    third = (a + b + c) / 3
    p = np.sqrt(((a - third) ** 2 + (b - third) ** 2 + (c - third) ** 2 + 2 * (d * d + e * e + f * f)) / 6)
    half = np.linalg.det((matrices(parts) - third[:, None, None] * np.eye(3, dtype=np.float32)) / p[:, None, None]) / 2
    closed = third + 2 * p * np.cos(np.arccos(np.clip(half, -1, 1)) / 3)
    wanted = np.linalg.eigvalsh(matrices(parts.astype(np.float64)))[:, 2]
    eps = float(np.finfo(np.float32).eps)
    assert np.abs(closed - wanted).max() > 100 * eps
    assert np.abs(found(parts, np.float32)[0][:, 0] - wanted).max() < 8 * eps


def test_of_opposite_directions_one_side_is_taken() -> None:
    for parts in TENSORS.values():
        _, directions = found(parts, np.float64)
        ahead = np.einsum("i,nij->nj", ops.SIDE, directions)
        assert (ahead[:, :2] > -1e-12).all()


def test_of_a_tensor_without_directions_they_are_the_axes() -> None:
    for parts in (np.zeros((6, 1)), np.array([[5.0], [5], [5], [0], [0], [0]])):
        values, directions = found(parts, np.float64)
        assert (values == parts[0, 0]).all()
        assert (directions == np.eye(3)).all()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_great_and_small_tensors_have_the_same_directions(dtype: Any) -> None:
    parts = TENSORS["random"].astype(dtype)
    values, directions = found(parts, dtype)
    for power in (-100, 100):
        scaled, same = found(parts * dtype(2.0**power), dtype)
        assert (same == directions).all()
        assert np.abs(scaled / 2.0**power - values).max() < 1e-5
    tiny = parts * np.finfo(dtype).tiny * dtype(1e-3)  # denormal: there is a frame, and values near 0
    values, directions = found(tiny, dtype)
    assert np.isfinite(values).all()
    assert np.isfinite(directions).all()


def test_what_is_no_number_gives_none() -> None:
    for wrong in (np.nan, np.inf, -np.inf):
        for k in range(6):
            parts = np.ones((6, 2))
            parts[k, 0] = wrong
            values, directions = found(parts, np.float64)
            assert np.isnan(values[0]).all()
            assert np.isnan(directions[0]).all()
            assert np.isfinite(values[1]).all()


# ---- enclosures ------------------------------------------------------------------------------------------------------


def boxes(parts: Array) -> tuple[list[Interval], Array]:
    """Boxes of all sizes about tensors, and random tensors in each (6, each, n)."""
    count = parts.shape[1]
    size = 10.0 ** RNG.uniform(-9, 0.5, count) * RNG.uniform(0, 1, (6, count)) * (RNG.random((6, count)) < 0.8)
    lo, hi = parts - size / 2, parts + size / 2
    inside = lo[:, None] + (hi - lo)[:, None] * np.rint(RNG.random((6, 40, count)) * 2) / 2
    return [interval(a, b) for a, b in zip(lo, hi, strict=True)], np.clip(inside, lo[:, None], hi[:, None])


@pytest.mark.parametrize("name", TENSORS)
def test_enclosures_hold_values_and_say_something(name: str) -> None:
    box, inside = boxes(TENSORS[name][:, :400].astype(np.float64))
    ranges = ops.enclose(*box, ops.RESULTS)
    leaps = ops.jumps(*box, ops.RESULTS)
    got = ops.principal(*inside, ops.RESULTS)
    for k, (r, values) in enumerate(zip(ranges, got, strict=True)):
        assert ((r.lo - 1e-12 <= values) & (values <= r.hi + 1e-12)).all(), ops.RESULTS[k]
        spread = values.max(0) - values.min(0)
        narrow = (r.hi - r.lo) < 1e-3
        assert (spread[narrow] < 1e-3).all()
        if k >= 3:  # a direction turns by 60 degrees at most about that of the middle, where it does not leap
            still = ~np.broadcast_to(leaps[k], spread.shape)
            assert still.any() or name != "random"
            assert (spread[still] <= 1.74).all()


def test_the_enclosure_of_a_small_box_is_small() -> None:
    parts = TENSORS["random"][:, :200]
    for size in (1e-3, 1e-6):
        box = [interval(p - size, p + size) for p in parts]
        for name, r in zip(ops.RESULTS, ops.enclose(*box, ops.RESULTS), strict=True):
            width = np.median(r.hi - r.lo)
            assert width < (10 if name[0] == "v" else 60) * size, name


def test_what_is_not_known_may_be_anything() -> None:
    none = np.zeros(1, np.bool_)
    wild = [Interval(np.array([-np.inf]), np.array([np.inf]), none)] + [interval(np.ones(1))] * 5
    for name, r in zip(ops.RESULTS, ops.enclose(*wild, ops.RESULTS), strict=True):
        assert r.nan.all()
        assert r.lo <= -1
        assert r.hi >= 1
        assert name[0] == "v" or r.lo == -1


@pytest.mark.parametrize("precision", [F32, F64])
def test_errors_of_directions_stay_within_a_frame(precision: Any) -> None:
    """Where values meet a direction is not known, and still no component is beyond 1."""
    root = node("principal", X, X, Y, Z, Z, Z, value="x1")
    at = [interval(np.array([1.0, 1.0, 1.0])), interval(np.array([1.0, 1 + 1e-7, 3])), interval(np.zeros(3))]
    known = enclose(Formula.of(root), at, precision)[0].range
    assert (np.abs(known.lo) < 1.001).all()
    assert (np.abs(known.hi) < 1.001).all()


# ---- the language ----------------------------------------------------------------------------------------------------


def test_both_backends_keep_the_law_near_double_values(backend: Any) -> None:
    """A tensor whose two greatest values meet along a line, as at the tip of a notch."""
    from porelang.backends.error import judge

    text = "let T = tensor(1 + x / 9, 1 - x / 9, -2, y / 9, z / 99, 0)\n"
    text += "out v = principal(T, {0}).value\nout d = principal(T, {0}).direction"
    points = RNG.normal(size=(2000, 3)) * 10.0 ** RNG.uniform(-6, 1, (2000, 1))
    points = points.astype(np.float32).astype(np.float64)
    for i in (1, 2, 3):
        program = porelang.compile(text.format(i))
        for name in ("v", "d"):
            for root in program.roots(name):
                formula = Formula.of(root)
                verdict = judge(formula, points, backend.evaluate(formula, points, {}), backend.precision)
                assert not verdict.broken.any()


def test_a_lattice_follows_the_principal_stress_of_a_file(tmp_path: Path) -> None:
    """Torsion: the first principal direction stands at 45 degrees round the axis. Six grids, interpolated, and then
    decomposed; directions interpolated with the signs that LAPACK happens to give are none."""
    axis = np.linspace(-10, 10, 21)
    x, y, _ = np.meshgrid(axis, axis, axis, indexing="ij")
    stress = np.stack([0 * x, 0 * x, 0 * x, 0 * x, x, -y], -1)
    np.savez(tmp_path / "s.npz", origin=[-10, -10, -10], spacing=1.0, stress=stress)
    program = tmp_path / "torsion.pore"
    program.write_text(
        'let T = load_tensor("s.npz", "stress")\nlet first = principal(T, 1)\n'
        "out way = first.direction\nout most = first.value\n"
        "align(gyroid(6), principal(T, 1).direction, symmetry=2, about=[0, 1.5, 0]) & cylinder(9, 18)\n"
    )
    compiled = porelang.compile(path=program)
    points = RNG.uniform(-9, 9, (3000, 3))
    rho = np.hypot(points[:, 0], points[:, 1])
    assert compiled.field("most")(points) == pytest.approx(rho, abs=1e-9)
    way = compiled.field("way")(points)
    around = np.stack([-points[:, 1] / rho, points[:, 0] / rho, 1 + 0 * rho], 1) / np.sqrt(2)
    assert np.abs(np.abs((way * around).sum(1)) - 1).max() < 1e-9
    assert np.isfinite(compiled.field("part")(points)).all()


def test_in_plane_stress_the_second_direction_jumps_and_the_first_stays() -> None:
    """What the language says of `orientation=[v, u]`: of diag(9, x, 0) the second is y where x > 0, and else z."""
    at = np.array([[4.0, 0, 0], [-4.0, 0, 0]])
    for i, ways in ((1, [[1, 0, 0], [1, 0, 0]]), (2, [[0, 1, 0], [0, 0, 1]]), (3, [[0, 0, 1], [0, 1, 0]])):
        text = f"out d = principal(tensor(9, x, 0, 0, 0, 0), {i}).direction"
        assert np.abs(porelang.compile(text).field("d")(at)) == pytest.approx(np.array(ways))


@pytest.mark.parametrize(
    ("text", "code", "says"),
    [
        ("principal(5, 1).value", "E060", "needs a tensor"),
        ("principal([1, 2, 3], 1).value", "E060", "tensor(xx"),
        ("principal(tensor(1, 2, 3, 0, 0, 0), 4).value", "E064", "1, 2 or 3"),
        ("principal(tensor(1, 2, 3, 0, 0, 0), 0).value", "E064", "largest"),
        ("principal(tensor(1, 2, 3, 0, 0, 0), x).value", "E063", ""),
        ("tensor(p, 0, 0, 0, 0, 0).xx", "E060", "`xx`"),
        ("tensor(1MPa, 2mm, 0, 0, 0, 0).xx", "E062", "`yy`"),
        ("principal(tensor(1, 2, 3), 1).value", "E043", "xy"),
    ],
)
def test_what_is_no_tensor_is_told(text: str, code: str, says: str) -> None:
    with pytest.raises(porelang.PoreError) as caught:
        porelang.compile(text)
    assert [d.code for d in caught.value.diagnostics] == [code]
    assert says in str(caught.value)


def test_a_param_may_say_which_and_values_carry_their_unit() -> None:
    program = porelang.compile(
        "param i = 1 in 1..3\nlet T = tensor(3MPa, 2MPa, 1MPa, 0, 0, 0)\n"
        'check principal(T, 1).value > 2MPa, "tension"\nout part = bare(principal(T, i).value) + 0 * x'
    )
    assert [float(program.field("part", i=i)(np.zeros((1, 3)))[0]) for i in (1, 2, 3)] == [3, 2, 1]
    with pytest.raises(porelang.PoreError):
        porelang.compile("principal(tensor(3MPa, 2MPa, 1MPa, 0, 0, 0), 1).value + 1mm")
