"""The child process as its parent sees it: started, asked, watched and ended."""

from __future__ import annotations

import multiprocessing.spawn
import os
import signal
import subprocess
import sys
import tempfile
import time
import weakref
from collections.abc import Callable
from concurrent.futures import CancelledError
from multiprocessing.connection import Pipe
from typing import Any

from porelang.gpu.errors import GpuFailed
from porelang.gpu.resident import Resident
from porelang.gpu.wire import Arena, Done, Failed, GpuInfo, Request
from porelang.limits import memory_limit
from porelang.resources import PACKAGE

START = 60.0  # seconds until a driver has to be there
POLL = 0.05  # seconds between two questions whether the answer is still wanted
LOG = 4000  # characters of the driver's last words that are worth showing

Cancel = Callable[[], bool]
_children: weakref.WeakSet[Child] = weakref.WeakSet()


class Child:
    """A running `porelang.gpu.child`; raises GpuFailed where it cannot be started or does not answer."""

    def __init__(self, driver: str, cancel: Cancel | None = None) -> None:
        self.owner = os.getpid()
        self.resident = Resident()
        self.arena = Arena()
        self._words = tempfile.TemporaryFile()  # noqa: SIM115 - closed by end()
        self._socket, theirs = Pipe()
        fds = (theirs.fileno(), self.arena.fd)
        command = [_python(), "-P", "-m", "porelang.gpu.child", *map(str, fds), driver]
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=self._words,
                stderr=self._words,
                pass_fds=fds,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(_python_path())},
            )
        except OSError as error:
            self._free()
            reason = error.strerror or str(error)
            raise GpuFailed(f"no process can be started for the graphics driver: {reason}", ended=True) from None
        finally:
            theirs.close()
        _children.add(self)
        try:
            answer = self._receive(START, "the graphics driver did not start", cancel)
            if isinstance(answer, Failed):
                raise GpuFailed(answer.reason, answer.log)
        except BaseException:
            self.end()
            raise
        assert isinstance(answer, GpuInfo)
        self.info = answer

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def alive(self) -> bool:
        """Whether this process can still ask it something (a process forked from this one cannot)."""
        return self.owner == os.getpid() and not self._socket.closed

    def ask(self, request: Request, timeout: float, cancel: Cancel | None = None) -> Done | Failed:
        """Send a request and wait for the answer; the child is ended when it is late, dead, or no longer wanted.

        Raises CancelledError once `cancel` says so, and whatever it raises itself.
        """
        try:
            try:
                self._socket.send(request)
            except OSError:
                raise self._lost() from None
            answer: Done | Failed = self._receive(timeout, "the shader did not finish", cancel)
        except BaseException:
            self.end()
            raise
        return answer

    def _receive(self, timeout: float, late: str, cancel: Cancel | None) -> Any:
        last = time.monotonic() + timeout
        while not self._answered(last if cancel is None else min(last, time.monotonic() + POLL)):
            check(cancel)
            if time.monotonic() >= last:
                self.end()
                raise GpuFailed(f"{late} within {timeout:g} s and was stopped")
        try:
            return self._socket.recv()
        except (EOFError, OSError):
            raise self._lost() from None

    def _answered(self, until: float) -> bool:
        try:
            return self._socket.poll(max(0.0, until - time.monotonic()))
        except OSError:  # closed meanwhile
            raise self._lost() from None

    def _lost(self) -> GpuFailed:
        try:
            code = self._process.wait(5)
        except subprocess.TimeoutExpired:
            code = 0
        log = self._last_words()
        self.end()
        if -code in (signal.SIGKILL, signal.SIGTERM, signal.SIGXCPU):
            name = signal.Signals(-code).name
            return GpuFailed(f"its process was killed ({name}), for want of memory or by somebody", log, ended=True)
        if code < 0:
            limit = memory_limit()
            room = "" if limit is None else f", with {limit / 1e6:,.0f} MB of memory allowed to it"
            return GpuFailed(f"the graphics driver crashed ({signal.Signals(-code).name}){room}", log, ended=True)
        return GpuFailed("the process of the graphics driver ended", log)

    def _last_words(self) -> str:
        """What the driver printed, without a Python traceback."""
        self._words.seek(0)
        text = self._words.read().decode(errors="replace")
        lines = text.partition("Traceback (most recent call last)")
        last = lines[2].strip().splitlines()[-1:] if lines[1] else []
        return "\n".join([lines[0].strip(), *last]).strip()[-LOG:]

    def end(self) -> None:
        """Kill the child and free what it held; it has nothing to save. Harmless when repeated."""
        if not self.alive:
            return
        self._process.kill()
        self._process.wait()
        if self._process.stdin is not None:
            self._process.stdin.close()
        self._free()

    def forget(self) -> None:
        """In a process forked from this one: let go of what keeps the child alive when its parent ends."""
        if not self._socket.closed:
            if self._process.stdin is not None:
                self._process.stdin.close()
            self._socket.close()
            self.arena.close()

    def _free(self) -> None:
        self._socket.close()
        self.arena.close()
        self._words.close()


def check(cancel: Cancel | None) -> None:
    """Raise CancelledError where `cancel` says so."""
    if cancel is not None and cancel():
        raise CancelledError


def _forget_children() -> None:
    for child in list(_children):
        child.forget()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_children)


def _python() -> str:
    """The interpreter that multiprocessing would start, which programs that embed Python know how to set."""
    executable = multiprocessing.spawn.get_executable() or sys.executable
    if not executable:
        raise GpuFailed("this program embeds Python and names no interpreter: call multiprocessing.set_executable")
    return os.fsdecode(executable)


def _python_path() -> list[str]:
    """Where this process finds its modules, so that the child finds the same ones."""
    path = [os.path.abspath(p) for p in sys.path if isinstance(p, str)]
    here = str(PACKAGE.parent)
    return list(dict.fromkeys([*path, here]))
