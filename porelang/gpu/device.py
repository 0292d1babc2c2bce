"""The GPU for the rest of the program: arrays in, arrays out."""

from __future__ import annotations

import errno
import importlib.util
import os
import sys
import threading
import weakref
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import TracebackType
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from porelang.gpu.errors import GpuEnded, GpuFailed, GpuMissing, install_command, way_out_of_an_end
from porelang.gpu.process import POLL, Cancel, Child, check
from porelang.gpu.wire import Arena, Compute, Driver, Failed, GpuInfo, Keep, Render, Request, offsets
from porelang.limits import memory_limit, speaks_of_memory

#: Long work, or what a person waits for: each has a child of its own, so that neither waits for the other.
Lane = Literal["work", "person"]
#: Data by a digest of their content, and how to get them where the device does not hold them yet.
Data = tuple[str, Callable[[], NDArray[Any]]]
Uniform = float | int | Sequence[float] | NDArray[Any]
ENVIRONMENT = "PORELANG_GL"  # none, egl or osmesa; for tests, and for machines whose EGL is broken
INPUTS = ("float32", "uint32", "int32")
TIMEOUT = 60.0
SCARCE = 2_000_000_000  # bytes: where a process is allowed less, a driver that does not start may just lack memory


class Gpu:
    """Runs shaders in a child process that is started again after a crash. Safe to share by threads: they take turns.

    Where a call is given `cancel`, it is asked every 50 ms while the call waits, for its turn or for the shader. Once
    it says yes, CancelledError is raised; a shader that runs is stopped with the child, and the next call starts
    another.
    """

    def __init__(self, driver: str) -> None:
        self._driver, self._lock, self._compiled, self._closed = driver, threading.RLock(), 0, False
        self._at_end: weakref.finalize[[], Gpu] | None = None
        self._child = self._start()
        _opened.add(self)

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
        data: Sequence[Data] = (),
        uniforms: Mapping[str, Uniform] = {},
        groups: tuple[int, int, int],
        timeout: float = TIMEOUT,
        cancel: Cancel | None = None,
    ) -> NDArray[np.float32]:
        """Run a compute shader over `groups` work groups and return the storage buffer at binding 0.

        The buffer has `output` floats, which are 0 before the shader runs. `inputs` (float32, uint32 or int32, any
        shape, read in C order) are the buffers at bindings 1, 2, ... and `data` those after them: arrays of the same
        types, (digest, how to get them), that stay on the device. They are asked for and sent only where the device
        does not hold them; a shader must not write to them. `uniforms` are numbers, or arrays for vectors, arrays and
        matrices (column after column).

        Raises GpuFailed where the shader does not compile, the driver crashes, `timeout` seconds pass or a limit of
        `info` is exceeded; CancelledError where `cancel` says so; TypeError for another type of input.
        """
        self._within_bindings(1 + len(inputs) + len(data))
        self._within_limits(4 * output, "the output")
        most = self.info.max_groups
        if len(groups) != 3 or any(not 0 < g <= m for g, m in zip(groups, most, strict=False)):
            raise GpuFailed(f"{groups} work groups were asked for, this device takes 1 to {most}")
        arrays = [self._input(i, array) for i, array in enumerate(inputs, start=1)]
        sizes = tuple(a.nbytes for a in arrays)
        digests = tuple(digest for digest, _ in data)
        request = Compute(shader, 4 * output, sizes, digests, _uniforms(uniforms), (groups[0], groups[1], groups[2]))
        with self._turn(data, 1 + len(arrays), timeout, cancel):
            arena = self._hand_over(arrays, 4 * output)
            self._answer(request, timeout, cancel)
            return np.frombuffer(arena.view(0, 4 * output), np.float32).copy()

    def render(
        self,
        fragment: str,
        *,
        size: tuple[int, int],
        uniforms: Mapping[str, Uniform] = {},
        inputs: Sequence[NDArray[Any]] = (),
        data: Sequence[Data] = (),
        timeout: float = TIMEOUT,
        cancel: Cancel | None = None,
    ) -> NDArray[np.uint8]:
        """Run a fragment shader for every pixel of a picture `size` = (width, height).

        Returns (height, width, 4) bytes, red green blue alpha, the top row first; `gl_FragCoord` counts from the
        bottom, as OpenGL does. Inputs, data, uniforms and errors are those of `compute`.
        """
        width, height = size
        if width < 1 or height < 1:
            raise GpuFailed(f"a picture of {width} x {height} pixels has no pixel")
        self._within_bindings(len(inputs) + len(data))
        arrays = [self._input(i, array) for i, array in enumerate(inputs, start=1)]
        sizes, digests = tuple(a.nbytes for a in arrays), tuple(digest for digest, _ in data)
        request = Render(fragment, (width, height), sizes, digests, _uniforms(uniforms))
        with self._turn(data, 1 + len(arrays), timeout, cancel):
            arena = self._hand_over(arrays, 4 * width * height)
            self._answer(request, timeout, cancel)
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

    def _start(self, cancel: Cancel | None = None) -> Child:
        child = Child(self._driver, cancel)
        if self._at_end is not None:
            self._at_end.detach()  # of a child that has ended
        self._at_end = weakref.finalize(self, child.end)  # when this object is dropped, and at the end of the program
        return child

    @contextmanager
    def _turn(self, data: Sequence[Data], first: int, timeout: float, cancel: Cancel | None) -> Iterator[None]:
        """The turn of this thread, with a child that holds the data; `first` is the binding of the first of them."""
        ready: dict[str, NDArray[Any]] = {}
        places = {digest: i for i, (digest, _) in enumerate(data)}
        while True:
            with self._locked(cancel):
                missing = [digest for digest in places if digest not in self._child.resident]
                if not (wanted := [digest for digest in missing if digest not in ready]):
                    for digest in missing:
                        self._keep(digest, ready[digest], places, timeout, cancel)
                    self._child.resident.use(places)
                    yield
                    return
            for digest in wanted:  # outside the lock: others need not wait while they are made
                i = places[digest]
                ready[digest] = self._input(first + i, data[i][1]())

    @contextmanager
    def _locked(self, cancel: Cancel | None) -> Iterator[None]:
        """No other thread calls, and a child is there."""
        lock = self._lock
        while not lock.acquire(timeout=-1 if cancel is None else POLL):
            check(cancel)
        try:
            check(cancel)
            if self._closed:
                raise GpuFailed("this GPU has been closed")
            if not self._child.alive:
                self._child = self._start(cancel)
            yield
        finally:
            lock.release()

    def _keep(
        self, digest: str, array: NDArray[Any], needed: Collection[str], timeout: float, cancel: Cancel | None
    ) -> None:
        """Send data to the child, which lets go of others for them."""
        resident = self._child.resident
        dropped = resident.to_drop(array.nbytes, needed)
        self._hand_over([array], array.nbytes)
        resident.drop(dropped)  # the child lets go of them even where there is no room for the new ones
        self._answer(Keep(digest, array.nbytes, dropped), timeout, cancel)
        resident.add(digest, array.nbytes)

    def _hand_over(self, arrays: list[NDArray[Any]], result: int) -> Arena:
        """Copy arrays to the memory that the child shares, which has room for a result of `result` bytes."""
        arena, starts = self._child.arena, offsets(tuple(a.nbytes for a in arrays))
        try:
            arena.grow(max(starts[-1], result))
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            if error.errno == errno.EFBIG:
                reason = "files may not be that large (`ulimit -f`)"
            raise GpuFailed(f"no memory to share with it: {reason}") from None
        for start, array in zip(starts, arrays, strict=False):
            np.copyto(np.frombuffer(arena.view(start, array.nbytes), array.dtype), array.reshape(-1))
        return arena

    def _answer(self, request: Request, timeout: float, cancel: Cancel | None) -> None:
        answer = self._child.ask(request, timeout, cancel)
        self._compiled += answer.compiled
        if isinstance(answer, Failed):
            raise GpuFailed(answer.reason, answer.log)

    def _input(self, binding: int, array: NDArray[Any]) -> NDArray[Any]:
        if array.dtype.name not in INPUTS:
            raise TypeError(f"the buffer at binding {binding} is {array.dtype.name}, not one of {', '.join(INPUTS)}")
        self._within_limits(array.nbytes, f"the buffer at binding {binding}")
        return np.ascontiguousarray(array)

    def _within_bindings(self, count: int) -> None:
        if count > (most := self.info.max_buffers):
            raise GpuFailed(f"the shader has {count} storage buffers, this device binds at most {most}")

    def _within_limits(self, size: int, what: str) -> None:
        most = self.info.max_buffer_bytes
        if not 0 < size <= most:
            raise GpuFailed(f"{what} has {size} bytes, a buffer of this device has 1 to {most}: work in smaller pieces")


def open_gpu(driver: Driver = "auto") -> Gpu:
    """Start a child for the driver `egl`, `osmesa`, or the first of them that works.

    The environment variable PORELANG_GL chooses where `driver` is auto, and `none` there makes every machine one
    without OpenGL. Raises GpuMissing, with the command that installs what is missing.
    """
    asked = os.environ.get(ENVIRONMENT, "")
    if asked not in ("", "auto", "none", "egl", "osmesa"):
        raise GpuMissing(f"{ENVIRONMENT} is {asked!r}", f"set it to auto, egl, osmesa or none, or unset {ENVIRONMENT}")
    if driver == "auto" and asked in ("egl", "osmesa"):
        driver = "egl" if asked == "egl" else "osmesa"
    install = install_command(driver)
    if asked == "none":
        raise GpuMissing(f"OpenGL is switched off by {ENVIRONMENT}=none", f"unset {ENVIRONMENT}")
    if sys.platform != "linux":
        raise GpuMissing("there is no OpenGL 4.3 without a screen on this system", install)
    if importlib.util.find_spec("moderngl") is None:
        raise GpuMissing("the Python package moderngl is not installed", f"{sys.executable} -m pip install moderngl")
    failures: list[GpuFailed] = []
    for candidate in ("egl", "osmesa") if driver == "auto" else (driver,):
        try:
            return Gpu(candidate)
        except GpuFailed as failed:
            failures.append(failed)
    tight = (memory_limit() or SCARCE) < SCARCE
    ended = next((f for f in failures if f.ended or tight or speaks_of_memory(str(f))), None)
    if ended is not None and (tight or failures[0] is ended):
        raise GpuEnded(ended.reason, way_out_of_an_end())
    raise GpuMissing("no OpenGL 4.3 was found (" + "; ".join(map(str, failures)) + ")", install)


_shared: dict[tuple[int, Driver, Lane], Gpu] = {}
_shared_lock = threading.Lock()
_opened: weakref.WeakSet[Gpu] = weakref.WeakSet()


def shared_gpu(driver: Driver = "auto", lane: Lane = "work") -> Gpu:
    """What this process shares of a lane, opened on the first call; raises GpuMissing as `open_gpu` does."""
    key = (os.getpid(), driver, lane)  # a forked process inherits the table, but cannot use the child of another
    with _shared_lock:
        if key not in _shared or _shared[key].closed:
            _shared[key] = open_gpu(driver)
        return _shared[key]


def _fresh_locks() -> None:
    """In a forked process: the threads that held the locks are not there to release them."""
    global _shared_lock
    _shared_lock = threading.Lock()
    for gpu in list(_opened):
        gpu._lock = threading.RLock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_fresh_locks)


def _uniforms(uniforms: Mapping[str, Uniform]) -> dict[str, NDArray[Any]]:
    arrays = {name: np.asarray(value) for name, value in uniforms.items()}
    for name, array in arrays.items():
        if array.dtype.kind not in "fiub":
            raise TypeError(f"the uniform {name} is not made of numbers")
    return arrays
