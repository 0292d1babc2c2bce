"""The text of a page's program: as it is on disk, as it is being written, and what to do where these differ."""

from __future__ import annotations

import os

from porelang.atomic import replace_file
from porelang.files import read_source
from porelang.session import Session, Snapshot
from porelang.source import Source
from porelang.syntax.format import formatted


class Document:
    """A file of a session. `disk` is its text when it was last read or written here."""

    def __init__(self, session: Session, path: str) -> None:
        self.session, self.path = session, os.path.normpath(path)
        self.disk = ""
        self.text = ""

    @property
    def dirty(self) -> bool:
        """Whether what is written is not on disk."""
        return self.text != self.disk

    def read(self) -> Snapshot:
        """The file as it is on disk now, whatever was written here. Errors: E105, E106, E028."""
        self.disk = self.text = read_source(self.path).text
        self.session.workspace.close(self.path)
        return self.session.update(self.path)

    def changed_on_disk(self) -> bool:
        """Whether another program has written the file since. Errors: those of reading it."""
        return read_source(self.path).text != self.disk

    def edit(self, text: str) -> Snapshot:
        """The program has this text now, and the file stays as it is."""
        self.text = text
        return self.session.update(self.path, text)

    def write(self, text: str, over: bool = False) -> bool:
        """Save a text. False, and nothing is done, where the file was changed by another program, unless `over`.

        Errors: E113 where it cannot be written."""
        if not over and os.path.exists(self.path) and self.changed_on_disk():
            return False
        with replace_file(self.path) as file:
            file.write(text.encode())
        self.disk = text
        self.edit(text)
        return True

    def styled(self, text: str) -> str:
        """A text in the one style. Errors: what is wrong in its syntax."""
        return formatted(Source(self.path, text))
