"""What a page needs to draw an output of a design: a shader's text, and the values and textures that it reads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import Box
from porelang.backends.glsl import shader
from porelang.diagnostics import fail
from porelang.gpu.fields import LONGEST, resident
from porelang.program import Design
from porelang.render.cells import bound_cells
from porelang.tape import operations

#: How far the box reaches beyond the part, in its longest side: rays begin outside of the part.
ROOM = 1e-3
#: Words in a row of a texture of data; the shader reads word i at (i % ROW, i / ROW).
ROW = 2048


@dataclass(frozen=True, slots=True)
class Scene:
    """An output as a page draws it. Lengths are in mm.

    `text` is a fragment shader for WebGL 2, `numbers` its array `u`, `cells` its texture of what is proven of the field
    in parts of the box (x fastest), `data` the textures of words that it reads. Two scenes whose `text` is the same
    differ in nothing that has to be compiled.
    """

    output: str
    text: str
    box: Box
    numbers: NDArray[np.float32]
    counts: tuple[int, int, int]
    cells: NDArray[np.float32]
    data: tuple[NDArray[np.uint32], ...]

    def head(self) -> dict[str, Any]:
        """All but the textures, for JSON; how long these are, in the order in which `body` holds them."""
        return {
            "output": self.output,
            "text": self.text,
            "lo": list(self.box.lo),
            "hi": list(self.box.hi),
            "numbers": [float(v) for v in self.numbers],
            "counts": list(self.counts),
            "words": [len(d) for d in self.data],
        }

    def body(self) -> bytes:
        """The cells, then the data, each word of 4 bytes, the lowest byte first."""
        return b"".join(part.astype(part.dtype.newbyteorder("<")).tobytes() for part in (self.cells, *self.data))


def scene(design: Design, name: str | None = None) -> Scene:
    """The scene of an output. Errors: E100-E103 about the output, E111 where nothing is solid, E121 for a program that
    no driver compiles."""
    program = design.program
    output = program.output(name)
    part = design.formula(program.solid(output))
    if (length := operations(part.roots)) > LONGEST:
        raise fail("E121", f"the program is too long for a shader: {length:,} operations, where drivers manage "
                   f"{LONGEST:,}", hint="`pore mesh --backend numpy` has no such limit")  # fmt: skip
    box = _roomy(design.bounds(output))
    cells = bound_cells(part, box)
    if cells.empty:
        raise fail("E111", f"nothing of `{output}` is solid", hint="solid is negative: look at the sign of its field")
    made = shader(part.roots, dict(program.ranges), "webgl")
    with np.errstate(over="ignore"):
        numbers = np.array(part.with_roots(*made.uniforms).numbers, dtype=np.float32)
    data = tuple(np.ravel(words()) for _, words in resident(part, made))
    # WebGL reads a texture's x first, NumPy an array's last axis
    return Scene(output, made.text, box, numbers, cells.counts, np.ravel(cells.values.transpose(2, 1, 0)), data)


def _roomy(box: Box) -> Box:
    more = ROOM * max(box.size)
    lo, hi = np.subtract(box.lo, more), np.add(box.hi, more)
    return Box((float(lo[0]), float(lo[1]), float(lo[2])), (float(hi[0]), float(hi[1]), float(hi[2])))
