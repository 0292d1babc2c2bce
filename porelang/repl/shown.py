"""How the value of a line is shown: as what it is."""

from __future__ import annotations

import shutil

import numpy as np

from porelang.assist.shown import signature, told
from porelang.diagnostics import PoreError
from porelang.elaborate.values import Function, Scalar
from porelang.ir import Stage
from porelang.repl.picture import slice_of
from porelang.repl.state import Said

#: What is found from fields may take as long as somebody waits: Ctrl-C ends it.
SECONDS = 1e6
#: Places at which a solid is looked at for how much of its box it fills.
_PLACES = 20_000
#: Columns of a picture.
_LEAST, _MOST = 16, 60


def shown(found: Said, picture: bool = False, colours: bool = False) -> str:
    """The value of a line: a number with its unit, a field with how far it reaches and how steep it is, a solid with
    its bounds and how much of them it fills; with a `picture`, a slice of it. Errors: those of what it reads."""
    value, program = found.value, found.program
    if value is None or program is None:
        return ""
    if isinstance(value, Function):
        return str(signature(value, value.name))
    lines = told(value, found.design, False, SECONDS)
    if not isinstance(value, Scalar) or value.node.stage is not Stage.FIELD:
        return "\n".join(lines)
    try:
        lines += _as_a_solid(found)
        if picture:
            lines.append(slice_of(found.design, found.name, _room(len(lines)), colours))
    except PoreError as error:
        if picture:
            raise
        if error.diagnostics[0].code not in ("E102", "E103"):
            raise
        lines.append(f"as a part: {found.typed(error.diagnostics[0]).message}")
    return "\n".join(lines)


def _room(lines: int) -> int:
    """How many columns a picture may have, of which a row is half as many, below so many lines and above a prompt."""
    columns, rows = shutil.get_terminal_size((80, 60))
    return max(_LEAST, min(_MOST, columns, 2 * (rows - lines - 2)))


def _as_a_solid(found: Said) -> list[str]:
    design = found.design
    box = design.bounds(found.name)
    points = np.random.default_rng(1).uniform(box.lo, box.hi, (_PLACES, 3))
    share = float((np.asarray(design.field(found.name)(points)) < 0).mean())
    off = 2 * float(np.sqrt(max(share * (1 - share), 1 / _PLACES) / _PLACES))
    corners = " to ".join(f"({', '.join(f'{v:.4g}' for v in corner)})" for corner in (box.lo, box.hi))
    size = " x ".join(f"{v:.4g}" for v in box.size)
    return [f"as a part: {size} mm, {corners}, of which it fills {share:.1%} +- {off:.1%}"]
