"""The commands: each takes the parsed options and gives an exit status."""

from __future__ import annotations

import os
import platform
import sys
import traceback
from argparse import Namespace
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout, suppress
from typing import TYPE_CHECKING

from porelang.cli import report
from porelang.cli.parsing import parse
from porelang.diagnostics import Diagnostic, PoreError, fail, suggest
from porelang.progress import watched

if TYPE_CHECKING:
    from porelang.data import Reduced
    from porelang.program import Program

Command = Callable[[Namespace], int]


def run(argv: Sequence[str]) -> int:
    """Run a command line; whatever goes wrong is said as a diagnostic."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    command = ""
    try:
        options = parse(argv)
        command = options.command or "help"
        with watched(report.busy("finding numbers from fields", getattr(options, "quiet", False))):
            return RUN[command](options)
    except PoreError as error:
        found = list(error.diagnostics)
    except SystemExit as asked:  # argparse has printed help or the version
        return int(asked.code or 0)
    except MemoryError:
        found = [
            Diagnostic(
                "E124",
                "this machine has not enough memory for that",
                hint="use a larger --voxel, smaller --bounds or fewer points",
            )
        ]
    except (KeyboardInterrupt, BrokenPipeError):
        raise
    except Exception as error:
        if os.environ.get("PORELANG_DEBUG"):
            traceback.print_exc()
        found = [bug(error)]
    return rejected(found, command, "--json" in argv)


def rejected(found: list[Diagnostic], command: str, as_json: bool) -> int:
    """Say why a command could not be carried out; with --json on standard output too."""
    report.say(found)
    if as_json:
        listed = [d.to_json() for d in found]
        report.put(listed if command == "check" else {"errors": listed})
    return report.status(found)


def bug(error: Exception) -> Diagnostic:
    """What is said of an error that is ours, not the user's."""
    from porelang import __version__

    last = traceback.extract_tb(error.__traceback__)[-1]
    where = f"{os.path.basename(last.filename)}:{last.lineno}"
    return Diagnostic(
        "E199",
        f"this is a bug in porelang, not in your program: {type(error).__name__} at {where}",
        hint=f"please report it with the program and the command (porelang {__version__}, "
        f"Python {platform.python_version()}, {sys.platform}); PORELANG_DEBUG=1 shows more",
    )


def load(options: Namespace) -> Program:
    """The program of a command, its warnings said. Errors: all that is wrong with it."""
    from porelang.files import read_source
    from porelang.program import try_compile

    program, found = try_compile(read_source(options.file))
    if program is None:
        raise PoreError(found)
    if not getattr(options, "quiet", False):
        report.say(found)
    return program


def broken_checks(program: Program, settings: dict[str, str], measure: bool = False) -> list[Diagnostic]:
    """An error for each `check` of the program that does not hold with these settings, with the numbers it found.

    Checks about whole fields (a porosity) are looked at only if `measure` says so: they take a second or more.
    """
    from porelang.ir import order
    from porelang.settings import settle

    values = settle(program.params, settings)
    failed = {c.span for c in program.failed_checks(measure, **settings)}
    found = []
    for i, check in enumerate(program.elaborated.checks):
        if check.span not in failed:
            continue
        params = {str(n.value) for n in order([check.condition]) if n.op == "param"} & program.params.keys()
        read = {str(n.value) for n in order([program.graph.roots[f"check {i}"]]) if n.op == "param"}
        measured = read - params
        numbers = program.numbers(**settings) if measured else {}
        label = ", ".join(_told(*numbers[name]) for name in sorted(measured)) or "does not hold"
        with_these = ", ".join(f"{name} = {program.params[name].shown(values[name])}" for name in sorted(params))
        label += f" with {with_these}" if params else ""
        found.append(Diagnostic("E068", check.message, check.span, label, check.others))
    return found


def undecided_checks(program: Program, settings: dict[str, str]) -> list[Diagnostic]:
    """A warning for each `check` that holds, but would not for other numbers within the errors of those it found."""
    from porelang.analysis.enclose import enclose, fixed
    from porelang.interval import interval
    from porelang.ir import order
    from porelang.settings import settle

    numbers = program.numbers(**settings)
    ranges = fixed(settle(program.params, settings))
    for name, (_, n) in numbers.items():
        ranges[name] = interval(n.value - n.error, n.value + n.error)
    failed = {c.span for c in program.failed_checks(True, **settings)}
    found = []
    for i, check in enumerate(program.elaborated.checks):
        root = program.graph.roots[f"check {i}"]
        read = {str(n.value) for n in order([root]) if n.op == "param"} & numbers.keys()
        if read and check.span not in failed and bool((enclose([root], (), ranges)[0].range.lo < 1).any()):
            told = (numbers[name] for name in sorted(read))
            label = ", ".join(f"{text} is {n.value:.6g} +- {n.error:.1g}" for text, n in told)
            hint = "leave a margin larger than the error"
            said = f"this check holds, but within the error of its numbers it might not: {check.message}"
            found.append(Diagnostic("W203", said, check.span, label, check.others, hint, severity="warning"))
    return found


def _told(text: str, found: Reduced) -> str:
    """A number found from fields, with its error where that shows in four figures."""
    error = f" +- {found.error:.1g}" if found.error > 5e-5 * abs(found.value) else ""
    return f"{text} is {found.value:.4g}{error}"


def check(options: Namespace) -> int:
    """`pore check`: all diagnostics, the `check` statements included."""
    from porelang.files import read_source
    from porelang.program import MOST_DIAGNOSTICS, try_compile
    from porelang.syntax.parse import MOST

    source = read_source(options.file)
    program, found = try_compile(source)
    report.say([d for d in found if d.severity == "error" or not options.quiet])
    if program is not None:  # what was found so far is said first: a check may have to measure the whole part
        try:
            broken = broken_checks(program, dict(options.settings), options.measure)
            if options.measure:
                settings = dict(options.settings)
                broken += [*undecided_checks(program, settings), *program.doubtful_contracts(**settings)]
        except PoreError as error:
            broken = list(error.diagnostics)
        report.say([d for d in broken if d.severity == "error" or not options.quiet])
        found = [*found, *broken]
    if options.json:
        report.put([d.to_json() for d in found])
    if program is not None and not options.measure:
        waiting = program.unmeasured_checks()
        if waiting and not options.quiet:
            them = "it" if waiting == 1 else "them"
            report.note(f"{report.plural(waiting, 'check')} about whole fields left out: --measure looks at {them}")
    if not options.quiet:
        errors = sum(d.severity == "error" for d in found)
        warnings = report.plural(len(found) - errors, "warning")
        first = "the first " if len(found) in (MOST, MOST_DIAGNOSTICS) else ""
        report.note(f"{options.file}: {first}{report.plural(errors, 'error')}, {warnings}")
    return report.status(found)


def show(options: Namespace) -> int:
    """`pore show`: the graph after a pass, with what the pass notes of each node."""
    from porelang import ir
    from porelang.rewrites import PIPELINE, run

    names = [step.name for step in PIPELINE]
    after = options.after or names[-1]
    if after not in names:
        near = suggest(after, names)
        raise fail(
            "E108",
            f"there is no pass `{after}`",
            hint=f"did you mean `{near}`?" if near else f"the passes are {', '.join(names)}",
        )
    program = load(options)
    chosen = program.output(options.out) if options.out else None
    graph = run(program.lowered, after)
    note = PIPELINE[names.index(after)].note
    roots = {name: root for name, root in graph.roots.items() if chosen in (None, name.partition(".")[0])}
    text = ir.show(roots, note and note(graph))
    if after == "bounds":
        text += "".join(f"\n; {line}" for line in _boxes(program, chosen))
    if options.json:
        report.put({"after": after, "nodes": len(ir.order(roots.values())), "lines": text.split("\n")})
    else:
        print(text)
    return 0


def _boxes(program: Program, chosen: str | None) -> list[str]:
    """The box of each solid output with the params at their defaults, and a bound on how steep its field is inside."""
    import numpy as np

    from porelang.analysis.bounds import lipschitz
    from porelang.elaborate.values import Scalar

    lines: list[str] = []
    for name, output in program.outputs.items():
        if chosen not in (None, name) or not isinstance(output.value, Scalar):
            continue
        try:
            box = program.bounds(name)
        except PoreError as error:
            lines.append(f"{name}: {error.diagnostics[0].message}")
            continue
        corners = (", ".join(f"{v:g}" for v in corner) for corner in box)
        steep = float(lipschitz(program.solid(name), np.array([box.lo]), np.array([box.hi]), program.settle())[0])
        lines.append(f"{name}: within ({next(corners)}) .. ({next(corners)}) mm, |grad| <= {steep:.4g} there")
    return lines


def glsl(options: Namespace) -> int:
    """`pore glsl`: the text of the shader."""
    from porelang.backends.glsl import Form, shader

    program = load(options)
    form: Form = "grid" if options.stage == "compute" else options.stage
    made = shader(program.solid(options.out), program.graph.ranges, form)
    if options.json:
        report.put({"stage": options.stage, "text": made.text, "uniforms": len(made.uniforms)})
    else:
        print(made.text.rstrip())
    return 0


def notation(options: Namespace) -> int:
    """`pore notation`: the steps of the program as the paper writes them."""
    from porelang.notation import steps

    found = steps(load(options))
    if options.json:
        report.put(
            [{"line": s.span.line, "step": s.text, "notation": s.notation, "dimension": s.dimension} for s in found]
        )
    for s in found if not options.json else ():
        print(f"{s.notation:<24} {s.dimension:<12} {s.text}")
    if not found:
        report.note(f"{options.file}: none of the ten modifications is used")
    return 0


def evaluate(options: Namespace) -> int:
    """`pore eval`: values at points."""
    from porelang.cli.evaluate import evaluate

    return evaluate(load(options), options)


def mesh(options: Namespace) -> int:
    """`pore mesh`: the surface, to a file."""
    from porelang.cli.meshing import mesh

    return mesh(options)


def render(options: Namespace) -> int:
    """`pore render`: a picture."""
    from porelang.cli.render import render

    return render(options)


def measure(options: Namespace) -> int:
    """`pore measure`: volume, porosity, components and more, with their errors."""
    from porelang.cli.measuring import measure

    return measure(options)


def slices(options: Namespace) -> int:
    """`pore slices`: layers for printing, to a folder."""
    from porelang.cli.slicing import slices

    return slices(options)


def explain(options: Namespace) -> int:
    """`pore explain`: the page of a code, or the list of all."""
    from porelang.cli.explain import explain

    return explain(options.code, options.json)


def cache(options: Namespace) -> int:
    """`pore cache`: what tasks have left on disk."""
    from porelang.cli.caching import cache

    return cache(options)


def doctor(options: Namespace) -> int:
    """`pore doctor`: what of this machine is used."""
    from porelang.conformance.report import doctor

    return doctor(options.json)


def conformance(options: Namespace) -> int:
    """`pore conformance`: the backends compared on this machine."""
    from porelang.conformance.report import certificate

    return certificate(options.json, options.count, options.seed, options.quick)


def usage(options: Namespace) -> int:
    """`pore` alone says what it can do, and that this was no command."""
    with suppress(SystemExit), redirect_stdout(sys.stderr):
        parse(["--help"])
    return 2


RUN: dict[str, Command] = {
    "check": check,
    "mesh": mesh,
    "measure": measure,
    "slices": slices,
    "eval": evaluate,
    "show": show,
    "glsl": glsl,
    "notation": notation,
    "render": render,
    "explain": explain,
    "cache": cache,
    "doctor": doctor,
    "conformance": conformance,
    "help": usage,
}
