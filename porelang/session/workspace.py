"""The files of a project as they are being edited: texts that are not saved yet stand over those on disk."""

from __future__ import annotations

import os
import threading

from porelang.files import read_source
from porelang.source import Source


class Workspace:
    """Texts by path. An unsaved one wins over the file until it is closed; paths are normalized. Threads may share it.

    >>> workspace = Workspace()
    >>> workspace.open("plate.pore", "let t = 2mm")
    >>> workspace.source("./plate.pore").text
    'let t = 2mm'
    """

    def __init__(self) -> None:
        self._texts: dict[str, str] = {}
        self._lock = threading.Lock()

    def open(self, path: str, text: str) -> None:
        """From now on a file has this text, whatever is on disk."""
        with self._lock:
            self._texts[os.path.normpath(path)] = text

    def close(self, path: str) -> None:
        """From now on a file is what is on disk; one that was not open stays as it is."""
        with self._lock:
            self._texts.pop(os.path.normpath(path), None)

    def source(self, path: str) -> Source:
        """The text of a file as it is now. Errors: E105, E106, E028, as of any file that is read."""
        path = os.path.normpath(path)
        with self._lock:
            text = self._texts.get(path)
        return read_source(path) if text is None else Source(path, text)

    def used(self, path: str, user: Source) -> Source:
        """The text of `use "path"`, sought beside the file that uses it. Errors: those of `source`."""
        return self.source(os.path.join(os.path.dirname(user.name), path))
