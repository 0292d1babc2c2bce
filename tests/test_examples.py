"""Every example compiles without a word, and every output of it is the same sound surface on both backends."""

from __future__ import annotations

import math
import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import porelang
from porelang.ir import order
from porelang.mesh.part import grid_of, surface_of

ROOT = Path(__file__).parent.parent
EXAMPLES = {path.stem: porelang.compile(path=path) for path in sorted((ROOT / "examples").glob("*.pore"))}
OUTPUTS = [(name, output) for name, program in EXAMPLES.items() for output in program.outputs]


def test_examples_show_the_ten_modifications() -> None:
    used = {call.name for program in EXAMPLES.values() for call in program.elaborated.calls}
    assert used >= {"gyroid", "rotate", "thicken", "shell", "polar", "spherical", "align", "twist", "morph", "blend"}
    assert any(info.choices for program in EXAMPLES.values() for info in program.params.values())


@pytest.mark.parametrize("name", EXAMPLES)
def test_example_is_explained_and_has_params(name: str) -> None:
    program = EXAMPLES[name]
    assert program.warnings == ()
    assert program.source.text.startswith("# ")
    assert program.params
    assert all(info.doc for info in program.params.values())
    assert "part" in program.outputs


@pytest.mark.parametrize("name", EXAMPLES)
def test_every_param_of_an_example_matters(name: str) -> None:
    program = EXAMPLES[name]
    read = {str(n.value) for n in order(program.graph.roots) if n.op == "param"}
    assert read | set(program.structure) == set(program.params)


@cache
def exact_volume(name: str, output: str) -> float:
    design = EXAMPLES[name].design()
    return surface_of(design, output, grid_of(design, output, resolution=32), "numpy", "f64").volume


@pytest.mark.parametrize(("name", "output"), OUTPUTS)
def test_output_is_one_sound_surface_on_both_backends(name: str, output: str, engine: Any) -> None:
    program = EXAMPLES[name]
    design = program.design()
    mesh = surface_of(design, output, grid_of(design, output, resolution=32), engine, "f32")
    assert mesh.check() == []
    assert mesh.volume == pytest.approx(exact_volume(name, output), rel=1e-4)
    box = design.bounds(output).volume
    assert 0.05 * box < mesh.volume < 0.9 * box


@pytest.mark.parametrize(("name", "output"), OUTPUTS)
def test_points_have_the_same_values_on_both_backends(name: str, output: str, engine: Any) -> None:
    program = EXAMPLES[name]
    points = np.random.default_rng(5).uniform(-40, 40, (2000, 3)).astype(np.float32)
    exact = program.field(output)(points)
    values = program.field(output, backend=engine, dtype="f32")(points)
    assert np.isfinite(values).all()
    # a place on a seam of the coordinates may fall on either side of it
    assert np.quantile(np.abs(values - exact) / (1 + np.abs(exact)), 0.999) < 1e-3


def test_specimen_is_half_solid() -> None:
    """The paper's measure: a gyroid shell of t = 1.53 has the porosity 0.5, whatever the unit cell."""
    program = EXAMPLES["specimen"]
    random = np.random.default_rng(7)
    points = random.uniform(-1, 1, (400_000, 3)) * [75, 75, 150]
    points = points[np.hypot(points[:, 0], points[:, 1]) < 75]
    for w in (20, 30, 45):
        porosity = np.mean(program.field("part", w=w)(points) > 0)
        assert porosity == pytest.approx(0.5, abs=0.01)


def test_specimen_has_the_paper_s_envelope() -> None:
    box = EXAMPLES["specimen"].bounds()
    assert box.size == pytest.approx((150, 150, 300), rel=1e-3)
    assert math.pi / 4 * box.volume == pytest.approx(5.30e6, rel=2e-3)


def test_the_program_that_opens_the_reference_is_an_example() -> None:
    text = (ROOT / "docs" / "language.md").read_text(encoding="utf-8")
    first = re.search(r"```pore\n(.*?)```", text, re.DOTALL)
    assert first is not None
    assert first[1] == (ROOT / "examples" / "heat.pore").read_text(encoding="utf-8")
