"""The second mesher: fTetWild, through pytetwild, from a closed surface of triangles.

Y. Hu, T. Schneider, B. Wang, D. Zorin, D. Panozzo, Fast Tetrahedral Meshing in the Wild, ACM Transactions on Graphics
39 (4), 2020. It may move the surface by `epsilon`, and improves tetrahedra until the worst has a conformal AMIPS energy
of `ENERGY` (3 is the regular one).

It runs in a process of its own (`wildchild`): on an empty surface, on indices and numbers that are none and on a
negative epsilon it crashes, and with epsilon 0 it never ends (pytetwild 0.4.2). What it is given is looked over all the
same. And fTetWild leaves files where it works (`__tracked_surface.stl`): that process works where there is no folder.
"""

from __future__ import annotations

import math
import re
import signal
import tempfile
from dataclasses import dataclass
from importlib.util import find_spec
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from porelang.children import child, ended
from porelang.diagnostics import PoreError, fail
from porelang.limits import speaks_of_memory
from porelang.parallel import workers
from porelang.progress import activity, tell
from porelang.tet.islands import sorted_pieces
from porelang.tet.quality import sound
from porelang.tet.tetmesh import TetMesh

Floats = NDArray[np.float64]
MESHER, LIBRARY = "fTetWild", "pytetwild"
#: What is shown while it works; nobody can tell how many passes it will take.
ACTIVITY = "meshing with fTetWild"
TIME_LIMIT = 1800.0  # seconds
PASSES = 80
ENERGY = 10.0
#: How far the surface may move, as a part of the size of the tetrahedra.
EPSILON = 0.05
#: Of the diagonal of the surface's box: below, it takes forever; above, nothing is left of the surface.
LEAST_EPSILON, MOST_EPSILON = 1e-5, 0.05
#: Regular tetrahedra that fit the volume: hours of work.
MOST_TETS = 5_000_000
_REGULAR = math.sqrt(72)  # the inverse volume of a regular tetrahedron of edge 1
_DIRECT = "use --mesher direct, which needs no other program"
_PASS = re.compile(r"/+ pass (\d+) /+")
_BEFORE = 3  # what is done before the first pass: simplifying, inserting, collapsing
_WORDS = 300  # characters of its last words that are worth showing


@dataclass(frozen=True, slots=True)
class Wish:
    """What is asked of fTetWild: the edges of its tetrahedra and how far it may move the surface, in mm; and the
    seconds that it may take."""

    size: float
    epsilon: float
    time_limit: float


def installed() -> None:
    """Errors: E163 where there is no pytetwild."""
    if find_spec(LIBRARY) is None:
        hint = f"pip install 'porelang[ftetwild]', or {_DIRECT}"
        raise fail("E163", f"{MESHER} takes the package {LIBRARY}, which is not installed", hint=hint)


def ftetwild(
    vertices: Floats,
    faces: NDArray[np.int32],
    size: float,
    *,
    epsilon: float | None = None,
    keep_islands: bool = False,
    time_limit: float = TIME_LIMIT,
) -> tuple[TetMesh, dict[str, Any]]:
    """Tetrahedra that fill a closed surface: `vertices` (n, 3) mm, `faces` (m, 3) counter-clockwise seen from outside.

    Edges inside are about `size` long (mm), those at the surface as short as its shape asks; the surface moves by at
    most `epsilon` mm, EPSILON of the size unless given. Pieces that do not hang together with the largest are left out
    unless `keep_islands`. What it found is told by facts: `epsilon` (mm), `passes`, `max_energy`, and those of
    `sorted_pieces`. Source: see the module.

    Errors: E163 where pytetwild is not installed; E164 where it crashed, ran out of memory or out of time
    (`time_limit`, s), or gave no mesh; E165 for what it must not be given.
    """
    installed()
    wish = wish_of(vertices, faces, size, epsilon, time_limit)
    log: dict[str, float] = {}
    with activity(ACTIVITY):
        found = _made(vertices, faces, wish, log)
    mesh = _sound(found["vertices"], found["tets"])
    facts = {"epsilon": wish.epsilon, "passes": int(log.get("passes", 0)), "max_energy": log.get("max_energy")}
    mesh, _, _, pieces = sorted_pieces(mesh, keep_islands)
    return mesh, facts | pieces


def wish_of(vertices: Floats, faces: NDArray[np.int32], size: Any, epsilon: Any, time_limit: Any) -> Wish:
    """What is asked, looked over. Errors: E165."""
    for what, value in (("size", size), ("epsilon", epsilon), ("time limit", time_limit)):
        number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
        if not (number and 0 < value < math.inf) and not (what == "epsilon" and value is None):
            raise _refused(f"{value!r:.60} is no {what} for {MESHER}", "give a number above 0")
    if defects := defects_of(vertices, faces):
        hint = f"{_DIRECT}, or mesh the part at another --size"
        raise _refused(f"the surface cannot be filled with tetrahedra: {defects}", hint)
    lo, hi = vertices.min(axis=0), vertices.max(axis=0)
    diagonal = float(np.linalg.norm(hi - lo))
    tets = _volume(vertices, faces) / size**3 * _REGULAR
    if tets > MOST_TETS:
        raise _refused(f"that takes some {float(f'{tets:.2g}') / 1e6:,.0f} million tetrahedra, and {MESHER} hours",
                       f"give a larger --size, or {_DIRECT}")  # fmt: skip
    least, most = LEAST_EPSILON * diagonal, MOST_EPSILON * diagonal
    return Wish(float(size), min(most, max(least, EPSILON * size if epsilon is None else epsilon)), float(time_limit))


def defects_of(vertices: Floats, faces: NDArray[np.int32]) -> str:
    """What keeps a surface from being closed and outward; "" where nothing does."""
    if vertices.ndim != 2 or vertices.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3:
        return "it is no array of places and one of triangles, three numbers each"
    if not len(vertices) or not len(faces):
        return "it has no triangles"
    if vertices.dtype.kind not in "fiu" or not np.isfinite(vertices).all():
        return "a vertex is not a number"
    if faces.dtype.kind not in "iu" or faces.min() < 0 or faces.max() >= len(vertices):
        return "a triangle names a vertex that does not exist"
    if (faces == faces[:, [1, 2, 0]]).any():
        return "a triangle names a vertex twice"
    corners = faces.astype(np.int64)
    edges = np.concatenate([corners[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
    there, back = np.sort(edges @ [len(vertices), 1]), np.sort(edges @ [1, len(vertices)])
    if not np.array_equal(there, back):
        return "it is open, or its triangles do not all face outward"
    volume = _volume(vertices, faces)
    return "" if volume > 0 else f"it encloses {volume:.3g} mm3"


def _volume(vertices: Floats, faces: NDArray[np.int32]) -> float:
    corners = (vertices - vertices.mean(axis=0))[faces]
    return float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))) / 6


def _refused(message: str, hint: str) -> PoreError:
    return fail("E165", message, hint=hint)


def _made(vertices: Floats, faces: NDArray[np.int32], wish: Wish, log: dict[str, float]) -> dict[str, NDArray[Any]]:
    """What the child made of a surface. Errors: E164."""
    diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    with tempfile.TemporaryFile() as source, tempfile.TemporaryFile() as target, tempfile.TemporaryFile() as words:
        np.savez(source, vertices=np.asarray(vertices, np.float64), faces=np.asarray(faces, np.int32))
        source.seek(0)
        passed = source.fileno(), target.fileno()
        asked = (wish.size, wish.epsilon / diagonal, ENERGY, PASSES, workers(), *passed)
        code = _run(asked, passed, words, wish.time_limit, log)
        if code:
            words.seek(0)
            raise _died(code, words.read().decode(errors="replace"))
        target.seek(0)
        try:
            with np.load(target, allow_pickle=False) as found:
                return {name: found[name] for name in ("vertices", "tets")}
        except (OSError, EOFError, ValueError, KeyError):
            raise _failed("its process ended without a result") from None


def _run(
    asked: tuple[object, ...], passed: tuple[int, int], words: IO[bytes], limit: float, log: dict[str, float]
) -> int:
    """Have the child work, and tell how far it is; how it ended. It is killed where the answer is no longer wanted.

    Errors: E164 where it takes too long, or cannot be started."""

    def heard(lines: list[str]) -> None:
        for line in lines:
            if (found := _PASS.search(line)) is not None:
                log["passes"] = int(found[1]) + 1
            elif line.startswith("max_energy = "):
                log["max_energy"] = _number(line.removeprefix("max_energy = "))
        tell(min(_BEFORE + int(log.get("passes", 0)), _BEFORE + PASSES) - 1, _BEFORE + PASSES)

    try:
        with child("porelang.tet.wildchild", asked, passed, words) as working:
            return ended(working, heard, limit)
    except TimeoutError:
        hint = f"give a larger --size, a longer --time-limit, or {_DIRECT}"
        raise _failed(f"it was stopped after {limit:g} s", hint) from None
    except OSError as error:
        raise _failed(f"no process can be started: {error.strerror}") from None


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _died(code: int, words: str) -> PoreError:
    last = (words.strip().splitlines() or [""])[-1][:_WORDS]
    if speaks_of_memory(words) or -code == signal.SIGKILL:
        why = "there was not enough memory, or its process was killed"
        return _failed(why, f"give a larger --size, or {_DIRECT}")
    if code < 0:
        return _failed(f"its process crashed ({signal.Signals(-code).name})")
    return _failed(f"its process failed: {last}")


def _failed(why: str, hint: str = _DIRECT) -> PoreError:
    return fail("E164", f"{MESHER} made no tetrahedra: {why}", hint=hint)


def _sound(vertices: Floats, tets: NDArray[Any]) -> TetMesh:
    """The mesh that came back, each tetrahedron of positive volume, without vertices of none. Errors: E164."""
    if vertices.ndim != 2 or vertices.shape[1:] != (3,) or tets.ndim != 2 or tets.shape[1:] != (4,) or not len(tets):
        raise _failed("nothing is left of the part", f"give a smaller --size, or {_DIRECT}")
    if tets.min() < 0 or tets.max() >= len(vertices) or not np.isfinite(vertices).all():
        raise _failed("what it gave is no mesh")
    used, numbered = np.unique(tets, return_inverse=True)
    cells = numbered.reshape(tets.shape).astype(np.int32)
    mesh = TetMesh(vertices[used], cells, np.zeros(len(cells), np.int8))
    if faults := sound(mesh).faults:
        raise _failed(f"its mesh is damaged: {'; '.join(faults)}", f"give another --size, or {_DIRECT}")
    return mesh
