"""What a process makes once, however many threads ask for it at the same time."""

from __future__ import annotations

import os
import struct
import threading
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Generic, TypeVar

from porelang.progress import checkpoint

T = TypeVar("T")
_POLL = 0.05  # seconds between two looks at whether what another thread makes is still wanted
#: The keys that some thread is at, each with its lock and how many have come to it.
_held: dict[Hashable, tuple[threading.RLock, int]] = {}
_holding = threading.Lock()


def _forget() -> None:
    """In a process that was forked: the threads that held something are not there."""
    global _holding  # a lock that was held when the process was forked is held for ever
    _held.clear()
    _holding = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)


@contextmanager
def alone(key: Hashable) -> Iterator[None]:
    """While this lasts no other thread is in it with the same key: who comes second finds what the first has made.

    Errors: CancelledError where it is no longer wanted before it is this thread's turn.
    """
    with _holding:
        lock, count = _held.get(key, (threading.RLock(), 0))
        _held[key] = (lock, count + 1)
    try:
        while not lock.acquire(timeout=_POLL):
            checkpoint()
        try:
            yield
        finally:
            lock.release()
    finally:
        with _holding:
            lock, count = _held[key]
            if count == 1:
                del _held[key]
            else:
                _held[key] = (lock, count - 1)


def once(make: Callable[[], T]) -> Callable[[], T]:
    """`functools.cache` for a function without arguments, with a lock: the first thread makes it, the others wait.

    `functools.cache` lets threads that come at the same time make one each. What fails is tried again.
    """
    lock = threading.RLock()
    made: list[T] = []

    @wraps(make)
    def get() -> T:
        if not made:
            with lock:
                if not made:
                    made.append(make())
        return made[0]

    return get


class Recent(Generic[T]):
    """What was made for the numbers that were asked for last, made once; threads may share it."""

    def __init__(self, most: int = 8) -> None:
        self._made: dict[bytes, T] = {}
        self._most = most
        self._lock = threading.Lock()

    def get(self, values: tuple[float, ...], make: Callable[[], T]) -> T:
        """What is remembered for these values, or is made for them now."""
        key = struct.pack(f"{len(values)}d", *values)  # -0 is not 0
        with alone((id(self), key)):
            with self._lock:
                found = self._made.get(key)
            found = make() if found is None else found
            with self._lock:
                self._made.pop(key, None)
                self._made[key] = found  # the last that was asked for
                if len(self._made) > self._most:
                    del self._made[next(iter(self._made))]
        return found
