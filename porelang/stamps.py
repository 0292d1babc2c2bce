"""Whether files were saved: what tells one state of a file from another, looked at by name.

So a save that renames, a file that appears only later and a folder on another machine are seen like any other. Whatever
stands in quotes in a program may be the name of a file: programs that are broken say so too, and one name too many
costs nothing.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Sequence

_QUOTED = re.compile(r'"([^"\n]{1,1000})"')
#: What tells one state of a file from another, or None where there is none.
Stamp = tuple[int, ...] | None


def stamps(program: str, named: Sequence[str] = ()) -> dict[str, Stamp]:
    """What is to be watched with its stamps: a program, what it names in quotes, what its used files name, and more.

    Used files are sought beside the file that uses them, and data from the current folder, as the compiler does.
    """
    found: dict[str, Stamp] = {}
    waiting = [os.path.abspath(program)]
    while waiting:
        path = waiting.pop()
        if path in found:
            continue
        found[path] = stamp(path)  # before it is read, or a save in between would be missed
        if found[path] is None or not (path.endswith(".pore") or len(found) == 1):
            continue
        try:
            with open(path, encoding="utf-8", errors="replace") as text:
                names = _QUOTED.findall(text.read(4_000_000))
        except OSError:
            continue
        for name in names:
            if name.endswith(".pore"):
                waiting.append(os.path.normpath(os.path.join(os.path.dirname(path), name)))
            elif os.path.splitext(name)[1]:
                waiting.append(os.path.abspath(name))
    return found | {os.path.abspath(name): stamp(name) for name in named}


def stamp(path: str) -> Stamp:
    """What changes when a file is written anew or replaced; None for what is no file."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return None
    return (found.st_mtime_ns, found.st_size, found.st_ino) if stat.S_ISREG(found.st_mode) else None


def changed(seen: dict[str, Stamp]) -> bool:
    """Whether any of the files is not as it was."""
    return any(stamp(path) != before for path, before in seen.items())
