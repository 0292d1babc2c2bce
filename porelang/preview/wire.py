"""A scene as one message for a page: a head as JSON, and after it the textures."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.preview.scene import Layer, Scene
from porelang.render.scale import COLOURS, VIRIDIS, Colouring, Scale, line_step, numbers


def packed(made: Scene, known: Sequence[str | None] = ()) -> bytes:
    """A scene as one message: the length of its head, the head as JSON, blanks up to a multiple of 4 bytes, and all
    textures one after the other, in words of 4 bytes, the lowest byte first. Texts that are `known` are left out."""
    textures: list[NDArray[Any]] = []
    bodies = []
    for k, b in enumerate(made.bodies):
        # WebGL reads a texture's x first, NumPy an array's last axis
        textures += [np.ravel(b.cells.values.transpose(2, 1, 0)), *b.layer.data]
        bodies.append(_head(b.layer, known[k] if k < len(known) else None) | {
            "lo": list(b.box.lo), "hi": list(b.box.hi), "counts": list(b.cells.counts), "colour": list(b.colour),
            "section": list(b.section),
        })  # fmt: skip
    head: dict[str, Any] = {
        "bodies": bodies,
        "plane": None,
        "lo": list(made.stage.lo),
        "hi": list(made.stage.hi),
        "nowhere": made.shown if made.scale is None else "",
        "scale": None if made.scale is None else _legend(made.scale) | {"shown": made.shown, "unit": made.unit},
    }
    if made.plane is not None:
        last = len(made.bodies)
        head["plane"] = _head(made.plane, known[last] if last < len(known) else None)
        textures += made.plane.data
    text = json.dumps(head).encode()
    text += b" " * (-len(text) % 4)
    words = [t.astype(t.dtype.newbyteorder("<")).tobytes() for t in textures]
    return b"".join([struct.pack("<I", len(text)), text, *words])


def texts(made: Scene) -> list[str | None]:
    """The shaders of a scene, in the order in which `packed` takes those that are known."""
    return [*(b.layer.text for b in made.bodies), None if made.plane is None else made.plane.text]


def _head(layer: Layer, known: str | None) -> dict[str, Any]:
    return {
        "name": layer.name,
        "text": None if layer.text == known else layer.text,
        "numbers": [float(v) for v in layer.numbers],
        "words": [len(d) for d in layer.data],
    }


def _legend(scale: Colouring) -> dict[str, Any]:
    """A scale: its nine colours, its ends and its middle, and the round numbers beside it."""
    low, high = scale.ends
    table, middle = (COLOURS, 0.0) if isinstance(scale, Scale) else (VIRIDIS, (low + high) / 2)
    return {
        "colours": [[float(c) for c in row] for row in table],
        "ends": [low, middle, high],
        "numbers": numbers(scale),
        "every": line_step(scale),
    }
