"""Places of a text as the protocol counts them: lines and columns from 0, columns in units of UTF-16, UTF-8 or
characters, as client and server have agreed."""

from __future__ import annotations

import os
from bisect import bisect_right
from pathlib import Path

from lsprotocol import types
from pygls import uris

from porelang import resources
from porelang.source import Source, Span

#: How many units each encoding has for a text.
_UNITS = {
    types.PositionEncodingKind.Utf8: lambda text: len(text.encode("utf-8", "replace")),
    types.PositionEncodingKind.Utf16: lambda text: len(text.encode("utf-16-le", "surrogatepass")) // 2,
    types.PositionEncodingKind.Utf32: len,
}
Encoding = types.PositionEncodingKind | str


def width(text: str, encoding: Encoding) -> int:
    """How many columns a text takes."""
    return _UNITS[types.PositionEncodingKind(encoding)](text)


def position(source: Source, offset: int, encoding: Encoding) -> types.Position:
    """A character of a text, as the protocol says it."""
    line = bisect_right(source.line_starts, offset) - 1
    start = source.line_starts[line]
    return types.Position(line, width(source.text[start:offset], encoding))


def offset(source: Source, at: types.Position, encoding: Encoding) -> int:
    """The character of a place; one beyond its line is the end of the line."""
    if at.line >= len(source.line_starts):
        return len(source.text)
    start = source.line_starts[at.line]
    line = source.line(at.line + 1)
    columns = 0
    for i, char in enumerate(line):
        if columns >= at.character:
            return start + i
        columns += width(char, encoding)
    return start + len(line)


def range_of(span: Span, encoding: Encoding) -> types.Range:
    """A place of a file, from where to where."""
    place = span.in_file
    return types.Range(position(place.source, place.start, encoding), position(place.source, place.end, encoding))


def location(span: Span, encoding: Encoding) -> types.Location:
    """A place and its file; of the prelude the file in the package."""
    name = span.in_file.source.name
    path = resources.folder("prelude").parent / name if span.source.prelude else Path(name).absolute()
    return types.Location(uri_of(str(path)), range_of(span, encoding))


def uri_of(path: str) -> str:
    """The address of a file."""
    return (
        path if "://" in path or path.startswith("untitled:") else uris.from_fs_path(str(Path(path).absolute())) or path
    )


def path_of(uri: str) -> str:
    """The path of an address, as sessions have it; one that is no file's is its own name."""
    return os.path.normpath(uris.to_fs_path(uri) or uri if uri.startswith("file:") else uri)
