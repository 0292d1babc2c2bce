"""What a task tells of what it found: said by the commands that read it, at its place, and kept with the result."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

import porelang
from porelang import store
from porelang.cli import main
from porelang.data import SampledField
from porelang.ir import Node
from porelang.tasks import telling
from porelang.tasks.run import RUN
from porelang.tasks.telling import Doubt, Told

PART = """let ball = sphere(5)
let wave = sample(sin(x), 1mm, ball)
out part = ball + 0.1 * wave
out plain = ball
"""
DOUBT = Doubt("W229", "half of it is guessed", "asked for here", "take finer samples")
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def computed(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """`sample` tells how many nodes it has, and doubts itself; the list grows with each that is computed."""
    store.forget()
    found: list[int] = []
    bake = RUN["sample"]

    def counted(asked: porelang.formula.Formula) -> SampledField:
        made = bake(asked)
        assert isinstance(made, SampledField)
        found.append(made.values.size)
        return replace(made, facts=(float(made.values.size),))

    def tells(asked: Node, made: store.Result) -> Told:
        assert isinstance(made, SampledField)
        return Told(f"{made.facts[0]:g} nodes", (DOUBT,))

    monkeypatch.setitem(RUN, "sample", counted)  # type: ignore[arg-type]  # a mapping for readers
    monkeypatch.setitem(telling.TELL, "sample", tells)  # type: ignore[arg-type]
    yield found
    store.forget()


@pytest.fixture
def run(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    monkeypatch.setenv("PORELANG_CACHE", str(tmp_path / "cache"))
    (tmp_path / "a.pore").write_text(PART)
    monkeypatch.chdir(tmp_path)

    def command(*words: str) -> tuple[int, str, str]:
        status = main([words[0], "a.pore", *words[1:]])
        out, err = capsys.readouterr()
        return status, out, err

    return command


def test_a_check_computes_nothing_unless_it_measures(computed: list[int], run: Run) -> None:
    status, _, err = run("check")
    assert status == 0
    assert not computed
    assert "nodes" not in err
    assert "no warnings" in err
    status, _, err = run("check", "--measure")
    assert status == 0
    assert computed == [13**3]
    assert "note: a.pore:2:12: sample: 2197 nodes\n" in err
    assert "warning[W229]: half of it is guessed\n --> a.pore:2:12" in err
    assert "= hint: take finer samples" in err
    assert "no errors, 1 warning" in err


@pytest.mark.parametrize(
    "words",
    [
        ("mesh", "-o", "a.stl", "--voxel", "1mm"),
        ("measure", "--voxel", "1mm"),
        ("slices", "-o", "layers", "--step", "0.5mm"),
    ],
)
def test_commands_that_read_it_tell_it(computed: list[int], run: Run, words: tuple[str, ...]) -> None:
    status, out, err = run(*words, "--out", "part", "--backend", "numpy")
    assert status == 0
    assert "note: a.pore:2:12: sample: 2197 nodes\n" in err
    assert "warning[W229]" in err
    status, out, err = run(*words, "--out", "part", "--backend", "numpy", "--json", "-q")
    found = json.loads(out)
    assert status == 0
    assert not err
    assert [d["code"] for d in found["warnings"]] == ["W229"]
    (note,) = found["notes"]
    assert (note["severity"], note["message"], note["line"], note["column"]) == ("note", "sample: 2197 nodes", 2, 12)
    assert len(computed) == 1  # what is kept tells the same
    _, _, err = run(*words, "--out", "plain", "--backend", "numpy")
    assert "nodes" not in err
    assert "W229" not in err


def test_what_lies_on_disk_tells_it_too(computed: list[int], run: Run) -> None:
    run("check", "--measure")
    store.forget()
    status, out, _ = run("check", "--measure", "--json", "-q")
    assert status == 0
    assert len(computed) == 1
    assert [(d["severity"], d["code"]) for d in json.loads(out)] == [("note", ""), ("warning", "W229")]


def test_pictures_tell_it(computed: list[int], run: Run, gpu: object) -> None:
    words = ("render", "-o", "a.png", "--size", "80x60")
    status, _, err = run(*words, "--out", "part")
    assert status == 0
    assert "note: a.pore:2:12: sample: 2197 nodes\n" in err
    assert "warning[W229]" in err
    status, out, _ = run(*words, "--out", "plain", "--field", "wave", "--json")
    assert [d["message"] for d in json.loads(out)["notes"]] == ["sample: 2197 nodes"]


def test_python_has_notes_and_warnings(computed: list[int]) -> None:
    design = porelang.compile(PART).design()
    with pytest.warns(porelang.PoreWarning, match="half of it is guessed"):
        (note,) = design.notes("part")
    assert str(note) == "note: <text>:2:12: sample: 2197 nodes"
    assert repr(note).startswith("<note at <text>:2:12: sample: 2197 nodes")
    with pytest.warns(porelang.PoreWarning, match="half of it is guessed"):
        assert [d["message"] for d in design.measure("part", voxel=1)["notes"]] == ["sample: 2197 nodes"]
    with pytest.warns(porelang.PoreWarning) as told:
        design.mesh("part", voxel=1)
    assert [w.message.diagnostic.code for w in told] == ["W229"]  # type: ignore[union-attr]  # and no note
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert design.notes("plain") == []
