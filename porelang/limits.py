"""What this process may use of the machine, as far as somebody has limited it."""

from __future__ import annotations

import errno

from porelang.diagnostics import Diagnostic


def memory_limit() -> int | None:
    """The bytes of memory that this process may ask for (`ulimit -v`); None where nobody has set a limit."""
    try:
        import resource
    except ImportError:  # Windows
        return None
    limits = [resource.getrlimit(kind)[0] for kind in (resource.RLIMIT_AS, resource.RLIMIT_DATA)]
    found = [limit for limit in limits if limit != resource.RLIM_INFINITY]
    return min(found) if found else None


def no_memory() -> Diagnostic:
    """What is said where memory is short: E124, with the limit that was set for this process, if there is one."""
    hint = "use a larger --voxel, smaller --bounds or fewer points"
    limit = memory_limit()
    if limit is None:
        return Diagnostic("E124", "this machine has not enough memory for that", hint=hint)
    message = f"this process may use {limit / 1e6:,.0f} MB of memory, which is not enough for that"
    return Diagnostic("E124", message, hint=f"{hint}; or raise the limit, as with `ulimit -v unlimited`")


def is_short_of_memory(error: BaseException) -> bool:
    """Whether an error is want of memory in other words: of a thread that cannot be started, of a module's code."""
    cause: BaseException | None = error
    while cause is not None:  # a library may tell it in words of its own
        if isinstance(cause, MemoryError) or (isinstance(cause, OSError) and cause.errno == errno.ENOMEM):
            return True
        if isinstance(cause, ImportError | RuntimeError | OSError) and speaks_of_memory(str(cause)):
            return True
        cause = cause.__cause__ or cause.__context__
    return False


def speaks_of_memory(said: str) -> bool:
    """Whether what a library or another process said of its end is want of memory."""
    return any(word in said.lower() for word in _WORDS)


_WORDS = ("allocate memory", "failed to map segment", "start new thread", "memoryerror", "bad_alloc", "out of memory")
