"""What files of meshes say of themselves, before anything is made of them: enough of one to know that it is damaged.

`pore check` looks no further, and no reader of a mesh is given a file that claims more than it has bytes for.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from importlib.util import find_spec
from typing import BinaryIO

#: What is read, by the ending of the file.
ENDINGS = (".stl", ".obj", ".ply", ".off", ".glb", ".3mf", ".step", ".stp")
#: Those that hold curved faces and the unit of their numbers, and what makes triangles of them.
STEP, CASCADE = (".step", ".stp"), "cascadio"
#: Bytes of a file.
LARGEST = 1_000_000_000
#: Triangles of a mesh: so many take some 6 GB of memory and minutes.
MOST_TRIANGLES = 5_000_000

_HEAD = 1 << 16  # bytes of a file in which its header stands
_CHUNK = 1 << 20
_STL_HEADER, _STL_TRIANGLE = 84, 50
_SIZES = {
    **dict.fromkeys(("char", "uchar", "int8", "uint8"), 1),
    **dict.fromkeys(("short", "ushort", "int16", "uint16"), 2),
    **dict.fromkeys(("int", "uint", "int32", "uint32", "float", "float32"), 4),
    **dict.fromkeys(("double", "float64", "int64", "uint64"), 8),
}
_AGAIN = "export it again"
_LFS = b"version https://git-lfs.github.com/"


class UnusableError(Exception):
    """What is wrong with a mesh: a code, a message that goes on after its path, and a way out."""


def look_over(file: BinaryIO, size: int, ending: str) -> int | None:
    """Read what a file says of itself: how many faces it holds, None where it does not say. Errors: UnusableError,
    where that cannot be true, or where it holds too much."""
    if size > LARGEST:
        raise UnusableError("E135", f"is too large: {size:,} bytes of {LARGEST:,}", "simplify the mesh")
    if size == 0:
        raise UnusableError("E140", "is empty: it holds no triangles", _AGAIN)
    if file.read(len(_LFS)) == _LFS:
        raise UnusableError("E140", "stands for a file that Git LFS has not fetched", "fetch it: `git lfs pull`")
    file.seek(0)
    count = _COUNTS[ending](file, size)
    if count == 0:
        raise UnusableError("E140", "holds no triangles", "export the part as a mesh of triangles")
    check_count(count or 0)
    return count


def check_count(triangles: int) -> None:
    """Errors: UnusableError where these are too many."""
    if triangles > MOST_TRIANGLES:
        raise UnusableError(
            "E135", f"is too large: {triangles:,} triangles of {MOST_TRIANGLES:,}", "simplify the mesh, or cut it up"
        )


def _damaged(what: str) -> UnusableError:
    return UnusableError("E140", f"is damaged: {what}", _AGAIN)


def _no(ending: str, instead: str) -> UnusableError:
    return UnusableError("E140", f"is no {ending} file: {instead}", "name the file by what it is, or export it again")


def stl_length(triangles: int) -> int:
    """The bytes of a binary STL."""
    return _STL_HEADER + _STL_TRIANGLE * triangles


def _stl(file: BinaryIO, size: int) -> int | None:
    head = file.read(_HEAD)
    count = int.from_bytes(head[80:84], "little") if len(head) >= _STL_HEADER else None
    if count is not None and 0 <= size - stl_length(count) < _STL_TRIANGLE:  # some programs add a few bytes
        return count
    if head.lstrip()[:5].lower() == b"solid" and b"\0" not in head:
        file.seek(max(0, size - _CHUNK))
        if b"endsolid" not in file.read().lower():
            raise _damaged("it was cut short, for there is no `endsolid` at its end")
        return None if b"facet" in head.lower() else 0
    if count is None:
        raise _damaged(f"{size} bytes, where the header alone takes {_STL_HEADER}")
    has = (size - _STL_HEADER) // _STL_TRIANGLE
    raise _damaged(f"it says that it holds {count:,} triangles, and has bytes for {has:,}")


def _ply(file: BinaryIO, size: int) -> int:
    head = file.read(_HEAD)
    if head[:3] != b"ply":
        raise _no(".ply", "it does not begin with `ply`")
    text, ended, _ = head.partition(b"end_header")
    if not ended:
        raise _damaged("its header has no end")
    binary, counts, least, of = b"format ascii" not in text, dict[str, int](), dict[str, int](), ""
    for words in (line.decode("latin-1").split() for line in text.splitlines()):
        match words:
            case ["element", of, number]:
                counts[of] = int(number) if number.isdigit() else -1
                least[of] = 0
            case ["property", "list", kind, _, _] if of:
                least[of] += _SIZES.get(kind, 1) if binary else 2
            case ["property", kind, _] if of:
                least[of] += _SIZES.get(kind, 1) if binary else 2
    if (wrong := min(counts, key=lambda name: counts[name], default=None)) and counts[wrong] < 0:
        raise _damaged(f"the number of `{wrong}` is none")
    for name, count in counts.items():
        if count * least[name] > size:
            raise _damaged(f"it says that it holds {count:,} of `{name}`, for which its {size:,} bytes have no room")
    return counts.get("face", 0)


def _off(file: BinaryIO, size: int) -> int:
    lines = (line.partition(b"#")[0].split() for line in file.read(_HEAD).splitlines())
    words = [word for line in lines for word in line][:4]
    if not words or not re.fullmatch(rb"(ST)?C?N?4?n?OFF", words[0]):
        raise _no(".off", "it does not begin with `OFF`")
    if len(words) < 3 or not all(word.isdigit() for word in words[1:3]):
        raise _damaged("it does not say how many corners and triangles it holds")
    vertices, faces = int(words[1]), int(words[2])
    if 6 * vertices + 8 * faces > size + _HEAD:
        raise _damaged(f"it says that it holds {vertices:,} corners and {faces:,} triangles, "
                       f"for which its {size:,} bytes have no room")  # fmt: skip
    return faces


def _obj(file: BinaryIO, size: int) -> int | None:
    """None: nobody counts before the whole file is read."""
    begun = b"\n"
    while chunk := file.read(_CHUNK):
        if b"\nf " in (text := begun + chunk.replace(b"\r", b"\n").replace(b"\t", b" ")):
            return None
        begun = text[-3:]
    return 0


def _glb(file: BinaryIO, size: int) -> None:
    head = file.read(12)
    if head[:4] != b"glTF":
        raise _no(".glb", "it does not begin with `glTF`")
    length = int.from_bytes(head[8:12], "little")
    if length != size:
        raise _damaged(f"it says that it has {length:,} bytes, and has {size:,}")


def _archive(file: BinaryIO, size: int) -> None:
    if file.read(4) != b"PK\3\4":
        raise _no(".3mf", "it is no ZIP archive")
    file.seek(max(0, size - _HEAD))
    if b"PK\5\6" not in file.read():
        raise _damaged("it was cut short, for there is no list of contents at its end")


def _step(file: BinaryIO, size: int) -> None:
    if b"ISO-10303-21" not in file.read(_HEAD):
        raise _no(".step", "it does not begin with `ISO-10303-21`")
    file.seek(max(0, size - _HEAD))
    if b"END-ISO-10303-21" not in file.read():
        raise _damaged("it was cut short, for there is no `END-ISO-10303-21` at its end")
    if find_spec(CASCADE) is None:
        raise UnusableError("E144", f"was not read: .step files take the package {CASCADE}, which is not installed",
                            f"`pip install {CASCADE}`, or export the part as .stl")  # fmt: skip


_COUNTS: Mapping[str, Callable[[BinaryIO, int], int | None]] = {
    ".stl": _stl,
    ".ply": _ply,
    ".off": _off,
    ".obj": _obj,
    ".glb": _glb,
    ".3mf": _archive,
    **dict.fromkeys(STEP, _step),
}
