"""Processes of our own, for native code that can crash: started with the modules of this one, listened to, ended."""

from __future__ import annotations

import multiprocessing.spawn
import os
import select
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import IO

from porelang.progress import checkpoint
from porelang.resources import PACKAGE

Running = subprocess.Popen[bytes]
_POLL = 0.05  # seconds between two questions whether the answer is still wanted
_CHUNK = 1 << 16


@contextmanager
def child(module: str, words: Sequence[object], passed: Sequence[int], errors: IO[bytes]) -> Iterator[Running]:
    """`python -m MODULE WORDS...` while the block lasts, with some descriptors passed on; killed where it still runs
    at the end. Errors: OSError where no process can be started."""
    # The interpreter that multiprocessing would start, which programs that embed Python know how to set.
    python = os.fsdecode(multiprocessing.spawn.get_executable() or sys.executable)
    path = dict.fromkeys([*(os.path.abspath(p) for p in sys.path), str(PACKAGE.parent)])
    process = subprocess.Popen(
        [python, "-P", "-m", module, *map(str, words)],
        stdin=subprocess.PIPE,  # a lifeline: it closes when this process ends, in whatever way
        stdout=subprocess.PIPE,
        stderr=errors,
        pass_fds=passed,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(path)},
    )
    with process:
        try:
            yield process
        finally:
            if process.poll() is None:
                process.kill()


def ended(process: Running, heard: Callable[[list[str]], None], limit: float | None = None) -> int:
    """Wait until a process has ended, and say how; meanwhile hand on the lines that it says, and none where it says
    nothing. Errors: TimeoutError after `limit` seconds; CancelledError where it is no longer wanted."""
    assert process.stdout is not None
    descriptor, begun = process.stdout.fileno(), b""
    last = None if limit is None else time.monotonic() + limit
    while True:
        checkpoint()
        if last is not None and time.monotonic() > last:
            raise TimeoutError
        if not select.select([descriptor], [], [], _POLL)[0]:
            heard([])
            continue
        chunk = os.read(descriptor, _CHUNK)
        if not chunk:
            return process.wait()
        *lines, begun = (begun + chunk).split(b"\n")
        heard([line.decode(errors="replace") for line in lines])
