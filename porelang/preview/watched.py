"""Whether a program, or a file that it names, was saved."""

from __future__ import annotations

import os

from porelang.stamps import changed, stamps

#: Seconds between two looks at the files.
LOOK = 0.1
#: Looks at which the program has to be missing before it counts as gone.
PATIENCE = 4


class Watched:
    """A program's files, looked at by name: a save that renames is seen like any other.

    A file has to stay the same for one look before it counts as saved: editors write in pieces.
    """

    def __init__(self, path: str) -> None:
        self.path = path
        self._seen = self._before = stamps(path)
        self._missed = 0

    def gone(self) -> str:
        """Why the program cannot be read any more, or "". A save that renames has a moment without the file."""
        self._missed = 0 if os.access(self.path, os.R_OK) else self._missed + 1
        if self._missed < PATIENCE:
            return ""
        return "cannot be read any more" if os.path.exists(self.path) else "is no longer there"

    def changed(self) -> bool:
        """Whether something was saved since the last time that this was so."""
        if not changed(self._before):
            if self._before == self._seen or self._before[os.path.abspath(self.path)] is None:
                return False
            self._seen = self._before
            return True
        self._before = stamps(self.path)
        return False
