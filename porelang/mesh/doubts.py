"""What is to be said of a mesh: that it is not the part, what it lacks, and where it is in pieces or runs through
itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from porelang.analysis.box import block
from porelang.data import Reduced
from porelang.diagnostics import Diagnostic, PoreError, fail
from porelang.field import Bounds, checked_bounds
from porelang.ir import node
from porelang.mesh.bridged import bridged
from porelang.mesh.crumbs import LITTLE, Settled
from porelang.mesh.grid import Grid, place
from porelang.mesh.lost import lost
from porelang.mesh.missed import Missed, far_and_long, missed
from porelang.mesh.surface import Surface
from porelang.program import Design
from porelang.solid import Flags, Floats, Solid
from porelang.source import Span
from porelang.tasks.numbers.integrals import volume
from porelang.walls import (
    A_PART,
    MOST_TRIANGLES,
    TO_A_WALL,
    gaps_at,
    on_surface,
    rounded,
    takes,
    thinnest,
    triangles,
    walls_at,
)

#: A mesh whose volume is further than this from the part's is not the part, and one much further is not written.
COARSE, USELESS = 0.03, 0.2
ACCURACY = 2e-3
#: Less than this share of the cells of a mesh, and no further beyond its ends than so many voxels, is nothing that
#: anyone misses: wherever two surfaces meet at a sharp angle something runs out between the samples.
MISSED, SHORT = 0.02, 2.0
#: Of a voxel that is too coarse, for other reasons than the walls: what is proposed instead.
FINER = 0.45


@dataclass(frozen=True, slots=True)
class Coarse:
    """What may have made a mesh coarse: its voxel, and what it was simplified within (mm; None if it was not); and the
    volume (mm3) that it held before it was refined."""

    voxel: float
    simplified: float | None
    held: float


def volume_doubts(
    design: Design,
    name: str | None,
    bounds: Bounds | None,
    held: float,
    part: Solid,
    coarse: Coarse,
    force: bool = False,
) -> list[Diagnostic]:
    """W202, where a mesh as it will be written holds another volume (mm3) than the part. Errors: E118 where it is
    another by more than a fifth, unless `force`. A few points in the part's box are looked at first, and may do.
    """
    if _about(part, held):
        return []
    true = _volume(design, name, bounds)
    off, numbers = _off(held, true)
    if not off:
        return []
    span = _span(design, name)
    cause, label, hint = _cause(part, coarse, held, true, off)
    if off > USELESS and not force:
        much = f"lost {off:.0%} of the part" if held < true.value else f"holds {off:.0%} too much"
        hint = f"{hint}; or keep it as it is, --force"
        raise fail("E118", f"the mesh {much}: it holds {numbers}", span, label=f"{cause}: {label}", hint=hint)
    return [Diagnostic("W202", f"{cause}: the mesh holds {numbers}", span, label, hint=hint, severity="warning")]


def _cause(part: Solid, coarse: Coarse, held: float, true: Reduced, off: float) -> tuple[str, str, str]:
    """What took the greater part of the share that a mesh is off: as a message, as a label, and what to do about it."""
    if coarse.simplified is not None and abs(held - coarse.held) > abs(coarse.held - true.value):
        larger = coarse.simplified > float((part.hi - part.lo).max())
        told = f"--simplify {coarse.simplified:.4g}mm is {'larger than the part' if larger else 'too coarse'}"
        label = f"without --simplify the mesh holds {coarse.held:.4g} mm3"
        return told, label, "use a smaller --simplify"
    at, of = on_surface(part), ("thinnest walls", "thick")
    found = walls_at(part, at)
    if held > true.value and (gaps := gaps_at(part, at, TO_A_WALL * coarse.voxel)):
        found, of = gaps, ("narrowest gaps", "wide")
    if found is not None and found.wall > TO_A_WALL * coarse.voxel:  # chords err by the square of the voxel
        voxel = coarse.voxel * min(FINER, FINER * 2 * (COARSE / off) ** 0.5)
        label = f"triangles of {coarse.voxel:.3g} mm {'cut off' if held < true.value else 'fill'} what is curved"
        return "the voxel is too coarse", label, f"use --voxel {rounded(voxel)}mm{_takes(part, voxel)}"
    label = f"{'walls' if held < true.value else 'gaps'} no wider than a voxel or two are lost or torn"
    hint = "use a smaller --voxel, a few to the thinnest wall"
    if found is not None:
        walls = f"the {of[0]} are about {found.wall:.2g} mm {of[1]}, as at {place(found.at)}"
        finer = _finer(found.wall, coarse.voxel)
        hint = f"use --voxel {rounded(finer)}mm: {walls}{_takes(part, finer)}"
    return "the voxel is too coarse", label, hint


def layer_doubts(
    design: Design, name: str | None, bounds: Bounds | None, held: float, step: float, pixel: float
) -> list[Diagnostic]:
    """W202, where layers, a `step` thick, of pixels (mm) hold another volume (mm3) than the part."""
    off, numbers = _off(held, _volume(design, name, bounds))
    if not off:
        return []
    box = checked_bounds(bounds) if bounds is not None else design.bounds(name)
    wall, size = thinnest(Solid(design.of(name), (box.lo, box.hi))), max(step, pixel)
    hint = "use a smaller --step and --voxel, a few to the thinnest wall"
    if wall is None or wall <= TO_A_WALL * size:
        label = "what is thinner than a pixel or a layer is lost or torn"
        if wall is not None:
            finer = rounded(_finer(wall, size))
            hint = f"use --step {finer}mm --voxel {finer}mm: the thinnest walls are about {wall:.2g} mm thick"
    else:
        label = f"pixels of {pixel:.3g} mm and layers of {step:.3g} mm are coarse steps round what is curved"
        hint = f"use --step {rounded(FINER * step)}mm --voxel {rounded(FINER * pixel)}mm"
    return [Diagnostic("W202", f"the layers hold {numbers}", _span(design, name), label, hint=hint, severity="warning")]


def _volume(design: Design, name: str | None, bounds: Bounds | None) -> Reduced:
    formula = design.of(name)
    if bounds is not None:
        formula = formula.with_roots(node("max", formula.root, block(checked_bounds(bounds))))
    return volume(formula, accuracy=ACCURACY)


def _off(held: float, true: Reduced) -> tuple[float, str]:
    """By which share of a part's volume another is off, 0 where that is nothing to speak of; and both as text."""
    off = max(abs(held - true.value) - true.error, 0.0)
    told = f"{held:.4g} mm3, the part {true.value:.4g} +- {true.error:.2g} mm3"
    return (off / true.value if off > COARSE * true.value else 0.0), told


def _span(design: Design, name: str | None) -> Span:
    return design.program.outputs[design.program.output(name)].span


def _about(part: Solid, held: float) -> bool:
    """Whether points by chance tell that the part holds about that volume."""
    volume, error = part.guess
    return bool(abs(held - volume) + error <= COARSE * volume)


def hopeless(part: Solid, held: float) -> bool:
    """Whether points by chance tell that a mesh with a volume (mm3) will be refused, whatever is done about crumbs."""
    volume, error = part.guess
    return bool(abs(held - volume) - LITTLE * held > USELESS * (volume + error) + error)


def _finer(wall: float, voxel: float) -> float:
    """The voxel to use for a wall (mm) instead of one that does not do: always a finer one."""
    return min(wall / TO_A_WALL, FINER * voxel)


def _takes(part: Solid, voxel: float) -> str:
    """What a voxel (mm) takes that is proposed, where that is much."""
    told = takes(part.hi - part.lo, voxel)
    return f"; {told}" if told else ""


def lost_doubts(
    design: Design, name: str | None, raw: Surface, surface: Surface, grid: Grid, part: Solid
) -> list[Diagnostic]:
    """W205, where the part has something that the mesh has nothing of: neither the `raw` one on the grid, nor the
    `surface` that was made of it."""
    found = lost(raw, grid, part)
    walls = found.solid & np.isfinite(found.thick) | ~found.solid
    lo, hi = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    beyond = _beyond(found.points[found.solid], lo, hi)
    short = float(beyond.max(initial=0.0)) > SHORT * grid.spacing
    much = short or walls.sum() * found.each > MISSED * len(raw.vertices) or far_and_long(found, grid)
    pieces = missed(raw, grid, part, found)
    across = [b for b in bridged(grid, part) if not (much if b.solid else pieces.gaps)]
    if not much and not len(pieces.middle) and not pieces.gaps and not across:
        return []
    parts, thick = [], found.thick[np.isfinite(found.thick)]
    if short:
        most = np.maximum(hi, found.points[found.solid].max(axis=0)) - np.minimum(
            lo, found.points[found.solid].min(axis=0)
        )
        parts.append(f"the part is at least {_size(most)} mm, the mesh {_size(hi - lo)} mm")
    if much:
        here = int(found.away.argmax())
        far = found.points[found.solid][int(beyond.argmax())] if short else found.points[here]
        kind = "the part has material" if found.solid[here] or short else "the part has a gap"
        wide = f", and is about {np.median(thick):.2g} mm thick there" if len(thick) else ""
        parts.append(f"at {place(far)} {kind} where the mesh has none{wide}")
    parts += [*_named(pieces), *(b.told for b in across)]
    widths = [*([float(np.median(thick))] if much and len(thick) else []), *pieces.across.tolist()]
    widths += [gap.width for gap in pieces.gaps] + [b.width for b in across]
    hint = "use a smaller --voxel, a few to the thinnest wall or gap"
    if widths:
        finer = _finer(min(widths), grid.spacing)
        hint = f"use --voxel {rounded(finer)}mm{_takes(part, finer)}"
    return [
        Diagnostic(
            "W205",
            f"the mesh lacks what is thinner than its voxel of {grid.spacing:.3g} mm: {'; '.join(parts)}",
            _span(design, name),
            "some of this falls between the samples",
            hint=hint,
            severity="warning",
        )
    ]


def _named(pieces: Missed) -> list[str]:
    """How many pieces, voids and gaps of the part are missing, with a place."""
    told = []
    for solid, one, many in ((True, "piece", "pieces"), (False, "void", "voids")):
        some = np.flatnonzero(pieces.solid == solid)
        if len(some):
            first = f"{pieces.across[some[0]]:.2g} mm across at {place(pieces.middle[some[0]])}"
            told.append(
                f"at least {len(some)} whole {many}, one {first}" if len(some) > 1 else f"a whole {one}, {first}"
            )
    for gap in sorted(pieces.gaps, key=lambda g: -g.length)[:1]:
        more = f"{len(pieces.gaps)} gaps, one" if len(pieces.gaps) > 1 else "a gap"
        told.append(f"{more} about {gap.width:.2g} mm wide and {gap.length:.2g} mm long, at {place(gap.at)}")
    return told


def _beyond(points: Floats, lo: Floats, hi: Floats) -> Floats:
    """How far points are outside of a box, along the axis where they are furthest."""
    beyond: Floats = np.maximum(lo - points, points - hi).max(axis=1, initial=-np.inf)
    return beyond


def _size(size: Floats) -> str:
    return " x ".join(f"{s:.4g}" for s in size)


def torn_doubts(design: Design, name: str | None, settled: Settled, grid: Grid) -> list[Diagnostic]:
    """W205, where pieces of the mesh hang together in the part, or may, as most do that there was time to look at."""
    torn, joined = settled.torn, settled.joined
    pending = settled.pending if joined > settled.alone else 0  # most of their like are torn off, or most are not
    if not torn and not pending:
        return []
    told = f"{torn} pieces of the mesh are torn off" if torn > 1 else "a piece of the mesh is torn off" if torn else ""
    if pending:
        looked = joined + settled.alone
        may = f"{pending:,} small pieces may be torn off, as {joined:,} of {looked:,} that were looked at are"
        told = f"{told} and {may}" if told else may
    return [
        Diagnostic(
            "W205",
            f"{told}: in the part what lies between is thinner than the voxel of {grid.spacing:.3g} mm",
            _span(design, name),
            "some of this falls between the samples",
            hint="use a smaller --voxel, a few to the thinnest wall",
            severity="warning",
        )
    ]


def crossed_doubts(design: Design, name: str | None, surface: Surface, crossing: Flags) -> list[Diagnostic]:
    """W207, where triangles cross others."""
    count = int(crossing.sum())
    if not count:
        return []
    where = surface.vertices[surface.faces[int(np.flatnonzero(crossing)[0])]].mean(axis=0)
    return [
        Diagnostic(
            "W207",
            f"the mesh runs through itself: {count} of {len(crossing)} triangles cross others, one at {place(where)}",
            _span(design, name),
            "walls or wedges thinner than a voxel cross there",
            hint="use a smaller --voxel; without --sharp and --simplify the mesh does not cross itself",
            severity="warning",
        )
    ]


def explained(error: PoreError, grid: Grid, part: Solid) -> PoreError:
    """Why a mesh is empty: where the part has material between the samples, that, and the voxel to use."""
    found = lost(None, grid, part)
    some = np.flatnonzero(found.solid)
    if not len(some):
        return error
    thick = found.thick[some][np.isfinite(found.thick[some])]
    at = place(found.points[some[0]])
    if not len(thick):
        between = f"there is material at {at}, and no sample meets it"
        return fail(
            "E111",
            f"the part is thinner than the voxel of {grid.spacing:.3g} mm: {between}",
            hint="use a smaller --voxel: a few to the thinnest wall",
        )
    wall = float(np.median(thick))
    voxel = _finer(wall, grid.spacing)
    many = triangles(part, wall / 4) / voxel**2
    much = _takes(part, voxel)
    if not much and many > MOST_TRIANGLES:
        much = f"; that takes some {many / 1e6:,.0f} million triangles: {A_PART}"
    between = f"about {wall:.2g} mm (at {at}) between samples {grid.spacing:.3g} mm apart"
    return fail(
        "E111",
        f"the walls are thinner than the voxel, and no sample meets them: {between}",
        hint=f"use --voxel {rounded(voxel)}mm{much}",
    )
