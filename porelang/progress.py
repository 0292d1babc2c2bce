"""Who is told how far a long search has come: a bar of the command line, or nobody."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

#: Called between pieces of work with (done, all), and with done = all at the end.
Watch = Callable[[int, int], None]
_watch: ContextVar[Watch | None] = ContextVar("watch", default=None)


@contextmanager
def watched(watch: Watch | None) -> Iterator[None]:
    """While this lasts, `watch(done, all)` is called between pieces of work."""
    token = _watch.set(watch)
    try:
        yield
    finally:
        _watch.reset(token)


def tell(done: int, total: int) -> None:
    """Say how far the work at hand has come."""
    watch = _watch.get()
    if watch is not None:
        watch(done, total)
