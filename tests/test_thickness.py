"""The thinnest walls of solids whose thickness is known, and what is said where a part has thinner ones than it may."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import porelang
from porelang.cli import main


@pytest.mark.parametrize(
    ("text", "thickness"),
    [
        ("shell(sphere(10), 1)", 1.0),
        ("box([10, 10, 0.5]) | box([3, 3, 9])", 0.5),
        ("rotate(box([10, 10, 0.5]), [1, 2, 3], 0.7)", 0.5),
        ("cylinder(8, 10) \\ cylinder(7.7, 20)", 0.3),
        ("translate(cylinder(0.4, 20), [3, 0, 0]) | box([2, 2, 2])", 0.8),  # a pin is as thick as its diameter
        ("metric(gyroid(10mm)) |> shell(0.8mm) & cube(20)", 0.8),
        ("sphere(4)", 8.0),
    ],
)
def test_walls_are_as_thin_as_they_are(text: str, thickness: float) -> None:
    program = porelang.compile(f"let t = min_wall({text})\nout part = sphere(bare(t))")
    (found,) = program.design().own_numbers(program.named("t")).values()  # type: ignore[arg-type]  # it is there
    assert found.value == pytest.approx(thickness, rel=2e-3)
    assert abs(found.value - thickness) <= max(found.error, 1e-3 * thickness)


def test_walls_that_grow_are_known_as_well_as_it_says() -> None:
    """A wedge of walls from 0.5 to 1.5 mm: what counts as the thinnest lies within its error of the thin end."""
    text = "box([30, 10, 20]) & abs(z) - (0.5 + (x + 15) / 30) / 2"
    program = porelang.compile(f"let t = min_wall({text})\nout part = sphere(bare(t))")
    (found,) = program.design().own_numbers(program.named("t")).values()  # type: ignore[arg-type]  # it is there
    assert found.value + 0.01 >= 0.5
    assert found.value - found.error <= 0.51
    assert found.error < 0.2


def test_a_check_fails_with_the_place(tmp_path: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = 'let part = shell(sphere(10), {})\ncheck min_wall(part) >= 0.4mm, "must print"\nout whole = part\n'
    Path("thin.pore").write_text(text.format(0.3))
    assert main(["mesh", "thin.pore", "-o", "thin.stl"]) == 1
    said = capsys.readouterr().err
    assert "error[E068]: must print" in said
    assert "min_wall(part) is 0.3 mm at (" in said
    at = np.array([float(v) for v in said.partition("mm at (")[2].partition(")")[0].split(",")])
    assert np.sqrt((at**2).sum()) == pytest.approx(10, abs=0.05)  # within the shell
    assert not Path("thin.stl").exists()
    Path("thick.pore").write_text(text.format(0.5))
    assert main(["check", "thick.pore", "--measure"]) == 0


def test_a_report_has_it_and_a_cone_has_none(tmp_path: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.pore").write_text("shell(sphere(10), 1)\n")
    Path("b.pore").write_text("cone(10, 0, 20)\n")
    assert main(["measure", "a.pore", "--voxel", "1mm", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["min_wall"] == pytest.approx(1, abs=1e-5)
    assert found["error"]["min_wall"] < 1e-4
    assert np.sqrt((np.array(found["min_wall_at"]) ** 2).sum()) == pytest.approx(10, abs=0.01)
    assert main(["measure", "b.pore", "--voxel", "1mm", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["min_wall"] is None
    with pytest.raises(porelang.PoreError, match="E139"):
        porelang.compile("let w = min_wall(cone(10, 0, 20))\nsphere(bare(w))").field("part")
