"""`pore cache`: what tasks have left on disk, and clearing it."""

from __future__ import annotations

import os
from argparse import Namespace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from porelang import store
from porelang.cli import report
from porelang.diagnostics import fail


def cache(options: Namespace) -> int:
    """List what is kept, say its size, or clear it. Errors: E108 for a limit in the environment that is no size."""
    if options.action == "clear":
        return _cleared(options)
    try:
        found = store.usage()
    except ValueError as error:
        raise fail("E108", str(error), hint="write 500MB or 2GB; 0 keeps nothing on disk") from None
    if found.refusal:
        report.note(f"nothing is kept on disk: {found.refusal}")
    if options.json:
        report.put(_listed(found) if options.action == "list" else _sized(found))
        return 0
    if options.action == "list":
        for e in found.entries:
            print(f"{size(e.bytes):>9}  {_time(e.used, local=True)}  {e.kind:<13}  {e.label or e.key[:16]}")
        if options.quiet:
            return 0
    where = f" in {_short(found.folder)}" if found.folder is not None else ""
    said = f"{report.plural(len(found.entries), 'result')}, {size(found.total)} of {size(found.limit)}{where}"
    if found.loops:
        said += f"; {size(found.loops)} of compiled loops"
    if found.left:
        said += f"; {size(found.left)} left by runs that were killed: `pore cache clear` deletes them"
    if options.action == "list":
        report.note(said)
    else:
        print(said)
    return 0


def size(count: int) -> str:
    """Bytes as people write them: `0 B`, `1.5 kB`, `2 GB`."""
    value, unit = float(count), "B"
    for larger in ("kB", "MB", "GB", "TB"):
        if value < 999.5:
            break
        value, unit = value / 1000, larger
    return f"{value:.3g} {unit}"


def _cleared(options: Namespace) -> int:
    freed = store.clear()
    if options.json:
        report.put({"freed": freed})
    elif not options.quiet:
        print(f"{size(freed)} freed")
    return 0


def _sized(found: store.Usage) -> dict[str, Any]:
    folder = None if found.folder is None else str(found.folder)
    return {"folder": folder, "results": len(found.entries), "bytes": found.total, "limit": found.limit,
            "loops": found.loops, "left": found.left}  # fmt: skip


def _listed(found: store.Usage) -> dict[str, Any]:
    entries = [
        {"key": e.key, "kind": e.kind, "bytes": e.bytes, "used": _time(e.used), "label": e.label} for e in found.entries
    ]
    return {**_sized(found), "entries": entries}


def _time(seconds: float, local: bool = False) -> str:
    """A moment: for programs in UTC by ISO 8601, for people in their own time to the minute."""
    try:
        moment = datetime.fromtimestamp(seconds, UTC)
        return moment.astimezone().strftime("%Y-%m-%d %H:%M") if local else moment.isoformat(timespec="seconds")
    except (OverflowError, ValueError, OSError):  # a file whose time was set to no date
        return "-"


def _short(path: Path) -> str:
    """A path with `~` for the user's home."""
    try:
        return f"~{os.sep}{path.relative_to(Path.home())}"
    except (ValueError, RuntimeError):
        return str(path)
