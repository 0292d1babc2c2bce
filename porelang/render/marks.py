"""What is written on a picture: which way the axes point, how long a length is, and which colour is which output."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from porelang.diagnostics import fail
from porelang.render.camera import Camera

Pixels = NDArray[np.uint8]
Colour = tuple[int, int, int]
INK: Colour = (34, 32, 32)
#: Round marks, so that they can be read on a part.
HALO = (255, 255, 255, 215)
#: Of x, y and z: red, green and blue as everywhere, in shades that the colour-blind tell apart (Okabe and Ito 2008).
AXES: tuple[Colour, ...] = ((213, 94, 0), (0, 158, 115), (0, 114, 178))
#: Marks are drawn so many times larger and averaged: Pillow's lines have steps.
FINER = 4
#: The share of a picture's width that a scale bar takes at most.
LONGEST = 0.22


def letters(size: tuple[int, int]) -> int:
    """The size of letters for a picture, in pixels."""
    return int(np.clip(min(size) / 32, 10, 60))


@dataclass(frozen=True, slots=True)
class Mark:
    """What is laid into a corner of a picture: its pixels, and the corners by preference, as (right, top)."""

    patch: Image.Image
    corners: tuple[tuple[bool, bool], ...]


def axes_mark(camera: Camera, size: tuple[int, int]) -> Mark:
    """A triad for a picture of a size: the axes as the viewer sees them, the nearest in front."""
    em = letters(size) * FINER
    font = ImageFont.load_default(0.95 * em)
    long, line, middle = 2.6 * em, max(2, round(em / 7)), (5.0 * em, 5.0 * em)
    page, pen = _page(10 * em, 10 * em)
    seen = np.stack([camera.right, camera.up, -camera.forward])  # rows: to the right, up, toward the viewer
    for axis in np.argsort(seen[2]):
        right, up, toward = (float(v) for v in seen[:, axis])
        tip = (middle[0] + right * long, middle[1] - up * long)
        flat = math.hypot(right, up)
        if flat > 0.12:
            pen.line((*middle, *tip), HALO, line * 3)
            pen.line((*middle, *tip), (*AXES[axis], 255), line)
            _arrow(pen, middle, tip, AXES[axis], 0.62 * em)
            place = (tip[0] + right / flat * 0.85 * em, tip[1] - up / flat * 0.85 * em)
        else:  # it points at the viewer, or away: a dot, or a ring
            r = 0.24 * em
            pen.ellipse((middle[0] - r, middle[1] - r, middle[0] + r, middle[1] + r),
                        fill=(*AXES[axis], 255) if toward > 0 else (255, 255, 255, 255),
                        outline=(*AXES[axis], 255), width=line)  # fmt: skip
            place = (middle[0] - 0.8 * em, middle[1] + 0.8 * em)
        pen.text(place, "xyz"[axis], (*AXES[axis], 255), font, anchor="mm", stroke_width=em // 9, stroke_fill=HALO)
    return Mark(_trimmed(page), ((False, False), (False, True), (True, False), (True, True)))


def scale_bar_mark(pixel: float, size: tuple[int, int], words: str = "") -> Mark:
    """A bar of a round length for a picture of a size; `pixel` is that of one in mm, and `words` say where it is so."""
    em = letters(size) * FINER
    font = ImageFont.load_default(0.95 * em)
    length = round_length(LONGEST * size[0] * pixel)
    text = told(length) + words
    long = length / pixel * FINER
    wide = math.ceil(max(long, font.getlength(text)) + 3 * em)
    page, pen = _page(wide, 4 * em)
    x0, x1, y = (wide - long) / 2, (wide + long) / 2, 2.5 * em
    tick, line = 0.32 * em, max(2, round(em / 7))
    for colour, more in ((HALO, 2 * line), ((*INK, 255), 0)):
        pen.line((x0 - more / 2, y, x1 + more / 2, y), colour, line + more)
        for x in (x0, x1):
            pen.line((x, y - tick - more / 2, x, y + tick + more / 2), colour, line + more)
    pen.text((wide / 2, y - 0.55 * em), text, (*INK, 255), font, anchor="md", stroke_width=em // 9, stroke_fill=HALO)
    return Mark(_trimmed(page), ((True, False), (False, False), (True, True), (False, True)))


def words_mark(text: str, size: tuple[int, int]) -> Mark:
    """Words in a corner of a picture of a size."""
    em = letters(size) * FINER
    font = ImageFont.load_default(0.95 * em)
    page, pen = _page(font.getlength(text) + 2 * em, 2 * em)
    pen.text((em, em), text, (*INK, 255), font, anchor="lm", stroke_width=em // 9, stroke_fill=HALO)
    return Mark(_trimmed(page), ((True, True), (False, True), (False, False), (True, False)))


def lay(pixels: Pixels, marks: Sequence[Mark], seen: NDArray[np.bool_]) -> Pixels:
    """The picture with each mark in the first of its corners where nothing is `seen`, or hardly more than in others."""
    height, width = pixels.shape[:2]
    picture = Image.fromarray(np.ascontiguousarray(pixels))
    margin = round(0.7 * letters((width, height)))
    taken: set[tuple[bool, bool]] = set()
    for mark in marks:
        covered: list[tuple[int, tuple[bool, bool], tuple[int, int]]] = []
        for corner in (c for c in mark.corners if c not in taken):
            left = max(0, width - margin - mark.patch.width if corner[0] else margin)
            top = max(0, margin if corner[1] else height - margin - mark.patch.height)
            hidden = int(np.count_nonzero(seen[top : top + mark.patch.height, left : left + mark.patch.width]))
            covered.append((hidden, corner, (left, top)))
        least = min(hidden for hidden, *_ in covered)
        _, corner, place = next(found for found in covered if found[0] <= 2 * least)
        taken.add(corner)
        picture.alpha_composite(mark.patch.crop((0, 0, width - place[0], height - place[1])), place)
    return np.asarray(picture)


def key(named: Sequence[tuple[str, Colour]], size: tuple[int, int], transparent: bool) -> Pixels:
    """A strip of pixels at the right of a picture of a size: a patch of each colour, and its name beside it.

    Errors: E107 where there is no room.
    """
    width, height = size
    em = letters(size)
    font = ImageFont.load_default(em)
    longest = max(font.getlength(name) for name, _ in named)
    strip = math.ceil(longest + 2.8 * em)
    if 2 * strip > width or height < 1.7 * em * (len(named) + 1):
        raise fail("E107", f"a picture of {width} x {height} pixels has no room for a legend of {len(named)} names",
                   hint="make it larger with --size, or leave --legend out")  # fmt: skip
    page = Image.new("RGBA", (strip * FINER, height * FINER), (255, 255, 255, 0 if transparent else 255))
    pen, large, em = ImageDraw.Draw(page), ImageFont.load_default(em * FINER), em * FINER
    y = page.height / 2 - 0.85 * em * len(named)
    for name, colour in named:
        pen.rounded_rectangle((0.5 * em, y + 0.3 * em, 1.5 * em, y + 1.3 * em), 0.15 * em, (*colour, 255),
                              (*INK, 255), max(1, em // 16))  # fmt: skip
        pen.text((1.9 * em, y + 0.8 * em), name, (*INK, 255), large, anchor="lm")
        y += 1.7 * em
    return np.asarray(page.resize((strip, height), Image.Resampling.BOX))


def round_length(most: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is no longer than `most` mm."""
    power = 10.0 ** math.floor(math.log10(most))
    return next(k * power for k in (5, 2, 1) if k * power <= most * (1 + 1e-9))


def told(length: float) -> str:
    """A length with the unit that fits it."""
    unit, scale = ("m", 1000.0) if length >= 1000 else ("mm", 1.0) if length >= 0.1 else ("um", 1e-3)
    return f"{length / scale:.6g} {unit}"


def _page(width: float, height: float) -> tuple[Image.Image, ImageDraw.ImageDraw]:
    """Clear paper; what is drawn on it is made FINER times smaller."""
    sides = (math.ceil(width / FINER) * FINER, math.ceil(height / FINER) * FINER)
    page = Image.new("RGBA", sides, (255, 255, 255, 0))
    return page, ImageDraw.Draw(page)


def _trimmed(page: Image.Image) -> Image.Image:
    """What was drawn, in the size that it has in the picture, without clear edges."""
    small = page.resize((page.width // FINER, page.height // FINER), Image.Resampling.BOX)
    return small.crop(small.getbbox(alpha_only=True))


def _arrow(
    pen: ImageDraw.ImageDraw, tail: tuple[float, float], tip: tuple[float, float], colour: Colour, long: float
) -> None:
    dx, dy = tip[0] - tail[0], tip[1] - tail[1]
    far = math.hypot(dx, dy)
    long = min(long, 0.8 * far)
    dx, dy = dx / far * long, dy / far * long
    back = (tip[0] - dx, tip[1] - dy)
    pen.polygon([tip, (back[0] - 0.38 * dy, back[1] + 0.38 * dx), (back[0] + 0.38 * dy, back[1] - 0.38 * dx)],
                fill=(*colour, 255))  # fmt: skip
