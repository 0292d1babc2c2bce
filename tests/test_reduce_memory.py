"""Numbers found from fields are kept: on disk by content, whole or not at all, and a search can be ended."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

import porelang
from porelang import cache
from porelang.data import Reduced
from porelang.tasks import store as memory

TEXT = "param r = 3 in 1..9\nx + bare(volume(sphere(r))) + porosity(gyroid(3), sphere(r))"


@pytest.fixture(autouse=True)
def _own_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PORELANG_CACHE", str(tmp_path / "kept"))
    memory.forget()


def kept(tmp_path: Path) -> list[Path]:
    return sorted((tmp_path / "kept").glob("number-*"))


def test_another_process_computes_nothing_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = porelang.compile(TEXT).reduced(r=4)
    assert len(kept(tmp_path)) == 2
    memory.forget()  # what a new process knows
    with monkeypatch.context() as m:
        m.setattr(porelang.tasks.numbers, "_compute", _never)
        assert porelang.compile(TEXT).reduced(r=4) == first  # to the last bit
        with pytest.raises(AssertionError):
            porelang.compile(TEXT).reduced(r=4.000001)
        with pytest.raises(AssertionError):
            porelang.compile(TEXT.replace("gyroid(3)", "gyroid(4)")).reduced(r=4.5)


@pytest.mark.slow
def test_guesses_of_a_solve_are_not_kept(tmp_path: Path) -> None:
    porelang.compile("x + solve(t => volume(sphere(t)), 100, 1..10)").settle()
    assert len(kept(tmp_path)) == 1


def test_another_version_of_the_code_computes_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    porelang.compile(TEXT).reduced()
    memory.forget()
    monkeypatch.setattr(memory, "_code", lambda: "other")
    monkeypatch.setattr(porelang.tasks.numbers, "_compute", lambda n, params: Reduced(1.0, 0.5))
    assert {r.value for r in porelang.compile(TEXT).reduced().values()} == {1.0}


@pytest.mark.parametrize(
    "damage",
    [
        lambda b: b[: len(b) // 2],
        lambda b: b"",
        lambda b: b"\xff\x00" * 40,
        lambda b: b.replace(b"0x1.", b"0x1.1", 1),  # a number all the same, but not the one that was found
        lambda b: b"nan nan nan",
    ],
)
def test_what_was_damaged_is_computed_again(damage: Callable[[bytes], bytes], tmp_path: Path) -> None:
    first = porelang.compile(TEXT).reduced()
    for path in kept(tmp_path):
        path.write_bytes(damage(path.read_bytes()))
    memory.forget()
    assert porelang.compile(TEXT).reduced() == first
    memory.forget()
    assert all(memory._read(path.read_bytes()) in first.values() for path in kept(tmp_path))  # and mended


def test_many_may_write_at_once(tmp_path: Path) -> None:
    contents = [memory._written(Reduced(float(i), 0.5)) for i in range(8)]
    seen: list[Reduced | None] = []

    def work(content: bytes) -> None:
        for _ in range(50):
            cache.put("number-1", content)
            seen.append(memory._read(cache.get("number-1") or b""))

    threads = [threading.Thread(target=work, args=(c,)) for c in contents]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    assert None not in seen
    assert [p.name for p in (tmp_path / "kept").iterdir()] == ["number-1"]


def test_only_the_newest_are_kept(tmp_path: Path) -> None:
    for i in range(20):
        cache.put(f"number-{i:02d}", b"x", most=5, prefix="number-")
        os.utime(tmp_path / "kept" / f"number-{i:02d}", (i, i))
    cache.put("other", b"x")
    cache.put("number-990", b"x", most=5, prefix="number-")
    assert [p.name for p in kept(tmp_path)] == [f"number-{i}" for i in (16, 17, 18, 19, 990)]
    assert (tmp_path / "kept" / "other").exists()


def test_an_interrupted_write_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        cache.put("number-1", b"x")
    assert not list((tmp_path / "kept").iterdir())


@pytest.mark.slow
def test_a_long_search_shows_itself_and_ctrl_c_ends_it(tmp_path: Path) -> None:
    path = tmp_path / "slow.pore"
    path.write_text(
        "let t = solve(t => area(gyroid(t) & cylinder(50, 100)), 300000, 6..20)\ngyroid(t) & cylinder(50, 100)\n"
    )
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "porelang", "mesh", str(path), "-o", str(tmp_path / "part.stl")]
    running = subprocess.Popen(command, stderr=theirs, stdout=subprocess.DEVNULL)
    os.close(theirs)
    shown = b""
    while b"finding numbers from fields" not in shown:
        shown += os.read(ours, 1000)
    running.send_signal(signal.SIGINT)
    assert running.wait(60) == 130
    os.close(ours)
    assert b"Traceback" not in shown
    assert not kept(tmp_path)
    assert {p.name for p in tmp_path.iterdir()} == {"slow.pore", "kept"}
    assert not list((tmp_path / "kept").glob(".*"))


def _never(*_: object) -> Reduced:
    raise AssertionError("computed again")
