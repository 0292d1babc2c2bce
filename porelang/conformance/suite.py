"""The whole suite: the table swept, the programs run, random graphs judged, and a certificate of it all."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.checks import failed_checks
from porelang.compiler import try_compile
from porelang.conformance import samples
from porelang.conformance.backend import Backend
from porelang.conformance.generate import RANGES, Dice, draw_graph
from porelang.conformance.law import Failure, Finding, places, put
from porelang.conformance.programs import Case, Variant, cases
from porelang.conformance.sweep import Measurement, sweep
from porelang.diagnostics import PoreError
from porelang.elaborate.values import Vector
from porelang.files import read_source
from porelang.formula import Formula
from porelang.ir import Node, Value, node, order
from porelang.ops import TABLE
from porelang.program import Program
from porelang.rewrites import flatten
from porelang.settings import Setting

PLACES = 200


@dataclass(frozen=True, slots=True)
class Certificate:
    """What a run of the suite found.

    `measurements` are of single operations, against their exact values. `programs` and `graphs` were judged by the law
    at `points` values, `sharp` of them under a bound of at most 1 % of the value (or of 1); `use` is the worst part of
    such a bound. `appearances` counts the random graphs that each operation stood in.
    """

    backends: tuple[str, ...]
    device: str
    seed: int
    measurements: tuple[Measurement, ...]
    programs: int
    expectations: int
    graphs: int
    points: int
    sharp: int
    use: float
    appearances: dict[str, int]
    failures: tuple[Failure, ...]

    @property
    def holds(self) -> bool:
        """Whether the law was kept everywhere."""
        return not self.failures


def run_suite(
    backends: Sequence[Backend],
    graphs: int = 500,
    seed: int = 0,
    device: str = "",
    operations: Iterable[str] | None = None,
    programs: Sequence[Case] | None = None,
) -> Certificate:
    """Sweep the operations (all, if none are named), run the programs (all, if none are given), judge random graphs."""
    chosen_operations = list(TABLE if operations is None else operations)
    measurements = [m for b in backends for m in sweep(b, [n for n in chosen_operations if not has_samples(n)], seed)]
    chosen = cases() if programs is None else programs
    findings = [f for case in chosen for b in backends for f in check_case(case, b, PLACES, seed)]
    findings += [f for n in chosen_operations if has_samples(n) for b in backends for f in check_samples(n, b, seed)]
    appearances: Counter[str] = Counter(dict.fromkeys(TABLE, 0))
    for i, root in enumerate(random_graphs(graphs, seed)):
        appearances.update({n.op for n in order([root]) if n.op in TABLE})
        for b in backends:
            findings.append(check_graph(f"graph {i} of seed {seed}", root, b, PLACES, seed + i))
    failures = [Failure(f"table, {m.form} form", m.backend, m.op, m.example) for m in measurements if m.broken]
    failures += [f.failure for f in findings if f.failure]
    return Certificate(
        tuple(b.name for b in backends), device, seed, tuple(measurements), len(chosen),
        sum(len(v.expectations) for c in chosen for v in c.variants), graphs, sum(f.points for f in findings),
        sum(f.sharp for f in findings), max((f.use for f in findings), default=0.0), dict(appearances), tuple(failures),
    )  # fmt: skip


def random_graphs(count: int, seed: int, size: int = 24) -> Iterator[Node]:
    """Random graphs, the same for the same seed."""
    dice = Dice.seeded(seed)
    for _ in range(count):
        yield draw_graph(dice, size)


def check_graph(where: str, root: Node, backend: Backend, points: int, seed: int) -> Finding:
    """A random graph (over the params of `generate.RANGES`) through all passes and before the law."""
    rng = np.random.default_rng(seed)
    params = {name: float(rng.uniform(lo, hi)) for name, (lo, hi) in RANGES.items()}
    formula = Formula.of(*flatten(root), **params).bind(samples.bindings())
    return put(where, formula, places(points, seed, 30.0), backend, RANGES)


def has_samples(operation: str) -> bool:
    """Whether an operation reads data, or more numbers than a point has: it is judged on samples, not swept."""
    return TABLE[operation].args[0] in ("grid", "segments") or len(TABLE[operation].args) > 3


def check_samples(operation: str, backend: Backend, seed: int, points: int = 4000) -> list[Finding]:
    """An operation with everything that can be asked of it, on samples: at nodes of data, between, outside."""
    row = TABLE[operation]
    asked: list[Value] = list(row.results) or [None]
    if row.payload:
        most = 1 if operation == "lookup" else 3
        orders = [(0, 0, 0), *(o for k in range(1, most + 1) for o in ((k, 0, 0), (0, k, 0), (0, 0, k))), (1, 1, 0)]
        asked = [(c, *o) for c in range(samples.grid().components) for o in orders]
    at = np.concatenate([places(points, seed), hard_places()])
    formulas = [Formula((node(operation, *samples.arguments(row), value=v),), samples.bindings()) for v in asked]
    return [put(f"{operation} {f.root.value}", f, at, backend) for f in formulas]


def hard_places() -> NDArray[np.float64]:
    """Places on nodes and faces of the grid, at ends and axes of bars, and far away."""
    grid, bars = samples.grid(), samples.bars()
    index = np.stack(np.meshgrid(*(np.arange(n) for n in grid.shape), indexing="ij"), -1).reshape(-1, 3)
    nodes = np.array(grid.origin) + index * np.array(grid.spacing)
    halves = nodes + np.array(grid.spacing) * (index % 2) / 2
    ends = np.concatenate([bars.starts, bars.ends, (bars.starts + bars.ends) / 2])
    far = np.array([[1e4, 0.0, 0.0], [0.0, -3e4, 5.0], [1e5, 1e5, 1e5]])
    return np.concatenate([nodes, halves, ends, far]).astype(np.float32).astype(np.float64)


def check_case(case: Case, backend: Backend, points: int, seed: int) -> list[Finding]:
    """A conformance program on one backend: its expectations, then the law at random points for every output."""
    program, diagnostics = try_compile(read_source(case.path))
    if program is None:
        text = "; ".join(f"{d.code} {d.message}" for d in diagnostics if d.severity == "error")
        return [_wrong(case.path.name, backend, f"it does not compile: {text}")]
    found = []
    codes = {d.code for d in diagnostics}
    if codes != set(case.warnings):
        text = f"it warns of {sorted(codes)}, where {sorted(case.warnings)} was expected"
        found.append(_wrong(case.path.name, backend, text))
    for variant in case.variants:
        try:
            found += _check_variant(case, program, variant, backend, points, seed)
        except PoreError as error:
            found.append(_wrong(case.path.name, backend, "; ".join(d.message for d in error.diagnostics)))
    return found


def _check_variant(
    case: Case, program: Program, variant: Variant, backend: Backend, points: int, seed: int
) -> Iterator[Finding]:
    settings: dict[str, Setting] = dict(variant.settings)
    design = program.design(settings)
    program = design.program  # a variant, where the settings count
    failed = {program.elaborated.checks[i].message for i in failed_checks(design, measure=False)}
    if failed != set(variant.fails):
        yield _wrong(case.path.name, backend, f"the checks {sorted(failed)} fail, not {sorted(variant.fails)}")
    ranges = program.ranges
    roots = {name: program.roots(name) for name in program.outputs}
    for e in variant.expectations:
        where = f"{case.path.name}:{e.line}"
        if e.output not in roots or (e.axis is not None) != isinstance(program.outputs[e.output].value, Vector):
            yield _wrong(where, backend, f"the program has no output `{e.output}` of this kind")
            continue
        at = np.array([e.point])
        got = float(backend.evaluate(design.formula(roots[e.output][e.axis or 0]), at, ranges)[0])
        if e.holds(got, backend.precision.name):
            yield Finding(1, 1, 0.0, None)
        else:
            yield _wrong(where, backend, f"`{e.output}` at {e.point} is {got!r}, expected was {e.value!r}")
    at = np.concatenate([np.array(case.places).reshape(-1, 3), places(points, seed)])
    for name, parts in roots.items():
        for root in parts:
            yield put(f"{case.path.name} `{name}`", design.formula(root), at, backend, ranges)


def _wrong(where: str, backend: Backend, text: str) -> Finding:
    return Finding(1, 1, np.inf, Failure(where, backend.name, "", text))
