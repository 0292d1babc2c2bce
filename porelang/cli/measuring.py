"""`pore measure`: what a part measures, with errors, and the `check` statements over it."""

from __future__ import annotations

import math
from argparse import Namespace
from typing import Any

from porelang.checks import broken_checks, doubtful_numbers, undecided_checks
from porelang.cli import report
from porelang.cli.evaluate import machine
from porelang.cli.loading import bound
from porelang.measure import measure as measured

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


#: What is counted at a voxel and looked at again at a coarser one.
_COUNTS = frozenset(("solid_components", "void_components", "euler"))


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
    if options.json:
        report.put(found | {"failed_checks": [d.to_json() for d in broken]})
    else:
        print(_text(options.file, found))
    report.say(broken)
    if not options.quiet:
        asked = [*design.program.roots(options.out), *design.program.graph.checks]
        report.say([*undecided_checks(design), *doubtful_numbers(design, *asked)])
    return report.status(broken)


def _text(path: str, found: dict[str, Any]) -> str:
    lo, hi = found["bounds"]
    lines = [path]
    lines.append(f"  {'size':<16} {' x '.join(f'{b - a:.5g}' for a, b in zip(lo, hi, strict=True))} mm")
    for key, (name, unit) in _WORDS.items():
        error = found["error"][key]
        value = f"{found[key]:.6g}" if isinstance(found[key], float) else f"{found[key]}"
        told = f"{value} +- {error:.2g} {unit}".rstrip()
        if not math.isfinite(error):
            told = "not known: the voxel is too coarse"
        elif key in _COUNTS:
            told = value if error == 0 else f"{value}, not certain at this voxel: a coarser one differs by {error:.0f}"
        more = f"({found['envelope']})" if key == "envelope_volume" else ""
        lines.append(f"  {name:<16} {told} {more}".rstrip())
    lines.extend(f"  {text} = {r['value']:.6g} +- {r['error']:.2g}" for text, r in found["reduced"].items())
    lines.append(f"  counts at a voxel of {found['voxel']:.4g} mm, compared with those at one 1.5 times as large")
    return "\n".join(lines)
