"""Letters of one width, so that what a message points at stands above its mark, as on a terminal."""

from __future__ import annotations

import textwrap
from functools import cache

import numpy as np
from PIL import Image, ImageDraw, ImageFont

Colour = tuple[int, int, int, int]
#: Fonts that systems have, the first that is there is taken. Pillow looks where its system keeps them.
KNOWN = ("DejaVuSansMono.ttf", "LiberationMono-Regular.ttf", "consola.ttf", "cour.ttf", "Menlo.ttc")
#: How wide a letter is where there is none of them, in its height: Pillow's own font is set into cells of this width.
CELL = 0.62


@cache
def font(em: int) -> tuple[ImageFont.FreeTypeFont | ImageFont.ImageFont, float]:
    """The letters of a height in pixels, and how far one is from the next."""
    for name in KNOWN:
        try:
            found = ImageFont.truetype(name, em)
        except OSError:
            continue
        return found, found.getlength("m")
    return ImageFont.load_default(em), CELL * em


def written(pen: ImageDraw.ImageDraw, place: tuple[float, float], text: str, colour: Colour, em: int) -> None:
    """A line of text at its upper left corner, each letter in a cell of its own."""
    letters, cell = font(em)
    for i, letter in enumerate(text):
        if letter != " ":
            pen.text((place[0] + (i + 0.5) * cell, place[1] + em), letter, colour, letters, anchor="ms")


def wrapped(text: str, room: int) -> list[str]:
    """A text in lines of at most `room` letters; what is indented stays so."""
    return [part for line in text.splitlines() for part in textwrap.wrap(line, max(room, 8)) or [""]]


def broken(text: str, room: int) -> list[str]:
    """A message in lines of at most `room` letters; what stands in columns is not moved, and words stay whole."""
    room = max(room, 8)
    out = []
    for line in text.splitlines():
        while len(line) > room:
            space = line.rfind(" ", room // 2, room + 1)
            end = space if space > 0 and line[:space].strip() else room
            out.append(line[:end])
            line = "    " + line[end:].lstrip()
        out.append(line)
    return out


def premultiplied(image: Image.Image) -> Image.Image:
    """A picture whose colours are as light as they are seen through, as blending takes them."""
    pixels = np.asarray(image, np.uint16)
    out = pixels.copy()
    out[..., :3] = pixels[..., :3] * pixels[..., 3:] // 255
    return Image.fromarray(out.astype(np.uint8))
