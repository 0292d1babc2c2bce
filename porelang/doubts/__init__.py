"""What values show to be a mistake, of what `porelang.elaborate.suspect` noted while a program was elaborated.

Each suspicion is looked at with the params at their defaults, at some thousands of points: where those do not bear it
out, nothing is said. What reads a porosity, a file or anything else that takes long to find is left alone.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping

from porelang.diagnostics import Diagnostic
from porelang.doubts import curves, distances, frames, lattices, solids, stretches
from porelang.doubts.periods import beyond, bodies, drifting
from porelang.doubts.solids import MOST_CUTS, MOST_NODES, idle_cuts
from porelang.elaborate.results import Elaborated, Suspicion
from porelang.formula import Bindings, Formula
from porelang.ir import TASKS, Node, order, within
from porelang.rewrites import flatten
from porelang.settings import off_step
from porelang.source import Span

__all__ = ["borne_out", "idle_cuts"]

#: What looks at a suspicion of each kind.
_LOOKS: Mapping[str, Callable[[Suspicion, Elaborated, Bindings], Diagnostic | None]] = {
    "total": solids.total,
    "copies": lattices.copies,
    "apart": solids.apart,
    "empty": solids.empty,
    "pores": lattices.pores,
    "seam": lattices.seam,
    "jump": lattices.jump,
    "period": drifting,
    "still": frames.still,
    "fold": frames.fold,
    "fits": frames.fits,
    "uneven": distances.uneven,
    "stretched": stretches.stretched,
    "bend": curves.bend,
    "beyond": beyond,
}
#: Of these it is looked again, when they read what tasks find.
_LATE = ("period", "beyond", "uneven")


def borne_out(found: Elaborated, bindings: Bindings) -> list[Diagnostic]:
    """A warning for each suspicion that values bear out, and for each name that nothing reads."""
    whole = {n for output in found.outputs.values() for n in output.nodes}  # of what is empty as a whole more is said
    looked_at = [s for s in found.suspicions if not solids.is_whole(s, whole)]
    out: list[Diagnostic] = []
    said: set[tuple[str, Span]] = set()  # of one place a thing is said once
    spent = cuts = 0
    for s in looked_at:
        size, cut = len(order(s.nodes, within)), s.what in ("apart", "empty")
        if spent + size > MOST_NODES or cuts + cut > MOST_CUTS:
            continue  # smaller ones may follow
        spent, cuts = spent + size, cuts + cut
        if (s.what, s.span) not in said and (d := _LOOKS[s.what](s, found, bindings)) is not None:
            said.add((s.what, s.span))
            out.append(d)
    return [
        *out,
        *_unread(found),
        *off_step(found.params, {k: i.default for k, i in found.params.items()}, default=True),
    ]


def of_data(found: Elaborated, formula: Callable[..., Formula], known: Collection[Node]) -> list[Diagnostic]:
    """A warning for each lattice that values bear out when it is known what it reads: all of it is among the tasks that
    are `known`. Of those that read none it has been said when the program was compiled.
    """
    out = []

    def read(flat: Collection[Node]) -> list[Node]:
        return [n for n in order(flat) if n.op in TASKS]

    def is_known(flat: Collection[Node]) -> bool:
        return all(n in known for n in read(flat))

    late = [s for s in found.suspicions if s.what in _LATE]
    # what a lattice is seen in reads numbers of its own
    seen = [flat for body in bodies(found) if late and is_known(flat := flatten(body))]
    said: set[tuple[str, Span]] = set()
    for s in late:
        flat = flatten(*s.nodes)
        if not (read(flat) and is_known(flat)) or (s.what, s.span) in said:
            continue
        bindings = formula(*flat, *(n for body in seen for n in body)).bindings
        if (d := _LOOKS[s.what](s, found, bindings)) is not None:
            said.add((s.what, s.span))
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
