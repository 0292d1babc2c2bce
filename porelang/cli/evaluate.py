"""`pore eval`: points from a file, values to a file or to standard output."""

from __future__ import annotations

import os
import re
import stat
import sys
from argparse import Namespace
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.atomic import destination, save
from porelang.backends.numpy import Dtype
from porelang.checks import broken_checks
from porelang.cli import report
from porelang.cli.loading import bound
from porelang.diagnostics import PoreError, fail, to_lists
from porelang.field import Backend, checked_points
from porelang.gpu.fields import gpu

AT_ONCE = 2**16


def evaluate(options: Namespace) -> int:
    """Values of an output at points. Errors: E104 for points that are none, and what `Program.field` rejects."""
    if options.file == options.points == "-":
        raise fail("E108", "standard input can be read only once", hint="write the points to a file, and name that")
    design = bound(options)
    if options.output:
        destination(options.output, [*design.program.files, options.points])
        if not options.output.endswith(".npy"):
            raise fail("E112", f"{options.output}: values are written as .npy", hint="end the name with .npy")
    backend, dtype = machine(options, "f64")
    if broken := broken_checks(design):
        raise PoreError(broken)
    points = read_points(options.points)
    values = design.field(options.out, backend, dtype)(points)
    if options.output:
        save(options.output, lambda file: np.save(file, values))
    if options.json:
        written = {"file": options.output} if options.output else {"values": values.tolist()}
        report.put({"points": len(points), "backend": backend, "dtype": dtype, **written, **to_lists(options.doubts)})
    elif not options.output:
        for i in range(0, len(values), AT_ONCE):
            sys.stdout.write("".join(f"{_line(row)}\n" for row in values[i : i + AT_ONCE].tolist()))
    elif not options.quiet:
        report.note(f"{options.output}: {report.plural(len(points), 'value')}")
    return 0


def machine(options: Namespace, usual: Dtype) -> tuple[Backend, Dtype]:
    """Which backend computes, and in which numbers: `auto` is GLSL where there is OpenGL and f32 is asked for.

    Says on standard error where it falls back to NumPy. Errors: E108 for GLSL in f64, E120 for GLSL without OpenGL.
    """
    if options.backend == "glsl":
        if options.dtype == "f64":
            raise fail("E108", "GLSL computes in f32 only", hint="leave --dtype out, or use --backend numpy")
        gpu()
        return "glsl", "f32"
    if options.backend == "auto" and options.dtype == "f32":
        try:
            gpu()
            return "glsl", "f32"
        except PoreError as missing:
            if not options.quiet:
                report.note(f"{missing.diagnostics[0].message}: NumPy computes instead")
    return "numpy", options.dtype or usual


def _line(row: Any) -> str:
    match row:
        case list():
            return ",".join(map(repr, row))
        case bool():
            return str(row).lower()
    return repr(row)


def read_points(path: str) -> NDArray[np.float64]:
    """Points (n, 3) in mm from `.npy`, from CSV, or from CSV on standard input (`-`). Errors: E104, E105."""
    try:
        if path == "-":
            if sys.stdin is None:
                raise fail("E105", "there is no standard input: it is closed", hint="name a file after --points")
            return checked_points(_from_csv(sys.stdin, "standard input"))
        if os.path.exists(path) and stat.S_ISCHR(os.stat(path).st_mode) and path != "/dev/stdin":
            raise fail("E105", f"`{path}` is a device that never ends", hint="name a file after --points")
        with open(path, "rb") as file:
            magic = file.read(6) == b"\x93NUMPY"
        if magic:
            return checked_points(_from_npy(path))
        if path.endswith(".npy"):
            raise fail("E104", f"`{path}` is no NumPy array", hint="write it with numpy.save, or hand over .csv")
        with open(path, encoding="utf-8-sig") as text:
            return checked_points(_from_csv(text, f"`{path}`"))
    except FileNotFoundError:
        hint = "check the path after --points"
        if path.count(",") == 2:
            hint = f"points come from a file, or from standard input: echo {path} | pore eval ... --points -"
        raise fail("E105", f"there is no file `{path}`", hint=hint) from None
    except UnicodeDecodeError:
        raise fail("E104", f"`{path}` is neither .npy nor CSV", hint="a line of CSV is x,y,z in mm") from None
    except OSError as error:
        raise fail(
            "E105", f"`{path}` cannot be read: {error.strerror or error}", hint="check the path after --points"
        ) from None


def _from_npy(path: str) -> NDArray[Any]:
    try:
        array: NDArray[Any] = np.load(path, allow_pickle=False)
    except (ValueError, EOFError, MemoryError) as error:  # the latter where a header claims what is not there
        raise fail(
            "E104", f"`{path}` cannot be read: {str(error).splitlines()[0]}", hint="write it with numpy.save"
        ) from None
    if array.dtype.kind not in "fiu":
        raise fail("E104", f"`{path}` holds {array.dtype}, not numbers", hint="give an array of shape (n, 3)")
    return array


def _from_csv(lines: Iterable[str], name: str) -> list[list[float]]:
    """Rows of three numbers. A first line of words is a header: if it names x, y and z, those columns are taken."""
    rows: list[list[float]] = []
    columns: list[int] | None = None
    for number, line in enumerate(lines, 1):
        if ";" in line and "," in line:
            raise fail("E104", f"line {number} of {name} has both `;` and `,`: `{line.strip()[:57]}`",
                       hint="write decimals with a point, and separate numbers by one sign")  # fmt: skip
        words = re.split(r"\s*[,;]\s*|\s+", line.strip())
        if words == [""] or line.lstrip().startswith("#"):
            continue
        if columns is None:
            low = [w.strip('"').lower() for w in words]
            if {"x", "y", "z"} <= set(low):
                columns = [low.index(axis) for axis in "xyz"]
                continue
            columns = [0, 1, 2]
            if len(words) != 3:
                raise fail("E104", f"line {number} of {name} has {report.plural(len(words), 'number')}, not three",
                           hint="a line is x,y,z in mm; with more columns a first line names them")  # fmt: skip
        try:
            rows.append([float(words[c]) for c in columns])
        except (ValueError, IndexError):
            shown = line.strip() if len(line) < 60 else f"{line.strip()[:57]}..."
            raise fail(
                "E104", f"line {number} of {name} is no point: `{shown}`", hint="a line is x,y,z in mm"
            ) from None
    return rows
