"""`%load_ext porelang` in a notebook: then a cell that begins with `%%pore` is a program."""

from __future__ import annotations

import sys
import warnings
from typing import Any

from porelang.compiler import compile
from porelang.diagnostics import PoreWarning, fail
from porelang.program import Program


def load_ipython_extension(shell: Any) -> None:
    """Have a notebook know `%%pore`: `%%pore NAME` binds the program of the cell to NAME (`program` unless told)."""

    def pore(line: str, cell: str) -> Program:
        """Compile the cell, bind the program to the name after %%pore (default: program), and show it."""
        name = line.strip() or "program"
        if not name.isidentifier():
            raise fail(
                "E108", f"`{name}` is no name for a program", hint="write `%%pore`, or a name: `%%pore specimen`"
            )
        with warnings.catch_warnings(record=True) as doubts:
            program = compile(cell, name=name)
        for doubt in doubts:
            if issubclass(doubt.category, PoreWarning):  # of a line of the cell, and none of IPython's
                print(doubt.message, file=sys.stderr)
            else:
                warnings.warn_explicit(doubt.message, doubt.category, doubt.filename, doubt.lineno)
        shell.user_ns[name] = program
        return program

    shell.register_magic_function(pore, "cell", "pore")
