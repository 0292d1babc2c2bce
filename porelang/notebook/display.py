"""What stands under a cell that ends in a program or a design: its viewer, or a still picture and the tables."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from porelang.diagnostics import fail
from porelang.doors import Doors
from porelang.notebook.still import fallback
from porelang.program import Design, Program
from porelang.render.picture import bodies_of

if TYPE_CHECKING:
    from porelang.notebook.widget import Viewer


def in_kernel() -> bool:
    """Whether a notebook shows what cells give: not a terminal, where nobody would see a picture."""
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return getattr(shell, "kernel", None) is not None


def view(design: Design, name: str | Sequence[str] | None, *, paint: str, plane: bool, cut: str) -> Viewer:
    """The viewer of a design, of an output or of several. Errors: E100, E126 where anywidget is missing."""
    kind = _viewers()
    if kind is None:
        raise fail("E126", "a viewer in a notebook needs the package anywidget",
                   hint="pip install 'porelang[notebook]'")  # fmt: skip
    names = [name] if isinstance(name, str) else list(name or ())
    return kind(design.program, design.settings, outputs=names, paint=paint, plane=plane, cut=cut)


def bundle(shown: Doors) -> Any:
    """The displays of a program or a design by their MIME types, and their metadata; none where there is no notebook,
    or nothing to be drawn, or something goes wrong."""
    assert isinstance(shown, Program | Design)
    try:
        return _bundle(shown)
    except Exception:  # the text says what it is
        return {}


def _bundle(shown: Program | Design) -> Any:
    program = shown if isinstance(shown, Program) else shown.program
    if not in_kernel() or not bodies_of(program):
        return {}
    settings = {} if isinstance(shown, Program) else shown.settings
    kind = _viewers()
    if kind is None:
        return fallback(shown, settings)[0], {}
    made = kind(program, settings)
    found = made._repr_mimebundle_()
    data, metadata = found if found is not None else ({}, {})
    return {**data, **fallback(shown, settings, known=made.still)[0]}, metadata


def _viewers() -> type[Viewer] | None:
    """What viewers are made of; None where the package for it is missing."""
    try:
        from porelang.notebook.widget import Viewer
    except ImportError:
        return None
    return Viewer
