"""A plot of powers: numbers over a density on logarithmic axes, each with its fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from porelang.picture import Picture
from porelang.render.marks import AXES, INK

Floats = NDArray[np.float64]
#: Pixels of the picture, how many times larger it is drawn, and the margins: left, top, right, bottom.
SIZE, FINER, MARGINS = (820, 620), 3, (90, 60, 30, 130)
GREY = (150, 150, 150)


def powers_picture(
    density: Sequence[float],
    lines: Mapping[str, tuple[Sequence[float], Sequence[float], Any]],
    bound: tuple[Floats, Floats],
    title: str,
) -> Picture:
    """Values by name with errors and a power C rho^n (`factor`, `exponent`) each, by density; `bound` is drawn grey."""
    rho = np.asarray(density)
    every = np.concatenate([np.asarray(v)[np.asarray(v) > 0] for v, _, _ in lines.values()])
    x_ends, y_ends = _ends(rho), _ends(every)
    y_ends = (y_ends[0], max(y_ends[1], 1.0))
    x_ends = (x_ends[0], 1.0)
    page = Image.new("RGB", (SIZE[0] * FINER, SIZE[1] * FINER), (255, 255, 255))
    pen, em = ImageDraw.Draw(page), 15 * FINER
    letters, small = ImageFont.load_default(em), ImageFont.load_default(0.9 * em)
    left, top, right, bottom = (m * FINER for m in MARGINS)
    wide, high = page.width - left - right, page.height - top - bottom

    def at(x: float, y: float) -> tuple[float, float]:
        u, v = (np.log(a / lo) / np.log(hi / lo) for a, (lo, hi) in ((x, x_ends), (y, y_ends)))
        return left + wide * float(u), top + high * (1 - float(v))

    for tick, named in _ticks(*x_ends):
        x, y = at(tick, y_ends[0])
        pen.line((x, y, x, top), fill=(225, 225, 225) if named else (243, 243, 243), width=FINER)
        if named:
            pen.text((x, y + 0.4 * em), f"{tick:g}", INK, small, anchor="ma")
    for tick, named in _ticks(*y_ends):
        x, y = at(x_ends[0], tick)
        pen.line((x, y, left + wide, y), fill=(225, 225, 225) if named else (243, 243, 243), width=FINER)
        if named:
            pen.text((x - 0.4 * em, y), f"{tick:g}", INK, small, anchor="rm")
    pen.rectangle((left, top, left + wide, top + high), outline=INK, width=FINER)
    inside = (bound[0] >= x_ends[0]) & (bound[1] >= y_ends[0])
    pen.line([at(x, y) for x, y in zip(bound[0][inside], bound[1][inside], strict=True)], fill=GREY, width=2 * FINER)
    caption = top + high + 2.0 * em
    pen.text((left + wide / 2, caption), "density (share of solid)", INK, letters, anchor="ma")
    for i, (name, (values, errors, fit)) in enumerate(lines.items()):
        colour = AXES[i % len(AXES)]
        ends = np.array([rho.min(), rho.max()])
        drawn = [at(x, fit.factor * x**fit.exponent) for x in np.geomspace(ends[0], ends[1], 40)]
        pen.line(drawn, fill=colour, width=FINER)
        for r, v, e in zip(rho, values, errors, strict=True):
            if v <= y_ends[0]:
                continue
            x, y = at(r, v)
            low, up = at(r, max(v - e, y_ends[0]))[1], at(r, min(v + e, y_ends[1]))[1]
            pen.line((x, low, x, up), fill=colour, width=2 * FINER)
            pen.ellipse((x - 4 * FINER, y - 4 * FINER, x + 4 * FINER, y + 4 * FINER), fill=colour)
        pen.text((left + (i % 2) * 0.53 * wide, caption + (1.6 + 1.4 * (i // 2)) * em), f"{name}: {fit}", colour, small)
    pen.text((left + 0.53 * wide, caption + 3.0 * em), "grey: E at the bounds of Hashin and Shtrikman", GREY, small)
    pen.text((left, top / 2), title, INK, _fitting(title, em, page.width - left - right), anchor="lm")
    shown = np.asarray(page.resize(SIZE, Image.Resampling.BOX))
    pixels = np.concatenate([shown, np.full((*shown.shape[:2], 1), 255, np.uint8)], axis=2)
    return Picture(pixels, None, 0.0, 1.0, 0.0, None, "numpy", 0.0)


def _fitting(text: str, em: int, room: float) -> Any:
    sizes = (s for s in range(em, 8, -1) if ImageFont.load_default(s).getlength(text) < room)
    return ImageFont.load_default(next(sizes, 8))


def _ends(values: Floats) -> tuple[float, float]:
    """Ends a little beyond values above 0."""
    low, high = float(values.min()), float(values.max())
    return low / 1.25, high * 1.25


def _ticks(low: float, high: float) -> list[tuple[float, bool]]:
    """The numbers 1 to 9 times a power of ten between two ends, and whether each is named: few enough are."""
    first, last = int(np.floor(np.log10(low))), int(np.ceil(np.log10(high)))
    every = [(k * 10.0**p, k) for p in range(first, last + 1) for k in range(1, 10)]
    return [(v, k in (1, 2, 5)) for v, k in every if low <= v <= high * (1 + 1e-9)]
