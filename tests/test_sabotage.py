"""The suite is put to the test: operations are broken on purpose, and it has to say which one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from porelang.backends import glsl as glsl_backend
from porelang.conformance import report, suite
from porelang.conformance.backend import NUMPY, Backend
from porelang.conformance.programs import cases
from porelang.conformance.report import certificate, doctor
from porelang.conformance.suite import run_suite
from porelang.conformance.sweep import sweep
from porelang.gpu import Gpu, fields
from porelang.interval import Interval, interval
from porelang.ops import TABLE

F64, F32 = NUMPY


@pytest.fixture
def device_backend(named: Callable[[str], Backend]) -> Backend:
    return named("glsl")


@pytest.fixture(autouse=True)
def _fresh() -> Iterator[None]:
    """Shaders are kept by their graph, which knows nothing of a changed table."""
    fields._shader.cache_clear()
    yield
    fields._shader.cache_clear()


def broken(monkeypatch: pytest.MonkeyPatch, name: str, **changes: Any) -> None:
    monkeypatch.setitem(TABLE, name, replace(TABLE[name], **changes))


def blamed(backend: Any, name: str) -> set[tuple[str, str]]:
    """(what found it, operation) of every failure of a small run of the suite; the other operations are as they were,
    which `test_table` sweeps."""
    made = run_suite([backend], graphs=60, seed=3, operations=[name], programs=cases()[::10])
    return {(f.where.split()[0], f.operation) for f in made.failures}


@pytest.mark.parametrize(
    ("name", "template"),
    [
        ("add", "({0} - {1})"),  # a wrong sign
        ("sub", "({1} - {0})"),  # arguments exchanged
        ("cos", "pore_sin({0})"),  # a sine for a cosine
        ("cos_turns", "pore_sin_turns({0})"),
        ("abs", "({0})"),  # a missing abs
        ("floor", "trunc({0})"),  # right for positive numbers only
        ("round", "floor({0} + 0.5)"),  # halves up
        ("le", "({0} < {1})"),  # an equality forgotten
        ("sqrt", "sqrt({0}) * 1.00001"),  # slightly off
        ("exp", "exp({0} * 1.0001)"),
        ("atan2", "atan({0}, {1})"),  # the driver's own, which is not good enough
        ("select", "({0} ? {2} : {1})"),
        ("min", "pore_max({0}, {1})"),
        ("reduced", "({0} * 6.2831855)"),  # whole turns left in
        ("lookup", "pore_lookup{0}({2}, {1}, {3}, {payload})"),  # coordinates exchanged
        ("lookup_cubic", "pore_lookup{0}({1}, {2}, {3}, {payload})"),  # linear for cubic
        ("covers", "(pore_covers{0}({1}, {2}, {3}) || {1} > 0.0)"),
        ("nearest", "pore_nearest{0}({1}, {2}, {3} * 1.001)"),
        ("joined", "pore_joined{0}({1}, {2}, {3}, {4} * 1.01)"),
    ],
)
def test_a_wrong_shader_is_found(
    device_backend: Backend, monkeypatch: pytest.MonkeyPatch, name: str, template: str
) -> None:
    broken(monkeypatch, name, glsl=template, guarded="", calm="")
    made = run_suite([device_backend], graphs=0, seed=3, operations=[name], programs=[])
    assert {f.operation for f in made.failures} == {name}
    assert not made.holds


def test_a_wrong_cheap_form_is_found(device_backend: Backend, monkeypatch: pytest.MonkeyPatch) -> None:
    broken(monkeypatch, "max", guarded="min({0}, {1})")
    made = run_suite([device_backend], graphs=0, seed=3, operations=["max", "min"], programs=[])
    assert {(f.where, f.operation) for f in made.failures} == {("table, guarded form", "max")}


def test_a_special_value_forgotten_is_found(device_backend: Backend, monkeypatch: pytest.MonkeyPatch) -> None:
    """The driver's own min of NaN is a number; only the general form's sweep can know."""
    broken(monkeypatch, "min", glsl="min({0}, {1})")
    made = run_suite([device_backend], graphs=0, seed=3, operations=["min"], programs=[])
    assert [f.where for f in made.failures] == ["table, general form"]
    assert "nan" in made.failures[0].example


@pytest.mark.slow
def test_graphs_and_programs_blame_the_operation(device_backend: Backend, monkeypatch: pytest.MonkeyPatch) -> None:
    """Programs and random graphs find it without the sweep, and name the operation and not what is built on it."""
    broken(monkeypatch, "sub", glsl="({1} - {0})")
    made = run_suite([device_backend], graphs=60, seed=3, operations=[], programs=cases()[::10])
    graphs = [f for f in made.failures if f.where.startswith("graph")]
    laws = [f for f in made.failures if "`" in f.where]
    assert graphs
    assert laws
    assert {f.operation for f in graphs + laws} == {"sub"}
    assert all(f.example.splitlines()[0].startswith("%0") for f in graphs)


@pytest.mark.parametrize(
    ("name", "form"),
    [
        ("mul", lambda a, b, out=None: np.multiply(a, b, out=out) * a.dtype.type(1 + 1e-3)),
        ("sin", lambda a, out=None: np.cos(a, out=out)),
        ("hypot", lambda a, b, out=None: np.add(np.abs(a), np.abs(b), out=out)),
        ("log", lambda a, out=None: np.log2(a, out=out)),
    ],
)
@pytest.mark.parametrize("backend", [F64, F32], ids=["f64", "f32"])
@pytest.mark.slow
def test_a_wrong_array_form_is_found(
    monkeypatch: pytest.MonkeyPatch, name: str, form: Callable[..., Any], backend: Any
) -> None:
    def written(*arguments: Any, out: Any = None) -> Any:
        result = form(*arguments)
        if out is None:
            return result
        np.copyto(out, result)
        return out

    broken(monkeypatch, name, numpy=written)
    found = blamed(backend, name)
    assert ("table,", name) in found
    made_of_it = {"sin": {"sin_turns"}}.get(name, set())  # NumPy takes it apart: the sine of what is reduced
    assert {operation for _, operation in found} <= {name, "", *made_of_it}


@pytest.mark.parametrize("name", ["lookup", "lookup_cubic", "nearest", "joined"])
@pytest.mark.parametrize("backend", [F64, F32], ids=["f64", "f32"])
def test_a_wrong_reading_of_data_is_found(monkeypatch: pytest.MonkeyPatch, name: str, backend: Any) -> None:
    right = TABLE[name].numpy

    def form(data: Any, x: Any, y: Any, z: Any, *asked: Any, **more: Any) -> Any:
        return right(data, x, y, z * x.dtype.type(1 + 1e-3), *asked, **more)

    broken(monkeypatch, name, numpy=form)
    made = run_suite([backend], graphs=0, seed=3, operations=[name], programs=[])
    assert {f.operation for f in made.failures} == {name}
    graphs = run_suite([backend], graphs=120, seed=3, operations=[], programs=[])
    assert {f.operation for f in graphs.failures} == {name}


def test_an_error_of_a_thousandth_is_found_in_graphs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Float32 alone is off, so that the float64 reference knows better."""

    def form(a: Any, b: Any, out: Any = None) -> Any:
        result = np.multiply(a, b, out=out)
        if result.dtype == np.float32:
            result *= np.float32(1.001)
        return result

    broken(monkeypatch, "mul", numpy=form)
    made = run_suite([F32], graphs=60, seed=3, operations=[], programs=[])
    assert made.failures
    assert {f.operation for f in made.failures} == {"mul"}


def test_a_wrong_enclosure_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """The law rests on enclosures; one that is too narrow shows as well."""

    def narrow(a: Interval) -> Interval:
        return interval(np.sqrt(np.maximum(a.lo, 0)), np.sqrt(np.maximum(a.lo, 0)))

    broken(monkeypatch, "sqrt", enclose=narrow)
    assert "sqrt" in {operation for _, operation in blamed(F32, "sqrt")}


def test_a_missing_function_is_no_pass(device_backend: Backend, monkeypatch: pytest.MonkeyPatch) -> None:
    """A shader that does not compile is an error and never counts as kept."""
    broken(monkeypatch, "neg", glsl="no_such_function({0})")
    with pytest.raises(Exception, match="graphics driver"):
        run_suite([device_backend], graphs=0, operations=["neg"], programs=[])


def test_a_wrong_library_function_is_found(device_backend: Backend, monkeypatch: pytest.MonkeyPatch) -> None:
    text = glsl_backend._function("pore_sine")
    wrong = text.replace("2.28318524", "2.28319")
    assert wrong != text
    monkeypatch.setattr(glsl_backend, "_function", lambda name, known=glsl_backend._function: (
        wrong if name == "pore_sine" else known(name)))  # fmt: skip
    made = run_suite([device_backend], graphs=0, operations=["sin_turns", "cos_turns", "floor"], programs=[])
    assert {f.operation for f in made.failures} == {"sin_turns", "cos_turns"}


@pytest.mark.slow
def test_the_doctor_finds_a_wrong_lookup(
    gpu: Gpu, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(glsl_backend, "_function", lambda name, known=glsl_backend._function: (
        known(name).replace("p0 + d * at.f", "p0 + d * at.g") if name.startswith("pore_lookup") else known(name)
    ))  # fmt: skip
    monkeypatch.setattr(report, "NUMPY", ())
    monkeypatch.setattr(report, "sweep", lambda backend: [])
    assert doctor() == 1
    assert "BEYOND ITS BOUND  lookup" in capsys.readouterr().out


@pytest.mark.slow
def test_commands_report_it(gpu: Gpu, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    broken(monkeypatch, "floor", glsl="trunc({0})")
    monkeypatch.setattr(report, "NUMPY", ())  # which is not broken
    for asked in (report, suite):  # all operations and programs are gone through where nothing is broken
        monkeypatch.setattr(asked, "sweep", lambda backend, *_: sweep(backend, ["floor", "round"]))
    monkeypatch.setattr(suite, "cases", lambda: [c for c in cases() if c.name == "kernel_rounding"])
    assert doctor() == 1
    assert "BEYOND TOLERANCE  floor(" in capsys.readouterr().out
    assert certificate(count=0, seed=1) == 1
    printed = capsys.readouterr().out
    assert "operation `floor`" in printed
    assert "The law is broken" in printed
