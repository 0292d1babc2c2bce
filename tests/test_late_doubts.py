"""What is doubtful of a lattice that reads what tasks find is told when that is found, and not before."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import porelang
from porelang.cli import main
from porelang.diagnostics import Diagnostic

#: About two holes directions point outward from each: between them, and past half a turn, cells fold.
HOLES = (
    "let hole = cylinder(4, 20)\n"
    "let body = box([50, 25, 10]) \\ translate(hole, [12, 0, 0]) \\ translate(hole, [-12, 0, 0])\n"
    "let v = grad(blur(hypot(x - 12, y) | hypot(x + 12, y), 3mm, body, smooth=true))\n"
)
#: The stress in a clamped beam: its first direction turns where bending changes its sign.
BEAM = "let body = translate(box([60, 20, 20]), [30, 0, 0])\n"
ALIGNED = "align(gyroid(10), principal(T, 1).direction, symmetry=2, about=[30, 2.5, 0]) |> shell(0.8) & body"


def later(text: str, name: str | None = None) -> list[Diagnostic]:
    """What a design tells of an output besides what was said when it was compiled."""
    program = porelang.compile(text)
    return [d for d in program.design().told(*program.field_roots(name)) if d.severity == "warning"]


def test_cells_that_follow_a_blurred_distance_are_looked_at(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.pore"
    file.write_text(HOLES + "align(gyroid(8), v, symmetry=2, about=[0, 2, 0]) |> shell(0.8) & body")
    assert main(["check", str(file)]) == 0
    assert "W239" not in capsys.readouterr().err  # a blur takes too long for that
    assert main(["check", str(file), "--measure"]) == 0
    assert capsys.readouterr().err.count("warning[W239]") == 1
    with pytest.warns(porelang.PoreWarning, match="W239"):
        porelang.compile(path=file).notes()


def test_a_tensor_from_a_file_stretches_cells_as_its_formula_does(tmp_path: Path) -> None:
    x, z = np.linspace(0, 60, 61), np.linspace(-10, 10, 21)
    stress = np.zeros((61, 21, 21, 6))  # xx, yy, zz, xy, yz, xz
    stress[..., 0] = -z * (60 - x[:, None, None]) / 10
    stress[..., 5] = 100 - z**2
    np.savez(tmp_path / "s.npz", origin=[0.0, -10.0, -10.0], spacing=1.0, stress=stress)
    formula = "let T = tensor(xx=-z * (60 - x) / 10, yy=0 * x, zz=0 * x, xy=0 * x, yz=0 * x, xz=100 - z^2)\n"
    (said,) = porelang.compile(BEAM + formula + ALIGNED).warnings
    (found,) = later(f'{BEAM}let T = load_tensor("{tmp_path / "s.npz"}", "stress")\n{ALIGNED}')
    shares = [int(re.findall(r"in (\d+) % of the part", d.message)[0]) for d in (said, found)]
    assert found.code == said.code == "W239"
    assert shares[1] == pytest.approx(shares[0], abs=3)


@pytest.mark.parametrize(
    ("lattice", "code"),
    [
        ("align(gyroid(6), grad(sphere(10))) & part", "W239"),
        ("align(gyroid(6), [x, y - 10, 0], symmetry=2) & part", "W236"),
        ("polar(gyroid(6), turn=40) & part", "W218"),
        ("along(gyroid(6), arc(10mm, 0deg, 270deg)) & part", "W240"),
        ("gyroid(phase=if x > 0 then p / 6 else p / 7) & part", "W218"),
    ],
)
def test_lattices_are_looked_at_within_a_part_from_a_file(tmp_path: Path, lattice: str, code: str) -> None:
    """The lattice reads nothing, and the solid that it fills is known only when the file is read."""
    n = np.mgrid[-12:13, -12:13, -12:13]
    np.savez(tmp_path / "d.npz", origin=[-12.0] * 3, spacing=1.0, d=np.hypot(np.hypot(n[0], n[1]), n[2]) - 9.5)
    part = f'let part = load("{tmp_path / "d.npz"}", "d", unit=mm)\n'
    assert code in [d.code for d in later(part + lattice)]


def test_what_was_said_at_once_is_not_said_again() -> None:
    lattice, later_known = "align(gyroid(10), grad(sphere(20)))", "sphere(blur(20, 1mm, sphere(30)) @ [0, 0, 0])"
    (found,) = later(f"{lattice} & {later_known}")
    assert found.code == "W239"
    both = porelang.compile(f"let f = {lattice}\nout a = f & sphere(20)\nout b = f & {later_known}")
    assert [d.code for d in both.warnings] == ["W239"]
    assert [d.code for d in both.design().told(*both.field_roots("b")) if d.severity == "warning"] == []


POLAR = "polar(gyroid(phase=phase({w}, box([24, 90, 20]))), turn=48mm) |> shell(0.6) & {part}"
WHOLE, HALF = "cylinder(12, 20)", "cylinder(12, 20) & -x"


@pytest.mark.parametrize(
    ("w", "part", "torn"),
    [
        ("8mm + z / 20", WHOLE, True),
        ("7mm", WHOLE, True),
        ("8mm", WHOLE, False),
        ("[8mm + z / 20, 8mm, 8mm + z / 20]", WHOLE, False),  # what the hint proposes
        ("8mm + z / 20", HALF, False),  # it ends before the seam
    ],
)
def test_a_phase_that_does_not_close_leaves_a_seam(w: str, part: str, torn: bool) -> None:
    program = porelang.compile(POLAR.format(w=w, part=part))
    assert not program.warnings
    told = program.design().told(*program.field_roots())
    assert [d.code for d in told if d.severity == "warning"] == (["W218"] if torn else [])
    if part == HALF:
        return
    x, z = np.random.default_rng(1).uniform([-12, -10], [-1, 10], (4000, 2)).T  # of a nanometre on both sides
    one, other = (program.field()(np.stack([x, side * 1e-6 * x, z], -1)) < 0 for side in (1, -1))
    assert bool(np.mean(one != other) > 0.05) == torn


def test_a_seam_is_found_in_a_part_that_was_moved() -> None:
    moved = POLAR.format(w="8mm + z / 20", part=WHOLE)
    (d,) = later(f"translate({moved}, [50, 0, 0])")
    assert d.code == "W218"
    assert "`phase([w, turn / n, w], ...)`" in d.hint
