"""A folder of the user's for what is costly to compute twice; without it everything works, only slower."""

from __future__ import annotations

import os
import tempfile
from contextlib import suppress
from pathlib import Path


def folder() -> Path | None:
    """`$PORELANG_CACHE`, else `porelang` in the user's cache folder (XDG); None if there is no home."""
    if own := os.environ.get("PORELANG_CACHE"):
        return Path(own)
    # The XDG specification: a relative path there is invalid and to be ignored.
    if (base := os.environ.get("XDG_CACHE_HOME")) and os.path.isabs(base):
        return Path(base) / "porelang"
    try:
        return Path.home() / ".cache" / "porelang"
    except RuntimeError:
        return None


def get(key: str) -> bytes | None:
    """What was put under `key` (a file name), or None if nothing was or it cannot be read."""
    where = folder()
    if where is None:
        return None
    try:
        return (where / key).read_bytes()
    except OSError:
        return None


def put(key: str, content: bytes) -> None:
    """Keep `content` under `key` (a file name); silently nothing where the folder cannot be written.

    The file appears whole or not at all: another process never reads half of it.
    """
    where = folder()
    if where is None:
        return
    with suppress(OSError):
        where.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=where, prefix=f".{key}.")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(content)
            os.replace(temporary, where / key)
        except OSError:
            os.unlink(temporary)
