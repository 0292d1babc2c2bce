"""`pore` as a process: signals, full disks and standard streams. Nothing is left behind or half-written."""

from __future__ import annotations

import os
import random
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import porelang
from porelang.slices import write_slices

ROOT = Path(__file__).resolve().parent.parent
BALL = "sphere(4)\n"
pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals")


def names(where: Path) -> list[str]:
    return sorted(os.listdir(where))


def files(where: Path) -> dict[str, bytes]:
    return {p.relative_to(where).as_posix(): p.read_bytes() for p in sorted(where.rglob("*")) if p.is_file()}


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": ""}


#: `pore` that says when `main` has begun: before it Python starts, which answers Ctrl-C in its own way. A busy machine
#: may take long between two lines, so that it is said from within.
SAYS_FIRST = """
import sys
from porelang import cli

def begun(argv, carry_out=cli._main):
    print("begun", flush=True)
    return carry_out(argv)

cli._main = begun
sys.exit(cli.main())
"""


def start(*words: str, said_first: bool = False, **more: object) -> subprocess.Popen[str]:
    pore = ["-c", SAYS_FIRST] if said_first else ["-m", "porelang"]
    return subprocess.Popen([sys.executable, *pore, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            text=True, env=environment(), **more)  # type: ignore[call-overload, no-any-return]  # fmt: skip


@pytest.fixture(scope="module")
def work(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("work")
    (folder / "a.pore").write_text("gyroid(5) |> shell(0.8) & sphere(10)\n")
    (folder / "ball.pore").write_text(BALL)
    np.save(folder / "p.npy", np.random.default_rng(1).uniform(-10, 10, (300_000, 3)))
    write_slices(porelang.compile(BALL).design(), folder / "layers", 2)
    return folder


COMMANDS = {
    "stl": ["mesh", "a.pore", "-o", "a.stl", "--voxel", "0.5mm", "-q"],
    "slices": ["slices", "a.pore", "-o", "layers", "--step", "0.5mm", "--voxel", "0.15mm", "-q"],
    "new": ["slices", "a.pore", "-o", "new", "--step", "0.5mm", "--voxel", "0.15mm", "-q"],
    "tet": ["tet", "a.pore", "-o", "a.msh", "--bounds", "0,0,0,2,2,2", "--size", "0.4mm", "-q"],
    "eval": ["eval", "a.pore", "--points", "p.npy", "-o", "v.npy", "-q"],
    "render": ["render", "a.pore", "-o", "a.png", "--solid", "none", "--slice", "x=0", "--samples", "2", "-q"],
}


@pytest.mark.parametrize("what", COMMANDS)
def test_a_signal_at_any_moment_leaves_nothing_behind(what: str, work: Path) -> None:
    """The result is there whole, or what was there before; no draft and no traceback in either case."""
    before = names(work)
    old = files(work / "layers")
    begun = time.monotonic()
    running = start(*COMMANDS[what], cwd=work)
    assert running.communicate(timeout=120) == ("", "")
    whole = time.monotonic() - begun
    (made,) = set(names(work)) - set(before) or {"layers"}
    result = files(work / made) if (work / made).is_dir() else (work / made).read_bytes()
    chance = random.Random(what)
    for k in range(3):
        number = (signal.SIGHUP, signal.SIGTERM, signal.SIGINT, signal.SIGQUIT)[(k + len(what)) % 4]
        if what != "slices":
            for path in [*(work / made).iterdir(), work / made] if (work / made).is_dir() else [work / made]:
                path.rmdir() if path.is_dir() else path.unlink(missing_ok=True)
        running = start(*COMMANDS[what], cwd=work, said_first=True)
        assert running.stdout is not None
        assert running.stdout.readline() == "begun\n"
        time.sleep(chance.random() * whole)
        running.send_signal(number)
        if k % 2:
            running.send_signal(signal.SIGTERM)  # one more, while it cleans up
        _, said = running.communicate(timeout=120)
        ended = {0, 128 + number, 128 + signal.SIGTERM, -number, -signal.SIGTERM}  # the latter before and after `main`
        assert running.returncode in ended, said
        assert "Traceback" not in said
        assert "bug" not in said
        assert set(names(work)) - {made} == set(before) - {made}
        if what == "slices":
            assert files(work / "layers") in (old, result)
        elif (work / made).exists():
            assert (files(work / made) if (work / made).is_dir() else (work / made).read_bytes()) == result


def test_ctrl_c_in_the_first_moments_has_no_traceback(work: Path) -> None:
    chance = random.Random(5)
    for _ in range(12):
        running = start("check", "a.pore", "-q", cwd=work, said_first=True)
        assert running.stdout is not None
        assert running.stdout.readline() == "begun\n"
        time.sleep(chance.random() * 0.15)
        running.send_signal(signal.SIGINT)
        _, said = running.communicate(timeout=60)
        assert said == ""
        assert running.returncode in (0, 130, -2)  # the number tells which signal, should it be another


#: A command during which SIGHUP falls into the callback of a weak reference; what it does then is to follow.
INTERRUPTED = """
import os, signal, sys, time, weakref
from porelang.cli import commands, main
class Thing: pass
def run(argv):
    thing = Thing()
    seen = weakref.ref(thing, lambda _: [signal.raise_signal(signal.SIGHUP), sum(range(1000))])
    del thing
"""


def test_what_a_signal_leaves_half_made_does_not_complain() -> None:
    """An object whose making was interrupted lacks what its end asks for; without a signal that is told."""
    code = (
        "import sys; from porelang.cli.interrupts import Ended, ender; sys.unraisablehook = ender.lost\n"
        "class Half:\n"
        "    def __del__(self):\n"
        "        self.never_made\n"
    )
    signalled = "try:\n    ender(2, None)\nexcept Ended:\n    pass\n"
    for before, tells in (("", True), (signalled, False)):
        done = subprocess.run(
            [sys.executable, "-c", code + before + "x = Half(); del x"], capture_output=True, text=True, check=True
        )
        assert ("never_made" in done.stderr) == tells


def test_a_signal_that_falls_into_a_callback_is_not_lost() -> None:
    """Python lets no exception out of the callback of a weak reference, such as its imports have; also under nohup."""
    code = f"""{INTERRUPTED}    time.sleep(20)
    return 0
commands.run = run
sys.exit(main())
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment(), check=False,
                          preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL))  # fmt: skip
    assert (done.returncode, done.stderr) == (129, "ended: nothing is left half-written\n")


def test_a_signal_that_falls_into_the_last_callback_ends_nothing_else() -> None:
    """It would be raised again by an alarm, which kills a process whose Python has already gone."""
    code = f"""{INTERRUPTED}    return 0
commands.run = run
status = main()
signal.signal(signal.SIGALRM, signal.SIG_DFL)  # as Python does when it ends
time.sleep(0.1)
sys.exit(status)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment(), check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_signal_that_is_ignored_stays_ignored(work: Path) -> None:
    """`nohup pore mesh ... &` goes on when the terminal is closed."""
    running = start(*COMMANDS["eval"], cwd=work, preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    for _ in range(20):
        time.sleep(0.02)
        running.send_signal(signal.SIGHUP)
    running.communicate(timeout=60)
    assert running.returncode == 0
    (work / "v.npy").unlink()


@pytest.mark.parametrize("command", ["stl", "new", "eval"])
def test_a_full_disk_is_told_and_leaves_nothing(command: str, work: Path) -> None:
    """A limit on the size of files stands in for it: the same place fails in the same way."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (300, 300))

    before = names(work)
    running = start(*COMMANDS[command], cwd=work, preexec_fn=limit)
    _, said = running.communicate(timeout=60)
    assert running.returncode == 2
    assert "error[E113]: cannot write" in said
    assert names(work) == before


FULL = pytest.mark.skipif(not os.path.exists("/dev/full"), reason="Linux has a device that is always full")


@FULL
@pytest.mark.parametrize(
    ("words", "unbuffered"),
    [
        (["check", "ball.pore", "--json"], ""),
        (["show", "ball.pore"], ""),
        (["glsl", "ball.pore"], ""),
        (["eval", "ball.pore", "--points", "p.npy"], "1"),
        (["mesh", "ball.pore", "-o", "full.stl", "--resolution", "9", "--force"], "1"),
        (["explain", "--json"], ""),
        (["explain", "--json"], "1"),
        (["--help"], ""),
        (["--help"], "1"),
    ],
)
def test_standard_output_that_takes_nothing_is_told(words: list[str], unbuffered: str, work: Path) -> None:
    for redirected in (">/dev/full", ">&-"):
        done = subprocess.run(["sh", "-c", f'exec "$@" {redirected}', "sh", sys.executable, "-m", "porelang", *words],
                              cwd=work, capture_output=True, text=True, check=False,
                              env={**environment(), "PYTHONUNBUFFERED": unbuffered})  # fmt: skip
        assert done.returncode == 2, done.stderr
        assert done.stderr.count("error[") == 1
        assert "error[E113]: cannot write to standard output" in done.stderr
        assert "Traceback" not in done.stderr


@FULL
def test_streams_that_nobody_needs_may_be_closed(work: Path) -> None:
    """A file that is written then does not take the number of standard output or error."""
    mesh = ["mesh", "ball.pore", "-o", "c.stl", "--resolution", "9", "-q", "--force"]
    values = ["eval", "ball.pore", "--points", "p.npy", "-o", "c.npy", "-q"]
    for redirected, words in ((">&-", values), ("2>&-", values), ("<&- >&- 2>&-", mesh), ("2>/dev/full", values),
                              (">/dev/full", values)):  # fmt: skip
        done = subprocess.run(["sh", "-c", f'exec "$@" {redirected}', "sh", sys.executable, "-m", "porelang", *words],
                              cwd=work, capture_output=True, text=True, env=environment(), check=False)  # fmt: skip
        assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
        if words is mesh:
            assert (work / "c.stl").stat().st_size % 50 == 84 % 50
            (work / "c.stl").unlink()
        else:
            assert np.load(work / "c.npy").shape == (300_000,)
            (work / "c.npy").unlink()
    done = subprocess.run(["sh", "-c", 'exec "$@" 2>/dev/full', "sh", sys.executable, "-m", "porelang", "check", "b"],
                          cwd=work, capture_output=True, text=True, env=environment(), check=False)  # fmt: skip
    assert done.returncode == 2


def test_a_folder_that_is_gone_is_told(tmp_path: Path) -> None:
    """Also the one that the command is typed in."""
    code = (
        "import os, sys; os.chdir(sys.argv[1]); os.rmdir(sys.argv[1]); from porelang.cli import main;"
        "sys.exit(main(['slices', sys.argv[2], '-o', 'out', '--step', '1mm']) * 10"
        " + main(['mesh', sys.argv[2], '-o', 'a.stl']))"
    )
    (tmp_path / "a.pore").write_text(BALL)
    (tmp_path / "gone").mkdir()
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path / "gone"), str(tmp_path / "a.pore")],
                          capture_output=True, text=True, env=environment(), check=False)  # fmt: skip
    assert done.returncode == 22
    assert done.stderr.count("error[E113]") == 2
