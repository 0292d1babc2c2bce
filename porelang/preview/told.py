"""What a page is told of a program beside its picture: its params, outputs and fields, and what is wrong in it."""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterable, Mapping
from contextlib import suppress
from typing import Any

from porelang.asked import Report
from porelang.assist.complete import Item
from porelang.checks import broken_checks, failed_checks
from porelang.diagnostics import Diagnostic, PoreError, in_order, render
from porelang.elaborate.results import ParamInfo
from porelang.elaborate.values import Scalar
from porelang.ir import Stage
from porelang.measure import BOUNDS
from porelang.preview.words import on_page
from porelang.program import Design, Program
from porelang.render.picture import bodies_of
from porelang.session import Snapshot
from porelang.settings import settle
from porelang.source import Source
from porelang.units import LENGTH, UNITS

Settings = dict[str, float | str]
#: Fields of a study that are offered as colours.
RESULTS = ("{}.von_mises", "{}.principal1", "{}.principal3", "{}.energy", "length({}.displacement)")
#: Fields that are offered, at most: a menu is to be read.
MOST_OFFERED = 60


def program(found: Snapshot, settings: Settings, begun: Settings) -> dict[str, Any]:
    """What a page shows of a program; where its text is wrong, of the last one that was well. `begun` is what is set
    for a page whose address says nothing of it."""
    good = found.good
    told = {
        "say": "program",
        "file": os.path.basename(found.path),
        "again": f"pore view {shlex.quote(found.path)}",
        "wrong": _rendered(found, found.diagnostics, "error"),
        "marks": marks(found.diagnostics, found.source),
    }
    if good is None:
        return told | {"params": [], "outputs": [], "bodies": [], "fields": [], "presets": [], "checks": 0}
    return told | described(good, settings, begun)


def described(good: Program, settings: Settings, begun: Settings | None = None) -> dict[str, Any]:
    """What can be set and shown of a program."""
    return {
        "params": [_param(p, settings.get(p.name), (begun or {}).get(p.name)) for p in good.params.values()],
        "lengths": {unit.name: unit.scale for unit in UNITS.values() if unit.dimension == LENGTH},
        "presets": list(good.presets),
        "outputs": list(good.outputs),
        "bodies": bodies_of(good),
        "fields": _fields(good),
        "checks": len(good.graph.checks),
    }


def doubts(found: Snapshot, more: Iterable[Diagnostic] = ()) -> dict[str, Any]:
    """Warnings, those that samples bear out too, and what tasks say of what they found; it takes seconds, and can be
    cancelled."""
    every = [*found.all_diagnostics, *more]
    return {
        "say": "doubts",
        "doubts": _rendered(found, every, "warning"),
        "notes": [on_page(d).message for d in every if d.severity == "note"],
        "marks": marks(every, found.source),
    }


def _rendered(found: Snapshot, some: Iterable[Diagnostic], severity: str) -> list[str]:
    return [render(on_page(d)) for d in in_order(list(some), found.source) if d.severity == severity]


def marks(some: Iterable[Diagnostic], main: Source) -> list[dict[str, Any]]:
    """Where the text is underlined, and what is said there. One of another file is told at the beginning."""
    out = []
    for d in some:
        if d.severity == "note":
            continue
        here = d.span is not None and d.span.in_file.source.name == main.name
        begin, end = (d.span.in_file.start, d.span.in_file.end) if here and d.span is not None else (0, 0)
        told = on_page(d)
        said = [told.message if here or d.span is None else f"{d.span}: {told.message}", told.label, told.hint]
        out.append({
            "from": units(main.text, begin), "to": units(main.text, end), "severity": d.severity,
            "message": "\n".join(filter(None, said)),
        })  # fmt: skip
    return out


def completions(items: Iterable[Item], text: str) -> list[dict[str, Any]]:
    """What may be written, for the page's editor."""
    return [
        {"label": i.label, "kind": i.what, "text": i.text, "detail": i.detail, "doc": i.doc,
         "start": units(text, i.start), "end": units(text, i.end)}
        for i in items
    ]  # fmt: skip


def checked(design: Design) -> dict[str, Any]:
    """What became of the `check` statements, with the numbers of those that fail; `holds` is None where the errors of
    the numbers leave it open. It may take seconds. Errors: those of the numbers."""
    program = design.program
    broken = {i: d.label for i, d in zip(failed_checks(design), broken_checks(design, measure=True), strict=True)}
    return {
        "say": "checked",
        "checks": [
            {"text": check.message, "holds": False if i in broken else design.decided(root), "why": broken.get(i, "")}
            for i, (check, root) in enumerate(zip(program.elaborated.checks, program.graph.checks, strict=True))
        ],
    }


def measured(found: Report) -> dict[str, Any]:
    """What was measured of an output, each with its error, and of what its porosity is."""
    envelope = "its box" if found["envelope"] == BOUNDS else found["envelope"]
    return {"say": "measured", "output": found.output, "rows": [list(r) for r in found.rows()], "envelope": envelope}


def units(text: str, offset: int) -> int:
    """How many UTF-16 units lie before a character: a page counts in these."""
    before = text[:offset]
    return offset if before.isascii() else len(before.encode("utf-16-le")) // 2


def characters(text: str, offset: int) -> int:
    """How many characters so many UTF-16 units are, from the beginning of a text."""
    return len(text.encode("utf-16-le", "surrogatepass")[: 2 * offset].decode("utf-16-le", "ignore"))


def kept(program: Program, settings: Mapping[str, float | str]) -> Settings:
    """The settings that a program still takes."""
    out: Settings = {}
    for name, value in settings.items():
        with suppress(PoreError):
            number = settle(program.params, {name: value})[name]
            out[name] = word(program.params[name], number)
    return out


def word(info: ParamInfo, value: float) -> float | str:
    """A value of a param in base units, or by its word."""
    return info.choices[int(value)] if info.choices and not info.numbers else value


def _param(info: ParamInfo, value: float | str | None, begun: float | str | None) -> dict[str, Any]:
    """A param for a slider: value and range in base units, and in how many of the unit that it is shown in."""
    default = word(info, info.default)
    return {
        "name": info.name,
        "doc": info.doc,
        "value": default if value is None else value,
        "default": default,
        "begun": default if begun is None else begun,
        "low": info.low,
        "high": info.high,
        "step": info.step or (1.0 if info.structural else None),  # what counts is a whole number
        "choices": list(info.numbers or info.choices),
        "unit": info.written or info.unit,
        "scale": UNITS[info.written].scale if info.written else 1.0,
    }


def _fields(good: Program) -> list[str]:
    """What surfaces and planes can be coloured by: lets and outputs that vary in space, and the results of studies."""
    lets = [
        name for name, value in good.elaborated.lets.items()
        if isinstance(value, Scalar) and value.node.axes and value.node.stage is Stage.FIELD
    ]  # fmt: skip
    results = [text.format(name) for name in good.studies for text in RESULTS]
    return list(dict.fromkeys([*results, *lets, *bodies_of(good)]))[:MOST_OFFERED]
