"""`pore`: the command line.

Exit status: 0 well; 1 the program or one of its checks is at fault; 2 wrong usage; 3 a missing piece of this machine;
130 interrupted, 129, 131, 143 ended by SIGHUP, SIGQUIT, SIGTERM: nothing is left half-written.

What is imported here is imported before an interruption can be answered: hardly anything.
"""

from __future__ import annotations

import os
import sys
import time

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence

INTERRUPTED, PIPE_CLOSED = 130, 141  # 128 + the signal's number, as shells have it
#: What a terminal, a job scheduler or a supervisor ends a process with.
_ENDINGS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGXCPU")
#: Seconds after a signal in which others are taken for the same wish, so that cleaning up is not interrupted.
_SAME_WISH = 1.0


class _Ended(KeyboardInterrupt):
    """A signal that ends the process: like Ctrl-C it leaves nothing half-written. Its argument is the number."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command line (by default this process's) and give its exit status. Never raises."""
    try:
        return _main(argv)
    except _Ended as ended:
        return 128 + int(ended.args[0])
    except KeyboardInterrupt:
        return INTERRUPTED
    finally:
        if argv is None:  # what is left to do is to end
            _on_signals(lambda number, frame: None)


def _main(argv: Sequence[str] | None) -> int:
    # NumPy's linear algebra is not used, and starting its threads costs as much as compiling a program.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if argv is None:  # the process is ours
        ender = _Ender()
        _on_signals(ender)
        sys.unraisablehook = ender.lost
    from porelang.cli.streams import open_streams, silence

    if argv is None:
        open_streams()
    try:
        from porelang.cli.commands import run

        return run(list(sys.argv[1:] if argv is None else argv))
    except BrokenPipeError:
        silence(sys.stdout)
        return PIPE_CLOSED


class _Ender:
    """Raises `_Ended` at a signal, and not again for those that follow at once."""

    def __init__(self) -> None:
        self.last = -_SAME_WISH

    def __call__(self, number: int, frame: object) -> None:
        now = time.monotonic()
        if now - self.last >= _SAME_WISH:
            self.last = now
            raise _Ended(number)

    def lost(self, unraisable: sys.UnraisableHookArgs) -> None:
        """Raise it again in a moment if it fell into a callback of Python's own, which lets no exception out."""
        import signal

        ended = unraisable.exc_value
        if not isinstance(ended, _Ended) or not hasattr(signal, "setitimer"):
            sys.__unraisablehook__(unraisable)
            return
        self.last = -_SAME_WISH
        signal.signal(signal.SIGALRM, lambda _, frame: self(ended.args[0], frame))
        signal.setitimer(signal.ITIMER_REAL, 0.01)


def _on_signals(answer: object) -> None:
    """Have a function answer the signals that end processes, but for those that this one was started to ignore."""
    import signal

    for name in _ENDINGS:
        number = getattr(signal, name, None)  # Windows has few of them
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, answer)  # type: ignore[arg-type]
