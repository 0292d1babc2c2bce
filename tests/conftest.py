"""The suite has a cache of its own, so that no number of an earlier run stands in for one that the code finds now.

Tests that need OpenGL ask for the fixture `gpu` (or `opened`, for a driver of a certain kind) and are skipped where
there is none. With PORELANG_TEST_GL=required, which `make test` sets on Linux, they fail there instead.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable

import pytest

from porelang.gpu import Gpu, GpuMissing, open_gpu, shared_gpu


def pytest_configure(config: pytest.Config) -> None:
    folder = tempfile.TemporaryDirectory(prefix="porelang-tests-")
    os.environ["PORELANG_CACHE"] = folder.name
    config.add_cleanup(folder.cleanup)


def _or_skip(start: Callable[[], Gpu], required: bool) -> Gpu:
    try:
        return start()
    except GpuMissing as missing:
        if required:
            pytest.fail(f"PORELANG_TEST_GL is required, and there is no OpenGL: {missing}", pytrace=False)
        pytest.skip(f"no OpenGL here: {missing.reason}")


@pytest.fixture(scope="session")
def gpu() -> Gpu:
    """The GPU that the process shares; no test may close it."""
    return _or_skip(shared_gpu, os.environ.get("PORELANG_TEST_GL") == "required")


@pytest.fixture(scope="session")
def opened() -> Callable[..., Gpu]:
    """`open_gpu`, but that it skips. OSMesa is never required: systems newer than 2025 do not have it."""

    def open_or_skip(kind: str = "auto") -> Gpu:
        required = os.environ.get("PORELANG_TEST_GL") == "required" and kind != "osmesa"
        return _or_skip(lambda: open_gpu(kind), required)  # type: ignore[arg-type]

    return open_or_skip
