"""The loop of a program, in tetrahedra of its lattice: a short cantilever of a network, in coarse elements."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import porelang
from porelang.cli import main
from porelang.diagnostics import PoreError
from porelang.optimize.adapting import adapting

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


def test_words_that_are_no_ends(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "bar.pore"
    file.write_text(TEXT)
    for words in (["--until", "change<x"], ["--limits", "0.8..0.2"], ["--porosity", "150%"], ["--rule", "luck"]):
        assert main(["optimize", str(file), *words]) == 2
    assert "error" in capsys.readouterr().err
    assert main(["optimize", str(file), "--porosity", "90%", "-o", str(tmp_path / "x")]) == 1
    assert "E192" in capsys.readouterr().err
    assert not (tmp_path / "x").exists()
