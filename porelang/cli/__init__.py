"""`pore`: the command line.

Exit status: 0 well; 1 the program or one of its checks is at fault; 2 wrong usage; 3 a missing piece of this machine.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

INTERRUPTED, PIPE_CLOSED = 130, 141  # 128 + the signal's number, as shells have it


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command line (by default this process's) and give its exit status. Never raises."""
    # NumPy's linear algebra is not used, and starting its threads costs as much as compiling a program.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        from porelang.cli.commands import run

        status = run(list(sys.argv[1:] if argv is None else argv))
        sys.stdout.flush()
        return status
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # Python flushes standard output once more at exit; the reader has gone, so let that go nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PIPE_CLOSED
