"""What a function modifies is said in its documentation: read from the prelude and from a user's own defs."""

from __future__ import annotations

from pathlib import Path

import pytest

import porelang
from porelang.cli import main
from porelang.diagnostics import PoreError
from porelang.elaborate.prelude import prelude_files
from porelang.notation import modification, steps
from porelang.syntax import tree
from porelang.syntax.parse import parse


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("conventions.axolotl.gyroid(9)", ["(F)(C)(W)(F)"]),
        ("conventions.axolotl.blend(sphere(5), cube(5))", []),  # a smooth union, where `blend` is a transition
        ("def twist(f, w) = f * w\ntwist(sphere(5), z)", []),  # called as one of the prelude's, and not it
        ("(a => 2 * a)(sphere(5))", []),
        ("## Modifies: space by q, as a vector field\ndef f(g, q) = g @ q\nf(sphere(5), 2 * p)", ["(F)(V)(S)(F)"]),
        ("## Modifies: distance by d\ndef f(g, d) = g - d\nf(sphere(5), z / 9)", ["(F)(F)(D)(F)"]),
        ("## Modifies: distance by d\ndef f(g, d: field) = g - d\nf(sphere(5), z / 9)", ["(F_A)(F_B)(D)(F)"]),
        ("gyroid(phase=p / 20)", ["(F)(C)(W)(F)"]),  # which is the period 20
        ("gyroid(phase=p / (20 + z / 9))", ["(F)(F)(W)(F)"]),
        ("gyroid(phase=[x / 20, y / 20, z / 30])", ["(F)(V)(W)(F)"]),
        ("## Modifies: wavelength by w or q\ndef f(w or q = p / w) = q.x\nf(q=2 * p)", ["(F)(V)(W)(F)"]),
        ("## Modifies: ratio by r\ndef f(a, b, r = 0.5) = a * r + b * (1 - r)\nf(x, y)", ["(F_A, F_B)(C)(R)(F_R)"]),
        (
            "## Modifies: space by a\n## Example: f(x, 1)\ndef f(g, a) = g * a\nf(f(x, 1), y)",
            ["(F)(C)(S)(F)", "(F)(F)(S)(F)"],
        ),
    ],
)
def test_each_def_says_what_it_modifies(text: str, expected: list[str]) -> None:
    assert [step.notation for step in steps(porelang.compile(text))] == expected


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("colour by depth", "one of type, space, wavelength, distance, ratio"),
        ("distance", "`## Modifies: DIMENSION by PARAMETER`"),
        ("distance by depth, as a tensor", "does not read"),
        ("distance by dept", "did you mean `depth`"),
        ("distance by depth or height", "no parameter `height`"),
    ],
)
def test_a_line_that_does_not_read_is_told(line: str, says: str, tmp_path: Path) -> None:
    text = f"## Modifies: {line}\ndef f(g, depth) = g - depth\nf(sphere(5), 1)"
    program = porelang.compile(text)  # documentation is no part of a program: it compiles
    with pytest.raises(PoreError) as failed:
        steps(program)
    (found,) = failed.value.diagnostics
    assert found.code == "E116"
    assert says in f"{found.message} {found.hint}"
    assert found.span is not None
    assert found.span.text == "f"
    path = tmp_path / "part.pore"
    path.write_text(text)
    assert (main(["check", str(path), "-q"]), main(["notation", str(path)])) == (0, 1)


def test_what_the_prelude_modifies_reads() -> None:
    found = {
        f"{name} {d.name}": known.dimension
        for name, source in prelude_files()
        for d in parse(source)[0].statements
        if isinstance(d, tree.Def) and (known := modification(d)) is not None
    }
    assert sum(dimension == "W" for name, dimension in found.items() if name.startswith("tpms ")) == 23
    assert (found["space twist"], found["modify blend"]) == ("S", "R")
    assert len(found) == 58
