"""What was found of a period as a material: numbers with errors, and the report of `pore homogenize`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import permutations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.data import figures
from porelang.diagnostics import Diagnostic
from porelang.homogenize.table import AXES_KEYS, CUBIC_KEYS, lines_of, told
from porelang.picture import Picture
from porelang.unitcell import moduli
from porelang.unitcell.effective import Effective
from porelang.unitcell.extrapolate import limit
from porelang.unitcell.grids import ALIKE, sizes_of
from porelang.unitcell.pieces import Piece

Floats = NDArray[np.float64]
#: The least relative error of walls of one voxel, less by the cube of how many there are; of less than one voxel more
#: by the share: a gyroid sheet of .22, .29, .44 and .59 voxels is off by 10, 7, 3.4 and 2.2 % where it is worst.
THIN = 0.03
#: What cut voxels err by at least, times how many there are along the cell, unless grids differ by less: of a spherical
#: void of .27, whose grids agree to .07 %, the bulk modulus at 64 was off by .08 %.
CUT = 0.1
#: The least relative errors of others: of Poisson's ratios in units of that of E, of other moduli in units of that of
#: the best known E, of the Zener ratio in units of those of E and G; and of any E in units of the greatest of E and G,
#: of other moduli and entries twice that, of ratios three times: what grids that agree by chance were off by, in 14
#: lattices (docs/decisions/0018).
OF_RATIOS, OF_MODULI, OF_ZENER, OF_SOFTEST = 0.25, 0.2, 0.9, 0.05
#: What modes have in a picture that nothing resists, as a share of the stiffest: the surface of a laminate has no
#: thickness, and a fibre's is a line.
FAINT = 1e-3


@dataclass(frozen=True, slots=True)
class Level:
    """What one resolution gave: its voxels, and the effective properties of them."""

    voxels: tuple[int, int, int]
    stiffness: Effective
    conductivity: Effective


@dataclass(frozen=True)
class Homogenized:
    """What a period does as a material, for a solid of unit Young's modulus and unit conductivity.

    `cell` are its sides and `low` its lower corner (mm); `stiffness` (6, 6) is by Voigt with engineering shear (xx yy
    zz yz xz xy), `conductivity` (3, 3); each with an error of the same shape. Both are extrapolated from the `levels`,
    whose finest was asked to have `resolution` voxels along the longest side.
    `wall` is how thick the thinnest walls are (mm), None where none were found; `orders` are those of convergence that
    are taken for possible, and a grid `strays` by that share of what they differ by. The `pieces` are those of the
    finest voxels, as elements hang together; `doubts` are warnings.
    """

    name: str
    cell: tuple[float, float, float]
    low: tuple[float, float, float]
    nu: float
    resolution: int
    levels: tuple[Level, ...] = field(repr=False)
    wall: float | None
    orders: tuple[float, ...] = field(repr=False)
    strays: float = field(repr=False)
    density: float
    density_error: float
    stiffness: Floats = field(repr=False)
    stiffness_error: Floats = field(repr=False)
    conductivity: Floats = field(repr=False)
    conductivity_error: Floats = field(repr=False)
    pieces: tuple[Piece, ...] = field(repr=False)
    doubts: tuple[Diagnostic, ...] = field(repr=False)
    seconds: float = field(repr=False)

    def __str__(self) -> str:
        return "\n".join(lines_of(self))

    @property
    def through(self) -> float | None:
        """The voxels of the finest grid through the thinnest walls."""
        if self.wall is None:
            return None
        return self.wall / max(side / n for side, n in zip(self.cell, self.levels[-1].voxels, strict=True) if n > ALIKE)

    @property
    def least_error(self) -> float:
        """The least relative error of anything, whatever the grids say: of walls of few voxels they may agree and be
        wrong."""
        return THIN / self.through ** (3 if self.through > 1 else 1) if self.through else 0.0

    @property
    def least_error_of_moduli(self) -> float:
        """The least relative error of a modulus: with twice that of the density, which all grids share and moduli go
        with by a power of 1 to 2."""
        return self.least_error + 2 * self.density_error / self.density

    def widened(self) -> Homogenized:
        """The same with errors of the entries that are no less than `least_error_of_moduli`, and than a share of what
        the softest modulus errs by."""
        most = max((self.errors[key] / e for key, e in self.numbers.items() if key[0] in "EG" and e), default=0.0)
        least = max(self.least_error_of_moduli, 2 * OF_SOFTEST * min(1.0, most))
        return replace(
            self,
            stiffness_error=np.maximum(self.stiffness_error, least * np.abs(self.stiffness)),
            conductivity_error=np.maximum(self.conductivity_error, least * np.abs(self.conductivity)),
        )

    def young(self, directions: Any) -> Floats:
        """Young's modulus (n,) along directions (n, 3)."""
        return moduli.young(self.stiffness, directions)

    def directions(self, step: float = 5.0) -> Floats:
        """Young's modulus by direction as a table (n, 6): azimuth and elevation in degrees every `step`, x, y, z of the
        direction, the modulus. The lower half of space is the upper one's mirror in the origin, and left out."""
        azimuth, elevation = np.meshgrid(np.arange(0, 360, step), np.arange(0, 90 + step / 2, step), indexing="ij")
        a, e = np.radians(azimuth.ravel()), np.radians(elevation.ravel())
        n = np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], axis=1)
        return np.column_stack([azimuth.ravel(), elevation.ravel(), n, self.young(n)])

    def picture(self) -> Picture:
        """The surface of Young's modulus by direction, with its scale; a notebook shows it."""
        from porelang.render.directional import modulus_picture

        rho = figures(self.density, max(self.density_error, 1e-4)).split(" ")[0]
        sides = " x ".join(f"{s:g}" for s in self.cell)
        along = [f"{key}: {told(self.numbers[f'E.{key}'], self.errors[f'E.{key}'])}"
                 for key in (CUBIC_KEYS if self.is_cubic else AXES_KEYS)]  # fmt: skip
        notes = [
            "E along " + ",   ".join(along[:2]),
            "          " + ",   ".join(along[2:]),
            f"nu of the solid {self.nu:g}, finest grid {max(self.levels[-1].voxels)} voxels along the longest side",
        ]
        if free := moduli.free(self.stiffness):
            how = ": drawn as if a thousandth did" if free < 6 else ", so that there is nothing to draw"
            notes.append(f"nothing resists in {free} of 6 modes{how}")
        title = f"Young's modulus by direction: {self.name}, {sides} mm, density {rho}"
        return modulus_picture(moduli.compliance(self.stiffness, FAINT), title, notes)

    def _repr_png_(self) -> bytes:
        return self.picture()._repr_png_()

    @property
    def is_cubic(self) -> bool:
        """Whether the stiffness is that of a cubic cell along x, y, z, within a per cent."""
        return moduli.away_from_cubic(self.stiffness) < moduli.CUBIC

    @cached_property
    def numbers(self) -> dict[str, float]:
        """The moduli by their names: E.100, nu.100, nu.xy, zener, bulk, shear and so on; NaN where there is none."""
        return numbers_of(self.stiffness, self.conductivity)

    @cached_property
    def errors(self) -> dict[str, float]:
        """The errors of the `numbers`: each extrapolated by itself, and what that differs by from theirs, and no less
        than a share of what others err by; NaN where there is no number, infinite where the finest grids have none."""
        of_each = [numbers_of(level.stiffness.matrix, level.conductivity.matrix) for level in self.levels]
        out: dict[str, float] = {}
        cut = CUT / max(self.levels[-1].voxels)
        for name, value in self.numbers.items():
            is_ratio = name == "zener" or name.startswith("nu")
            least = (self.least_error if is_ratio else self.least_error_of_moduli) * abs(value)
            series = np.array([numbers[name] for numbers in of_each])
            out[name] = _error(
                value, series, max(least, min(cut * abs(value), np.ptp(series))), self.orders, self.strays
            )

        def off(*names: str) -> list[float]:
            return [out[name] / self.numbers[name] for name in names if self.numbers[name]] or [0.0]

        pulls, every = off("E.100", "E.010", "E.001"), off(*(f"E.{key}" for key in moduli.NAMED))
        most = min(1.0, max(off(*(key for key in out if key[0] in "EG"))))
        for name, value in self.numbers.items():
            least = OF_SOFTEST * most
            if name == "zener":
                least = max(3 * least, OF_ZENER * max(off("E.100", "G.xy")))
            elif name.startswith("nu"):
                least = max(3 * least, OF_RATIOS * max(pulls))
            elif not name.startswith("E"):
                least = max(2 * least, OF_MODULI * min(every))
            out[name] = max(out[name], least * abs(value))
        return out

    def report(self) -> dict[str, Any]:
        """What `pore homogenize --json` prints."""
        numbers, errors = self.numbers, self.errors
        mean = moduli.averages(self.stiffness)
        bounds = moduli.upper_bounds(self.density, self.nu)
        heat = float(self.conductivity.trace() / 3)
        # bounds of isotropic solids; that of the bulk modulus holds for cubic ones as well, and none for others
        share = {"bulk": numbers["bulk"] / bounds["bulk"] if self.is_cubic else np.nan,
                 "shear": numbers["shear"] / bounds["shear"] if self.is_cubic else np.nan,
                 "conductivity": heat / bounds["conductivity"]}  # fmt: skip
        return {
            "output": self.name,
            "cell": list(self.cell),
            "low": list(self.low),
            "solid": {"E": 1.0, "nu": self.nu, "conductivity": 1.0},
            "density": self.density,
            "stiffness": self.stiffness.tolist(),
            "E": {key: numbers[f"E.{key}"] for key in moduli.NAMED},
            "nu": {key: numbers[f"nu.{key}"] for key in _RATIOS},
            "G": {key: numbers[f"G.{key}"] for key in _SHEARS},
            "zener": numbers["zener"],
            "bulk": numbers["bulk"],
            "shear": numbers["shear"],
            "voigt": {"bulk": mean.bulk_voigt, "shear": mean.shear_voigt},
            "reuss": {"bulk": mean.bulk_reuss, "shear": mean.shear_reuss},
            "anisotropy": mean.anisotropy,
            "away_from_cubic": moduli.away_from_cubic(self.stiffness),
            "conductivity": self.conductivity.diagonal().tolist(),
            "conductivity_tensor": self.conductivity.tolist(),
            "hashin_shtrikman": {**bounds, "share": share},
            "error": {
                "density": self.density_error,
                "stiffness": self.stiffness_error.tolist(),
                "conductivity_tensor": self.conductivity_error.tolist(),
                "conductivity": self.conductivity_error.diagonal().tolist(),
                "E": {key: errors[f"E.{key}"] for key in moduli.NAMED},
                "nu": {key: errors[f"nu.{key}"] for key in _RATIOS},
                "G": {key: errors[f"G.{key}"] for key in _SHEARS},
                **{key: errors[key] for key in ("zener", "bulk", "shear")},
            },
            "orders": [min(self.orders), max(self.orders)],
            "strays": self.strays,
            "wall": self.wall,
            "voxels_through_wall": self.through,
            "levels": [
                {"voxels": list(at.voxels), "density": at.stiffness.density, "stiffness": at.stiffness.matrix.tolist(),
                 "conductivity_tensor": at.conductivity.matrix.tolist(), "cases": at.stiffness.solved,
                 "steps": at.stiffness.steps, "residual": at.stiffness.residual}
                for at in self.levels
            ],
            "pieces": [{"share": p.share, "at": self.place(p.at), "leads": p.axes}
                       for p in self.pieces[:10]],
            "piece_count": len(self.pieces),
            "seconds": self.seconds,
        }  # fmt: skip

    def place(self, index: Sequence[int]) -> list[float]:
        """The place (mm) of the middle of a voxel of the finest grid."""
        counts = self.levels[-1].voxels
        return [lo + (i + 0.5) * c / n for lo, c, i, n in zip(self.low, self.cell, index, counts, strict=True)]


_SHEARS = {"yz": 3, "xz": 4, "xy": 5}
_RATIOS = ("100", "xy", "xz", "yx", "yz", "zx", "zy")


def numbers_of(stiffness: Floats, conductivity: Floats) -> dict[str, float]:
    """The moduli of a stiffness and a conductivity by their names; NaN where there is none."""
    s, mean = moduli.compliance(stiffness), moduli.averages(stiffness)
    along = moduli.young(stiffness, list(moduli.NAMED.values()))
    out = {f"E.{key}": float(e) for key, e in zip(moduli.NAMED, along, strict=True)}
    resists = [out["E.100"], out["E.010"], out["E.001"]]
    for (a, pulled), (b, across) in permutations(enumerate("xyz"), 2):
        # how much narrower along b for a pull along a; of what hangs by nothing along either there is none
        out[f"nu.{pulled}{across}"] = float(-s[a, b] / s[a, a]) if resists[a] and resists[b] else np.nan
    out["nu.100"] = (out["nu.xy"] + out["nu.xz"]) / 2
    held = moduli.resisted(stiffness, np.eye(6))
    shears = {key: float(1 / s[i, i]) if held[i] else 0.0 for key, i in _SHEARS.items()}
    out |= {f"G.{key}": g if g > moduli.NOTHING else 0.0 for key, g in shears.items()}
    # where Reuss' is none, half of Voigt's is no average of anything
    averages = {"bulk": mean.bulk if mean.bulk_reuss else np.nan, "shear": mean.shear if mean.shear_reuss else np.nan}
    return out | {"zener": moduli.zener(stiffness), **averages,
                  "conductivity": float(conductivity.trace() / 3)}  # fmt: skip


def _error(value: float, series: Floats, least: float, orders: tuple[float, ...], strays: float) -> float:
    """The error of a number from what each grid gave, the coarsest first, and no less than `least`."""
    if np.isnan(value):
        return float("nan")
    there = np.flatnonzero(np.isfinite(series))
    if len(there) < 2 or there[-1] != len(series) - 1:
        return float("inf")
    found = limit(sizes_of()[there], series[there], orders, strays)
    return max(float(found.error), abs(float(found.value) - value), least)
