"""The XML files of VTK: the arrays of a .vtu or .vti file, whichever of its ways they are written in.

An array is numbers as text, or bytes: in base64 where it stands, or after the text (`appended`), raw or in base64;
whole, or in blocks that are compressed. What it claims is compared with what there is before anything is unpacked.
The format: VTK's "XML file formats" (docs.vtk.org), and vtkXMLDataParser, which reads a header as UInt32 in old files.
"""

from __future__ import annotations

import base64
import re
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import BinaryIO
from xml.etree import ElementTree

import numpy as np

from porelang.progress import tell
from porelang.tasks.readers.asked import BROKEN, LARGEST, Array, Asked, lower, shown

_TYPES = {f"{sign}Int{8 * n}": f"{kind}{n}" for sign, kind in (("", "i"), ("U", "u")) for n in (1, 2, 4, 8)}
_TYPES |= {"Float32": "f4", "Float64": "f8", "vtkIdType": "i8"}
_BLOCKS = 1_000_000  # blocks of an array: VTK makes them of 32 kB
_ZLIB, _LZMA = "vtkZLibDataCompressor", "vtkLZMADataCompressor"
_COMPRESS = "write it with `CompressorType` ZLib or None (in ParaView an option of Save Data)"
_SERIES = "write one step, as a file of its own"


@dataclass(frozen=True, slots=True)
class Document:
    """A file: its root, how its bytes are ordered, the type of sizes, and what stands after the text."""

    asked: Asked
    root: ElementTree.Element
    order: str
    header: np.dtype[np.unsignedinteger]
    compressor: str
    appended: bytes
    encoding: str

    def pieces(self, dataset: str) -> list[ElementTree.Element]:
        """The parts that a dataset is written in. Errors: E131, E151."""
        found = self.root.find(dataset)
        if found is None:
            kind = shown(self.root.get("type", "") or "nothing that VTK writes")
            raise self.asked.fail("E131", f"`{self.asked.path}` holds {kind}, not {dataset}", _OTHERS.get(kind, ""))
        if len(found.get("TimeValues", "").split()) > 1:
            raise self.several_steps()
        pieces = found.findall("Piece")
        filled = [p for p in pieces if p.get("NumberOfPoints", "").strip() != "0"]
        return filled or pieces  # of a mesh in parts some may hold nothing, not even the arrays

    def several_steps(self) -> Exception:
        """E151: which of several times is meant?"""
        return self.asked.fail("E151", f"`{self.asked.path}` holds several time steps", _SERIES)

    def named(self, pieces: list[ElementTree.Element]) -> tuple[str, list[ElementTree.Element]]:
        """The array that was asked for in each piece, and where it is: `PointData` or `CellData`, the first if both.

        Errors: E132, E151.
        """
        for section in ("PointData", "CellData"):
            found = []
            for piece in pieces:
                several = [a for a in piece.iterfind(f"{section}/DataArray") if a.get("Name") == self.asked.name]
                if len(several) > 1 or any(a.get("TimeStep", "0") != "0" for a in several):
                    raise self.several_steps()
                found += several
            if found and len(found) == len(pieces):
                return section, found
        held = (
            a.get("Name", "") for s in ("PointData", "CellData") for p in pieces for a in p.iterfind(f"{s}/DataArray")
        )
        raise self.asked.no_array(held)

    def count(self, piece: ElementTree.Element, of: str) -> int:
        """How many points or cells a piece claims. Errors: E131, E135."""
        text = piece.get(of, "")
        if not re.fullmatch(r"\s*\d{1,18}\s*", text):
            raise self.asked.damaged(f"`{of}` is `{text}`")
        return int(text)

    def array(self, element: ElementTree.Element | None, count: int, what: str) -> Array:
        """The numbers of a `DataArray`, (count, components). Errors: E131, E133, E135."""
        if element is None:
            raise self.asked.damaged(f"it has no {what}")
        kind = _TYPES.get(element.get("type", ""))
        if kind is None:
            held = shown(element.get("type", "no type"))
            raise self.asked.fail("E133", f"{what} in `{self.asked.path}` holds {held}, not numbers")
        text = element.get("NumberOfComponents", "").strip() or "1"
        components = int(text) if text.isdecimal() and len(text) < 4 else 0
        if components == 0:
            raise self.asked.damaged(f"{what} has `{text}` components")
        dtype = np.dtype(self.order + kind)
        size = count * components * dtype.itemsize
        if size > LARGEST:
            raise self.asked.too_large(f"{what} claims {count * components:,} numbers, {size:,} bytes of {LARGEST:,}")
        try:
            flat = self._numbers(element, dtype, size, what)
        except BROKEN as error:
            raise self.asked.damaged(f"{what}: {lower(error)}") from None
        if len(flat) != count * components:
            raise self.asked.damaged(f"{what} holds {len(flat):,} numbers where it claims {count * components:,}")
        return flat.astype(dtype.newbyteorder("="), copy=False).reshape(count, components)

    def _numbers(self, element: ElementTree.Element, dtype: np.dtype[np.generic], size: int, what: str) -> Array:
        """Errors: `BROKEN`."""
        written = element.get("format", "ascii")
        if written == "ascii":
            return np.array((element.text or "").split()).astype(dtype) if size else np.empty(0, dtype)
        if written == "binary":
            inline = "".join((element.text or "").split()).encode("ascii")
            return np.frombuffer(self._bytes(_Base64(inline, 0), size), dtype)
        if written != "appended":
            raise ValueError(f"it is written as `{shown(written)}`")
        offset = int(element.get("offset", ""))
        if not 0 <= offset <= len(self.appended):
            raise ValueError("it lies beyond the end of the file, which was cut short")
        source = _Raw if self.encoding == "raw" else _Base64
        return np.frombuffer(self._bytes(source(self.appended, offset), size), dtype)

    def _bytes(self, source: _Raw | _Base64, size: int) -> bytes:
        """What an array holds, which has to be `size` bytes."""
        width = self.header.itemsize
        if not self.compressor:
            claimed = self._sizes(source.head(width, True))[0]
            if claimed != size:
                raise ValueError(f"{claimed:,} bytes where {size:,} are claimed")
            return source.take(size)
        count = self._sizes(source.head(width, False))[0]
        if count == 0:
            return b""
        if count > _BLOCKS:
            raise ValueError(f"it claims {count:,} blocks")
        _, block, last, *packed = self._sizes(source.head((3 + count) * width, False, done=True))
        whole = [block] * (count - 1) + [last or block]
        if sum(whole) != size:
            raise ValueError(f"{sum(whole):,} bytes where {size:,} are claimed")
        unpack = _UNPACK[self.compressor]
        data = source.take(sum(packed))
        out, at = bytearray(), 0
        for of, by in zip(whole, packed, strict=True):
            part = unpack(data[at : at + by], of)
            if len(part) != of:
                raise ValueError("a block is not as long as it claims")
            out += part
            at += by
            tell(len(out), size)
        return bytes(out)

    def _sizes(self, head: bytes) -> list[int]:
        return [int(n) for n in np.frombuffer(head, self.header)]


def names_of(element: ElementTree.Element) -> list[str]:
    """What an array calls its components; "" where it does not say."""
    text = element.get("NumberOfComponents", "").strip() or "1"
    count = int(text) if text.isdecimal() and len(text) < 4 else 0
    return [element.get(f"ComponentName{k}", "") for k in range(count)]


class _Raw:
    """Bytes from a place on."""

    def __init__(self, data: bytes, at: int) -> None:
        self._data, self._at = data, at

    def head(self, count: int, joined: bool, done: bool = False) -> bytes:
        """The sizes before the data: `take` goes on behind them, or they are only looked at where others follow."""
        out = self._data[self._at : self._at + count]
        if len(out) < count:
            raise EOFError("it was cut short")
        if joined or done:
            self._at += count
        return out

    def take(self, count: int) -> bytes:
        out = self._data[self._at : self._at + count]
        if len(out) < count:
            raise EOFError(f"it was cut short: {len(out):,} bytes of {count:,}")
        return out


class _Base64:
    """Bytes that are written in base64 from a place on: sizes that end with `=` are a text of their own."""

    def __init__(self, data: bytes, at: int) -> None:
        self._data, self._at, self._skip = data, at, 0

    def head(self, count: int, joined: bool, done: bool = False) -> bytes:
        written = -(-count // 3) * 4
        text = self._data[self._at : self._at + written]
        out = base64.b64decode(text, validate=True)[:count] if len(text) == written else b""
        if len(out) < count:
            raise EOFError("it was cut short")
        if done or (joined and text.endswith(b"=")):
            self._at += written
        elif joined:
            self._skip = count
        return out

    def take(self, count: int) -> bytes:
        written = -(-(self._skip + count) // 3) * 4
        text = self._data[self._at : self._at + written]
        if len(text) < written:
            raise EOFError(f"it was cut short: {len(text):,} characters of {written:,}")
        return base64.b64decode(text, validate=True)[self._skip : self._skip + count]


def _inflate(data: bytes, size: int) -> bytes:
    return zlib.decompressobj().decompress(data, size + 1)


def _unlzma(data: bytes, size: int) -> bytes:
    import lzma

    try:
        return lzma.LZMADecompressor().decompress(data, size + 1)
    except lzma.LZMAError as error:
        raise ValueError(str(error)) from None


_UNPACK: dict[str, Callable[[bytes, int], bytes]] = {_ZLIB: _inflate, _LZMA: _unlzma}
_PARTS = "name one of the files that it lists"
_OTHERS = {
    "PolyData": "a surface has no inside: export the cells of the volume, as .vtu",
    "RectilinearGrid": "export it as .vti or .vtu (in ParaView: the filters Resample To Image, Append Datasets)",
    "StructuredGrid": "export it as .vtu (in ParaView: the filter Append Datasets)",
    "PUnstructuredGrid": _PARTS,
    "PImageData": _PARTS,
    "Collection": _PARTS,
}


def opened(asked: Asked, file: BinaryIO, size: int) -> Document:
    """A file's text as a tree, and what is appended to it. Errors: E131, E135."""
    if size > LARGEST:
        raise asked.too_large(f"{size:,} bytes of {LARGEST:,}")
    data = file.read()
    begin = data.find(b"<AppendedData")
    text, appended, encoding = data, b"", "raw"
    if begin >= 0:
        if not data.rstrip().endswith(b"</VTKFile>"):
            raise asked.damaged("it was cut short: its end is missing")
        tag_end = data.find(b">", begin)
        start = data.find(b"_", tag_end)
        if tag_end < 0 or start < 0:
            raise asked.damaged("it was cut short")
        encoding = "raw" if re.search(rb"encoding\s*=\s*[\"']raw", data[begin:tag_end]) else "base64"
        text, appended = data[:begin] + b"</VTKFile>", data[start + 1 :]
        if encoding == "base64":
            appended = b"".join(appended[: max(appended.find(b"<"), 0) or None].split())
    if b"<!DOCTYPE" in text or b"<!ENTITY" in text:
        raise asked.damaged("it defines words of its own, as no program does that writes data")
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, *BROKEN) as error:
        why = "it was cut short" if "no element found" in str(error) or "unclosed" in str(error) else lower(error)
        raise asked.fail("E131", f"`{asked.path}` is damaged or no file of VTK: {why}") from None
    if root.tag != "VTKFile":
        raise asked.fail("E131", f"`{asked.path}` is no file of VTK: it begins with <{shown(root.tag)}>")
    compressor = root.get("compressor", "")
    if compressor and compressor not in _UNPACK:
        how = shown(compressor.removeprefix("vtk").removesuffix("DataCompressor"))
        raise asked.fail("E131", f"`{asked.path}` is compressed by {how}, which is not read", _COMPRESS)
    order = ">" if root.get("byte_order") == "BigEndian" else "<"
    header = np.dtype(f"{order}u8" if root.get("header_type") == "UInt64" else f"{order}u4")
    return Document(asked, root, order, header, compressor, appended, encoding)
