"""Whether a program, or a file that it names, was saved."""

from __future__ import annotations

import os

from porelang.stamps import changed, stamps

#: Seconds between two looks at the files.
LOOK = 0.1


class Watched:
    """A program's files, looked at by name: a save that renames is seen like any other.

    A file has to stay the same for one look before it counts as saved: editors write in pieces.
    """

    def __init__(self, path: str) -> None:
        self.path = path
        self._seen = self._before = stamps(path)

    def changed(self) -> bool:
        """Whether something was saved since the last time that this was so."""
        if not changed(self._before):
            if self._before == self._seen or self._before[os.path.abspath(self.path)] is None:
                return False
            self._seen = self._before
            return True
        self._before = stamps(self.path)
        return False
