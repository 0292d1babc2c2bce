"""`frame("truss.json")`: bars between nodes, `{"nodes": [[x, y, z], ...], "bars": [[i, j], ...], "radii": [...]}`.

Nodes are in mm, bars name their nodes counted from 0, and there is one radius for each bar; `"radius"`, a single
number, stands for the same one everywhere. Other keys are a reader's own and are left alone.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
from typing import Any, BinaryIO, NoReturn

import numpy as np
from numpy.typing import NDArray

from porelang.data import FARTHEST, MOST_COUNTED, NEAREST, Segments
from porelang.diagnostics import PoreError, fail, suggest
from porelang.progress import tell
from porelang.source import Span
from porelang.tasks.datafile import remembered

#: Bytes of a file, which takes ten times that while it is read: some four million bars with radii of their own.
LARGEST = 256_000_000
#: Lists within lists: three are needed. The limit protects the stack of whoever parses the text.
_DEEPEST = 100
_CHUNK = 1 << 20
_STEPS = 5  # of reading: the text, its lists, the nodes, the bars, the radii
_FORM = '{"nodes": [[0, 0, 0], [10, 0, 0]], "bars": [[0, 1]], "radii": [1]}, lengths in mm'
_CELL = '{"nodes": [[0, 0, 0], [0.5, 0.5, 0.5]], "bars": [[0, 1]]}, in parts of the cell'
_NAMES = {bool: "true or false", str: "text", type(None): "null", list: "a list", dict: "an object"}


@dataclass(frozen=True, slots=True)
class _Asked:
    """The file that was asked for and where, for what is said of it; `cell` where it is that of a cell which repeats,
    in parts of its sides."""

    path: str
    span: Span | None
    cell: bool = False

    @property
    def form(self) -> str:
        return f"a cell is {_CELL}" if self.cell else f"a frame is {_FORM}"

    def fail(self, code: str, message: str, hint: str = "") -> PoreError:
        return fail(code, message, self.span, hint=hint or self.form)


class _NotJsonError(ValueError):
    """What is no JSON: a number or a name that stands there twice."""


def read_frame(path: str, span: Span | None = None) -> Segments:
    """The bars of a .json file, in mm. Errors: E130-E136, placed at `span`."""
    return remembered(path, ".json", "a frame", span, partial(_read, _Asked(path, span)))


def read_cell(path: str, span: Span | None = None) -> Segments:
    """The bars of a .json file in parts of a cell, with factors as radii. Errors: E130-E136, placed at `span`."""
    return remembered(path, ".json", "a cell", span, partial(_read, _Asked(path, span, cell=True)), "cell")


def _read(asked: _Asked, file: BinaryIO, size: int) -> Segments:
    if size > LARGEST:
        raise asked.fail("E135", f"`{asked.path}` is too large: {size:,} bytes of {LARGEST:,}", "split the frame")
    content = file.read(LARGEST + 1)
    tell(1, _STEPS)
    if _depth(content) > _DEEPEST:
        raise asked.fail(
            "E131",
            f"`{asked.path}` is no {'cell' if asked.cell else 'frame'}: its lists are nested over {_DEEPEST} deep",
        )
    try:
        found = json.loads(content.decode("utf-8-sig"), parse_constant=_constant, object_pairs_hook=_object)
    except UnicodeDecodeError as error:
        raise asked.fail("E131", f"`{asked.path}` is no text: byte {error.start} is not UTF-8") from None
    except json.JSONDecodeError as error:
        text = f"`{asked.path}` is no JSON: line {error.lineno}, column {error.colno}: {error.msg.lower()}"
        raise asked.fail("E131", text) from None
    except _NotJsonError as error:
        raise asked.fail("E134" if error.args[1:] else "E131", f"`{asked.path}`: {error.args[0]}") from None
    except (ValueError, RecursionError):  # a whole number of thousands of digits
        raise asked.fail("E134", f"`{asked.path}` holds a number that is too long to read") from None
    if not isinstance(found, dict):
        raise asked.fail(
            "E133",
            f"`{asked.path}` is {_NAMES.get(type(found), 'a number')}, not a {'cell' if asked.cell else 'frame'}",
        )
    tell(2, _STEPS)
    return _segments(asked, found)


def _segments(asked: _Asked, found: dict[str, Any]) -> Segments:
    nodes = _rows(asked, _list(asked, found, "nodes"), "nodes", "node", 3)
    if len(nodes) == 0:
        raise asked.fail("E133", f"`{asked.path}` has no nodes")
    _near_enough(asked, nodes, "node")
    tell(3, _STEPS)
    bars = _rows(asked, _list(asked, found, "bars"), "bars", "bar", 2)
    if len(bars) > MOST_COUNTED:
        text = f"`{asked.path}` has {len(bars):,} bars; float32 counts {MOST_COUNTED:,}"
        raise asked.fail("E135", text, "split the frame")
    tell(4, _STEPS)
    if len(bars) == 0:
        raise asked.fail("E133", f"`{asked.path}` has no bars")
    ends = _indices(asked, bars, len(nodes))
    radii = _radii(asked, found, len(bars))
    starts, stops = nodes[ends[:, 0]], nodes[ends[:, 1]]
    short = np.abs(stops - starts).max(axis=1) < NEAREST
    if short.any():
        bar = int(np.argmax(short))
        i, j = (int(v) for v in ends[bar])
        more = f", and {int(short.sum()) - 1:,} more like it" if short.sum() > 1 else ""
        at = ", ".join(f"{v:g}" for v in nodes[i])
        text = f"joins node {i} with itself" if i == j else f"joins nodes {i} and {j}, which both lie at ({at})"
        raise asked.fail("E136", f"bar {bar} of `{asked.path}` {text}{more}", "leave out bars that have no length")
    for array in (starts, stops, radii):
        array.setflags(write=False)
    return Segments(starts, stops, radii, (1.0, 1.0, 1.0) if asked.cell else None)


def _list(asked: _Asked, found: dict[str, Any], key: str) -> list[Any]:
    if key not in found:
        near = suggest(key, found)
        hint = f"rename `{near}` to `{key}`" if near else asked.form
        raise asked.fail("E132", f"`{asked.path}` has no `{key}`", hint)
    value = found[key]
    if type(value) is not list:
        raise asked.fail("E133", f"`{key}` in `{asked.path}` is {_named(value)}, not a list")
    return value


def _rows(asked: _Asked, rows: list[Any], key: str, thing: str, width: int) -> NDArray[np.float64]:
    """A list of lists of `width` numbers as an array; types are looked at, as NumPy would read "1" and true as 1."""
    if set(map(type, rows)) - {list}:
        at = next(i for i, row in enumerate(rows) if type(row) is not list)
        raise asked.fail("E133", f"{thing} {at} of `{asked.path}` is {_named(rows[at])}, not a list of {width} numbers")
    if set(map(len, rows)) - {width}:
        at = next(i for i, row in enumerate(rows) if len(row) != width)
        raise asked.fail("E133", f"{thing} {at} of `{asked.path}` has {len(rows[at])} numbers, not {width}")
    flat = list(chain.from_iterable(rows))
    _numbers_only(asked, flat, lambda at: f"{thing} {at // width} of `{asked.path}`")
    return _floats(flat).reshape(-1, width)


def _numbers_only(asked: _Asked, flat: Sequence[Any], place: Any) -> None:
    if set(map(type, flat)) - {int, float}:
        at = next(i for i, v in enumerate(flat) if type(v) not in (int, float))
        raise asked.fail("E133", f"{place(at)} holds {_named(flat[at])} where there must be a number")


def _floats(flat: list[Any]) -> NDArray[np.float64]:
    try:
        return np.array(flat, np.float64)
    except OverflowError:  # a whole number beyond all floats
        return np.array([float(v) if abs(v) < 1e300 else np.copysign(np.inf, float(v > 0) - 0.5) for v in flat])


def _near_enough(asked: _Asked, nodes: NDArray[np.float64], thing: str) -> None:
    far = ~(np.abs(nodes) <= FARTHEST).all(axis=1)
    if far.any():
        at = int(np.argmax(far))
        place = ", ".join(f"{v:g}" for v in nodes[at])
        hint = f"parts lie within {FARTHEST:,.0f} mm of the origin: lengths are in mm"
        hint = "places are in parts of the cell: 0 to 1" if asked.cell else hint
        raise asked.fail("E134", f"{thing} {at} of `{asked.path}` lies at ({place})", hint)


def _indices(asked: _Asked, bars: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    wrong = ~((bars >= 0) & (bars < count) & (bars == np.floor(bars))).all(axis=1)
    if wrong.any():
        bar = int(np.argmax(wrong))
        pair = bars[bar]
        first = next(float(v) for v in pair if not (0 <= v < count and v == np.floor(v)))
        if np.isfinite(first) and first != np.floor(first):
            text, hint = f"names the node {first:g}, which is no whole number", "bars name nodes by their number"
        else:
            text = f"names the node {first:.15g}, and there are {count:,} nodes"
            hint = f"nodes are counted from 0, so the last is {count - 1}"
        raise asked.fail("E136", f"bar {bar} of `{asked.path}` {text}", hint)
    return bars.astype(np.int64)


def _radii(asked: _Asked, found: dict[str, Any], count: int) -> NDArray[np.float64]:
    """One radius for each bar; of a cell a factor, which may be left out."""
    if asked.cell and "radii" not in found:
        return np.ones(count)
    if "radius" in found and not asked.cell:
        if "radii" in found:
            raise asked.fail("E133", f"`{asked.path}` has both `radius` and `radii`", "leave one of them out")
        _numbers_only(asked, [found["radius"]], lambda _: f"`radius` in `{asked.path}`")
        radii = np.repeat(_floats([found["radius"]]), count)
    else:
        listed = _list(asked, found, "radii")
        _numbers_only(asked, listed, lambda at: f"radius {at} of `{asked.path}`")
        if len(listed) != count:
            text = f"`{asked.path}` has {count:,} bars and {len(listed):,} radii"
            more = "leave it out if all are the same" if asked.cell else '"radius": 1 gives all the same'
            raise asked.fail("E133", text, f"one radius for each bar; {more}")
        radii = _floats(listed)
    wrong = ~((radii >= NEAREST) & (radii <= FARTHEST))
    if wrong.any():
        bar = int(np.argmax(wrong))
        more = f", and {int(wrong.sum()) - 1:,} more are wrong" if wrong.sum() > 1 else ""
        hint = "a factor of the radius is above 0" if asked.cell else "a radius is above 0, in mm"
        raise asked.fail("E134", f"the radius of bar {bar} of `{asked.path}` is {radii[bar]:g}{more}", hint)
    return radii


def _depth(content: bytes) -> int:
    """How deep the lists and objects of a text are nested at most; brackets within its words count too."""
    deepest, level = 0, 0
    for start in range(0, len(content), _CHUNK):
        part = np.frombuffer(content, np.uint8, min(_CHUNK, len(content) - start), start)
        folded = part & 0xDF  # `[` and `{`, `]` and `}` differ in one bit
        steps = (folded == ord("[")).view(np.int8) - (folded == ord("]")).view(np.int8)
        levels = level + np.cumsum(steps, dtype=np.int32)
        deepest, level = max(deepest, int(levels.max())), int(levels[-1])
    return deepest


def _constant(name: str) -> NoReturn:
    raise _NotJsonError(f"`{name}` is no number", "E134")


def _object(pairs: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    out: dict[str, Any] = {}
    for key, value in pairs:
        if key in out:
            shown = "".join(c if c.isprintable() else "?" for c in key[:60])
            raise _NotJsonError(f"`{shown}` stands there twice")
        out[key] = value
    return out


def _named(value: Any) -> str:
    return _NAMES.get(type(value), "a number")
