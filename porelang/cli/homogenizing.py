"""`pore homogenize`: what one period of a lattice does as a material, with errors; or a sweep, with its law."""

from __future__ import annotations

import csv
import io
import json
import math
from argparse import Namespace
from pathlib import Path
from typing import Any, BinaryIO

from porelang.atomic import destination, save
from porelang.checks import broken_checks, undecided_checks
from porelang.cli import report
from porelang.cli.loading import bound
from porelang.data import figures
from porelang.diagnostics import PoreError, fail, to_lists
from porelang.picture import write_png

_ENDINGS = (".png", ".csv", ".json")
_HEADS = ("azimuth_deg", "elevation_deg", "x", "y", "z", "E")
#: Errors below this are rounding.
_LEAST = 1e-12


def homogenize(options: Namespace) -> int:
    """Homogenize an output. What can be refused is refused before anything is computed."""
    from porelang.homogenize import homogenize as solved
    from porelang.homogenize import sweep

    for path in options.outputs:
        if Path(path).suffix.lower() not in _ENDINGS:
            raise fail("E112", f"{path}: what was homogenized is written as .png, .csv or .json",
                       hint="end the name with one of these")  # fmt: skip
        destination(path)
    design = bound(options)
    for path in options.outputs:
        destination(path, design.program.files)
    if broken := broken_checks(design, measure=True):
        raise PoreError(broken)
    found: Any
    if options.sweep is None:
        found = solved(design, options.out, options.cell, options.nu, options.resolution)
    else:
        param, low, high, count = options.sweep
        found = sweep(design, param, low, high, count, options.out, options.cell, options.nu, options.resolution)
    doubts = [*found.doubts, *undecided_checks(design), *design.told(*design.program.roots(options.out))]
    whole = found.report() | to_lists(doubts)
    for path in options.outputs:
        _write(path, found, whole)
    report.say([] if options.quiet else doubts)
    if options.json:
        report.put(whole)
    elif not options.quiet:
        print("\n".join([design.program.source.name, *(_sweep(found) if options.sweep else _one(found))]))
    return 0


def _write(path: str, found: Any, whole: dict[str, Any]) -> None:
    ending = Path(path).suffix.lower()
    if ending == ".png":
        write_png(found.picture(), path)
        return
    text = json.dumps(report.finite(whole), indent=2) + "\n"
    if ending == ".csv":
        file = io.StringIO()
        writer = csv.writer(file, lineterminator="\n")
        if hasattr(found, "rows"):
            rows = found.rows()
            writer.writerow(rows[0])
            writer.writerows([repr(v) for v in row.values()] for row in rows)
        else:
            writer.writerow(_HEADS)
            writer.writerows([f"{v:.9g}" for v in row] for row in found.directions())
        text = file.getvalue()

    def put(file: BinaryIO) -> None:
        file.write(text.encode())

    save(path, put)


def _told(value: float, error: float) -> str:
    """A number with its error, or that there is none."""
    return figures(value, max(error, _LEAST)) if math.isfinite(value) else "none"


def _one(found: Any) -> list[str]:
    numbers, errors = found.numbers, found.errors
    whole = found.report()
    cell = " x ".join(f"{s:g}" for s in found.cell)
    lines = [("cell", f"{cell} mm"), ("density", _told(found.density, found.density_error))]
    names = ("100", "110", "111") if whole["zener"] == whole["zener"] else ("100", "010", "001", "110", "111")
    lines += [(f"E {key}", _told(numbers[f"E.{key}"], errors[f"E.{key}"])) for key in names]
    lines += [("nu 100", _told(numbers["nu.100"], errors["nu.100"]))]
    lines += [(f"G {key}", _told(numbers[f"G.{key}"], errors[f"G.{key}"])) for key in ("yz", "xz", "xy")]
    lines += [("Zener ratio", _told(numbers["zener"], errors["zener"]) if numbers["zener"] == numbers["zener"] else
               f"none: {whole['away_from_cubic']:.1%} away from cubic")]  # fmt: skip
    share = whole["hashin_shtrikman"]["share"]
    for key in ("bulk", "shear"):
        above = f", {share[key]:.0%} of the bound of Hashin and Shtrikman"
        lines += [(key, _told(numbers[key], errors[key]) + above)]
    heat, off = found.conductivity.diagonal(), found.conductivity_error.diagonal()
    lines += [("conductivity", ", ".join(_told(float(v), float(e)) for v, e in zip(heat, off, strict=True)))]
    out = [f"  {name:<13} {value}" for name, value in lines]
    out.append("  stiffness (xx yy zz yz xz xy)")
    out += ["    " + " ".join(f"{v:9.5f}" for v in row) for row in found.stiffness]
    grids = ", ".join(str(max(level.voxels)) for level in found.levels)
    out.append(f"  for a solid of E 1, nu {found.nu:g}, conductivity 1; from {grids} voxels along the longest side, "
               f"extrapolated; {found.seconds:.1f} s")  # fmt: skip
    return out


def _sweep(found: Any) -> list[str]:
    heads = (found.param, "density", "E", "shear", "bulk", "conductivity", "Zener")
    out = ["  " + "".join(f"{head:>20}" for head in heads)]
    for text, row in zip(found.shown, found.rows(), strict=True):
        cells = [figures(row[key], max(row[f"{key}_error"], _LEAST)) for key in heads[1:6]]
        out.append("  " + "".join(f"{cell:>20}" for cell in [text, *cells, f"{row['zener']:.3f}"]))
    return out + [f"  {name:<13} {fit}" for name, fit in found.fits.items()]
