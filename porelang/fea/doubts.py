"""What is doubtful about a solution that was found: said with it, and it stands."""

from __future__ import annotations

import numpy as np

from porelang.diagnostics import Diagnostic
from porelang.fea.checks import taken
from porelang.fea.covered import Patch, covered
from porelang.fea.narrow import narrow
from porelang.fea.nodes import EDGES, Nodes
from porelang.fea.problem import Floats, Pressure
from porelang.fea.solution import Solution
from porelang.fea.supports import name_of
from porelang.fea.surface import interleaved, place
from porelang.fea.system import System

#: A share of the volume that may be one element thick without a word: rims and necks are.
_THIN = 0.1
#: The cosine between normals that look to opposite sides.
_OPPOSITE = -0.5
#: Errors in energy (relative, norm) above which a number is no basis for a decision.
_COARSE = 0.2
#: An area of which more lies in triangles that a selection does not cut in two is ragged.
_RAGGED = 0.1
#: Of a load, what supports may take without a word: the edge of an area that is held is on both sides of it.
_MUCH = 0.1
#: Of what a support selects of a surface, by how much its nodes may have more or less: as wide as an element or so.
_BESIDE = 0.25
#: What selects less of the triangles that it reaches, and holds none of their area, is meant as a line or a point.
_EDGE = 0.05
#: How much of an element a support loses along its ends, at most.
_LOST = 0.75
#: No share is told that is smaller.
_SMALLEST = 1e-6
#: Near 0.5 displacements of the order lock.
_LOCKS = {1: 0.45, 2: 0.495}


def of(found: Solution, system: System, tolerance: float) -> tuple[Diagnostic, ...]:
    """Warnings: W255 for several pieces, W256 for walls of one element, W257 for a large error, W258 for a force that
    stands on a point, W259 where elements lock, W280 for a pressure on a ragged area, W281 for an equilibrium that
    rounding ends early, W286 for a load that supports take, W288 for a support that ends within elements, W289 for
    what is left of loads that are to balance, W291 for a load on less than an element.
    """
    told = [_pieces(system.bodies), _thin(found.nodes), _coarse(found), *_points(found), _locking(found)]
    told += [*_ragged(found, system), _unsettled(found, tolerance), *_taken(system), *_beside(found, system)]
    told += [_unbalanced(system), *_narrow(system)]
    return tuple(d for d in told if d is not None)


def _warn(code: str, message: str, hint: str) -> Diagnostic:
    return Diagnostic(code, message, hint=hint, severity="warning")


def _pieces(bodies: int) -> Diagnostic | None:
    if bodies == 1:
        return None
    return _warn(
        "W255",
        f"the mesh is in {bodies} pieces that do not touch: each deforms by itself",
        "if they are to carry loads together, join them in the design",
    )


def thin_share(nodes: Nodes) -> tuple[float, Floats]:
    """The share of the volume in tetrahedra that reach through the part, and where the largest of them is.

    Such a tetrahedron has an edge from boundary to boundary, inside the part, whose ends look to opposite sides.
    Edges across a corner do not.
    """
    faces = nodes.faces[:, :3]
    ends = nodes.points[faces]
    areas = np.cross(ends[:, 1] - ends[:, 0], ends[:, 2] - ends[:, 0])
    normals: Floats = np.stack(
        [np.bincount(faces.ravel(), np.repeat(a, 3), nodes.vertices) for a in areas.T], axis=1, dtype=np.float64
    )
    length = np.linalg.norm(normals, axis=1)
    normals /= np.where(length > 0, length, 1.0)[:, None]
    rim = np.sort(faces[:, [[0, 1], [1, 2], [0, 2]]].reshape(-1, 2), axis=1).astype(np.int64)
    pairs = np.sort(nodes.corners[:, EDGES], axis=2).astype(np.int64)
    a, b = pairs[..., 0], pairs[..., 1]
    across = (np.einsum("mek,mek->me", normals[a], normals[b]) < _OPPOSITE) & (length[a] > 0) & (length[b] > 0)
    across[across] = ~np.isin(a[across] * nodes.vertices + b[across], rim[:, 0] * nodes.vertices + rim[:, 1])
    through = np.flatnonzero(across.any(axis=1))
    if not len(through):
        return 0.0, nodes.points[0]
    largest = through[np.argmax(nodes.volumes[through])]
    return float(nodes.volumes[through].sum() / nodes.volumes.sum()), nodes.points[nodes.corners[largest]].mean(axis=0)


def _thin(nodes: Nodes) -> Diagnostic | None:
    share, where = thin_share(nodes)
    if share < _THIN:
        return None
    return _warn(
        "W256",
        f"the part is one element thick in {share:.0%} of its volume, for instance at {place(where)}",
        "take smaller elements: walls that bend want two or three across them",
    )


def _coarse(found: Solution) -> Diagnostic | None:
    error = found.error
    if error.relative < _COARSE:
        return None
    worst = int(np.argmax(error.of_tets**2 / found.nodes.volumes))
    where = found.nodes.points[found.nodes.corners[worst]].mean(axis=0)
    return _warn(
        "W257",
        f"the mesh is coarse: stresses are wrong by about {error.relative:.0%} in the mean, most of all at "
        f"{place(where)}",
        "take smaller elements, or refine where the error is",
    )


def _points(found: Solution) -> list[Diagnostic]:
    """Supports that carry much on nodes of a single point or line: stresses there grow with every finer mesh."""
    whole = sum(float(np.linalg.norm(r.force)) for r in found.reactions)
    told = []
    for number, (reaction, chosen) in enumerate(zip(found.reactions, found.held, strict=True)):
        where = found.nodes.points[chosen]
        spread = np.linalg.svd(where - where.mean(axis=0), compute_uv=False) if len(where) > 1 else np.zeros(2)
        size = float(np.ptp(found.nodes.points, axis=0).max()) * np.sqrt(len(where))
        if spread[1] < 1e-6 * size and np.linalg.norm(reaction.force) > 0.01 * whole:
            name = f"the support `{reaction.name}`" if reaction.name else f"the support number {number + 1}"
            shape = "a point" if spread[0] < 1e-6 * size else "a line"
            told.append(
                _warn(
                    "W258",
                    f"{name} carries {np.linalg.norm(reaction.force):.3g} N on {shape}, at {place(where.mean(axis=0))}",
                    "a finer mesh has higher stresses there without end: hold an area, or read no stress near it",
                )
            )
    return told


def _locking(found: Solution) -> Diagnostic | None:
    limit = _LOCKS[found.nodes.order]
    most = float(found.poisson.max())
    if most <= limit:
        return None
    return _warn(
        "W259",
        f"Poisson's ratio is {most:.10g}: elements of order {found.nodes.order} are too stiff where it is above "
        f"{limit}",
        "take order 2" if found.nodes.order == 1 else "take finer elements, and see how the result changes",
    )


def _ragged(found: Solution, system: System) -> list[Diagnostic]:
    """Pressures on areas that come and go within single triangles: what is left out bears no load."""
    told = []
    for load, acting, come_to in zip(found.problem.loads, system.loads, found.loads, strict=True):
        if not isinstance(load, Pressure) or acting.on is None:
            continue
        torn = interleaved(acting.on.chosen)
        whole = system.boundary.areas.sum(axis=1)
        touched = float(whole[acting.on.chosen.any(axis=1)].sum())
        if torn.any() and whole[torn].sum() > _RAGGED * touched:
            at = system.boundary.points[np.argmax(np.where(torn, whole, 0.0))].mean(axis=0)
            told.append(
                _warn(
                    "W280",
                    f"{acting.name} acts on a ragged area: {come_to.area:.4g} mm2, in triangles of the boundary that "
                    f"have {touched:.4g}, as at {place(at)}",
                    "the boundary lies on both sides of where its condition ends: give that some room",
                )
            )
    return told


def _taken(system: System) -> list[Diagnostic]:
    """Loads on areas of which supports take much before it comes to the part."""
    told = []
    for load in system.loads:
        share = taken(load, system.held)
        if load.on is None or share <= _MUCH:
            continue
        at = int(np.argmax(np.abs(load.forces * system.held.components).sum(axis=1)))
        told.append(
            _warn(
                "W286",
                f"{share:.0%} of {load.name} is on nodes that are held against it, as at "
                f"{place(system.nodes.points[at])}: supports take that at once",
                "load the part where it is not held, or hold less of it; finer elements take what is beside it apart",
            )
        )
    return told


def _beside(found: Solution, system: System) -> list[Diagnostic]:
    """Supports whose nodes hold another area than they select: they end within elements."""
    told = []
    for number, (support, held) in enumerate(zip(found.problem.supports, found.reactions, strict=True)):
        name = name_of(support, number)
        on = covered(support.where, system.nodes, system.boundary, name)
        wanted = on.area
        if not wanted > 0 or abs(held.area / wanted - 1) <= _BESIDE:
            continue
        touched = np.unique(on.faces)
        if not held.area and wanted < _EDGE * float(system.boundary.areas[touched].sum()):
            continue  # a line or a point that is meant: W258
        said = f"{held.area:.3g} mm2 of the surface" if held.area else "nodes of a line or a point, no area,"
        told.append(
            _warn(
                "W288",
                f"{name} holds {said} where {wanted:.3g} mm2 are selected: it ends within elements",
                "let it end at a rim of the part, or hold an area some elements wide; elements of "
                f"{_for_width(on):.2g} mm have it to a quarter",
            )
        )
    return told


def _for_width(on: Patch) -> float:
    """The edge (mm) of elements with which a support has the area that it selects to a quarter.

    Along its ends it loses half an element in the mean, of discs .57, and of a strip as much as .75 of six elements.
    """
    narrow, wide = on.widths
    return _BESIDE / _LOST / (2 / narrow + 2 / wide)  # over the ends of a rectangle for its area


def _unbalanced(system: System) -> Diagnostic | None:
    """What is left of loads for what elements make of the areas that they are on."""
    if system.rest is None:
        return None
    return _warn(
        "W289",
        f"the loads do not quite balance: they add up to {system.rest.said}, "
        f"{system.rest.share:.1g} of the loads; a force on all of the volume takes that",
        "see whether the loads as they are written do: then mend them, or put a support in place of one. "
        f"These elements cannot tell where loads are wrong by less than {system.rest.open + system.rest.share:.1g} "
        "of them: finer ones tell more",
    )


def _narrow(system: System) -> list[Diagnostic]:
    return [
        _warn(
            "W291",
            f"{load.name} acts on {load.area:.3g} mm2, {load.wide:.2g} mm across, which is less than an element there "
            f"({load.face:.2g} mm): under it the part gives way by up to {load.more:.2g} mm more",
            f"its errors say so; spread it over what it really presses on, or take elements of {load.size:.2g} mm",
        )
        for load in narrow(system)
    ]


def _unsettled(found: Solution, tolerance: float) -> Diagnostic | None:
    if found.residual <= tolerance:
        return None
    return _warn(
        "W281",
        f"forces balance to {found.residual:.2g} of those that act, where {tolerance:.2g} is wanted: rounding ends "
        f"there, and displacements are sure to {max(found.unsure, _SMALLEST):.1g} of themselves",
        "slender parts that bend do that, moduli that differ by orders, flat tetrahedra, a Poisson's ratio next to "
        "0.5: a reaction may be off by the first share",
    )
