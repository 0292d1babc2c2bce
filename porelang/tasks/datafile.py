"""Opening a file of data that a program names: regular files only, of a known size, the same before and after.

What is wrong with a data file is said at the call that names it. A device or a pipe is never opened, for that may do
something or wait for ever; what was read is remembered for as long as the file stays the same.
"""

from __future__ import annotations

import os
import re
import stat
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO, TypeVar, cast

from porelang.data import Data, SampledField
from porelang.diagnostics import PoreError, fail, suggest
from porelang.once import alone
from porelang.source import Span

_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
)
_OPEN = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0) | getattr(os, "O_BINARY", 0)
#: What is remembered of the files read last: so many, and so many bytes of them, but the last in any case.
_MOST, _MOST_BYTES = 16, 1_000_000_000
_TICK = 2.0  # s: a file that changed so recently may change again and keep its times

Key = tuple[object, ...]
Some = TypeVar("Some", bound=Data)
_lock = threading.Lock()
_read: OrderedDict[Key, Data] = OrderedDict()


def remembered(
    path: str,
    ending: str | tuple[str, ...],
    what: str,
    span: Span | None,
    read: Callable[[BinaryIO, int], Some],
    part: str = "",
    instead: str = "",
) -> Some:
    """What `read` makes of a file and its size, or made of it before, for as long as the file stays the same.

    `ending` is that of its name, or those it may have, `what` says in words what the file should be, `part` which part
    of it is read, `instead` what to do with one of another ending. Errors: E130 where it cannot be read, E131 for
    another ending, and those of `read`.
    """
    found = _asked(path, ending, what, span, instead)
    key: Key = (os.path.abspath(path), part, ending, *_stamp(found))
    with alone(key):
        with _lock:
            if key in _read:
                _read.move_to_end(key)
                return cast(Some, _read[key])  # the ending is in the key, and says the type
        with _opened(path, found, span) as file:
            data = read(file, found.st_size)
        if time.time() - max(found.st_mtime, found.st_ctime) > _TICK:
            _remember(key, data)
        return data


def looked_at(
    path: str,
    ending: str | tuple[str, ...],
    what: str,
    span: Span | None,
    look: Callable[[BinaryIO, int], None],
) -> None:
    """Have `look` look at a file and its size, of which nothing is remembered. Errors: those of `remembered`."""
    found = _asked(path, ending, what, span)
    with _opened(path, found, span) as file:
        look(file, found.st_size)


def forget() -> None:
    """Forget what was read."""
    with _lock:
        _read.clear()


def _stamp(found: os.stat_result) -> tuple[int, ...]:
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns


def _remember(key: Key, data: Data) -> None:
    with _lock:
        _read[key] = data
        while len(_read) > _MOST or (len(_read) > 1 and sum(map(_bytes, _read.values())) > _MOST_BYTES):
            _read.popitem(last=False)


def _bytes(data: Data) -> int:
    return data.values.nbytes if isinstance(data, SampledField) else data.starts.nbytes * 7 // 3


def _asked(path: str, ending: str | tuple[str, ...], what: str, span: Span | None, instead: str = "") -> os.stat_result:
    """What the system says of a file that may be read; it is not opened."""
    endings = (ending,) if isinstance(ending, str) else ending
    try:
        found = os.stat(path)
    except (FileNotFoundError, NotADirectoryError, ValueError):  # the latter for a NUL in the name
        raise _missing(path, endings, span) from None
    except OSError as error:
        raise _unreadable(path, error, span) from None
    listed = " or ".join(filter(None, (", ".join(endings[:-1]), endings[-1])))
    for is_kind, name in _KINDS:
        if is_kind(found.st_mode):
            raise fail("E130", f"`{path}` is {name}, not {what}", span, hint=f"name a file that ends in {listed}")
    if not stat.S_ISREG(found.st_mode):
        raise fail("E130", f"`{path}` is no file", span, hint=f"name a file that ends in {listed}")
    if Path(path).suffix.lower() not in endings:
        has = f"ends in `{Path(path).suffix}`" if Path(path).suffix else "has no ending"
        marked = re.sub(r"\.\w+", lambda m: f"`{m[0]}`", listed)
        raise fail(
            "E131", f"`{path}` {has}, where {what} ends in {marked}", span, hint=instead or f"name a {listed} file"
        )
    return found


def _missing(path: str, endings: tuple[str, ...], span: Span | None) -> PoreError:
    where, name = os.path.split(path)
    near = None
    with suppress(OSError, ValueError):
        listed = sorted(n for n in os.listdir(where or ".") if not n.startswith("."))[:10_000]
        alike = [n for n in listed if n.lower().endswith(endings)]
        near = suggest(name, alike) or next((n for n in alike if Path(n).stem == name), None)
    if near is not None:
        return fail("E130", f"there is no file `{path}`", span, hint=f"did you mean `{os.path.join(where, near)}`?")
    if where and not os.path.lexists(where):
        return fail("E130", f"there is no file `{path}`: there is no folder `{where}`", span, hint="check the path")
    return fail("E130", f"there is no file `{path}`", span, hint="check the path")


def _unreadable(path: str, error: OSError, span: Span | None) -> PoreError:
    hint = "check its permissions" if isinstance(error, PermissionError) else "check the path and the disk"
    return fail("E130", f"`{path}` cannot be read: {error.strerror or error}", span, hint=hint)


@contextmanager
def _opened(path: str, found: os.stat_result, span: Span | None) -> Iterator[BinaryIO]:
    """The file that was looked at, open; what changes meanwhile is refused, whatever was made of it."""
    try:
        with os.fdopen(os.open(path, _OPEN), "rb") as file:

            def same() -> bool:
                return _stamp(os.fstat(file.fileno())) == _stamp(found)

            if not same():
                raise _changed(path, span)
            try:
                yield file
            except PoreError:  # what seemed wrong may be half of the old file and half of the new
                if not same():
                    raise _changed(path, span) from None
                raise
            if not same():
                raise _changed(path, span)
    except OSError as error:
        raise _unreadable(path, error, span) from None


def _changed(path: str, span: Span | None) -> PoreError:
    return fail("E130", f"`{path}` changed while it was read", span, hint="run again when what writes it has ended")
