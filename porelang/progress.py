"""How far long work has come, and whether it is still wanted: one mechanism for whatever takes long.

Who waits says so with `watching`; what takes long names itself with `activity`, and calls `tell` between pieces of
work. Nobody has to be watching. A cancelled run ends in `CancelledError` at its next `tell`, and leaves nothing behind.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError as CancelledError
from contextlib import contextmanager
from contextvars import ContextVar

__all__ = [
    "CancelledError",
    "Report",
    "activity",
    "cancelled",
    "checkpoint",
    "compiling",
    "on_compiling",
    "tell",
    "watching",
]

#: Called with what is done (`meshing`), how much of it, and how much there is; with done = all at the end.
Report = Callable[[str, int, int], None]
_report: ContextVar[Report | None] = ContextVar("report", default=None)
_cancelled: ContextVar[Callable[[], bool] | None] = ContextVar("cancelled", default=None)
_activity: ContextVar[str] = ContextVar("activity", default="working")


@contextmanager
def watching(report: Report | None = None, cancel: Callable[[], bool] | None = None) -> Iterator[None]:
    """While this lasts, `report` is told how far work has come, and `cancel` asked whether to stop it.

    `cancel` is asked from whichever thread works. What an outer `watching` was told or asked goes on being so, where
    this one gives nothing.
    """
    told = _report.set(report) if report is not None else None
    asked = _cancelled.set(cancel) if cancel is not None else None
    try:
        yield
    finally:
        if told is not None:
            _report.reset(told)
        if asked is not None:
            _cancelled.reset(asked)


@contextmanager
def activity(name: str) -> Iterator[None]:
    """While this lasts, what is told is about `name`; when it ends, also by an error, it is told to be all done."""
    token = _activity.set(name)
    try:
        yield
    finally:
        report = _report.get()
        if report is not None:
            report(name, 1, 1)
        _activity.reset(token)


_on_compiling: list[Callable[[bool], None]] = []


def on_compiling(say: Callable[[bool], None]) -> None:
    """Have `say` called, once, if a loop has to be compiled from now on: after an installation that takes seconds.

    It is told whether the loop is kept for the next run.
    """
    _on_compiling[:] = [say]


def compiling(kept: bool) -> None:
    """Said by who compiles loops."""
    while _on_compiling:
        _on_compiling.pop()(kept)


def tell(done: int, total: int) -> None:
    """Say how far the work at hand has come. Errors: CancelledError where it is no longer wanted."""
    checkpoint()
    report = _report.get()
    if report is not None:
        report(_activity.get(), done, total)


def cancelled() -> bool:
    """Whether the work at hand is no longer wanted."""
    asked = _cancelled.get()
    return asked is not None and asked()


def checkpoint() -> None:
    """Stop here, if the work is no longer wanted: raises CancelledError."""
    if cancelled():
        raise CancelledError
