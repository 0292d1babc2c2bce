"""`.vtk`: VTK's older format, a text with numbers as text or as bytes (big-endian), of cells or of a regular grid.

The format: The VTK User's Guide, "VTK File Formats"; cells since version 5 are two arrays, offsets and connectivity.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import BinaryIO
from urllib.parse import unquote_to_bytes

import numpy as np

from porelang.data import MOST_COUNTED
from porelang.tasks.readers.asked import (
    BROKEN,
    LARGEST,
    Array,
    Asked,
    layered,
    lower,
    shown,
)
from porelang.tasks.readers.cells import HEXAHEDRON, Block, Cells, blocks, cells
from porelang.tasks.readers.grid import Grid, grid_of
from porelang.tasks.readers.tensors import are_named, components

_TYPES = {"char": "i1", "short": "i2", "int": "i4", "long": "i8", "float": "f4", "double": "f8", "vtkidtype": "i4"}
_TYPES |= {f"unsigned_{name}": kind.replace("i", "u") for name, kind in _TYPES.items() if kind[0] == "i"}
_TYPES |= {"vtktypeint64": "i8", "vtktypeuint64": "u8", "vtktypeint32": "i4"}
#: A line that begins with a word: where a list of numbers ends that are written as text.
_WORD = re.compile(rb"^[ \t]*(?![+-]?(?:nan|inf))[A-Za-z_]", re.MULTILINE | re.IGNORECASE)
_ONE = {"VECTORS": 3, "NORMALS": 3, "TENSORS": 9, "TENSORS6": 6, "GLOBAL_IDS": 1, "PEDIGREE_IDS": 1, "EDGE_FLAGS": 1}
_OTHERS = "export the cells of the volume as UNSTRUCTURED_GRID, or as .vtu"


class _Reader:
    """A file and how far it is read."""

    def __init__(self, asked: Asked, data: bytes, at: int, binary: bool) -> None:
        self.asked, self.data, self.at, self.binary = asked, data, at, binary
        self.last = ""  # the array that was met last, to which what METADATA says belongs
        self.names: dict[str, list[str]] = {}

    def line(self) -> list[str]:
        """The words of the next line that has some; none at the end."""
        while self.at < len(self.data):
            end = self.data.find(b"\n", self.at, self.at + 10_000)
            if end < 0:
                end = min(len(self.data), self.at + 10_000)
            words = self.data[self.at : end].decode("latin-1").split()
            self.at = end + 1
            if words:
                return words
        return []

    def notes(self) -> None:
        """METADATA goes to the next line that is empty; of it what the components are called is kept."""
        end = re.compile(rb"\n[ \t\r]*\n").search(self.data, max(self.at - 1, 0))
        until = len(self.data) if end is None else end.start()
        lines = [line.strip() for line in self.data[self.at : until].splitlines()]
        if lines and lines[0] == b"COMPONENT_NAMES":
            last = next((i for i, line in enumerate(lines) if line.startswith(b"INFORMATION")), len(lines))
            named = [unquote_to_bytes(line).decode(errors="replace") for line in lines[1:last]]
            self.names.setdefault(self.last, named)
        self.at = len(self.data) if end is None else end.end()

    def numbers(self, count: int, kind: str, what: str, wanted: bool = True) -> Array:
        """The next numbers, of VTK's type. Errors: E131, E133, E135."""
        dtype = _TYPES.get(kind.lower())
        if kind.lower() in ("bit", "string", "variant") or dtype is None:
            if kind.lower() == "bit" and self.binary and not wanted:
                self.at += -(-count // 8)
                return np.empty(0)
            raise self.asked.fail("E133", f"{what} in `{self.asked.path}` holds {shown(kind)}, not numbers")
        size = count * np.dtype(dtype).itemsize
        if count < 0 or size > LARGEST:
            raise self.asked.too_large(f"{what} claims {count:,} numbers, {size:,} bytes of {LARGEST:,}")
        if not self.binary:
            return self._text(count, dtype, what, wanted)
        if self.at + size > len(self.data):
            there = max(0, len(self.data) - self.at)
            raise self.asked.damaged(f"it was cut short: {what} claims {size:,} bytes where there are {there:,}")
        found = np.frombuffer(self.data, np.dtype(dtype).newbyteorder(">"), count, self.at)
        self.at += size
        return found.astype(dtype) if wanted else found

    def _text(self, count: int, dtype: str, what: str, wanted: bool) -> Array:
        end = _WORD.search(self.data, self.at)
        words = self.data[self.at : end.start() if end else len(self.data)].split()
        self.at = end.start() if end else len(self.data)
        if len(words) != count:
            raise self.asked.damaged(f"{what} holds {len(words):,} numbers where it claims {count:,}")
        try:
            return (
                np.array(words, np.bytes_).astype(np.float64 if dtype[0] == "f" else dtype)
                if wanted and count
                else np.empty(0)
            )
        except BROKEN as error:
            raise self.asked.damaged(f"{what}: {lower(error)}") from None


def read(asked: Asked, file: BinaryIO, size: int) -> Cells | Grid:
    """The array of that name, of points or else of cells. Errors: E131-E135, E150."""
    if size > LARGEST:
        raise asked.too_large(f"{size:,} bytes of {LARGEST:,}")
    data = file.read()
    start = re.match(
        rb"# vtk DataFile Version (\d+)\.(\d+)[^\n]{0,100}\n[^\n]{0,1000}\n\s*(ASCII|BINARY)\s*\n", data, re.IGNORECASE
    )
    if start is None:
        hint = "an .xml file of VTK's ends in .vtu or .vti" if data.lstrip()[:5] in (b"<?xml", b"<VTKF") else ""
        raise asked.fail("E131", f"`{asked.path}` is damaged or no .vtk file: it begins with none of its lines", hint)
    reader = _Reader(asked, data, start.end(), start[3].upper() == b"BINARY")
    try:
        return _read(reader)
    except (*BROKEN, MemoryError) as error:
        raise asked.damaged(lower(error)) from None


def _read(reader: _Reader) -> Cells | Grid:
    asked = reader.asked
    kind, shape = "", np.zeros(3, np.int64)
    origin, spacing = np.zeros(3), np.ones(3)
    points = connectivity = offsets = kinds = None
    axes: dict[str, Array] = {}
    while words := reader.line():
        word = words[0].upper()
        if word == "DATASET":
            kind = words[1].upper()
            if kind not in ("UNSTRUCTURED_GRID", "STRUCTURED_POINTS", "STRUCTURED_GRID", "RECTILINEAR_GRID"):
                raise asked.fail(
                    "E131", f"`{asked.path}` holds {shown(kind)}, which has no cells with a volume", _OTHERS
                )
        elif word == "DIMENSIONS":
            shape = np.array([int(w) for w in words[1:4]])
        elif word in ("ORIGIN", "SPACING", "ASPECT_RATIO"):
            three = np.array([float(w) for w in words[1:4]]).reshape(3)
            origin, spacing = (three, spacing) if word == "ORIGIN" else (origin, three)
        elif word == "POINTS":
            points = reader.numbers(3 * int(words[1]), words[2], "the list of points").reshape(-1, 3).astype(np.float64)
        elif word.endswith("_COORDINATES") and word[0] in "XYZ":
            axes[word[0]] = reader.numbers(int(words[1]), words[2], "a list of coordinates").astype(np.float64)
        elif word == "CELLS":
            connectivity, offsets = _listed(reader, int(words[1]), int(words[2]))
        elif word == "CELL_TYPES":
            kinds = reader.numbers(int(words[1]), "int", "the list of kinds of cells").astype(np.int64)
        elif word in ("POINT_DATA", "CELL_DATA"):
            break
        elif word == "FIELD":
            for _ in _fields(reader, int(words[2])):
                pass
        elif word == "METADATA":
            reader.notes()
        else:
            raise asked.damaged(f"it has a line that begins with `{shown(words[0])}`")
    section, values = _found(reader, words)
    names = reader.names.get(asked.name, [])
    named = are_named(names, values.shape[-1])
    if kind == "STRUCTURED_POINTS":
        return _grid(
            asked, shape, asked.mm * origin, asked.mm * spacing, components(asked, values, names), section, named
        )
    if kind == "UNSTRUCTURED_GRID":
        if points is None or connectivity is None or offsets is None or kinds is None:
            raise asked.damaged("it has no points, or no cells")
        listed = blocks(asked, kinds, offsets, connectivity)
    else:
        if kind == "RECTILINEAR_GRID":
            x, y, z = (axes.get(a, np.empty(0)) for a in "XYZ")
            shape = np.array([len(x), len(y), len(z)])
            points = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).transpose(2, 1, 0, 3).reshape(-1, 3)
        if points is None or len(points) != np.prod(shape, dtype=object):
            raise asked.damaged("it has no points, or not as many as its dimensions say")
        listed = [_bricks(shape)]
    of = len(points) if section == "POINT_DATA" else sum(len(b.numbers) for b in listed)
    if len(values) != of:
        raise asked.damaged(f"`{asked.name}` has {len(values):,} values where {of:,} belong")
    return cells(asked, asked.mm * points, listed, components(asked, values, names), section == "CELL_DATA", named)


def _bricks(shape: Array) -> Block:
    """The hexahedra between points that are counted along x, then y, then z."""
    nx, ny, nz = shape.tolist()
    number = np.arange(nx * ny * nz).reshape(nz, ny, nx)
    low = number[:-1, :-1, :-1].reshape(-1, 1)
    around = np.array([0, 1, 1 + nx, nx]) if nx else np.zeros(4, np.int64)
    return Block(HEXAHEDRON, low + np.concatenate([around, around + nx * ny]), np.arange(len(low)))


def _listed(reader: _Reader, first: int, second: int) -> tuple[Array, Array]:
    """The points of all cells one after another, and where those of each begin and end."""
    at = reader.at
    words = reader.line()
    if words and words[0].upper() == "OFFSETS":  # version 5: one offset more than there are cells
        offsets = reader.numbers(first, words[1], "the list of offsets").astype(np.int64)
        words = reader.line()
        if not words or words[0].upper() != "CONNECTIVITY":
            raise reader.asked.damaged("it has no CONNECTIVITY")
        return reader.numbers(second, words[1], "the list of cells").astype(np.int64), offsets
    reader.at = at
    mixed = reader.numbers(second, "int", "the list of cells").astype(np.int64)
    starts, place = np.empty(first, np.int64), 0
    counts = mixed.tolist()
    for i in range(first):  # each cell begins with how many points it has
        starts[i] = place
        place += max(counts[place], 0) + 1 if place < len(counts) else 1
    if place != len(mixed):
        raise reader.asked.damaged("the list of cells is longer or shorter than its cells")
    kept = np.ones(len(mixed), np.bool_)
    kept[starts] = False
    return mixed[kept], np.append(starts, place) - np.arange(first + 1)


def _fields(reader: _Reader, count: int) -> Iterator[tuple[str, Array]]:
    """Arrays that say their names and sizes."""
    for _ in range(count):
        words = reader.line()
        while words and words[0].upper() == "METADATA":
            reader.notes()
            words = reader.line()
        name, size, tuples, kind = words
        reader.last = unquote_to_bytes(name).decode(errors="replace")
        wanted = reader.last == reader.asked.name
        if not wanted and not reader.binary and kind.lower() in ("string", "bit"):
            end = _WORD.search(reader.data, reader.at)
            reader.at = end.start() if end else len(reader.data)
            continue
        values = reader.numbers(int(size) * int(tuples), kind, f"`{shown(name)}`", wanted)
        yield name, values.reshape(int(tuples), int(size)) if wanted else values


def _found(reader: _Reader, words: list[str]) -> tuple[str, Array]:
    """The array that was asked for and which section has it: that of points if both do. Errors: E132."""
    found: dict[str, Array] = {}
    held: list[str] = []
    section, count = "", 0

    def met(name: str, values: Array) -> None:
        plain = reader.last = unquote_to_bytes(name).decode(errors="replace")
        held.append(plain)
        if plain == reader.asked.name:
            found.setdefault(section, values)

    while words:
        word = words[0].upper()
        if word in ("POINT_DATA", "CELL_DATA"):
            section, count = word, int(words[1])
        elif word == "SCALARS":
            size = int(words[3]) if len(words) > 3 else 1
            at, table = reader.at, reader.line()
            if not table or table[0].upper() != "LOOKUP_TABLE":
                reader.at = at
            met(words[1], reader.numbers(size * count, words[2], f"`{shown(words[1])}`").reshape(count, size))
        elif word in _ONE:
            size = _ONE[word]
            met(words[1], reader.numbers(size * count, words[2], f"`{shown(words[1])}`").reshape(count, size))
        elif word in ("TEXTURE_COORDINATES", "COLOR_SCALARS"):
            colors = word == "COLOR_SCALARS"
            kind = ("unsigned_char" if reader.binary else "float") if colors else words[3]
            reader.numbers(int(words[2]) * count, kind, f"`{shown(words[1])}`")
        elif word == "LOOKUP_TABLE":
            reader.numbers(4 * int(words[2]), "unsigned_char" if reader.binary else "float", "a table of colours")
        elif word == "FIELD":
            for name, values in _fields(reader, int(words[2])):
                met(name, values)
        elif word == "METADATA":
            reader.notes()
        else:
            raise reader.asked.damaged(f"it has a line that begins with `{shown(words[0])}`")
        words = reader.line()
    for section in ("POINT_DATA", "CELL_DATA"):
        if section in found:
            return section, found[section]
    raise reader.asked.no_array(held)


def _grid(asked: Asked, shape: Array, origin: Array, spacing: Array, values: Array, section: str, named: bool) -> Grid:
    nodes = shape if section == "POINT_DATA" else shape - 1
    what = "nodes" if section == "POINT_DATA" else "cells"
    if int(nodes.max()) > MOST_COUNTED:
        raise asked.too_large(f"it claims {nodes.max():,} {what} along an axis; float32 counts {MOST_COUNTED:,}")
    layered(asked, nodes.tolist(), what)
    if len(values) != np.prod(nodes, dtype=object):
        raise asked.damaged(f"`{asked.name}` has {len(values):,} values where {np.prod(nodes, dtype=object):,} belong")
    nx, ny, nz = nodes.tolist()
    whole = values.reshape(nz, ny, nx, -1).transpose(2, 1, 0, 3)
    x, y, z = origin.tolist()
    dx, dy, dz = spacing.tolist()
    return grid_of(asked, whole, (x, y, z), (dx, dy, dz), section == "CELL_DATA", named)
