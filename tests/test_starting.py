"""`pore new`, `pore examples` and `pore completion`: how one begins."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import porelang
from porelang.cli import main
from porelang.cli.completing import offered
from porelang.cli.starting import shown
from porelang.source import Source
from porelang.syntax.format import formatted

ROOT = Path(__file__).parent.parent


def test_a_new_program_is_well_and_speaks_of_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", "knee"]) == 0
    text = Path("knee.pore").read_text(encoding="utf-8")
    assert "bracket" not in text
    assert "pore mesh knee.pore -o knee.stl" in text
    assert formatted(Source("knee.pore", text)) == text
    program = porelang.compile(path="knee.pore")
    assert not program.warnings
    assert set(program.params) == {"w", "t", "more"}


@pytest.mark.parametrize("argv", [["new", "taken.pore"], ["new", "taken"], ["examples", "twist", "taken"]])
def test_what_is_there_stays(
    argv: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    if argv[0] == "examples":
        argv = ["examples", "twist", "blend"]
        Path("blend.pore").write_text("mine")
    Path("taken.pore").write_text("mine")
    assert main(argv) == 2
    assert "is there already" in capsys.readouterr().err
    assert {path.read_text() for path in tmp_path.iterdir()} == {"mine"}  # nor is half of it copied


def test_a_program_ends_in_pore(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["new", "part.stl"]) == 2
    assert "`part.pore`" in capsys.readouterr().err
    for name in (".", "", "..", "parts/"):
        assert main(["new", name]) == 2
        assert "is no name of a program" in capsys.readouterr().err


def test_all_examples_are_listed_with_what_they_are_about(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["examples"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == len([*(ROOT / "examples").rglob("*.pore")])
    for line, name in zip(lines, shown(), strict=True):
        listed, about = line[:24].strip(), line[24:]
        assert listed == name
        assert len(about) > 15


@pytest.mark.parametrize("name", ["bending", "frame", "grip", "hole", "fig07c_frames", "fig10b_thickness"])
def test_an_example_works_where_it_is_copied(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["examples", name]) == 0
    assert len([*tmp_path.iterdir()]) == 2  # with the file that it reads or uses
    assert porelang.compile(path=f"{name}.pore").outputs


def test_an_unknown_example_is_told_with_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["examples", "twits"]) == 2
    assert "did you mean `twist`?" in capsys.readouterr().err


def test_what_a_word_may_become(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("heat_sink.pore").write_bytes((ROOT / "examples" / "heat_sink.pore").read_bytes())
    Path("broken.pore").write_text("let = 3")
    (tmp_path / "parts").mkdir()
    assert offered(["me"]) == ["mesh", "measure"]
    assert offered(["mesh", ""]) == ["broken.pore", "heat_sink.pore", "parts/"]
    assert offered(["mesh", "heat_sink.pore", "--vo"]) == ["--voxel"]
    assert offered(["mesh", "heat_sink.pore", "--set", ""]) == ["n=", "pitch=", "d=", "h="]
    assert offered(["mesh", "heat_sink.pore", "--preset", "s"]) == ["still air"]
    assert offered(["mesh", "heat_sink.pore", "--out", ""]) == ["part"]
    assert offered(["mesh", "broken.pore", "--set", ""]) == []
    assert offered(["mesh", "heat_sink.pore", "--backend", "n"]) == ["numpy"]
    assert offered(["mesh", "heat_sink.pore", "-o", ""]) == []  # any file: the shell knows them
    assert offered(["watch", "heat_sink.pore", "--", "mesh", "--sha"]) == ["--sharp"]
    assert offered(["explain", "E19"])[0] == "E190"
    assert offered(["examples", "twi"]) == ["twist"]
    assert offered(["nonsense", "x"]) == []


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
def test_bash_completes(tmp_path: Path) -> None:
    (tmp_path / "heat_sink.pore").write_bytes((ROOT / "examples" / "heat_sink.pore").read_bytes())
    pore = tmp_path / "pore"
    pore.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m porelang "$@"\n')
    pore.chmod(0o755)
    script = """
        eval "$(pore completion bash)"
        complete -p pore
        COMP_WORDS=(pore render heat_sink.pore --preset st) COMP_CWORD=4
        _pore 2>/dev/null  # `compopt` is for real completions
        printf '%s\\n' "${COMPREPLY[@]}"
    """
    env = os.environ | {"PATH": f"{tmp_path}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}
    got = subprocess.run(["bash", "-c", script], cwd=tmp_path, env=env, capture_output=True, text=True, check=True)
    assert got.stdout.splitlines() == ["complete -o default -F _pore pore", "still\\ air"]


def test_scripts_are_for_shells_that_are_known(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", "powershell"]) == 2
    assert "bash, zsh, fish" in capsys.readouterr().err
