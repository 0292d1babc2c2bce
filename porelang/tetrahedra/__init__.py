"""A part as tetrahedra: `tetrahedra(design, ...)` makes them by either mesher, with a report."""

from __future__ import annotations

from porelang.tetrahedra.made import MESHERS, PHASES, Mesher, tetrahedra
from porelang.tetrahedra.result import Tetrahedra

__all__ = ["MESHERS", "PHASES", "Mesher", "Tetrahedra", "tetrahedra"]
