"""A field as a notebook shows it: a plane through the middle of the part, in the colours of `pore render --slice`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from porelang.analysis.box import Box
from porelang.field import Field
from porelang.notebook import display
from porelang.notebook.still import small
from porelang.preview.scene import usual
from porelang.program import Design
from porelang.render.legend import INK, legend, strip_of
from porelang.render.planes import BEYOND
from porelang.render.scale import fitting, scale_colours

AXES = "xyz"
#: Pixels of the longer side, and of the height at least, which a legend needs.
LONGEST, LOWEST = 360, 150
#: Of values in the scale: those beyond are few, and have the colours of its ends.
SHARE = (0.002, 0.998)


def shown(field: Field) -> bytes | None:
    """What a notebook shows of a field: a slice, as PNG; None where there is none."""
    if field.of is None or not display.in_kernel():
        return None
    try:
        return slice_picture(field, *field.of)
    except Exception:  # a part without an end, say: the text says what it is
        return None


def slice_picture(field: Field, design: Design, name: str) -> bytes:
    """A field on a plane across the shortest side of the part, as PNG: red below zero, blue above, zero drawn black;
    of a field of one sign violet to yellow. A vector has its length. Errors: those of the part's bounds."""
    box: Box = design.extent(usual(design.program)).outer.grown(BEYOND)
    axis = min((1, 0, 2), key=lambda a: round(box.size[a], 6))  # from the front where it makes no difference
    along = [a for a in range(3) if a != axis]
    at = (box.lo[axis] + box.hi[axis]) / 2
    pixel = max(box.size[a] for a in along) / LONGEST
    across, up = (np.arange(box.lo[a] + pixel / 2, box.hi[a], pixel)[:: -1 if k else 1] for k, a in enumerate(along))
    points = np.empty((len(up), len(across), 3))
    points[..., axis], points[..., along[0]], points[..., along[1]] = at, across, up[:, None]
    with np.errstate(all="ignore"):  # a field may be infinite somewhere
        values = np.asarray(field(points.reshape(-1, 3)), np.float64)
    if values.ndim > 1:
        values, name = np.linalg.norm(values, axis=1), f"|{name}|"
    values = values.reshape(points.shape[:2])
    known = values[np.isfinite(values)]
    scale = fitting(np.clip(known, *np.quantile(known, SHARE)) if len(known) else known)
    pixels = np.full((max(len(up), LOWEST), len(across), 4), 255, np.uint8)
    pixels[: len(up), :, :3] = np.rint(255 * scale_colours(values, scale))
    pixels[: len(up)][_zero(values)] = INK
    room = (max(len(across), 140), pixels.shape[0])
    strip = legend(scale, name, strip_of(room), pixels.shape[0], transparent=False)
    where = _line(f"{AXES[axis]} = {at:.4g} mm, {AXES[along[0]]} to the right, {AXES[along[1]]} up",
                  pixels.shape[1] + strip.shape[1])  # fmt: skip
    return small(np.ascontiguousarray(np.vstack([np.hstack([pixels, strip]), where])[..., :3]), 256)


def _zero(values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Where the sign changes to the pixel on the right, or below."""
    below = values <= 0
    line = np.zeros(values.shape, bool)
    line[:, :-1] |= below[:, :-1] != below[:, 1:]
    line[:-1] |= below[:-1] != below[1:]
    return line & np.isfinite(values)


def _line(text: str, width: int) -> NDArray[np.uint8]:
    """A line of text on white."""
    page = Image.new("RGBA", (width, 20), (255, 255, 255, 255))
    ImageDraw.Draw(page).text((4, 10), text, INK, ImageFont.load_default(11), anchor="lm")
    return np.asarray(page)
