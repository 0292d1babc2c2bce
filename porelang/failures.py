"""What is said of an error that no diagnostic was made for: what the machine lacks, or that it is ours."""

from __future__ import annotations

import errno
import os
import platform
import sys
import traceback

from porelang.diagnostics import Diagnostic, PoreError
from porelang.limits import is_short_of_memory, no_memory


def failure(error: Exception) -> Diagnostic:
    """E124 for want of memory, E113 for want of room, else E199: a bug of this package. Of a `PoreError` its first."""
    if isinstance(error, PoreError):
        return error.diagnostics[0]
    if is_short_of_memory(error):
        return no_memory()
    known = of_the_system(error) if isinstance(error, OSError) else None
    return known or bug(error)


#: Refusals of the system that no program can help.
_REFUSALS = ("ENOSPC", "EDQUOT", "EFBIG", "EROFS", "EIO", "EBADF", "EMFILE", "ENFILE")


def of_the_system(error: OSError) -> Diagnostic | None:
    """What is said where the system refuses something for want of room; None if the mistake may be ours."""
    if error.errno in {getattr(errno, name, None) for name in _REFUSALS}:
        what = f"`{error.filename}`" if error.filename else "what was asked for"
        reason = (error.strerror or str(error)).lower()
        return Diagnostic("E113", f"cannot write {what}: {reason}", hint="make room, or write somewhere else")
    return None


def bug(error: Exception) -> Diagnostic:
    """What is said of an error that is ours, not the user's."""
    from porelang import __version__

    last = traceback.extract_tb(error.__traceback__)[-1]
    where = f"{os.path.basename(last.filename)}:{last.lineno}"
    return Diagnostic(
        "E199",
        f"this is a bug in porelang, not in your program: {type(error).__name__} at {where}",
        hint=f"please report it with the program and the command (porelang {__version__}, "
        f"Python {platform.python_version()}, {sys.platform}); PORELANG_DEBUG=1 shows more",
    )
