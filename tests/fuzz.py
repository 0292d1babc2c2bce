"""`make fuzz`: random programs on every backend; what fails becomes a file of `tests/regressions/`.

    python tests/fuzz.py --seed 20260101 --count 10000

The seed is the day's if none is given, so that every night tries other programs, and is printed. Three kinds are tried:
graphs (before the law, on all backends), graphs written as programs (which must be the same graphs, and warn of
nothing), and texts, which need an answer. Exit status 1 where something failed.
"""

from __future__ import annotations

import argparse
import contextlib
import datetime
import sys
import warnings
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from regression_files import FOLDER, Place, answered, replay, written

import porelang
from porelang.conformance import samples
from porelang.conformance.backend import NUMPY, Backend, glsl
from porelang.conformance.generate import RANGES, Dice, draw_graph, program_text
from porelang.conformance.law import places, put
from porelang.conformance.programs import cases
from porelang.conformance.suite import random_graphs
from porelang.formula import Formula
from porelang.gpu import GpuMissing, shared_gpu
from porelang.ir import Node, order, show, within
from porelang.rewrites import flatten

POINTS = 100
WORDS = """
use param let def out check if then else for in where and or not true false as step p x y z w gyroid sphere box 0 30
2.5mm 45% 3x .5 "text" 1e999 -1 == != <= < => |> | & \\ + - * / % ^ ~ @ .. . : , ; ( ) [ ] { } = && ** ! ? $ # ## "
"""
SOUP = WORDS.split()


def fuzz_graphs(backends: Sequence[Backend], count: int, seed: int, folder: Path) -> list[Path]:
    """Random graphs before the law, every fourth a long one. Gives the files of those that break it."""
    found = []
    long = random_graphs(count, seed + 1, size=60)
    for i, root in enumerate(random_graphs(count, seed)):
        graph = next(long) if i % 4 == 3 else root
        rng = np.random.default_rng([seed, i])
        params = {name: float(rng.uniform(lo, hi)) for name, (lo, hi) in RANGES.items()}
        for backend in backends:
            try:
                smallest = _smallest(graph, backend, params, seed + i)
            except Exception as error:  # of whatever kind: it is what is looked for
                smallest = graph, [], f"{type(error).__name__}: {error}"
            if smallest is None:
                continue
            root, at, example = smallest
            name = f"graph_{seed}_{i}_{backend.name.replace(' ', '_')}"
            story = [f"Found by `make fuzz`, seed {seed}, graph {i}, on {backend.name}:", example]
            read = {str(n.value) for n in order([root]) if n.op == "param"}
            settings = {key: value for key, value in params.items() if key in read}
            found.append(written(folder, name, story, program_text(root), settings, at))
            if not replay(found[-1], backend):
                print(f"{found[-1].name} does not fail by itself: only the seed does")
    return found


def _smallest(
    graph: Node, backend: Backend, params: dict[str, float], seed: int
) -> tuple[Node, list[Place], str] | None:
    """The smallest part of a graph that breaks the law on its own, a place where it does, and what is said of it."""
    points = places(POINTS, seed, 30.0)

    def judged(root: Node, at: np.ndarray) -> str:  # type: ignore[type-arg]
        formula = Formula.of(*flatten(root), **params).bind(samples.bindings())
        failure = put("", formula, at, backend, RANGES).failure
        return failure.example if failure else ""

    if not judged(graph, points):
        return None
    root = next(n for n in order([graph], within) if n is graph or (n.args and n.axes and judged(n, points)))
    at = next((p for p in points if judged(root, p[None])), points[0])
    return root, [(float(at[0]), float(at[1]), float(at[2]))], judged(root, points)


def fuzz_programs(count: int, seed: int, folder: Path) -> list[Path]:
    """Random graphs written as programs: they are the same graphs, and their values come without a warning."""
    dice, found = Dice.seeded(seed + 2), []
    for i in range(count):
        root = draw_graph(dice, 16)
        text = program_text(root)
        try:
            with TemporaryDirectory() as beside, contextlib.chdir(beside):
                samples.write(Path(beside))
                wrong = _as_program(root, text, seed + i)
        except Exception as error:
            wrong = f"{type(error).__name__}: {error}"
        if wrong:
            story = [f"Found by `make fuzz`, seed {seed}, program {i}:", wrong]
            found.append(written(folder, f"program_{seed}_{i}", story, text))
    return found


def _as_program(root: Node, text: str, seed: int) -> str:
    program = porelang.compile(text)
    otherwise = {"direction", "reduced", "covers"}  # no functions of the language
    if not any(n.op in otherwise for n in order([root])) and shown(program.roots("part")) != shown(flatten(root)):
        return "the program is another graph than the one it was written from"
    points = places(POINTS, seed)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for end in range(2):
            settings = {name: RANGES[name][end] for name in program.params}
            program.field("part", settings=settings)(points)
            program.field("part", dtype="f32", settings=settings)(points)
    return ""


def shown(roots: tuple[Node, ...]) -> str:
    """A graph as text, in which a file is called what the program calls it, wherever it lies."""
    return show({str(i): n for i, n in enumerate(roots)})


def fuzz_texts(count: int, seed: int, folder: Path) -> list[Path]:
    """Programs with pieces of them changed, and soups of words: each has an answer."""
    rng, found = np.random.default_rng(seed), []
    programs = [case.path.read_text(encoding="utf-8") for case in cases()]
    for i in range(count):
        if rng.random() < 0.2:
            text = " ".join(rng.choice(SOUP, rng.integers(1, 40)))
        else:
            text = programs[rng.integers(len(programs))]
            for _ in range(rng.integers(1, 4)):
                at, width = int(rng.integers(len(text) + 1)), int(rng.integers(8))
                text = text[:at] + str(rng.choice(SOUP)) + text[at + width :]
        try:
            wrong = answered(text)
        except Exception as error:
            wrong = [f"{type(error).__name__}: {error}"]
        if wrong:
            story = [f"Found by `make fuzz`, seed {seed}, text {i}:", *wrong]
            found.append(written(folder, f"text_{seed}_{i}", story, text, rejected=True))
    return found


def main() -> int:
    """Try programs and say what was found."""
    parser = argparse.ArgumentParser(description="Random programs on every backend.")
    parser.add_argument("--seed", type=int, default=int(datetime.date.today().strftime("%Y%m%d")))
    parser.add_argument("--count", type=int, default=10_000)
    options = parser.parse_args()
    backends = [*NUMPY]
    try:
        backends.append(glsl(shared_gpu()))
    except GpuMissing as missing:
        print(f"without GLSL: {missing.reason}")
    print(f"seed {options.seed}: {options.count} graphs, programs and texts on {', '.join(b.name for b in backends)}")
    found = fuzz_graphs(backends, options.count, options.seed, FOLDER)
    found += fuzz_programs(options.count // 4, options.seed, FOLDER)
    found += fuzz_texts(options.count // 4, options.seed, FOLDER)
    for path in found:
        print(f"FAILED  {path}")
    print(f"{len(found)} failed" if found else "nothing failed")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
