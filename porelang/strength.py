"""The studies of a design in elements: what is solved for a study of its program, to be looked at and written.

What a program reads of a study are samples, found by the same solve (`porelang.tasks.study`).
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import Box
from porelang.atomic import destination, draft_in, save, unwritable
from porelang.compiler import try_compile
from porelang.data import Reduced, SampledField, figures
from porelang.diagnostics import Diagnostic, PoreError, fail, suggest
from porelang.fea import Resultant
from porelang.ir import Node, X, node
from porelang.measure import BOUNDS, envelope_of
from porelang.ops.principal import RESULTS, principal
from porelang.ops.studies import NUMBERS
from porelang.program import Design
from porelang.source import Source
from porelang.tasks.resolve import leave
from porelang.tasks.study.asked import question
from porelang.tasks.study.found import kept
from porelang.tasks.study.numbers import form_error
from porelang.tasks.study.sized import Sized
from porelang.tasks.study.solved import Solved, refined, solved
from porelang.tasks.telling import told

Floats = NDArray[np.float64]
#: What is no number of its own in a report: it is told under `error`.
_ERROR = "error"
#: What the solver doubts of loads and elements, and a study does not say itself: a force on a point, locking, a ragged
#: area, an equilibrium that rounding ends early, a load that supports take, a support that ends within elements, loads
#: that do not quite balance, one that is smaller than an element.
_OF_THE_SOLVER = frozenset({"W258", "W259", "W280", "W281", "W286", "W288", "W289", "W291"})
#: A part without an envelope of its own that fills so much of its bounds is a solid, and no lattice in them.
_FILLS = 0.5


@dataclass(frozen=True, repr=False)
class Strength:
    """A study in elements: the mesh with what was found on it (`solved`), and what it comes to.

    `numbers` are those that the study gives in the language, each with its error: stiffness (N/mm), compliance (N mm),
    stresses (MPa), displacements (mm), volume (mm3), mass (g). `effective_modulus` (MPa) is that of a compression, of
    the area of the `envelope` and the length between platens; None of any other. `told` are its note and its doubts.
    """

    name: str
    solved: Solved
    effective_modulus: Reduced | None
    envelope: str
    told: tuple[Diagnostic, ...]

    @property
    def numbers(self) -> Mapping[str, Reduced]:
        """The numbers by name, of those that there are: stiffness of one load, mass where the density is known."""
        return {name: number for name, number in self.solved.numbers.items() if not self._lacks(name)}

    @property
    def report(self) -> dict[str, Any]:
        """What `pore fea --json` prints of it."""
        solved, numbers = self.solved, self.solved.numbers
        shown = {name: numbers[name].value for name in NUMBERS if name != _ERROR and not self._lacks(name)}
        errors = {name: numbers[name].error for name in shown}
        if self.effective_modulus is not None:
            shown["effective_modulus"] = self.effective_modulus.value
            errors["effective_modulus"] = self.effective_modulus.error
        wall, missed = solved.sized.wall, solved.missed
        return {
            "study": self.name,
            "elements": len(solved.mesh.tets),
            "unknowns": solved.unknowns,
            "iterations": solved.iterations,
            "residual": solved.residual,
            "size": solved.sized.size,
            "finest_size": solved.sized.finest or solved.sized.size,
            "halved": solved.sized.halved,
            **shown,
            "reaction": self.reaction.tolist(),
            "reactions": {name: force.tolist() for name, force in solved.reactions.items()},
            "supports": {r.name: _resultant(r) for r in solved.supports},
            "loads": {r.name: _resultant(r) for r in solved.loads},
            "left_out": solved.lost,
            "wall": None if wall is None else {"thickness": wall.wall, "at": wall.at.tolist()},
            "missed": {"lacking": missed.lacking, "beyond": missed.beyond, "at": list(missed.at),
                       "holes": missed.of, "holes_otherwise": missed.handles, "of_stiffness": form_error(missed)},
            "error": {"energy": numbers[_ERROR].value, **errors},
        }  # fmt: skip

    @property
    def reaction(self) -> Floats:
        """The force (N) with which what stands still holds the part against its load: of all supports that do not move
        it together, a platen, the held end, the outer pads of a beam, everything that is `held`. It is opposite to the
        sum of the loads, and to what a support presses with that moves the part. 0 where no support stands still."""
        solved = self.solved
        moving = {
            reaction.name
            for support, reaction in zip(solved.solution.problem.supports, solved.solution.reactions, strict=True)
            if callable(support.displacement) or any(support.displacement)
        }
        total = np.zeros(3)
        for name, force in solved.reactions.items():
            total += 0.0 if name in moving else force
        return total

    def _lacks(self, name: str) -> bool:
        return name in ("mass", "stiffness") and not self.solved.numbers[name].value

    def __repr__(self) -> str:
        numbers = ("stiffness", "max_von_mises", "max_displacement")
        told = (f"{name} {figures(n.value, n.error)}" for name, n in self.numbers.items() if name in numbers)
        return f"<study {self.name} of {len(self.solved.mesh.tets):,} elements: {', '.join(told)}>"

    def write(self, path: str | Path) -> None:
        """Write the elements with what was found on them as .vtu, whole or not at all.

        At points: displacement (mm), stress (MPa, VTK's order xx yy zz xy yz xz), strain (likewise; shear is half of
        the engineers'), von Mises' stress, principal stresses and their directions, energy density (N/mm2). In cells:
        Young's modulus (MPa), and by which share the stress of each errs. Errors: E112 for another ending, E113.
        """
        if Path(path).suffix.lower() != ".vtu":
            raise fail("E112", f"{path}: results of a study are written as .vtu", hint="end the name with .vtu")
        with draft_in(destination(path).parent) as draft:
            try:
                _write_vtu(self.solved, draft)
            except OSError as error:
                raise unwritable(path, error) from error
            save(path, lambda file: shutil.copyfileobj(draft.open("rb"), file))


def _resultant(of: Resultant) -> dict[str, Any]:
    """What acts in one place: area (mm2), its middle (mm), force (N), moment about that middle (N mm)."""
    return {"area": of.area, "centre": of.centre.tolist(), "force": of.force.tolist(), "moment": of.couple.tolist()}


def carry_out(
    design: Design, name: str | None = None, refine: bool = False, within: str | None = None, out: str | None = None,
    begun: Callable[[Sized], None] | None = None,
) -> Strength:  # fmt: skip
    """Solve a study that a `let` of the program names: the one that is asked for, or the only one. Or one that is
    described as a program would call it, `compress(part, 10kN, axis=z, material="PA12")`, of the output `out`.

    `refine` adds a step of refinement: where the stresses of the first solve err most, elements of half the size.
    `within` names the envelope of an effective modulus: an output or a `let`. `begun` is told of the size of elements,
    and about how many there are, before they are made. Errors: E100 where there is no such
    study, or several and none is named; E109 for an unknown `within`; those of the study.

    >>> import porelang
    >>> text = "let s = compress(box([9mm, 9mm, 9mm]), 1kN, E=2GPa, nu=0.3, size=5mm)\\nout part = box([9mm, 9mm, 9mm])"
    >>> found = carry_out(porelang.compile(text).design())
    >>> round(found.numbers["max_von_mises"].value, 3)
    12.346
    """
    if name is not None and "(" in name:
        n = described(design, name, out)
    else:
        name, n = chosen(design, name)
    place = design.program.places.get(n)
    try:
        asked = design.formula(*n.args)
        found = solved(question(asked.taken), begun)
        if refine:
            found = refined(found)
        samples = kept(found)
        if not refine:  # a mesh that reads the study has it from here
            leave(n, asked.bindings, design.program.places, samples)
    except PoreError as error:
        raise PoreError([replace(d, span=d.span or place) for d in error.diagnostics]) from None
    return _result(design, name, n, found, samples, within)


def chosen(design: Design, name: str | None) -> tuple[str, Node]:
    """A study of the program, and its name. Errors: E100."""
    studies = design.program.studies
    if name is None and len(studies) == 1:
        return next(iter(studies.items()))
    if name is not None and name in studies:
        return name, studies[name]
    if not studies:
        hint = 'name one with `let`: `let s = compress(part, force=10kN, axis=z, material="PA12")`'
        raise fail("E100", "the program has no study", hint=hint)
    listed = ", ".join(f"`{s}`" for s in studies)
    if name is None:
        raise fail("E100", f"the program has several studies: {listed}", hint="choose one with --study NAME")
    near = suggest(name, studies)
    raise fail(
        "E100", f"the program has no study `{name}`", hint=f"did you mean `{near}`?" if near else f"it has {listed}"
    )


def described(design: Design, call: str, out: str | None = None) -> Node:
    """The study of an output that a text describes; `part` is that output, and no other name of the program is known.

    Errors: E108 for a text that is no call of a study, and what is wrong with it.
    """
    source = Source("--study", f"let part = x\nlet studied = {call}\npart")
    program, found = try_compile(source)
    if program is None:
        raise PoreError(found)
    n = program.studies.get("studied")
    if n is None or n.args[0] is not X:
        hint = 'as in `compress(part, 10kN, axis=z, material="PA12")`'
        raise fail("E108", f"`{call}` is no study of `part`", hint=hint)
    return node("study", design.program.solid(out), *n.args[1:])


def _result(design: Design, name: str, n: Node, found: Solved, samples: SampledField, within: str | None) -> Strength:
    place = design.program.places.get(n)
    doubts = told(n, samples, place)
    doubts += [replace(d, span=d.span or place) for d in found.solution.doubts if d.code in _OF_THE_SOLVER]
    whole = found.asked.whole
    modulus, called = None, ""
    if whole is not None and whole.name == "compress":
        modulus, called = _modulus(design, found, int(whole.numbers[1]), within)
    return Strength(name, found, modulus, called, tuple(doubts))


def _modulus(design: Design, found: Solved, axis: int, within: str | None) -> tuple[Reduced, str]:
    """Stiffness times length over area: what a solid in place of the part would be made of."""
    part, mesh = found.asked.part, found.mesh
    lo, hi = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    length = float(hi[axis] - lo[axis])
    envelope, called = envelope_of(design, part, within, Box(tuple(lo.tolist()), tuple(hi.tolist())))
    whole = design.number(node("volume", envelope)).value
    own = found.numbers["volume"].value
    if called == BOUNDS and own > _FILLS * whole:  # a plain shape is its own envelope
        whole, called = own, "the part itself"
    area = whole / length
    stiffness = found.numbers["stiffness"]
    return Reduced(stiffness.value * length / area, stiffness.error * length / area), called


def _write_vtu(found: Solved, path: Path) -> None:
    """The elements of a study and what was found on them, as VTK's XML."""
    from meshio import Mesh
    from meshio.vtu import write

    fields = found.fields
    way = principal(*fields.stress.T)
    points: dict[str, Floats] = {
        "displacement": fields.displacement,
        "stress": fields.stress,
        "strain": fields.strain,
        "von_mises": fields.von_mises,
        "energy": fields.energy,
        **{f"principal{k}": way[RESULTS.index(f"v{k}")] for k in (1, 2, 3)},
        **{f"direction{k}": np.stack([way[RESULTS.index(f"{a}{k}")] for a in "xyz"], 1) for k in (1, 2, 3)},
    }
    cells = {"young": [found.young], "error": [found.errors]}
    write(str(path), Mesh(fields.mesh.vertices, [("tetra", fields.mesh.tets)], points, cells))
