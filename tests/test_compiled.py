"""Compiled loops: what they give is kept on disk, and who waits for them is told once."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

CODE = """
import sys
sys.path.insert(0, {folder!r})
from porelang.progress import on_compiling
on_compiling(lambda kept: print("compiling" if kept else "compiling, not kept"))
import loops
print(loops.total(loops.np.arange(4.0)), loops.total(loops.np.arange(4)))
"""
LOOPS = """
import numpy as np
from porelang.compiled import compiled

@compiled
def total(values):
    out = 0.0
    for value in values:
        out += value / (value + 1.0)
    return out
"""


@pytest.fixture
def loops(tmp_path: Path) -> Path:
    (tmp_path / "loops.py").write_text(LOOPS)
    return tmp_path


def run(folder: Path) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-c", CODE.format(folder=str(folder))], capture_output=True, text=True, check=True
    )
    return done.stdout.split()


@pytest.mark.slow
def test_only_the_first_run_compiles_and_says_so_once(loops: Path) -> None:
    value = str(1 / 2 + 2 / 3 + 3 / 4)
    assert run(loops) == ["compiling", value, value]
    assert run(loops) == [value, value]


@pytest.mark.slow
def test_a_change_of_the_text_is_compiled_anew(loops: Path) -> None:
    run(loops)
    (loops / "loops.py").write_text(LOOPS.replace("value / (value + 1.0)", "2 * value"))
    assert run(loops) == ["compiling", "12.0", "12.0"]


def test_where_nothing_can_be_kept_it_is_compiled_again(loops: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Numba refuses to cache where no folder can be written; the function must work all the same."""
    from numba.core import caching

    from porelang.compiled import compiled

    monkeypatch.setattr(caching.CacheImpl, "_locator_classes", [])

    def double(value: float) -> float:
        return 2 * value

    assert compiled(double)(2.0) == 4.0
