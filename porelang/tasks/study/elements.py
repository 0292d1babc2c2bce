"""The elements of a study: the largest piece of a part, and what is said where they are too coarse for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from porelang.data import coordinates
from porelang.diagnostics import PoreError, fail
from porelang.formula import Formula
from porelang.solid import Solid
from porelang.tasks.study.sized import THROUGH, Sized
from porelang.tet.direct import direct
from porelang.tet.tetmesh import TetMesh, components, taken, volumes

#: What is in pieces, of which those that are not the largest hold more than this of the volume, is no part.
_LOST = 0.05


def meshed(part: Solid, size: float | Formula, found: Sized) -> tuple[TetMesh, Sized, float, int]:
    """Elements of a part in its largest piece, how fine they are; which share of the volume is in others, in how many.

    Errors: E162 where so large elements hold nothing of it, E188 where much is in other pieces.
    """
    try:
        mesh, facts = direct(part, size, keep_islands=True)
    except PoreError as error:
        said = f"{_too_coarse(found)}: " if _is_thin(found) else ""
        told = [replace(d, message=said + d.message, hint=found.finer) if d.code == "E162" else d
                for d in error.diagnostics]  # fmt: skip
        raise PoreError(told) from None
    found = replace(found, halved=facts["halved"], least=facts["finest_cube"])
    piece = components(mesh)
    count = int(piece.max())
    if not count:
        return mesh, found, 0.0, 0
    volume = volumes(mesh)
    lost = float(volume[piece > 0].sum() / volume.sum())
    if lost > _LOST:
        some = piece == 1
        at = np.average(mesh.vertices[mesh.tets[some]].mean(axis=1), axis=0, weights=volume[some])
        if _is_thin(found):
            raise fail("E188", f"{_too_coarse(found)}: they come out as {count + 1:,} pieces", hint=found.finer)
        text = f"{lost:.0%} of the part hang together with its largest piece by nothing, as at ({coordinates(at)}) mm"
        hint = f"join the pieces, or study each by itself; or elements of {found.span} mm are too coarse for what joins"
        raise fail("E188", text, hint=hint)
    return taken(mesh, piece == 0), found, lost, count


def _is_thin(found: Sized) -> bool:
    return found.wall is not None and found.wall.wall < THROUGH * found.size


def _too_coarse(found: Sized) -> str:
    assert found.wall is not None
    at = coordinates(found.wall.at)
    return f"elements of {found.span} mm are too coarse for walls {found.wall.wall:.3g} mm thick, as at ({at}) mm"
