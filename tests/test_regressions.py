"""What once went wrong does so no more; and what `make fuzz` would write does go wrong here where it did there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from regression_files import regressions, replay

from porelang.conformance.backend import F64, NUMPY, Backend


@pytest.mark.parametrize("path", regressions(), ids=lambda path: path.stem)
def test_what_once_went_wrong_is_right(path: Path, backend: Backend) -> None:
    assert replay(path, backend) == []


def test_a_failing_graph_is_written_and_fails_again(tmp_path: Path) -> None:
    """A backend whose results are off by a thousandth where x > 3: what is written says so by itself."""
    import fuzz

    def wrong(formula, points, ranges):  # type: ignore[no-untyped-def]
        got = NUMPY[0].evaluate(formula, points, ranges)
        return got if got.dtype == bool else got + 1e-3 * (points[:, 0] > 3)

    broken = replace(NUMPY[0], name="broken", evaluate=wrong)
    assert broken.precision is F64
    (path, *_) = fuzz.fuzz_graphs([broken], 3, 5, tmp_path)
    assert replay(path, broken) != []
    assert replay(path, NUMPY[0]) == []
    assert "seed 5" in path.read_text()


def test_a_text_that_ends_the_compiler_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import fuzz
    import regression_files as kept

    def broken(source: object) -> object:
        raise RecursionError

    monkeypatch.setattr(kept, "try_compile", broken)
    (path, *_) = fuzz.fuzz_texts(2, 5, tmp_path)
    monkeypatch.undo()
    assert "RecursionError" in path.read_text()
    assert replay(path, NUMPY[0]) == []


def test_what_is_sound_is_not_written(tmp_path: Path) -> None:
    import fuzz

    assert fuzz.fuzz_graphs(NUMPY, 10, 7, tmp_path) == []
    assert fuzz.fuzz_programs(10, 7, tmp_path) == []
    assert fuzz.fuzz_texts(10, 7, tmp_path) == []
    assert list(tmp_path.iterdir()) == []
