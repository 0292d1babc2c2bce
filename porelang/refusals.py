"""What other commands would refuse of a program: no output, no surface, no end, no material.

`pore check` says so before. A field that is no part is nothing wrong: it is evaluated, and drawn within bounds that are
given.
So ends are looked at of that output only which commands take by themselves, material also of other short ones that are
solids, and only what is decided quickly is said; the rest is found with `--measure`.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from porelang.analysis.box import extent_of, has_ends, unbounded_axes
from porelang.analysis.sampled import about_the_origin, holds_anything, seen, unending, unstretched
from porelang.backends.numpy import NumpyField
from porelang.diagnostics import Diagnostic, Label, PoreError
from porelang.elaborate.advice import as_solid, joins
from porelang.elaborate.results import ParamInfo
from porelang.elaborate.values import Bool, Scalar, Vector
from porelang.extents import NoEnd, no_end
from porelang.formula import Bindings, Formula
from porelang.ir import TASKS, order, param, within
from porelang.program import Design, Program
from porelang.rewrites import flatten
from porelang.source import Span

#: Graphs up to this size are looked at without `--measure`: samples of them take less than 0.1 s.
QUICK = 5000
#: Of larger ones no end is proven without `--measure`: of 37 tubes in two sheets it takes a minute.
PROVEN = 150
#: Other outputs than the one that is taken by itself are looked at without `--measure` up to so many operations.
TOGETHER = 500
#: Samples of the box of a part, with `--measure`.
SAMPLES = 200_000
#: What is thinner along an axis (mm) may be there by rounding alone, where two shapes touch.
ROUNDED = 1e-6
#: More than this share of infinite values is no matter of a few places.
UNDEFINED = 0.99
#: In place of an offset that is yet to be found.
A_LITTLE = 0.1
#: What is wrong with a part, and not with its program: of a value that counts that is told by `structural_faults`.
_OF_THE_PART = frozenset({"E102", "E103", "E117"})
#: Values further from the default may make a program of another size: they are compiled on request.
FAR = 200
END_IT = "intersect it with a shape, `... & box([50, 50, 50])`, or mesh it with --bounds"


def refusals(design: Design, measure: bool = False) -> list[Diagnostic]:
    """What meshing would say of the output that it takes by itself, and of others that are solids: an error where there
    is no material.

    Without `measure` it takes 0.1 s at most: of other outputs the short ones are looked at, as long as there are few,
    and nothing is said of a part that depends on numbers found from fields. With it every output that is a solid is
    looked at, and the one that is taken by itself also with each param at either end of its range.
    """
    program = design.program
    if not program.outputs:
        return _no_output(program)
    chosen = _chosen(program)
    found: list[Diagnostic] = []
    left = TOGETHER
    for name, output in program.outputs.items():
        if name != chosen and not measure:
            left -= len(order(program.graph.outputs[name], within))
        if name == chosen or (output.solid and (measure or left >= 0)):
            found += _refused(design, name, measure, chosen)
    if measure and chosen and not found:
        found += _as_a_part(design, chosen)
    return found


def endless(design: Design) -> str:
    """The axes along which the output that commands take by itself is a field without an end; "" where it is a part."""
    name = _chosen(design.program)
    if name is None or not isinstance(design.program.outputs[name].value, Scalar):
        return ""
    (root,) = design.program.graph.outputs[name]
    nodes = order([root], within)
    if not root.axes or any(n.op in TASKS for n in nodes) or len(nodes) > QUICK:
        return ""
    formula = design.of(name)
    if len(nodes) > PROVEN and not unending(formula):
        return ""
    found = _no_end(formula)
    return found.axes if found is not None and found.as_far else ""


def _no_end(formula: Formula) -> NoEnd | None:
    """What meshing would say of a field of which no end is proven; None where one is."""
    return None if not unending(formula) and has_ends(formula) else _unproven(formula)


def _unproven(formula: Formula) -> NoEnd | None:
    extent = extent_of(formula)
    if extent is None or not unbounded_axes(extent.outer):
        return None
    return no_end(formula, extent.outer)


def _chosen(program: Program) -> str | None:
    """The output that a command takes when none is named."""
    names = list(program.outputs)
    return "part" if "part" in names else names[0] if len(names) == 1 else None


def _no_output(program: Program) -> list[Diagnostic]:
    if program.elaborated.collection:
        return []
    try:
        program.output()
    except PoreError as error:
        (found,) = error.diagnostics
        if not program.source.text.strip():
            return [found]
        unread = program.elaborated.unread
        last = next((u.name for u in reversed(unread) if not u.param), "...")
        return [
            replace(
                found,
                code="W221",
                span=unread[-1].span if unread else found.span,
                label="definitions alone",
                hint=f"end it with `{last}`, or write `out part = {last}`; a file that others use needs none",
                severity="warning",
            )
        ]
    return []


def _refused(design: Design, name: str, measure: bool, chosen: str | None) -> list[Diagnostic]:
    program = design.program
    output, roots = program.outputs[name], program.graph.outputs[name]
    if not isinstance(output.value, Scalar) or not roots[0].axes:
        return [_no_surface(design, name)] if name == "part" else []
    nodes = order(roots, within)
    if not measure:
        if len(nodes) > QUICK:
            return []
        asked = [n for n in nodes if n.op in TASKS]
        if asked:  # of an offset yet to be found it is known that it leaves both solid and void
            bindings: Bindings = {param(k): v for k, v in design.settings.items()} | dict.fromkeys(asked, A_LITTLE)
            sure = output.made and {n.op for n in asked} <= {"to_porosity", "shell_to_porosity"}
            missing = _no_end(Formula(roots, bindings)) if sure else None
            return [_as_doubt(missing, name, output.span)] if missing else []
        formula = design.of(name)
        if (nowhere := _undefined(design, name, formula)) is not None:
            return [nowhere] if output.solid else [replace(nowhere, severity="warning", code="W211")]
        if holds_anything(formula) and not unending(formula) and (len(nodes) > PROVEN or has_ends(formula)):
            return []
    try:
        design.bounds(name)
    except PoreError as error:
        (found,) = error.diagnostics
        if found.code == "E103" and output.solid:
            return [found]
        if found.code == "E103":
            return [replace(found, code="W211", severity="warning")] if name == "part" else []
        if found.code != "E102":
            return [found]
        missing = _unproven(design.of(name)) if name == chosen else None
        if missing and (output.made or not missing.as_far):  # a field has none
            return [_as_doubt(missing, name, output.span)]
    return []


def _undefined(design: Design, name: str, formula: Formula) -> Diagnostic | None:
    """Of a field that is infinite wherever samples look, that it is."""
    values = NumpyField(formula, "f64", 1).at(about_the_origin())
    if not np.isinf(values).mean() > UNDEFINED:
        return None
    return Diagnostic(
        "E110",
        f"the field of `{name}` is infinite nearly everywhere",
        design.program.outputs[name].span,
        "infinite at all points that were looked at" if np.isinf(values).all() else "infinite at most points",
        hint="look for a division by zero",
    )


def _as_doubt(found: NoEnd, name: str, span: Span) -> Diagnostic:
    """E102 as `pore check` says it: meshing it takes bounds, and there is nothing wrong with it till then."""
    hint = END_IT if found.as_far else found.hint
    return replace(found.told(name, span), code="W210", hint=hint, severity="warning")


def _no_surface(design: Design, name: str) -> Diagnostic:
    """A warning about an output that is no number, or the same number everywhere."""
    output = design.program.outputs[name]
    span, hint = output.span, "a solid is a number that varies in space and is negative inside"
    others, edit = tuple[Label, ...](), None
    match output.value:
        case Vector():
            what, label = "a vector", "three numbers at every point"
        case Bool():
            what, label = "a condition", "true or false at every point"
            hint = "a solid is where a number is negative: write the number alone, `f` for `f < 0` and `~f` for `f > 0`"
            compared = design.program.elaborated.conditions.get(output.value.node)
            if compared is not None and joins(compared):
                hint, edit = as_solid(compared)
                others = () if compared.span == span else (Label(compared.span, "compared here"),)
        case _:
            value = design.formula(*design.program.graph.outputs[name]).numbers[0]
            what, label = f"{float(value):.6g} everywhere", "the same at every point"
    return Diagnostic("W211", f"`{name}` is {what}, which has no surface", span, label, others, hint, edit, "warning")


def _at_the_ends(design: Design, name: str) -> list[Diagnostic]:
    """A warning for each end of a param's range with which an output that is a part now is none."""
    program = design.program
    found: list[Diagnostic] = []
    for setting, info in program.params.items():
        for value in info.ends:
            if value == design.settings[setting]:
                continue
            try:
                program.design({**design.settings, setting: value}).bounds(name)
            except PoreError as error:
                if setting not in program.structure or error.diagnostics[0].code in _OF_THE_PART:
                    found.append(_broken_end(setting, info.shown(value), info.span, error.diagnostics[0]))
    return found


def structural_faults(program: Program, all_values: bool = False) -> list[Diagnostic]:
    """What is wrong or doubtful with the program for other values of the params that count and choose.

    One param is varied at a time, the others are at their defaults: over its choices, else at both ends of its range
    where that is not more than `FAR` values from the default, or if `all_values` says so over whole ranges (all of 64,
    or 16 of more). Each thing is told once.
    """
    found: list[Diagnostic] = []
    told = {d.told for d in program.warnings}
    for name in program.structure:
        for value in _tried(program.params[name], all_values):
            if any(d.code == "E070" for d in found):  # too big: what counts more is bigger, and takes as long
                return found
            try:
                made = program.design({name: value}).program
                where = f", with {name} = {program.params[name].shown(value)}"
                several = [replace(d, message=d.message + where) for d in made.warnings]
            except PoreError as error:
                several = list(error.diagnostics)
            found += [d for d in several if d.told not in told]
            told |= {d.told for d in several}
    return found


def _tried(info: ParamInfo, all_values: bool) -> list[float]:
    """The values of a structural param that are looked at, without its default."""
    values = list(info.ends)
    if all_values and not info.choices:
        step = info.step or 1.0
        count = int((info.high - info.low) // step) + 1
        values = [info.low + step * round(i) for i in np.linspace(0, count - 1, count if count <= 64 else 16)]
    near = all_values or info.choices
    return [v for v in values if v != info.default and (near or abs(v - info.default) <= FAR)]


def _as_a_part(design: Design, name: str) -> list[Diagnostic]:
    """What is doubtful of an output that is a part, with an end."""
    if not design.program.outputs[name].solid:
        return []
    try:
        design.bounds(name)
    except PoreError:  # a field without an end
        return []
    return _hardly_there(design, name) or [*_larger_cells(design, name), *_at_the_ends(design, name)]


def _hardly_there(design: Design, name: str) -> list[Diagnostic]:
    """A warning where a part has a box, and no sample in it meets material: surfaces that only touch.

    A box is proven, and may be a thousand times as large as a thin part in it: that is looked for by its values, too.
    """
    box, formula = design.bounds(name), design.of(name)
    points = np.random.default_rng(1).uniform(box.lo, box.hi, (SAMPLES, 3))
    if bool((NumpyField(formula, "f64", 1).at(points) < 0).any()):
        return []
    found = seen(formula)
    if found is not None and float((found[1] - found[0]).min()) > ROUNDED:
        return []
    return [
        Diagnostic(
            "W211",
            f"`{name}` holds no material that {SAMPLES:,} samples could find",
            design.program.outputs[name].span,
            "walls without thickness, or two shapes that only touch",
            (),
            "check the numbers",
            None,
            "warning",
        )
    ]


def _larger_cells(design: Design, name: str) -> list[Diagnostic]:
    """A warning for each lattice of which the part does not hold half a period in any direction."""
    program = design.program
    size = max(design.bounds(name).size)
    found: dict[Span, Diagnostic] = {}  # a choice among lattices names one period for several
    bindings: Bindings = {param(k): v for k, v in design.settings.items()}
    for n in unstretched(program.outputs[name].nodes, bindings):
        span, period = program.elaborated.lattices.get(n, (None, None))
        if span is None or period is None:
            continue
        w = float(design.formula(*flatten(period)).numbers[0])
        if w > 2 * size:
            message = f"the period of {w:g} mm is more than twice the part, which is {size:.3g} mm at most"
            hint = "the period is the edge of a cell in mm, not a number of cells"
            found[span] = Diagnostic("W225", message, span, "not half a cell fits in", (), hint, None, "warning")
    return list(found.values())


def _broken_end(name: str, shown: str, span: Span, found: Diagnostic) -> Diagnostic:
    return Diagnostic(
        "W222",
        f"with `{name}` = {shown}: {found.message}",
        span,
        "an end of its range",
        (),
        "narrow the range, or change the formula",
        None,
        "warning",
    )
