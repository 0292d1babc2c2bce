"""What points of a part show of the data that it reads: that they lie elsewhere, or are measured in another unit.

Data go on beyond their box as at its faces, without a word: of a file in metres, or one about another origin, a whole
part may read one value. What is read there counts only where it changes what is asked for.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.sampled import MOST, Points, inside_of, sampler
from porelang.data import SampledField, coordinates
from porelang.diagnostics import Diagnostic, Edit, PoreError
from porelang.formula import Bindings, Formula
from porelang.ir import Node, X, Y, Z, const, node, order, within
from porelang.source import Span
from porelang.tasks.bake import region
from porelang.tasks.readers.got import Got
from porelang.units import LENGTH, UNITS

#: What samples are, that end somewhere and are read as fields.
SAMPLES = ("load", "bound", "sample", "blur")
#: Steps beyond the last sample that are no matter: a skin, a fillet, a mesh that was cut a little smaller.
_STEPS = 2.0
#: So much of a part makes a doubt.
_SHARE, _FEW = 0.01, 8
#: Cells that all lie within so many mm may be measured in m.
_SMALL = 1.0
#: A box holds a part if it holds so much of it, and misses it if it holds less than the second; one that is so many
#: times as large holds it by chance.
_HOLDS, _MISSES, _LARGER = 0.9, 0.1, 4.0
_MOST_NODES = 20_000
_LOOKUPS = ("lookup", "lookup_cubic")


@dataclass(frozen=True, slots=True)
class Reading:
    """Fields that are read within a solid, and what is bound in them."""

    fields: tuple[Node, ...]
    body: Node
    bindings: Bindings


@dataclass(frozen=True, slots=True)
class _Stray:
    """How much of a solid reads beyond samples, from how far, and the places there (n, 3) as they are looked up."""

    share: float
    farthest: float
    places: Points
    unit: str


def strays(readings: Iterable[Reading], places: Mapping[Node, Span]) -> list[Diagnostic]:
    """A warning for each sampled field that a solid reads far beyond its samples: W231 where a unit of length would
    mend it, else W241."""
    worst: dict[Node, tuple[_Stray, SampledField]] = {}
    for reading in readings:
        read = [n for n in order(reading.fields, within) if n.op in _LOOKUPS and n.args[0].op in SAMPLES]
        if not read or len(order([*reading.fields, reading.body], within)) > _MOST_NODES:
            continue
        points = _points(reading)
        if points is None or len(points) < _FEW:
            continue
        for grid, at in dict.fromkeys((n.args[0], n.args[1:]) for n in read):
            data = reading.bindings.get(grid)
            if not isinstance(data, SampledField):
                continue
            stray = _stray(reading, grid, at, data, points)
            if stray is not None and (grid not in worst or stray.share > worst[grid][0].share):
                worst[grid] = stray, data
    return [_told(grid, data, stray, places.get(grid)) for grid, (stray, data) in worst.items()]


def specks(roots: Sequence[Node], bindings: Bindings, places: Mapping[Node, Span]) -> list[Diagnostic]:
    """W231 for each file that lies within a millimetre and is read there in mm, whether or not that is a part."""
    out: dict[Node, Diagnostic] = {}
    for n in order(roots, within):
        if n.op in _LOOKUPS and n.args[0].op == "load" and n.args[1:] == (X, Y, Z) and not _has_unit(n.args[0]):
            data = bindings.get(n.args[0])
            if isinstance(data, SampledField) and float((box := _box(data))[1].max() - box[0].min()) < _SMALL:
                size = " x ".join(f"{s:.3g}" for s in box[1] - box[0])
                said = f"all of this lies within {size} mm: is the file in metres?"
                out[n.args[0]] = _unit_doubt(said, "m", places.get(n.args[0]))
    return list(out.values())


def _points(reading: Reading) -> Points | None:
    """Points within the solid of a reading; of one that samples do not find at once its box has to be proven first."""
    points, at = inside_of(reading.body, reading.bindings), sampler([reading.body], reading.bindings)
    if points is not None or at is None:
        return points
    try:
        box = region(Formula((reading.body,), reading.bindings), "what is read")
    except PoreError:  # it has no end, or is nothing: more is said of that
        return None
    points = np.random.default_rng(1).uniform(box.lo, box.hi, (2 * MOST, 3))
    return points[at(points)[0] < 0]


def _stray(reading: Reading, grid: Node, at: tuple[Node, ...], data: SampledField, points: Points) -> _Stray | None:
    look = sampler(at, reading.bindings)
    if look is None:
        return None
    places = np.stack(look(points), -1)
    low, high = np.array(data.origin), np.array(data.end)
    away = np.maximum(np.maximum(low - places, places - high), 0)
    beyond = (away > _STEPS * np.array(data.spacing)).any(axis=1)
    if beyond.sum() < max(_FEW, _SHARE * len(points)):
        return None
    covered = any(n.op == "covers" and n.args == (grid, *at) for n in order(reading.fields, within))
    if covered and beyond.all():  # what holds outside is given, and holds throughout
        counts = np.ones(len(points), np.bool_)
    else:
        counts = np.zeros(len(points), np.bool_)
        counts[beyond] = _counts(reading, grid, at, data, points[beyond])
    share = float(counts.mean())
    if counts.sum() < _FEW or share < _SHARE:
        return None
    farthest = float(np.linalg.norm(away[counts], axis=1).max())
    unit = "" if grid.op != "load" or _has_unit(grid) else _unit_of(_box(data), places)
    return _Stray(share, farthest, places, unit)


def _counts(
    reading: Reading, grid: Node, at: tuple[Node, ...], data: SampledField, points: Points
) -> NDArray[np.bool_]:
    """At which points (n,) other values of some samples, which they may have elsewhere, change what is asked for."""
    now, out = sampler(reading.fields, reading.bindings), np.zeros(len(points), np.bool_)
    for greatest in (False, True):
        changed = sampler([_changed(f, grid, at, data, greatest) for f in reading.fields], reading.bindings)
        if now is None or changed is None:
            return out
        for a, b in zip(now(points), changed(points), strict=True):
            out |= ~np.isclose(a, b, rtol=1e-9, atol=1e-12, equal_nan=True)
    return out


def _changed(root: Node, grid: Node, at: tuple[Node, ...], data: SampledField, greatest: bool) -> Node:
    """A field with the least or the greatest of some samples in the place of what is looked up among them."""
    new: dict[Node, Node] = {}
    for n in order([root], within):
        if n.op in _LOOKUPS and n.args == (grid, *at):
            assert isinstance(n.value, tuple)
            values, slopes = data.values[..., int(n.value[0])], [int(v) for v in n.value[1:]]
            least, most = float(values.min()), float(values.max())
            steps = float(np.prod([s**k for s, k in zip(data.spacing, slopes, strict=True)]))
            value = most if greatest else least
            new[n] = const(value if not any(slopes) else (most - least) / steps * (1 if greatest else -1))
        else:
            new[n] = node(n.op, *(new.get(a, a) for a in n.args), value=n.value) if within(n) else n
    return new[root]


def _box(data: SampledField) -> tuple[Points, Points]:
    """The corners of the box of data: of cells that of these, not of their samples."""
    if not data.facts:
        return np.array(data.origin), np.array(data.end)
    got = Got.of(data)
    return np.array([got.low_x, got.low_y, got.low_z]), np.array([got.high_x, got.high_y, got.high_z])


def _has_unit(grid: Node) -> bool:
    """Whether the program says what the lengths of a file are."""
    return isinstance(grid.value, tuple) and len(grid.value) > 6 and bool(grid.value[6])


def _unit_of(box: tuple[Points, Points], places: Points) -> str:
    """The unit of length in which a box holds places that it misses in mm; "" where there is none."""

    def held(scale: float) -> float:
        room = 0.02 * scale * (box[1] - box[0])
        if scale * (box[1] - box[0]).max() > _LARGER * np.ptp(places, axis=0).max():
            return 0.0
        return float(((places >= scale * box[0] - room) & (places <= scale * box[1] + room)).all(axis=1).mean())

    if held(1.0) > _MISSES:
        return ""
    lengths = sorted((u.scale, name) for name, u in UNITS.items() if u.dimension == LENGTH and u.scale != 1)
    return next((name for scale, name in lengths if held(scale) > _HOLDS), "")


def _told(grid: Node, data: SampledField, stray: _Stray, place: Span | None) -> Diagnostic:
    low, high = _box(data)
    lie = f"they lie from ({coordinates(low)}) to ({coordinates(high)}) mm"
    if stray.unit:
        size = " x ".join(f"{s:.3g}" for s in high - low)
        said = f"these data of {size} mm hold nothing of the part, and would hold it if they were in {stray.unit}"
        return _unit_doubt(said, stray.unit, place, lie)
    much = "all" if stray.share > 0.995 else f"{stray.share:.0%}"
    what = "data" if grid.op in ("load", "bound") else "samples"
    said = f"{much} of the part lies beyond the {what} that it reads, by up to {stray.farthest:.3g} mm"
    first, last = stray.places.min(axis=0), stray.places.max(axis=0)
    if grid.op in ("sample", "blur"):
        hint = "give a `within` that holds the part: beyond it go on the values at its faces"
    else:
        seen = f"the part is looked up from ({coordinates(first, 3)}) to ({coordinates(last, 3)}) mm"
        hint = f"{seen}: move the data or the part, or say what holds beyond them, `outside=0`"
        shift, alike = (first + last - low - high) / 2, (last - first) / (high - low)
        if ((alike > 0.8) & (alike < 1.1)).all():  # as if one were moved against the other
            moved = ", ".join(f"{0.0 if abs(s) < 1e-3 * np.ptp(stray.places) else s:.3g}" for s in shift)
            hint = f"{seen}: `@ (p - [{moved}])` behind the data moves their middle to its middle"
        if grid.op == "bound":
            hint = f"{seen}: bind data that reach so far"
    return Diagnostic("W241", said, place, f"{lie}, and go on beyond as at their faces", hint=hint, severity="warning")


def _unit_doubt(said: str, unit: str, place: Span | None, label: str = "") -> Diagnostic:
    edit = None
    if place is not None and place.text.endswith(")"):
        edit = Edit(Span(place.source, place.end - 1, place.end), f", lengths={unit})")
    behind = place is not None and place.source.name.startswith("--bind ")
    how = f"{place.source.name}=FILE:ARRAY,lengths={unit}" if place is not None and behind else f"lengths={unit}"
    hint = f"say in what the file has its places: `{how}`"
    return Diagnostic("W231", said, place, label, hint=hint, edit=edit, severity="warning")
