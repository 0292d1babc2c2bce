"""`pore tet`: a part as tetrahedra, to a file, with a short report."""

from __future__ import annotations

import time
from argparse import Namespace
from typing import Any

from porelang.atomic import destination
from porelang.checks import broken_checks, undecided_checks
from porelang.cli import report
from porelang.cli.loading import bound
from porelang.data import figures
from porelang.diagnostics import PoreError, to_lists
from porelang.tet.export import writer_of
from porelang.tetrahedra import tetrahedra
from porelang.tetrahedra.made import wishes

_BARS, _WIDEST = "dihedral_histogram", 32


def tet(options: Namespace) -> int:
    """Fill an output with tetrahedra, write them and print a report. What can be refused is refused before anything is
    computed."""
    destination(options.output)
    writer_of(options.output)
    wishes(options.mesher, options.phases, options.size, options.surface_size, options.time_limit)
    design = bound(options)
    destination(options.output, design.program.files)
    if broken := broken_checks(design, measure=True):
        raise PoreError(broken)
    start = time.perf_counter()
    made = tetrahedra(
        design, options.out, options.size, options.mesher, options.phases, surface_size=options.surface_size,
        bounds=options.bounds, keep_islands=options.keep_islands,
        time_limit=options.time_limit, force=options.force,
    )  # fmt: skip
    doubts = [*undecided_checks(design), *made.doubts, *design.told(*design.program.roots(options.out))]
    report.say([] if options.quiet else doubts)
    made.write(options.output)
    found = made.report | {"seconds": round(time.perf_counter() - start, 3)}
    if options.json:
        report.put(
            {"file": options.output, "output": design.program.output(options.out), **found}
            | to_lists([*options.doubts, *doubts])
        )
    elif not options.quiet:
        print(_text(options.output, found))
    return 0


def _text(path: str, found: dict[str, Any]) -> str:
    """The report: a line for each thing, then the angles as bars."""
    lines = {
        "tetrahedra": f"{found['tets']:,} on {found['vertices']:,} vertices",
        "size": found["size_told"] + _at_the_surface(found) + _halved(found),
        "volume": _volume(found),
        "surface": _distance(found["distance"]),
        "angles": f"{found['min_dihedral']:.3g} to {found['max_dihedral']:.4g} degrees between faces",
        "pieces": _pieces(found),
    }
    if "missing" in found:
        lines["rims"] = _rims(found)
    if len(found["phases"]) > 1:
        told = (f"{name} {phase['volume']:.6g} mm3 in {phase['tets']:,}" for name, phase in found["phases"].items())
        lines["phases"] = "; ".join(told)
    if len(found["surfaces"]) > 1:
        told = (f"{name} {patch['area']:.5g} mm2" for name, patch in found["surfaces"].items())
        lines["surfaces"] = "; ".join(told)
    lines["time"] = f"{found['seconds']:.2f} s ({_MESHERS[found['mesher']]})"
    return "\n".join([path, *(f"  {name:<11} {value}" for name, value in lines.items()), *_bars(found[_BARS])])


_MESHERS = {"direct": "direct", "ftetwild": "fTetWild"}


def _at_the_surface(found: dict[str, Any]) -> str:
    size = found["surface_size"]
    return "" if size is None else f", {size:.4g} mm at the surface"


def _halved(found: dict[str, Any]) -> str:
    return f"; {report.halved(found['halved'], found['finest_cube'])}" if found.get("halved") else ""


def _volume(found: dict[str, Any]) -> str:
    held, true, error = found["volume"], found["field_volume"], found["field_volume_error"]
    return f"{held:.6g} mm3, {found['volume_error']:+.2%} of the part's {figures(true, error)}"


def _rims(found: dict[str, Any]) -> str:
    lost = f"by more than a bend {found['missing']:.2g} mm3 are missing, {found['extra']:.2g} mm3 too much"
    cut = found["rim_triangles_left"]
    return f"{lost}; {cut:,} triangles cut a rim off" if cut else lost


def _distance(distance: dict[str, float]) -> str:
    some = f"; no gradient at {distance['unknown']:.1%} of places" if distance["unknown"] > 0 else ""
    return f"off the part's by {distance['rms']:.2g} mm (rms), at most {distance['max']:.2g} mm{some}"


def _pieces(found: dict[str, Any]) -> str:
    count, islands, lost = found["components"], found["islands"], found["dropped_volume_fraction"]
    if not islands or count > 1:
        return f"{count}"
    return f"{count}; {islands} that did not hang together with it left out, {lost:.2g} of the volume"


def _bars(histogram: dict[str, list[int]]) -> list[str]:
    """The share of angles in each class of ten degrees."""
    ends, counts = histogram["degrees"], histogram["angles"]
    total, most = sum(counts), max(counts)
    held = [i for i, n in enumerate(counts) if n]
    return [
        f"  {f'{ends[i]}-{ends[i + 1]}':>11}{counts[i] / total:8.2%} {'#' * round(_WIDEST * counts[i] / most)}".rstrip()
        for i in range(held[0], held[-1] + 1)
    ]
