"""`load("grid.npz", "name")`: a field that was measured or computed elsewhere, on a regular grid.

The file is NumPy's own (`numpy.savez`): a zip of arrays, each with a header that tells its type and shape. Whoever
wrote it is not trusted: sizes are compared with what the headers claim before anything is allocated, and nothing is
unpickled.
"""

from __future__ import annotations

import io
import math
import zipfile
from collections.abc import Callable
from functools import partial
from typing import Any, BinaryIO

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from porelang.data import MOST_COUNTED, Triple
from porelang.progress import tell
from porelang.tasks.readers.asked import BROKEN, LARGEST, Asked, floats, layered, lower
from porelang.tasks.readers.grid import Grid, grid_of

#: Bytes of a zip's directory, which is read at once: over ten thousand arrays.
_DIRECTORY = 1_000_000
_HEADER = 70_000  # bytes: more than the longest header of version 1
_CHUNK = 1 << 20
_NO_NUMBERS = {"O": "Python objects", "S": "text", "U": "text", "c": "complex numbers", "V": "records"}
_NO_NUMBERS |= {"M": "dates", "m": "times"}


def read(asked: Asked, file: BinaryIO, size: int) -> Grid:
    """The array of a .npz file, with the `origin` and `spacing` (mm) that stand beside it.

    The array is (nx, ny, nz), or (nx, ny, nz, k) with k = 1, 3 (a vector) or 6 (a symmetric tensor) numbers a node.
    Errors: E131-E135.
    """
    try:
        with zipfile.ZipFile(_Bounded(file)) as archive:
            members = _members(asked, archive, size)
            # The small ones first: what is wrong with them is found before the large one is read.
            origin = _triple(asked, archive, members["origin"], "origin")
            spacing = _triple(asked, archive, members["spacing"], "spacing")
            values = _values(asked, archive, members[asked.name])
    except OSError:
        raise
    except BROKEN as error:
        raise asked.fail("E131", f"`{asked.path}` is damaged or no .npz file: {lower(error)}") from None
    origin, spacing = _in_mm(asked, origin), _in_mm(asked, spacing)
    return grid_of(asked, values, origin, spacing, named=True)  # the manual says the order of an array's components


def _in_mm(asked: Asked, lengths: Triple) -> Triple:
    x, y, z = lengths
    return asked.mm * x, asked.mm * y, asked.mm * z


class _Bounded:
    """A file of which no more is read at once than a directory may take: `zipfile` believes what a file claims."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.seek: Callable[..., int] = file.seek
        self.tell: Callable[[], int] = file.tell
        self.seekable: Callable[[], bool] = file.seekable

    def read(self, count: int = -1) -> bytes:
        most = max(_DIRECTORY, _CHUNK)
        found = self._file.read(count if 0 <= count <= most else most + 1)
        if len(found) > most:
            raise zipfile.BadZipFile("its directory is too large")
        return found


def _members(asked: Asked, archive: zipfile.ZipFile, size: int) -> dict[str, zipfile.ZipInfo]:
    """The entries of the three arrays that are needed."""
    found = {info.filename.removesuffix(".npy"): info for info in archive.infolist() if info.filename.endswith(".npy")}
    if asked.name not in found:
        raise asked.no_array(n for n in found if n not in ("origin", "spacing"))
    missing = [n for n in ("origin", "spacing") if n not in found]
    if missing:
        raise asked.fail("E132", f"`{asked.path}` does not say where its grid lies: no `{'` and no `'.join(missing)}`")
    for name in (asked.name, "origin", "spacing"):
        info = found[name]
        if info.flag_bits & 1:
            raise asked.fail("E131", f"`{asked.path}` is encrypted")
        if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            hint = "write it with numpy.savez or numpy.savez_compressed"
            raise asked.fail(
                "E131", f"`{name}` in `{asked.path}` is compressed in a way that NumPy does not write", hint
            )
        if info.compress_size > size:
            raise asked.fail("E131", f"`{asked.path}` is cut short: `{name}` is longer than the whole file")
    return found


def _values(asked: Asked, archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> NDArray[Any]:
    """The values at the nodes: (nx, ny, nz, components), float32 or float64, not to be written."""
    array = _array(asked, archive, info, asked.name, LARGEST, _shaped)
    if array.ndim == 3:
        array = array[..., None]
    return floats(array)


def _shaped(asked: Asked, name: str, shape: tuple[int, ...]) -> None:
    """Errors: E133 where a shape is none of a grid."""
    if len(shape) not in (3, 4) or (len(shape) == 4 and shape[3] not in (1, 3, 6)):
        hint = "it is (nx, ny, nz), or (nx, ny, nz, 3) for vectors and (nx, ny, nz, 6) for symmetric tensors"
        raise asked.fail("E133", f"`{name}` in `{asked.path}` has the shape {shape}, which is no grid", hint)
    layered(asked, shape[:3])


def _triple(asked: Asked, archive: zipfile.ZipFile, info: zipfile.ZipInfo, name: str) -> Triple:
    """`origin` or `spacing`: three numbers; for the spacing one will do."""
    array = _array(asked, archive, info, name, 1000, partial(_small, many=name == "origin")).astype(np.float64)
    x, y, z = (float(v) for v in np.broadcast_to(array, (3,)))
    if not all(map(math.isfinite, (x, y, z))):
        raise asked.fail("E134", f"`{name}` in `{asked.path}` is ({x:g}, {y:g}, {z:g})")
    return x, y, z


def _small(asked: Asked, name: str, shape: tuple[int, ...], many: bool) -> None:
    if shape not in ([(3,)] if many else [(3,), (), (1,)]):
        what = "three numbers" if many else "one number or three"
        raise asked.fail("E133", f"`{name}` in `{asked.path}` has the shape {shape}, not that of {what}")


def _array(
    asked: Asked,
    archive: zipfile.ZipFile,
    info: zipfile.ZipInfo,
    name: str,
    most: int,
    examine: Callable[[Asked, str, tuple[int, ...]], None],
) -> NDArray[Any]:
    """An array of numbers in the archive, in its shape, of `most` bytes at most as float32 or float64."""
    try:
        with archive.open(info) as member:
            shape, fortran, kind, offset = _header(member.read(_HEADER))
        if kind.hasobject or kind.kind not in "fiub":
            held = _NO_NUMBERS.get("O" if kind.hasobject else kind.kind, str(kind))
            raise asked.fail("E133", f"`{name}` in `{asked.path}` holds {held}, not numbers", _number_hint(kind))
        examine(asked, name, shape)
        count = math.prod(shape)
        size = count * max(kind.itemsize, 4 if _single(kind) else 8)
        if size > most:
            hint = "keep every second node, or a part of the grid; float32 takes half of float64"
            raise asked.fail(
                "E135", f"`{name}` in `{asked.path}` is too large: {shape} are {size:,} bytes of {most:,}", hint
            )
        if (longest := max(shape, default=0)) > MOST_COUNTED:
            hint = "keep every second node, or a part of the grid"
            text = f"`{name}` in `{asked.path}` has {longest:,} nodes along an axis; float32 counts {MOST_COUNTED:,}"
            raise asked.fail("E135", text, hint)
        if offset + count * kind.itemsize != info.file_size:
            claimed = f"{count * kind.itemsize:,} bytes of values where there are {info.file_size - offset:,}"
            raise asked.fail("E131", f"`{asked.path}` is damaged: `{name}` claims {claimed}")
        flat: NDArray[Any] = np.empty(count, kind)
        with archive.open(info) as member:
            member.read(offset)
            _fill(member, flat)
    except OSError:
        raise
    except BROKEN as error:
        raise asked.fail("E131", f"`{name}` in `{asked.path}` is damaged: {lower(error)}") from None
    return flat.reshape(shape[::-1]).T if fortran else flat.reshape(shape)


def _header(start: bytes) -> tuple[tuple[int, ...], bool, np.dtype[Any], int]:
    """Shape, whether the first axis runs fastest, type and the offset of the values. Errors: ValueError and kin."""
    file = io.BytesIO(start)
    version = npy.read_magic(file)
    if version not in ((1, 0), (2, 0)):
        raise ValueError(f"version {version[0]}.{version[1]} of the format is not one for plain numbers")
    read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    try:
        shape, fortran, kind = read(file)
    except (MemoryError, RecursionError):
        raise ValueError("its header is nested too deeply") from None
    if not all(type(n) is int and n >= 0 for n in shape):
        raise ValueError(f"its shape is {shape}")
    return shape, fortran, kind, file.tell()


def _fill(member: Any, flat: NDArray[Any]) -> None:
    """Read the values of an array and what follows, which is nothing: there the zip compares its checksum."""
    place = flat.view(np.uint8).data
    done = 0
    while chunk := member.read(_CHUNK):
        if done + len(chunk) > len(place):
            raise ValueError("there is more in it than it claims")
        place[done : done + len(chunk)] = chunk
        done += len(chunk)
        tell(done, max(len(place), 1))
    if done != len(place):
        raise EOFError(f"{done:,} bytes where {len(place):,} are claimed")


def _single(kind: np.dtype[Any]) -> bool:
    """Whether these are float32, in whatever order of bytes."""
    return kind.kind == "f" and kind.itemsize == 4


def _number_hint(kind: np.dtype[Any]) -> str:
    if kind.hasobject:
        return "objects are not read, for that could run code: write an array of floats"
    if kind.kind == "c":
        return "write its real part, its imaginary part or its absolute value"
    return "write an array of floats"
