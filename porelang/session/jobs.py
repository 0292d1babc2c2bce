"""Work in the background of which the latest wins: a picture of the part as it is now, a mesh, the doubts of a text."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from contextvars import copy_context
from typing import Any, Generic, TypeVar

from porelang.progress import Report, checkpoint, watching

T = TypeVar("T")


class Job(Generic[T]):
    """One piece of work. It ends well, with an error, or cancelled; whoever asks for its result waits for that."""

    def __init__(self, work: Callable[[], T], report: Report | None) -> None:
        self._work, self._report = work, report
        self._cancelled, self._ended = threading.Event(), threading.Event()
        self._found: T | None = None
        self._error: BaseException | None = None

    def cancel(self) -> None:
        """It is no longer wanted: it ends at the next place where it says how far it is, or does not begin."""
        self._cancelled.set()

    @property
    def done(self) -> bool:
        """Whether it has ended, in whatever way."""
        return self._ended.is_set()

    @property
    def cancelled(self) -> bool:
        """Whether it is no longer wanted."""
        return self._cancelled.is_set()

    def result(self, timeout: float | None = None) -> T:
        """What it found. Errors: its own; CancelledError; TimeoutError after so many seconds."""
        if not self._ended.wait(timeout):
            raise TimeoutError
        if self._error is not None:
            raise self._error
        return self._found  # type: ignore[return-value]  # it ended well

    def run(self) -> None:
        """Do it here; what goes wrong is kept for who asks for the result."""
        try:
            with watching(self._report, self._cancelled.is_set):
                checkpoint()
                self._found = self._work()
        except BaseException as error:
            self._error = error
        finally:
            self._ended.set()


class Jobs:
    """Work by what it is for: each purpose has one job at a time, and a new one takes the place of the last.

    The last is cancelled, and the new one begins when it has ended: so two never work for the same purpose side by
    side. One that is superseded before it has begun never begins.
    """

    def __init__(self) -> None:
        self._latest: dict[Hashable, Job[Any]] = {}
        self._lock = threading.Lock()

    def submit(self, purpose: Hashable, work: Callable[[], T], report: Report | None = None) -> Job[T]:
        """Begin work; what was asked for the same purpose before is cancelled. `report` is told how far it is, from the
        thread that works."""
        job: Job[T] = Job(work, report)
        with self._lock:
            before = self._latest.get(purpose)
            self._latest[purpose] = job
        if before is not None:
            before.cancel()
        context = copy_context()
        threading.Thread(target=context.run, args=(self._after, before, job), daemon=True).start()
        return job

    def _after(self, before: Job[Any] | None, job: Job[Any]) -> None:
        if before is not None:
            before._ended.wait()
        job.run()

    def cancel(self, purpose: Hashable | None = None) -> None:
        """What is being done for a purpose, or at all, is no longer wanted."""
        with self._lock:
            jobs = list(self._latest.values()) if purpose is None else [self._latest.get(purpose)]
        for job in jobs:
            if job is not None:
                job.cancel()
