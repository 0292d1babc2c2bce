"""Signals that end the process: each raises `Ended` once, wherever it comes, and none is lost.

What is imported here is imported before an interruption can be answered: hardly anything.
"""

from __future__ import annotations

import sys
import time

#: What a terminal, a job scheduler or a supervisor ends a process with.
_ENDINGS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGXCPU")
#: Seconds after a signal in which others are taken for the same wish, so that cleaning up is not interrupted.
_SAME_WISH = 1.0


class Ended(KeyboardInterrupt):
    """A signal that ends the process: like Ctrl-C it leaves nothing half-written. Its argument is the number."""


class Ender:
    """Raises `Ended` at a signal, and not again for those that follow at once. `number` is that of the last one."""

    def __init__(self) -> None:
        self.last = -_SAME_WISH
        self.number: int | None = None
        self.resting = False

    def __call__(self, number: int, frame: object) -> None:
        now = time.monotonic()
        if now - self.last >= _SAME_WISH and not self.resting:
            self.last, self.number = now, number
            raise Ended(number)

    def lost(self, unraisable: sys.UnraisableHookArgs) -> None:
        """Raise it again in a moment if it fell into a callback of Python's own, which lets no exception out. What else
        goes wrong in one after a signal is of objects that this left half made, and is no news."""
        import signal

        ended = unraisable.exc_value
        if not isinstance(ended, Ended) or not hasattr(signal, "setitimer"):
            if self.number is None:
                sys.__unraisablehook__(unraisable)
            return
        self.last = -_SAME_WISH
        signal.signal(signal.SIGALRM, lambda _, frame: self(ended.args[0], frame))
        signal.setitimer(signal.ITIMER_REAL, 0.01)

    def rest(self) -> None:
        """Raise nothing from now on: what is left to do is to end."""
        self.resting = True
        import signal

        if hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_REAL, 0)  # an alarm that Python no longer answers would kill it


ender = Ender()


def interruption() -> Ended | None:
    """The signal that has come. One that falls into an import ends in whatever error the import makes of it."""
    return None if ender.number is None else Ended(ender.number)


def on_signals(answer: object) -> None:
    """Have a function answer the signals that end processes, but for those that this one was started to ignore."""
    import signal

    for name in _ENDINGS:
        number = getattr(signal, name, None)  # Windows has few of them
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, answer)  # type: ignore[arg-type]  # to name its type takes an import
