"""What was found of a period, or of a sweep, as lines to read."""

from __future__ import annotations

import math
from typing import Any

from porelang.data import figures
from porelang.unitcell import moduli

#: The directions that are told of a cubic cell, and of others.
CUBIC_KEYS, AXES_KEYS = ("100", "110", "111"), ("100", "010", "001", "110", "111")
#: Errors below this are rounding.
_LEAST = 1e-12


def told(value: float, error: float) -> str:
    """A number with its error, or that there is none; of what its error exceeds no more than its size."""
    if not math.isfinite(value):
        return "none"
    if not math.isfinite(error):
        return f"{value:.2g}, error not known"
    if error > abs(value) > 0:
        return f"{value:.2g} +- {error:.2g}"
    return figures(value, max(error, _LEAST, 1e-7 * abs(value)))


def lines_of(found: Any) -> list[str]:
    """The moduli of a period (`Homogenized`) with their errors, as `pore homogenize` prints them."""
    numbers, errors = found.numbers, found.errors
    mean = moduli.averages(found.stiffness)
    bounds = moduli.upper_bounds(found.density, found.nu)

    def number(name: str) -> str:
        return told(numbers[name], errors[name])

    cell = " x ".join(f"{s:g}" for s in found.cell)
    lines = [("cell", f"{cell} mm"), ("density", told(found.density, found.density_error))]
    if found.wall is not None:
        lines += [("thinnest wall", f"{found.wall:.3g} mm, {found.through:.2g} voxels")]
    lines += [(f"E {key}", number(f"E.{key}")) for key in (CUBIC_KEYS if found.is_cubic else AXES_KEYS)]
    ratios = ("100",) if found.is_cubic else ("xy", "xz", "yx", "yz", "zx", "zy")
    lines += [(f"nu {key}", number(f"nu.{key}")) for key in ratios]
    lines += [(f"G {key}", number(f"G.{key}")) for key in ("yz", "xz", "xy")]
    none = "nothing resists" if found.is_cubic else f"{moduli.away_from_cubic(found.stiffness):.1%} away from cubic"
    lines += [("Zener ratio", number("zener") if math.isfinite(numbers["zener"]) else f"none: {none}")]
    for key, reuss in (("bulk", mean.bulk_reuss), ("shear", mean.shear_reuss)):
        if reuss == 0:
            lines += [(key, "none: nothing resists in some mode")]
        elif found.is_cubic:
            lines += [(key, f"{number(key)}, {numbers[key] / bounds[key]:.0%} of the bound of Hashin and Shtrikman")]
        else:
            lines += [(key, f"{number(key)}, the mean of Voigt's and Reuss' (Hill)")]
    heat, off = found.conductivity.diagonal(), found.conductivity_error.diagonal()
    lines += [("conductivity", ", ".join(told(float(v), float(e)) for v, e in zip(heat, off, strict=True)))]
    out = [f"  {name:<13} {value}" for name, value in lines]
    out.append("  stiffness (xx yy zz yz xz xy)")
    shown = min(9, max(5, 4 - math.floor(math.log10(found.stiffness.max())))) if found.stiffness.max() > 0 else 5
    out += ["    " + " ".join(f"{v + 0.0:{shown + 4}.{shown}f}" for v in row) for row in found.stiffness]
    grids = ", ".join(" x ".join(map(str, level.voxels)) for level in reversed(found.levels))
    most = max(found.levels[-1].voxels)
    if most > found.resolution:
        grids += f" ({found.resolution} were asked for along the longest side, and come as {most})"
    out.append(f"  for a solid of E 1, nu {found.nu:g}, conductivity 1; from {grids} voxels, "
               f"extrapolated; {found.seconds:.1f} s")  # fmt: skip
    return out


def table_of(swept: Any) -> list[str]:
    """The table of a sweep (`Swept`), each column as wide as it must be, and the powers through it."""
    along = ["E"] if all(one.is_cubic for one in swept.found) else ["E", "E.010", "E.001"]
    keys = ["density", *along, "shear", "bulk", "conductivity", "zener"]
    heads = [
        swept.param,
        "density",
        *("E 100" if k == "E" else k.replace(".", " ") for k in along),
        *keys[1 + len(along) :],
    ]
    rows = [heads]
    for text, row in zip(swept.shown, swept.rows(), strict=True):
        rows.append([text, *(told(row[key], row[f"{key}_error"]) for key in keys)])
    wide = [max(len(row[i]) for row in rows) for i in range(len(heads))]
    out = ["  " + "  ".join(f"{cell:>{width}}" for cell, width in zip(row, wide, strict=True)) for row in rows]
    return out + [f"  {'E 100' if name == 'E' else name:<13} {fit}" for name, fit in swept.fits.items()]
