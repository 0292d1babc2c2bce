"""Random programs on every backend, judged by the law; Hypothesis draws them and shrinks what fails."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, seed, settings
from hypothesis import strategies as st

import porelang as pore
from porelang.conformance import samples
from porelang.conformance.backend import NUMPY, Backend
from porelang.conformance.generate import Dice, draw_graph, program_text
from porelang.conformance.suite import check_graph, random_graphs
from porelang.formula import Formula
from porelang.ir import Node, order
from porelang.ops import TABLE
from porelang.rewrites import flatten

SEED = 20240229
EXAMPLES = 500


@dataclass(slots=True)
class Drawn:
    """Decisions by Hypothesis, which makes them smaller where a graph fails."""

    draw: st.DrawFn

    def below(self, n: int) -> int:
        return self.draw(st.integers(0, n - 1))


@st.composite
def graphs(draw: st.DrawFn, size: int = 16) -> Node:
    return draw_graph(Drawn(draw), size)


@pytest.mark.slow
def test_every_backend_keeps_the_law(backend: Backend) -> None:
    @seed(SEED)
    @settings(
        max_examples=EXAMPLES, deadline=None, database=None, print_blob=True,
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
    )  # fmt: skip
    @given(graphs())
    def keeps_the_law(root: Node) -> None:
        failure = check_graph(f"hypothesis, seed {SEED}", root, backend, 100, SEED).failure
        assert failure is None, f"{failure.backend} breaks the law at `{failure.operation}`:\n{failure.example}"

    keeps_the_law()


def test_the_law_says_something(capsys: pytest.CaptureFixture[str]) -> None:
    """Most random values are under a bound of 1 %, every operation appears, and no backend is merely lucky."""
    found = [check_graph("", root, b, 100, i) for i, root in enumerate(random_graphs(120, SEED)) for b in NUMPY]
    points, sharp = sum(f.points for f in found), sum(f.sharp for f in found)
    with capsys.disabled():
        print(f"\nseed {SEED}: {points} values, {100 * sharp / points:.1f} % under a bound of 1 %")
    assert sharp > 0.8 * points
    seen = {n.op for root in random_graphs(400, SEED) for n in order([root])}
    assert set(TABLE) <= seen


def test_graphs_are_the_same_for_the_same_seed() -> None:
    """Nodes are unique, so that equal graphs are one object."""
    assert [a is b for a, b in zip(random_graphs(30, 4), random_graphs(30, 4), strict=True)] == [True] * 30
    assert len({*random_graphs(30, 4)} & {*random_graphs(30, 5)}) < 15


@pytest.fixture
def beside_samples(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of the test, with the files in it that generated programs read."""
    samples.write(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_files_of_samples_hold_the_samples(beside_samples: Path) -> None:
    """What a generated program reads is what the graph it was written from is judged on, as far as files can say it."""
    program = pore.compile(
        f'out value = load("{samples.GRID_FILE}", "{samples.GRID_NAME}")\n'
        f'out smooth = load("{samples.GRID_FILE}", "{samples.GRID_NAME}", smooth=true)\n'
        f'out bars = frame("{samples.FRAME_FILE}")'
    )
    points = np.random.default_rng(1).uniform(-30, 30, (500, 3))
    for name in ("value", "smooth", "bars"):
        (root,) = program.roots(name)
        held = {n.op: data for n, data in samples.bindings().items()}  # the program's file lies somewhere else
        bound = {n: held[n.op] for n in order([root]) if n.op in held}
        wanted = NUMPY[0].evaluate(Formula((root,), bound), points, {})
        assert np.allclose(program.field(name)(points), wanted, rtol=0, atol=2e-6)


@pytest.mark.usefixtures("beside_samples")
def test_graphs_written_as_programs_are_the_same_graphs() -> None:
    """What the language makes of a graph's text is the graph itself, after the passes."""
    import fuzz

    otherwise = {"direction", "reduced", "covers"}  # no functions of the language: written as what comes near
    dice, compared = Dice.seeded(SEED), set[str]()
    for _ in range(300):
        root = draw_graph(dice, 16)
        text = program_text(root)
        program = pore.compile(text)
        if any(n.op in otherwise for n in order([root])):
            continue
        assert fuzz.shown(program.roots("part")) == fuzz.shown(flatten(root)), text
        compared.update(n.op for n in order([root]))
    assert set(TABLE) - otherwise <= compared


@pytest.mark.usefixtures("beside_samples")
def test_programs_of_random_graphs_keep_the_law_with_params_at_their_ends() -> None:
    for i, root in enumerate(random_graphs(25, SEED + 1)):
        program = pore.compile(program_text(root))
        for ends in ({"a": 0.5, "b": 2.0}, {"a": 4.0, "b": -2.0}):
            settings = {name: ends[name] for name in program.params}
            points = np.random.default_rng(i).uniform(-20, 20, (64, 3)).astype(np.float32).astype(np.float64)
            with warnings.catch_warnings():
                warnings.simplefilter("error")  # no NumPy warning reaches a user
                wide = program.field("part", settings=settings)(points)
                narrow = program.field("part", dtype="f32", settings=settings)(points)
            assert wide.shape == narrow.shape == (64,)
            assert narrow.dtype == np.float32


def test_longer_graphs_keep_the_law(backend: Backend) -> None:
    for i, root in enumerate(random_graphs(150, SEED + 2, size=50)):
        failure = check_graph(f"graph {i} of seed {SEED + 2}", root, backend, 100, i).failure
        assert failure is None, f"{failure.where}: {backend.name} breaks the law:\n{failure.example}"
