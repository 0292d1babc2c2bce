"""Every conformance program, on every backend: its expectations, and the law at random points."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator

import pytest

import porelang
from porelang.backends.numpy import NumpyField
from porelang.conformance import report, suite
from porelang.conformance.backend import NUMPY, Backend, glsl
from porelang.conformance.programs import Case, cases, folder, number, read_case
from porelang.conformance.report import certificate, doctor
from porelang.conformance.suite import check_case, has_samples
from porelang.conformance.sweep import Measurement
from porelang.formula import Formula
from porelang.gpu import Gpu, GpuMissing
from porelang.ir import X, node, order
from porelang.ops import TABLE

CASES = cases()


@pytest.mark.parametrize("case", CASES, ids=[c.name for c in CASES])
def test_program(case: Case, backend: Backend) -> None:
    findings = check_case(case, backend, points=200, seed=1)
    assert not [f.failure.example for f in findings if f.failure]


@pytest.fixture(scope="module")
def osmesa(opened: Callable[..., Gpu]) -> Iterator[Backend]:
    with opened("osmesa") as device:
        yield glsl(device)


@pytest.mark.parametrize("case", [c for c in CASES if c.name.startswith("kernel_")], ids=lambda c: c.name)
def test_kernel_program_where_only_osmesa_is_present(case: Case, osmesa: Backend) -> None:
    findings = check_case(case, osmesa, points=200, seed=1)
    assert not [f.failure.example for f in findings if f.failure]


def test_every_program_says_what_it_expects() -> None:
    for case in CASES:
        assert any(v.expectations or v.fails for v in case.variants), case.name


def test_every_operation_stands_in_a_program() -> None:
    """The sweep knows operations alone, and random graphs know no prelude: programs use each as people do."""
    programs = [porelang.compile(path=case.path) for case in CASES]
    used = {n.op for p in programs for output in p.outputs for n in order(p.roots(output))}
    waves = NumpyField(Formula.of(node("sin_turns", X)))  # which are taken apart before they are computed
    assert set(TABLE) <= used | {n.op for n in order(waves.formula.roots)}


def test_what_has_samples_is_judged_with_the_operations(monkeypatch: pytest.MonkeyPatch) -> None:
    """The sweep is over numbers; a run of the suite puts samples of data to the law beside it."""
    judged: list[str] = []
    monkeypatch.setattr(suite, "check_samples", lambda name, backend, seed: judged.append(name) or [])
    suite.run_suite(NUMPY[:1], graphs=0, operations=["neg", "lookup", "nearest"], programs=[])
    assert judged == ["lookup", "nearest"]
    assert {name for name in TABLE if has_samples(name)} == {
        "lookup", "lookup_cubic", "covers", "nearest", "joined", "principal", "random", "sites"
    }  # fmt: skip


def test_a_wrong_expectation_is_reported_with_its_line(tmp_path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "wrong.pore"
    path.write_text("sphere(2)\n# expect: part(5, 0, 0) = 3\n# expect: part(5, 0, 0) = 3.5\n")
    failures = [f.failure for f in check_case(read_case(path), NUMPY[0], points=8, seed=0) if f.failure]
    assert [f.where for f in failures] == ["wrong.pore:3"]
    assert "3.5" in failures[0].example


def test_a_wrong_warning_and_a_check_that_does_not_fail_are_reported(tmp_path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "wrong.pore"
    path.write_text('check 1 < 2, "never"\nsphere(2)\n# warn: W999\n# fails: never\n')
    failures = [f.failure for f in check_case(read_case(path), NUMPY[0], points=8, seed=0) if f.failure]
    assert len(failures) == 2


def test_an_unreadable_expectation_names_its_line(tmp_path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "bad.pore"
    path.write_text("x\n# expect: part(1, 2) = 3\n")
    with pytest.raises(ValueError, match=r"bad\.pore:2"):
        read_case(path)


def test_numbers_of_expectations() -> None:
    assert number("2 * sqrt(2)**2 - 1") == pytest.approx(3)
    assert number("-pi / 2 + true") == pytest.approx(1 - 3.141592653589793 / 2)
    with pytest.raises(ValueError, match="no number"):
        number("[1]")


def test_the_programs_are_found() -> None:
    assert (folder() / "lib" / "plates.pore").is_file()


@pytest.mark.slow
def test_a_certificate_says_what_was_done(
    gpu: Gpu,
    swept: Callable[[str], list[Measurement]],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    few = CASES[::6]
    monkeypatch.setattr(suite, "cases", lambda: few)  # all of them have their own test
    monkeypatch.setattr(suite, "sweep", lambda backend, *_: swept(backend.name))
    assert certificate(json=True, count=8, seed=5) == 0
    made = json.loads(capsys.readouterr().out)
    assert made["holds"] is True
    assert made["failures"] == []
    assert made["seed"] == 5
    assert made["programs"] == len(few)
    assert made["graphs"] == 8
    assert made["backends"] == ["numpy f64", "numpy f32", "glsl"]
    assert {m["op"] for m in made["measurements"]} == {name for name in TABLE if not has_samples(name)}
    assert made["points"] > 3 * 200 * len(few)
    assert 0.9 * made["points"] < made["sharp"] <= made["points"]
    assert 0 < made["use"] <= 1


@pytest.mark.slow
def test_the_doctor_names_the_device(gpu: Gpu, capsys: pytest.CaptureFixture[str]) -> None:
    assert doctor(json=True) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["opengl"]["renderer"] == gpu.info.renderer
    assert {row["op"] for row in [*told["operations"], *told["data"]]} == TABLE.keys()
    assert all(row["use"] <= 1 for row in told["data"])


@pytest.mark.slow
def test_the_doctor_tells_what_is_missing(
    swept: Callable[[str], list[Measurement]], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def none() -> None:
        raise GpuMissing("there is no OpenGL", "apt-get install libegl1 libgl1")

    monkeypatch.setattr(report, "shared_gpu", none)
    monkeypatch.setattr(report, "sweep", lambda backend: swept(backend.name))
    assert doctor() == 3
    text = capsys.readouterr().out
    assert "apt-get install libegl1 libgl1" in text
    assert "numpy f32" in text
    assert "glsl" not in text
    assert doctor(json=True) == 3
    assert json.loads(capsys.readouterr().out)["missing"]["install"] == "apt-get install libegl1 libgl1"


def test_the_tolerances_in_the_documentation_are_those_of_the_table() -> None:
    text = (folder().parent.parent / "docs" / "conformance.md").read_text(encoding="utf-8")
    rows = {cells[0]: cells[1] for line in text.splitlines() if len(cells := line.strip("| ").split(" | ")) == 3}
    for name, row in TABLE.items():
        t = row.tolerance
        written = rows[name]
        assert (written == "exact") == (not (t.ulp or t.absolute or t.extra)), name
        if t.ulp:
            assert f"{t.ulp:g} of the result" in written, name
        if t.absolute >= 1:
            assert f"+ {t.absolute:g}" in written, name
