"""What Python asks of a design, done as the commands do it: words read as values, checks kept, doubts told as warnings.

The options and their defaults stand in `doors`.

The functions that do the work (`mesh.part`, `measure`, `slices`, `render`) take values that are ready.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import numpy as np

from porelang import values
from porelang.backends.numpy import Dtype
from porelang.checks import broken_checks, undecided_checks
from porelang.data import figures
from porelang.diagnostics import PoreError, fail, to_lists, warn
from porelang.doors import Length
from porelang.field import Backend, Bounds
from porelang.html import table, title
from porelang.picture import Picture
from porelang.program import Design

if TYPE_CHECKING:
    from porelang.optimize.run import Optimized
    from porelang.strength import Strength
    from porelang.tetrahedra import Tetrahedra

Some = TypeVar("Some")
_UNITS = {"volume": "mm3", "envelope_volume": "mm3", "area": "mm2"}


def mesh(
    design: Design, name: str | None, voxel: Length | None, resolution: int | None, bounds: Bounds | str | None,
    backend: Backend, dtype: Dtype, smooth: bool, sharp: bool, simplify: Length | None, check: bool, force: bool,
) -> Any:  # fmt: skip
    """The surface of an output as a `trimesh.Trimesh`; see `Program.mesh`."""
    from porelang.mesh.made import make

    spacing, deviation = length("voxel", voxel, values.spacing), length("simplify", simplify)
    if check:
        keep_checks(design)
    limits: Bounds | None = read("bounds", bounds, values.box)
    made = make(design, name, spacing, resolution, limits, backend, dtype, smooth, sharp, deviation, force)
    open_checks = undecided_checks(design) if check else []
    warn([*open_checks, *made.doubts, *design.told(*design.program.roots(name))])
    return made.surface.to_trimesh()


def measure(
    design: Design, name: str | None, within: str | None, voxel: Length | None, resolution: int | None,
    bounds: Bounds | str | None, backend: Backend, dtype: Dtype,
) -> Report:  # fmt: skip
    """What an output measures; see `Program.measure`."""
    from porelang.measure import measure as measured

    limits: Bounds | None = read("bounds", bounds, values.box)
    with np.errstate(all="ignore"):  # a field may be infinite somewhere, and that is told
        found = measured(design, name, within, length("voxel", voxel), resolution, limits, backend, dtype)
    broken = broken_checks(design, measure=True)
    asked = [*design.program.roots(name), *design.program.graph.checks]
    doubts = [*undecided_checks(design), *design.told(*asked)]
    warn([*broken, *doubts])
    listed = {"failed_checks": [d.to_json() for d in broken], **to_lists(doubts)}
    return Report(design.program.output(name), found | listed)


def study(design: Design, name: str | None, refine: bool, within: str | None) -> Strength:
    """A study of the program in elements; see `Program.study`."""
    from porelang.strength import carry_out

    found = carry_out(design, name, refine, within)
    warn([d for d in found.told if d.severity == "warning"])
    return found


def iterate(
    design: Design, name: str | None, until: float | str, most: int | str, rule: Any,
    limits: tuple[float, float] | str, porosity: float | str | None, adapt: str | None, study: str | None,
    within: str | None, cell: Length | None, damping: float | str, folder: str | Path | None, resume: bool,
    force: bool, early: str | None,
) -> Optimized:  # fmt: skip
    """The loop from stress back to geometry; see `Program.iterate`."""
    from porelang.optimize.run import optimize

    change, share = number("until", until, values.until), number("damping", damping, values.share)
    void = None if porosity is None else number("porosity", porosity, values.share)
    densities = pair("limits", read("limits", limits, values.limits))
    if not isinstance(folder, str | Path | None):
        raise fail("E108", f"folder: {folder!r:.60} is no folder", hint='give its path: folder="part.loop"')
    found = optimize(design, name, change, whole("most", most), rule, densities, void, adapt, study, within,
                     length("cell", cell), share, folder, resume, early, force=force)  # fmt: skip
    warn(found.told)
    return found


def tet(
    design: Design, name: str | None, size: Length | None, surface_size: Length | None,
    mesher: Literal["direct", "ftetwild"], phases: str | Sequence[str], bounds: Bounds | str | None,
    keep_islands: bool, time_limit: float | str | None, check: bool, force: bool,
) -> Tetrahedra:  # fmt: skip
    """An output as tetrahedra; see `Program.tet`."""
    from porelang.tetrahedra import tetrahedra

    edge, at_surface = length("size", size, values.size), length("surface_size", surface_size)
    wanted: Sequence[str] = read("phases", phases, values.phases)
    if check:
        keep_checks(design)
    made = tetrahedra(
        design, name, edge, mesher, wanted, surface_size=at_surface, bounds=read("bounds", bounds, values.box),
        keep_islands=keep_islands, time_limit=read("time_limit", time_limit, values.duration), force=force,
    )  # fmt: skip
    warn([*(undecided_checks(design) if check else []), *made.doubts, *design.told(*design.program.roots(name))])
    return made


def slices(
    design: Design, name: str | None, folder: str | Path, step: Length, format: Literal["png", "svg"],
    voxel: Length | None, bounds: Bounds | str | None, backend: Backend, dtype: Dtype, check: bool,
) -> Layers:  # fmt: skip
    """The layers of an output, written into a folder; see `Program.slices`."""
    from porelang.mesh.doubts import layer_doubts
    from porelang.slices import write_slices

    if format not in ("png", "svg"):
        raise fail("E108", f"layers are no {format!r}", hint="choose from png, svg")
    apart, pixel = length("step", step), length("voxel", voxel)
    limits: Bounds | None = read("bounds", bounds, values.box)
    if apart is None:
        raise fail("E114", "layers need a step", hint='give their thickness: step="0.1mm"')
    if check:
        keep_checks(design)
    found = write_slices(design, folder, apart, name=name, form=format, pixel=pixel, bounds=limits,
                         backend=backend, dtype=dtype)  # fmt: skip
    doubts = layer_doubts(design, name, limits, found["volume"], found["step"], found["pixel"])
    doubts += [*(undecided_checks(design) if check else []), *design.told(*design.program.roots(name))]
    warn(doubts)
    return Layers(folder, found)


def render(
    design: Design, name: str | Sequence[str] | None, *, bodies: bool, view: str | tuple[float, float],
    size: str | tuple[int, int], cut: str | Sequence[str], slice: str | Sequence[str], field: str | None,
    range: str | tuple[float, float] | None, legend: bool | str, deform: bool | str | float,
    bounds: Bounds | str | None, check: bool, **more: Any,
) -> Picture:  # fmt: skip
    """A picture of an output, or of several; see `Program.render`."""
    from porelang.render.picture import bodies_of, render_output, roots_shown
    from porelang.render.wishes import wishes_of

    cuts, planes = ([one] if isinstance(one, str) else list(one) for one in (cut, slice))
    names = bodies_of(design.program) if bodies else name
    for what, reader in (("zoom", values.factor), ("samples", values.fineness)):
        if what in more:
            more[what] = read(what, str(more[what]), reader)
    for what, known in _WORDS.items():
        if what in more and more[what] not in known:
            words = ", ".join(word for word in known if word)
            raise fail("E108", f"{what} cannot be {more[what]!r}", hint=f"choose from {words}")
    wishes = wishes_of(
        view=read("view", view if isinstance(view, str) else _joined(view), values.view),
        size=read("size", size if isinstance(size, str) else _joined(size, "x"), values.picture_size),
        cut=[read("cut", one, values.cut) for one in cuts],
        slice=[read("slice", one, values.plane) for one in planes],
        field=field,
        range=None if range is None else read("range", range if isinstance(range, str) else _joined(range, ".."),
                                              values.value_range),
        legend="" if legend is True else legend or None,
        deform=None if deform is False or deform is None else read(
            "deform", "auto" if deform is True else str(deform), values.deform),
        several=not isinstance(names, str | None) and len(set(names)) > 1,
        **more,
    )  # fmt: skip
    if check:
        keep_checks(design, measure=False)
    made = render_output(design, names, wishes, read("bounds", bounds, values.box))
    warn([*design.told(*roots_shown(design.program, names, wishes)), *made.told])
    return made


def homogenize(
    design: Design, name: str | None, cell: float | str | Sequence[float | str] | None, nu: float | str,
    resolution: int | str, sweep: str | None, check: bool, fixed: Collection[str] = (),
) -> Any:  # fmt: skip
    """A period of an output as a material, or of a sweep each, of a param that is not among those `fixed`; see
    `Program.homogenize`."""
    from porelang import homogenize as work

    sides = None if cell is None else read("cell", cell if isinstance(cell, str) else _joined(cell), values.cell)
    ratio, voxels = number("nu", nu, values.poisson), whole("resolution", resolution, 64)
    if check:
        keep_checks(design)
    found: Any
    if sweep is None:
        found = work.homogenize(design, name, sides, ratio, voxels)
    else:
        if not isinstance(sweep, str):
            raise fail("E108", f"sweep: {sweep!r:.60} is no sweep",
                       hint='a text of a param, its range and how many values: sweep="t=0.2..1.2:6"')  # fmt: skip
        param, low, high, count = read("sweep", sweep, values.swept)
        found = work.sweep(design, param, low, high, count, name, sides, ratio, voxels, fixed)
    warn([*found.doubts, *design.told(*design.program.roots(name))])
    return found


#: What options may be that are one of a few words.
_WORDS = {
    "projection": ("perspective", "orthographic"),
    "solid": ("none", "opaque", "glass", None),
    "background": ("white", "transparent"),
    "frame": ("surface", "bounds"),
}


def _joined(given: Any, sign: str = ",") -> str:
    """Numbers as the command line has them, so that there is one reader of each option."""
    try:
        return sign.join(str(v) for v in given)
    except TypeError:
        return str(given)


def keep_checks(design: Design, measure: bool = True) -> None:
    """Refuse a design of which a `check` fails, those about whole fields included if `measure`. Errors: E068."""
    if broken := broken_checks(design, measure):
        raise PoreError(broken)


def read(what: str, given: Any, reader: Callable[[str], Some]) -> Any:
    """A text read as the command line reads it; what is no text stays as it is. Errors: E108."""
    if not isinstance(given, str):
        return given
    try:
        return reader(given)
    except values.Unreadable as no:
        raise fail("E108", f"{what}: {no.text}", hint=no.hint) from None


def number(what: str, given: Any, reader: Callable[[str], float]) -> float:
    """A number, or a text that says one. Errors: E108 for what is none."""
    value = read(what, given, reader)
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        raise fail("E108", f"{what}: {given!r:.60} is no number", hint=f"as in {what}=0.5")
    return float(value)


def whole(what: str, given: Any, usual: int = 15) -> int:
    """A count, of which one is `usual`. Errors: E108 for what is none."""
    value = read(what, given, values.steps if what == "most" else values.count)
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise fail("E108", f"{what}: {given!r:.60} is no whole number", hint=f"as in {what}={usual}")
    return int(value)


def pair(what: str, given: Any) -> tuple[float, float]:
    """Two numbers. Errors: E108 for what is not that."""
    try:
        low, high = given
        return float(low), float(high)
    except (TypeError, ValueError):
        hint = f'as in {what}=(0.2, 0.8), or {what}="0.2..0.8"'
        raise fail("E108", f"{what}: {given!r:.60} is no pair of numbers", hint=hint) from None


def length(what: str, given: Length | None, reader: Callable[[str], Any] = values.length) -> Any:
    """A length in mm, or a text that says one, as that; whether there can be one so long is judged by who uses it.

    Errors: E114."""
    if given is None or (isinstance(given, int | float | np.number) and not isinstance(given, bool)):
        return given
    if not isinstance(given, str):
        hint = f'in Python lengths are numbers of mm, or texts with a unit: {what}=0.5, {what}="0.5mm"'
        raise fail("E114", f"{what}={given!r:.60} is no length", hint=hint)
    try:
        return reader(given)
    except values.Unreadable as no:
        raise fail(
            "E114", f"{what}: {no.text}", hint=f'a length is a number of mm or has a unit: {what}="0.5mm"'
        ) from None


class Report(dict[str, Any]):
    """What a part measures, by the keys of `pore measure --json`; printed as a table with the errors."""

    def __init__(self, output: str = "part", found: Mapping[str, Any] | None = None) -> None:
        super().__init__(found or {})
        self.output = output

    def rows(self) -> list[tuple[str, str, str]]:
        """Each quantity that has an error: its name, value and error, with units."""
        out = []
        for key, error in self.get("error", {}).items():
            if key == "bounds_by_axis":  # the largest of them is told
                continue
            unit, value = _UNITS.get(key, ""), self[key]
            if key == "bounds":
                key, unit = "size", "mm"
                value = " x ".join(f"{b - a:.5g}" for a, b in zip(*value, strict=True))
            if not math.isfinite(error):
                told, off = "not certain at this voxel", ""
            elif isinstance(value, int) and error:
                told, off = f"not certain at this voxel ({value} are counted)", ""
            else:
                told, off = str(value), f"{error:.2g}"
                if isinstance(value, float):
                    told, off = figures(value, error).split(" +- ")
                told, off = f"{told} {unit}".rstrip(), f"+- {off} {unit}".rstrip() if error else ""
            out.append((key, told, off))
        for text, number in self.get("reduced", {}).items():
            told, off = figures(number["value"], number["error"]).split(" +- ")
            unit = number["unit"]
            out.append((text, f"{told} {unit}".rstrip(), f"+- {off} {unit}".rstrip()))
        return out

    def __repr__(self) -> str:
        told = ", ".join(f"{name} {value} {error}" for name, value, error in self.rows()[:3])
        failed = len(self.get("failed_checks", ()))
        return f"<report of {self.output}: {told}{f'; {failed} failed checks' if failed else ''}>"

    def __str__(self) -> str:
        rows = self.rows()
        wide, long = (max((len(row[i]) for row in rows), default=0) for i in (0, 1))
        return "\n".join([self.output, *(f"  {a:<{wide}}  {b:<{long}}  {c}".rstrip() for a, b, c in rows)])

    def _repr_html_(self) -> str:
        failed = [f"failed check: {d['message']}" for d in self.get("failed_checks", ())]
        heads = ("quantity", "value", "error")
        return title(f"measures of {self.output}") + table(heads, self.rows()) + "".join(map(title, failed))


class Layers(dict[str, Any]):
    """The manifest of layers, as it lies in their `folder`."""

    def __init__(self, folder: str | Path = "", found: Mapping[str, Any] | None = None) -> None:
        super().__init__(found or {})
        self.folder = Path(folder)

    @property
    def paths(self) -> list[Path]:
        """The files of the layers, lowest first."""
        return [self.folder / name for name in self["files"]]

    def __repr__(self) -> str:
        return f"<{self['layers']} layers of {self['step']:g} mm in {self.folder}, {self['volume']:.6g} mm3>"
