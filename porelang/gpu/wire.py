"""What the two processes say to each other, and the memory in which they hand over large arrays.

Small things travel pickled through a socket. Arrays lie in a memory file without a name that both processes map:
it needs no cleaning up whichever of them dies first, and no room in /dev/shm, which containers keep small.
"""

from __future__ import annotations

import mmap
import os
import tempfile
from dataclasses import dataclass
from typing import Any, Literal

from numpy.typing import NDArray

Driver = Literal["auto", "egl", "osmesa"]
ALIGN = 64  # bytes; every array starts on a cache line


@dataclass(frozen=True, slots=True)
class GpuInfo:
    """What runs the shaders: the library it was opened through, its names and its limits.

    A shader may bind `max_buffers` storage buffers of up to `max_buffer_bytes` each: inputs, data, and the output of a
    compute shader. OpenGL 4.3 guarantees 8; Mesa's software driver has 16.
    """

    driver: str
    renderer: str
    vendor: str
    version: str
    glsl: str
    max_buffer_bytes: int
    max_buffers: int
    max_groups: tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class Compute:
    """Run a compute shader; inputs lie in the arena one after another, the output of `output` bytes replaces them.

    The buffers at bindings 1, 2, ... are the inputs, of these sizes in bytes, and then the kept data of these digests.
    """

    shader: str
    output: int
    inputs: tuple[int, ...]
    data: tuple[str, ...]
    uniforms: dict[str, NDArray[Any]]
    groups: tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class Render:
    """Run a fragment shader for every pixel of a picture of `size` (width, height)."""

    shader: str
    size: tuple[int, int]
    inputs: tuple[int, ...]
    data: tuple[str, ...]
    uniforms: dict[str, NDArray[Any]]


@dataclass(frozen=True, slots=True)
class Keep:
    """Keep the `size` bytes at the start of the arena as a buffer named by a digest, after letting go of others."""

    digest: str
    size: int
    dropped: tuple[str, ...]


Request = Compute | Render | Keep


@dataclass(frozen=True, slots=True)
class Done:
    """The result, where there is one, lies at the start of the arena."""

    compiled: int


@dataclass(frozen=True, slots=True)
class Failed:
    """The request was understood and could not be fulfilled."""

    reason: str
    log: str = ""
    compiled: int = 0


class Arena:
    """Memory shared by the two processes, named by a file descriptor; it only ever grows."""

    def __init__(self, fd: int | None = None) -> None:
        self.fd = _memory_file() if fd is None else fd
        self._map: mmap.mmap | None = None

    def grow(self, size: int) -> None:
        """Make room for `size` bytes; raises OSError where the machine has no memory left for them."""
        if size > os.fstat(self.fd).st_size:
            # reserve it now: writing to memory that turns out not to exist would kill the process
            os.posix_fallocate(self.fd, 0, -(-size // mmap.PAGESIZE) * mmap.PAGESIZE)

    def view(self, offset: int, size: int) -> memoryview:
        """The `size` bytes from `offset`."""
        if self._map is None or offset + size > len(self._map):
            self._map = mmap.mmap(self.fd, os.fstat(self.fd).st_size)
        return memoryview(self._map)[offset : offset + size]

    def close(self) -> None:
        os.close(self.fd)
        self._map = None


def offsets(sizes: tuple[int, ...]) -> tuple[int, ...]:
    """Where arrays of these sizes in bytes start in the arena; the last number is the end of them all."""
    at = [0]
    for size in sizes:
        at.append(at[-1] + -(-size // ALIGN) * ALIGN)
    return tuple(at)


def _memory_file() -> int:
    if hasattr(os, "memfd_create"):
        return os.memfd_create("porelang", os.MFD_CLOEXEC)
    with tempfile.TemporaryFile() as file:
        return os.dup(file.fileno())
