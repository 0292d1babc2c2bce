"""What a program becomes: `pore show` (its graph after any pass, or a plan), `pore glsl`, `pore notation`."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Mapping

import numpy as np

from porelang import ir
from porelang.analysis.bounds import lipschitz
from porelang.analysis.notes import NOTES
from porelang.backends.glsl import Form, shader
from porelang.cli import report
from porelang.cli.loading import bound
from porelang.diagnostics import PoreError, fail, suggest, to_lists
from porelang.elaborate.values import Scalar
from porelang.ir import Node
from porelang.notation import steps
from porelang.ops import TASK_TABLE
from porelang.program import Design
from porelang.rewrites import PIPELINE, Graph, run
from porelang.tape import lower
from porelang.tasks.study import estimate, number_of

#: The graph as the program was written, before any pass.
WRITTEN = "lower"
#: What was once a pass and rewrote nothing.
_NOTED = {"stages": "stage", "separate": "axes", "bounds": "bounds"}


def show(options: Namespace) -> int:
    """Print the graph after a pass, with a note beside each node; or with --stages the plan of an output.

    Params that are set have their values in notes, where others have their ranges.
    """
    passes = [WRITTEN, *(step.name for step in PIPELINE)]
    after = options.after or passes[-1]
    if after not in passes:
        near = suggest(after, passes)
        hint = f"did you mean `{near}`?" if near else f"the passes are {', '.join(passes)}"
        hint = f"write --note {_NOTED[after]}" if after in _NOTED else hint
        raise fail("E108", f"there is no pass `{after}`", hint=hint)
    design = bound(options)
    program = design.program
    fixed = {name for name, _ in options.settings} | set(program.presets.get(options.preset, ()))
    ranges = program.ranges | {name: (design.settings[name],) * 2 for name in fixed}
    chosen = program.output(options.out) if options.out else None
    if options.stages:
        lines = plan(design, program.output(options.out))
        report.put({"stages": lines} | to_lists(options.doubts)) if options.json else print("\n".join(lines))
        return 0
    graph = program.written if after == WRITTEN else run(program.written, after)
    roots = _named(graph, chosen)
    note = NOTES[options.note](list(roots.values()), ranges) if options.note else None
    text = ir.show(roots, note)
    if options.note == "bounds":
        text += "".join(f"\n; {line}" for line in _boxes(design, chosen))
    if options.json:
        report.put(
            {"after": after, "nodes": len(ir.order(roots.values())), "lines": text.split("\n")}
            | to_lists(options.doubts)
        )
    else:
        print(text)
    return 0


def glsl(options: Namespace) -> int:
    """`pore glsl`: the text of the shader."""
    program = bound(options).program
    form: Form = "grid" if options.stage == "compute" else options.stage
    made = shader((program.solid(options.out),), program.ranges, form)
    if options.json:
        report.put(
            {"stage": options.stage, "text": made.text, "uniforms": len(made.uniforms)} | to_lists(options.doubts)
        )
    else:
        print(made.text.rstrip())
    return 0


def notation(options: Namespace) -> int:
    """`pore notation`: the steps of the program as the paper writes them."""
    program = bound(options).program
    found = steps(program)
    if options.json:
        report.put(
            [{"line": s.span.line, "step": s.text, "notation": s.notation, "dimension": s.dimension} for s in found]
        )
    for s in found if not options.json else ():
        print(f"{s.notation:<24} {s.dimension:<12} {s.text}")
    if not found:
        report.note(f"{program.source.name}: none of the ten modifications is used")
    return 0


def _named(graph: Graph, chosen: str | None) -> dict[str, Node]:
    """The roots of a graph by what a reader calls them."""
    roots: dict[str, Node] = {}
    for name, several in graph.outputs.items():
        if chosen in (None, name):
            labels = [name] if len(several) == 1 else [f"{name}.{axis}" for axis in "xyz"]
            roots |= dict(zip(labels, several, strict=True))
    if chosen is None:
        roots |= {f"require {i}": n for i, n in enumerate(graph.requirements)}
        roots |= {f"check {i}": n for i, n in enumerate(graph.checks)}
    return roots


def plan(design: Design, name: str) -> list[str]:
    """What is done for an output, in order: tasks, what is computed once, what is computed at every point; and which
    studies the program has besides."""
    program = design.program
    lines = [f"{name}: {program.outputs[name].span.text.splitlines()[0]}"]
    found = [n for n in ir.order(program.roots(name)) if n.op in TASK_TABLE]
    for i, n in enumerate(found, 1):
        place = program.places.get(n)
        told = " ".join(place.text.split()) if place is not None else n.op
        needs = [str(found.index(m) + 1) for m in lower(n.args).nodes if m.op in TASK_TABLE] if n.args else []
        after = f", after {', '.join(needs)}" if needs else ""
        if n.op == "of_study":
            lines.append(f"  task {i}: `{number_of(n)}` of task {needs[0]} (kept with it)")
        else:
            lines.append(f"  task {i}: {told} ({_cost(design, n)}{after})")
    tape = lower(program.roots(name))
    once = sum(1 for i, s in enumerate(tape.stages) if s is ir.Stage.UNIFORM and tape.inputs[i])
    slots = [tape.nodes[i] for i in tape.slots if tape.ops[i] == "param"]
    reads = f", of {', '.join(str(n.value) for n in slots)}" if slots else ""
    lines.append(f"  once for the settings: {report.plural(once, 'operation')}{reads}")
    by_axes: Mapping[int, int] = dict.fromkeys((1, 2, 3), 0)
    counts = dict(by_axes)
    for i in tape.field:
        counts[tape.axes[i].bit_count()] += 1
    words = {1: "along one axis", 2: "over two axes", 3: "at every point"}
    lines += [f"  on a grid, {words[k]}: {report.plural(n, 'operation')}" for k, n in counts.items() if n]
    others = [(name, n) for name, n in program.studies.items() if n not in found]
    return lines + [f"  not read by it: study {name} ({_cost(design, n)})" for name, n in others]


def _cost(design: Design, n: Node) -> str:
    """What a task takes; of a study how many elements and unknowns, where nothing has to be found for it first."""
    if n.op != "study" or any(TASK_TABLE[m.op].cost != "instant" for m in ir.order(n.args) if m.op in TASK_TABLE):
        return TASK_TABLE[n.op].cost
    cost = estimate(design.formula(*n.args))
    elements, unknowns, seconds = (
        f"{float(f'{v:.2g}'):,.0f}" for v in (cost.elements, cost.unknowns, max(1.0, cost.seconds))
    )
    rims = f"; up to {cost.rims:g} times as many with smaller ones at rims" if cost.rims else ""
    return f"some {elements} elements of {cost.size:.3g} mm, {unknowns} unknowns, {seconds} s{rims}"


def _boxes(design: Design, chosen: str | None) -> list[str]:
    """The box of each solid output of a design, and a bound on how steep its field is inside."""
    lines: list[str] = []
    for name, output in design.program.outputs.items():
        if chosen not in (None, name) or not isinstance(output.value, Scalar):
            continue
        try:
            box = design.bounds(name)
        except PoreError as error:
            lines.append(f"{name}: {error.diagnostics[0].message}")
            continue
        corners = (", ".join(f"{v:g}" for v in corner) for corner in box)
        steep = float(lipschitz(design.of(name), np.array([box.lo]), np.array([box.hi]))[0])
        lines.append(f"{name}: within ({next(corners)}) .. ({next(corners)}) mm, |grad| <= {steep:.4g} there")
    return lines
