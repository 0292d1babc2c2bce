"""The scale of the colours of planes, with its numbers, beside the picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from porelang.diagnostics import fail
from porelang.render.scale import Colouring, numbers, scale_colours

INK = (34, 32, 32, 255)


@dataclass(frozen=True, slots=True)
class Strip:
    """The room that a legend takes at the right of a picture, in pixels, and the size of its letters."""

    width: int
    font: int


def strip_of(size: tuple[int, int]) -> Strip:
    """The strip for a picture of a size. Errors: E107 where there is no room."""
    width, height = size
    font = int(np.clip(height / 38, 9, 40))
    strip = Strip(7 * font, font)
    if 2 * strip.width > width or height < 12 * font:
        raise fail("E107", f"a picture of {width} x {height} pixels has no room for a legend",
                   hint=f"from {2 * strip.width} x {12 * font} pixels on there is")  # fmt: skip
    return strip


def legend(scale: Colouring, unit: str, strip: Strip, height: int, transparent: bool) -> NDArray[np.uint8]:
    """A strip of pixels (height, strip.width, 4): a bar of the colours, numbers beside it, the unit above."""
    em = strip.font
    page = Image.new("RGBA", (strip.width, height), (255, 255, 255, 0 if transparent else 255))
    pen, letters = ImageDraw.Draw(page), ImageFont.load_default(em)
    top, tall, wide = height // 4, height // 2, max(4, int(1.1 * em))
    left = em // 2
    # the bar is drawn in its own values, so that a step of a number is as long below zero as above
    least, greatest = scale.ends
    values = np.linspace(greatest, least, tall)
    bar = np.rint(scale_colours(values, scale) * 255).astype(np.uint8)
    page.paste(Image.fromarray(np.ascontiguousarray(np.repeat(bar[:, None], wide, axis=1))), (left, top))
    pen.rectangle((left, top, left + wide - 1, top + tall - 1), outline=INK, width=max(1, em // 16))
    high, low = (f"{v:.4g}" for v in (greatest, least))
    apart = 1.2 * em / (tall - 1) * (greatest - least)
    inner = [v for v in numbers(scale) if least + apart < v < greatest - apart]
    for v, text in [(least, low), *((v, f"{v:.6g}") for v in inner), (greatest, high)]:
        y = top + (greatest - v) / (greatest - least) * (tall - 1)
        pen.line((left + wide, y, left + wide + em // 3, y), INK, max(1, em // 14))
        pen.text((left + wide + em // 2, y), text, INK, letters, anchor="lm")
    lines = _lines(unit, em, strip.width - left)
    fits = (s for s in range(em, 5, -1) if max(map(ImageFont.load_default(s).getlength, lines)) < strip.width - left)
    small = ImageFont.load_default(next(fits, 6))
    for i, line in enumerate(reversed(lines)):
        pen.text((left, top - (0.9 + 1.25 * i) * em), line, INK, small, anchor="ls")
    return np.asarray(page)


def _lines(text: str, em: int, room: int) -> list[str]:
    """A text in as many lines, up to three, as it needs to fit, broken between words."""
    letters = ImageFont.load_default(em)
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if lines[-1] and len(lines) < 3 and letters.getlength(longer) >= room:
            lines.append(word)
        else:
            lines[-1] = longer
    return lines
