"""`.nrrd`: a regular grid with its header before it, as 3D Slicer and ITK write it.

The format: teem.sourceforge.net/nrrd/format.html. The array is in the file itself, raw, as text or in gzip. Axes run
along x, y and z, in any order and direction; where the file names its unit of space, lengths become mm.
"""

from __future__ import annotations

import math
import os
import re
import zlib
from typing import BinaryIO

import numpy as np

from porelang.data import MOST_COUNTED, Triple
from porelang.tasks.readers.asked import (
    BROKEN,
    LARGEST,
    Array,
    Asked,
    layered,
    lower,
    shown,
)
from porelang.tasks.readers.grid import Grid, grid_of
from porelang.tasks.readers.tensors import components
from porelang.units import LENGTH, UNITS

_HEADER = 1_000_000  # bytes
_TYPES = {"signed char": "i1", "int8": "i1", "int8_t": "i1", "uchar": "u1", "unsigned char": "u1", "uint8": "u1"}
_TYPES |= {"uint8_t": "u1", "float": "f4", "double": "f8"}
for _bytes, _names in ((2, ("short",)), (4, ("int",)), (8, ("long long", "longlong"))):
    for _name in _names:
        _TYPES |= dict.fromkeys((_name, f"{_name} int", f"signed {_name}", f"signed {_name} int"), f"i{_bytes}")
        _TYPES |= dict.fromkeys((f"u{_name}", f"unsigned {_name}", f"unsigned {_name} int"), f"u{_bytes}")
    _TYPES |= {f"int{8 * _bytes}": f"i{_bytes}", f"int{8 * _bytes}_t": f"i{_bytes}"}
    _TYPES |= {f"uint{8 * _bytes}": f"u{_bytes}", f"uint{8 * _bytes}_t": f"u{_bytes}"}
#: Where xx, yy, zz, xy, yz, xz stand among the numbers of a kind of axis.
_TENSORS = {"3d-symmetric-matrix": (0, 3, 5, 1, 4, 2), "3d-masked-symmetric-matrix": (1, 4, 6, 2, 5, 3)}
_NUMBERS = {"vector", "3-vector", "covariant-vector", "3-gradient", "3-normal", "3-color", "rgb-color", "scalar"}
_NUMBERS |= {"3d-matrix", *_TENSORS, "list", "point", "normal"}
_WRITE = "write it with encoding raw or gzip, in one file with its header"


def read(asked: Asked, file: BinaryIO, size: int) -> Grid:
    """The one array of the file: its name is what the header calls `content`, else that of the file.

    Errors: E131-E135, E151.
    """
    if size > LARGEST:
        raise asked.too_large(f"{size:,} bytes of {LARGEST:,}")
    header, start = _header(asked, file.read(_HEADER))
    name = header.get("content") or os.path.splitext(os.path.basename(asked.path))[0]
    if asked.name != name:
        raise asked.no_array([name], ", by what its header calls `content`, or by the name of the file")
    if not header.get("type") or not header.get("sizes") or not header.get("encoding"):
        raise asked.damaged("its header lacks type, sizes or encoding")
    try:
        sizes = [int(n) for n in header["sizes"].split()]
        places, axis_of_numbers = _axes(asked, header, sizes)
        values = _values(asked, header, sizes, file, start)
    except OSError:
        raise
    except (*BROKEN, MemoryError) as error:
        raise asked.damaged(lower(error)) from None
    named = False
    if axis_of_numbers is None:
        values = values[..., None]
    else:
        values = np.moveaxis(values, axis_of_numbers, -1)
        kind = _kinds(header, len(sizes))[axis_of_numbers]
        if named := kind in _TENSORS:
            values = values[..., list(_TENSORS[kind])]
    return _upright(asked, values, places, named)


def _header(asked: Asked, data: bytes) -> tuple[dict[str, str], int]:
    """The fields of the header, and where the array begins."""
    if not data.startswith(b"NRRD000"):
        raise asked.fail("E131", f"`{asked.path}` is damaged or no .nrrd file: it does not begin with NRRD")
    end = re.compile(rb"\r?\n\r?\n").search(data)
    text = data[: end.start() if end else len(data)].decode("utf-8", "replace")
    fields = {}
    for line in text.splitlines()[1:]:
        key, colon, value = line.partition(":")
        if colon and not line.startswith("#") and not value.startswith("="):
            fields[key.strip().lower().replace(" ", "")] = value.strip()
    if "datafile" in fields:
        raise asked.fail("E131", f"`{asked.path}` is a header alone: its array lies in another file", _WRITE)
    if end is None:
        raise asked.damaged("it was cut short: its header has no end")
    return fields, end.end()


def _kinds(header: dict[str, str], count: int) -> list[str]:
    return [*header.get("kinds", "").lower().split(), *[""] * count][:count]


def _axes(asked: Asked, header: dict[str, str], sizes: list[int]) -> tuple[Array, int | None]:
    """The place of the first node and the step along each of three axes, (4, 3) in mm; and which axis is none of space.

    Errors: E133, E151.
    """
    kinds = _kinds(header, len(sizes))
    across = [i for i, kind in enumerate(kinds) if kind in _NUMBERS]
    vectors = _vectors(header.get("spacedirections", ""))
    across = across or [i for i, v in enumerate(vectors) if v is None]
    if not across and len(sizes) == 4 and sizes[0] in (1, 3, 6, 9) and not kinds[0]:
        across = [0]
    space = [i for i in range(len(sizes)) if i not in across]
    if len(space) > 3 or any(kind == "time" for kind in kinds):
        raise asked.fail("E151", f"`{asked.path}` holds several time steps", "write one step, as a file of its own")
    if len(space) != 3 or len(across) > 1:
        what = " x ".join(map(str, sizes))
        raise asked.fail("E133", f"`{asked.name}` in `{asked.path}` has the shape {what}, which is no grid",
                         "it is a grid of nx x ny x nz nodes, with an axis more for vectors and tensors")  # fmt: skip
    if "spacedirections" in header:
        unit = _unit(asked, header)
        steps = [vectors[i] for i in space]
        first = _vectors(header.get("spaceorigin", "(0,0,0)"))[0]
    else:
        unit = _unit(asked, header)
        apart = [float(t) for t in header.get("spacings", "").split()] or [math.nan] * len(sizes)
        least = [float(t) for t in header.get("axismins", "").split()] or [0.0] * len(sizes)
        if not all(math.isfinite(apart[i]) for i in space):
            hint = "it needs `space directions` and `space origin`, or `spacings` and `axis mins`, in mm"
            raise asked.fail("E132", f"`{asked.path}` does not say where its grid lies", hint)
        steps = [[apart[i] if axis == j else 0.0 for axis in range(3)] for j, i in enumerate(space)]
        first = [least[i] if math.isfinite(least[i]) else 0.0 for i in space]
        origin = _vectors(header.get("spaceorigin", ""))
        first = origin[0] if origin and origin[0] is not None else first
    return unit * np.array([first, *steps], np.float64).reshape(4, 3), across[0] if across else None


def _vectors(text: str) -> list[list[float] | None]:
    """`(1,0,0) none (0,0,1)`."""
    found = re.findall(r"none|\([^()]*\)", text)
    return [None if v == "none" else [float(n) for n in v[1:-1].split(",")] for v in found]


def _unit(asked: Asked, header: dict[str, str]) -> float:
    """How many mm a length of the file is: what the program says, or the file, else 1. Errors: E133."""
    if asked.lengths is not None:
        return asked.lengths
    names = set(re.findall(r'"([^"]*)"', header.get("spaceunits", header.get("units", "")))) - {"", "???"}
    known = {"um": "um", "microns": "um", "micrometers": "um", "millimeters": "mm", "meters": "m", "meter": "m"}
    if not names:
        return 1.0
    unit = UNITS.get(known.get(name := names.pop(), name))
    if names or unit is None or unit.dimension != LENGTH:
        raise asked.fail("E133", f"the space of `{asked.path}` is in `{shown(name)}`", "write lengths in mm")
    return unit.scale


def _values(asked: Asked, header: dict[str, str], sizes: list[int], file: BinaryIO, start: int) -> Array:
    """The numbers, in the order of the file's axes. Errors: those above, and what damaged files lead to."""
    kind = _TYPES.get(header["type"].lower())
    if kind is None:
        raise asked.fail("E133", f"`{asked.name}` in `{asked.path}` holds {shown(header['type'])}, not numbers")
    if str(len(sizes)) != header.get("dimension", "").strip() or min(sizes) < 0:
        raise ValueError(f"its sizes are {sizes} of dimension {header.get('dimension', '')}")
    order = {"big": ">", "little": "<"}.get(header.get("endian", "").lower(), "" if kind[1] == "1" else "?")
    dtype = np.dtype(f"{order.replace('?', '<')}{kind}")
    count = math.prod(sizes)
    size = count * dtype.itemsize
    if size > LARGEST:
        raise asked.too_large(f"it claims {count:,} numbers, {size:,} bytes of {LARGEST:,}")
    if max(sizes) > MOST_COUNTED:
        raise asked.too_large(f"it claims {max(sizes):,} nodes along an axis; float32 counts {MOST_COUNTED:,}")
    file.seek(start)
    encoding = header["encoding"].lower()
    if encoding in ("txt", "text", "ascii"):
        flat = np.array(file.read().split(), np.bytes_).astype(np.float64)
    elif encoding in ("raw", "gzip", "gz"):
        if order == "?":
            raise ValueError("its header lacks endian")
        data = _skipped(asked, header, file)
        data = data[:size] if encoding == "raw" else zlib.decompressobj(31).decompress(data, size + 1)
        if len(data) != size:
            why = "it was cut short" if len(data) < size else "there is more in it than that"
            raise EOFError(f"{why}: its header claims {size:,} bytes")
        flat = np.frombuffer(data, dtype)
    else:
        raise asked.fail("E131", f"`{asked.path}` is encoded as {shown(encoding)}, which is not read", _WRITE)
    if len(flat) != count:
        raise ValueError(f"{len(flat):,} numbers where its header claims {count:,}")
    return flat.astype(flat.dtype.newbyteorder("="), copy=False).reshape(sizes, order="F")


def _skipped(asked: Asked, header: dict[str, str], file: BinaryIO) -> bytes:
    data = file.read()
    for _ in range(int(header.get("lineskip", "0") or 0)):
        data = data.partition(b"\n")[2]
    skip = int(header.get("byteskip", "0") or 0)
    if skip < -1:
        raise ValueError(f"it skips {skip} bytes")
    if skip == -1:
        raise asked.fail("E131", f"`{asked.path}` has a header that is not told from its array", _WRITE)
    return data[skip:]


def _upright(asked: Asked, values: Array, places: Array, named: bool) -> Grid:
    """The grid with its axes along x, y and z. Errors: E133 where it is turned, E134."""
    first, steps = places[0], places[1:]
    if not np.isfinite(places).all():
        raise asked.fail("E134", f"the grid of `{asked.path}` has no place: its origin or a direction is not finite")
    main = np.argmax(np.abs(steps), axis=1)
    along = steps[np.arange(3), main]
    rest = steps.copy()
    rest[np.arange(3), main] = 0
    if sorted(main.tolist()) != [0, 1, 2] or (np.abs(rest).max(axis=1) > 1e-6 * np.abs(along)).any():
        text = f"the grid of `{asked.path}` is turned: its axes are not x, y and z"
        raise asked.fail("E133", text, "resample it on an upright grid")
    order = np.argsort(main)
    values = values.transpose(*order.tolist(), 3)
    spacing = np.empty(3)
    origin = first.copy()
    for axis in range(3):
        step = along[order[axis]]
        if step < 0:
            origin[axis] += step * (values.shape[axis] - 1)
            values = np.flip(values, axis)
        spacing[axis] = abs(step)
    layered(asked, values.shape[:3])
    x, y, z = origin.tolist()
    dx, dy, dz = spacing.tolist()
    place: Triple = (x, y, z)
    return grid_of(asked, components(asked, values), place, (dx, dy, dz), named=named)
