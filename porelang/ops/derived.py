"""What is made from data once and kept as long as the data live: single precision, pyramids, trees, words."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

from porelang.data import Data
from porelang.once import alone

Made = TypeVar("Made")
# beside the data and not on them: what is derived is not pickled along
_KEPT: WeakKeyDictionary[Data, dict[Hashable, Any]] = WeakKeyDictionary()
_LOCK = threading.Lock()


def derived(data: Data, key: Hashable, make: Callable[[], Made]) -> Made:
    """What `make` returns, made once for these data and this key; threads that need it meanwhile wait."""
    kept = _KEPT.get(data)
    if kept is not None and key in kept:
        return kept[key]  # type: ignore[no-any-return]  # a key always names the same kind of thing
    with _LOCK:
        kept = _KEPT.setdefault(data, {})
    with alone(("derived", id(data), key)):
        if key not in kept:
            kept[key] = make()
        return kept[key]  # type: ignore[no-any-return]  # as above
