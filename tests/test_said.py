"""What commands and Python say: of tetrahedra too coarse, of wishes that are none, when they are interrupted."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import porelang
from porelang.cli import main
from porelang.diagnostics import PoreError

ROOT = Path(__file__).resolve().parent.parent
SHEET = "metric(gyroid(10mm)) |> shell(0.75mm) & cube(8mm)\n"


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--size", "3mm"], ["E162", "walls are about 0.75 mm", "--size 0.37mm"]),
        (["--size", "1mm", "--bounds", "100,100,100,120,120,120"], ["E162", "the bounds are beside the part"]),
        (["--size", "abc"], ["E100", "`abc` is no length, as `3mm`"]),
        (["--size", "nan"], ["E100", "`nan` is no length, as `3mm`"]),
    ],
)
def test_tetrahedra_that_cannot_be_are_refused_for_their_reason(
    options: list[str], says: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "sheet.pore"
    file.write_text(SHEET, encoding="utf-8")
    assert main(["tet", str(file), "-o", str(tmp_path / "a.vtu"), *options]) != 0
    told = capsys.readouterr().err
    assert all(part in told for part in says), told
    assert not (tmp_path / "a.vtu").exists()


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.slow
@pytest.mark.parametrize(("number", "word"), [(signal.SIGINT, "interrupted"), (signal.SIGTERM, "ended")])
def test_who_is_interrupted_says_so(number: signal.Signals, word: str, tmp_path: Path) -> None:
    """A program from standard input that never ends: the command waits for it."""
    running = subprocess.Popen(
        [sys.executable, "-m", "porelang", "check", "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    time.sleep(2)
    running.send_signal(number)
    out, err = running.communicate(timeout=60)
    assert running.returncode == 128 + number
    assert (out, err) == ("", f"{word}: nothing is left half-written\n")


def test_python_takes_what_its_hints_propose() -> None:
    lattice = porelang.compile("gyroid(10)")
    with pytest.warns(porelang.PoreWarning, match="resolution=16"):
        one = lattice.homogenize(resolution=8, cell="10")
    with pytest.warns(porelang.PoreWarning):
        other = lattice.homogenize(resolution="8", cell=["1cm", 10, "10mm"])
    assert one.numbers["E.100"] == other.numbers["E.100"]
    for wrong in ({"nu": None}, {"cell": [1, 2]}):
        with pytest.raises(PoreError):
            lattice.homogenize(resolution=16, **wrong)


def test_a_study_is_a_line_in_python() -> None:
    loads = "[force(z > 4mm, [0, 0, -9N]), force(z > 4mm, [0, 9N, 0])]"
    text = f"let s = study(cube(9mm), fix=z < -4mm, load={loads}, E=1GPa, nu=0.3, size=3mm)\nout part = cube(9mm)"
    found = porelang.compile(text).study()
    assert re.fullmatch(r"<study s of [\d,]+ elements: max_von_mises .* \+- .*, max_displacement .*>", repr(found))
    assert {"stiffness", "mass"}.isdisjoint(found.numbers)
