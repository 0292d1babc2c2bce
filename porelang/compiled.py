"""Loops that NumPy has no word for, compiled by Numba: the one place that knows of it.

A compiled function sees arrays and numbers only, lets other threads run (`nogil`), and is kept on disk, so that only
the first run after an installation compiles: beside the module, or where that cannot be written in the user's cache.
Arithmetic is IEEE: nothing is fused or reordered (docs/decisions/0007).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import event

from porelang import cache
from porelang.progress import compiling
from porelang.resources import PACKAGE

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Compile a function of arrays and numbers when it is first called with their types.

    >>> import numpy as np
    >>> @compiled
    ... def total(values):
    ...     sum = 0.0
    ...     for value in values:
    ...         sum += value
    ...     return sum
    >>> total(np.array([1.0, 2.0]))
    3.0
    """
    try:
        with _place():
            made = numba.njit(nogil=True, error_model="numpy", cache=True)(function)
    except (RuntimeError, OSError):  # no folder where it could be kept: it is compiled in every process
        _Listener.kept = False
        made = numba.njit(nogil=True, error_model="numpy")(function)
    else:
        _forgive(made)
    return cast(Function, made)


@contextmanager
def _place() -> Iterator[None]:
    """While this lasts, Numba keeps functions in the user's cache, if it cannot do so beside their module.

    Numba's setting is for the whole process: others than we are to find it as it was.
    """
    where = None if numba.config.CACHE_DIR or _writable(PACKAGE) else _own_folder()
    if where is None:
        yield
        return
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(where)
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before


def _writable(folder: Path) -> bool:
    return os.access(folder, os.W_OK | os.X_OK)


def _own_folder() -> Path | None:
    """`loops` in the user's cache, if nobody else can write there: what Numba reads is trusted like a program."""
    root = cache.folder()
    if root is None:
        return None
    where = root / cache.LOOPS
    try:  # one by one: the mode is not that of the parents that `mkdir` makes
        for made in (root, where):
            made.mkdir(mode=0o700, parents=True, exist_ok=True)
    except (OSError, ValueError):
        return None
    return None if cache.distrust(root) or cache.distrust(where) or not _writable(where) else where.absolute()


def _forgive(made: Any) -> None:
    """Have a function do its work where what is kept of it cannot be read, or a full disk takes no more."""
    kept: Any = getattr(made, "_cache", None)
    if kept is None or not hasattr(kept, "load_overload") or not hasattr(kept, "save_overload"):
        return
    load, save = kept.load_overload, kept.save_overload

    def loaded(*arguments: Any) -> Any:
        try:
            return load(*arguments)
        except Exception:  # whatever a damaged file leads to: it is compiled again, and the index begun anew
            with suppress(Exception):
                kept.flush()
            return None

    def saved(*arguments: Any) -> None:
        with suppress(OSError):
            save(*arguments)

    kept.load_overload, kept.save_overload = loaded, saved


class _Listener(event.Listener):  # type: ignore[misc]  # Numba has no types
    """Says that something is compiled, for that takes seconds."""

    kept = True  # whether there is a folder for what is compiled

    def on_start(self, event: object) -> None:
        compiling(self.kept)

    def on_end(self, event: object) -> None:
        pass


event.register("numba:compile", _Listener())
