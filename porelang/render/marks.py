"""What is written on a picture: which way the axes point, how long a length is, and which colour is which output."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from porelang.diagnostics import fail
from porelang.render.camera import Camera

Pixels = NDArray[np.uint8]
Colour = tuple[int, int, int]
INK: Colour = (34, 32, 32)
#: Of x, y and z: red, green and blue as everywhere, in shades that the colour-blind tell apart (Okabe and Ito 2008).
AXES: tuple[Colour, ...] = ((213, 94, 0), (0, 158, 115), (0, 114, 178))
#: Marks are drawn so many times larger and averaged: Pillow's lines have steps.
FINER = 4
#: The share of a picture's width that a scale bar takes at most.
LONGEST = 0.22


def letters(size: tuple[int, int]) -> int:
    """The size of letters for a picture, in pixels."""
    return int(np.clip(min(size) / 32, 10, 60))


def draw_axes(pixels: Pixels, camera: Camera) -> Pixels:
    """The picture with a triad in its lower left corner: the axes as the viewer sees them, the nearest in front."""
    height, width = pixels.shape[:2]
    em = letters((width, height)) * FINER
    page, pen = _page(min(width, 9 * em // FINER), min(height, 9 * em // FINER))
    font = ImageFont.load_default(0.95 * em)
    long, line = 2.6 * em, max(2, round(em / 7))
    seen = np.stack([camera.right, camera.up, -camera.forward])  # rows: to the right, up, toward the viewer
    # room for the arms that point left and down, as much as they need
    middle = (1.5 * em + max(0.0, float(-seen[0].min())) * long + 0.4 * em,
              page.height - 1.5 * em - max(0.0, float(-seen[1].min())) * long - 0.4 * em)  # fmt: skip
    for axis in np.argsort(seen[2]):
        right, up, toward = (float(v) for v in seen[:, axis])
        tip = (middle[0] + right * long, middle[1] - up * long)
        flat = math.hypot(right, up)
        if flat > 0.12:
            pen.line((*middle, *tip), (255, 255, 255, 200), line * 3)
            pen.line((*middle, *tip), (*AXES[axis], 255), line)
            _arrow(pen, middle, tip, AXES[axis], 0.62 * em)
            place = (tip[0] + right / flat * 0.85 * em, tip[1] - up / flat * 0.85 * em)
        else:  # it points at the viewer, or away: a dot, or a ring
            r = 0.24 * em
            pen.ellipse((middle[0] - r, middle[1] - r, middle[0] + r, middle[1] + r),
                        fill=(*AXES[axis], 255) if toward > 0 else (255, 255, 255, 255),
                        outline=(*AXES[axis], 255), width=line)  # fmt: skip
            place = (middle[0] - 0.8 * em, middle[1] + 0.8 * em)
        pen.text(place, "xyz"[axis], (*AXES[axis], 255), font, anchor="mm",
                 stroke_width=em // 9, stroke_fill=(255, 255, 255, 220))  # fmt: skip
    return _laid(pixels, page, 0)


def draw_scale_bar(pixels: Pixels, pixel: float, right: int, words: str) -> Pixels:
    """The picture with a bar of a round length in its lower right corner, `right` pixels from its edge.

    `pixel` is the size of one in mm, and `words` say where that is so.
    """
    height, width = pixels.shape[:2]
    em = letters((width, height)) * FINER
    page, pen = _page(max(1, round((LONGEST + 0.25) * (width - right))), min(height, 4 * em // FINER))
    font = ImageFont.load_default(0.95 * em)
    length = round_length(LONGEST * (width - right) * pixel)
    long = length / pixel * FINER
    x1, y = page.width - 1.4 * em, page.height - 1.5 * em
    x0, tick, line = x1 - long, 0.32 * em, max(2, round(em / 7))
    for colour, more in (((255, 255, 255, 220), 2 * line), ((*INK, 255), 0)):
        pen.line((x0 - more / 2, y, x1 + more / 2, y), colour, line + more)
        for x in (x0, x1):
            pen.line((x, y - tick - more / 2, x, y + tick + more / 2), colour, line + more)
    pen.text(((x0 + x1) / 2 if not words else x1, y - 0.55 * em), told(length) + words, (*INK, 255), font,
             anchor="md" if not words else "rd", stroke_width=em // 9, stroke_fill=(255, 255, 255, 220))  # fmt: skip
    return _laid(pixels, page, width - right - page.width // FINER)


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


def _page(width: int, height: int) -> tuple[Image.Image, ImageDraw.ImageDraw]:
    """Clear paper for a patch of so many pixels of a picture."""
    page = Image.new("RGBA", (width * FINER, height * FINER), (255, 255, 255, 0))
    return page, ImageDraw.Draw(page)


def _laid(pixels: Pixels, page: Image.Image, left: int) -> Pixels:
    """The picture with a patch laid over its lower edge, from the column `left` on."""
    picture = Image.fromarray(np.ascontiguousarray(pixels))
    patch = page.resize((page.width // FINER, page.height // FINER), Image.Resampling.BOX)
    picture.alpha_composite(patch, (left, picture.height - patch.height))
    return np.asarray(picture)


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
