"""Programs as files: reading them, and finding the files they use."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from porelang.diagnostics import fail
from porelang.source import Source
from porelang.syntax.parse import LARGEST

#: What the program is called that standard input has.
STANDARD_INPUT = "<stdin>"


def read_source(path: str | Path) -> Source:
    """The text of a `.pore` file. Errors: E105 where it cannot be read, E106 where it is no text."""
    where = Path(path)
    try:
        if where.is_char_device() or where.is_block_device():
            raise fail("E105", f"`{path}` is a device, not a program", hint="name a .pore file")
        if where.is_dir():
            raise fail("E105", f"`{path}` is a folder, not a program", hint="name the .pore file in it")
        if where.stat().st_size > 4 * LARGEST and where.is_file():
            size = where.stat().st_size
            raise fail(
                "E028",
                f"`{path}` is too large: {size:,} bytes, where {LARGEST:,} characters are read",
                hint="share definitions with `use`",
            )
        with where.open("rb") as file:
            data = file.read(4 * LARGEST + 1)
    except (FileNotFoundError, ValueError):  # the latter for a NUL in the name
        near = next((p.name for p in where.parent.glob("*.pore") if p.stem.lower() == where.stem.lower()), None)
        raise fail(
            "E105",
            f"there is no file `{path}`",
            hint=f"did you mean `{near}`?" if near else "check the path",
        ) from None
    except OSError as error:
        raise fail(
            "E105", f"`{path}` cannot be read: {error.strerror or error}", hint="check its permissions"
        ) from None
    return _decoded(str(path), data)


def read_standard_input() -> Source:
    """The text that standard input has. Errors: E105, E106, E028, as of a file."""
    try:
        data = sys.stdin.buffer.read(4 * LARGEST + 1) if sys.stdin is not None else None
    except (OSError, ValueError) as error:  # the latter where it was closed
        raise fail("E105", f"standard input cannot be read: {error}", hint="name a .pore file") from None
    if data is None:
        raise fail("E105", "there is no standard input", hint="name a .pore file")
    return _decoded(STANDARD_INPUT, data)


def _decoded(name: str, data: bytes) -> Source:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise fail(
            "E106",
            f"`{name}` is no text: byte {error.start} is not UTF-8",
            hint="save it as UTF-8",
        ) from None
    return Source(name, text)


def find_used(path: str, user: Source) -> Source:
    """The text of `use "path"`, sought beside the file that uses it. Errors: those of `read_source`."""
    return read_source(os.path.normpath(os.path.join(os.path.dirname(user.name), path)))  # one name a file
