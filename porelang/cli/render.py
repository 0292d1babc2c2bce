"""`pore render`: a picture of a part, with cuts and field planes, as PNG."""

from __future__ import annotations

import math
import re
import time
from argparse import ArgumentTypeError, Namespace

from porelang.atomic import destination
from porelang.cli import report
from porelang.diagnostics import PoreError, fail
from porelang.units import LENGTH, UNITS

AXES = "xyz"
VIEW_NAMES = ("iso", "front", "back", "left", "right", "top", "bottom")
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_WIDEST = 16384


def view(text: str) -> tuple[float, float] | str:
    """A name of a view, or `AZIMUTH,ELEVATION` in degrees."""
    if text in VIEW_NAMES:
        return text
    match = re.fullmatch(rf"\s*({_NUMBER})\s*,\s*({_NUMBER})\s*", text)
    if match is None or abs(float(match[2])) > 90 or abs(float(match[1])) > 1e6:
        raise ArgumentTypeError(
            f"`{text}` is no view: write {', '.join(VIEW_NAMES)}, or AZIMUTH,ELEVATION in degrees, as in -30,20"
        )
    return float(match[1]), float(match[2])


def picture_size(text: str) -> tuple[int, int]:
    """`WxH` in pixels."""
    match = re.fullmatch(r"(\d{1,6})x(\d{1,6})", text.strip().lower())
    if match is None or not all(1 <= int(v) <= _WIDEST for v in match.groups()):
        raise ArgumentTypeError(f"`{text}` is no size: write WIDTHxHEIGHT in pixels, as in 800x600")
    return int(match[1]), int(match[2])


def factor(text: str) -> float:
    """A number above 0."""
    value = float(text) if re.fullmatch(_NUMBER, text.strip()) else 0.0
    if not (math.isfinite(value) and 1e-3 <= value <= 1e4):
        raise ArgumentTypeError(f"`{text}` is no zoom: write 2 for twice as large")
    return value


def fineness(text: str) -> int:
    """1 to 6."""
    if text not in ("1", "2", "3", "4", "5", "6"):
        raise ArgumentTypeError(f"`{text}` is no number of samples: write 1 (rough) to 6 (smooth)")
    return int(text)


def _place(number: str, unit: str) -> float | None:
    known = UNITS.get(unit or "mm")
    value = float(number) * known.scale if known is not None and known.dimension == LENGTH else math.nan
    return value if math.isfinite(value) else None


def plane(text: str) -> tuple[int, float]:
    """`x=0`, `z = 1cm`: an axis and a place on it in mm."""
    match = re.fullmatch(rf"\s*([xyz])\s*=\s*({_NUMBER})\s*([A-Za-z]*)\s*", text)
    at = _place(match[2], match[3]) if match else None
    if match is None or at is None:
        raise ArgumentTypeError(f"`{text}` is no plane: write x=0 or z=15mm")
    return AXES.index(match[1]), at


def cut(text: str) -> tuple[tuple[int, bool, float], ...]:
    """`y<0`, `y<0 & z > 1cm`: for each side that is meant its axis, whether it lies below, and where, in mm."""
    sides = []
    for part in text.split("&"):
        match = re.fullmatch(rf"\s*([xyz])\s*([<>])\s*({_NUMBER})\s*([A-Za-z]*)\s*", part)
        at = _place(match[3], match[4]) if match else None
        if match is None or at is None:
            raise ArgumentTypeError(
                f"`{text}` cuts nothing: write what to take away in quotes, 'y<0', or 'y<0 & z>15mm' for a corner"
            )
        sides.append((AXES.index(match[1]), match[2] == "<", at))
    for axis in range(3):
        lo = max((at for a, below, at in sides if a == axis and not below), default=-math.inf)
        hi = min((at for a, below, at in sides if a == axis and below), default=math.inf)
        if lo >= hi:
            raise ArgumentTypeError(
                f"`{text}` takes nothing away: no place has {AXES[axis]} above {lo:g} and below {hi:g}"
                ": write --cut twice to take both sides"
            )
    return tuple(sides)


def value_range(text: str) -> tuple[float, float]:
    """`-20..20`: from zero or below it to zero or above it."""
    match = re.fullmatch(rf"\s*({_NUMBER})\s*\.\.\s*({_NUMBER})\s*", text)
    low, high = (float(match[1]), float(match[2])) if match else (0.0, 0.0)
    if not (low <= 0 <= high and low < high and math.isfinite(high - low)):
        raise ArgumentTypeError(f"`{text}` is no range of colours: zero has to lie in it, as in -20..20 or 0..1")
    return low, high


def render(options: Namespace) -> int:
    """Draw an output and write the picture. What can be refused is refused before anything is computed."""
    from porelang.cli.commands import broken_checks, load
    from porelang.render.camera import VIEWS
    from porelang.render.cuts import HalfSpace
    from porelang.render.picture import Wishes, render_output, write_png
    from porelang.render.planes import Plane, Scale

    if not options.output.lower().endswith(".png"):
        raise fail("E112", f"{options.output}: pictures are written as .png", hint="end the name with .png")
    destination(options.output)
    for option, given in (("--field", options.field), ("--range", options.range), ("--legend", options.legend)):
        if given is not None and not options.slice:
            raise fail("E108", f"{option} is about planes, and there is none", hint="add one: --slice x=0")
    if options.solid == "none" and not options.slice:
        raise fail("E108", "--solid none leaves nothing to be seen", hint="add a plane, as in --slice x=0")
    program, settings = load(options), dict(options.settings)
    if broken := broken_checks(program, settings):
        raise PoreError(broken)
    low, high = options.range or (0.0, 0.0)
    wishes = Wishes(
        size=options.size,
        view=VIEWS[options.view] if isinstance(options.view, str) else options.view,
        projection=options.projection,
        zoom=options.zoom,
        samples=options.samples,
        cuts=tuple(tuple(HalfSpace(*side) for side in c) for c in options.cut),
        slices=tuple(Plane(*p) for p in options.slice),
        field=options.field,
        scale=None if options.range is None else Scale(-low or high, high or -low),
        legend=options.legend,
        solid=options.solid or ("glass" if options.slice else "opaque"),
        transparent=options.background == "transparent",
    )
    start = time.perf_counter()
    bar = report.progress("drawing", options.quiet)
    made = render_output(program, options.out, wishes, options.bounds, settings, bar)
    write_png(made, options.output, wishes.transparent)
    seconds = round(time.perf_counter() - start, 3)
    width, height = options.size
    if not made.covered and wishes.solid != "none" and not options.quiet:
        report.note(
            f"no part of the solid is seen: it is cut away, thinner than {made.pixel:.2g} mm, or out of the picture"
        )
    if options.json:
        report.put(
            {
                "file": options.output,
                "output": program.output(options.out),
                "size": [width, height],
                "seconds": seconds,
                "steps": made.steps,
                "covered": made.covered,
                "pixel": made.pixel,
                "slice_range": None if made.scale is None else [-made.scale.low, made.scale.high],
                "backend": made.backend,
            }
        )
    elif not options.quiet:
        lines = {"size": f"{width} x {height} pixels of {made.pixel:.3g} mm"}
        if made.scale is not None:
            lines["planes"] = f"red -{made.scale.low:.3g}, yellow 0, blue {made.scale.high:.3g}"
        lines["time"] = f"{seconds:.2f} s ({made.backend})"
        print("\n".join([options.output, *(f"  {name:<10} {value}" for name, value in lines.items())]))
    return 0
