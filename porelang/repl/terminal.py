"""A terminal: lines are edited with history, colours and completion, by prompt_toolkit."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable
from pathlib import Path

from prompt_toolkit import PromptSession
from prompt_toolkit.completion import CompleteEvent, Completer, Completion, PathCompleter
from prompt_toolkit.document import Document
from prompt_toolkit.formatted_text import StyleAndTextTuples
from prompt_toolkit.history import FileHistory, History, InMemoryHistory
from prompt_toolkit.lexers import Lexer

from porelang import cache
from porelang.assist.complete import completions
from porelang.repl.commands import COMMANDS
from porelang.repl.loop import Read
from porelang.repl.state import NAME
from porelang.session import Session
from porelang.syntax.highlighting import patterns

_STYLES = {"comment": "ansibrightblack", "string": "ansigreen", "number": "ansicyan", "keyword": "ansiblue bold",
           "function": "ansimagenta", "constant": "ansicyan"}  # fmt: skip


class Colours(Lexer):
    """Colours of a line, by the patterns of the language."""

    def lex_document(self, document: Document) -> Callable[[int], StyleAndTextTuples]:
        known = [(what.partition(".")[0], re.compile(pattern)) for what, pattern in patterns()]

        def line(number: int) -> StyleAndTextTuples:
            text, at = document.lines[number], 0
            out: StyleAndTextTuples = []
            while at < len(text):
                found = next(((w, m) for w, p in known if (m := p.match(text, at)) and m.end() > at), None)
                end = found[1].end() if found is not None else at + 1
                out.append((_STYLES.get(found[0], "") if found is not None else "", text[at:end]))
                at = end
            return out

        return line


class Names(Completer):
    """What may stand where the cursor is: of the program so far, and of the line."""

    def __init__(self, text: list[str], name: str = NAME) -> None:
        self._text, self._name, self._session = text, name, Session()

    def get_completions(self, document: Document, complete_event: CompleteEvent) -> Iterable[Completion]:
        line = document.text_before_cursor
        if line.startswith(":") and " " not in line:
            yield from (Completion(c, -len(line), display_meta=COMMANDS[c].doc) for c in COMMANDS if c.startswith(line))
            return
        if line.startswith(":"):
            command, _, rest = line.partition(" ")
            if command in COMMANDS and COMMANDS[command].takes.startswith(("FILE", "[FILE")):
                yield from PathCompleter(expanduser=True).get_completions(Document(rest), complete_event)
                return
            line = rest
        before = "".join(self._text)
        snapshot = self._session.update(self._name, before + line)
        in_word = line[-1:].isalnum() or line[-1:] == "_"
        for item in completions(snapshot, len(before) + len(line), os.getcwd()):
            begun = (before + line)[item.start : item.end]
            if item.text.startswith(begun) and (begun or not in_word):
                yield Completion(item.text, item.start - item.end, display=item.label, display_meta=item.detail[:60])


def reader(text: list[str], name: str = NAME) -> Read:
    """Reads lines from the terminal; `text` holds the program so far, which has this name, for completion."""
    session: PromptSession[str] = PromptSession(
        history=_history(), lexer=Colours(), completer=Names(text, name), complete_while_typing=False
    )
    return session.prompt


def _history() -> History:
    folder = cache.folder()
    return InMemoryHistory() if folder is None else FileHistory(str(Path(folder) / "repl.history"))
