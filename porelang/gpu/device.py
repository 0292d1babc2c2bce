"""The GPU for the rest of the program: arrays in, arrays out."""

from __future__ import annotations

import importlib.util
import os
import sys
import threading
import weakref
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.gpu.errors import GpuFailed, GpuMissing, install_command
from porelang.gpu.process import Child
from porelang.gpu.wire import Arena, Compute, Failed, GpuInfo, Kind, Render, offsets

Uniform = float | int | Sequence[float] | NDArray[Any]
ENVIRONMENT = "PORELANG_GL"  # none, egl or osmesa; for tests, and for machines whose EGL is broken
INPUTS = ("float32", "uint32", "int32")
TIMEOUT = 60.0


class Gpu:
    """A device that runs shaders, in a child process that is started again after a crash. Safe to share by threads."""

    def __init__(self, kind: str) -> None:
        self._kind, self._lock, self._compiled, self._closed = kind, threading.RLock(), 0, False
        self._child = self._start()

    @property
    def info(self) -> GpuInfo:
        return self._child.info

    @property
    def closed(self) -> bool:
        """Whether `close` has been called: such a device runs nothing any more."""
        return self._closed

    @property
    def compiled(self) -> int:
        """How many shaders have been compiled so far; a change of a uniform must not raise it."""
        return self._compiled

    @property
    def pid(self) -> int:
        """The process that the driver runs in."""
        return self._child.pid

    def compute(
        self,
        shader: str,
        *,
        output: int,
        inputs: Sequence[NDArray[Any]] = (),
        uniforms: Mapping[str, Uniform] = {},
        groups: tuple[int, int, int],
        timeout: float = TIMEOUT,
    ) -> NDArray[np.float32]:
        """Run a compute shader over `groups` work groups and return the storage buffer at binding 0.

        The buffer has `output` floats, which are 0 before the shader runs. `inputs` (float32, uint32 or int32, any
        shape, read in C order) are the buffers at bindings 1, 2, ... `uniforms` are numbers, or arrays for vectors,
        arrays and matrices (column after column). Raises GpuFailed where the shader does not compile, the driver
        crashes, `timeout` seconds pass or a limit of the device is exceeded; TypeError for another type of input.
        """
        self._within_limits(4 * output, "the output")
        most = self.info.max_groups
        if len(groups) != 3 or any(not 0 < g <= m for g, m in zip(groups, most, strict=False)):
            raise GpuFailed(f"{groups} work groups were asked for, this device takes 1 to {most}")
        arrays = [self._input(i, array) for i, array in enumerate(inputs, start=1)]
        sizes = tuple(a.nbytes for a in arrays)
        request = Compute(shader, 4 * output, sizes, _uniforms(uniforms), (groups[0], groups[1], groups[2]))
        with self._lock:
            arena = self._ask(request, arrays, 4 * output, timeout)
            return np.frombuffer(arena.view(0, 4 * output), np.float32).copy()

    def render(
        self,
        fragment: str,
        *,
        size: tuple[int, int],
        uniforms: Mapping[str, Uniform] = {},
        inputs: Sequence[NDArray[Any]] = (),
        timeout: float = TIMEOUT,
    ) -> NDArray[np.uint8]:
        """Run a fragment shader for every pixel of a picture `size` = (width, height).

        Returns (height, width, 4) bytes, red green blue alpha, the top row first; `gl_FragCoord` counts from the
        bottom, as OpenGL does. Inputs, uniforms and errors are those of `compute`.
        """
        width, height = size
        if width < 1 or height < 1:
            raise GpuFailed(f"a picture of {width} x {height} pixels has no pixel")
        arrays = [self._input(i, array) for i, array in enumerate(inputs, start=1)]
        request = Render(fragment, (width, height), tuple(a.nbytes for a in arrays), _uniforms(uniforms))
        with self._lock:
            arena = self._ask(request, arrays, 4 * width * height, timeout)
            pixels = np.frombuffer(arena.view(0, 4 * width * height), np.uint8)
            return pixels.reshape(height, width, 4)[::-1].copy()

    def close(self) -> None:
        """End the child process; harmless when repeated."""
        with self._lock:
            self._closed = True
            self._child.end()

    def __enter__(self) -> Gpu:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def _start(self) -> Child:
        child = Child(self._kind)
        weakref.finalize(self, child.end)  # when this object is dropped, and at the end of the program
        return child

    def _ask(self, request: Compute | Render, arrays: list[NDArray[Any]], result: int, timeout: float) -> Arena:
        """Hand over the inputs, wait, and return the memory that holds the result."""
        if self._closed:
            raise GpuFailed("this GPU has been closed")
        if not self._child.alive:
            self._child = self._start()
        child = self._child
        starts = offsets(tuple(a.nbytes for a in arrays))
        try:
            child.arena.grow(max(starts[-1], result))
        except OSError as error:
            raise GpuFailed(f"no memory to share with the graphics driver: {error.strerror}") from None
        for start, array in zip(starts, arrays, strict=False):
            np.copyto(np.frombuffer(child.arena.view(start, array.nbytes), array.dtype), array.reshape(-1))
        answer = child.ask(request, timeout)
        self._compiled += answer.compiled
        if isinstance(answer, Failed):
            raise GpuFailed(answer.reason, answer.log)
        return child.arena

    def _input(self, binding: int, array: NDArray[Any]) -> NDArray[Any]:
        if array.dtype.name not in INPUTS:
            raise TypeError(f"the buffer at binding {binding} is {array.dtype.name}, not one of {', '.join(INPUTS)}")
        self._within_limits(array.nbytes, f"the buffer at binding {binding}")
        return np.ascontiguousarray(array)

    def _within_limits(self, size: int, what: str) -> None:
        most = self.info.max_buffer_bytes
        if not 0 < size <= most:
            raise GpuFailed(f"{what} has {size} bytes, a buffer of this device has 1 to {most}: work in smaller pieces")


def open_gpu(kind: Kind = "auto") -> Gpu:
    """Start a device: `egl`, `osmesa`, or the first of them that works.

    The environment variable PORELANG_GL chooses where `kind` is auto, and `none` there makes every machine one without
    OpenGL. Raises GpuMissing, with the command that installs what is missing.
    """
    asked = os.environ.get(ENVIRONMENT, "")
    if asked not in ("", "auto", "none", "egl", "osmesa"):
        raise GpuMissing(f"{ENVIRONMENT} is {asked!r}", f"set it to auto, egl, osmesa or none, or unset {ENVIRONMENT}")
    if kind == "auto" and asked in ("egl", "osmesa"):
        kind = "egl" if asked == "egl" else "osmesa"
    install = install_command(kind)
    if asked == "none":
        raise GpuMissing(f"OpenGL is switched off by {ENVIRONMENT}=none", f"unset {ENVIRONMENT}")
    if sys.platform != "linux":
        raise GpuMissing("there is no OpenGL 4.3 without a screen on this system", install)
    if importlib.util.find_spec("moderngl") is None:
        raise GpuMissing("the Python package moderngl is not installed", f"{sys.executable} -m pip install moderngl")
    reasons = []
    for candidate in ("egl", "osmesa") if kind == "auto" else (kind,):
        try:
            return Gpu(candidate)
        except GpuFailed as failed:
            reasons.append(str(failed))
    raise GpuMissing("no OpenGL 4.3 was found (" + "; ".join(reasons) + ")", install)


_shared: dict[tuple[int, str], Gpu] = {}
_shared_lock = threading.Lock()


def shared_gpu(kind: Kind = "auto") -> Gpu:
    """The device that this process shares, opened on the first call; raises GpuMissing as `open_gpu` does."""
    key = (os.getpid(), kind)  # a forked process inherits the table, but cannot use the child of another
    with _shared_lock:
        if key not in _shared or _shared[key].closed:
            _shared[key] = open_gpu(kind)
        return _shared[key]


def _uniforms(uniforms: Mapping[str, Uniform]) -> dict[str, NDArray[Any]]:
    arrays = {name: np.asarray(value) for name, value in uniforms.items()}
    for name, array in arrays.items():
        if array.dtype.kind not in "fiub":
            raise TypeError(f"the uniform {name} is not made of numbers")
    return arrays
