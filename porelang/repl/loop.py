"""The loop: lines are read until what they say is complete, and answered. Plain text, so that a pipe will do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from porelang.diagnostics import PoreError, fail, render, suggest
from porelang.progress import CancelledError
from porelang.repl.checked import checked, fallen
from porelang.repl.commands import COMMANDS
from porelang.repl.shown import shown
from porelang.repl.state import State, is_incomplete, said

#: What stands before a line, and before one that goes on.
PROMPT, MORE = "pore> ", "....> "
#: What ends it, beside Ctrl-D.
ENDS = (":quit", ":q", "quit", "exit")
#: Reads a line after a prompt. Errors: EOFError at the end, KeyboardInterrupt where the line is not wanted.
Read = Callable[[str], str]


@dataclass(frozen=True, slots=True)
class Answered:
    """What a line came to: the state from now on, what is said to it, and whether it was wrong."""

    state: State
    said: str = ""
    wrong: bool = False


def answered(state: State, line: str) -> Answered:
    """The answer to a line, a command or a text of the language."""
    word, _, rest = line.strip().partition(" ")
    try:
        if word.startswith(":"):
            if word not in COMMANDS:
                near = suggest(word, COMMANDS)
                raise fail("E108", f"there is no command `{word}`",
                           hint=f"did you mean `{near}`?" if near else ":help lists the commands")  # fmt: skip
            after, text = COMMANDS[word].run(state, rest.strip())
            told = [render(d) for d in fallen(state, after)]
            return Answered(after, "\n".join([text, *told]), bool(told))
        found = said(state, line)
        told = [render(d) for d in found.diagnostics]
        try:
            value = shown(found, state.colours, state.colours) if found.value is not None else ""
        except PoreError as error:
            raise PoreError([found.typed(d) for d in error.diagnostics]) from None
        holds = checked(found.state, list(found.checks))
        holds += [d for d in fallen(state, found.state) if d.message not in {h.message for h in holds}]
        told += [render(d) for d in holds]
        wrong = any(d.severity == "error" for d in (*found.diagnostics, *holds))
        return Answered(found.state, "\n".join([*told, *([value] if value else [])]), wrong)
    except PoreError as error:
        return Answered(state, "\n".join(render(d) for d in error.diagnostics), True)
    except (CancelledError, KeyboardInterrupt):
        return Answered(state, "ended")


def talk(read: Read, say: Callable[[str], None], state: State, heard: Callable[[State], None] | None = None) -> bool:
    """Read and answer until the end; whether any line was wrong. `heard` is told of the state after each. Ctrl-C leaves
    the line, or ends what is being computed; Ctrl-D ends."""
    lines: list[str] = []
    wrong = False
    while True:
        try:
            lines.append(read(MORE if lines else PROMPT))
        except KeyboardInterrupt:
            lines = []
            continue
        except EOFError:
            if not lines:
                return wrong
            lines.append("")  # what was begun is told to be incomplete
        text = "\n".join(lines)
        commanded = len(lines) > 1 and lines[-1].partition(" ")[0] in COMMANDS  # it ends what was begun
        if not text.lstrip().startswith(":") and lines[-1].strip() and is_incomplete(text) and not commanded:
            continue
        if commanded:
            unfinished = answered(state, "\n".join(lines[:-1]))
            say(unfinished.said)
            text, wrong = lines[-1], wrong or unfinished.wrong
        lines = []
        if text.strip() in ENDS:
            return wrong
        if not text.strip():
            continue
        found = answered(state, text)
        state, wrong = found.state, wrong or found.wrong
        if heard is not None:
            heard(state)
        if found.said:
            say(found.said)
