"""The names of the arrays in a file of data, read from what the file says of itself: for who is choosing one."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterator

#: So much of a file is looked through, and so many arrays are told.
_MOST, _NAMES = 64_000_000, 200
_ARRAY = re.compile(rb"<(?:P?DataArray)\b([^>]*)>")
_ATTRIBUTE = re.compile(rb'(\w+)\s*=\s*"([^"]*)"')
_LEGACY = re.compile(rb"^(SCALARS|VECTORS|TENSORS|NORMALS)\s+(\S+)", re.MULTILINE)
_FIELD = re.compile(rb"^(\w\S*)\s+(\d+)\s+\d+\s+(?:float|double|int)\s*$", re.MULTILINE)


_KINDS = {"1": "a number in each place", "3": "a vector", "6": "a tensor", "9": "a tensor"}


def names_in(path: str) -> list[tuple[str, str]]:
    """The arrays of a .vtu, .vti, .vtk or .npz file, each with how many numbers it has in a place, in order; none where
    the file cannot be read."""
    found: dict[str, str] = {}
    try:
        for name, detail in _npz(path) if path.lower().endswith(".npz") else _vtk(path):
            found.setdefault(name, detail)
            if len(found) >= _NAMES:
                break
    except (OSError, ValueError, zipfile.BadZipFile):
        return []
    return list(found.items())


def _npz(path: str) -> Iterator[tuple[str, str]]:
    with zipfile.ZipFile(path) as archive:
        for name in archive.namelist():
            if name.endswith(".npy"):
                yield name.removesuffix(".npy"), "an array"


def _vtk(path: str) -> Iterator[tuple[str, str]]:
    with open(path, "rb") as file:
        data = file.read(_MOST)
    for tag in _ARRAY.finditer(data):
        said = {key.decode(): value.decode("utf-8", "replace") for key, value in _ATTRIBUTE.findall(tag[1])}
        name = said.get("Name", "")
        if name and name not in ("connectivity", "offsets", "types", "Points"):
            yield name, _detail(said.get("NumberOfComponents", "1"))
    for word, name in _LEGACY.findall(data[:1_000_000] if data[:5] != b"# vtk" else data):
        many = {b"SCALARS": "1", b"TENSORS": "9"}.get(word, "3")
        yield name.decode("utf-8", "replace"), _detail(many)
    if data[:5] == b"# vtk":
        for name, many in _FIELD.findall(data):
            yield name.decode("utf-8", "replace"), _detail(many.decode())


def _detail(many: str) -> str:
    return _KINDS.get(many, f"{many} numbers")
