"""What of a program adapts: a param that takes data and thickens a lattice, the output that reads it, and its study.

`param t: field = 1.53` is a number until the loop hands it samples; the study is of the output, so that both change.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import Box
from porelang.backends.numpy import NumpyField
from porelang.data import SampledField
from porelang.diagnostics import PoreError, fail, suggest
from porelang.formula import Formula
from porelang.ir import TASKS, Node, node, order, within
from porelang.measure import envelope_of
from porelang.optimize.climb import Refused, about, climb, within_limits
from porelang.optimize.laws import Thickness
from porelang.optimize.record import Under
from porelang.program import Design, Program
from porelang.rewrites import flatten
from porelang.tasks.study.asked import question

Array = NDArray[np.float64]
#: Places within an envelope at which the share of solid is counted: its error is 1 / (2 sqrt n) at most, .1 %.
PLACES = 200_000
#: How many thicknesses make the table of a lattice; the least that is tried, and how often it is made four times that.
_TABLE, _LEAST, _STEPS, _TIMES = 13, 0.01, 7, 4.0
#: Limits are proposed that have been tried: so many times narrower ones.
_TRIALS = 4
#: A param whose default is not 0 is a size first: so many times a factor either way.
_OUTWARD, _APART = 9, 1.4
#: Of the places, every so many make the table: thickness is moved after it until all of them have the porosity.
_FEW = 8
_WAVES = ("sin_turns", "cos_turns", "sin", "cos")


@dataclass(frozen=True, eq=False)
class Adapting:
    """A design, the output that adapts, the param that makes it so, and the study that is of that output.

    `envelope` is what its porosity is relative to, `places` (n, 3) mm are spread evenly over that. The study is loaded
    `under` forces or displacements.
    """

    design: Design
    output: str
    param: str
    study: str
    envelope: Formula
    box: Box
    places: Array
    under: Under = "forces"

    def with_samples(self, samples: SampledField) -> Design:
        """The design with samples for the param."""
        return self.design.program.bind({self.param: samples}).design(dict(self.design.settings))

    def density(self, samples: SampledField) -> float:
        """The share of the envelope that is solid with samples for the param."""
        return _solid(self.part(samples), self.places)

    @cached_property
    def _shares(self) -> dict[float, float]:
        return {}

    def _share(self, value: float) -> float:
        if value not in self._shares:
            self._shares[value] = _solid(self.part(self.same_all_over(value)), self.places[::_FEW])
        return self._shares[value]

    def part(self, samples: SampledField) -> Formula:
        """The output as a formula with samples for the param."""
        if self._open is not None:
            return self._open[0].bind({self._open[1]: samples})
        design = self.with_samples(samples)
        return design.formula(design.program.solid(self.output))

    @cached_property
    def _open(self) -> tuple[Formula, Node] | None:
        """The output, compiled once, and what its samples are bound to; None where tasks of it depend on them."""
        program, samples = _bound(self.design.program, self.param, self.box)
        root = program.solid(self.output)
        if any(n.op in TASKS and n.args for n in order([root], within)):
            return None
        return program.design(dict(self.design.settings)).formula(root), samples

    def same_all_over(self, value: float) -> SampledField:
        """Samples of a value."""
        return SampledField.from_array(np.full((2, 2, 2), value), self.box.lo, _size(self.box))

    def as_it_stands(self) -> float:
        """The share of solid of the program without the loop, with what is bound to it already, if anything is."""
        return _solid(self.design.formula(self.design.program.solid(self.output)), self.places)

    def cell(self, part: Formula | None = None) -> float:
        """The period of the lattice in mm, as the program stands or of the `part` that samples make: the longest of its
        waves, in the middle of the places. Errors: E193 where it has none."""
        part = part or self.design.formula(self.design.program.solid(self.output))
        root = part.root
        turned = [n.args[0] for n in order([root], within) if n.op in _WAVES and n.args[0].axes]
        found = []
        for u in turned:
            slopes = flatten(*(node("d", u, value=a) for a in range(3)))
            rates = np.zeros(len(self.places[::500]))
            for slope in slopes:
                field = NumpyField(part.with_roots(slope), "f64")
                rates = rates + np.asarray(field.at(self.places[::500])) ** 2
            rate = float(np.sqrt(np.median(rates)))
            if rate > 0:
                found.append(1 / rate)
        if not found:
            raise fail("E193", f"`{self.output}` has no waves, so that the size of its cells is not known",
                       hint="give it: --cell 10mm")  # fmt: skip
        return max(found)

    def law(self, low: float, high: float) -> tuple[Thickness, float]:
        """The thickness that gives each density between two, of what the part has with that thickness all over.

        With it comes 1, or -1 where more of the param is less of the solid: then the thickness is minus the param.
        Errors: E193 where these densities are not reached, E192 where the density does not rise all along; what is
        proposed in their place has been tried.
        """
        found = self._tried(low, high)
        if not isinstance(found, Refused):
            return found
        near = found.near
        for _ in range(_TRIALS):
            if near is None:
                break
            other = self._tried(*near)
            if not isinstance(other, Refused):
                break
            near = other.near
        else:
            near = None
        narrow = f"narrow the limits, as in --limits {near[0]:g}..{near[1]:g}, or " if near else ""
        raise fail(found.code, found.message, self.design.program.data[self.param].span,
                   hint=f"{narrow}let `{self.param}` thicken the part all along and more")  # fmt: skip

    def _tried(self, low: float, high: float) -> tuple[Thickness, float] | Refused:
        found, shares, values = self._outward(low, high)
        at = self._default
        if found is None and not (at and np.isnan(self._share_or_none(-at))):  # a size is never below 0
            values = np.array([-(_LEAST * _TIMES**k) for k in range(_STEPS, -1, -1)])
            values = np.concatenate([values, [0.0], -values[::-1]])
            shares = np.array([self._share_or_none(v) for v in values])
            found = climb(values, shares, low, high)
        if found is None:
            return self._out_of_reach(values, shares, low, high)
        first, last, sign = found
        for _ in range(2):  # the ladder is coarse: first to where the limits are
            values = np.linspace(first, last, _TABLE)
            shares = np.array([self._share(sign * v) for v in values])
            first = float(values[max(0, int(np.flatnonzero(shares <= low).max()))])
            last = float(values[min(_TABLE - 1, int(np.flatnonzero(shares >= high).min()))])
        inside = np.flatnonzero((shares > low) & (shares < high))
        used = slice(max(0, inside[0] - 1), inside[-1] + 2)
        flat = np.flatnonzero(np.diff(shares[used]) <= 0)
        if len(flat):
            near = within_limits(*about(values[used], shares[used], sign * at or float(values[used].mean())), low, high)
            return Refused("E192", f"the density of `{self.output}` does not rise at `{self.param}` = "
                            f"{sign * float(values[used][flat[0]]):.4g}", near)  # fmt: skip
        return Thickness(shares[used], values[used]), sign

    def _share_or_none(self, value: float) -> float:
        """NaN where the part is none with that value, as with a period below 0."""
        try:
            return self._share(value)
        except PoreError:
            return np.nan

    @property
    def _default(self) -> float:
        """The default of the param, 0 where it varies."""
        root = self.design.program.data[self.param].default[0]
        return 0.0 if root.axes else float(self.design.formula(*flatten(root)).numbers[0])

    def _out_of_reach(self, values: Array, shares: Array, low: float, high: float) -> Refused:
        """That no way up goes from one limit to the other, where values have these `shares` of solid."""
        there = np.isfinite(shares)
        least, most = about(values[there], shares[there], self._default)
        return Refused("E193", f"`{self.param}` takes the density of `{self.output}` from {least:.3f} to {most:.3f}, "
                        f"which is not all of {low:g} to {high:g}", within_limits(least, most, low, high))  # fmt: skip

    def _outward(self, low: float, high: float) -> tuple[tuple[float, float, float] | None, Array, Array]:
        """The way up among multiples of the default of the param, as of a size, which is never 0: up and down from that
        until the densities pass the limits, or have no such part."""
        middle = self._default
        shares = {0: self.as_it_stands()}
        for side in (1, -1) if middle else ():
            for k in range(side, side * (_OUTWARD + 1), side):
                try:
                    shares[k] = self._share(middle * _APART**k)
                except PoreError:
                    break
                if not low < shares[k] < high:
                    break
        values = np.array([middle * _APART**k for k in sorted(shares)])
        known = np.array([shares[k] for k in sorted(shares)])
        rising = np.argsort(values)
        return climb(values[rising], known[rising], low, high), known[rising], values[rising]


def _solid(part: Formula, places: Array) -> float:
    """The share of places (n, 3) that lie in a part."""
    return float((np.asarray(NumpyField(part, "f64").at(places)) < 0).mean())


def adapting(
    design: Design,
    output: str | None = None,
    adapt: str | None = None,
    study: str | None = None,
    within: str | None = None,
) -> Adapting:
    """What of a design adapts; what is not named is found if it is the only one.

    Errors: E100 for names that are none, E193 where nothing adapts, several could, or the study is of another part.
    """
    program = design.program
    name = program.output(output)
    extent = design.extent(name).outer
    box = Box(extent.lo, extent.hi)
    param = _param(program, name, adapt, box)
    part = design.formula(program.solid(name))
    envelope, _ = envelope_of(design, part, within, box)
    shape = design.formula(envelope)
    places = _places(shape, box)
    studied = _study(program, name, param, study, box)
    return Adapting(design, name, param, studied, shape, box, places, _under(design, studied))


def _are(names: list[str]) -> str:
    """`is `t``, `are `t` and `w``."""
    return f"{'is' if len(names) == 1 else 'are'} {' and '.join(f'`{n}`' for n in names)}"


def _param(program: Program, output: str, adapt: str | None, box: Box) -> str:
    """The param that an output reads."""
    known = [n for n, info in program.data.items() if info.components == 1]
    if adapt is not None and adapt not in known:
        near = suggest(adapt, known)
        raise fail("E193", f"`{adapt}` is no param that takes one number in each place",
                   hint=f"did you mean `{near}`?" if near else f"there {_are(known)}" if known
                   else f"declare it: `param {adapt}: field = 1.5`")  # fmt: skip
    read = [n for n in ([adapt] if adapt else known) if _reads(program, output, n, box)]
    if len(read) == 1:
        return read[0]
    if adapt is not None:
        raise fail("E193", f"`{output}` does not read `{adapt}`", hint="let its thickness be that param: `shell(t)`")
    if read:
        raise fail("E193", f"`{output}` reads {', '.join(f'`{n}`' for n in read)}, which take data",
                   hint=f"say which adapts: --adapt {read[0]}")  # fmt: skip
    raise fail("E193", f"`{output}` reads no param that takes data, so nothing can adapt",
               hint="declare one, `param t: field = 1.5`, and let it thicken: `gyroid(10mm) |> shell(t)`")  # fmt: skip


def _bound(program: Program, param: str, box: Box) -> tuple[Program, Node]:
    """A program with samples that nobody else has, and the node that reads them."""
    samples = SampledField.from_array(np.full((2, 2, 2), 0.7390851332), box.lo, _size(box))
    return program.bind({param: samples}), node("bound", value=(samples.digest,))


def _size(box: Box) -> list[float]:
    return [h - lo for lo, h in zip(box.lo, box.hi, strict=True)]


def _reads(program: Program, output: str, param: str, box: Box) -> bool:
    made, samples = _bound(program, param, box)
    return samples in set(order([made.solid(output)]))


def _study(program: Program, output: str, param: str, study: str | None, box: Box) -> str:
    """The study of an output."""
    made, _ = _bound(program, param, box)
    if study is not None and study not in made.studies:
        near = suggest(study, made.studies)
        raise fail("E100", f"the program has no study `{study}`",
                   hint=f"did you mean `{near}`?" if near
                   else f"it has {', '.join(f'`{s}`' for s in made.studies)}" if made.studies
                   else "name one: `let s = compress(part, ...)`")  # fmt: skip
    of = [n for n, task in made.studies.items() if task.args[0] is made.solid(output) and study in (None, n)]
    if len(of) == 1:
        return of[0]
    if of:
        raise fail("E193", f"`{output}` has several studies: {', '.join(f'`{n}`' for n in of)}",
                   hint=f"say which: --study {of[0]}")  # fmt: skip
    what = "no study of the program is" if study is None else f"the study `{study}` is not"
    raise fail("E193", f"{what} of `{output}` itself, which is what the loop solves",
               hint=f"write `let s = compress({output}, ...)`: of what is iterated, not of the solid")  # fmt: skip


def _under(design: Design, study: str) -> Under:
    """What loads the part of a study.

    Under forces the stiffest part takes the least work, under displacements the most. Of both at once, the stiffest has
    the greatest total potential, which may be 0, so that no step would be so many per cent stiffer than another.
    Errors: E193 for both at once.
    """
    acts = question(design.formula(*design.program.studies[study].args).taken).acts
    moved = any(a.name == "moved" and any(w and d for w, d in zip(a.numbers[:3], a.numbers[3:], strict=True))
                for a in acts)  # fmt: skip
    pushed = [a.name for a in acts if a.name not in ("held", "moved")]
    if moved and pushed:
        raise fail("E193", f"the study `{study}` has a `moved` and a `{pushed[0]}`: there is no one number that says "
                   "which of two parts is stiffer",
                   hint="load it by displacements alone, or by forces alone: `moved` by 0 mm is a support")  # fmt: skip
    return "displacements" if moved else "forces"


def _places(envelope: Formula, box: Box) -> Array:
    """Places spread evenly over an envelope: those of a lattice of points turned against the axes, so that no period
    of the part falls in step with them (R. Cranley and T. N. L. Patterson, 1976; Roberts' R3 sequence)."""
    g = 1.2207440846057596  # the real root of g^4 = g + 1
    size = np.subtract(box.hi, box.lo)
    field = NumpyField(envelope, "f64")
    count = PLACES
    for _ in range(3):
        points = (0.5 + np.arange(1, count + 1)[:, None] / g ** np.arange(1, 4)) % 1 * size + np.array(box.lo)
        inside: Array = points[np.asarray(field.at(points)) < 0]
        if len(inside) >= PLACES // 2:
            break
        count = int(count * PLACES / max(len(inside), PLACES // 50))
    if not len(inside):
        raise fail("E193", "the envelope is empty", hint="name it: --within NAME")
    return inside
