"""The values of options as words, on the command line and in a call: each reader takes one and gives what it means."""

from __future__ import annotations

import math
import re

from porelang.units import LENGTH, UNITS

AXES = "xyz"
VIEW_NAMES = ("iso", "front", "back", "left", "right", "top", "bottom")
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_WIDEST = 16384
#: What a length on the command line may be, in mm.
SHORTEST, LONGEST = 1e-9, 1e9


class Unreadable(Exception):  # noqa: N818 - it is a word that is unreadable
    """A word that is no value of its kind: what is wrong with it, and what to write."""

    def __init__(self, text: str, hint: str = "") -> None:
        super().__init__(text)
        self.text, self.hint = text, hint


def length(text: str) -> float:
    """`1mm`, `0.5`, `1e-1cm` in mm."""
    match = re.fullmatch(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([A-Za-z]*)", text.strip())
    unit = UNITS.get(match[2] or "mm") if match else None
    if match is None or unit is None or unit.dimension != LENGTH:
        point = text.replace(",", ".", 1)
        hint = f"decimals have a point: {point}" if re.match(r"\d*,\d", text.strip()) else "write 1mm or 0.5"
        raise Unreadable(f"`{text}` is no length", hint)
    value = float(match[1]) * unit.scale
    if not (math.isfinite(value) and value > 0):
        raise Unreadable(f"{text} is no length above 0", "as in 1mm or 0.5")
    if not SHORTEST <= value <= LONGEST:
        hint = "it is in mm" if text.strip()[-1].isdigit() else "lengths are from 1e-9mm to 1e9mm"
        raise Unreadable(f"{text} is {'longer than any part' if value > 1 else 'shorter than an atom'}", hint)
    return value


def output(text: str) -> str:
    """The name of a file or folder to be written."""
    if not text.strip():
        raise Unreadable("nothing is named to be written", "name a file: -o part.stl")
    if text == "-":
        raise Unreadable("results go to files, not to standard output", "name a file: -o part.stl")
    return text


def spacing(text: str) -> float | str:
    """A length, or `auto`."""
    return text if text == "auto" else length(text)


def cell(text: str) -> tuple[float, float, float]:
    """`10,10,15`, `1cm,1cm,15mm` in mm; one length is that of a cube."""
    words = text.split(",")
    if len(words) not in (1, 3):
        raise Unreadable(f"`{text}` is no cell", "write its sides along x, y and z: 10,10,15")
    x, y, z = (_side(word) for word in (words if len(words) == 3 else words * 3))
    return x, y, z


def _side(text: str) -> float:
    try:
        found = length(text)
    except Unreadable as no:
        raise Unreadable(f"`{text.strip()}` is no side of a cell", no.hint) from None
    if not 1e-6 <= found <= 1e5:
        raise Unreadable(f"`{text.strip()}` is no side of a cell", "sides lie between 1e-6 and 1e5 mm")
    return found


def poisson(text: str) -> float:
    """Poisson's ratio of a solid."""
    found = number(text)
    if not -1 < found < 0.5:
        raise Unreadable(
            f"{text.strip()} is no Poisson's ratio of a solid", "it lies between -1 and 0.5, without these"
        )
    return found


def voxels(text: str) -> int:
    """How many voxels lie along the longest side of a cell."""
    found = count(text)
    if not 8 <= found <= 256:
        raise Unreadable(f"{found} voxels along a cell cannot be had", "take from 8 to 256")
    return found


def number(text: str) -> float:
    """A finite number."""
    if not re.fullmatch(_NUMBER, text.strip()) or not math.isfinite(float(text)):
        raise Unreadable(f"`{text}` is no number", "write 0.3")
    return float(text)


def swept(text: str) -> tuple[str, str, str, int]:
    """`NAME=LO..HI:N`: a param, the ends of its range with or without a unit, and how many values."""
    match = re.fullmatch(r"\s*(\w+)\s*=\s*(.+?)\s*\.\.\s*(.+?)\s*:\s*(\d{1,9})\s*", text)
    if match is None:
        raise Unreadable(f"`{text}` is no sweep", "write a param, its range and how many values: t=0.2..1.2:6")
    if not 2 <= int(match[4]) <= 100:
        raise Unreadable(f"a sweep over {int(match[4])} values cannot be had", "take from 2 to 100: t=0.2..1.2:6")
    return match[1], match[2], match[3], int(match[4])


def size(text: str) -> float | str:
    """A length, `auto`, or the name of what says one."""
    name = text.strip()
    return name if name.isidentifier() else length(text)


def duration(text: str) -> float:
    """`90s`, `5min`, `2h`, or a number of seconds, in seconds."""
    match = re.fullmatch(rf"\s*({_NUMBER})\s*(s|min|h|)\s*", text)
    value = float(match[1]) * {"": 1, "s": 1, "min": 60, "h": 3600}[match[2]] if match else 0.0
    if not (math.isfinite(value) and value > 0):
        raise Unreadable(f"`{text}` is no time", "write 90s, 5min or 2h")
    return value


def phases(text: str) -> tuple[str, ...]:
    """`solid`, or `solid,void`."""
    found = tuple(word.strip() for word in text.split(","))
    if not set(found) <= {"solid", "void"} or len(set(found)) != len(found):
        raise Unreadable(f"`{text}` are no phases", "write solid, or solid,void")
    return found


def count(text: str) -> int:
    """A whole number above 0."""
    if not text.isascii() or not text.isdigit() or len(text) > 10 or int(text) < 1:
        raise Unreadable(f"`{text}` is no count", "write a whole number above 0")
    return int(text)


def steps(text: str) -> int:
    """A whole number, 0 or more: how many steps come after the start."""
    return 0 if text == "0" else count(text)


def box(text: str) -> tuple[float, ...]:
    """`x0,y0,z0,x1,y1,z1` in mm, the lower corner first."""
    try:
        values = tuple(float(v) for v in text.split(","))
    except ValueError:
        values = ()
    if len(values) != 6 or not all(map(math.isfinite, values)):
        raise Unreadable(f"`{text}` are no bounds", "write six numbers, x0,y0,z0,x1,y1,z1, in mm")
    for axis, lo, hi in zip("xyz", values[:3], values[3:], strict=True):
        if lo >= hi:
            raise Unreadable(
                f"the bounds are empty along {axis}, from {lo:g} to {hi:g}", "the lower corner comes first"
            )
        if hi - lo < SHORTEST:
            raise Unreadable(f"the bounds are thinner than an atom along {axis}: {hi - lo:g} mm", "they are in mm")
    return values


def setting(text: str) -> tuple[str, str]:
    """`NAME=VALUE`."""
    name, sign, value = text.partition("=")
    if not (sign and name.strip() and value.strip()):
        raise Unreadable(f"`{text}` sets nothing", "write NAME=VALUE, as in w=25mm")
    return name.strip(), value.strip()


#: What may be said after an array how it is read, as in a `load`.
_OPTION = re.compile(r",\s*(?=(?:outside|smooth|voxel|unit|lengths)\s*=)")


def binding(text: str) -> tuple[str, str, str, str]:
    """`NAME=FILE:ARRAY`, and what is said behind it."""
    name, sign, source = text.partition("=")
    try:
        file, array, options = array_of(source)
    except Unreadable:
        file = ""
    if not (sign and name.strip() and file):
        hint = "write NAME=FILE:ARRAY, as in stress=result.vtu:von_mises or stress=result.vtu:von_mises,unit=Pa"
        raise Unreadable(f"`{text}` binds nothing", hint)
    return name.strip(), file, array, options


def array_of(text: str) -> tuple[str, str, str]:
    """`FILE:ARRAY`, or `FILE:ARRAY,unit=Pa` with options as `load` has them."""
    source, *options = _OPTION.split(text)
    file, colon, array = source.rpartition(":")
    if not (colon and file.strip() and array.strip()):
        raise Unreadable(f"`{text:.60}` names no array of a file", "write FILE:ARRAY, as in result.vtu:von_mises")
    return file.strip(), array.strip(), ", ".join(option.strip() for option in options)


def view(text: str) -> tuple[float, float] | str:
    """A name of a view, or `AZIMUTH,ELEVATION` in degrees."""
    if text in VIEW_NAMES:
        return text
    match = re.fullmatch(rf"\s*({_NUMBER})\s*,\s*({_NUMBER})\s*", text)
    if match is None or abs(float(match[2])) > 90 or abs(float(match[1])) > 1e6:
        raise Unreadable(
            f"`{text}` is no view", f"write {', '.join(VIEW_NAMES)}, or AZIMUTH,ELEVATION in degrees, as in -30,20"
        )
    return float(match[1]), float(match[2])


def picture_size(text: str) -> tuple[int, int]:
    """`WxH` in pixels."""
    match = re.fullmatch(r"(\d{1,6})x(\d{1,6})", text.strip().lower())
    if match is None or not all(1 <= int(v) <= _WIDEST for v in match.groups()):
        raise Unreadable(f"`{text}` is no size", "write WIDTHxHEIGHT in pixels, as in 800x600")
    return int(match[1]), int(match[2])


def factor(text: str) -> float:
    """A number above 0."""
    value = float(text) if re.fullmatch(_NUMBER, text.strip()) else 0.0
    if not (math.isfinite(value) and 1e-3 <= value <= 1e4):
        raise Unreadable(f"`{text}` is no zoom", "write 2 for twice as large")
    return value


def deform(text: str) -> tuple[float | None, str]:
    """`s`, `120`, `120 s`, `120 * s.displacement`, `auto`, `auto s`: by how much (None: it is found), and of what."""
    turned = re.fullmatch(rf"([A-Za-z_][\w.]*)(?:\s*\*\s*|\s+(?:x\s*)?)({_NUMBER})", text.strip())
    if turned is not None:  # `s 120`, `s.displacement * 120`
        text = f"{turned[2]} {turned[1]}"
    match = re.fullmatch(r"(auto|[-+]?(?:[\d.][\d.eE+-]*|nan|inf\w*))(?:\s*[*x]\s*|\s+|$)([\w.]*)", text.strip())
    if match is None:
        return None, text.strip()
    if match[1] == "auto":
        return None, match[2]
    value = float(match[1]) if re.fullmatch(_NUMBER, match[1]) else math.nan
    if not 0 < value < math.inf:
        raise Unreadable(f"displacements cannot be drawn {match[1]} times as large",
                         "write a number above 0 (1 as they are), as in --deform 100, or leave it out")  # fmt: skip
    return value, match[2]


def share(text: str) -> float:
    """`50%` or `0.5`: above 0 and at most 1."""
    number, percent = (text.strip()[:-1], 100) if text.strip().endswith("%") else (text.strip(), 1)
    value = float(number) / percent if re.fullmatch(_NUMBER, number) else math.nan
    if not 0 < value <= 1:
        raise Unreadable(f"`{text}` is no share", "write 50% or 0.5: above 0 and at most 1")
    return value


def limits(text: str) -> tuple[float, float]:
    """`0.2..0.8` or `20%..80%`: densities, the least first."""
    low, dots, high = text.partition("..")
    if not dots or not (found := (share(low), share(high)))[0] < found[1]:
        raise Unreadable(f"`{text}` is no range of densities", "write the least and the greatest: 0.2..0.8")
    return found


def until(text: str) -> float:
    """`change<0.5%`, or the share alone."""
    match = re.fullmatch(r"\s*(?:change\s*<)?\s*([^<>=]+)", text)
    if match is None:
        raise Unreadable(f"`{text}` is no end of a loop", "write by how little the compliance changes: change<0.5%")
    return share(match[1])


def fineness(text: str) -> int:
    """1 to 6."""
    if text not in ("1", "2", "3", "4", "5", "6"):
        raise Unreadable(f"`{text}` is no number of samples", "write 1 (rough) to 6 (smooth)")
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
        raise Unreadable(f"`{text}` is no plane", "write x=0 or z=15mm")
    return AXES.index(match[1]), at


def cut(text: str) -> tuple[tuple[int, bool, float], ...]:
    """`y<0`, `y<0 & z > 1cm`: for each side that is meant its axis, whether it lies below, and where, in mm."""
    sides = []
    for part in text.split("&"):
        match = re.fullmatch(rf"\s*([xyz])\s*([<>])\s*({_NUMBER})\s*([A-Za-z]*)\s*", part)
        at = _place(match[3], match[4]) if match else None
        if match is None or at is None:
            raise Unreadable(
                f"`{text}` cuts nothing", "write what to take away in quotes, 'y<0', or 'y<0 & z>15mm' for a corner"
            )
        sides.append((AXES.index(match[1]), match[2] == "<", at))
    for axis in range(3):
        lo = max((at for a, below, at in sides if a == axis and not below), default=-math.inf)
        hi = min((at for a, below, at in sides if a == axis and below), default=math.inf)
        if lo >= hi:
            raise Unreadable(
                f"`{text}` takes nothing away: no place has {AXES[axis]} above {lo:g} and below {hi:g}",
                "write --cut twice to take both sides",
            )
    return tuple(sides)


def value_range(text: str) -> tuple[float, float]:
    """`-20..20`, `0.3..1.2`: the lower end first."""
    match = re.fullmatch(rf"\s*({_NUMBER})\s*\.\.\s*({_NUMBER})\s*", text)
    low, high = (float(match[1]), float(match[2])) if match else (0.0, 0.0)
    if not (low < high and math.isfinite(high - low)):
        raise Unreadable(f"`{text}` is no range of colours", "write the lower end first, as in -20..20 or 0..1")
    return low, high
