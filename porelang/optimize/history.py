"""The history of a loop as a table and as a picture."""

from __future__ import annotations

from collections.abc import Sequence

from PIL import Image, ImageDraw, ImageFont

from porelang.optimize.record import Step

INK, FAINT = (34, 32, 32), (222, 222, 222)
#: What the picture shows, relative to the start: the name, how it is had of a step, its colour.
_CURVES = (
    ("compliance", "compliance", (0, 90, 156)),
    ("max displacement", "max_displacement", (204, 102, 0)),
    ("stress per density", "stress_per_density", (0, 130, 90)),
    ("max von Mises", "max_von_mises", (150, 50, 120)),
)
#: What is called compliance under forces is, under displacements, the work that they take.
WORK = "work N mm (more is stiffer)"
_COLUMNS = (
    "step", "compliance N mm", "known to", "/ start", "max von Mises MPa", "stress/density MPa",
    "max displacement mm", "porosity", "change", "spread",
)  # fmt: skip


def table(steps: Sequence[Step], best: int) -> str:
    """A table in Markdown, a line for each step; the best has a star."""
    start = steps[0].compliance
    columns = [c if steps[0].under == "forces" else c.replace("compliance N mm", WORK) for c in _COLUMNS]
    rows = [
        (
            f"{s.number}{' *' if s.number == best else ''}", f"{s.compliance:.5g}",
            "" if s.error is None else f"{100 * s.error:.1f} %", f"{s.compliance / start:.3f}",
            f"{s.max_von_mises:.4g}", f"{s.stress_per_density:.4g}", f"{s.max_displacement:.4g}", f"{s.porosity:.4f}",
            "" if s.change is None else f"{100 * s.change:+.2f} %", f"{s.spread:.3f}",
        )
        for s in steps
    ]  # fmt: skip
    widths = [max(len(row[i]) for row in [columns, *rows]) for i in range(len(columns))]
    lines = ["| " + " | ".join(t.rjust(w) for t, w in zip(row, widths, strict=True)) + " |" for row in [columns, *rows]]
    lines.insert(1, "|" + "|".join("-" * (w + 1) + ":" for w in widths) + "|")
    return "\n".join(lines)


def plot(steps: Sequence[Step], best: int, title: str = "") -> Image.Image:
    """A picture: compliance, displacement and stresses of each step, relative to those of the start."""
    width, height, left, right, top, bottom = 1200, 720, 110, 40, 110, 70
    page = Image.new("RGB", (width, height), (255, 255, 255))
    pen = ImageDraw.Draw(page)
    small, large = ImageFont.load_default(22), ImageFont.load_default(26)
    curves = [
        (name, [getattr(s, key) / getattr(steps[0], key) for s in steps], colour) for name, key, colour in _CURVES
    ]
    values = [v for _, curve, _ in curves for v in curve]
    apart = _round(max(max(values) - min(0.9, *values), 0.1) / 6)
    low = apart * int(min(0.9, *values) / apart)
    high = apart * (int(max(values) / apart - 1e-9) + 1)
    last = max(1, len(steps) - 1)

    def at(number: int, value: float) -> tuple[float, float]:
        return (
            left + number / last * (width - left - right),
            top + (high - value) / (high - low) * (height - top - bottom),
        )

    for i in range(round((high - low) / apart) + 1):
        x, y = at(0, low + i * apart)
        pen.line((x, y, width - right, y), FAINT, 2)
        pen.text((x - 12, y), f"{low + i * apart:.4g}", INK, small, anchor="rm")
    for number in range(0, len(steps), 1 + len(steps) // 16):
        pen.text((at(number, low)[0], height - bottom + 10), str(number), INK, small, anchor="mt")
    pen.text(((left + width - right) / 2, height - 8), "step", INK, small, anchor="mb")
    for _, curve, colour in reversed(curves):  # the first lies on top
        points = [at(n, v) for n, v in enumerate(curve)]
        pen.line(points, colour, 4, joint="curve")
        for px, py in points:
            pen.ellipse((px - 5, py - 5, px + 5, py + 5), colour)
    x = float(left)
    for name, _, colour in curves:
        name = "work" if name == "compliance" and steps[0].under == "displacements" else name
        pen.line((x, 72, x + 34, 72), colour, 4)
        pen.text((x + 42, 72), name, INK, small, anchor="lm")
        x += 42 + small.getlength(name) + 36
    bx, by = at(best, curves[0][1][best])
    pen.ellipse((bx - 12, by - 12, bx + 12, by + 12), outline=_CURVES[0][2], width=3)
    side = Image.new("L", (height - top - bottom, 28))  # a text along the axis: drawn flat, and turned
    ImageDraw.Draw(side).text((side.width / 2, 14), "over step 0", 255, small, anchor="mm")
    page.paste(INK, (4, top), side.rotate(90, expand=True))
    pen.text((left, 36), title or "relative to the start", INK, large, anchor="lm")
    return page


def _round(step: float) -> float:
    """A round number near a step of an axis."""
    power = 10.0
    while power > step:
        power /= 10
    return next(power * n for n in (1, 2, 5, 10) if power * n >= step)
