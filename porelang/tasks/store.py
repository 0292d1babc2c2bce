"""What was found is kept by content: the text of the graph, the params it reads, and the code that computed it.

In memory for a process, on disk (`porelang.cache`) for the next: `pore render`, `pore mesh` and `pore measure` of one
file solve once. A file holds its own digest: what was damaged is computed anew.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections import OrderedDict
from collections.abc import Callable, Mapping
from functools import cache as once
from pathlib import Path

from porelang import __version__, cache, resources
from porelang.data import Reduced
from porelang.ir import Node, order, show
from porelang.progress import tell

_KEPT = 512
_FILES = 4096
_PREFIX = "number-"
#: The code that a number depends on, by folder or file of the package.
_CODE = ("ir.py", "interval.py", "rewrite.py", "ops", "rewrites", "analysis", "backends", "tasks/numbers")
_known: OrderedDict[str, Reduced] = OrderedDict()


def remembered(n: Node, params: Mapping[str, float], compute: Callable[[], Reduced]) -> Reduced:
    """The number of a reduction with these params, computed if it was not before; an error is never kept."""
    read = sorted({str(m.value) for m in order([n]) if m.op == "param"} & params.keys())
    asked = json.dumps([show({"": n}), [(name, float(params[name]).hex()) for name in read]])
    key = hashlib.sha256(asked.encode()).hexdigest()
    found = _known.pop(key, None)
    if found is None:
        trial = any(name.startswith("?") for name in read)  # one of many guesses of a `solve`, whose answer is kept
        found = compute() if trial else _on_disk(key, compute)
    _known[key] = found
    while len(_known) > _KEPT:
        _known.popitem(last=False)
    return found


def forget() -> None:
    """Forget what this process remembers, not what is on disk."""
    _known.clear()


def _on_disk(key: str, compute: Callable[[], Reduced]) -> Reduced:
    name = _PREFIX + hashlib.sha256(f"{_code()} {key}".encode()).hexdigest()[:40]
    kept = cache.get(name)
    found = _read(kept) if kept is not None else None
    if found is None:
        try:
            found = compute()
        finally:
            tell(1, 1)
        cache.put(name, _written(found), most=_FILES, prefix=_PREFIX)
    return found


def _written(found: Reduced) -> bytes:
    text = f"{found.value.hex()} {found.error.hex()}"
    return f"{text} {hashlib.sha256(text.encode()).hexdigest()}\n".encode()


def _read(kept: bytes) -> Reduced | None:
    """The number in a file; None if it is not what was written."""
    try:
        value, error, digest = kept.decode("ascii").split()
        found = Reduced(float.fromhex(value), float.fromhex(error))
    except ValueError:
        return None
    whole = digest == hashlib.sha256(f"{value} {error}".encode()).hexdigest()
    return found if whole and not math.isnan(found.value) and found.error >= 0 else None


@once
def _code() -> str:
    """A digest of the code: a number that another version of it found is not this version's."""
    digest = hashlib.sha256(__version__.encode())
    for part in _CODE:
        where = resources.PACKAGE / part
        for path in sorted(where.glob("*.py")) if where.is_dir() else [where]:
            digest.update(Path(path).read_bytes())
    return digest.hexdigest()
