"""Loops that NumPy has no word for, compiled by Numba: the one place that knows of it.

A compiled function sees arrays and numbers only, lets other threads run (`nogil`), and is kept on disk, so that only
the first run after an installation compiles. Arithmetic is IEEE: nothing is fused or reordered (docs/decisions/0007).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
from numba.core import event

from porelang.progress import compiling

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
        return cast(Function, numba.njit(nogil=True, error_model="numpy", cache=True)(function))
    except RuntimeError:  # no folder where what was compiled could be kept: it is compiled in every process
        return cast(Function, numba.njit(nogil=True, error_model="numpy")(function))


class _Listener(event.Listener):  # type: ignore[misc]  # Numba has no types
    """Says that something is compiled, for that takes seconds."""

    def on_start(self, event: object) -> None:
        compiling()

    def on_end(self, event: object) -> None:
        pass


event.register("numba:compile", _Listener())
