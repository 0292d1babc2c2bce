"""What is asked of a solve: a mesh of tetrahedra, what it is made of, how it is held, and what loads it.

Lengths are mm, forces N, stresses and moduli MPa = N/mm2, densities g/cm3. Places are selected by functions of
points, so
that fields, shapes and plain NumPy all serve. Supports act on the nodes of the boundary that are selected; loads
on its area: a selection that cuts through triangles loads the part of them that it covers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]
#: Which of the points (n, 3) mm are meant, (n,) of bool.
Where = Callable[[Floats], Any]
#: A vector (n, 3) for each of the points (n, 3) mm.
Vectors = Callable[[Floats], Any]
Triple = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class OnSurface:
    """A selection that is asked at the places on a part's own surface which are `nearest` to points of a mesh's
    boundary: that has facets where the part is round."""

    anywhere: Where
    nearest: Callable[[Floats], Floats]

    def __call__(self, points: Floats) -> Any:
        return self.anywhere(self.nearest(points))


@dataclass(frozen=True, slots=True)
class Facing:
    """A selection of a load, of what of the boundary looks in a direction alone: of a strip of one side not what of the
    sides beside it lies as near."""

    anywhere: Where
    toward: Triple

    def __call__(self, points: Floats) -> Any:
        return self.anywhere(points)


class Tetrahedra(Protocol):
    """What is read of a mesh: `porelang.tet.TetMesh` is one."""

    @property
    def vertices(self) -> Floats:
        """(n, 3) mm."""

    @property
    def tets(self) -> Ints:
        """(m, 4), each of positive volume."""


@dataclass(frozen=True, slots=True)
class Support:
    """Nodes of the boundary that are held along the axes named, or moved there by a prescribed displacement.

    All three axes are a bonded face; one alone lets the face slide in its plane, without friction. `displacement` is in
    mm, the same for all nodes or a function of their places (n, 3) to (n, 3); along axes that are not named it counts
    for
    nothing. Supports may overlap where they agree.

    >>> Support(lambda p: p[:, 2] < 1e-6, axes=(False, False, True), name="platen")  # doctest: +ELLIPSIS
    Support(where=..., axes=(False, False, True), displacement=(0.0, 0.0, 0.0), name='platen')
    """

    where: Where
    axes: tuple[bool, bool, bool] = (True, True, True)
    displacement: Triple | Vectors = (0.0, 0.0, 0.0)
    name: str = ""


@dataclass(frozen=True, slots=True)
class Force:
    """A force in N, spread evenly over the area of the boundary that is selected."""

    where: Where
    total: Triple
    name: str = ""


@dataclass(frozen=True, slots=True)
class Pressure:
    """A pressure in MPa on the area selected, against its outward normal: above 0 it pushes into the part."""

    where: Where
    value: float
    name: str = ""


@dataclass(frozen=True, slots=True)
class Moment:
    """A couple in N mm on the area selected, without a net force: bending or torque by the right hand.

    The traction is w x (x - c) about the centroid c of the area, as stresses are over a section that stays plane; w is
    found from the area's moments of inertia. A couple has the same moment about every point.
    """

    where: Where
    total: Triple
    name: str = ""


@dataclass(frozen=True, slots=True)
class Weight:
    """A force on all of the mass: density times an acceleration in mm/s2, for gravity on a part that stands (0, 0,
    -9810)."""

    acceleration: Triple
    name: str = "weight"


@dataclass(frozen=True, slots=True)
class BodyForce:
    """A force in N/mm3 on the volume, a function of places (n, 3) to (n, 3)."""

    density: Vectors
    name: str = "body force"


Load: TypeAlias = Force | Pressure | Moment | Weight | BodyForce


@dataclass(frozen=True, slots=True)
class Problem:
    """A part in equilibrium: the displacements of linear elasticity are wanted.

    `young` (m,) MPa, `poisson` (m,) and `density` (m,) g/cm3 are of the tetrahedra, or one number for all. `order` 2
    has displacements
    that are quadratic in each tetrahedron, 1 linear ones, which are too stiff unless the mesh is very fine.

    `balanced` says that loads are known to do no work on the motions which supports leave free, as between frictionless
    platens: those motions are then taken out, with the mean displacement along them zero. Otherwise a free motion is
    refused (E171).
    """

    mesh: Tetrahedra
    young: Floats | float
    poisson: Floats | float
    density: Floats | float = 1.0
    supports: tuple[Support, ...] = ()
    loads: tuple[Load, ...] = ()
    order: Literal[1, 2] = 2
    balanced: bool = False
