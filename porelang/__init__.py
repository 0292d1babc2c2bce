"""Porous parts as text: lattices, foams and minimal surfaces whose cell, thickness and kind follow fields.

>>> import porelang as pore
>>> program = pore.compile("gyroid(30) & cylinder(75, 300)")
>>> f = program.field("part")
>>> bool(f([[200, 0, 0]])[0] > 0)
True
"""

from __future__ import annotations

TYPE_CHECKING = False  # the module `typing` takes long to import, and `pore` answers no Ctrl-C until this is done
if TYPE_CHECKING:
    from typing import Any

    from porelang.diagnostics import Diagnostic, PoreError
    from porelang.program import Field, Program, compile

__version__ = "0.1.0"
__all__ = ["Diagnostic", "Field", "PoreError", "Program", "__version__", "compile"]


def __getattr__(name: str) -> Any:
    if name in ("Diagnostic", "PoreError"):
        from porelang import diagnostics

        return getattr(diagnostics, name)
    if name in ("Field", "Program", "compile"):
        from porelang import program

        return getattr(program, name)
    raise AttributeError(f"module 'porelang' has no attribute '{name}'")
