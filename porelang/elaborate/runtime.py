"""What compiling asks of Python itself, for as long as anyone compiles: deep recursion, and no garbage collector.

Both belong to the process and not to a thread. So they are counted: the first to compile changes them, the last one
restores them, however the threads of a server overlap.
"""

from __future__ import annotations

import gc
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

#: The tree is walked by recursion; its depth is limited by the parser, and calls by `calls.DEEPEST`. (Frames of Python
#: functions do not lie on the C stack, so that threads with small stacks can go as deep.)
RECURSION = 60_000
#: A server whose threads always overlap never restores the collector: after so many compilations it collects itself.
PATIENCE = 200

_lock = threading.Lock()
_compiling = 0
_since_collection = 0
_recursion_before = 0
_collecting_before = False


@contextmanager
def room_to_compile() -> Iterator[None]:
    """Room for deep recursion, and no search for garbage (what is made stays): a third faster. May be nested."""
    _enter()
    try:
        yield
    finally:
        _leave()


def _enter() -> None:
    global _compiling, _since_collection, _recursion_before, _collecting_before
    with _lock:
        if _compiling == 0:
            _recursion_before, _collecting_before, _since_collection = sys.getrecursionlimit(), gc.isenabled(), 0
            sys.setrecursionlimit(max(_recursion_before, RECURSION))
            gc.disable()
        _compiling += 1


def _leave() -> None:
    global _compiling, _since_collection
    overdue = False
    with _lock:
        _compiling -= 1
        if _compiling == 0:
            if _collecting_before:
                gc.enable()
            if sys.getrecursionlimit() == max(_recursion_before, RECURSION):  # else somebody else has set it since
                sys.setrecursionlimit(_recursion_before)
        elif _collecting_before:
            _since_collection += 1
            overdue = _since_collection >= PATIENCE
            if overdue:
                _since_collection = 0
    if overdue:  # outside the lock: what is collected may run code of its own
        gc.collect()
