"""`pore homogenize`: what one period of a lattice does as a material, with errors; or a sweep, with its law."""

from __future__ import annotations

import csv
import io
import json
from argparse import Namespace
from pathlib import Path
from typing import Any, BinaryIO

from porelang.atomic import destination, save
from porelang.checks import broken_checks, undecided_checks
from porelang.cli import report
from porelang.cli.loading import bound
from porelang.diagnostics import PoreError, fail, to_lists
from porelang.picture import write_png

_ENDINGS = (".png", ".csv", ".json")
_HEADS = ("azimuth_deg", "elevation_deg", "x", "y", "z", "E")


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
        fixed = [name for name, _ in options.settings]
        found = sweep(design, param, low, high, count, options.out, options.cell, options.nu, options.resolution, fixed)
    doubts = [*found.doubts, *undecided_checks(design), *design.told(*design.program.roots(options.out))]
    whole = found.report() | to_lists([*options.doubts, *doubts])
    for path in options.outputs:
        _write(path, found, whole)
    report.say([] if options.quiet else doubts)
    if options.json:
        report.put(whole)
    elif not (options.quiet and options.outputs):  # without a file this is the result
        print(design.program.source.name, found, sep="\n")
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
            writer.writerows(["" if v is None else f"{v:.9g}" for v in row.values()] for row in rows)
        else:
            writer.writerow(_HEADS)
            writer.writerows([f"{v:.9g}" for v in row] for row in found.directions())
        text = file.getvalue()

    def put(file: BinaryIO) -> None:
        file.write(text.encode())

    save(path, put)
