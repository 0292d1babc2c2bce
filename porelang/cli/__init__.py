"""`pore`: the command line.

Exit status: 0 well; 1 the program or one of its checks is at fault; 2 wrong usage; 3 a missing piece of this machine;
130 interrupted, 143 ended from outside: nothing is left half-written.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence

INTERRUPTED, PIPE_CLOSED, TERMINATED = 130, 141, 143  # 128 + the signal's number, as shells have it


class _Terminated(KeyboardInterrupt):
    """SIGTERM: like Ctrl-C it leaves nothing half-written."""


def _terminate(number: int, frame: object) -> None:
    raise _Terminated


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command line (by default this process's) and give its exit status. Never raises."""
    # NumPy's linear algebra is not used, and starting its threads costs as much as compiling a program.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if argv is None:  # the process is ours
        signal.signal(signal.SIGTERM, _terminate)
    try:
        from porelang.cli.commands import run

        status = run(list(sys.argv[1:] if argv is None else argv))
        sys.stdout.flush()
        return status
    except _Terminated:
        return TERMINATED
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # Python flushes standard output once more at exit; the reader has gone, so let that go nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PIPE_CLOSED
