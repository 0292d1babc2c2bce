"""What a solve gives, and what engineers read off it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from porelang.diagnostics import Diagnostic, fail
from porelang.fea.error import Error
from porelang.fea.means import mean_length
from porelang.fea.nodes import Nodes
from porelang.fea.patches import Sites
from porelang.fea.problem import Floats, Ints, Problem
from porelang.fea.resultants import Resultant
from porelang.fea.shares import percentile
from porelang.fea.stress import energy_density, principal, strains_of, von_mises


@dataclass(frozen=True, slots=True)
class Solution:
    """A part in equilibrium.

    `displacement` (k, 3) mm is that of all `nodes.points`, the mesh's n vertices first.

    `stress` (p, 6) MPa, in the order xx, yy, zz, xy, yz, xz, is recovered at the *sites* (p,): the mesh's n vertices,
    each in the stiffest
    material there, then the same vertices in others. `sites.corners` (m, 4) are those of each tetrahedron:
    interpolate between them, and no value crosses
    a jump of the material. `stress_of_tets` (m, 6) are the means that the elements themselves have. `young`,
    `poisson` and `density` (m,) are those of the tetrahedra,
    and `site_young`, `site_poisson` (p,) those of sites.

    `reactions` are what supports hold with, `loads` what loads come to, in the order of the problem; `held` are the
    nodes of each support, `applied` (k, 3) N all loads on nodes. `compliance` is
    twice the strain energy, N mm: what forces times displacements are. `residual` is what the `iterations` left of
    forces, and of their resultants, over those that act (loads, and what moved supports press with);
    `unsure` is by which share displacements and compliance may be off for that, where it is more than was asked;
    `unknowns` are the components that nothing held. `error` is an estimate of what the mesh leaves out, and
    `doubts` are warnings.
    """

    problem: Problem
    nodes: Nodes
    young: Floats
    poisson: Floats
    density: Floats
    displacement: Floats
    reactions: tuple[Resultant, ...]
    loads: tuple[Resultant, ...]
    held: tuple[Ints, ...]
    applied: Floats
    compliance: float
    residual: float
    unsure: float
    iterations: int
    unknowns: int
    sites: Sites
    site_young: Floats
    site_poisson: Floats
    stress: Floats
    stress_of_tets: Floats
    error: Error
    doubts: tuple[Diagnostic, ...]

    @property
    def at_vertices(self) -> Floats:
        """The displacement (n, 3) mm of the mesh's vertices."""
        return self.displacement[: self.nodes.vertices]

    @property
    def strain(self) -> Floats:
        """The strains (p, 6) at sites, tensor components: shear is half of the engineers'."""
        return strains_of(self.stress, self.site_young, self.site_poisson)

    @property
    def von_mises(self) -> Floats:
        """Von Mises' equivalent stress (p,) MPa at sites."""
        return von_mises(self.stress)

    @property
    def energy_density(self) -> Floats:
        """The strain energy (p,) N mm/mm3 at sites."""
        return energy_density(self.stress, self.site_young, self.site_poisson)

    def principal(self) -> tuple[Floats, Floats]:
        """The principal stresses (p, 3) MPa at sites, largest first, and their directions (p, 3, 3), one a row."""
        return principal(self.stress)

    @property
    def mass(self) -> float:
        """The mass in g."""
        return float(self.nodes.volumes @ self.density) / 1000

    @property
    def max_displacement(self) -> float:
        """The longest displacement of a node, mm."""
        return float(np.linalg.norm(self.displacement, axis=1).max())

    @property
    def mean_displacement(self) -> float:
        """The mean over the volume of the length of the displacement, mm."""
        return mean_length(self.nodes, self.displacement)[0]

    def percentile(self, values: Floats, share: float) -> float:
        """The value that `share` per cent of the volume stay below, of values (p,) at sites, linear between them:
        `percentile(s.von_mises, 99)`."""
        return percentile(values, self.sites.corners, self.nodes.volumes, share)

    def scaled(self, factor: float) -> Solution:
        """The same part under loads and prescribed displacements that are `factor` times those of `problem`.

        For a rigid platen under a force: move it by 1 mm, and scale by the force over the reaction.
        """
        if not np.isfinite(factor):
            raise fail("E173", f"a solution cannot be scaled by {factor!r}", hint="give a finite number")
        reactions, loads = (tuple(r.scaled(factor) for r in some) for some in (self.reactions, self.loads))
        return replace(
            self, displacement=self.displacement * factor, reactions=reactions, loads=loads,
            applied=self.applied * factor, compliance=self.compliance * factor**2, stress=self.stress * factor,
            stress_of_tets=self.stress_of_tets * factor,
        )  # fmt: skip
