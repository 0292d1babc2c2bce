"""What is taken away of a part so that one sees inside: half-spaces, and corners where several of them meet."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from porelang.analysis.box import Box
from porelang.diagnostics import fail

Faces = tuple[bool, bool, bool]
#: As many as the shader has room for.
MOST_NOTCHES = 8


@dataclass(frozen=True, slots=True)
class HalfSpace:
    """Where the coordinate `axis` lies below (or above) `at` mm."""

    axis: int
    below: bool
    at: float

    def __str__(self) -> str:
        return f"{'xyz'[self.axis]}{'<' if self.below else '>'}{self.at:g}"


#: What lies in all of these is taken away: one makes a half, two that cross a quarter.
Cut = tuple[HalfSpace, ...]


@dataclass(frozen=True, slots=True)
class Shown:
    """A box, which of its lower and upper faces cut the part, and the notches: boxes in it that are taken out."""

    box: Box
    cut_lo: Faces
    cut_hi: Faces
    notches: tuple[Box, ...] = ()


def whole(box: Box, at_ends: bool = False) -> Shown:
    """A box of which nothing is taken away; `at_ends`: the part goes on beyond it, and is cut at its faces."""
    return Shown(box, (at_ends,) * 3, (at_ends,) * 3)


def take_away(shown: Shown, cuts: Iterable[Cut]) -> Shown:
    """What cuts leave of a box. A notch that takes a whole side of the box makes the box smaller.

    Errors: E107 where nothing is left, E114 for too many notches.
    """
    left = list(cuts)
    while (found := next(((c, s) for c in left if (s := _shorter(shown, c)) is not None), None)) is not None:
        left.remove(found[0])
        shown = found[1]
    notches = tuple(n for n in (_region(shown.box, c) for c in left) if n is not None)
    if len(notches) > MOST_NOTCHES:
        raise fail("E114", f"{len(notches)} corners are cut out, and {MOST_NOTCHES} are the most",
                   hint="leave some out, or join those that share a face")  # fmt: skip
    return Shown(shown.box, shown.cut_lo, shown.cut_hi, notches)


def _region(box: Box, cut: Cut) -> Box | None:
    """What a cut takes of a box, or None; it goes beyond the box where the cut has no end there."""
    beyond = max(box.size)
    ends = [[v - beyond for v in box.lo], [v + beyond for v in box.hi]]
    for h in cut:
        keep, end = (min, 1) if h.below else (max, 0)
        ends[end][h.axis] = keep(ends[end][h.axis], h.at)
    (a, b) = ends
    if any(max(a[i], box.lo[i]) >= min(b[i], box.hi[i]) for i in range(3)):
        return None
    return Box((a[0], a[1], a[2]), (b[0], b[1], b[2]))


def _shorter(shown: Shown, cut: Cut) -> Shown | None:
    """The box that is left where a cut takes all that lies on one side of a plane. Errors: E107: it takes all."""
    box = shown.box
    region = _region(box, cut)
    if region is None:
        return None
    below = [region.lo[i] <= box.lo[i] for i in range(3)]
    above = [region.hi[i] >= box.hi[i] for i in range(3)]
    across = [i for i in range(3) if not (below[i] and above[i])]
    if not across:
        axis = cut[0].axis
        reach = f"from {box.lo[axis]:.6g} to {box.hi[axis]:.6g} mm along {'xyz'[axis]}"
        raise fail("E107", f"the cut {' & '.join(map(str, cut))} leaves nothing of the part",
                   hint=f"the part reaches {reach}")  # fmt: skip
    (axis, *others) = across
    if others or not (below[axis] or above[axis]):
        return None
    lo, hi, cut_lo, cut_hi = list(box.lo), list(box.hi), list(shown.cut_lo), list(shown.cut_hi)
    if below[axis]:
        lo[axis], cut_lo[axis] = region.hi[axis], True
    else:
        hi[axis], cut_hi[axis] = region.lo[axis], True
    return Shown(Box((lo[0], lo[1], lo[2]), (hi[0], hi[1], hi[2])),
                 (cut_lo[0], cut_lo[1], cut_lo[2]), (cut_hi[0], cut_hi[1], cut_hi[2]))  # fmt: skip
