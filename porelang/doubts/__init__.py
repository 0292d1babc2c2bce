"""What values show to be a mistake, of what `porelang.elaborate.suspect` noted while a program was elaborated.

Each suspicion is looked at with the params at their defaults, at some thousands of points: where those do not bear it
out, nothing is said. What reads a porosity, a file or anything else that takes long to find is left alone until that
is found.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping

from porelang.diagnostics import Diagnostic
from porelang.doubts import curves, distances, frames, lattices, seams, solids, stretches
from porelang.doubts.periods import beyond, bodies, drifting
from porelang.doubts.solids import MOST_CUTS, MOST_NODES, idle_cuts
from porelang.elaborate.results import Elaborated, Suspicion
from porelang.formula import Bindings, Formula
from porelang.ir import TASKS, Node, order, within
from porelang.rewrites import flatten
from porelang.settings import off_step
from porelang.source import Span

__all__ = ["borne_out", "idle_cuts"]

#: What looks at a suspicion of each kind; at a "rod" with what follows it.
_LOOKS: Mapping[str, Callable[[Suspicion, Elaborated, Bindings], Diagnostic | None]] = {
    "total": solids.total,
    "copies": lattices.copies,
    "apart": solids.apart,
    "empty": solids.empty,
    "pores": lattices.pores,
    "seam": seams.seam,
    "jump": seams.jump,
    "period": drifting,
    "still": frames.still,
    "fold": frames.fold,
    "fits": frames.fits,
    "uneven": distances.uneven,
    "stretched": stretches.stretched,
    "bend": curves.bend,
    "beyond": beyond,
}
#: Of these it is looked again when they read what tasks find, or the part does in which they are seen.
_LATE = ("seam", "jump", "period", "still", "fold", "fits", "stretched", "bend", "beyond", "uneven")
#: These are looked at where the parts show them, which takes some 0.3 ms for each operation of the parts: so many
#: operations in all, some six seconds.
_MOST_SEEN = 20_000


def borne_out(found: Elaborated, bindings: Bindings) -> list[Diagnostic]:
    """A warning for each suspicion that values bear out, and for each name that nothing reads."""
    whole = {n for output in found.outputs.values() for n in output.nodes}  # of what is empty as a whole more is said
    looked_at = [
        s
        for s in found.suspicions
        if s.what in _LOOKS and not (solids.is_whole(s, whole) or distances.is_idle(s, found))
    ]
    out: list[Diagnostic] = []
    said: set[tuple[str, Span]] = set()  # of one place a thing is said once
    spent = cuts = seen = 0
    parts = len(order(whole, within))
    for s in looked_at:
        size, cut = len(order(s.nodes, within)), s.what in ("apart", "empty")
        sees = parts if s.what in _LATE else 0
        if spent + size > MOST_NODES or cuts + cut > MOST_CUTS or seen + sees > _MOST_SEEN:
            continue  # smaller ones may follow
        spent, cuts, seen = spent + size, cuts + cut, seen + sees
        if (s.what, s.span) not in said and (d := _LOOKS[s.what](s, found, bindings)) is not None:
            said.add((s.what, s.span))
            out.append(d)
    return [
        *out,
        *_unread(found),
        *off_step(found.params, {k: i.default for k, i in found.params.items()}, default=True),
    ]


def of_data(
    found: Elaborated, formula: Callable[..., Formula], known: Collection[Node], before: Collection[Diagnostic]
) -> list[Diagnostic]:
    """A warning for each lattice that values bear out when it is known what it reads, and what the parts read in which
    it is seen: all of it is among the tasks that are `known`. What was said `before` is not said again.
    """

    def read(flat: Collection[Node]) -> list[Node]:
        return [n for n in order(flat) if n.op in TASKS]

    late = [s for s in found.suspicions if s.what in _LATE and not distances.is_idle(s, found)] if known else []
    outputs = [o.nodes for o in found.outputs.values()] if late else []
    # what a lattice is seen in reads numbers of its own
    flats = [flatten(*nodes) for nodes in (*outputs, *([body] for body in (bodies(found) if late else ())))]
    seen = [flat for flat in flats if all(n in known for n in read(flat))]
    of_parts = any(read(flat) for flat in seen)
    out: list[Diagnostic] = []
    said = {(d.code, d.span) for d in before}
    for s in late:
        flat = flatten(*s.nodes)
        needed = read(flat)
        if not (needed or of_parts) or any(n not in known for n in needed):
            continue
        d = _LOOKS[s.what](s, found, formula(*flat, *(n for body in seen for n in body)).bindings)
        if d is not None and (d.code, d.span) not in said:
            said.add((d.code, d.span))
            out.append(d)
    return out


def _unread(found: Elaborated) -> list[Diagnostic]:
    """Lets and params that nothing refers to, of a file that is more than a collection for others."""
    if not found.outputs:
        return []
    out = []
    for u in found.unread:
        if u.param:
            message, hint = f"nothing reads the param `{u.name}`", "use it, or leave it out: setting it changes nothing"
        else:
            message = f"nothing reads `{u.name}`"
            hint = (
                f"use it, or leave it out; call it `_{u.name}` if only an option or Python names it: "
                f'`--within _{u.name}`, `field("_{u.name}")`'
            )
            if u.fixed:
                hint = f'use it, or leave it out; call it `_{u.name}` if only Python asks for it: `number("_{u.name}")`'
        out.append(Diagnostic("W220", message, u.span, "bound here, and not used", hint=hint, severity="warning"))
    return out
