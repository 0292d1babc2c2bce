"""The standard streams of a process: closed ones filled, and standard output asked whether it took what was printed."""

from __future__ import annotations

import codecs
import errno
import io
import os
import sys
from typing import Any, TextIO

from porelang.diagnostics import Diagnostic


class _Remembering(io.FileIO):
    """A file that remembers the first refusal to take more: whoever printed may have let it pass, as argparse does."""

    refusal: OSError | None = None

    def write(self, data: Any, /) -> int:
        try:
            return super().write(data) or 0
        except OSError as error:
            self.refusal = self.refusal or error
            raise


def as_it_came(error: UnicodeError) -> tuple[str | bytes, int]:
    """What a stream is given for letters that it cannot encode: bytes of a file's name as they came, else `\\u....`.

    A handler for `codecs.register_error`.
    """
    if not isinstance(error, UnicodeEncodeError):
        raise error
    letter = error.object[error.start]
    if 0xDC80 <= ord(letter) <= 0xDCFF:  # a byte that was no letter, as Python keeps it (PEP 383)
        return bytes([ord(letter) - 0xDC00]), error.start + 1
    return codecs.backslashreplace_errors(UnicodeEncodeError(error.encoding, error.object, error.start,
                                                             error.start + 1, error.reason))  # fmt: skip


codecs.register_error("porelang", as_it_came)


def open_streams() -> None:
    """Make the streams of this process ready to be printed to.

    The places of those that were closed are filled, for else the next file that is opened would take them. Writing to
    a standard output that was closed then fails, as it should; what a closed standard error misses is lost.
    """
    for number, flags in enumerate((os.O_RDONLY, os.O_RDONLY, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, flags)  # the lowest number that is free
    if sys.stderr is None:
        sys.stderr = io.TextIOWrapper(io.FileIO(2, "w", closefd=False), write_through=True)
    encoding = "utf-8" if sys.stdout is None else sys.stdout.encoding
    out = _Remembering(1, "w", closefd=False)
    sys.stdout = io.TextIOWrapper(io.BufferedWriter(out), encoding=encoding, line_buffering=out.isatty())


def unheard() -> Diagnostic | None:
    """What is to be said if standard output did not take what was printed: a full disk, a stream that was closed.

    Raises BrokenPipeError where its reader has gone.
    """
    out = getattr(getattr(sys.stdout, "buffer", None), "raw", None)
    error = None
    if isinstance(out, _Remembering):
        error, out.refusal = out.refusal, None  # it is told once
    try:
        sys.stdout.flush()
    except OSError as failed:
        error = error or failed
    if error is None:
        return None
    silence(sys.stdout)
    if isinstance(error, BrokenPipeError):
        raise error
    reason = "it is closed" if error.errno == errno.EBADF else (error.strerror or str(error)).lower()
    return Diagnostic("E113", f"cannot write to standard output: {reason}",
                      hint="direct it to a file with room: > FILE")  # fmt: skip


def silence(stream: TextIO) -> None:
    """Let what a stream still holds go nowhere: Python flushes it once more at exit, and would complain."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
