"""`pore watch`: every way of saving runs the command again, one run at a time; nothing is left running."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from porelang.cli import main
from porelang.cli.watching import command_line, settled
from porelang.diagnostics import PoreError
from porelang.stamps import changed, stamps

ROOT = Path(__file__).resolve().parent.parent
RUN = re.compile(r"^\d\d:\d\d:\d\d a\.pore: (well|exit status \d+), \d+\.\d s$", re.MULTILINE)
AGAIN = re.compile(r"^\d\d:\d\d:\d\d saved after \d+\.\d s: begun anew$", re.MULTILINE)
pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals")


class Watching:
    """`pore watch` at work in a folder, and what it has said so far."""

    def __init__(self, folder: Path, *words: str) -> None:
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "porelang", "watch", *words], cwd=folder, env=environment, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip
        self.text = ""
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.text += line

    def wait(self, met: Callable[[str], object]) -> str:
        """What was said once `met` holds of it; the wait is long, for machines are busy."""
        for _ in range(1200):
            if met(self.text):
                return self.text
            assert self.process.poll() is None, self.text
            time.sleep(0.05)
        raise AssertionError(self.text)

    def runs(self, count: int) -> list[str]:
        """How the first `count` runs ended."""
        self.wait(lambda text: len(RUN.findall(text)) >= count)
        return RUN.findall(self.text)[:count]

    def end(self, number: int = signal.SIGINT) -> int:
        self.process.send_signal(number)
        return self.process.wait(60)


@pytest.fixture
def watching(tmp_path: Path) -> Iterator[Callable[..., Watching]]:
    begun: list[Watching] = []

    def begin(*words: str) -> Watching:
        begun.append(Watching(tmp_path, *words))
        return begun[-1]

    yield begin
    for one in begun:
        if one.process.poll() is None:
            os.killpg(one.process.pid, signal.SIGKILL)
            one.process.wait()


def replace(path: Path, text: str) -> None:
    """As most editors save: a new file takes the old one's place."""
    draft = path.with_name(".draft")
    draft.write_text(text)
    os.replace(draft, path)


def moved_away(path: Path, text: str) -> None:
    """As others do: the old file becomes a backup first."""
    os.replace(path, path.with_name(path.name + "~"))
    time.sleep(0.15)
    path.write_text(text)


def in_place(path: Path, text: str) -> None:
    path.write_text(text)


def test_every_way_of_saving_and_a_broken_program(tmp_path: Path, watching: Callable[..., Watching]) -> None:
    path = tmp_path / "a.pore"
    path.write_text("sphere(4)\n")
    watch = watching("a.pore", "--", "mesh", "-o", "a.stl", "--resolution", "8")
    assert watch.runs(1) == ["well"]
    assert (tmp_path / "a.stl").exists()
    replace(path, "spere(4)\n")
    assert watch.runs(2)[1] == "exit status 1"
    assert "did you mean `sphere`" in watch.text
    for i, save in enumerate((replace, moved_away, in_place)):
        before = (tmp_path / "a.stl").stat().st_mtime_ns
        save(path, f"sphere({5 + i})\n")
        assert watch.runs(3 + i)[-1] == "well"
        assert (tmp_path / "a.stl").stat().st_mtime_ns > before
    assert watch.end() == 130
    assert "Traceback" not in watch.text
    assert sorted(os.listdir(tmp_path)) == ["a.pore", "a.pore~", "a.stl"]


def test_used_files_and_data_are_watched_also_those_that_come_later(
    tmp_path: Path, watching: Callable[..., Watching]
) -> None:
    path, used = tmp_path / "a.pore", tmp_path / "parts.pore"
    path.write_text('use "parts.pore" as parts\nparts.ball\n')
    watch = watching("a.pore")
    assert watch.runs(1) == ["exit status 1"]
    assert "parts.pore" in watch.text
    used.write_text("let ball = sphere(4)\n")
    assert watch.runs(2)[1] == "well"
    replace(used, "let ball = sphere(4) +\n")
    assert watch.runs(3)[2] == "exit status 1"
    assert watch.end(signal.SIGTERM) == 143


def test_a_save_while_a_run_is_under_way_ends_it(tmp_path: Path, watching: Callable[..., Watching]) -> None:
    path = tmp_path / "a.pore"
    path.write_text("gyroid(5) |> shell(0.8) & sphere(50)\n")
    watch = watching("a.pore", "slices", "-o", "layers", "--step", "0.05mm", "--voxel", "0.05mm", "-q")
    for _ in range(1200):  # until it is at work: its draft lies there
        if any(name.startswith(".pore-") for name in os.listdir(tmp_path)):
            break
        time.sleep(0.05)
    replace(path, "sphere(4)\n")
    watch.wait(AGAIN.search)
    assert watch.runs(1) == ["well"]
    assert watch.end() == 130
    assert sorted(os.listdir(tmp_path)) == ["a.pore", "layers"]


def test_ending_it_ends_the_run(tmp_path: Path, watching: Callable[..., Watching]) -> None:
    (tmp_path / "a.pore").write_text("gyroid(5) |> shell(0.8) & sphere(50)\n")
    watch = watching("a.pore", "slices", "-o", "layers", "--step", "0.05mm", "--voxel", "0.05mm", "-q")
    for _ in range(1200):
        if any(name.startswith(".pore-") for name in os.listdir(tmp_path)):
            break
        time.sleep(0.05)
    assert watch.end() == 130
    assert os.listdir(tmp_path) == ["a.pore"]
    with pytest.raises(ProcessLookupError):  # nobody of its session is left
        os.killpg(watch.process.pid, 0)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "needs FILE"),
        (["nowhere.pore"], "there is no file"),
        (["a.pore", "doctor"], "cannot carry out `doctor`"),
        (["a.pore", "watch"], "cannot carry out `watch`"),
        (["a.pore", "--", "mesh"], "needs --output"),
        (["a.pore", "mesh", "-o", "a.stl", "--voxel", "x"], "is no length"),
        (["--loud", "a.pore"], "no option `--loud`"),
        (["a.pore", "eval", "--points", "-"], "only once"),
    ],
)
def test_wrong_usage_is_told_at_once(
    words: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.pore").write_text("sphere(4)\n")
    assert main(["watch", *words]) == 2
    assert said in capsys.readouterr().err


def test_the_command_is_about_the_file() -> None:
    assert command_line("a.pore", []) == ["check", "a.pore"]
    assert command_line("a.pore", ["mesh", "-o", "a.stl"]) == ["mesh", "a.pore", "-o", "a.stl"]
    assert command_line("a.pore", ["mesh", "a.pore", "-o", "a.stl"]) == ["mesh", "a.pore", "-o", "a.stl"]
    with pytest.raises(PoreError, match="E108"):
        command_line("a.pore", ["explain"])


def test_what_is_watched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sub").mkdir()
    (tmp_path / "a.pore").write_text(
        'use "sub/b.pore" as b  # a comment\nload("s.npz", "von_mises")\nparam w = 3 "cell"\n'
    )
    (tmp_path / "sub" / "b.pore").write_text('use "../a.pore" as a\nuse "c.pore" as c\n')
    seen = stamps("a.pore", ["p.csv"])
    assert {os.path.relpath(p) for p in seen} == {"a.pore", "sub/b.pore", "sub/c.pore", "s.npz", "p.csv"}
    assert not changed(seen)
    (tmp_path / "s.npz").write_text("1")
    assert changed(seen)
    assert not changed(settled(lambda: stamps("a.pore"), str(tmp_path / "a.pore")))
    os.mkfifo(tmp_path / "sub" / "c.pore")  # never opened: that would wait for ever
    assert stamps("a.pore")[str(tmp_path / "sub" / "c.pore")] is None
