"""A folder of the user's for what is costly to compute twice; without it everything works, only slower.

What lies there is believed only where nobody else can have put it: the folder and each file belong to this user and
cannot be written by others. Links, devices and pipes in the place of a file are never opened.
"""

from __future__ import annotations

import errno
import os
import re
import secrets
import stat
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]  # a module, or none

#: A temporary file of ours: `.NAME.0123456789abcdef.part`.
_TEMPORARY = re.compile(r"\..+\.[0-9a-f]{16}\.part")
_STALE, _ABANDONED = 3600.0, 60.0  # seconds: whoever holds it, and if nobody does
LOOPS = "loops"  # the folder in ours where compiled loops are
_READ = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
_WRITE = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)


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
    """What was put under `key` (a file name), or None if nothing was, it cannot be read or is not to be trusted."""
    where = folder()
    if where is None or distrust(where):
        return None
    try:
        with open_own(where / key) as file:
            return file.read()
    except (OSError, ValueError):
        return None


def put(key: str, content: bytes, most: int | None = None, prefix: str = "") -> None:
    """Keep `content` under `key` (a file name); silently nothing where the folder cannot be written or trusted.

    The file appears whole or not at all: another process never reads half of it. Of the files that begin with `prefix`
    no more than about `most` are kept, the newest.
    """
    where = folder()
    if where is None or not write(where, key, [content]):
        return
    if most is not None and key.endswith("0"):  # now and then: to list the folder at each file would cost more
        with suppress(OSError):
            _trim(where, prefix, most)
            sweep(where)


def distrust(where: Path) -> str:
    """Why a folder is not used, in words that end "the folder ..."; empty where it is ours alone or not there yet."""
    try:
        link = os.lstat(where)
        found = os.stat(where) if stat.S_ISLNK(link.st_mode) else link
    except FileNotFoundError:
        return ""
    except (OSError, ValueError) as error:
        return f"cannot be looked at: {getattr(error, 'strerror', None) or error}"
    if not stat.S_ISDIR(found.st_mode):
        return "is not a folder"
    if not (_ours(link) and _ours(found)):
        return "belongs to another user"
    if _open_to_others(found):
        return "can be written by others"
    return ""


def open_own(path: Path) -> BinaryIO:
    """A regular file of this user's that no other can write, open for reading. Errors: OSError for anything else."""
    if not own(os.lstat(path)):  # looked at before it is opened: to open a device can do something
        raise PermissionError(errno.EPERM, "not a file of this user alone", str(path))
    handle = os.open(path, _READ)
    try:
        if not own(os.fstat(handle)):
            raise PermissionError(errno.EPERM, "not a file of this user alone", str(path))
        return os.fdopen(handle, "rb")
    except BaseException:
        os.close(handle)
        raise


def own(found: os.stat_result) -> bool:
    """Whether this is a regular file that belongs to this user and that no other can write."""
    return stat.S_ISREG(found.st_mode) and _ours(found) and not _open_to_others(found)


def write(where: Path, name: str, parts: Iterable[Any]) -> bool:
    """Write `parts` (bytes or contiguous arrays) to the file `name` in a folder of ours, whole or not at all.

    A link in the place of the file is replaced, not followed. False where that could not be done: a full or read-only
    disk, a folder that is not ours alone.
    """
    temporary = where / f".{name}.{secrets.token_hex(8)}.part"
    try:
        # One by one: the mode of `mkdir` is not that of the parents it makes, which a umask may open to others.
        for made in (where.parent, where):
            made.mkdir(mode=0o700, parents=True, exist_ok=True)
        if distrust(where):
            return False
        try:
            with os.fdopen(os.open(temporary, _WRITE, 0o600), "wb") as file:
                _hold(file.fileno())
                for part in parts:
                    file.write(part)
                file.flush()
                if fcntl is not None:  # while it is held, so that nobody takes it for a crash's
                    os.replace(temporary, where / name)
            if fcntl is None:
                os.replace(temporary, where / name)
        except BaseException:  # an interrupt too leaves nothing behind
            with suppress(OSError):
                os.unlink(temporary)
            raise
    except (OSError, ValueError):  # the latter for a NUL in the name
        return False
    return True


def left(where: Path) -> list[tuple[Path, os.stat_result]]:
    """The temporary files that crashes have left in a folder: a process that writes one holds it (`flock`)."""
    now = time.time()
    return [
        (path, found)
        for path, found in entries(where, _TEMPORARY)
        if now - found.st_mtime > _STALE or (now - found.st_mtime > _ABANDONED and not _is_held(path))
    ]


def sweep(where: Path) -> int:
    """Delete the temporary files that crashes have left in a folder, and say how many bytes they held."""
    freed = 0
    for path, found in left(where):
        with suppress(OSError):
            os.unlink(path)
            freed += found.st_size
    return freed


def _hold(handle: int) -> None:
    if fcntl is not None:
        with suppress(OSError):  # not every network's file system can
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _is_held(path: Path) -> bool:
    """Whether a process writes this file; also where that cannot be known."""
    if fcntl is None:
        return True
    try:
        with open_own(path) as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return True
    return False


def entries(where: Path, pattern: re.Pattern[str]) -> list[tuple[Path, os.stat_result]]:
    """The regular files of ours in a folder whose whole name fits a pattern; none where it cannot be listed."""
    out: list[tuple[Path, os.stat_result]] = []
    with suppress(OSError), os.scandir(where) as listed:
        for entry in listed:
            if pattern.fullmatch(entry.name):
                with suppress(OSError):  # another process may be deleting too
                    found = os.lstat(entry.path)
                    if own(found):
                        out.append((where / entry.name, found))
    return out


def _trim(where: Path, prefix: str, most: int) -> None:
    """Delete the oldest of the files that begin with `prefix`, beyond `most`."""
    ages = [(found.st_mtime, path) for path, found in entries(where, re.compile(re.escape(prefix) + ".*"))]
    for _, path in sorted(ages, reverse=True)[most:]:
        path.unlink(missing_ok=True)


def _ours(found: os.stat_result) -> bool:
    return not hasattr(os, "geteuid") or found.st_uid == os.geteuid()


def _open_to_others(found: os.stat_result) -> bool:
    return hasattr(os, "geteuid") and bool(found.st_mode & (stat.S_IWGRP | stat.S_IWOTH))
