"""What a window shows beside its picture, as pictures: what can be set, measures and checks, and what is wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw

from porelang.diagnostics import PoreError
from porelang.preview.heard import HOLDS, Known
from porelang.preview.items import Item
from porelang.preview.letters import Colour, broken, font, premultiplied, wrapped, written
from porelang.preview.scene import Scene
from porelang.render.legend import legend, strip_of

INK, QUIET, ACCENT, WRONG = (34, 35, 31, 255), (99, 101, 94, 255), (154, 77, 39, 255), (156, 28, 28, 255)
FINE: Colour = (38, 108, 58, 255)
GROUND, TRACK, OVER = (246, 245, 241, 255), (214, 212, 204, 255), (255, 252, 248, 242)
#: Pixels of a letter, a line, the edge, a slider and the whole column; all times what a screen has to a pixel.
EM, ROW, EDGE, BAR, WIDE = 13, 19, 10, 6, 300
KEYS = """Tab       the next to be set
, .       set it, as the mouse does
x y z     section; page keys move
p         the field on it
c         colours by the next one
f o 1..7  fit, parallel, views
drag      turns; Shift-drag moves
wheel     zooms, as + and -
arrows    turn
Bksp      cancels what takes long
h         hides this column"""


@dataclass(frozen=True, slots=True)
class Column:
    """A picture, premultiplied, and the rows (first, behind the last) that each item has in it; sliders reach from
    `left` to `right`."""

    image: Image.Image
    rows: list[tuple[int, int]]
    left: int
    right: int


def column(known: Known, items: Sequence[Item], chosen: int, least: int, scale: float = 1.0) -> Column:
    """All that stands beside the picture, at least so many pixels high."""
    em, row, edge, bar, wide = (round(n * scale) for n in (EM, ROW, EDGE, BAR, WIDE))
    room = int((wide - 2 * edge) / font(em)[1])
    lines: list[tuple[str, Colour]] = []
    sliders: dict[int, tuple[float, Colour]] = {}
    rows: list[tuple[int, int]] = []

    def say(text: str, colour: Colour, indent: str = "") -> None:
        lines.extend((indent + part, colour) for part in wrapped(text, room - len(indent)))

    say(known.file, INK)
    say(", ".join(known.doing.values()) or " ", QUIET)
    for i, item in enumerate(items):
        begun = len(lines)
        colour = ACCENT if i == chosen else INK
        text = f"{'>' if i == chosen else ' '} {item.name}"
        if len(text) + len(item.value) + 1 <= room:
            say(text + item.value.rjust(room - len(text)), colour)
        else:
            say(text, colour)
            say(item.value, colour, "    ")
        if item.share is not None:
            sliders[len(lines)] = item.share, colour
            lines.append(("", colour))
        rows.append((begun, len(lines)))
        if i == chosen and item.more:
            say(item.more, QUIET, "  ")
    if known.head:
        lines.append(("", INK))
        say(known.head, INK)
        for name, value, error in known.rows:
            told = f"{value} {error}".rstrip()
            colour = QUIET if known.old else INK
            if len(name) + len(told) + 3 <= room:
                say(f"  {name}{told.rjust(room - len(name) - 2)}", colour)
            else:
                say(name, colour, "  ")
                say(told, colour, "    ")
    for text, holds, why in known.checks:
        say(f"{HOLDS[holds]}: {text}", QUIET if known.old else {True: FINE, False: WRONG, None: INK}[holds], "  ")
        if why:
            say(why, QUIET, "    ")
    lines.append(("", INK))
    lines += [(text, QUIET) for text in KEYS.splitlines()]
    for text in known.doubts:
        lines.append(("", INK))
        lines += [(part, QUIET) for part in broken(text, room)]
    if not known.doing and row * len(lines) + 2 * edge > least:
        lines[1] = "the wheel shows more below", QUIET
    page = Image.new("RGBA", (wide, max(least, row * len(lines) + 2 * edge)), GROUND)
    pen = ImageDraw.Draw(page)
    left, right = edge + round(2 * font(em)[1]), wide - edge
    for i, (text, colour) in enumerate(lines):
        top = edge + i * row
        written(pen, (edge, top), text, colour, em)
        if i in sliders:
            share, colour = sliders[i]
            share = min(max(share, 0.0), 1.0)
            middle, at = top + row // 2, round(left + share * (right - left))
            pen.rounded_rectangle((left, middle - bar // 2, right, middle + bar // 2), bar // 2, TRACK)
            pen.rounded_rectangle((left, middle - bar // 2, at, middle + bar // 2), bar // 2, colour)
            pen.ellipse((at - bar, middle - bar, at + bar, middle + bar), colour)
    return Column(premultiplied(page), [(edge + a * row, edge + b * row) for a, b in rows], left, right)


def notice(text: str, size: tuple[int, int], scale: float = 1.0) -> Image.Image:
    """What is wrong, as wide as it needs within a picture of a size and no higher than two fifths of it."""
    em, row, edge = (round(n * scale) for n in (EM, ROW - 2, EDGE))
    cell = font(em)[1]
    lines = broken(text, int((size[0] - 2 * edge) / cell))
    most = max(3, int((0.4 * size[1] - 2 * edge) / row))
    if len(lines) > most:
        lines = [*lines[: most - 1], f"... and {len(lines) - most + 1} lines more, as `pore check` tells"]
    wide = min(size[0], round(max(map(len, lines)) * cell) + 2 * edge)
    page = Image.new("RGBA", (wide, row * len(lines) + 2 * edge), OVER)
    pen = ImageDraw.Draw(page)
    for i, line in enumerate(lines):
        written(pen, (edge, edge + i * row), line, WRONG, em)
    pen.rectangle((0, 0, round(3 * scale), page.height), WRONG)
    return premultiplied(page)


def colours(scene: Scene, size: tuple[int, int]) -> Image.Image | None:
    """The scale of the colours of a scene with its numbers, of what it is and in what unit; none where it has none, or
    a picture of this size no room."""
    if scene.scale is None:
        return None
    try:
        strip = strip_of(size)
    except PoreError:
        return None
    said = scene.shown if not scene.unit or scene.unit == scene.shown else (
        scene.unit if scene.unit.startswith(scene.shown) else f"{scene.shown} {scene.unit}"
    )  # fmt: skip
    return premultiplied(Image.fromarray(np.array(legend(scene.scale, said, strip, size[1], transparent=True))))
