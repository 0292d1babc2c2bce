"""What was found of a period as a material: numbers with errors, and the report of `pore homogenize`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.data import figures
from porelang.diagnostics import Diagnostic
from porelang.picture import Picture
from porelang.unitcell import moduli
from porelang.unitcell.effective import Effective
from porelang.unitcell.extrapolate import limit
from porelang.unitcell.pieces import Piece

Floats = NDArray[np.float64]


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
    zz yz xz xy), `conductivity` (3, 3); each with an error of the same shape. All are extrapolated from the `levels`,
    with the `order` by the voxel. The `pieces` are those of the finest samples, of which `fine` lie along a side of a
    voxel; `doubts` are warnings about it.
    """

    name: str
    cell: tuple[float, float, float]
    low: tuple[float, float, float]
    nu: float
    levels: tuple[Level, ...]
    density: float
    density_error: float
    stiffness: Floats = field(repr=False)
    stiffness_error: Floats = field(repr=False)
    conductivity: Floats = field(repr=False)
    conductivity_error: Floats = field(repr=False)
    order: float
    pieces: tuple[Piece, ...]
    fine: int
    doubts: tuple[Diagnostic, ...]
    seconds: float

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
        along = ",   ".join(
            f"{key}: {figures(self.numbers[f'E.{key}'], max(self.errors[f'E.{key}'], 1e-9))}"
            for key in (("100", "110", "111") if moduli.away_from_cubic(self.stiffness) < moduli.CUBIC
                        else ("100", "010", "001", "111"))
        )  # fmt: skip
        notes = [
            f"E along {along}",
            f"nu of the solid {self.nu:g}, finest grid {max(self.levels[-1].voxels)} voxels a side",
        ]
        title = f"Young's modulus by direction: {self.name}, {sides} mm, density {rho}"
        return modulus_picture(moduli.compliance(self.stiffness), title, notes)

    def _repr_png_(self) -> bytes:
        return self.picture()._repr_png_()

    @cached_property
    def numbers(self) -> dict[str, float]:
        """The moduli by their names: E.100, nu.100, zener, bulk, shear and so on; NaN where there is none."""
        return numbers_of(self.stiffness, self.conductivity)

    @cached_property
    def errors(self) -> dict[str, float]:
        """The errors of the `numbers`: each extrapolated by itself, and what that differs by from theirs."""
        series = [numbers_of(level.stiffness.matrix, level.conductivity.matrix) for level in self.levels]
        sizes = sizes_of(self.levels)
        out = {}
        for name, value in self.numbers.items():
            found = limit(sizes, np.array([numbers[name] for numbers in series]))
            out[name] = max(float(found.error), abs(float(found.value) - value)) if len(self.levels) > 1 else np.inf
        return out

    def report(self) -> dict[str, Any]:
        """What `pore homogenize --json` prints."""
        numbers, errors = self.numbers, self.errors
        mean = moduli.averages(self.stiffness)
        bounds = moduli.upper_bounds(self.density, self.nu)
        heat = float(self.conductivity.trace() / 3)
        share = {"bulk": mean.bulk / bounds["bulk"], "shear": mean.shear / bounds["shear"],
                 "conductivity": heat / bounds["conductivity"]}  # fmt: skip
        return {
            "output": self.name,
            "cell": list(self.cell),
            "low": list(self.low),
            "solid": {"E": 1.0, "nu": self.nu, "conductivity": 1.0},
            "density": self.density,
            "stiffness": self.stiffness.tolist(),
            "E": {key: numbers[f"E.{key}"] for key in moduli.NAMED},
            "nu": {"100": numbers["nu.100"]},
            "G": {key: numbers[f"G.{key}"] for key in _SHEARS},
            "zener": numbers["zener"],
            "bulk": mean.bulk,
            "shear": mean.shear,
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
                "nu": {"100": errors["nu.100"]},
                "G": {key: errors[f"G.{key}"] for key in _SHEARS},
                **{key: errors[key] for key in ("zener", "bulk", "shear")},
            },
            "order": self.order,
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
        """The place (mm) of a sample of the finest level."""
        counts = [self.fine * n for n in self.levels[-1].voxels]
        return [lo + (i + 0.5) * c / n for lo, c, i, n in zip(self.low, self.cell, index, counts, strict=True)]


_SHEARS = {"yz": 3, "xz": 4, "xy": 5}


def numbers_of(stiffness: Floats, conductivity: Floats) -> dict[str, float]:
    s, mean = moduli.compliance(stiffness), moduli.averages(stiffness)
    along = moduli.young(stiffness, list(moduli.NAMED.values()))
    out = {f"E.{key}": float(e) for key, e in zip(moduli.NAMED, along, strict=True)}
    out["nu.100"] = float(-(s[0, 1] + s[0, 2]) / 2 / s[0, 0]) if out["E.100"] else np.nan
    shears = {key: float(1 / s[i, i]) for key, i in _SHEARS.items()}
    out |= {f"G.{key}": g if g > moduli.NOTHING else 0.0 for key, g in shears.items()}
    return out | {"zener": moduli.zener(stiffness), "bulk": mean.bulk, "shear": mean.shear,
                  "conductivity": float(conductivity.trace() / 3)}  # fmt: skip


def sizes_of(levels: Sequence[Level]) -> Floats:
    """The size of the voxels of levels, in units of the cell's longest side."""
    return np.array([1 / max(level.voxels) for level in levels])
