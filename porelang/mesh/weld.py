"""One surface from the patches of bricks, as they come: a slab of bricks at a time, so that seams are few.

Bricks come sorted by x. All that start at the same x are one slab; a vertex can be shared only within a slab and with
the one before it, so no more than two slabs' borders are ever looked at. Finished rows are kept in memory up
to a limit and beyond it in a file without a name, which the system removes however the run ends.
"""

from __future__ import annotations

import mmap
import sys
import tempfile
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.contour import Patch
from porelang.mesh.surface import Surface

Ints = NDArray[np.int64]
#: Bytes of vertices, and of triangles, that stay in memory: together the 1024^3 grid of a dense part.
IN_MEMORY = 3 << 29
FIRST = 1 << 24  # bytes mapped at first


class Rows:
    """Rows of three numbers that are only ever appended to: in memory, then, beyond `limit` bytes, on disk.

    The memory is mapped, not allocated: it grows in place, and is touched only where rows are. Pieces in a list would
    stay with the allocator when they are joined, and the peak would be twice as high (measured).
    """

    def __init__(self, dtype: Any, limit: int = IN_MEMORY, folder: Path | None = None) -> None:
        self.dtype = np.dtype(dtype)
        self.limit = limit
        self.folder = folder
        self.count = 0
        self.memory = _mapped(FIRST)
        self.file: IO[bytes] | None = None

    def add(self, rows: NDArray[Any]) -> None:
        """Append rows (n, 3). Errors: `OSError` where the disk is full."""
        size = 3 * self.dtype.itemsize
        begin, end = self.count * size, (self.count + len(rows)) * size
        self.count += len(rows)
        if self.file is None and end > self.limit:
            self.file = tempfile.TemporaryFile(dir=self.folder)  # noqa: SIM115 - it lives as long as the rows
            self.file.write(memoryview(self.memory)[:begin])
            self.memory = _mapped(FIRST)
        if self.file is not None:
            self.file.write(np.ascontiguousarray(rows).data)
            return
        if end > len(self.memory):
            self.memory = _grown(self.memory, begin, max(end, len(self.memory) * 3 // 2))
        np.frombuffer(self.memory, self.dtype, 3 * len(rows), begin).reshape(-1, 3)[:] = rows

    def all(self) -> NDArray[Any]:
        """Every row, (n, 3); nothing can be appended afterwards."""
        if self.file is not None:
            self.file.flush()
            return np.memmap(self.file, self.dtype, "r+", shape=(self.count, 3))
        return np.frombuffer(self.memory, self.dtype, 3 * self.count).reshape(-1, 3)


def _mapped(size: int) -> mmap.mmap:
    if sys.platform == "win32":
        return mmap.mmap(-1, size)
    # A shared mapping, the default, would grow beyond what it is backed by.
    return mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)


def _grown(memory: mmap.mmap, used: int, size: int) -> mmap.mmap:
    size = -(-size // mmap.PAGESIZE) * mmap.PAGESIZE
    try:
        memory.resize(size)
    except (SystemError, OSError):  # only Linux can grow a mapping in place
        larger = _mapped(size)
        larger[:used] = memory[:used]
        return larger
    return memory


class Weld:
    """A surface under construction; `folder` is where it goes if it outgrows the memory."""

    def __init__(self, limit: int = IN_MEMORY, folder: Path | None = None) -> None:
        self.vertices = Rows(np.float64, limit, folder)
        self.faces = Rows(np.int32, limit, folder)
        self.keys: Ints = np.zeros(0, np.int64)
        self.numbers: NDArray[np.int32] = np.zeros(0, np.int32)

    def slab(self, patches: list[Patch]) -> None:
        """Join the patches of the next slab: vertices with the same key are the same vertex."""
        keys = np.concatenate([self.keys, *(p.keys for p in patches)])
        distinct, first, which = np.unique(keys, return_index=True, return_inverse=True)
        numbers = np.empty(len(distinct), np.int32)
        known = first < len(self.keys)
        numbers[known] = self.numbers[first[known]]
        start = len(self.keys)
        for p in patches:
            shared = which[start : start + len(p.keys)]
            mine = first[shared] == np.arange(start, start + len(p.keys))
            start += len(p.keys)
            kept = np.ones(len(p.vertices), np.bool_)
            kept[p.border[~mine]] = False
            number = np.cumsum(kept, dtype=np.int32)
            number += np.int32(self.vertices.count - 1)
            numbers[shared[mine]] = number[p.border[mine]]
            number[p.border] = numbers[shared]
            self.vertices.add(p.vertices[kept] if not mine.all() else p.vertices)
            self.faces.add(number.take(p.faces))
        self.keys, self.numbers = distinct, numbers

    def surface(self) -> Surface:
        """The surface of all slabs."""
        return Surface(self.vertices.all(), self.faces.all())
