"""The loop of a program, in tetrahedra of its lattice: a short cantilever of a network, in coarse elements."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import porelang
from porelang.cli import main, optimizing
from porelang.diagnostics import PoreError, fail
from porelang.optimize import record
from porelang.optimize.adapting import adapting
from porelang.optimize.grid import Grid
from porelang.optimize.real import Real
from porelang.optimize.rules import Optimum

TEXT = """param t: field = 0 "offset of the network"
param other: field = 1
let bar = box([60mm, 20mm, 20mm])
let lattice = gyroid(20mm) - t & bar
let s = study(lattice, fix=x < -29.9mm, load=force(x > 29.9mm, [0N, 0N, -10N]), E=1GPa, nu=0.3, size=3mm, order=1)
let solid = study(bar, fix=x < -29.9mm, load=force(x > 29.9mm, [0N, 0N, -10N]), E=1GPa, nu=0.3, size=8mm, order=1)
out part = lattice
out still = gyroid(20mm) & bar
out other_part = bar - 0.1 * t
"""


def design(text: str = TEXT) -> Any:
    return porelang.compile(text).design()


def test_what_adapts_is_found() -> None:
    found = adapting(design())
    assert (found.output, found.param, found.study) == ("part", "t", "s")
    assert found.cell() == pytest.approx(20)
    assert found.as_it_stands() == pytest.approx(0.5, abs=0.005)
    law, sign = found.law(0.3, 0.7)
    assert sign == 1
    # by the share of a cell where sin x cos y + sin y cos z + sin z cos x is below t, on a grid of its own
    x, y, z = np.meshgrid(*[(np.arange(90) + 0.5) / 90 * 2 * np.pi] * 3, indexing="ij")
    wave = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    for density in (0.35, 0.5, 0.65):
        t = float(law.thickness(np.array([density]))[0])
        assert (wave < t).mean() == pytest.approx(density, abs=0.005)


def test_a_param_may_thin() -> None:
    law, sign = adapting(design(TEXT.replace("gyroid(20mm) - t", "gyroid(20mm) + t"))).law(0.3, 0.7)
    assert sign == -1
    assert law.thickness(np.array([0.5]))[0] == pytest.approx(0, abs=0.02)


def test_a_param_may_be_the_size_of_the_cells() -> None:
    """Walls that are as thick everywhere: the density of a sheet goes as one over the period, of `phase` as of a
    number."""
    text = TEXT.replace("param t: field = 0", "param t: field = 20mm").replace("0.1 * t", "9mm")
    by = [
        adapting(design(text.replace("gyroid(20mm) - t", f"{lattice} |> shell(24mm / t)")))
        for lattice in ("gyroid(t)", "gyroid(phase=phase(t, bar))")
    ]
    law, sign = by[0].law(0.33, 0.5)
    assert sign == -1
    sizes = -law.thickness(np.array([0.35, 0.48]))
    # few cells are cut as they come, so that the density of 20 mm cells is known to some percent
    assert sizes[0] / sizes[1] == pytest.approx(0.48 / 0.35, rel=0.12)
    for found in by:
        assert found.cell() == pytest.approx(20)
        part = found.part(found.same_all_over(31.0))
        assert found.cell(part) == pytest.approx(31)
    assert by[1].density(by[1].same_all_over(31.0)) == pytest.approx(by[0].density(by[0].same_all_over(31.0)), abs=0.02)


@pytest.mark.parametrize(
    ("more", "code", "word"),
    [
        ({"output": "still"}, "E193", "reads no param"),
        ({"adapt": "other"}, "E193", "does not read `other`"),
        ({"adapt": "tt"}, "E193", "no param that takes one number"),
        ({"study": "solid"}, "E193", "is not of `part` itself"),
        ({"study": "z"}, "E100", "no study `z`"),
        ({"output": "other_part"}, "E193", "no study of the program is of `other_part`"),
    ],
)
def test_what_cannot_adapt(more: dict[str, str], code: str, word: str) -> None:
    with pytest.raises(PoreError) as caught:
        adapting(design(), **more)
    (told,) = caught.value.diagnostics
    assert told.code == code
    assert word in told.message
    assert told.hint


def test_limits_that_are_not_reached() -> None:
    text = TEXT.replace("gyroid(20mm) - t", "gyroid(20mm) - 0.3 * sin(t)")
    with pytest.raises(PoreError, match=r"E19[23]"):
        adapting(design(text)).law(0.2, 0.8)


def test_a_size_that_does_not_reach_the_limits_is_told_as_densities(monkeypatch: pytest.MonkeyPatch) -> None:
    """And not as a period below 0, which nobody asked for; the limits that are proposed are reached."""
    text = TEXT.replace("param t: field = 0", "param t: field = 20mm").replace("0.1 * t", "9mm")
    text = text.replace("gyroid(20mm) - t", "gyroid(phase=phase(t, bar)) |> shell(24mm / t)")
    found = adapting(design(text))

    def share(self: Any, value: float) -> float:
        if value <= 0:
            raise fail("E147", f"the period that is asked for is {value:g} mm")
        return float(0.31 + 0.69 / (1 + (value / 20) ** 2))

    monkeypatch.setattr(type(found), "_share", share)
    monkeypatch.setattr(type(found), "as_it_stands", lambda self: share(self, 20.0))
    with pytest.raises(PoreError, match=r"E193.*takes the density of `part` from 0\.3") as caught:
        found.law(0.2, 0.8)
    low, high = re.search(r"limits[ =]\"?([\d.]+)\.\.([\d.]+)", str(caught.value)).groups()
    law, sign = found.law(float(low), float(high))
    assert sign == -1
    assert law.limits[0] <= float(low) < float(high) <= law.limits[1]


def test_limits_that_are_proposed_are_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    """A density that falls back a little on its way, too little for the ladder to see: limits that end above that are
    proposed at once, and not first those that are refused for it."""
    text = TEXT.replace("param t: field = 0", "param t: field = 20mm").replace("0.1 * t", "9mm")
    found = adapting(design(text.replace("gyroid(20mm) - t", "gyroid(phase=phase(t, bar)) |> shell(24mm / t)")))

    def share(self: Any, value: float) -> float:
        if value <= 0:
            raise fail("E147", f"the period that is asked for is {value:g} mm")
        return float(0.22 + 0.78 / (1 + (value / 20) ** 2) + 0.1 * np.exp(-(((value - 70) / 5) ** 2)))

    monkeypatch.setattr(type(found), "_share", share)
    monkeypatch.setattr(type(found), "as_it_stands", lambda self: share(self, 20.0))
    with pytest.raises(
        PoreError, match=r"`t` takes the density of `part` from 0\.2\d+ to .*, which is not all"
    ) as caught:
        found.law(0.2, 0.8)
    low, high = (float(x) for x in re.search(r"limits[ =]\"?([\d.]+)\.\.([\d.]+)", str(caught.value)).groups())
    law, _ = found.law(low, high)
    assert low > share(found, 70.0) - 0.1  # above what falls back
    assert law.limits[0] <= low < high <= law.limits[1]


@pytest.mark.parametrize(
    ("mean", "limits"), [(0.193, (0.2, 0.8)), (0.97, (0.2, 0.8)), (0.5, (0, 1)), (0.5, (0.8, 0.2))]
)
def test_limits_that_do_not_hold_the_mean_have_others_proposed(mean: float, limits: tuple[float, float]) -> None:
    with pytest.raises(PoreError, match="E192") as caught:
        porelang.compile(TEXT).iterate("part", limits=limits, porosity=1 - mean)
    low, high = re.search(r"limits[ =]\"?([\d.]+)\.\.([\d.]+)", str(caught.value)).groups()
    assert 0 < float(low) < mean < float(high) <= 1


MOVED = TEXT.replace("load=force(x > 29.9mm, [0N, 0N, -10N]), E=1GPa, nu=0.3, size=3mm", "load=moved(x > 29.9mm, "
                     "[0mm, 0mm, -1mm]), E=1GPa, nu=0.3, size=4mm")  # fmt: skip


def test_what_loads_the_part_is_found() -> None:
    assert adapting(design()).under == "forces"
    assert adapting(design(MOVED)).under == "displacements"
    one = "moved(x > 29.9mm, [0mm, 0mm, -1mm])"
    mixed = MOVED.replace(one, f"[force(z > 9.9mm, [0N, 0N, 9N]), {one}]")
    still = mixed.replace("-1mm", "0mm")
    assert mixed != MOVED
    assert mixed != still
    assert adapting(design(still)).under == "forces"  # what is moved by 0 mm is held
    with pytest.raises(PoreError, match=r"E193.*`moved` and a `force`"):
        adapting(design(mixed))


def test_a_loop_tells_of_its_best_step_and_its_cell(tmp_path: Path) -> None:
    """The study of the start alone: what it doubts, what is on record, what is written."""
    program = porelang.compile(MOVED)
    with pytest.warns(porelang.PoreWarning) as told:
        found = program.iterate("part", most=0, until="0.5%", limits="30%..0.7", damping="0.5", folder=tmp_path / "a")
    assert "W284" in {w.message.diagnostic.code for w in told}
    assert all("step 0" in d.message for d in found.told if d.code in ("W284", "W266"))
    (step,) = found.steps
    head, line = (json.loads(text) for text in (tmp_path / "a" / "loop.jsonl").read_text().splitlines())
    assert (head["cell"], head["damping"], head["low"]) == (pytest.approx(20), 0.5, 0.3)
    assert (line["under"], step.under) == ("displacements", "displacements")
    # under a displacement of 1 mm the work is the stiffness
    solved = found.design.study("s")
    assert step.compliance == pytest.approx(solved.numbers["stiffness"].value, rel=1e-9)
    assert len(repr(found)) < 200
    assert "work" in str(found)
    assert "<table>" in found._repr_html_()
    with pytest.warns(porelang.PoreWarning):
        again = program.iterate("part", most=0, limits=(0.3, 0.7), damping=0.5, folder=tmp_path / "a", resume=True)
    assert again.steps == found.steps
    assert [d.code for d in again.told] == [d.code for d in found.told]


def test_a_step_that_fails_leaves_the_best_so_far(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file, folder = tmp_path / "bar.pore", tmp_path / "loop"
    file.write_text(TEXT.replace("size=3mm", "size=5mm"))
    words = ["optimize", str(file), "--iterate", "part", "--limits", "0.3..0.7", "-o", str(folder)]
    whole = Real.solve

    def solve(self: Real, density: Any, state: Any) -> Any:
        if np.ptp(density) > 0:
            raise fail("E187", "a pad touches nothing", hint="elsewhere")
        return whole(self, density, state)

    monkeypatch.setattr(Real, "solve", solve)
    assert main(words) == 1
    out, err = capsys.readouterr()
    assert "error[E187]: a pad touches nothing" in err
    assert "warning[W277]: step 1 could not be solved" in err
    assert "--resume" in err
    assert "ended: a step could not be solved; step 0" in out
    assert {p.name for p in folder.iterdir()} == {"t.npz", "history.md", "history.png", "loop.jsonl", "step-000.npz"}

    assert main(words) == 1
    assert "--force" in capsys.readouterr().err
    assert main([*words, "--resume", "--force"]) == 2
    step = folder / "step-000.npz"
    step.write_bytes(step.read_bytes()[:-9])
    assert main([*words, "--resume"]) == 1
    assert "warning[W272]: the record was damaged: step-000.npz" in capsys.readouterr().err
    assert main([*words, "--resume", "-q"]) == 1  # what is found is said all the same
    assert f"{folder}: t.npz" in capsys.readouterr().out
    assert main([*words, "--force", "--damping", "0.5", "-q", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["failed"][0]["code"] == "E187"
    assert json.loads((folder / "loop.jsonl").read_text().splitlines()[0])["damping"] == 0.5


def test_a_porosity_that_is_missed_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    what = adapting(design(TEXT.replace("size=3mm", "size=5mm")))
    law, sign = what.law(0.3, 0.7)
    grid = Grid(np.ones((6, 2, 2)), what.box.lo, (10, 10, 10))
    for mean, missed in ((0.5, False), (0.9, True)):  # of which the last lies beyond the limits
        answer = Real(what, grid, law, sign, 20, mean).solve(np.full(24, mean), None)
        assert ("W278" in {d.code for d in answer.doubts}) == missed
        assert answer.porosity == pytest.approx(1 - min(mean, 0.7), abs=0.05)


def test_a_gain_is_known_to_what_two_meshes_differ_by(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same two densities in finer elements: their ratio moves by less than is stated. Elements that join holes
    otherwise add what those may hold."""
    from porelang.optimize import real

    kept, whole = [], real.study_of

    def study_of(*args: Any) -> Any:
        kept.append(whole(*args))
        return kept[-1]

    monkeypatch.setattr(real, "study_of", study_of)
    short = TEXT.replace("60mm", "40mm").replace("29.9", "19.9")
    whats = [adapting(design(short.replace("size=3mm", f"size={size}"))) for size in ("5mm", "4mm")]
    law, sign = whats[0].law(0.3, 0.7)
    grid = Grid(np.ones((4, 2, 2)), whats[0].box.lo, (10, 10, 10))
    even, lean = np.full(16, 0.5), np.repeat(np.linspace(0.66, 0.34, 4), 4)
    steps = [[Real(what, grid, law, sign, 20, 0.5).solve(d, None) for d in (even, lean)] for what in whats]
    ratios = [second.compliance / first.compliance for first, second in steps]
    for first, second in steps:
        stated = float(np.hypot(first.apart, second.apart))
        assert abs(ratios[0] / ratios[1] - 1) < stated < 0.5 * second.error
    found = kept[-1]
    other = replace(found, missed=replace(found.missed, handles=4, of=19, necks=0.3))
    more = 0.5 * 4 / 20  # of what hangs on each of 20 holes
    assert real.apart_of(other) > real.form_error(found.missed) + more


def test_what_is_nearly_uniform_needs_no_finer_elements() -> None:
    """A column of few cells varies a little, and a step gains nothing that was asked for."""
    from porelang.optimize import loop
    from porelang.optimize.doubts import doubts

    step = record.Step(0, 2.0243, 0.074, 1, 1, 1, 0.5, None, 0.019, 0.009, apart=0.01)
    next_one = replace(step, number=1, compliance=2.0239, change=-2e-4, spread=0.015)
    what = adapting(design())
    for spread, gain, code in (
        (0.019, 2e-4, "W268"),
        (0.019, -1e-3, "W268"),
        (0.3, 2e-4, "W270"),
        (0.04, 0.01, "W270"),
    ):
        first = replace(step, spread=spread)
        after = replace(next_one, compliance=step.compliance * (1 - gain))
        (told, *_) = doubts(what, loop.Outcome((first, after), 0, np.ones(1), "settled"), 12, 0.005, False)
        assert told.code == code
        assert ("finer" in (told.hint or "")) == (code == "W270")


def test_what_the_uniform_part_makes_unsure_is_told() -> None:
    """A start whose elements are joined otherwise, and a best step that is not so: no word where both stray alike."""
    from porelang.optimize import loop
    from porelang.optimize.doubts import doubts

    coarse = ("W284", "elements are joined otherwise", "its stiffness may be off", "take finer elements")
    start = record.Step(0, 16.0, 0.24, 1, 1, 1, 0.5, None, 0.6, 0.03, doubts=(coarse,), apart=0.12)
    best = replace(start, number=1, compliance=10.3, change=-0.36, doubts=(), apart=0.022)
    what = adapting(design())
    for apart, told in ((0.12, 1), (0.05, 0)):
        steps = (replace(start, apart=apart), best)
        found = doubts(what, loop.Outcome(steps, 1, np.ones(1), "most"), 8, 0.005, False)
        assert [d.message.startswith("in step 0, which all is compared with") for d in found] == [True] * told


def test_what_helps_is_proposed_and_what_a_gain_costs_is_told() -> None:
    """Damping does nothing for an optimum. A displacement that rises by a third for a gain of 7 %, and a stress, are
    told; for a gain of 35 % a greatest stress that moves by so much is not."""
    from porelang.optimize import loop
    from porelang.optimize.doubts import doubts

    what = adapting(design())
    start = record.Step(0, 10.0, 0.1, 4.8, 1, 0.0872, 0.5, None, 0.6, 0.03, apart=0.02)
    softer = replace(start, number=1, compliance=10.4)
    for optimal, proposed in ((True, "--rule energy"), (False, "--damping 0.5")):
        (told,) = doubts(what, loop.Outcome((start, softer), 0, np.ones(1), "most"), 8, 0.005, optimal)
        assert told.code == "W269"
        assert proposed in (told.hint or "")
    better = replace(start, number=1, compliance=9.34, max_displacement=0.1139, max_von_mises=7.9)
    (told,) = doubts(what, loop.Outcome((start, better), 1, np.ones(1), "most"), 8, 0.005, True)
    assert told.code == "W290"
    assert "displacement rises by 31% and the greatest von Mises' stress rises by 65%" in told.message
    assert "falls by 6.6%" in told.message
    for fine in (
        replace(better, compliance=6.5, max_displacement=0.06),
        replace(better, max_displacement=0.09, max_von_mises=6),
        replace(better, under="displacements", compliance=10.7),
    ):
        steps = (replace(start, under=fine.under), fine)
        assert not doubts(what, loop.Outcome(steps, 1, np.ones(1), "most"), 8, 0.005, True)


def test_a_loop_that_is_stopped_leaves_the_best_so_far(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file, folder = tmp_path / "bar.pore", tmp_path / "loop"
    file.write_text(TEXT.replace("size=3mm", "size=5mm"))
    whole = Real.solve

    def solve(self: Real, density: Any, state: Any) -> Any:
        if np.ptp(density) > 0:
            raise KeyboardInterrupt
        return whole(self, density, state)

    monkeypatch.setattr(Real, "solve", solve)
    monkeypatch.setattr(optimizing, "A_WHILE", 0.0)
    assert main(["optimize", str(file), "--iterate", "part", "--limits", "0.3..0.7", "-o", str(folder)]) == 130
    err = capsys.readouterr().err
    assert f"stopped after step 0: {folder} has the best so far; --resume goes on" in err
    said = r"some [\d,]+ elements of 5 mm, [\d,]+ unknowns, to be solved 16 times at most: about \d+ s"
    assert re.search(said, err.split("step 0:")[0])
    assert "not ended yet" in (folder / "history.md").read_text()
    with np.load(folder / "t.npz") as file_of_best, np.load(folder / "step-000.npz") as first:
        assert np.array_equal(file_of_best["t"], first["t"])
        assert set(file_of_best.files) == {"t", "density", "origin", "spacing"}
        assert file_of_best["density"] == pytest.approx(0.5, abs=0.005)


def test_a_param_is_not_called_as_what_is_on_record(tmp_path: Path) -> None:
    program = porelang.compile(
        TEXT.replace("param t:", "param following:").replace("- t &", "- following &").replace("* t", "* other")
    )
    with pytest.raises(PoreError, match=r"E193.*called `following`"):
        program.iterate("part", folder=tmp_path / "a")
    assert not (tmp_path / "a").exists()


@pytest.mark.parametrize(
    ("more", "code", "word"),
    [
        ({"damping": "2"}, "E108", "share"),
        ({"damping": 2}, "E192", "damping"),
        ({"limits": 0.5}, "E108", "pair"),
        ({"limits": ("a", 1)}, "E108", "pair"),
        ({"porosity": "much"}, "E108", "share"),
        ({"porosity": 0.97}, "E192", r"limits=.0\.01\.\.0\.52"),
        ({"porosity": [1]}, "E108", "number"),
        ({"until": -1}, "E192", "less than -1"),
        ({"until": float("nan")}, "E192", "less than nan"),
        ({"most": -1}, "E192", "-1 steps"),
        ({"most": 1.5}, "E108", "whole"),
        ({"most": "x"}, "E108", "count"),
        ({"folder": 123}, "E108", "folder"),
        ({"rule": 3}, "E193", "no rule"),
        ({"rule": Optimum}, "E193", "no rule"),
        ({"rule": "energi"}, "E193", "did you mean `energy`"),
        ({"study": "zz"}, "E100", "`s`, `solid`"),
        ({"cell": "1m"}, "E193", "larger than the part"),
        ({"resume": True}, "E108", "no folder"),
        ({"resume": True, "force": True, "folder": "x"}, "E108", "exclude"),
    ],
)
def test_what_python_cannot_ask(more: dict[str, Any], code: str, word: str) -> None:
    with pytest.raises(PoreError, match=rf"(?s){code}.*{word}"):
        porelang.compile(TEXT).iterate("part", **more)


@pytest.mark.slow
def test_the_loop_of_a_program_stiffens_its_part(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """From the command line, interrupted by its limit and gone on with, replayed by what it says."""
    file, folder = tmp_path / "bar.pore", tmp_path / "loop"
    file.write_text(TEXT)
    words = ["optimize", str(file), "--iterate", "part", "--limits", "0.3..0.7", "-o", str(folder), "--json", "-q"]
    assert main([*words, "--until", "change<0.1%", "--max", "1"]) == 0
    first = json.loads(capsys.readouterr().out)
    assert main([*words, "--max", "2", "--until", "change<0.1%", "--resume"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["steps"][:2] == first["steps"]
    assert (found["adapts"], found["study"], found["cell"]) == ("t", "s", pytest.approx(20))
    assert found["gain"] < 0.9  # homogenised cantilevers gain twice as much; this one has three cells
    assert all(step["porosity"] == pytest.approx(found["steps"][0]["porosity"], abs=1e-3) for step in found["steps"])
    assert {"t.npz", "history.md", "history.png", "loop.jsonl", "step-002.npz"} <= {p.name for p in folder.iterdir()}

    best = found["steps"][found["best"]]
    solved = porelang.compile(path=str(file)).bind(t=f"{folder / 't.npz'}:t").study("s")
    assert solved.numbers["compliance"].value == pytest.approx(best["compliance"], rel=1e-6)
    assert solved.numbers["volume"].value / 24000 == pytest.approx(1 - best["porosity"], abs=0.03)
    replayed = porelang.compile(path=str(file)).bind(t=f"{folder / 'step-001.npz'}:t").study("s")
    assert replayed.numbers["compliance"].value == pytest.approx(found["steps"][1]["compliance"], rel=1e-6)

    rho = porelang.compile(f'let r = load("{folder / "t.npz"}", "density")\nout rho = r').design().field("rho")
    middles = np.stack(np.meshgrid(np.arange(-25, 30, 10), [-5, 5], [-5, 5], indexing="ij"), -1).reshape(-1, 3)
    assert np.asarray(rho(middles.astype(float))).mean() == pytest.approx(0.5, abs=0.02)

    assert main([*words, "--rule", "von_mises", "--resume"]) == 1
    assert "E195" in capsys.readouterr().err


def test_files_of_others_are_not_written_over(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, folder = tmp_path / "bar.pore", tmp_path / "mine"
    file.write_text(TEXT)
    folder.mkdir()
    words = ["optimize", str(file), "--iterate", "part", "--max", "1", "-o", str(folder)]
    for name in ("t.npz", "step-000.npz", "history.md"):
        (folder / name).write_text("mine")
        assert main(words) == 1
        told = capsys.readouterr().err
        assert f"no record of a loop, and files that it would write over: {name}" in told
        assert "--force" in told
        assert (folder / name).read_text() == "mine"
        (folder / name).unlink()
    (folder / "notes.txt").write_text("mine")
    (folder / "state-001.npz").write_text("mine")
    with pytest.raises(PoreError, match=r"E195.*state-001\.npz"):
        record.Book.open(folder, {}, resume=False)
    record.Book.open(folder, {}, resume=False, anew=True)


def test_words_that_are_no_ends(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "bar.pore"
    file.write_text(TEXT)
    for words in (["--until", "change<x"], ["--limits", "0.8..0.2"], ["--porosity", "150%"], ["--rule", "luck"]):
        assert main(["optimize", str(file), *words]) == 2
    assert "error" in capsys.readouterr().err
    assert main(["optimize", str(file), "--porosity", "90%", "-o", str(tmp_path / "x")]) == 1
    assert "E192" in capsys.readouterr().err
    assert not (tmp_path / "x").exists()
