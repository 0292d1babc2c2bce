"""What stands over the picture in a window, as a picture: the params, which of them is chosen, what is wrong."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

from PIL import Image, ImageDraw, ImageFont

INK, QUIET, ACCENT, WRONG = (34, 35, 31, 255), (99, 101, 94, 255), (154, 77, 39, 255), (156, 28, 28, 255)
GROUND = (255, 255, 255, 225)
#: Pixels of a letter, a line and the edge; letters of a line of a message.
EM, ROW, EDGE, WIDE = 14, 20, 10, 100
KEYS = (
    "Tab chooses a param, comma and period set it; x y z are sections, page keys move one;",
    "c colours by the next field; f fits, o is parallel, 1 to 7 are views; drag, Shift-drag, wheel",
)


def panel(file: str, params: Sequence[dict[str, Any]], chosen: int, looks: str, wrong: str, doing: str) -> Image.Image:
    """Lines on a light ground, premultiplied, the top row first."""
    lines: list[tuple[str, tuple[int, int, int, int]]] = [(f"{file}   {doing}".rstrip(), INK)]
    for i, param in enumerate(params):
        value = param["value"] if param["choices"] else f"{param['value'] / param['scale']:.6g}"
        mark = ">" if i == chosen else " "
        lines.append((f"{mark} {param['name']} = {value} {param['unit']}   {param['doc']}".rstrip(),
                      ACCENT if i == chosen else INK))  # fmt: skip
    lines += [(looks, INK)] if looks else []
    lines += [
        (part, WRONG)
        for line in wrong.splitlines()
        for part in (textwrap.wrap(line, WIDE, drop_whitespace=False) or [""])
    ]
    lines += [(text, QUIET) for text in KEYS]
    letters = ImageFont.load_default(EM)
    width = int(max(letters.getlength(text) for text, _ in lines)) + 2 * EDGE
    page = Image.new("RGBA", (width, ROW * len(lines) + 2 * EDGE), GROUND)
    pen = ImageDraw.Draw(page)
    for i, (text, colour) in enumerate(lines):
        pen.text((EDGE, EDGE + i * ROW), text, colour, letters)
    return page
