"""Threads that compile side by side: each gets what it would get alone, and the process is as it was."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import threading
import weakref
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

import pytest

import porelang
from porelang.compiler import try_compile
from porelang.elaborate.runtime import PATIENCE, RECURSION, room_to_compile
from porelang.ir import Node, show
from porelang.once import once
from porelang.program import Program
from porelang.source import Source

THREADS = 8
EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.pore"))
DEEP = "(".join(["sin"] * 150) + "(x" + ")" * 150
#: One for each thread: what is unlike in parsing and elaborating, and mistakes of both, for they are told from state.
TEXTS = [
    "param w = 30mm in 10mm..60mm\ngyroid(w) |> shell(1.5) & cylinder(75, 300)",
    "param kind = gyroid in {gyroid, schwarz_p, diamond}\nkind(9) |> twist(90deg / 50mm) & box([20, 20, 60])",
    "union([for i in range(12): translate(sphere(5 + i), [0, 0, 12 * i])])",
    f"let a = {DEEP}\na & sphere(9)",
    "let a = { let k = tau / 20; sin(k * x) }\ndef f(g, t) = g + t * a\nf(sphere(30), 0.4) @ [x, 2 * y, z]",
    "let a = 5mm + 3deg\nlet b = spere(4)\nlet c = d\nlet d = c\nlet e = (1 +\nshell(sphere(a), -1)",
    "conventions.axolotl.gyroid(10) |> blend(lidinoid(20), along=z, r=10) & sphere(30)",
    "def f(g) = g(g)\nf(f)",
]


def outcome(text: str, name: str = "program.pore") -> tuple[list[Node], list[str]]:
    """A program's roots (nodes are equal if they are the same object) and all diagnostics as they are printed."""
    program, found = try_compile(Source(name, text))
    roots = program.graph.roots if program is not None else []
    return roots, [str(d) for d in found]


def side_by_side(work: Callable[[int], object]) -> list[object]:
    """The results of `work(i)` in eight threads that start at the same moment."""
    start = threading.Barrier(THREADS)

    def one(i: int) -> object:
        start.wait()
        return work(i)

    with ThreadPoolExecutor(THREADS) as pool:
        return list(pool.map(one, range(THREADS)))


@pytest.fixture(autouse=True)
def quick_switches() -> Iterator[None]:
    """Threads take turns a hundred times as often as usual, so that they meet in every line."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(5e-5)
    yield
    sys.setswitchinterval(before)


def test_threads_compile_what_each_compiles_alone() -> None:
    limit, collecting = sys.getrecursionlimit(), gc.isenabled()
    alone = [outcome(text) for text in TEXTS]
    assert [bool(roots) for roots, _ in alone] == [True, True, True, True, True, False, True, False]

    def work(i: int) -> object:
        return [outcome(TEXTS[(i + k) % THREADS]) for k in range(30)]

    found = side_by_side(work)
    assert found == [[alone[(i + k) % THREADS] for k in range(30)] for i in range(THREADS)]
    assert (sys.getrecursionlimit(), gc.isenabled()) == (limit, collecting)


def test_threads_compile_the_examples() -> None:
    examples = EXAMPLES[::3]  # no fewer than threads, so that each begins with another one
    assert len(examples) >= THREADS
    texts = [path.read_text(encoding="utf-8") for path in examples]
    names = [str(path) for path in examples]
    alone = list(map(outcome, texts, names))
    found = side_by_side(lambda i: list(map(outcome, texts[i:] + texts[:i], names[i:] + names[:i])))
    assert found == [alone[i:] + alone[:i] for i in range(THREADS)]


def test_the_first_threads_of_a_process() -> None:
    """Nothing is there yet: the parser, the prelude and the imports are made while eight threads want them."""
    code = f"""
import sys, threading
from concurrent.futures import ThreadPoolExecutor
import porelang
from porelang.elaborate.prelude import prelude_scope
from porelang.ir import Node, show
sys.setswitchinterval(5e-5)
start = threading.Barrier({THREADS})
def work(text):
    start.wait()
    return show(dict(enumerate(porelang.compile(text).graph.roots))), id(prelude_scope())
texts = {[TEXTS[i] for i in (0, 1, 2, 3, 4, 6, 0, 1)]!r}
with ThreadPoolExecutor({THREADS}) as pool:
    found = list(pool.map(work, texts))
assert len({{scope for _, scope in found}}) == 1
print(*(text for text, _ in found), sys.getrecursionlimit(), sep="\\n")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stderr == ""
    programs = [try_compile(Source("<text>", TEXTS[i]))[0] for i in (0, 1, 2, 3, 4, 6, 0, 1)]
    texts = [show(dict(enumerate(p.graph.roots))) for p in programs if isinstance(p, Program)]
    assert done.stdout.splitlines() == [*"\n".join(texts).splitlines(), "1000"]


# ---- what belongs to the process: the recursion limit and the garbage collector


def state() -> tuple[int, bool]:
    return sys.getrecursionlimit(), gc.isenabled()


def test_the_last_one_to_leave_restores_the_process() -> None:
    before = state()
    with ExitStack() as first, ExitStack() as second:
        first.enter_context(room_to_compile())
        second.enter_context(room_to_compile())
        first.close()
        assert state() == (RECURSION, False)
    assert state() == before


def test_a_failure_inside_restores_the_process() -> None:
    before = state()
    with pytest.raises(ZeroDivisionError), room_to_compile(), room_to_compile():
        _ = 1 / 0
    assert state() == before


def test_a_collector_that_is_off_stays_off() -> None:
    gc.disable()
    try:
        with room_to_compile():
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_a_limit_that_somebody_else_sets_meanwhile_is_kept() -> None:
    before = sys.getrecursionlimit()
    try:
        with room_to_compile():
            sys.setrecursionlimit(5000)
        assert sys.getrecursionlimit() == 5000
    finally:
        sys.setrecursionlimit(before)


def test_threads_that_always_overlap_do_not_fill_the_memory() -> None:
    class Thing:
        def __init__(self) -> None:
            self.itself = self

    alive: list[weakref.ref[Thing]] = []
    with room_to_compile():
        for _ in range(PATIENCE + 1):
            with room_to_compile():
                alive.append(weakref.ref(Thing()))
    assert alive[0]() is None


# ---- once


def test_once_makes_one_for_all_threads() -> None:
    made: list[object] = []

    @once
    def slow() -> object:
        made.append(object())
        threading.Event().wait(0.01)
        return made[-1]

    assert set(side_by_side(lambda _: slow())) == {made[0]}
    assert len(made) == 1


def test_once_tries_again_after_a_failure() -> None:
    answers = iter([0, 7])

    @once
    def sometimes() -> int:
        answer = next(answers)
        if answer == 0:
            raise ValueError("not now")
        return answer

    with pytest.raises(ValueError, match="not now"):
        sometimes()
    assert sometimes() == sometimes() == 7


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_forked_process_waits_for_no_thread_of_its_parent() -> None:
    code = """
import os, sys, threading, time, porelang
design = porelang.compile("x + volume(gyroid(2) & sphere(9))").design()
thread = threading.Thread(target=design.field)
thread.start()
time.sleep(0.5)
child = os.fork()
if child == 0:
    from porelang.once import alone, _held
    assert not _held
    with alone("anything"):
        os._exit(0)
assert os.waitpid(child, 0)[1] == 0
thread.join()
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=120,
        env={**os.environ, "PYTHONPATH": str(Path(porelang.__file__).parent.parent)},
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
