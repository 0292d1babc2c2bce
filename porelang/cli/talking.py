"""`pore repl`: a program a line at a time, at a terminal or through a pipe."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Iterator
from functools import partial

from porelang.cli import report
from porelang.files import read_source
from porelang.repl.loop import Read, talk
from porelang.repl.state import State, goes_on, said
from porelang.repl.view import View
from porelang.session import Session


def repl(options: Namespace) -> int:
    """Read lines and answer them. Of a file that is named its statements are there already; its part is `part`. Exit
    status 1 where a line of a pipe was wrong."""
    at_terminal = sys.stdin is not None and sys.stdin.isatty()
    with View(browse=at_terminal) as page:
        return _talk(options, State(Session(), colours=report.has_colours(sys.stdout), page=page), at_terminal)


def _talk(options: Namespace, state: State, at_terminal: bool) -> int:
    if options.file is not None:
        source = read_source(options.file)
        found = said(state, source.text, part=True)
        report.say(found.diagnostics)
        state = found.state
    program: list[str] = [state.text]

    def heard(now: State) -> None:
        program[:] = [now.text]
        if now.page is not None:
            now.page.follow(now.with_part)

    wrong = talk(_reader(program) if at_terminal else _piped(iter(sys.stdin)), partial(print, flush=True), state, heard)
    return 1 if wrong and not at_terminal else 0


def _piped(every: Iterator[str]) -> Read:
    """Reads lines of a pipe, without a prompt: with those that go on with them, which a pipe can tell beforehand. Empty
    ones, which at a terminal end what was begun, are for the eye."""
    lines = (line for line in every if line.strip())
    waiting: list[str] = []

    def read(_: str) -> str:
        line = waiting.pop() if waiting else next(lines, None)
        if line is None:
            raise EOFError
        for more in lines:
            if not goes_on(more):
                waiting.append(more)
                break
            line += more
        return line.rstrip("\n")

    return read


def _reader(program: list[str]) -> Read:
    try:
        from porelang.repl.terminal import reader
    except ImportError as error:
        if (error.name or "").partition(".")[0] != "prompt_toolkit":
            raise
        report.note("without history and completion: pip install 'porelang[editor]' brings them")
        return input
    print("a statement, or an expression; :help lists the commands, Ctrl-D ends")
    return reader(program)
