"""`pore`: the command line.

Exit status: 0 well; 1 the program or one of its checks is at fault; 2 wrong usage; 3 a missing piece of this machine;
130 interrupted, 129, 131, 143 ended by SIGHUP, SIGQUIT, SIGTERM: nothing is left half-written.

What is imported here is imported before an interruption can be answered: hardly anything.
"""

from __future__ import annotations

import os
import sys

from porelang.cli.interrupts import Ended, ender, interruption, on_signals

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence

INTERRUPTED, PIPE_CLOSED = 130, 141  # 128 + the signal's number, as shells have it


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command line (by default this process's) and give its exit status. Never raises."""
    quiet = not {"-q", "--quiet"}.isdisjoint(sys.argv if argv is None else argv)
    try:
        return _main(argv)
    except Ended as ended:
        return _interrupted(128 + int(ended.args[0]), quiet)
    except KeyboardInterrupt:
        return _interrupted(INTERRUPTED, quiet)
    except Exception:
        if (signal := interruption()) is None:
            raise
        return _interrupted(128 + int(signal.args[0]), quiet)
    finally:
        if argv is None:
            ender.rest()


def _interrupted(status: int, quiet: bool) -> int:
    """Say that a signal has ended it, where there is still somebody to hear that."""
    if not quiet:
        try:
            beside_a_bar = "\r\033[K" if sys.stderr.isatty() else ""
            sys.stderr.write(f"{beside_a_bar}{'interrupted' if status == INTERRUPTED else 'ended'}: nothing is left "
                             "half-written\n")  # fmt: skip
            sys.stderr.flush()
        except (OSError, ValueError, AttributeError):
            pass
    return status


def _main(argv: Sequence[str] | None) -> int:
    # NumPy's linear algebra is not used, and starting its threads costs as much as compiling a program.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if argv is None:  # the process is ours
        ender.resting = False
        on_signals(ender)
        sys.unraisablehook = ender.lost
        if not sys.warnoptions:  # warnings of Python's are for those who write it: ours are diagnostics
            import warnings

            warnings.simplefilter("ignore")
    from porelang.cli.streams import open_streams, silence

    if argv is None:
        open_streams()
    try:
        from porelang.cli.commands import run

        return run(list(sys.argv[1:] if argv is None else argv))
    except BrokenPipeError:
        silence(sys.stdout)
        return PIPE_CLOSED
