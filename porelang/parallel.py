"""Work spread over this process's threads: NumPy and compiled loops release the interpreter."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from typing import TypeVar

import numpy as np

from porelang.diagnostics import fail
from porelang.progress import checkpoint

Item = TypeVar("Item")


def workers(threads: int | None = None) -> int:
    """The number of threads to use: as asked, else as many as this process may run on. Errors: E108."""
    if threads is not None:
        if not isinstance(threads, int | np.integer) or isinstance(threads, bool) or threads < 1:
            hint = "give a whole number above 0, or None for as many as this process may use"
            raise fail("E108", f"{threads!r} is no number of threads", hint=hint)
        return int(threads)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def parallel_for(work: Callable[[Item], None], items: Sequence[Item], threads: int) -> None:
    """Work on every item, on as many threads as that, without NumPy's warnings. A cancelled run ends between items."""

    def quiet(item: Item) -> None:
        checkpoint()
        with np.errstate(all="ignore"):
            work(item)

    if threads == 1 or len(items) < 2:
        for item in items:
            quiet(item)
        return
    context = copy_context()  # who watches this thread is told by the others too
    with ThreadPoolExecutor(threads) as pool:
        for _ in pool.map(lambda item: context.copy().run(quiet, item), items):  # what went wrong there is raised here
            pass
