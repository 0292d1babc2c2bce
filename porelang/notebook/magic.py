"""`%load_ext porelang` in a notebook: then a cell that begins with `%%pore` is a program."""

from __future__ import annotations

from typing import Any

from porelang.compiler import compile
from porelang.diagnostics import fail
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
        program = compile(cell, name=name)
        shell.user_ns[name] = program
        return program

    shell.register_magic_function(pore, "cell", "pore")
