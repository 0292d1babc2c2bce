"""The program that a command is about."""

from __future__ import annotations

from argparse import Namespace

from porelang.cli import report
from porelang.compiler import try_compile
from porelang.diagnostics import Diagnostic, PoreError, fail
from porelang.files import read_source, read_standard_input
from porelang.program import Design, Program
from porelang.settings import off_step
from porelang.source import Source


def source_of(options: Namespace) -> Source:
    """The text of the program that a command names; `-` is standard input. Errors: those of reading."""
    return read_standard_input() if options.file == "-" else read_source(options.file)


def data_of(options: Namespace) -> dict[str, tuple[str, ...]]:
    """The params that a command binds to arrays of files. Errors: E155 where one is bound twice."""
    bound: dict[str, tuple[str, ...]] = {}
    for name, file, array, how in options.bindings:
        found = ("load", file, array, how)
        if bound.setdefault(name, found) != found:
            raise fail("E155", f"`{name}` is bound twice", hint="leave one of the two out")
    return bound


def load(options: Namespace) -> Program:
    """The program of a command, its warnings said, and kept as `options.doubts` for `--json`. Errors: all that is wrong
    with it."""
    program, found = try_compile(source_of(options), bound=data_of(options))
    if program is None:
        raise PoreError(found)
    options.doubts = []
    named = {getattr(options, option, None) for option in ("within", "field", "size")}
    _say(options, [d for d in found if d.code != "W220" or d.span is None or d.span.text not in named])
    return program


def bound(options: Namespace) -> Design:
    """The program of a command with its settings and its preset bound. Errors: all that is wrong with either."""
    program = load(options)
    design = program.design(dict(options.settings), preset=options.preset)
    told = {d.told for d in program.warnings}
    _say(options, [d for d in design.program.warnings if d.told not in told])
    _say(options, off_step(program.params, design.settings))
    return design


def _say(options: Namespace, found: list[Diagnostic]) -> None:
    """Say what is doubtful about a program, and keep it: what is said on standard error is in `--json` too."""
    options.doubts += found
    if not getattr(options, "quiet", False):
        report.say(found)
