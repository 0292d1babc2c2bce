"""What is computed before a field: found when it is read, known by its content, kept, watched and ended."""

from __future__ import annotations

import contextlib
import json
import os
import pickle
import pty
import signal
import subprocess
import sys
import threading
from concurrent.futures import CancelledError, ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import porelang
from porelang import store
from porelang.checks import broken_checks, failed_checks
from porelang.data import Reduced
from porelang.gpu import shared_gpu
from porelang.ir import NUMBERS, TASKS
from porelang.ops import TASK_TABLE
from porelang.progress import watching
from porelang.tasks import datafile, identity, resolve
from porelang.tasks.numbers import area, integrals
from porelang.tasks.readers import npz, read_grid
from porelang.tasks.resolve import RUN
from porelang.tasks.run import READERS

TEXT = "param r = 3 in 1..9\nx + bare(volume(sphere(r))) + porosity(gyroid(3), sphere(r))"


@pytest.fixture(autouse=True)
def _own_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PORELANG_CACHE", str(tmp_path / "kept"))
    store.forget()


@pytest.fixture
def computed(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of the tasks that are computed from now on, in order."""
    done: list[str] = []
    run = resolve._computed

    def noted(n: Any, *more: Any) -> Any:
        done.append(n.op)
        return run(n, *more)

    monkeypatch.setattr(resolve, "_computed", noted)
    return done


@pytest.fixture
def roughly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Numbers are found to a few percent, by tests of who asks for them, and not of what they are."""
    for module, name, accuracy in ((integrals, "mean", 1e-2), (integrals, "porosity", 5e-3), (area, "area", 3e-2)):
        monkeypatch.setattr(module, name, partial(getattr(module, name), accuracy=accuracy))


def kept(tmp_path: Path) -> list[Path]:
    return sorted((tmp_path / "kept").rglob("*.result"))


def data_files(folder: Path) -> None:
    """`grid.npz` with the coordinate x and a vector, and `truss.json`, three bars."""
    n = np.linspace(-12, 12, 25)
    x, y, z = np.meshgrid(n, n, n, indexing="ij")
    np.savez(folder / "grid.npz", x=x, v=np.stack([x, y, z], -1), origin=[-12.0] * 3, spacing=1.0)
    frame = {"nodes": [[0, 0, 0], [10, 0, 0], [10, 10, 0]], "bars": [[0, 1], [1, 2]], "radii": [1, 2]}
    (folder / "truss.json").write_text(json.dumps(frame))


def test_the_table_says_what_the_graph_and_the_runners_know() -> None:
    assert TASK_TABLE.keys() == TASKS
    assert {n for n, row in TASK_TABLE.items() if row.result == "real"} == set(NUMBERS)
    assert RUN.keys() | READERS.keys() | {"solve", "bound"} == TASK_TABLE.keys()


# ---- identity


@pytest.mark.parametrize(
    "again",
    [
        "x + volume( sphere( 3 ) )   # spaced",
        "x + volume(sphere(1 + 2))",
        "let ball = sphere(3)\nlet v = volume(ball)\n\nx + v",
        "def v(r) = volume(sphere(r))\nx + v(3)",
    ],
)
def test_the_same_question_is_asked_once_however_it_is_written(again: str, computed: list[str]) -> None:
    first = porelang.compile("x + volume(sphere(3))").reduced()
    assert list(porelang.compile(again).reduced().values()) == list(first.values())
    assert computed == ["volume"]


@pytest.mark.usefixtures("roughly")
def test_renaming_recomputes_nothing(computed: list[str]) -> None:
    text = """param r = 30mm in 1mm..90mm
let c = cylinder(r, 50)
let t = solve(t => porosity(shell(gyroid(10), t), c), 60%, 0.2..1.4)
check porosity(gyroid(10), c) > 40%, "porous"
gyroid(10) |> shell(t) & c
"""
    renamed = text.replace("param r ", "param radius ").replace("(r,", "(radius,").replace("let c", "let cyl")
    renamed = renamed.replace(", c)", ", cyl)").replace("& c", "& cyl").replace("t => porosity", "u => porosity")
    renamed = renamed.replace("shell(gyroid(10), t)", "shell(gyroid(10), u)").replace("let t", "let wall")
    renamed = renamed.replace("shell(t)", "shell(wall)")
    first = porelang.compile(text).reduced()
    done = len(computed)
    assert done > 3
    second = porelang.compile(renamed).reduced()
    assert computed[done:] == []
    assert list(second.values()) == list(first.values())
    assert any("wall" not in name and "u => porosity" in name for name in second)


@pytest.mark.parametrize(
    ("one", "same"),
    [
        ("x*y + z", "z + y*x"),
        ("gyroid(3) & sphere(2)", "sphere(2) & gyroid(3)"),
        ("union([sphere(2), box([1, 3, 1])])", "union([box([1, 3, 1]), sphere(2)])"),
    ],
)
def test_what_commutes_is_the_same_question(one: str, same: str, computed: list[str]) -> None:
    for first, second in ((one, same), (same, one)):
        store.forget()
        porelang.compile(f"x + mean({first}, sphere(3))").reduced()
        porelang.compile(f"x + mean({second}, sphere(3))").reduced()
    assert computed == ["mean"]


@pytest.mark.usefixtures("roughly")
def test_what_does_not_commute_is_another_question(computed: list[str]) -> None:
    for text in ("x - y", "y - x", "sphere(2) - gyroid(3)", "gyroid(3) - sphere(2)"):
        porelang.compile(f"x + mean({text}, sphere(3))").reduced()
    assert computed == ["mean"] * 4


@pytest.mark.usefixtures("roughly")
def test_another_output_asks_nothing_again(computed: list[str]) -> None:
    text = "let c = sphere(3)\nlet m = mean(x*x + y, c)\nout part = x + m & c"
    porelang.compile(text).reduced()
    porelang.compile(f"out first = y + x*x\nout second = mean(x*x, c) + x\n{text}").reduced()
    assert computed == ["mean", "mean"]  # the new one of the second output


def test_a_zero_has_a_sign(computed: list[str]) -> None:
    program = porelang.compile("param a = 0 in -1..1\nx + mean(atan2(a, x - 5), sphere(3))")
    above, below = (next(iter(program.reduced(a=a).values())).value for a in (0.0, -0.0))
    assert above == pytest.approx(np.pi, rel=1e-6)
    assert below == pytest.approx(-np.pi, rel=1e-6)


def test_the_code_that_computes_is_in_what_a_result_is_known_by(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "tasks").mkdir()
    (tmp_path / "tasks" / "run.py").write_text("one")
    monkeypatch.setattr(identity.resources, "PACKAGE", tmp_path)
    monkeypatch.setattr(identity, "_CODE", ("tasks",))
    digests = []
    for text in ("one", "two", "one"):
        (tmp_path / "tasks" / "run.py").write_text(text)
        identity.code_digest.cache_clear()
        digests.append(identity.code_digest())
    monkeypatch.undo()
    identity.code_digest.cache_clear()
    assert digests[0] == digests[2] != digests[1]


def test_a_program_reads_its_files_from_wherever_it_is_asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data_files(tmp_path)
    (tmp_path / "a.pore").write_text('load("grid.npz", "x") & sphere(5)')
    monkeypatch.chdir(tmp_path)
    program = porelang.compile(path="a.pore")
    other = tmp_path / "elsewhere"
    other.mkdir()
    monkeypatch.chdir(other)
    assert program.field()([[0, 0, 0]])[0] == pytest.approx(0)


def test_a_design_goes_on_with_the_data_that_it_read(tmp_path: Path) -> None:
    """And what it finds is not kept as what another file would give."""
    text = 'let g = load("g.npz", "v")\nout a = g\nout m = sphere(5) - mean(g, sphere(5))'
    path = tmp_path / "p.pore"
    path.write_text(text)

    def write(value: float) -> None:
        np.savez(tmp_path / "g.npz", v=np.full((3, 3, 3), value), origin=[-6] * 3, spacing=6.0)

    write(1)
    program = porelang.compile(path=path)
    old = program.design()
    assert old.field("a")([[0, 0, 0]])[0] == 1
    write(2)
    assert old.field("m")([[0, 0, 0]])[0] == -6
    assert program.design().field("m")([[0, 0, 0]])[0] == -7
    (tmp_path / "g.npz").unlink()
    store.forget()
    assert old.field("m")([[0, 0, 0]])[0] == -6
    write(2)
    assert program.design().field("m")([[0, 0, 0]])[0] == -7


def test_a_file_that_changes_while_a_number_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def write(value: float) -> None:
        np.savez(tmp_path / "g.npz", v=np.full((3, 3, 3), value), origin=[-6] * 3, spacing=6.0)

    run = RUN["volume"]

    def changes_it(asked: Any) -> Any:
        write(2)
        return run(asked)

    write(1)
    (tmp_path / "p.pore").write_text(
        'out m = sphere(5) - mean(bare(volume(sphere(2))) * 1e-12 + load("g.npz", "v"), sphere(5))'
    )
    monkeypatch.setitem(resolve.RUN, "volume", changes_it)  # type: ignore[arg-type]  # a mapping for readers
    program = porelang.compile(path=tmp_path / "p.pore")
    assert program.field("m")([[0, 0, 0]])[0] == pytest.approx(-6)
    assert program.field("m")([[0, 0, 0]])[0] == pytest.approx(-7)
    write(1)
    assert program.field("m")([[0, 0, 0]])[0] == pytest.approx(-6)


def test_a_pickled_design_goes_on_with_the_data_that_it_read(tmp_path: Path) -> None:
    data_files(tmp_path)
    (tmp_path / "a.pore").write_text('load("grid.npz", "x")')
    design = porelang.compile(path=tmp_path / "a.pore").design()
    assert design.field()([[3, 0, 0]])[0] == 3
    kept = pickle.dumps(design)
    np.savez(tmp_path / "grid.npz", x=np.full((2, 2, 2), 7.0), origin=[-12.0] * 3, spacing=24.0)
    assert pickle.loads(kept).field()([[3, 0, 0]])[0] == 3
    assert pickle.loads(pickle.dumps(design.program)).field()([[3, 0, 0]])[0] == 7


def test_what_was_pickled_reads_the_files_of_its_own_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (("one", 11.0), ("two", 22.0)):
        (tmp_path / name).mkdir()
        np.savez(tmp_path / name / "g.npz", v=np.full((3, 3, 3), value), origin=[-6] * 3, spacing=6.0)
        (tmp_path / name / "p.pore").write_text('load("g.npz", "v")')
    monkeypatch.chdir(tmp_path / "one")
    program = porelang.compile(path="p.pore")
    sent = pickle.dumps((program, program.design()))
    monkeypatch.chdir(tmp_path / "two")
    for again in pickle.loads(sent):
        assert again.field()([[0, 0, 0]])[0] == 11


def test_a_number_that_is_moved_is_not_kept_as_what_it_is(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Where nothing is remembered, each is found anew beside numbers that are moved to see what their errors change."""
    text = """let a = porosity(sphere(3), sphere(5))
let b = mean(x*0 + a*1000, sphere(2))
out b1 = sphere(9) - b
out c1 = sphere(9) - mean(x*0 + a + b, sphere(2))
"""
    monkeypatch.setattr(store, "get", lambda key: None)
    kept: dict[str, list[float]] = {}
    monkeypatch.setattr(store, "put", lambda key, found, **_: kept.setdefault(key, []).append(found.value))
    porelang.compile(text).field("c1")
    porelang.compile(text).field("b1")
    assert len(kept) == 3
    assert all(np.ptp(values) == 0 for values in kept.values())


def test_what_is_different_is_computed(computed: list[str]) -> None:
    program = porelang.compile(TEXT)
    program.reduced(r=4)
    program.reduced(r=4)
    assert sorted(computed) == ["porosity", "volume"]
    program.reduced(r=4.000001)
    porelang.compile(TEXT.replace("gyroid(3)", "gyroid(4)")).reduced(r=4)
    assert sorted(computed) == ["porosity"] * 3 + ["volume"] * 2


def test_solves_within_each_other_do_not_take_each_others_unknown(computed: list[str]) -> None:
    """Both look for a `t`; the inner one stands alone and is found once, however often the outer one guesses."""
    text = "let a = solve(t => volume(sphere(t)), 100, 1..10)\nx + solve(t => t * a, 20, 1..100)"
    found = sorted(r.value for r in porelang.compile(text).reduced().values())
    a = (300 / 4 / np.pi) ** (1 / 3)
    assert found == pytest.approx([a, 20 / a], rel=1e-3)
    assert computed.count("solve") == 2
    nested = "x + solve(s => s + solve(t => t * s, 6, 0.1..100), 5, 2.5..4.5)"
    (outer,) = porelang.compile(nested).reduced().values()
    assert outer.value == pytest.approx(3.0, rel=1e-6)  # 3 + 6/3 = 5


def test_a_search_is_the_same_one_within_another(computed: list[str]) -> None:
    inner = "solve(t => volume(sphere(t)), 100, 1..9)"
    porelang.compile(inner).reduced()
    once = computed.count("volume")
    porelang.compile(f"solve(u => u * {inner}, 8, 1..9)").reduced()
    assert computed.count("volume") == once
    assert computed.count("solve") == 2


def test_what_a_search_does_not_try_is_kept_for_others(tmp_path: Path, computed: list[str]) -> None:
    big = "volume(sphere(3))"
    porelang.compile(f"solve(t => t * bare({big}), 500, 1..9)").reduced()
    store.forget()
    porelang.compile(big).reduced()
    assert computed.count("volume") == 1


def test_a_param_is_the_number_that_it_has(computed: list[str]) -> None:
    porelang.compile("param w = 3 in 1..9\nx + volume(max(sphere(4), x - w))").reduced()
    porelang.compile("x + volume(max(sphere(4), x - 3))").reduced()
    assert computed == ["volume"]


def test_another_version_of_the_code_computes_again(computed: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    porelang.compile(TEXT).reduced()
    monkeypatch.setattr(identity, "code_digest", lambda task="": "other")
    porelang.compile(TEXT).reduced()
    assert len(computed) == 4


def test_a_file_is_known_by_what_is_in_it(tmp_path: Path, computed: list[str]) -> None:
    data_files(tmp_path)
    text = 'x + mean(load("grid.npz", "x"), sphere(5))'
    (tmp_path / "a.pore").write_text(text)
    (tmp_path / "b.pore").write_text(text.replace("grid", "copy"))
    (tmp_path / "copy.npz").write_bytes((tmp_path / "grid.npz").read_bytes())
    first = porelang.compile(path=tmp_path / "a.pore").reduced()
    second = porelang.compile(path=tmp_path / "b.pore").reduced()
    assert list(first.values()) == list(second.values())
    assert computed == ["mean"]
    np.savez(tmp_path / "copy.npz", x=np.full((25, 25, 25), 7.0), origin=[-12.0] * 3, spacing=1.0)
    (third,) = porelang.compile(path=tmp_path / "b.pore").reduced().values()
    assert third.value == 7.0


# ---- what is read, and when


def test_a_root_waits_for_nothing_that_it_does_not_read(computed: list[str]) -> None:
    text = """out envelope = box([30, 30, 30])
out part = shell(gyroid(10), shell_to_porosity(gyroid(10), 70%, envelope)) & envelope
check porosity(part, envelope) > 60%, "porous"
"""
    program = porelang.compile(text)
    design = program.design()
    assert design.field("envelope")([[0, 0, 0]])[0] == -15
    assert design.bounds("envelope").size == (30, 30, 30)
    assert computed == []
    assert failed_checks(design, measure=False) == []
    assert computed == []
    design.field("part")
    assert computed == ["shell_to_porosity"]
    design.bounds("part")
    design.mesh("part", resolution=20, force=True, check=False)
    assert computed == ["shell_to_porosity"]


CHOICES = """param k = 0 in 0..9
let slow = area(gyroid(5) & sphere(4))
let field = if k > 5 then load("missing.npz", "x") else if k > 2 then sample(sin(y), 0.5mm, sphere(8)) else x
let bars = if k > 5 then frame("missing.json") else sphere(3)
out part = (if volume(sphere(k + 1)) > 20 then bare(slow) else 2) + field + bars
"""


def test_what_a_branch_reads_that_is_not_taken_is_not_found(computed: list[str], engine: str) -> None:
    """The settings decide, and what they read themselves: a number may decide too. The shader has all branches."""
    program = porelang.compile(CHOICES)
    points = np.random.default_rng(1).uniform(-3, 3, (50, 3))
    x, y, _ = points.T
    ball = np.linalg.norm(points, axis=1) - 3
    np.testing.assert_allclose(program.field(backend=engine)(points), 2 + x + ball, atol=1e-5)  # type: ignore[arg-type]
    assert computed == ["volume"]
    before = shared_gpu().compiled if engine == "glsl" else 0
    wide = program.design(k=3)
    found = wide.field(backend=engine)(points)  # type: ignore[arg-type]
    assert sorted(computed) == ["area", "sample", "volume", "volume"]
    area = next(r.value for n, r in wide.program.reduced(k=3).items() if n.startswith("area"))
    np.testing.assert_allclose(found, area + np.sin(y) + ball, rtol=1e-5, atol=0.04)  # trilinear: 0.5^2 / 8 an axis
    if engine == "glsl":
        assert shared_gpu().compiled == before
    with pytest.raises(porelang.PoreError, match=r"no file `missing.npz`"):
        program.field(k=6)


def test_the_box_and_the_mesh_are_of_the_branch_that_is_taken() -> None:
    program = porelang.compile('param k = 0 in 0..9\nif k > 5 then frame("missing.json") else sphere(3)')
    np.testing.assert_allclose(program.bounds().size, [6, 6, 6], rtol=1e-3)
    assert program.mesh(resolution=40).volume == pytest.approx(4 / 3 * np.pi * 27, rel=0.01)


def test_a_number_of_a_branch_that_is_not_taken_adds_no_error() -> None:
    text = "param k = 0 in 0..9\nvolume(sphere(if k > 5 then 3mm + 0.1mm * {} else 3mm))"
    (plain,) = porelang.compile(text.format("0")).reduced().values()
    found = porelang.compile(text.format("porosity(gyroid(3), sphere(8))")).reduced()
    assert next(r for n, r in found.items() if n.startswith("volume")) == plain
    moved = porelang.compile(text.format("porosity(gyroid(3), sphere(8))")).reduced(k=6)
    assert next(r for n, r in moved.items() if n.startswith("volume")).error > plain.error


GUARDED = """param k = 0 in 0..1
let bad = mean(log(-1 - x^2), sphere(1))
let v = mean(x - 5, sphere(1))
def walls(t where t > 0) = sphere(3 * t)
out part = if k > 0.5 then walls(bad) else sphere(3)
out either = if v > 0 then walls(v) else walls(-v)
check (if k > 0.5 then bad else 1) > 0, "sound"
"""


def test_a_contract_holds_where_its_branch_is_taken() -> None:
    """By settings, proven when it is compiled, and by numbers; the same call elsewhere has it everywhere."""
    text = "param t = 0mm in -1mm..1mm\n"
    assert porelang.compile(text + "if t > 0 then sphere(t) else sphere(0.1 - t)").params
    for wrong in ("if t > 0 then sphere(1) else sphere(t)", "(if t > 0 then sphere(t) else sphere(1)) | sphere(t)"):
        with pytest.raises(porelang.PoreError, match="E086"):
            porelang.compile(text + wrong)
    design = porelang.compile(GUARDED).design()
    design.keep_contracts()
    assert design.field("part")([[0, 0, 0]])[0] == -3
    assert design.field("either")([[0, 0, 0]])[0] == pytest.approx(-15, rel=1e-3)
    assert broken_checks(design, measure=True) == []
    assert "bad" not in design.measure("part", resolution=12)["reduced"]
    with pytest.raises(porelang.PoreError, match="E093"):
        porelang.compile(GUARDED).design(k=1).keep_contracts()


def test_a_contract_of_both_branches_is_one() -> None:
    """Each level would have two of each of the level below: 2^40 contracts."""
    defs = "".join(f"def g{i}(a) = if k > 1 then g{i - 1}(a) else g{i - 1}(a) + 1\n" for i in range(1, 41))
    text = f"param k = 1 in 0..2\ndef g0(r where r > 0) = x + r\n{defs}"
    assert len(porelang.compile(text + "g40(k + 1)").graph.requirements) == 1
    with pytest.raises(porelang.PoreError, match="E086"):
        porelang.compile(text + "g40(k)")


def test_an_if_that_guards_against_an_error_may_be_near(computed: list[str]) -> None:
    """The other way has no value: what is found is found, and its error is not known."""
    (ball,) = porelang.compile("x + volume(sphere(10))").reduced().values()
    text = f"""let v = bare(volume(sphere(10)))
let s = if v > {ball.value - ball.error / 2!r} then 2 else solve(t => t, 4, 5..10)
sphere(bare(volume(sphere(s))) / 10)
"""
    program = porelang.compile(text)
    assert program.field()([[0, 0, 0]])[0] == pytest.approx(-4 / 3 * np.pi * 0.8, rel=2e-3)
    assert program.reduced()["volume(sphere(s))"].error == np.inf


def test_the_slope_of_a_choice_reads_the_branch_that_is_taken() -> None:
    program = porelang.compile('param k = 0 in 0..1\ngrad(if k > 0.5 then load("missing.npz", "x") else x * y)')
    np.testing.assert_allclose(program.field()([[2, 3, 0]]), [[3, 2, 0]])


@pytest.mark.usefixtures("roughly")
def test_a_contract_is_kept_of_what_only_a_taken_branch_of_another_number_reads() -> None:
    text = """param k = 1 in 0..1
let low = bare(volume(sphere(1)))
let high = bare(volume(sphere(1.2)))
def h(r where r < 5) = r * x
let v = mean(if low > 1 then h(high) else x, sphere(1))
out part = (if k > 0.5 then sphere(5) else sphere(low)) - v
"""
    with pytest.raises(porelang.PoreError, match="E064"):
        porelang.compile(text).field("part")


def test_conditions_that_read_conditions_are_decided_once(computed: list[str]) -> None:
    links = "".join(f"let a{i + 1} = if a{i} > 3 then a{i} - 1.5 else a{i} + 1.25\n" for i in range(60))
    porelang.compile(f"let a0 = bare(volume(sphere(1)))\n{links}sphere(3) - 0.001 * a60").field()
    assert computed == ["volume"]


def test_a_thread_that_finds_a_number_lets_others_ask_the_design(computed: list[str]) -> None:
    """What is reported may ask the design too, while another thread wants the same number to choose a file by."""
    text = """let n = volume(gyroid(2) & sphere(9))
out slow = if n > 1 then sphere(3) else load("missing.npz", "x")
out cheap = sphere(2)
"""
    design = porelang.compile(text).design()
    started = threading.Event()

    def report(*_: object) -> None:
        started.set()
        design.field("cheap")

    def first() -> float:
        with watching(report):
            return float(design.field("slow")([[0, 0, 0]])[0])

    with ThreadPoolExecutor(2) as pool:
        one = pool.submit(first)
        started.wait(20)
        other = pool.submit(lambda: float(design.field("slow")([[0, 0, 0]])[0]))
        assert one.result(60) == other.result(60) == -3
    assert computed == ["volume"]


def test_a_search_may_choose_by_a_number_of_what_it_looks_for() -> None:
    """volume(sphere(t)) < 100 up to t = 2.88."""
    text = "x + solve(t => if volume(sphere(t)) < 100 then t else 2 * t, 9, 1..20)"
    assert porelang.compile(text).field()([[0, 0, 0]])[0] == pytest.approx(4.5)


def test_a_search_may_choose_by_what_it_looks_for() -> None:
    """volume(sphere(t)) where t < 2, 10 * t^3 from there on: 640 at t = 4."""
    text = "solve(t => if t < 2mm then volume(sphere(t)) else volume(cube(t)) * 10, 640, 1mm..9mm)"
    (found,) = (r for n, r in porelang.compile(text).reduced().items() if n.startswith("solve"))
    assert found.value == pytest.approx(4, abs=found.error)


def test_a_let_that_reads_a_number_can_be_an_envelope() -> None:
    text = "let r = solve(t => volume(sphere(t)), 1000, 1..20)\nlet ball = sphere(r)\nx & ball"
    found = porelang.compile(text).measure(within="ball", resolution=24)
    assert found["envelope_volume"] == pytest.approx(1000, rel=2e-3)


def test_a_contract_on_what_was_found_is_kept_when_it_is_read() -> None:
    text = """def ball(r: length where r < 5) = sphere(r)
out big = ball(solve(t => bare(volume(sphere(t))), 1000, 1..20))
out small = ball(2)
"""
    design = porelang.compile(text).design()
    assert design.bounds("small").size == pytest.approx((4, 4, 4))
    for _ in range(3):  # and is no less broken the next time
        with pytest.raises(porelang.PoreError) as caught:
            design.field("big")
        assert caught.value.diagnostics[0].code == "E064"
    assert design.bounds("small").size == pytest.approx((4, 4, 4))

    def refused(_: int) -> bool:
        try:
            design.field("big")
        except porelang.PoreError as error:
            return error.diagnostics[0].code == "E064"
        return False

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(refused, range(8)))


def test_a_call_with_the_same_arguments_brings_its_contract_again() -> None:
    """Of two solves that call one function with the same number, each output meets the contract."""
    text = """param v = 100 in 10..4000
def ball(r: length where r < 5) = sphere(r)
let r = solve(t => bare(volume(sphere(t))), v, 1..20)
out one = ball(r)
out other = solve(t => t * bare(volume(ball(r))), 50, 0.001..100) + x
"""
    program = porelang.compile(text)
    assert program.design().field("one")([[0, 0, 0]])[0] == pytest.approx(-((300 / 4 / np.pi) ** (1 / 3)), rel=1e-3)
    for name in ("one", "other"):
        with pytest.raises(porelang.PoreError) as caught:
            program.field(name, v=2000)
        assert caught.value.diagnostics[0].code == "E064"


def test_a_contract_is_about_whoever_reads_its_numbers() -> None:
    text = """def f(r, s where s < r) = sphere(r*9)
def g(r where r < 0.5) = sphere(5)
out half = f(porosity(sphere(5), sphere(6)), porosity(sphere(2), sphere(6)))
out unread = g(porosity(sphere(2), sphere(6)))
out free = sphere(1)
"""
    program = porelang.compile(text)
    with pytest.raises(porelang.PoreError) as caught:  # `s` is read by the contract alone
        program.field("half")
    assert caught.value.diagnostics[0].code == "E064"
    assert program.field("free")([[0, 0, 0]])[0] == -1  # whatever was asked before
    with pytest.raises(porelang.PoreError) as caught:  # no output reads it: who measures is told
        program.design().keep_contracts()
    assert [d.code for d in caught.value.diagnostics] == ["E064", "E064"]


@pytest.mark.parametrize(
    ("declared", "asked", "well"),
    [
        ("def f(r where r < 0.5) = r", "solve(t => f(porosity(sphere(t), sphere(4))), {}, 0.1..3.9)", 0.3),
        (
            "def f(t where t < 2) = sphere(t)",
            "solve(s => solve(t => porosity(f(t), sphere(4)), 1 - (s/4)^3, 0.1..3.5), {} * 3, 0.3..3)",
            0.6,
        ),
    ],
)
def test_a_contract_inside_a_solve_is_about_what_it_finds(declared: str, asked: str, well: float) -> None:
    """On a number of what is found, and of a `solve` inside: the guesses may break it, the solution may not."""
    sound = porelang.compile(f"{declared}\nout a = sphere(9) - {asked.format(well)}\nout b = sphere(1)")
    assert np.isfinite(sound.field("a")([[0, 0, 0]])).all()
    broken = porelang.compile(f"{declared}\nout a = sphere(9) - {asked.format(0.8)}\nout b = sphere(1)")
    assert broken.field("b")([[0, 0, 0]])[0] == -1
    with pytest.raises(porelang.PoreError) as caught:
        broken.field("a")
    assert {d.code for d in caught.value.diagnostics} == {"E064"}


def test_calls_that_bind_different_parameters_are_different() -> None:
    text = """param u = 1 in 0..3
def f(a or b = a*2, c or d = c*2) = sphere(1) + b*10 + d*100
out q = f(a=u, d=u*2*2)
out r = f(b=u, c=u*2)
"""
    program = porelang.compile(text)
    assert program.field("q")([[0, 0, 0]])[0] == -1 + 20 + 400
    assert program.field("r")([[0, 0, 0]])[0] == -1 + 10 + 400


@pytest.mark.usefixtures("roughly")
def test_a_contract_on_a_field_inside_a_solve_does_not_end_measuring() -> None:
    """The field reads the number that is looked for, which has no value outside."""
    text = """let c = sphere(10)
def h(f: field where f > -100) = f
let s = solve(t => porosity(h(gyroid(10) + t * mean(gyroid(10) + 1 + t, c)), c), 75%, 0.1..1)
out part = gyroid(10) + s & c
"""
    measured = porelang.compile(text).design().measure(voxel=1.0)
    assert measured["volume"] > 0


# ---- errors of what was found


def test_the_error_of_a_number_reaches_what_is_found_of_samples_that_read_it() -> None:
    """mean(s(x) + v) over a solid is v off by what v is off: sampling between does not lose it."""
    direct = "let v = bare(porosity(gyroid(9), sphere(10)))\nx + mean(0*x + v, sphere(10))"
    sampled = "let v = bare(porosity(gyroid(9), sphere(10)))\nx + mean(sample(0*x + v, 2mm, sphere(12)), sphere(10))"
    (one,) = porelang.compile(direct).reduced().values()
    (other,) = porelang.compile(sampled).reduced().values()
    (v,) = porelang.compile("x + porosity(gyroid(9), sphere(10))").reduced().values()
    assert v.error > 0
    assert one.error >= v.error * (1 - 1e-9)
    assert other.error >= v.error * (1 - 1e-9)


def test_a_number_that_cannot_be_moved_below_nothing_has_an_error_still() -> None:
    """The porosity of a gyroid in a full sphere is near 0: less than that is no porosity to look for."""
    text = "let q = porosity(sphere(9.99), sphere(10))\nx + to_porosity(gyroid(9), q, sphere(10))"
    program = porelang.compile(text)
    found = list(program.reduced().values())
    assert all(np.isfinite(r.value) for r in found)


# ---- data


@pytest.mark.parametrize(
    ("call", "code", "words"),
    [
        ("sample(1e38 * x, 1mm, sphere(3))", "E097", "beyond 1e+37"),
        ("sample(x, k * 1mm, sphere(5))", "E096", "voxel of 9.99989e-321"),
        ("sample(x, 1mm / k, sphere(5))", "E096", "voxel of inf"),
        ("sample(x, 1e40 * 1mm, sphere(5))", "E096", "voxel of 1e+40"),
    ],
)
def test_samples_keep_to_what_shaders_and_places_can_be(call: str, code: str, words: str) -> None:
    with pytest.raises(porelang.PoreError) as caught:
        porelang.compile(f"param k = 1 in 0..1\nx + {call}").field(k=1e-320)
    (d,) = caught.value.diagnostics
    assert d.code == code
    assert words in d.message


@pytest.mark.parametrize("call", ['load("grid.npz", "x")', 'frame("truss.json")'])
def test_reading_a_file_is_told_and_can_be_ended(call: str, tmp_path: Path) -> None:
    data_files(tmp_path)
    (tmp_path / "a.pore").write_text(call)
    program = porelang.compile(path=tmp_path / "a.pore")
    told: list[str] = []
    with watching(lambda what, done, total: told.append(what), lambda: True), pytest.raises(CancelledError):
        program.field()
    assert told
    assert set(told) == {"reading data"}


def test_threads_that_want_a_file_read_it_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data_files(tmp_path)
    os.utime(tmp_path / "grid.npz", (1e9, 1e9))
    reads: list[int] = []
    values = npz._values

    def slowly(*args: Any) -> Any:
        reads.append(1)
        threading.Event().wait(0.1)
        return values(*args)

    monkeypatch.setattr(npz, "_values", slowly)
    monkeypatch.setattr(datafile, "_TICK", -1e10)
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda _: read_grid(str(tmp_path / "grid.npz"), "x"), range(4)))
    assert len(reads) == 1


@pytest.mark.parametrize("smooth", ["", ", smooth=true"])
def test_a_loaded_field_is_the_field_of_its_samples(smooth: str, tmp_path: Path) -> None:
    data_files(tmp_path)
    (tmp_path / "a.pore").write_text(
        f"""let s = load("grid.npz", "x"{smooth})
let cut = load("grid.npz", "x", outside=-99{smooth})
out value = s
out beyond = cut
out moved = s @ [x + 1, y, z]
out slope = grad(s)
"""
    )
    program = porelang.compile(path=tmp_path / "a.pore")
    points = np.array([[0.5, 3.2, -4.4], [11.9, 0, 0], [20.0, 0, 0], [-3.3, 0, 40.0]])
    assert program.field("value")(points).tolist() == pytest.approx([0.5, 11.9, 12.0, -3.3])
    assert program.field("beyond")(points).tolist() == pytest.approx([0.5, 11.9, -99, -99])
    assert program.field("moved")(points)[:2].tolist() == pytest.approx([1.5, 12.0])
    assert program.field("slope")(points[:1]).tolist()[0] == pytest.approx([1, 0, 0])


def test_a_field_is_sampled_once_and_read_from_then_on(computed: list[str]) -> None:
    text = """param k = 1 in 0..2
let body = sphere(10)
let baked = sample(k * length(p)^2, 0.5mm, body, smooth=true)
let way = sample([x, y^2, 3], 1mm, body)
out part = baked - 25 & body
out way = way
"""
    program = porelang.compile(text)
    points = np.random.default_rng(1).uniform(-5, 5, (200, 3))
    square = (points**2).sum(1)
    exact = np.maximum(square - 25, np.sqrt(square) - 10)
    assert np.abs(program.field("part")(points) - exact).max() < 1e-9  # a cubic holds a quadratic
    assert program.field("part", k=2)([[3, 0, 0]])[0] == pytest.approx(-7)
    assert (
        np.abs(
            program.field("way")(points) - np.stack([points[:, 0], points[:, 1] ** 2, 0 * points[:, 0] + 3], 1)
        ).max()
        < 0.26
    )
    assert computed == ["sample", "sample", "sample"]
    store.forget()  # what another process knows
    program.design().field("part")
    assert computed == ["sample", "sample", "sample"]


def test_a_frame_is_the_solid_of_its_bars(tmp_path: Path) -> None:
    data_files(tmp_path)
    (tmp_path / "a.pore").write_text(
        """out part = frame("truss.json")
let bar = nearest_bar("truss.json")
out direction = bar.direction
out along = bar.along
"""
    )
    program = porelang.compile(path=tmp_path / "a.pore")
    assert program.field("part")([[5, 0, 0], [5, 3, 0], [10, 12, 0], [-4, 0, 0]]).tolist() == pytest.approx(
        [-1, 2, 0, 3]
    )
    assert program.field("direction")([[5, 1, 0], [10, 5, 1]]).tolist() == [[1, 0, 0], [0, 1, 0]]
    assert program.field("along")([[2.5, 1, 0]])[0] == pytest.approx(0.25)
    assert program.bounds("part").lo == pytest.approx((-1, -2, -2))
    assert program.mesh("part", resolution=48).is_watertight


# ---- kept


def test_another_process_computes_nothing_again(tmp_path: Path, computed: list[str]) -> None:
    first = porelang.compile(TEXT).reduced(r=4)
    assert len(kept(tmp_path)) == 2
    store.forget()  # what a new process knows
    computed.clear()
    assert porelang.compile(TEXT).reduced(r=4) == first  # to the last bit
    assert computed == []


def test_guesses_of_a_solve_are_not_kept(tmp_path: Path) -> None:
    porelang.compile("x + solve(t => volume(sphere(t)), 100, 1..10)").reduced()
    assert len(kept(tmp_path)) == 1


@pytest.mark.parametrize("damage", [lambda b: b[: len(b) // 2], lambda b: b"", lambda b: b[:-3] + b"abc"])
def test_what_was_damaged_is_computed_again(damage: Any, tmp_path: Path, computed: list[str]) -> None:
    text = f"{TEXT} + sample(x, 1mm, sphere(3))"
    first = porelang.compile(text).field()([[1, 2, 3]])
    for path in kept(tmp_path):
        path.write_bytes(damage(path.read_bytes()))
    store.forget()
    computed.clear()
    assert porelang.compile(text).field()([[1, 2, 3]]) == first
    assert sorted(computed) == ["porosity", "sample", "volume"]
    store.forget()
    computed.clear()
    assert porelang.compile(text).field()([[1, 2, 3]]) == first  # and mended
    assert computed == []


# ---- watched, cancelled


@pytest.mark.parametrize(
    "call",
    [
        "porosity(gyroid(3), sphere(9))",
        "area(gyroid(3) & sphere(5))",
        "maximum(sin(x) * y, sphere(9))",
        "to_porosity(gyroid(3), 30%, sphere(9))",
        "solve(t => volume(sphere(t)), 100, 1..10)",
        "sample(gyroid(3), 0.2mm, sphere(9))",
    ],
)
def test_every_task_says_how_far_it_is_and_can_be_ended(call: str, tmp_path: Path) -> None:
    program = porelang.compile(f"x + {call}")
    told: list[tuple[str, int, int]] = []
    asked = 0

    def cancel() -> bool:
        nonlocal asked
        asked += 1
        return asked > 1

    with watching(lambda *what: told.append(what), cancel), pytest.raises(CancelledError):
        program.design().field()
    assert {what for what, _, _ in told} <= {TASK_TABLE[n].activity for n in TASK_TABLE}
    assert kept(tmp_path) == []
    with watching(lambda *what: told.append(what)):
        program.design().field()
    assert told[-1][1] == told[-1][2]


def _drained(terminal: int) -> None:
    with contextlib.suppress(OSError):  # its other end is closed
        while os.read(terminal, 4096):
            pass


@pytest.mark.slow
def test_a_long_search_shows_itself_and_ctrl_c_ends_it(tmp_path: Path) -> None:
    path = tmp_path / "slow.pore"
    path.write_text(
        "let t = solve(t => area(gyroid(t) & cylinder(50, 100)), 300000, 6..20)\ngyroid(t) & cylinder(50, 100)\n"
    )
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "porelang", "mesh", str(path), "-o", str(tmp_path / "part.stl")]
    running = subprocess.Popen(command, stderr=theirs, stdout=subprocess.DEVNULL)
    os.close(theirs)
    shown = b""
    while b"finding numbers from fields" not in shown:
        shown += os.read(ours, 1000)
    drain = threading.Thread(target=_drained, args=(ours,), daemon=True)  # a terminal goes on reading
    drain.start()
    running.send_signal(signal.SIGINT)
    assert running.wait(60) == 130
    os.close(ours)
    assert b"Traceback" not in shown
    assert not kept(tmp_path)
    assert {p.name for p in tmp_path.iterdir()} <= {"slow.pore", "kept"}
    assert not list((tmp_path / "kept").glob(".*"))


# ---- shared and sent


def test_threads_may_share_a_design(computed: list[str]) -> None:
    design = porelang.compile(TEXT).design()
    start = threading.Barrier(8)

    def work(i: int) -> float:
        start.wait()
        return float(design.field()([[i, 0, 0]])[0] - i)

    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(work, range(8)))
    assert np.ptp(found) < 1e-9
    assert sorted(computed) == ["porosity", "volume"]  # once each, however many wait for it


def test_programs_and_designs_come_back_as_themselves(tmp_path: Path) -> None:
    (tmp_path / "lib.pore").write_text("def ball(r) = sphere(r)\n")
    (tmp_path / "a.pore").write_text(
        'use "lib.pore" as lib\nparam r = 3 in 1..9\nlib.ball(r) - bare(volume(sphere(r))) / 100\n'
    )
    program = porelang.compile(path=tmp_path / "a.pore")
    (tmp_path / "lib.pore").unlink()  # it need not be there where it is unpickled
    again = pickle.loads(pickle.dumps(program))
    assert all(a is b for a, b in zip(program.graph.roots, again.graph.roots, strict=True))
    design = program.design(r=4)
    sent = pickle.loads(pickle.dumps(design))
    points = np.random.default_rng(2).uniform(-5, 5, (50, 3))
    assert (sent.field()(points) == design.field()(points)).all()
    formula = pickle.loads(pickle.dumps(design.of()))
    assert formula.root is design.of().root
    code = "import pickle, sys; d = pickle.load(sys.stdin.buffer); print(repr(float(d.field()([[1, 2, 3]])[0])))"
    done = subprocess.run([sys.executable, "-c", code], input=pickle.dumps(design), capture_output=True, check=True)
    assert float(done.stdout) == design.field()([[1, 2, 3]])[0]


def test_settings_change_between_calls_and_are_bound_once() -> None:
    program = porelang.compile("param voxel = 3 in 1..9\nparam backend = 1 in 0..2\nsphere(voxel) + backend")
    assert program.field(settings={"voxel": 5, "backend": 2})([[0, 0, 0]])[0] == -3
    assert program.field()([[0, 0, 0]])[0] == -2
    assert program.design(voxel="9", backend=0).field()([[0, 0, 0]])[0] == -9
    assert program.mesh("part", resolution=16, settings={"voxel": 5, "backend": 0}).bounds[1][0] == pytest.approx(
        5, rel=0.02
    )


def test_a_vector_computes_what_its_parts_share_once() -> None:
    """One tape for three roots, on which each operation stands once."""
    program = porelang.compile("let f = exp(sin(x) * cos(y))\n[f, 2 * f, f + z]")
    tape = program.design().formula(*program.roots()).tape
    assert tape.ops.count("exp") == 1
    assert len(tape.roots) == 3


def test_a_number_has_an_error_and_data_do_not() -> None:
    design = porelang.compile("x + volume(sphere(3))").design()
    (n,) = design.program.numbers
    assert isinstance(design.number(n), Reduced)


def test_a_program_remembers_its_designs_but_not_what_was_in_files(tmp_path: Path, computed: list[str]) -> None:
    program = porelang.compile("param r = 3 in 1..9\nsphere(r) + 0 * porosity(gyroid(3), sphere(r))")
    assert program.design(r=4) is program.design({"r": "4"})
    assert program.design(r=4) is not program.design(r=5)
    data_files(tmp_path)
    (tmp_path / "a.pore").write_text('load("grid.npz", "x")')
    program = porelang.compile(path=tmp_path / "a.pore")
    assert program.field()([[2, 0, 0]])[0] == 2
    np.savez(tmp_path / "grid.npz", x=np.full((25, 25, 25), 7.0), origin=[-12.0] * 3, spacing=1.0)
    assert program.field()([[2, 0, 0]])[0] == 7


@pytest.mark.usefixtures("gpu")
def test_neither_data_nor_settings_change_a_shader(tmp_path: Path) -> None:
    """Another file of the same name, and another value of a param: the device compiles nothing, and is right."""
    data_files(tmp_path)
    (tmp_path / "a.pore").write_text(
        'param k = 1 in 0..9\nk * load("grid.npz", "x") + frame("truss.json") + bare(volume(sphere(k + 1)))'
    )
    program = porelang.compile(path=tmp_path / "a.pore")
    points = np.random.default_rng(3).uniform(-12, 12, (500, 3)).astype(np.float32)

    def both(**settings: float) -> None:
        exact = program.field(dtype="f32", settings=settings)(points)
        assert (program.field(backend="glsl", settings=settings)(points) == exact).all()

    both()
    compiled = shared_gpu().compiled
    both(k=3)
    np.savez(tmp_path / "grid.npz", x=np.random.default_rng(4).uniform(-1, 1, (5, 4, 3)), origin=[-9, -8, 3], spacing=2)
    frame = {"nodes": [[0, 0, 5], [0, 7, 0]], "bars": [[0, 1]], "radius": 1}
    (tmp_path / "truss.json").write_text(json.dumps(frame))
    both(k=3)
    assert shared_gpu().compiled == compiled
