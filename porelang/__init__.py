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
    from porelang.compiler import compile
    from porelang.data import SampledField
    from porelang.diagnostics import Diagnostic, PoreError, PoreWarning
    from porelang.field import Field
    from porelang.picture import Picture
    from porelang.program import Design, Program

__version__ = "0.1.0"
#: What is handed on, by the module it comes from: imported when it is asked for, so that `pore check` starts quickly.
_FROM = {
    "Design": "program",
    "Diagnostic": "diagnostics",
    "Field": "field",
    "Picture": "picture",
    "PoreError": "diagnostics",
    "PoreWarning": "diagnostics",
    "Program": "program",
    "SampledField": "data",
    "compile": "compiler",
    "load_ipython_extension": "notebook.magic",  # for `%load_ext porelang`
}
__all__ = [
    "Design",
    "Diagnostic",
    "Field",
    "Picture",
    "PoreError",
    "PoreWarning",
    "Program",
    "SampledField",
    "__version__",
    "compile",
]


def __getattr__(name: str) -> object:
    if name in _FROM:
        from importlib import import_module

        return getattr(import_module(f"porelang.{_FROM[name]}"), name)
    raise AttributeError(f"module 'porelang' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})
