"""A session: files that are edited, and what is known of each after every edit."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Hashable, Mapping
from types import MappingProxyType
from typing import TypeVar

from porelang.compiler import Memory, compiled
from porelang.elaborate.context import Bound
from porelang.progress import Report
from porelang.session.jobs import Job, Jobs
from porelang.session.snapshot import Snapshot
from porelang.session.workspace import Workspace

T = TypeVar("T")


class Session:
    """Programs that are being written. Threads may share it; of one file they take turns.

    Relative paths of data begin in `folder`, the current one unless told otherwise. `bound` are params that have data.

    >>> session = Session()
    >>> broken = session.update("part.pore", "gyroid(10) & cube(")
    >>> [d.code for d in broken.diagnostics], broken.good
    (['E005'], None)
    >>> session.update("part.pore", "gyroid(10) & cube(20)").program
    <program part.pore: part>
    """

    def __init__(
        self,
        workspace: Workspace | None = None,
        folder: str | None = None,
        bound: Mapping[str, Bound] = MappingProxyType({}),
    ) -> None:
        self.workspace = workspace or Workspace()
        self.jobs = Jobs()
        self._folder = os.getcwd() if folder is None else folder
        self._bound = bound
        self._memories: dict[str, Memory] = {}
        self._snapshots: dict[str, Snapshot] = {}
        self._locks: dict[str, threading.RLock] = {}
        self._lock = threading.Lock()

    def update(self, path: str, text: str | None = None) -> Snapshot:
        """A file has this text now, saved or not; without one, what the workspace has. Its snapshot: what compiling it
        afresh would find, at the cost of what was changed.

        Errors: E105, E106, E028 where there is no text of it.
        """
        path = os.path.normpath(path)
        if text is not None:
            self.workspace.open(path, text)
        with self._lock:
            lock = self._locks.setdefault(path, threading.RLock())
        with lock:
            source = self.workspace.source(path)
            memory = self._memories.setdefault(path, Memory())
            made = compiled(source, self.workspace.used, self._folder, self._bound, memory)
            before = self._snapshots.get(path)
            version = 1 if before is None else before.version + 1
            good = made.program
            if before is not None and before.good is not None and (good is None or not good.outputs):
                good = before.good
            snapshot = self._snapshots[path] = Snapshot(path, version, made, good)
            return snapshot

    def snapshot(self, path: str) -> Snapshot | None:
        """The last snapshot of a file; None where it was never updated."""
        return self._snapshots.get(os.path.normpath(path))

    def users(self, path: str) -> list[str]:
        """The files of the session that use a file, also through others: they want an update when it was changed."""
        path = os.path.normpath(path)
        return [
            name
            for name, snapshot in list(self._snapshots.items())
            if any(used.name == path for used in snapshot.compiled.used.values())
        ]

    def forget(self, path: str) -> None:
        """A file is no longer edited here: its unsaved text and what is known of it are dropped."""
        path = os.path.normpath(path)
        self.workspace.close(path)
        with self._lock:
            self._memories.pop(path, None)
            self._snapshots.pop(path, None)

    def submit(self, purpose: Hashable, work: Callable[[], T], report: Report | None = None) -> Job[T]:
        """Begin work in the background; the latest of a purpose wins. See `Jobs.submit`."""
        return self.jobs.submit(purpose, work, report)
