"""A folder of the user's for what is costly to compute twice; without it everything works, only slower."""

from __future__ import annotations

import os
import stat
from contextlib import suppress
from pathlib import Path

from porelang.atomic import draft_in


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
    """What was put under `key` (a file name), or None: nothing was, or others may have written it."""
    where = folder()
    if where is None:
        return None
    try:
        # neither through a link nor waiting at a pipe that somebody laid there
        handle = os.open(where / key, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0))
        with os.fdopen(handle, "rb") as file:
            return file.read() if _ours(os.fstat(handle)) else None
    except OSError:
        return None


def _ours(found: os.stat_result) -> bool:
    """Whether a file is one that this user alone can have written."""
    if not hasattr(os, "geteuid"):  # Windows keeps a user's cache folder from the others
        return stat.S_ISREG(found.st_mode)
    mine = found.st_uid == os.geteuid() and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return stat.S_ISREG(found.st_mode) and mine


def put(key: str, content: bytes, most: int | None = None, prefix: str = "") -> None:
    """Keep `content` under `key` (a file name); silently nothing where the folder cannot be written.

    The file appears whole or not at all: another process never reads half of it. Of the files that begin with `prefix`
    no more than about `most` are kept, the newest.
    """
    where = folder()
    if where is None:
        return
    with suppress(OSError):
        where.mkdir(mode=0o700, parents=True, exist_ok=True)
        with draft_in(where) as draft:
            with open(os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
                file.write(content)
            os.replace(draft, where / key)
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
