"""The commands: each takes the parsed options and gives an exit status."""

from __future__ import annotations

import os
import sys
import traceback
import warnings
from argparse import Namespace
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout, suppress
from importlib import import_module

from porelang.cli import report
from porelang.cli.interrupts import interruption
from porelang.cli.parsing import parse
from porelang.cli.streams import unheard
from porelang.diagnostics import Diagnostic, PoreError, PoreWarning
from porelang.failures import failure
from porelang.limits import is_short_of_memory
from porelang.progress import on_compiling, watching

Command = Callable[[Namespace], int]
#: Where each command is: imported when it is asked for, so that none waits for what another needs.
RUN: dict[str, str] = {
    "check": "checking.check",
    "mesh": "meshing.mesh",
    "measure": "measuring.measure",
    "fea": "strength.fea",
    "optimize": "optimizing.optimize",
    "slices": "slicing.slices",
    "volume": "volumes.volume",
    "tet": "tetrahedra.tet",
    "homogenize": "homogenizing.homogenize",
    "eval": "evaluate.evaluate",
    "show": "showing.show",
    "glsl": "showing.glsl",
    "notation": "showing.notation",
    "render": "render.render",
    "view": "viewing.view",
    "watch": "watching.watch",
    "new": "starting.new",
    "examples": "starting.examples",
    "fmt": "formatting.fmt",
    "repl": "talking.repl",
    "lsp": "serving.lsp",
    "completion": "completing.completion",
    "explain": "explain.explain",
    "cache": "caching.cache",
    "doctor": "examining.doctor",
    "conformance": "examining.conformance",
}


def command_of(name: str) -> Command:
    """What carries out a command; without one, what says which there are."""
    if name not in RUN:
        return usage
    module, _, function = RUN[name].partition(".")
    found: Command = getattr(import_module(f"porelang.cli.{module}"), function)
    return found


def run(argv: Sequence[str]) -> int:
    """Run a command line; whatever goes wrong is said as a diagnostic."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="porelang")
    status = _run(argv)
    if (lost := unheard()) is not None:
        report.say([lost])
        return status or report.status([lost])
    return status


def _run(argv: Sequence[str]) -> int:
    command = ""
    try:
        options = parse(argv)
        command = options.command or "help"
        quiet = getattr(options, "quiet", False)
        if not quiet:
            on_compiling(_compiling)
        with watching(report.progress(quiet)), warnings.catch_warnings():
            warnings.simplefilter("ignore", PoreWarning)  # commands say what is doubtful themselves
            return command_of(command)(options)
    except PoreError as error:
        found = list(error.diagnostics)
    except SystemExit as asked:  # argparse has printed help or the version
        return int(asked.code or 0)
    except (KeyboardInterrupt, BrokenPipeError):
        raise
    except Exception as error:
        if (ended := interruption()) is not None:
            raise ended from None
        if not is_short_of_memory(error) and isinstance(error, OSError) and (lost := unheard()) is not None:
            report.say([lost])
            return report.status([lost])
        found = [failure(error)]
        if found[0].code == "E199" and os.environ.get("PORELANG_DEBUG"):
            traceback.print_exc()
    return rejected(found, command, "--json" in argv)


def _compiling(kept: bool) -> None:
    if kept:
        report.note("compiling loops, once after an installation: this takes some seconds")
    else:
        report.note("compiling loops, which takes half a minute, in every run: no folder here can keep them; "
                    "PORELANG_CACHE names one")  # fmt: skip


def rejected(found: list[Diagnostic], command: str, as_json: bool) -> int:
    """Say why a command could not be carried out; with --json on standard output too."""
    report.say(found)
    if as_json:
        listed = [d.to_json() for d in found]
        report.put(listed if command == "check" else {"errors": listed})
    return report.status(found)


def usage(options: Namespace) -> int:
    """`pore` alone says what it can do, and that this was no command."""
    with suppress(SystemExit), redirect_stdout(sys.stderr):
        parse(["--help"])
    return 2
