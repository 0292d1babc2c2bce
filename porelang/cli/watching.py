"""`pore watch`: a command carried out again at every save of a program, or of a file that it names.

Files are looked at ten times a second by their names. So a save that renames, a file that appears only later and a
folder on another machine are seen like any other, and no package is needed (docs/decisions/0001). Whatever stands in
quotes may be the name of a file: programs that are broken say so too, and one name too many costs nothing.

The command runs in a process of its own, one at a time: a save while it runs ends it, and it leaves nothing behind.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from argparse import Namespace
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial

from porelang.cli import report
from porelang.cli.arguments import COMMANDS
from porelang.cli.parsing import parse
from porelang.diagnostics import fail
from porelang.files import read_source
from porelang.stamps import Stamp, changed, stamps

#: Seconds between two looks; a file has to stay the same for one before it counts as written.
LOOK = 0.1
#: Looks until a program that was renamed or removed is taken to be gone.
PATIENCE = 15
#: Seconds that a run has to end in, once it is asked to.
ENDING = 10.0


def watch(options: Namespace) -> int:
    """Carry out a command now and at every save, until a signal ends it. Errors: E105, E108 before anything runs."""
    argv = command_line(options.file, options.words)
    chosen = parse(argv)
    if getattr(chosen, "points", None) == "-":
        raise fail("E108", "standard input can be read only once", hint="write the points to a file, and name that")
    if options.file == "-":
        raise fail("E108", "standard input is no file that is saved", hint="name the .pore file to watch")
    read_source(options.file)  # a slip of the name is told, not waited for
    named = [chosen.points] if getattr(chosen, "points", None) else []
    named += [file for _, file, *_ in getattr(chosen, "bindings", [])]
    written = os.path.abspath(chosen.output) if getattr(chosen, "output", None) else ""

    def look() -> dict[str, Stamp]:
        found = stamps(options.file, named)
        found.pop(written, None)
        return found

    seen = look()
    more = len(seen) - 1
    others = f" and {report.plural(more, 'file')} that it names" if more else ""
    report.note(f"pore {' '.join(argv)}: at every save of {options.file}{others}; Ctrl-C ends it\n")
    while True:
        begun = time.monotonic()
        status = run([sys.executable, "-P", "-m", "porelang", *argv], partial(changed, seen))
        seconds = time.monotonic() - begun
        if status is None:
            report.note(f"{clock()} saved after {seconds:.1f} s: begun anew\n")
        else:
            how = "well" if status == 0 else f"exit status {status}"
            report.note(f"{clock()} {options.file}: {how}, {seconds:.1f} s\n")
        while status is not None and not changed(seen):
            time.sleep(LOOK)
        seen = settled(look, os.path.abspath(options.file))


def command_line(file: str, words: Sequence[str]) -> list[str]:
    """The command line that is carried out: `mesh -o a.stl` about a file; `check` where none is named. Errors: E108."""
    name, *rest = words or ["check"]
    about_files = [c.name for c in COMMANDS.values() if "file" in c.options and c.name != "watch"]
    if name not in about_files:
        raise fail("E108", f"`pore watch` cannot carry out `{name}`",
                   hint=f"write `{COMMANDS['watch'].example}`; the commands are {', '.join(about_files)}")  # fmt: skip
    return [name, *rest] if file in rest else [name, file, *rest]


def settled(look: Callable[[], dict[str, Stamp]], program: str) -> dict[str, Stamp]:
    """The stamps once nothing changes any more: an editor writes in pieces, or moves the old file away first."""
    before, seen = None, look()
    for _ in range(PATIENCE):
        if seen == before and seen[program] is not None:
            break
        time.sleep(LOOK)
        before, seen = seen, look()
    return seen


def run(argv: Sequence[str], stop: Callable[[], bool]) -> int | None:
    """The exit status of a process; None where `stop` asked for its end. It is ended too where we are."""
    process = subprocess.Popen(argv, stdin=subprocess.DEVNULL)
    try:
        while not stop():
            with suppress(subprocess.TimeoutExpired):
                return process.wait(LOOK)
        return None
    finally:
        end(process)


def end(process: subprocess.Popen[bytes]) -> None:
    """Have a process clean up and end; one that does not is killed."""
    if process.poll() is not None:
        return
    process.terminate()
    try:
        process.wait(ENDING)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def clock() -> str:
    return time.strftime("%H:%M:%S")
