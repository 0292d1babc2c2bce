"""Pieces of a mesh: networks of the void, which have names, and islands, which hang together with nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import Diagnostic
from porelang.tet.tetmesh import Floats, Indices, TetMesh, components, neighbours, taken, volumes

Ints = NDArray[np.int64]

FEW = 3  # islands that are told with their places
NETWORK = 0.01  # of the void: smaller pieces of it are islands, closed bubbles and what a cut has left
MOST = 100  # networks with names


def sorted_pieces(mesh: TetMesh, keep: bool) -> tuple[TetMesh, Indices, TetMesh, dict[str, Any]]:
    """A mesh without its islands, unless all are to be kept, and its neighbours; those that are left out; how many
    `islands` there were, and `dropped_volume_fraction`, the share of the volume that was dropped.

    Of the solid all pieces but the largest are islands; those of the void are phases by themselves, "void 1" the
    largest, where there are several, and islands where they are smaller than NETWORK of the void. Where the void is
    meshed too, islands of the solid in it become void: left out, they would be holes with walls to nowhere.
    W251 names islands: a solver finds them free to move.
    """
    beside = neighbours(mesh)
    piece = components(mesh, beside)
    count = int(piece.max(initial=-1)) + 1
    volume = volumes(mesh)
    size = np.bincount(piece, volume, count)
    kind = np.empty(count, np.int8)
    kind[piece] = mesh.phase
    solid, void = np.flatnonzero(kind == 0), np.flatnonzero(kind == 1)  # by size, the largest first
    networks = void[size[void] >= NETWORK * size[void].sum()][:MOST]
    main = np.concatenate([solid[:1], networks])
    label = np.zeros(count, np.int8)
    label[void] = len(networks)  # what is too small to be named, if it is kept, goes with the last
    label[networks] = 1 + np.arange(len(networks))
    names = ("void",) if len(networks) == 1 else tuple(f"void {n + 1}" for n in range(len(networks)))
    nothing = taken(mesh, np.zeros(len(mesh.tets), np.bool_))
    island = ~np.isin(np.arange(count), main)
    share = float(size[island].sum() / size.sum()) if count else 0.0
    facts: dict[str, Any] = {"islands": int(island.sum()), "dropped_volume_fraction": 0.0, "told": []}
    named = TetMesh(mesh.vertices, mesh.tets, label[piece], ("solid", *names))
    if not island.any():
        return named, beside, nothing, facts
    given = np.zeros(count, np.bool_)
    if not keep:
        around = _around(piece, beside, count, networks)
        given = island & (kind == 0) & (around >= 0)
        label[given] = label[around[given]]
        facts["dropped_volume_fraction"] = share
    facts["told"].append(_told(mesh, piece, volume, np.flatnonzero(island), share, keep, bool(given.any())))
    if keep:
        return named, beside, nothing, facts
    left = taken(named, island[piece] & (named.phase == 0))
    named = TetMesh(mesh.vertices, mesh.tets, label[piece], ("solid", *names))
    kept = taken(named, ~(island & ~given)[piece])
    return kept, neighbours(kept), left, facts


def _around(piece: Indices, beside: Indices, count: int, networks: Ints) -> Ints:
    """The network of the void (count,) with which each piece shares most faces; -1 where it does with none."""
    other = np.where(beside >= 0, piece[np.maximum(beside, 0)], -1)
    found = np.full(count, -1)
    most = np.zeros(count, np.int64)
    for network in networks:
        shared = np.bincount(piece, (other == network).sum(axis=1), count).astype(np.int64)
        shared[network] = 0
        found[shared > most] = network
        most = np.maximum(most, shared)
    return found


def _told(
    mesh: TetMesh, piece: Indices, volume: Floats, islands: Ints, share: float, keep: bool, void: bool
) -> Diagnostic:
    places = []
    for n in islands[:FEW]:
        some = piece == n
        x, y, z = np.average(mesh.vertices[mesh.tets[some]].mean(axis=1), axis=0, weights=volume[some])
        places.append(f"{volume[some].sum():.2g} mm3 at ({x:.4g}, {y:.4g}, {z:.4g})")
    more = "" if len(islands) <= FEW else f", and {len(islands) - FEW:,} smaller"
    pieces = "1 piece hangs" if len(islands) == 1 else f"{len(islands):,} pieces hang"
    hint = "a finer --size joins what is joined in the part; `pore measure` tells what is not"
    hint = f"hold each of them, or leave them out; {hint}" if keep else hint
    done = f"{'is' if len(islands) == 1 else 'are'} {'kept' if keep else 'made void' if void else 'dropped'}"
    message = f"{pieces} together with nothing, {100 * share:.2g} % of the volume, and {done}"
    return Diagnostic("W251", f"{message}: {', '.join(places)}{more}", hint=hint, severity="warning")
