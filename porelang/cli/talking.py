"""`pore repl`: a program a line at a time, at a terminal or through a pipe."""

from __future__ import annotations

import os
import select
import sys
from argparse import Namespace
from dataclasses import replace
from functools import partial

from porelang.cli import report
from porelang.diagnostics import fail
from porelang.files import read_source
from porelang.repl.loop import Read, talk
from porelang.repl.state import NAME, State, goes_on, said
from porelang.repl.view import View
from porelang.session import Session

#: Seconds within which a line of a pipe is gone on with: who waits for the answer writes no more until it is there.
MOMENT = 0.2


def repl(options: Namespace) -> int:
    """Read lines and answer them. Of a file that is named its statements are there already; its part is `part`. Exit
    status 1 where that file is wrong, which is not begun with, or a line of a pipe."""
    if sys.stdin is None:
        raise fail("E105", "there is no standard input: it is closed", hint="`pore repl` reads lines from it")
    at_terminal = sys.stdin.isatty()
    with View(browse=at_terminal) as page:
        return _talk(options, State(Session(), colours=report.has_colours(sys.stdout), page=page), at_terminal)


def _talk(options: Namespace, state: State, at_terminal: bool) -> int:
    if options.file is not None:
        source = read_source(options.file)
        opened = Session().update(options.file, source.text)
        report.say(opened.diagnostics)
        if opened.program is None:
            return 1
        name = os.path.normpath(os.path.join(os.path.dirname(options.file), NAME))
        state = said(replace(state, name=name), source.text, part=True).state
    program: list[str] = [state.text]

    def heard(now: State) -> None:
        program[:] = [now.text]
        if now.page is not None:
            now.page.follow(now.with_part)

    wrong = talk(
        _reader(program, state.name) if at_terminal else _piped(_Pipe()), partial(print, flush=True), state, heard
    )
    return 1 if wrong and not at_terminal else 0


class _Pipe:
    """The lines of standard input that are not empty, as they come."""

    def __init__(self) -> None:
        self._file = sys.stdin.fileno()
        self._held = b""
        self._ended = False

    def line(self, patience: float | None = None) -> str | None:
        """The next line, empty at the end; None where none came within so many seconds."""
        while True:
            first, newline, rest = self._held.partition(b"\n")
            if newline or self._ended:
                self._held = rest
                if first.strip() or (self._ended and not newline):
                    return (first + newline).decode(errors="replace")
                continue
            if patience is not None and os.name != "nt" and not select.select([self._file], [], [], patience)[0]:
                return None
            more = os.read(self._file, 65536)
            self._held, self._ended = self._held + more, not more


def _piped(pipe: _Pipe) -> Read:
    """Reads lines of a pipe, without a prompt: with those that go on with them, which are there beforehand, or within a
    moment. Empty ones, which at a terminal end what was begun, are for the eye."""
    waiting: list[str] = []

    def read(_: str) -> str:
        line = (waiting.pop() if waiting else pipe.line()) or ""
        if not line:
            raise EOFError
        while more := pipe.line(MOMENT):
            if not goes_on(more):
                waiting.append(more)
                break
            line += more
        return line.rstrip("\n")

    return read


def _reader(program: list[str], name: str) -> Read:
    try:
        from porelang.repl.terminal import reader
    except ImportError as error:
        if (error.name or "").partition(".")[0] != "prompt_toolkit":
            raise
        report.note("without history and completion: pip install 'porelang[editor]' brings them")
        return input
    print("a statement, or an expression; :help lists the commands, Ctrl-D ends")
    return reader(program, name)
