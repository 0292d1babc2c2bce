"""The Common Layer Interface, version 2.0, in ASCII: contours of layers in one file, for laser and resin printers.

A layer is what lies below its height, down to that of the layer before: a first one without contours says where the
lowest begins. Lengths are in mm. Each contour is closed, its last point its first; outer ones run counter-clockwise
(direction 1), holes clockwise (direction 0). Source: Common Layer Interface (CLI), version 2.0.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from porelang.slices.outline import Ring, area_of
from porelang.slices.stack import Stack

END = "$$GEOMETRYEND\n"
HOLE, OUTER = 0, 1


def head(stack: Stack, name: str) -> str:
    """What stands before the layers, the bounds of the part and where the lowest layer begins."""
    corners = ",".join(f"{v:.6g}" for v in (*stack.box.lo, *stack.box.hi))
    return (
        "$$HEADERSTART\n$$ASCII\n$$UNITS/1\n$$VERSION/200\n"
        f"$$LABEL/1,{name}\n$$DIMENSION/{corners}\n$$LAYERS/{len(stack.z) + 1}\n"
        f"$$HEADEREND\n$$GEOMETRYSTART\n$$LAYER/{stack.box.lo[2]:.6f}\n"
    )


def layer(stack: Stack, k: int, rings: Iterable[Ring]) -> str:
    """A layer and its contours, each as a polyline."""
    top = min(stack.box.lo[2] + (k + 1) * stack.step, stack.box.hi[2])
    lines = [f"$$LAYER/{top:.6f}"]
    for ring in rings:
        closed = np.concatenate([ring, ring[:1]])
        places = ",".join(f"{v:.4f}" for v in closed.ravel().tolist())
        lines.append(f"$$POLYLINE/1,{OUTER if area_of([ring]) > 0 else HOLE},{len(closed)},{places}")
    return "\n".join([*lines, ""])
