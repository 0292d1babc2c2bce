"""`pore measure`: what a part measures, with errors, and the `check` statements over it."""

from __future__ import annotations

import math
from argparse import Namespace
from typing import Any

import numpy as np

from porelang.checks import broken_checks, undecided_checks
from porelang.cli import report
from porelang.cli.evaluate import machine
from porelang.cli.loading import bound
from porelang.data import coordinates, figures
from porelang.diagnostics import to_lists
from porelang.measure import COUNTS
from porelang.measure import measure as measured
from porelang.pieces import MOST_NODES
from porelang.walls import rounded, takes

_WORDS = {
    "volume": ("volume", "mm3"),
    "envelope_volume": ("envelope", "mm3"),
    "porosity": ("porosity", ""),
    "area": ("area", "mm2"),
    "solid_components": ("pieces of solid", ""),
    "void_components": ("pieces of void", ""),
    "open_void_fraction": ("open void", ""),
    "euler": ("Euler number", ""),
}
#: What is listed by place, and what is to be known of it.
_LISTED = {"pieces": ("separate pieces", ""), "voids": ("closed voids", ", where powder or resin stays")}
_SHOWN = 3


def measure(options: Namespace) -> int:
    """Measure an output; exit 1 where a check of the program does not hold."""
    design = bound(options)
    backend, dtype = machine(options, "f32")
    found = measured(
        design,
        options.out,
        options.within,
        options.voxel,
        options.resolution,
        options.bounds,
        backend,
        dtype,
    )
    broken = broken_checks(design, measure=True)
    asked = [*design.program.roots(options.out), *design.program.graph.checks]
    doubts = [*undecided_checks(design), *design.told(*asked)]
    if options.json:
        report.put(found | {"failed_checks": [d.to_json() for d in broken], **to_lists([*options.doubts, *doubts])})
    else:
        print(_text(design.program.source.name, found))
    report.say(broken)
    report.say([] if options.quiet else doubts)
    return report.status(broken)


def _text(path: str, found: dict[str, Any]) -> str:
    lo, hi = found["bounds"]
    lines = [path]
    size = " x ".join(f"{b - a:.5g}" for a, b in zip(lo, hi, strict=True))
    ends = [f"{error:.1g}" for error in found["error"]["bounds_by_axis"]]
    ends = ends[:1] if len(set(ends)) == 1 else ends
    lines.append(f"  {'size':<16} {size} mm, each end +- {', '.join(ends)} mm")
    for key, (name, unit) in _WORDS.items():
        more = f"({found['envelope']})" if key == "envelope_volume" else ""
        lines.append(f"  {name:<16} {_with_error(found[key], found['error'][key], unit)} {more}".rstrip())
    if found["min_wall"] is not None:
        wall = f"{figures(found['min_wall'], found['error']['min_wall'])} mm"
        lines.append(f"  {'thinnest walls':<16} {wall}, as at ({coordinates(found['min_wall_at'], 3)}) mm")
    for key, (name, what) in _LISTED.items():
        several = found["solid_components"] if key == "pieces" else found["closed_voids"]
        if told := _largest(found[key], several, what, least=2 if key == "pieces" else 1):
            lines.append(f"  {name:<16} {told}")
    lines.extend(
        f"  {text} = {figures(r['value'], r['error'])} {r['unit']}".rstrip() for text, r in found["reduced"].items()
    )
    lines.append(f"  counted at a voxel of {found['voxel']:.4g} mm; certain is what one 1.5 times as large counts too")
    if any(not math.isfinite(found["error"][count]) for count in COUNTS):
        lines.append(f"  {_finer(found)}")
    return "\n".join(lines)


def _finer(found: dict[str, Any]) -> str:
    """The voxel at which what is not known may be counted, and what it takes."""
    voxel = found["voxel_for_wall"]
    if voxel is None:
        return "to count what is not known use a smaller --voxel: a few to the thinnest wall and gap"
    lo, hi = np.array(found["bounds"])
    much = takes(hi - lo, voxel, MOST_NODES)
    return f"to count what is not known use --voxel {rounded(voxel)}mm, as the thinnest walls ask{much and f'; {much}'}"


def _with_error(value: float, error: float, unit: str) -> str:
    """A number with its error; a count is certain or it is not."""
    if not math.isfinite(error):
        counted = f" ({_counted(value)})" if isinstance(value, int) and value else ""
        return f"not known: the voxel is too coarse{counted}"
    if isinstance(value, int):
        return f"{value}" if not error else f"not certain at this voxel ({_counted(value)})"
    return f"{figures(value, error)} {unit}".rstrip()


def _counted(value: int) -> str:
    return f"{value} {'is' if value == 1 else 'are'} counted"


def _largest(found: list[dict[str, Any]], several: int, what: str, least: int) -> str:
    """The largest of `several` pieces, of which those that are `found` are described, if so many are certain."""
    certain = [piece for piece in found if piece["certain"]]
    unsure = len(found) - len(certain)
    if len(certain) < least:
        return ""
    shown = "; ".join(_piece(p) for p in certain[:_SHOWN])
    hidden = len(certain) - _SHOWN
    more = f"; and {hidden} smaller {'one' if hidden == 1 else 'ones'} (--json lists them)" if hidden > 0 else ""
    doubt = f"; {unsure} more {'is' if unsure == 1 else 'are'} not certain at this voxel" if unsure else ""
    rest = several - len(found)
    ones = "one that is" if rest == 1 else "ones that are"
    doubt += f"; and {rest} yet smaller {ones} only counted" if rest > 0 else ""
    return f"{len(certain)}{what}: {shown}{more}{doubt}"


def _piece(piece: dict[str, Any]) -> str:
    at = coordinates(piece["at"], 3)
    return f"{figures(piece['volume'], piece['error'])} mm3 at ({at}) mm"
