"""What tasks have found, kept by content: in memory for this process, on disk (`porelang.cache`) for the next.

A key is a digest of everything that a result depends on; who asks makes it. On disk a result is a file of its own:

    porelang result 1 SHA-256 of the next line
    {"key", "kind", "label", "digest": of the content, "arrays": [[type, shape], ...]}
    the arrays, little-endian, one after the other

Nothing in it can run code, and it is whole or absent: what is damaged, cut short, of another kind or not ours alone is
as if it were not there. Arrays are read, not mapped: a mapped file that another process cuts short would end this one.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
import threading
from collections import OrderedDict
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from porelang import cache
from porelang.data import Numbers, Reduced, SampledField, Segments

Result = Reduced | SampledField | Segments
Stored = Result | Numbers

LIMIT = "PORELANG_CACHE_LIMIT"
_DEFAULT = 2_000_000_000
#: So many files at most: small ones fill a disk with their names and blocks, not with their bytes.
_FILES = 16_384
#: What a process holds in memory: bytes and entries.
_HELD_BYTES = 512_000_000
_HELD = 4096
_NAME = re.compile(r"([0-9a-f]{16,128})\.result")
_LOOP = re.compile(r".+\.nb[ic]")  # Numba's index of a function, and its code
_MAGIC = b"porelang result "
_VERSION = b"1"
_LONGEST = 8192  # bytes of a header
_LABEL = 200
_UNITS = {"": 1, "k": 10**3, "m": 10**6, "g": 10**9, "t": 10**12}
_BINARY = {"": 1, "k": 2**10, "m": 2**20, "g": 2**30, "t": 2**40}


@dataclass(frozen=True, slots=True)
class Entry:
    """A result on disk: what it is, its size in bytes, when it was last used (seconds since 1970), and its label."""

    key: str
    kind: str
    bytes: int
    used: float
    label: str


@dataclass(frozen=True, slots=True)
class Usage:
    """What lies on disk, the last used first; `refusal` says why nothing is kept there, where that is so.

    `left` are the bytes that runs which were killed have left there, `loops` those of compiled loops.
    """

    folder: Path | None
    entries: tuple[Entry, ...]
    limit: int
    refusal: str
    left: int = 0
    loops: int = 0

    @property
    def total(self) -> int:
        """Bytes of all entries."""
        return sum(e.bytes for e in self.entries)


@dataclass(slots=True)
class _Ledger:
    """What is known of a folder without listing it: the bytes and files found last, and those added since."""

    bytes: int | None = None
    files: int = 0
    added: int = 0
    puts: int = 0


@dataclass(slots=True)
class _Memory:
    """What this process holds, the last used at the end."""

    results: OrderedDict[str, tuple[Stored, int]] = field(default_factory=OrderedDict)
    bytes: int = 0
    ledgers: dict[Path, _Ledger] = field(default_factory=dict)


_lock = threading.Lock()
_memory = _Memory()


def get(key: str) -> Result | None:
    """The result of a task that was put under a key, from memory or from disk; None if none was or it is not whole."""
    found = _get(key)
    return None if isinstance(found, Numbers) else found


def numbers(key: str) -> Numbers | None:
    """The numbers that were put under a key, as `get` has results."""
    found = _get(key)
    return found if isinstance(found, Numbers) else None


def _get(key: str) -> Stored | None:
    _checked(key)
    with _lock:
        if key in _memory.results:
            _memory.results.move_to_end(key)
            return _memory.results[key][0]
    found = _from_disk(key)
    if found is not None:
        _hold(key, found)
    return found


def put(key: str, result: Stored, label: str = "", disk: bool = True) -> None:
    """Keep a result under a key (a digest in hexadecimal), with a line that says to a person what it is.

    It is kept on disk where that can be done and `disk` says so; a full or read-only disk is no error.
    """
    _checked(key)
    _hold(key, result)
    if not disk:
        return
    where, most = _folder(), _limit_or_default()
    if where is None or cache.distrust(where.parent) or not _plausible(result):
        return
    parts = _parts(result)
    about = {
        "key": key,
        "kind": _kind(result),
        "label": _line(label),
        "digest": _digest(result),
        "arrays": [[part.dtype.str, list(part.shape)] for part in parts],
    }
    header = json.dumps(about).encode() + b"\n"
    head = _MAGIC + _VERSION + b" " + hashlib.sha256(header).hexdigest().encode() + b"\n"
    size = len(head) + len(header) + sum(part.nbytes for part in parts)
    if size > most or len(header) > _LONGEST:
        return
    name = f"{key}.result"
    # A flat view of the bytes: an array of no elements has no buffer that can be written.
    if cache.write(where, name, [head, header, *(part.reshape(-1).view(np.uint8).data for part in parts)]):
        _note_added(where, name, size, most)


def forget() -> None:
    """Forget what this process remembers, not what is on disk."""
    with _lock:
        _memory.results.clear()
        _memory.bytes = 0
        _memory.ledgers.clear()


def usage() -> Usage:
    """What is on disk and why nothing is kept, if so. Errors: ValueError where the limit is no size."""
    where, most = _folder(), limit()
    if where is None:
        return Usage(None, (), most, "there is no home folder: set PORELANG_CACHE to a folder of yours")
    for place in (where.parent, where):
        if reason := cache.distrust(place):
            return Usage(where, (), most, f"`{place}` {reason}")
    found: list[Entry] = []
    for path, status in cache.entries(where, _NAME):
        key = path.name.removesuffix(".result")
        with suppress(OSError, ValueError), cache.open_own(path) as file:
            if not _marked(file):
                continue
            file.seek(0)
            about = _header(file, key) or {}
            kind, label = str(about.get("kind", "damaged")), _line(str(about.get("label", "")))
            found.append(Entry(key, kind, status.st_size, status.st_mtime, label))
    left = sum(status.st_size for _, status in cache.left(where))
    loops = sum(status.st_size for _, status in _loops(where.parent))
    return Usage(where, tuple(sorted(found, key=lambda e: (-e.used, e.key))), most, "", left, loops)


def clear() -> int:
    """Delete all results on disk, compiled loops and what crashes left, nothing else; the bytes that were freed."""
    where = _folder()
    if where is None or cache.distrust(where.parent) or cache.distrust(where):
        return 0
    freed = cache.sweep(where)
    for path, status in [*cache.entries(where, _NAME), *_loops(where.parent)]:
        if _deleted(path):
            freed += status.st_size
    with _lock:
        _memory.ledgers.pop(where, None)
    return freed


def _loops(root: Path) -> list[tuple[Path, os.stat_result]]:
    """The files of compiled loops in the user's cache: Numba keeps them in a folder for each of ours."""
    where = root / cache.LOOPS
    if cache.distrust(where):
        return []
    folders = [where]
    with suppress(OSError), os.scandir(where) as listed:
        folders += [where / e.name for e in listed if e.is_dir(follow_symlinks=False)]
    return [found for folder in folders for found in cache.entries(folder, _LOOP)]


def limit() -> int:
    """How many bytes may lie on disk: `$PORELANG_CACHE_LIMIT`, as in `500MB`. Errors: ValueError if that is no size."""
    text = os.environ.get(LIMIT, "").strip()
    if not text:
        return _DEFAULT
    match = re.fullmatch(r"(\d{1,18}(?:\.\d{1,18})?)\s*([kmgt]?)(i?)b?", text.lower(), re.ASCII)
    if match is None:
        raise ValueError(f"`{LIMIT}={text}` is no size")
    return int(float(match[1]) * (_BINARY if match[3] else _UNITS)[match[2]])


def _limit_or_default() -> int:
    try:
        return limit()
    except ValueError:
        return _DEFAULT


def _checked(key: str) -> None:
    if not _NAME.fullmatch(f"{key}.result"):
        raise ValueError(f"{key!r} is no digest in hexadecimal")


def _line(text: str) -> str:
    """A text as one line without what a terminal would obey."""
    line = "".join(c if c.isprintable() else " " for c in " ".join(text.split()))
    return line if len(line) <= _LABEL else line[: _LABEL - 3] + "..."


def _folder() -> Path | None:
    where = cache.folder()
    return None if where is None else where / "results"


def _hold(key: str, result: Stored) -> None:
    """Remember a result in memory, and forget those that were not used for longest."""
    size = sum(part.nbytes for part in _parts(result))
    with _lock:
        if key in _memory.results:
            _memory.bytes -= _memory.results.pop(key)[1]
        if size > _HELD_BYTES:  # it would push out everything and then itself
            return
        _memory.results[key] = (result, size)
        _memory.bytes += size
        while _memory.results and (_memory.bytes > _HELD_BYTES or len(_memory.results) > _HELD):
            _, (_, gone) = _memory.results.popitem(last=False)
            _memory.bytes -= gone


def _kind(result: Stored) -> str:
    match result:
        case Reduced():
            return "number"
        case Numbers():
            return "numbers"
        case SampledField():
            return "sampled field"
        case Segments():
            return "segments"


def _parts(result: Stored) -> list[NDArray[Any]]:
    """The arrays that make up a result, contiguous and little-endian."""
    match result:
        case Reduced():
            parts = [np.array([result.value, result.error, result.sole])]
        case Numbers():
            parts = [result.values]
        case SampledField():
            facts = np.array(result.facts, np.float64)
            parts = [np.array(result.origin), np.array(result.spacing), facts, result.values]
        case Segments():
            period = [] if result.period is None else [np.array([*result.period, result.reach])]
            parts = [result.starts, result.ends, result.radii, *period]
    return [np.ascontiguousarray(p, p.dtype.newbyteorder("<")) for p in parts]


def _from_parts(kind: str, parts: Sequence[NDArray[Any]]) -> Stored | None:
    """The result that arrays make up; None if they do not."""
    shapes = [p.shape for p in parts]
    if any(p.dtype != np.float64 for p in parts[: 3 if kind == "sampled field" else None]):
        return None
    if kind == "number" and shapes == [(3,)]:
        value, error, sole = map(float, parts[0])
        return Reduced(value, error, bool(sole)) if sole in (0.0, 1.0) else None
    if kind == "numbers" and [len(s) for s in shapes] == [1]:
        return Numbers(parts[0])
    if kind == "sampled field" and [len(s) for s in shapes] == [1, 1, 1, 4] and shapes[:2] == [(3,), (3,)]:
        (x, y, z), (dx, dy, dz), facts = (tuple(map(float, p)) for p in parts[:3])
        return SampledField(parts[3], (x, y, z), (dx, dy, dz), facts)
    if kind == "segments" and len(shapes) in (3, 4) and len(shapes[2]) == 1:
        n = shapes[2][0]
        if shapes[:2] != [(n, 3), (n, 3)] or shapes[3:] not in ([], [(4,)]):
            return None
        if not shapes[3:]:
            return Segments(parts[0], parts[1], parts[2])
        x, y, z, reach = map(float, parts[3])
        return Segments(parts[0], parts[1], parts[2], (x, y, z), reach)
    return None


def _plausible(result: Stored) -> bool:
    """Whether a result is one that a task can have found."""
    match result:
        case Reduced():
            return not math.isnan(result.value) and result.error >= 0
        case Numbers():
            return result.values.dtype == np.float64 and bool(np.isfinite(result.values).all())
        case SampledField():
            whole = min(result.shape) >= 2 and result.components >= 1 and min(result.spacing) > 0
            known = result.values.dtype in (np.float32, np.float64)
            return whole and known and all(bool(np.isfinite(p).all()) for p in _parts(result))
        case Segments():
            whole = len(result) >= 1 and all(p.dtype == np.float64 for p in _parts(result))
            whole = whole and (result.period is None or (min(result.period) > 0 and result.reach >= 0))
            return whole and all(bool(np.isfinite(p).all()) for p in _parts(result))


def _digest(result: Stored) -> str:
    """A digest of the content: for data the one they are known by, so that it is computed once."""
    if isinstance(result, Reduced | Numbers):
        return hashlib.sha256(_parts(result)[0].tobytes()).hexdigest()
    if isinstance(result, SampledField) and result.facts:
        return hashlib.sha256(result.digest.encode() + np.array(result.facts).tobytes()).hexdigest()
    return result.digest


def _from_disk(key: str) -> Stored | None:
    """The result in a file of ours that is whole, marked as used now; None for anything else."""
    where = _folder()
    if where is None or cache.distrust(where.parent) or cache.distrust(where):
        return None
    path = where / f"{key}.result"
    try:
        with cache.open_own(path) as file:
            about = _header(file, key)
            parts = _arrays(file, about["arrays"]) if about is not None else None
            if about is None or parts is None:
                return None
            found = _from_parts(about["kind"], parts)
            if found is None or not _plausible(found) or _digest(found) != about["digest"]:
                return None
            with suppress(OSError):
                os.utime(file.fileno() if os.utime in os.supports_fd else path)
    except (OSError, ValueError, TypeError, KeyError, OverflowError, RecursionError, MemoryError):
        return None
    return found


def _header(file: BinaryIO, key: str) -> dict[str, Any] | None:
    """What a file says of itself; None if that is damaged, of another version or belongs to another key."""
    magic, header = file.readline(_LONGEST), file.readline(_LONGEST)
    if magic != _MAGIC + _VERSION + b" " + hashlib.sha256(header).hexdigest().encode() + b"\n":
        return None
    about = json.loads(header)
    return about if isinstance(about, dict) and about.get("key") == key else None


def _arrays(file: BinaryIO, listed: Sequence[Any]) -> list[NDArray[Any]] | None:
    """The arrays of a file, which it must hold to the byte; their sizes are compared before anything is allocated."""
    shapes = [(np.dtype(kind), tuple(int(n) for n in shape)) for kind, shape in listed]
    if any(kind.str not in ("<f4", "<f8") or min(shape, default=0) < 0 for kind, shape in shapes):
        return None
    expected = sum(kind.itemsize * math.prod(shape) for kind, shape in shapes)
    if os.fstat(file.fileno()).st_size - file.tell() != expected or expected > _limit_or_default():
        return None
    out: list[NDArray[Any]] = []
    for kind, shape in shapes:
        array = np.empty(shape, kind)
        flat = array.reshape(-1).view(np.uint8)
        if file.readinto(flat.data) != flat.size:  # type: ignore[attr-defined]  # BinaryIO leaves it out
            return None  # cut short since
        array = array.astype(kind.newbyteorder("="), copy=False)
        array.setflags(write=False)
        out.append(array)
    return out


def _marked(file: BinaryIO) -> bool:
    """Whether a file is a result of any version, or an empty one, as a crash of the machine leaves it."""
    start = file.read(len(_MAGIC))
    return start in (_MAGIC, b"")


def _deleted(path: Path) -> bool:
    """Delete a file of ours; False where it is not ours or has gone already."""
    try:
        with cache.open_own(path) as file:
            if not _marked(file):
                return False
        os.unlink(path)
    except OSError:
        return False
    return True


def _note_added(where: Path, name: str, size: int, most: int) -> None:
    """Note that a file was added, and delete the least recently used where the limit may have been passed.

    To list the folder at each file would cost more than the file, so it is listed when this process knows that it must,
    and, as others write there too, now and then.
    """
    with _lock:
        ledger = _memory.ledgers.setdefault(where, _Ledger())
        ledger.added += size
        ledger.puts += 1
        if ledger.bytes is None:
            due = ledger.added >= most // 32 or name.startswith("0")
        else:
            due = ledger.bytes + ledger.added > most or ledger.files + ledger.puts > _FILES
            due = due or ledger.added >= most // 8 or ledger.puts >= 256
    if not due:
        return
    cache.sweep(where)
    total, files = _evict(where, most, name)
    with _lock:
        _memory.ledgers[where] = _Ledger(total, files)


def _evict(where: Path, most: int, spare: str) -> tuple[int, int]:
    """Delete the least recently used files, but `spare`, while there are too many; bytes and files that are left."""
    listed = sorted(cache.entries(where, _NAME), key=lambda e: e[1].st_mtime_ns)
    total, files = sum(status.st_size for _, status in listed), len(listed)
    if total <= most and files <= _FILES:
        return total, files
    for path, status in listed:
        if total <= 0.9 * most and files <= 0.9 * _FILES:  # some room, or each file that follows would list them again
            break
        if path.name == spare:
            continue
        _deleted(path)  # what another process has deleted first is gone as well
        total, files = total - status.st_size, files - 1
    return total, files
