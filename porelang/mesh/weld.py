"""One surface from the patches of bricks, as they come.

Bricks come sorted by x, so a vertex can be shared only with bricks that start where this one starts or touch it from
before: the table of shared vertices forgets the rest. Finished rows are kept in memory up to a limit and beyond it in a
file without a name, which the system removes however the run ends.
"""

from __future__ import annotations

import contextlib
import mmap
import sys
import tempfile
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.mesh.contour import Patch
from porelang.mesh.surface import Surface

Ints = NDArray[np.int64]
Numbers = NDArray[np.int32]
_NONE = np.int64(-1)  # an empty place in the table of keys
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
        self.row = 3 * self.dtype.itemsize
        self.limit = limit
        self.folder = folder
        self.count = 0
        self.memory = _mapped(FIRST)
        self.file: IO[bytes] | None = None

    def room(self, count: int) -> NDArray[Any]:
        """Space for `count` more rows, (count, 3), to be filled and then kept."""
        begin, end = self.count * self.row, (self.count + count) * self.row
        if self.file is None and end > self.limit:
            self.file = tempfile.TemporaryFile(dir=self.folder)  # noqa: SIM115 - it lives as long as the rows
            self.file.write(memoryview(self.memory)[:begin])
            self.memory = _mapped(FIRST)
        if self.file is not None:
            return np.empty((count, 3), self.dtype)
        if end > len(self.memory):
            self.memory = _grown(self.memory, begin, max(end, len(self.memory) * 3 // 2))
        return np.frombuffer(self.memory, self.dtype, 3 * count, begin).reshape(-1, 3)

    def keep(self, rows: NDArray[Any]) -> None:
        """Append rows that are the first of those there was `room` for. Errors: `OSError` where the disk is full."""
        self.count += len(rows)
        if self.file is not None:
            self.file.write(rows.data)

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
    memory = mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    if hasattr(mmap, "MADV_HUGEPAGE"):  # to touch it page by page would take as long as to compute it (measured: 6 x)
        with contextlib.suppress(OSError):  # a kernel without huge pages
            memory.madvise(mmap.MADV_HUGEPAGE)
    return memory


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
        self.keys = np.full(1 << 12, _NONE)
        self.numbers = np.zeros(1 << 12, np.int32)
        self.shared = 0

    def add(self, patch: Patch) -> None:
        """Join the next patch: vertices with the same key are the same vertex. Errors: `OSError`, the disk is full."""
        if 2 * (self.shared + len(patch.keys)) > len(self.keys):
            self._make_room(patch)
        vertices, faces = self.vertices.room(len(patch.vertices)), self.faces.room(len(patch.faces))
        new, shared = _join(
            patch.vertices, patch.faces, patch.border, patch.keys, self.keys, self.numbers, self.vertices.count,
            vertices, faces,
        )  # fmt: skip
        self.shared += shared
        self.vertices.keep(vertices[:new])
        self.faces.keep(faces)

    def _make_room(self, patch: Patch) -> None:
        """A table of the vertices that this patch and later ones may share."""
        kept = self.keys >= patch.first
        keys, numbers = self.keys[kept], self.numbers[kept]
        size = 1 << (4 * (len(keys) + len(patch.keys))).bit_length()
        self.keys, self.numbers, self.shared = np.full(size, _NONE), np.zeros(size, np.int32), len(keys)
        _enter(keys, numbers, self.keys, self.numbers)

    def surface(self) -> Surface:
        """The surface of all patches."""
        return Surface(self.vertices.all(), self.faces.all())


@compiled
def _slot(key: int, table: Ints) -> int:
    """Where a key stands in an open table whose size is a power of two, or the empty place where it would."""
    mixed = key * 0x1E3779B97F4A7C15
    at = (mixed ^ mixed >> 32) & (len(table) - 1)
    while table[at] != key and table[at] != _NONE:
        at = (at + 1) & (len(table) - 1)
    return at


@compiled
def _enter(keys: Ints, numbers: Numbers, table: Ints, table_numbers: Numbers) -> None:
    for i in range(len(keys)):
        at = _slot(keys[i], table)
        table[at], table_numbers[at] = keys[i], numbers[i]


@compiled
def _join(
    vertices: NDArray[np.float64],
    faces: Numbers,
    border: Numbers,
    keys: Ints,
    table: Ints,
    table_numbers: Numbers,
    first: int,
    new_vertices: NDArray[np.float64],
    new_faces: Numbers,
) -> tuple[int, int]:
    """Number a patch's vertices: those in the table as there, the others from `first` on. Gives how many are new, and
    how many of them went into the table."""
    number = np.full(len(vertices), -1, np.int32)
    for i in range(len(border)):
        at = _slot(keys[i], table)
        if table[at] != _NONE:
            number[border[i]] = table_numbers[at]
    new = 0
    for v in range(len(vertices)):
        if number[v] < 0:
            number[v] = first + new
            for n in range(3):
                new_vertices[new, n] = vertices[v, n]
            new += 1
    entered = 0
    for i in range(len(border)):
        if number[border[i]] >= first:
            at = _slot(keys[i], table)
            table[at], table_numbers[at] = keys[i], number[border[i]]
            entered += 1
    for t in range(len(faces)):
        for corner in range(3):
            new_faces[t, corner] = number[faces[t, corner]]
    return new, entered
