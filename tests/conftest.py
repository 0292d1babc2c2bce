"""The suite has a cache of its own, so that no number of an earlier run stands in for one that the code finds now.

Tests that need OpenGL ask for the fixture `gpu` (or `opened`, for a driver of a certain kind) and are skipped where
there is none. With PORELANG_TEST_GL=required, which `make test` sets on Linux, they fail there instead.
"""

from __future__ import annotations

import compileall
import os
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path

import pytest

from porelang import store
from porelang.conformance.backend import NUMPY, Backend, glsl
from porelang.conformance.sweep import Measurement, sweep
from porelang.gpu import Gpu, GpuMissing, open_gpu, shared_gpu
from porelang.resources import PACKAGE
from porelang.tasks.numbers import area, integrals


def pytest_configure(config: pytest.Config) -> None:
    if not hasattr(config, "workerinput"):  # workers share that of the process that started them
        folder = tempfile.TemporaryDirectory(prefix="porelang-tests-")
        os.environ["PORELANG_CACHE"] = folder.name
        config.add_cleanup(folder.cleanup)
        # Python is compiled once: for each `pore` that a test starts it would be a third of what that takes, and one on
        # a full disk leaves half of a compiled module behind (Python 3.11), which nothing can import
        compileall.compile_dir(PACKAGE, quiet=2)
    sys.dont_write_bytecode = False  # pytest takes ten seconds to rewrite the tests' own, and keeps them beside them
    # what a script starts in its background ignores Ctrl-C, and so would all that the tests start and interrupt
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="module")
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """A cache that nothing else has filled, for a module that asks what is computed."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("PORELANG_CACHE", str(tmp_path_factory.mktemp("kept")))
        store.forget()
        yield
    store.forget()


@pytest.fixture
def roughly(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """For tests of what is counted or told: volumes and areas, which take the time, to a few percent, kept nowhere."""
    for module, name, accuracy in ((integrals, "volume", 1e-2), (integrals, "porosity", 1e-2), (area, "area", 3e-2)):
        monkeypatch.setattr(module, name, partial(getattr(module, name), accuracy=accuracy))
    monkeypatch.setenv("PORELANG_CACHE", str(tmp_path / "kept"))
    store.forget()
    yield
    store.forget()


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


#: The backends by name, as the fixture `backend` is parametrised: `glsl` needs OpenGL.
NAMES = (*(b.name for b in NUMPY), "glsl")


@pytest.fixture(scope="session")
def named(request: pytest.FixtureRequest) -> Callable[[str], Backend]:
    """A backend by its name; for GLSL the test is skipped where there is no OpenGL."""

    def find(name: str) -> Backend:
        return {b.name: b for b in NUMPY}.get(name) or glsl(request.getfixturevalue("gpu"))

    return find


@pytest.fixture(params=NAMES)
def backend(request: pytest.FixtureRequest, named: Callable[[str], Backend]) -> Backend:
    """Each backend in turn."""
    return named(request.param)


@pytest.fixture(params=["numpy", "glsl"])
def engine(request: pytest.FixtureRequest) -> str:
    """What `backend=` takes, in turn."""
    if request.param == "glsl":
        request.getfixturevalue("gpu")
    return str(request.param)


@pytest.fixture(scope="session")
def swept(named: Callable[[str], Backend]) -> Callable[[str], list[Measurement]]:
    """What the whole sweep of a backend found: it takes seconds, so that all who look at it share one."""
    return cache(lambda name: sweep(named(name), seed=7))
