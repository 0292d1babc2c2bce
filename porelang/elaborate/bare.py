"""Bare numbers that are not what they look like: degrees that count as radians, numbers of percent beside shares."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from itertools import permutations

from porelang.diagnostics import Edit, Label
from porelang.elaborate.context import Context
from porelang.elaborate.values import Scalar, Value
from porelang.ir import Node, const, constant
from porelang.source import Span
from porelang.syntax.measures import with_unit
from porelang.units import RATIO

#: Bare angles from here on are doubted: nobody asks for one and a half turns in radians, and 10 degrees are common.
DEGREES_FROM = 10.0
#: The function of the prelude that makes a number of an angle.
DEGREES = "degrees"
_NUMBER = re.compile(r"(?<![\w.])(\d+\.?\d*|\.\d+)(?![\w.%])")
_NAMED = re.compile(r"\w+\s*=(?!=)\s*")


def doubt(
    ctx: Context,
    code: str,
    message: str,
    span: Span,
    label: str,
    hint: str,
    others: tuple[Label, ...] = (),
    edit: Edit | None = None,
) -> None:
    """Say a warning, once for a place: a list may come by it a hundred times."""
    ctx.error(code, message, span, label, others, hint, edit, "warning", once=True)


def value_of(argument: Span) -> Span:
    """The value of an argument that may have its name before it."""
    named = _NAMED.match(argument.text)
    return Span(argument.source, argument.start + (named.end() if named else 0), argument.end)


def short(text: str) -> str:
    text = " ".join(text.split())
    return text if len(text) <= 40 else text[:37] + "..."


def share_and_percent(ctx: Context, numbers: Sequence[Value], places: Sequence[Span]) -> None:
    """Doubt a comparison of a share of 1 with a number of percent: `porosity(f, within) < 70` is always so."""
    if len(numbers) != 2 or any(p.source.prelude for p in places):
        return
    for (share, at), (other, place) in permutations(zip(numbers, places, strict=True)):
        if not (isinstance(share, Scalar) and isinstance(other, Scalar)) or not _is_share(ctx, share.node):
            continue
        low, high = _ends(ctx, other.node)
        if other.dimension in (None, RATIO) and low > 1 and high <= 100:
            text = place.text
            right = with_unit(text, "%")
            doubt(
                ctx,
                "W226",
                f"`{short(at.text)}` is a share, from 0 to 1, and is compared with {text}",
                place,
                f"{text} is {low * 100:g}%" if low == high else "more than 1",
                f"write `{right}`",
                (Label(at, "never above 1"),),
                Edit(place, right),
            )


def _is_share(ctx: Context, n: Node) -> bool:
    """Whether a number surely lies from 0 to 1: a porosity, a param in percent, and what is left of one."""
    if n.op == "param":
        info = ctx.found.params.get(str(n.value))
        return info is not None and info.written == "%" and info.low >= 0 and info.high <= 1
    if n.op in ("min", "max", "mul"):
        return all(_is_share(ctx, a) for a in n.args)
    return n.op == "porosity" or (n.op == "sub" and ctx.constant(n.args[0]) == 1 and _is_share(ctx, n.args[1]))


def _ends(ctx: Context, n: Node) -> tuple[float, float]:
    """The least and the greatest that a constant or a param can be; not a number of anything else."""
    known = ctx.constant(n)
    info = ctx.found.params.get(str(n.value)) if n.op == "param" else None
    if info is not None and (info.numbers or not info.choices):
        return min(info.ends), max(info.ends)
    return (float(known), float(known)) if known is not None else (math.nan, math.nan)


def degrees(ctx: Context, value: Value, place: Span, called: str, rate: bool = False) -> None:
    """Doubt a bare number that stands for an angle and is far beyond a turn, or a number of degrees."""
    if place.source.prelude or not isinstance(value, Scalar) or value.dimension is not None:
        return
    if _counted_in_degrees(ctx, value, place, called, rate) or value.node.axes:
        return
    n = value.node
    info = ctx.found.params.get(str(n.value)) if n.op == "param" else None
    number = ctx.constant(n) if info is None or info.choices else info.default
    if not isinstance(number, float) or not DEGREES_FROM <= abs(number) < math.inf:
        return
    whole = value_of(place)
    text = whole.text
    numbers = [m for m in _NUMBER.finditer(text) if float(m[1]) >= DEGREES_FROM]
    large = {float(m[1]) for m in numbers}
    # 0.7 * i is what spreads things out in radians, sin(12.9898 * i) what makes up random numbers
    as_degrees = number * 4 % 1 == 0 and (any(v * 2 % 1 == 0 for v in large) or not re.search(r"\d", text))
    if re.search(r"\b(pi|tau|rad|turn)\b", text) or not (as_degrees or large & {180.0, 360.0}):
        return
    label, edit = f"{number / math.tau:.3g} turns", None
    if called == DEGREES:
        _of_radians(ctx, place, text, number)
        return
    if rate:
        hint = f"write the turn and the length it takes: `{number:g}deg / 10mm`"
        doubt(ctx, "W214", f"`{called}` turns by {number:g} rad/mm", place, f"{label} in every mm", hint)
        return
    if n.op == "param":
        hint = f"declare the param in degrees, `{number:g}deg in ...`, or write `{text} * 1deg`"
        edit = Edit(whole, f"{text} * 1deg")
    elif len(numbers) == 1:
        hint = f"write `{numbers[0][1]}deg`"
        at = whole.start + numbers[0].start()
        edit = Edit(Span(whole.source, at, at + len(numbers[0][1])), f"{numbers[0][1]}deg")
    else:
        instead = with_unit(text, "deg")
        hint, edit = f"write `{instead}`", Edit(whole, instead)
    doubt(ctx, "W214", f"`{called}` of {number:g} radians; are these degrees?", place, label, hint, edit=edit)


def _of_radians(ctx: Context, place: Span, text: str, number: float) -> None:
    """Doubt `degrees(30)`: it takes an angle and gives a number, so that an edit of its argument would help nobody."""
    right = with_unit(text, "deg")
    before = re.search(r"\bdegrees\s*\(\s*(?:angle\s*=\s*)?$", place.source.text[: place.start])
    after = re.match(r"\s*\)", place.source.text[place.end :])
    whole = Span(place.source, before.start(), place.end + after.end()) if before and after else None
    doubt(
        ctx,
        "W214",
        f"`{DEGREES}` of {number:g} radians; are these degrees?",
        whole or place,
        f"{number / math.tau:.3g} turns; what it gives is a number, no angle",
        f"an angle is written `{right}`: `{DEGREES}` makes a number of an angle",
        edit=None if whole is None else Edit(whole, right),
    )


def _counted_in_degrees(ctx: Context, value: Scalar, place: Span, called: str, rate: bool) -> bool:
    """Whether a number is one of degrees, as `degrees` makes it, and stands for an angle; then it is doubted."""
    n, text = value.node, value_of(place).text
    turned = n.args[0] if n.op == "neg" else const(-constant(n)) if n.op == "const" else n
    angle = ctx.in_degrees.get(n) or ctx.in_degrees.get(turned)
    if angle is None or (_NUMBER.fullmatch(text.lstrip("- ")) and not value.node.axes):
        return False  # a number that is written and happens to be the same is looked at as any other
    at = ctx.constant(angle.node)
    if angle.dimension is None and isinstance(at, float) and abs(at) >= DEGREES_FROM:
        return True  # `degrees(30)` itself has been doubted
    inside = re.fullmatch(r"(-?\s*)degrees\s*\(\s*(?:angle\s*=\s*)?([^()]*)\)", text)
    if inside:
        sign, angle_text = inside[1], inside[2]
        right = sign + (f"({angle_text})" if sign and not re.fullmatch(r"[\w.]+", angle_text) else angle_text)
        hint, edit = f"hand over the angle itself: `{right}`", Edit(value_of(place), right)
    else:
        right = with_unit(text, "deg")
        hint, edit = f"hand over the angle itself, or write `{right}`", Edit(value_of(place), right)
    message = f"`{called}` takes an angle, and this is a number of degrees, which counts as radians"
    doubt(ctx, "W214", message, place, "a number, as `degrees` makes it", hint, edit=None if rate else edit)
    return True
