"""What the commands say, and where: diagnostics and progress to standard error, results to standard output."""

from __future__ import annotations

import json
import os
import re
import sys
import time
from collections.abc import Iterable
from typing import Any, TextIO

from porelang.cli.streams import silence
from porelang.diagnostics import Diagnostic, render
from porelang.progress import Report

#: Wrong usage, wherever it is found: the request does not fit the program, or its files are not there.
_USAGE = frozenset({"E088", "E100", "E104", "E105", "E107", "E108", "E112", "E113", "E114", "E117", "E123", "E179"})
#: A piece of this machine that is missing.
_MISSING = frozenset({"E163"})
_SETTINGS = frozenset({"E083", "E084", "E085"})
_BOLD, _RED, _YELLOW, _BLUE, _CYAN, _END = "\033[1m", "\033[1;31m", "\033[1;33m", "\033[1;34m", "\033[36m", "\033[0m"
_SHADES = {"error": _RED, "warning": _YELLOW, "note": _CYAN}


def status(found: Iterable[Diagnostic]) -> int:
    """The exit status that diagnostics call for."""
    errors = [d for d in found if d.severity == "error"]
    if not errors:
        return 0
    if all((d.code.startswith("E12") and d.code not in _USAGE) or d.code in _MISSING for d in errors):
        return 3
    if all(d.code in _SETTINGS or (d.code in _USAGE and d.span is None) for d in errors):
        return 2
    return 1


def say(found: Iterable[Diagnostic]) -> None:
    """Write diagnostics to standard error, in colour on a terminal."""
    coloured = has_colours(sys.stderr)
    for d in found:
        text = render(d)
        tell(colour(text) if coloured else text, end="\n" if d.severity == "note" else "\n\n")


def note(text: str) -> None:
    """A line to standard error."""
    tell(text)


def tell(text: str, end: str = "\n") -> None:
    """A text to standard error. That it is full, or a terminal that was closed, changes nothing: the status tells."""
    try:
        print(text, end=end, file=sys.stderr, flush=True)
    except BrokenPipeError:
        raise
    except OSError:
        silence(sys.stderr)


def put(value: Any) -> None:
    """The result as one JSON value on standard output; what is no finite number is null, as JSON has no other word."""
    print(json.dumps(finite(value), indent=2))


def halved(many: int, finest: float) -> str:
    """How many cubes were halved at rims, and how large (mm) the smallest are."""
    return f"{many:,} {'cube' if many == 1 else 'cubes'} halved at rims, to {finest:.3g} mm"


def finite(value: Any) -> Any:
    """A value with None for what is no finite number."""
    match value:
        case float():
            return value if value - value == 0 else None
        case dict():
            return {k: finite(v) for k, v in value.items()}
        case list() | tuple():
            return [finite(v) for v in value]
    return value


def colour(text: str) -> str:
    """The text of a diagnostic with the escape sequences of a terminal."""
    head, *rest = text.split("\n")
    severity = _SHADES[head.partition("[")[0].partition(":")[0]]
    word, _, message = head.partition(": ")
    lines = [f"{severity}{word}{_END}: {_BOLD}{message}{_END}"]
    for line in rest:
        if match := re.match(r"( *)(-->)(.*)", line):
            lines.append(f"{match[1]}{_BLUE}-->{_END}{match[3]}")
        elif match := re.match(r"( +\| *)([\^-]+.*)", line):
            lines.append(f"{match[1]}{severity if match[2][0] == '^' else _BLUE}{match[2]}{_END}")
        elif match := re.match(r"( *= hint: )(.*)", line):
            lines.append(f"{match[1]}{_CYAN}{match[2]}{_END}")
        else:
            lines.append(line)
    return "\n".join(lines)


def has_colours(stream: TextIO) -> bool:
    """Whether a stream goes to a terminal that has colours, and nobody has asked for none."""
    return stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


#: What nobody can tell the end of: its time is shown, not its share.
_ENDLESS = frozenset({"finding numbers from fields", "meshing with fTetWild", "working"})
_SOON, _OFTEN = 0.5, 0.1  # seconds: until something is said, and between two looks


def progress(quiet: bool) -> Report | None:
    """What is under way and how far it is, on standard error, once it takes a while; None where nobody watches."""
    if quiet or not sys.stderr.isatty():
        return None
    at, start, last = "", 0.0, 0.0

    def show(activity: str, done: int, total: int) -> None:
        nonlocal at, start, last
        now = time.monotonic()
        if done >= total:
            if last:
                tell("\r\033[K", end="")
            at, last = "", 0.0
            return
        if activity != at:
            at, start = activity, now
        if now - start < _SOON or now - last < _OFTEN:
            return
        last = now
        filled = 30 * done // max(total, 1)
        bar = f"[{'#' * filled}{' ' * (30 - filled)}] {100 * done // max(total, 1):3d} %"
        how_far = f"{now - start:.0f} s (Ctrl-C ends it)" if activity in _ENDLESS else bar
        tell(f"\r\033[K{activity}: {how_far}", end="")

    return show


def plural(count: int, thing: str) -> str:
    """`1 warning`, `2 warnings`, `no errors`."""
    return f"{count or 'no'} {thing}{'' if count == 1 else 's'}"
