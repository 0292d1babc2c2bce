"""What points of a part show of the data that it reads: that they lie elsewhere, or are measured in another unit.

Data go on beyond their box as at its faces, without a word: of a file in metres, or one about another origin, a whole
part may read one value. What is read there counts only where it changes what is asked for.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.sampled import MOST, Points, inside_of, sampler
from porelang.data import SampledField, coordinates, shown
from porelang.diagnostics import Diagnostic, Edit, PoreError
from porelang.doubts.elsewhere import LOOKUPS, Reading, counts_of
from porelang.formula import Bindings, Formula
from porelang.ir import Node, X, Y, Z, order, within
from porelang.source import Span
from porelang.tasks.bake import region
from porelang.tasks.readers.got import Got
from porelang.units import LENGTH, UNITS, written

#: What samples are, that end somewhere and are read as fields.
SAMPLES = ("load", "bound", "sample", "blur", "study")
#: Steps beyond the last sample, and what share of their box, that are no matter: a skin, a fillet, a mesh that was cut
#: a little smaller.
_STEPS, _SKIN = 2.0, 1 / 50
#: So much of a part makes a doubt.
_SHARE, _FEW = 0.01, 8
#: And so much of the solid that a task looks within: a blur or a mean of it hardly hangs on less, as on the skin of a
#: scan that is larger than what was computed of it.
_OF_TASK = 0.05
#: A part that is smaller than this share of a step of its data reads one value.
_BETWEEN = 0.5
#: Cells that all lie within so many mm may be measured in m.
_SMALL = 1.0
#: A box holds a part if it holds so much of it, and misses it if it holds less than the second; one that is so many
#: times as large holds it by chance.
_HOLDS, _MISSES, _LARGER = 0.9, 0.1, 4.0
_MOST_NODES = 20_000
#: How a source is called that stands in a command.
_BEHIND = "--bind "


@dataclass(frozen=True, slots=True)
class _Stray:
    """How much of a solid reads beyond samples, from how far, the corners (2, 3) of where it is looked up, the unit of
    lengths that would mend it, for which task it reads (None for a part), whether it is said what holds beyond, and
    whether it lies between two samples."""

    share: float
    farthest: float
    corners: Points
    unit: str
    task: Node | None
    covered: bool
    speck: bool = False


def strays(readings: Iterable[Reading], places: Mapping[Node, Span]) -> list[Diagnostic]:
    """A warning for each sampled field that a solid reads far beyond its samples: W231 where a unit of length would
    mend it, else W241."""
    worst: dict[Node, tuple[_Stray, SampledField]] = {}
    for reading in readings:
        read = [n for n in order(reading.fields, within) if n.op in LOOKUPS and n.args[0].op in SAMPLES]
        if not read or len(order([*reading.fields, reading.body], within)) > _MOST_NODES:
            continue
        points = points_of(reading)
        if points is None or len(points) < _FEW:
            continue
        for grid, at in dict.fromkeys((n.args[0], n.args[1:]) for n in read):
            data = reading.bindings.get(grid)
            if not isinstance(data, SampledField):
                continue
            stray = _stray(reading, grid, at, data, points)
            if stray is not None and (grid not in worst or _weight(stray) > _weight(worst[grid][0])):
                worst[grid] = stray, data
    return [_told(grid, data, stray, places) for grid, (stray, data) in worst.items()]


def _weight(stray: _Stray) -> tuple[bool, bool, float]:
    """Of several solids that read the same data beyond them one is named: a part, which a task may look within too."""
    return bool(stray.unit), stray.task is None, stray.share


def specks(roots: Sequence[Node], bindings: Bindings, places: Mapping[Node, Span]) -> list[Diagnostic]:
    """W231 for each file that lies within a millimetre and is read there in mm, whether or not that is a part."""
    out: dict[Node, Diagnostic] = {}
    for n in order(roots, within):
        if n.op in LOOKUPS and n.args[0].op == "load" and n.args[1:] == (X, Y, Z) and not _lengths(n.args[0]):
            data = bindings.get(n.args[0])
            if not isinstance(data, SampledField):
                continue
            box = _box(n.args[0], data)
            if float(box[1].max() - box[0].min()) < _SMALL:
                size = " x ".join(f"{s:.3g}" for s in box[1] - box[0])
                said = f"all of this lies within {size} mm: is the file in metres?"
                out[n.args[0]] = _unit_doubt(said, "m", places.get(n.args[0]))
    return list(out.values())


def points_of(reading: Reading) -> Points | None:
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
    if (speck := _speck(reading, grid, data, points, places)) is not None:
        return speck
    covered = any(n.op == "covers" and n.args == (grid, *at) for n in order(reading.fields, within))
    counted = np.ones(3, np.bool_) if covered else _varying(data)  # of those that are the same the end says nothing
    beyond = ((away > _STEPS * np.array(data.spacing) + _SKIN * (high - low)) & counted).any(axis=1)
    if beyond.sum() < max(_FEW, _SHARE * len(points)):
        return None
    if covered and beyond.all():  # what holds outside is given, and holds throughout
        counts = np.ones(len(points), np.bool_)
    else:
        counts = np.zeros(len(points), np.bool_)
        counts[beyond] = counts_of(reading, grid, at, data, points[beyond])
    least = _SHARE if reading.task is None else _OF_TASK
    if counts.sum() < _FEW or float(counts.mean()) < least:
        return None
    # what counts decides whether it is said; what is said is how much lies beyond, and how far, as anyone measures it
    share = float(((away > 0) & counted).any(axis=1).mean())
    corners = _corners(reading, points, places)
    reach = np.maximum(np.maximum(low - corners[0], corners[1] - high), 0) * counted
    farthest = max(float(np.linalg.norm(away * counted, axis=1).max()), float(reach.max()))
    unit = "" if grid.op != "load" or _lengths(grid) else _unit_of(_box(grid, data), places)
    return _Stray(share, farthest, corners, unit, reading.task, covered)


def _speck(reading: Reading, grid: Node, data: SampledField, points: Points, places: Points) -> _Stray | None:
    """A part that lies between two of many samples, of which it reads next to one value: they are in another unit."""
    if grid.op != "load" or np.ptp(places, axis=0).max() > _BETWEEN * min(data.spacing) or min(data.shape) <= 2:
        return None
    if not _varying(data).all():
        return None
    unit = _unit_of(_box(grid, data), places, _lengths(grid) or 1.0, within=True)
    corners = _corners(reading, points, places)
    return _Stray(0.0, 0.0, corners, unit, reading.task, False, True) if unit else None


def _varying(data: SampledField) -> NDArray[np.bool_]:
    """Along which axes the values are not the same throughout."""
    return np.array([bool((data.values != data.values.take([0], axis)).any()) for axis in range(3)])


def _corners(reading: Reading, points: Points, places: Points) -> Points:
    """The corners (2, 3) of the places at which points of a solid are looked up: where these are only moved, and the
    box that encloses the solid is as large as samples say, those of that box."""
    seen = np.stack([places.min(axis=0), places.max(axis=0)])
    moved = places - points
    if not np.allclose(moved, moved[0], atol=1e-6):
        return seen
    try:
        box = region(Formula((reading.body,), reading.bindings), "what is read")
    except PoreError:
        return seen
    enclosed = np.array([box.lo, box.hi]) + moved[0]
    return enclosed if np.allclose(enclosed, seen, rtol=0, atol=0.05 * np.ptp(seen, axis=0)) else seen


def _box(grid: Node, data: SampledField) -> tuple[Points, Points]:
    """The corners of the box of data: of cells of a file that of these, not of their samples."""
    if grid.op != "load" or not data.facts:
        return np.array(data.origin), np.array(data.end)
    got = Got.of(data)
    return np.array([got.low_x, got.low_y, got.low_z]), np.array([got.high_x, got.high_y, got.high_z])


def _lengths(grid: Node) -> float:
    """What the program says that a length of a file is, in mm; 0 where it does not say."""
    return float(grid.value[6]) if isinstance(grid.value, tuple) and len(grid.value) > 6 else 0.0


def _unit_of(box: tuple[Points, Points], places: Points, now: float = 1.0, within: bool = False) -> str:
    """The unit of length in which a box holds places that it misses in mm, or where its lengths are `now` mm; or which
    it holds `within` two samples. "" where there is none."""

    def held(scale: float) -> float:
        scale = scale / now
        room = 0.02 * scale * (box[1] - box[0])
        if scale * (box[1] - box[0]).max() > _LARGER * np.ptp(places, axis=0).max():
            return 0.0
        return float(((places >= scale * box[0] - room) & (places <= scale * box[1] + room)).all(axis=1).mean())

    if held(now) > _MISSES and not within:
        return ""
    lengths = sorted((u.scale, name) for name, u in UNITS.items() if u.dimension == LENGTH and u.scale != now)
    return next((name for scale, name in lengths if held(scale) > _HOLDS), "")


def _told(grid: Node, data: SampledField, stray: _Stray, where: Mapping[Node, Span]) -> Diagnostic:
    low, high = _box(grid, data)
    place = where.get(grid)
    lie = f"from ({coordinates(low)}) to ({coordinates(high)}) mm"
    if stray.speck:
        size = " x ".join(shown(s) for s in np.ptp(stray.corners, axis=0))
        said = f"the part of {size} mm lies between two samples of these data, {shown(min(data.spacing))} mm apart"
        said += f", and would fit them with `lengths={written(stray.unit)}`"
        hint = f"say in what the file has its places: `lengths={written(stray.unit)}`"
        return Diagnostic("W231", said, place, f"they lie {lie}", hint=hint, severity="warning")
    if stray.unit:
        size = " x ".join(f"{s:.3g}" for s in high - low)
        said = (
            f"these data of {size} mm hold nothing of the part, and would hold it with `lengths={written(stray.unit)}`"
        )
        return _unit_doubt(said, stray.unit, place, f"they lie {lie}")
    much = "all" if stray.share > 0.995 else f"{stray.share:.0%}"
    what = "data" if grid.op in ("load", "bound") else "samples"
    far = f"lies beyond the {what} that it reads, by up to {shown(stray.farthest)} mm"
    goes_on = "and beyond holds what `outside` says" if stray.covered else "and go on beyond as at their faces"
    read = f"from ({coordinates(stray.corners[0], 5)}) to ({coordinates(stray.corners[1], 5)}) mm"
    if stray.task is not None:
        said = f"{much} of the solid that this `{stray.task.op}` looks within {far}"
        names = f"`{' '.join(place.text.split())}`" if place is not None else f"these {what}"
        hint = f"that solid is looked up {read}: give one that lies in the {what}"
        hint += ", or say what holds beyond them, `outside=0`" if grid.op == "load" and not stray.covered else ""
        label = f"{names}: {lie}, {goes_on}"
        return Diagnostic("W241", said, where.get(stray.task), label, hint=hint, severity="warning")
    if grid.op in ("sample", "blur"):
        hint = "give a `within` that holds the part: beyond it go on the values at its faces"
    elif grid.op == "study":
        hint = f"the part is looked up {read}: study one that reaches so far"
        hint += "" if stray.covered else ", or say what holds beyond it, `outside=0`"
    else:
        seen = f"the part is looked up {read}"
        hint = f"{seen}: move the data or the part"
        hint += "" if stray.covered else ", or say what holds beyond them, `outside=0`"
        if grid.op == "bound":
            hint = f"{seen}: bind data that reach so far"
        if moved := _shift(stray.corners, low, high):
            hint = f"{seen}: `@ (p - {moved})` behind the data moves their middle to its middle"
            if place is not None and (grid.op == "bound" or place.source.name.startswith(_BEHIND)):
                name = place.text if grid.op == "bound" else place.source.name.removeprefix(_BEHIND)
                hint = f"{seen}: `{name} @ (p - {moved})` where the program reads it moves their middle to its middle"
                hint += ", or bind data that reach so far"
    said = f"{much} of the part {far}"
    label = f"they lie {lie}, {goes_on}"
    return Diagnostic("W241", said, place, label, hint=hint, severity="warning")


def _shift(corners: Points, low: Points, high: Points) -> str:
    """By what data are to be moved that are as large as what reads them; "" where they are not."""
    size = np.ptp(corners, axis=0)
    if not ((size > 0.8 * (high - low)) & (size < 1.1 * (high - low))).all():
        return ""
    shift = corners.mean(axis=0) - (low + high) / 2
    decimals = max(0, 4 - math.floor(math.log10(size.max())))
    moved = (0.0 if abs(s) < 1e-3 * size.max() else round(float(s), decimals) for s in shift)
    return f"[{', '.join(f'{s:.12g}' for s in moved)}]"


def _unit_doubt(said: str, unit: str, place: Span | None, label: str = "") -> Diagnostic:
    edit = None
    if place is not None and place.text.endswith(")"):
        edit = Edit(Span(place.source, place.end - 1, place.end), f", lengths={written(unit)})")
    behind = place is not None and place.source.name.startswith(_BEHIND)
    how = f"lengths={written(unit)}"
    how = f"{place.source.name}=FILE:ARRAY,{how}" if place is not None and behind else how
    hint = f"say in what the file has its places: `{how}`"
    return Diagnostic("W231", said, place, label, hint=hint, edit=edit, severity="warning")
