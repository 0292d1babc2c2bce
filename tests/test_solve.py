"""`solve` gives the one number for which a function takes a value, with a true error, or says that there is not one."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import porelang
from porelang.cli import main
from porelang.diagnostics import Diagnostic
from porelang.ir import order, unknown
from porelang.tasks.numbers.trends import trend


def refusal(text: str) -> Diagnostic:
    with pytest.raises(porelang.PoreError) as caught:
        porelang.compile(text).reduced()
    (found,) = caught.value.diagnostics
    assert found.span is not None
    return found


@pytest.mark.parametrize(
    ("call", "exact"),
    [
        ("solve(t => t^2, 4, -1..3)", 2.0),  # it turns, and takes the value once
        ("solve(t => (t-1)*(t-2)*(t-3), 0, 1.5..2.5)", 2.0),
        ("solve(t => t^2, 0.01, 0.1..1)", 0.1),  # at the end of the range, to rounding
        ("solve(t => t, 3, 1..3)", 3.0),
        ("solve(t => t^2, 0, -1..2)", 0.0),  # it touches
        ("solve(t => t^2 - 2*t + 1, 0, -1..2)", 1.0),
        ("solve(t => abs(t - 1), 0, 0..5)", 1.0),
        ("solve(t => t^3, 0, -1..10)", 0.0),  # as flat as can be
        ("solve(t => sqrt(t - 3), 0.5, 0..5)", 3.25),  # not a number in a part of the range
        ("solve(t => tan(t), 3, 0..1.57)", math.atan(3)),
        ("solve(t => 1 / (t - 1), 3, 0..2)", 4 / 3),  # beside a pole
        ("solve(t => floor(t) + t, 5.5, 0..4)", None),  # jumped over
        ("solve(t => floor(t) + t, 4.5, 0..4)", 2.5),  # between two jumps
        ("solve(t => clamp(t, 1, 2), 1.5, 0..4)", 1.5),
        ("solve(t => gyroid(10) @ [t, 0, 0], 0.5, -1..1)", 10 * math.asin(0.5) / math.tau),
    ],
)
def test_the_one_answer_of_a_formula_lies_within_its_error(call: str, exact: float | None) -> None:
    if exact is None:
        assert refusal(f"x + {call}").code == "E099"
        return
    (found,) = porelang.compile(f"x + {call}").reduced().values()
    assert abs(found.value - exact) <= found.error < 1e-6
    assert found.sole


@pytest.mark.parametrize(
    ("call", "code", "words"),
    [
        ("solve(t => (t-1)*(t-2)*(t-3), 0, 0..4)", "E098", ("3 answers", "at 1, 2 and 3", "`0..1.5`")),
        ("solve(t => t * t * exp(-t), 0.2, 0..20)", "E098", ("2 answers",)),
        ("solve(t => (t-1)^2 * (t-3)^2, 0, -10..10)", "E098", ("at 1 and 3",)),
        ("solve(t => sin(100000 * t), 0.5, 0..10)", "E098", ("many answers",)),
        ("solve(t => clamp(t, 1, 2), 1, 0..4)", "E098", ("any number of answers", "throughout 0..1")),
        ("solve(t => floor(t), 2, 0..4)", "E098", ("between 2 and 3",)),
        ("solve(t => floor(t), 1.5, 0..4)", "E099", ("at 2", "from 1 to 2")),
        ("solve(t => if t < 2 then t else t + 3, 4, 0..4)", "E099", ("at 2", "from 2 to 5")),
        ("solve(t => 1 / (t - 1), 0, 0..2)", "E099", ("at 1 ",)),
        ("solve(t => t^2 + 1e-3, 0, -1..2)", "E094", ("cannot be reached",)),
        ("solve(t => t^2, 0.0099, 0.1..1)", "E094", ("cannot be reached",)),
        ("solve(t => mean(t * x + t * t, sphere(1)), 20, 0..3)", "E094", ("was not met in 11 places", "from 0 to 3")),
        ("solve(t => volume(sphere(abs(t))), 10, -5..5)", "E098", ("at least 2 answers", "narrow")),
        ("solve(t => volume(box([floor(t), 1, 1])), 3.5, 1..6)", "E099", ("at 4", "from 3 to 4")),
    ],
)
def test_what_is_not_the_only_answer_is_none(call: str, code: str, words: tuple[str, ...]) -> None:
    found = refusal(f"x + {call}")
    assert found.code == code
    for word in words:
        assert word in str(found)


def test_the_range_that_is_advised_holds_one_answer() -> None:
    hint = refusal("x + solve(t => (t-1)*(t-2)*(t-3), 0, 0..4)").hint
    advised = hint.split("`")[1]
    (found,) = porelang.compile(f"x + solve(t => (t-1)*(t-2)*(t-3), 0, {advised})").reduced().values()
    assert abs(found.value - 1) <= found.error


@pytest.mark.parametrize(
    ("text", "status"),
    [
        ("sphere(solve(t => (t-1)*(t-2)*(t-3), 0, 0..4))", 1),
        ("sphere(solve(t => (t-1)*(t-2)*(t-3), 0, 1.5..2.5))", 0),
        ("param k = 0 in 0..1\nsphere(if k > 0.5 then solve(t => floor(t), 1.5, 0..4) else 3)", 0),
        ("sphere(solve(s => s + solve(t => t * s, 6, 0.1..100), 5, 2.5..4.5))", 0),
        ("sphere(solve(t => t^2, 4, -3..3)) & sphere(volume(sphere(1)) / 1mm^2)", 0),  # that needs --measure
    ],
)
def test_a_check_says_at_once_what_is_wrong_with_a_formula(
    text: str, status: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "part.pore"
    path.write_text(text)
    assert main(["check", str(path)]) == status
    assert ("E098" in capsys.readouterr().err) == bool(status)


def test_numbers_with_errors_widen_the_answer() -> None:
    """t V(1) = 2, where the volume of a ball comes with an error of its own."""
    ball, found = (
        porelang.compile("let v = volume(sphere(1))\nx + v + solve(t => t * bare(v), 2, 0..10)").reduced().values()
    )
    exact = 2 / (4 / 3 * math.pi)
    assert abs(found.value - exact) <= found.error
    assert found.error == pytest.approx(exact * ball.error / ball.value, rel=0.1)


@pytest.mark.parametrize(
    ("function", "low", "high", "way"),
    [
        ("volume(sphere(t))", 1, 9, 1),
        ("volume(cylinder(t, 2 * t))", 1, 9, 1),
        ("volume(box([t, t, t]))", 1, 9, 1),
        ("bare(volume(sphere(t)))^5 - t^-2", 1, 9, 1),
        ("porosity(gyroid(10) - t, sphere(9))", -1, 1, -1),
        ("porosity(shell(gyroid(10), t), sphere(9))", 0.1, 1.4, -1),
        ("porosity(thicken(schwarz_p(10), x / 30 + t, 0.3), sphere(9))", -1, 1, -1),
        ("to_porosity(gyroid(10), t, sphere(9))", 0.1, 0.9, -1),
        ("volume(sphere(abs(t)))", -5, 5, 0),
        ("bare(volume(sphere(t))) - t", 1, 9, 0),
        ("porosity(sphere(t), sphere(2 * t))", 1, 9, 0),
        ("area(sphere(t))", 1, 9, 0),
        ("porosity(gyroid(t), sphere(9))", 5, 9, 0),
        ("volume(sphere(floor(t)))", 1, 9, 0),
    ],
)
def test_which_way_numbers_go_is_proven_by_slopes(function: str, low: float, high: float, way: int) -> None:
    program = porelang.compile(f"x + solve(t => {function}, 1, {low}..{high})")
    (asked,) = (n for n in order(program.graph.roots) if n.op == "solve")
    assert trend(asked.args[0], unknown(0), low, high, {}) == (-way if "thicken" in function else way)


@pytest.mark.slow
def test_an_answer_beside_which_there_may_be_others_is_doubted() -> None:
    """It rises and falls again: what was looked at in some places is one answer, not certainly the only one."""
    text = "sphere(solve(t => bare(volume(sphere(t) & box([4, 4, 4]))) - 3 * t, 2, 0.2..6))"
    design = porelang.compile(text).design()
    (warning,) = design.told(*design.program.roots())
    assert (warning.code, warning.severity) == ("W206", "warning")
    assert "there may be others" in warning.message
    sure = porelang.compile("sphere(solve(t => volume(sphere(t)), 100, 1..10))").design()
    assert not sure.told(*sure.program.roots())
