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


def put(key: str, content: bytes, most: int | None = None, prefix: str = "") -> None:
    """Keep `content` under `key` (a file name); silently nothing where the folder cannot be written.

    The file appears whole or not at all: another process never reads half of it. Of the files that begin with `prefix`
    no more than about `most` are kept, the newest.
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
        except BaseException:  # an interrupt too leaves nothing behind
            os.unlink(temporary)
            raise
        if most is not None and key.endswith("0"):  # now and then: to list the folder at each file would cost more
            _trim(where, prefix, most)


def _trim(where: Path, prefix: str, most: int) -> None:
    """Delete the oldest of the files that begin with `prefix`, beyond `most`."""
    ages: list[tuple[float, Path]] = []
    for path in where.glob(f"{prefix}*"):
        with suppress(OSError):  # another process may be trimming too
            ages.append((path.stat().st_mtime, path))
    for _, path in sorted(ages, reverse=True)[most:]:
        path.unlink(missing_ok=True)
