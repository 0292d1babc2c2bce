"""A picture of what depends on a direction alone: a surface as far from the middle as the number is large that way."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from porelang.compiled import compiled
from porelang.picture import Picture
from porelang.render.legend import legend, strip_of
from porelang.render.marks import AXES, INK
from porelang.render.scale import Ramp, fitting, scale_colours

Floats = NDArray[np.float64]
#: From where one looks: azimuth and elevation in degrees, so that x, y and z all come toward the viewer.
AZIMUTH, ELEVATION = 36.0, 26.0
#: Pixels along a side of the picture without its legend, and samples along a side of a pixel.
SIDE, SAMPLES = 720, 2
#: The share of the half picture that the greatest value takes, and how far axes reach beyond it.
REACH, BEYOND = 0.7, 1.25
_LIGHT = np.array([-0.35, 0.45, 0.82])  # to the right, up, toward the viewer
_AMBIENT = 0.8
#: A modulus below this (of the solid's) is none, and drawn as none.
_NOTHING = 1e-9


def modulus_picture(
    compliance: Floats, title: str, notes: Sequence[str] = (), unit: str = "E / E of the solid"
) -> Picture:
    """Young's modulus by direction, of a compliance (6, 6) by Voigt: 1 / E = n n : S : n n.

    Colours and distance both show it; the legend begins at its least value, and the rings on the axes are its scale.
    """
    right, up, toward = _camera()
    view = np.stack([right, up, toward])
    sphere = _sphere()
    every = _modulus(compliance, sphere)
    greatest, least = float(every.max()), float(every.min())
    size = SIDE * SAMPLES
    nothing = greatest < _NOTHING
    reach = 1.0 if nothing else greatest / REACH
    values, light, depth = np.full((size, size), np.nan), np.zeros((size, size)), np.full((size, size), -np.inf)
    if not nothing:
        _cast(compliance, view, reach, greatest, _LIGHT / np.linalg.norm(_LIGHT), values, light, depth)
    spread = greatest - least
    flat = spread < 1e-4 * greatest
    scale = Ramp(0.0, 1.0) if nothing else Ramp(0.98 * least, 1.02 * greatest) if flat else fitting(every)
    # shade as little as shows the form: a colour that is much darker is another value of the scale
    colours = scale_colours(values, scale) * (_AMBIENT + (1 - _AMBIENT) * light)[..., None]
    colours[np.isnan(values)] = 1.0
    page = Image.fromarray(np.rint(255 * np.clip(colours, 0, 1)).astype(np.uint8))
    _axes(page, view, reach, compliance, depth)
    small = np.asarray(page, np.float64).reshape(SIDE, SAMPLES, SIDE, SAMPLES, 3).mean(axis=(1, 3))
    solid = np.concatenate([np.rint(small), np.full((SIDE, SIDE, 1), 255.0)], axis=2).astype(np.uint8)
    strip = legend(scale, unit, strip_of((SIDE + 180, SIDE)), SIDE, False)
    pixels = np.concatenate([solid, strip], axis=1)
    pixels = _titled(pixels, title, notes)
    return Picture(pixels, None, 0.0, float(np.isfinite(values).mean()), 0.0, scale, "numpy", 0.0)


def _camera() -> tuple[Floats, Floats, Floats]:
    a, e = np.radians([AZIMUTH, ELEVATION])
    toward = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return right, np.cross(toward, right), toward


def _sphere(count: int = 4000) -> Floats:
    """Directions (n, 3) spread evenly, with the axes, face diagonals and space diagonals among them."""
    place = np.arange(count)
    z = 1 - (2 * place + 1) / count
    turn = place * np.pi * (3 - np.sqrt(5))
    flat = np.sqrt(1 - z * z)
    named = np.array([(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1) if i or j or k], float)
    return np.concatenate([np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1),
                           named / np.linalg.norm(named, axis=1, keepdims=True)])  # fmt: skip


def _modulus(compliance: Floats, n: Floats) -> Floats:
    x, y, z = n.T
    pull = np.stack([x * x, y * y, z * z, y * z, x * z, x * y], axis=1)
    return np.asarray(1 / np.einsum("ni,ij,nj->n", pull, compliance, pull))


@compiled
def _cast(s: Any, view: Any, reach: float, greatest: float, sun: Any, values: Any, light: Any, depth: Any) -> None:
    """Where each ray of an orthographic picture meets the surface: the modulus there, the light on it, and how
    far toward the viewer it lies. A ray is walked from in front of the sphere that holds everything."""
    height, width = values.shape
    p, g = np.empty(3), np.empty(3)
    steps = 160
    for row in range(height):
        v = (0.5 - (row + 0.5) / height) * 2 * reach
        for col in range(width):
            u = ((col + 0.5) / width - 0.5) * 2 * reach
            flat = greatest * greatest - u * u - v * v
            if flat <= 0:
                continue
            half = np.sqrt(flat)
            found, before = False, half
            for k in range(1, steps + 1):
                t = half - 2 * half * k / steps
                for i in range(3):
                    p[i] = u * view[0, i] + v * view[1, i] + t * view[2, i]
                if _beyond(s, p) < 0:
                    found = True
                    break
                before = t
            if not found:
                continue
            inner = t
            for _ in range(24):
                middle = (inner + before) / 2
                for i in range(3):
                    p[i] = u * view[0, i] + v * view[1, i] + middle * view[2, i]
                if _beyond(s, p) < 0:
                    inner = middle
                else:
                    before = middle
            for i in range(3):
                p[i] = u * view[0, i] + v * view[1, i] + inner * view[2, i]
            length = np.sqrt(p[0] ** 2 + p[1] ** 2 + p[2] ** 2)
            values[row, col] = length
            depth[row, col] = inner
            step = 1e-4 * greatest
            for i in range(3):
                p[i] += step
                above = _beyond(s, p)
                p[i] -= 2 * step
                g[i] = above - _beyond(s, p)
                p[i] += step
            norm = np.sqrt(g[0] ** 2 + g[1] ** 2 + g[2] ** 2)
            lit = 0.0
            for i in range(3):
                for j in range(3):
                    lit += sun[i] * view[i, j] * g[j] / norm
            light[row, col] = max(0.0, lit)


@compiled
def _beyond(s: Any, p: Any) -> float:
    """How far a point lies outside of the surface: |p| less the modulus that way."""
    x, y, z = p[0], p[1], p[2]
    r2 = x * x + y * y + z * z
    if r2 == 0:
        return -1.0
    a, b, c, d, e, f = x * x, y * y, z * z, y * z, x * z, x * y
    q = (
        s[0, 0] * a * a + s[1, 1] * b * b + s[2, 2] * c * c + s[3, 3] * d * d + s[4, 4] * e * e + s[5, 5] * f * f
        + 2 * (s[0, 1] * a * b + s[0, 2] * a * c + s[0, 3] * a * d + s[0, 4] * a * e + s[0, 5] * a * f
               + s[1, 2] * b * c + s[1, 3] * b * d + s[1, 4] * b * e + s[1, 5] * b * f
               + s[2, 3] * c * d + s[2, 4] * c * e + s[2, 5] * c * f
               + s[3, 4] * d * e + s[3, 5] * d * f + s[4, 5] * e * f)
    )  # fmt: skip
    far: float = np.sqrt(r2) - r2 * r2 / q
    return far


def _axes(page: Image.Image, view: Floats, reach: float, compliance: Floats, depth: Floats) -> None:
    """The axes from where they leave the surface, with ticks at round numbers and their names; in place.

    What the surface hides of them is left out.
    """
    pen, size = ImageDraw.Draw(page), page.width
    em = size // 36
    letters, figures = ImageFont.load_default(em), ImageFont.load_default(0.72 * em)
    greatest = REACH * reach
    end, tick = BEYOND * greatest, _round(greatest / 2)

    def at(point: Floats) -> tuple[float, float]:
        u, v = view[:2] @ point
        return (u / reach + 1) * size / 2, (1 - v / reach) * size / 2

    def seen(point: Floats) -> bool:
        x, y = (int(np.clip(v, 0, size - 1)) for v in at(point))
        return bool(view[2] @ point > depth[y, x] - 0.01 * greatest)

    for axis, name in enumerate("xyz"):
        along, colour = np.eye(3)[axis], AXES[axis]
        start = float(_modulus(compliance, along[None])[0])
        places = [d * along for d in np.linspace(start, end, 200)]
        for a, b in pairwise(places):
            if seen(a) and seen(b):
                pen.line((*at(a), *at(b)), fill=colour, width=max(2, em // 9))
        x, y = at((end + 0.075 * greatest) * along)
        pen.text((x, y), name, colour, letters, anchor="mm")
        side = np.array(at(along)) - np.array(at(np.zeros(3)))
        side = np.array([-side[1], side[0]]) / max(float(np.linalg.norm(side)), 1e-9)
        for k in range(1, int(end / tick) + 1):
            x, y = at(k * tick * along)
            label = x + side[0] * 1.1 * em, y + side[1] * 0.95 * em
            behind = depth[int(np.clip(label[1], 0, size - 1)), int(np.clip(label[0], 0, size - 1))] > -np.inf
            if k * tick <= 1.03 * start or not seen(k * tick * along):
                continue
            pen.line((x - side[0] * em / 4, y - side[1] * em / 4, x + side[0] * em / 4, y + side[1] * em / 4),
                     fill=colour, width=max(2, em // 10))  # fmt: skip
            if not behind:
                pen.text(label, f"{k * tick:.3g}", INK, figures, anchor="mm")


def _round(value: float) -> float:
    """The round number (1, 2 or 5 times a power of ten) next below a value."""
    power = 10.0 ** np.floor(np.log10(value)) if value > 0 else 1.0
    return float(max(r * power for r in (1, 2, 5) if r * power <= value * (1 + 1e-9)) if value > 0 else 1.0)


def _titled(pixels: NDArray[np.uint8], title: str, notes: Sequence[str]) -> NDArray[np.uint8]:
    """A picture under a title, and over lines of notes."""
    wide, em = pixels.shape[1], SIDE // 32
    top, bottom = int(2.4 * em), int((1.45 * len(notes) + 0.8) * em) if notes else 0
    page = Image.new("RGBA", (wide, pixels.shape[0] + top + bottom), (255, 255, 255, 255))
    page.paste(Image.fromarray(pixels), (0, top))
    pen = ImageDraw.Draw(page)
    fits = (s for s in range(em, 7, -1) if ImageFont.load_default(s).getlength(title) < wide - em)
    pen.text((em, 0.75 * em), title, INK, ImageFont.load_default(next(fits, 8)))
    for i, line in enumerate(notes):
        sizes = (
            size for size in range(em, 7, -1) if ImageFont.load_default(0.85 * size).getlength(line) < wide - 2 * em
        )
        font = ImageFont.load_default(0.85 * next(sizes, 8))
        pen.text((em, top + pixels.shape[0] + (1.45 * i + 0.1) * em), line, INK, font)
    return np.asarray(page)
