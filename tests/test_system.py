"""What the system refuses is told as the system's: names, room, memory, a driver that is killed, a read-only home."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from porelang import cache, compiled, limits, store
from porelang.atomic import destination, unwritable
from porelang.cli import main
from porelang.diagnostics import PoreError
from porelang.gpu import device, errors, fields, process
from porelang.slices.folder import layers_folder

BALL = "sphere(4)\n"
ROOT = Path(__file__).parent.parent
pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals, limits and modes of files")


def environment(**more: str) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT), **more}


def pore(words: str, cwd: Path, **more: str) -> subprocess.CompletedProcess[str]:
    """A command line as a shell runs it: `pore` is this Python's."""
    text = f'pore() {{ "{sys.executable}" -m porelang "$@"; }}; {words}'
    return subprocess.run(["bash", "-c", text], cwd=cwd, capture_output=True, text=True, check=False,
                          env=environment(**more), errors="surrogateescape")  # fmt: skip


@pytest.fixture
def work(tmp_path: Path) -> Path:
    (tmp_path / "a.pore").write_text(BALL)
    return tmp_path


def names(where: Path) -> list[str]:
    return sorted(os.listdir(where))


# ---- names


@pytest.mark.parametrize("name", ["", "nowhere/..", "nowhere/../a.pore", "nowhere/../../" + "x"])
def test_a_name_that_leads_elsewhere_replaces_nothing(
    name: str, work: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`-o ''` replaced the folder that the command was typed in by one of layers."""
    monkeypatch.chdir(work)
    (work.parent / "x").mkdir(exist_ok=True)
    for check in (destination, layers_folder):
        with pytest.raises(PoreError, match="E113"):
            check(name)
    assert main(["slices", "a.pore", "-o", name, "--step", "1"]) == 2
    assert "error[E1" in capsys.readouterr().err
    assert names(work) == ["a.pore"]


@pytest.mark.parametrize(
    ("number", "says"),
    [(errno.ENOSPC, "make room"), (errno.ENAMETOOLONG, "shorter name"), (errno.EROFS, "another|can be written"),
     (errno.ENOTDIR, "check the path"), (errno.EACCES, "choose a folder"), (errno.EFBIG, "ulimit -f")],
)  # fmt: skip
def test_the_way_out_fits_the_reason(number: int, says: str) -> None:
    (found,) = unwritable("part.stl", OSError(number, os.strerror(number))).diagnostics
    assert found.code == "E113"
    assert any(word in found.hint for word in says.split("|"))


def test_want_of_memory_is_no_fault_of_the_folder() -> None:
    (found,) = unwritable("part.stl", OSError(errno.ENOMEM, "Cannot allocate memory")).diagnostics
    assert found.code == "E124"
    assert "folder" not in found.hint


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("mesh a.pore -o /dev/full", "it is a device"),
        ("render a.pore -o /dev/full", "it is a device"),
        ("eval a.pore --points p.csv -o /dev/full", "it is a device"),
        ("mesh a.pore -o -", "not to standard output"),
        ("eval a.pore --points - <&-", "no standard input"),
    ],
)
def test_what_is_no_file_is_called_what_it_is(words: str, says: str, work: Path) -> None:
    (work / "p.csv").write_text("0,0,0\n")
    done = pore(f"pore {words}", work)
    assert done.returncode == 2
    assert says in done.stderr
    assert names(work) == ["a.pore", "p.csv"]


def test_a_name_that_is_no_text_is_said_as_it_was_typed(work: Path) -> None:
    done = pore("cp a.pore $'b\\xe9.pore'; pore check $'b\\xe9.pore'; pore check $'c\\xe9.pore'", work)
    assert done.stderr.startswith("b\udce9.pore: no errors")
    assert "there is no file `c\udce9.pore`" in done.stderr
    done = pore("pore check n\u00f6.pore", work, LC_ALL="C", PYTHONUTF8="0", PYTHONCOERCECLOCALE="0")
    assert "there is no file `n\u00f6.pore`" in done.stderr.encode(errors="surrogateescape").decode()


# ---- command lines


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["mesh", "a.pore", "out.stl"], "`-o out.stl`"),
        (["check", "a.pore", "b.pore"], "one program at a time"),
        (["check", "a.pore", "--set", "w=5", "v=6"], "`--set v=6`"),
        (["check", "a.pore", "--w=5"], "`--set w=5`"),
        (["mesh", "a.pore", "-o", "a.stl", "--voxel", "0,5"], "0.5"),
        (["eval", "a.pore", "--points", "1,2,3"], "echo 1,2,3 |"),
        (["mesh", "b.pore", "-o", "a.stl", "--out", "ball"], "`out ball_ = ball`"),
    ],
)
def test_the_way_out_of_a_command_line_is_told(
    words: list[str], says: str, work: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(work)
    (work / "b.pore").write_text("let ball = sphere(5)\nball | cube(3)\n")
    assert main(words) == 2
    assert says in capsys.readouterr().err.partition("= hint: ")[2]


def test_a_code_may_be_asked_for_by_its_number(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", "12"]) == 0
    assert capsys.readouterr().out.startswith("E012: ")


# ---- numbers


@pytest.mark.parametrize(
    "words",
    ["mesh a.pore -o o.stl --voxel 1e300", "mesh a.pore -o o.stl --voxel 1e-300", "slices a.pore -o l --step 1e300",
     "slices a.pore -o l --step 1e-300", "slices a.pore -o l --step 1 --voxel 1e300", "measure a.pore --voxel 1e300",
     "mesh a.pore -o o.stl --simplify 1e300", "mesh a.pore -o o.stl --bounds=5e-324,0,0,1e-323,1,1"],
)  # fmt: skip
def test_lengths_that_are_none_are_told_in_a_line(words: str, work: Path) -> None:
    done = pore(f"pore {words}", work)
    assert done.returncode == 2
    assert "error[E108]" in done.stderr
    assert "Warning" not in done.stderr
    assert max(map(len, done.stderr.splitlines())) < 120
    assert names(work) == ["a.pore"]


def test_layers_of_no_height_are_told_from_python_too(work: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """At once: the ends of the part are known well enough for such a layer after twenty seconds."""
    import porelang
    from porelang.slices import write_slices

    monkeypatch.setattr("porelang.slices.write.extent_of", None)
    for step, pixel in ((1e300, None), (1e-300, None), (1.0, 1e300), (1.0, 1e-300)):
        with pytest.raises(PoreError, match="E114"):
            write_slices(porelang.compile(BALL).design(), work / "l", step, pixel=pixel)


def test_a_field_that_is_zero_everywhere_is_not_called_positive(work: Path) -> None:
    (work / "z.pore").write_text("0 * x\n")
    done = pore("pore mesh z.pore -o o.stl --bounds=-1,-1,-1,1,1,1", work)
    assert "nowhere negative" in done.stderr
    assert "from 0 to 0" not in done.stderr


# ---- memory


def test_want_of_memory_is_known_in_any_words() -> None:
    assert limits.is_short_of_memory(MemoryError())
    assert limits.is_short_of_memory(OSError(errno.ENOMEM, "Cannot allocate memory"))
    assert limits.is_short_of_memory(RuntimeError("can't start new thread"))
    assert limits.is_short_of_memory(ImportError("x.so: failed to map segment from shared object"))
    hidden = OSError("Could not find/load shared object file")
    hidden.__cause__ = OSError("lib.so: failed to map segment from shared object")
    assert limits.is_short_of_memory(hidden)
    assert not limits.is_short_of_memory(RuntimeError("something else"))
    assert not limits.is_short_of_memory(OSError(errno.EACCES, "Permission denied"))


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere `ulimit -v` limits nothing")
@pytest.mark.parametrize("most", [160_000, 200_000])
def test_a_limited_memory_is_told_with_its_limit(most: int, work: Path) -> None:
    done = pore(f"ulimit -v {most}; pore measure a.pore -q", work)
    assert done.returncode == 3
    assert f"this process may use {most * 1024 / 1e6:,.0f} MB of memory" in done.stderr
    assert "ulimit -v unlimited" in done.stderr


# ---- the driver's process


@pytest.fixture
def killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Drivers' processes are killed as soon as they start."""
    script = tmp_path / "python"
    script.write_text("#!/bin/sh\nkill -9 $$\n")
    script.chmod(0o755)
    monkeypatch.setattr(process, "_python", lambda: str(script))
    monkeypatch.setattr(device, "_shared", {})
    monkeypatch.delenv("PORELANG_GL", raising=False)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has OpenGL without a screen")
@pytest.mark.usefixtures("killed")
def test_a_driver_that_is_killed_has_not_to_be_installed() -> None:
    with pytest.raises(errors.GpuEnded):
        device.open_gpu()
    with pytest.raises(PoreError) as caught:
        fields.gpu()
    (found,) = caught.value.diagnostics
    assert found.code == "E125"
    assert "SIGKILL" in found.message
    assert "install" not in found.hint
    assert "--backend numpy" in found.hint


# ---- compiled loops


LOOPS = """
from porelang.compiled import compiled
@compiled
def total(values):
    out = 0.0
    for value in values:
        out += value
    return out
"""
RUN = """
import sys, porelang.compiled
from porelang.progress import on_compiling
sys.path.insert(0, sys.argv[1])
porelang.compiled._writable = lambda folder: str(folder) != str(porelang.compiled.PACKAGE)
on_compiling(lambda kept: print("compiling" if kept else "not kept"))
import numpy, loops, numba
print(loops.total(numpy.arange(4.0)), numba.config.CACHE_DIR or "as it was")
"""


def run_loops(where: Path, **more: str) -> list[str]:
    done = subprocess.run([sys.executable, "-c", RUN, str(where)], capture_output=True, text=True, check=True,
                          env=environment(**more))  # fmt: skip
    return done.stdout.split(maxsplit=1 if done.stdout[0] in "cn" else 0)


def test_loops_are_kept_in_the_users_cache_where_the_package_is_read_only(tmp_path: Path) -> None:
    (tmp_path / "loops.py").write_text(LOOPS)
    folder = tmp_path / "cache"
    assert run_loops(tmp_path, PORELANG_CACHE=str(folder))[0] == "compiling"
    assert [p.suffix for p in sorted((folder / cache.LOOPS).rglob("*.nb?"))] == [".nbc", ".nbi"]
    assert (folder / cache.LOOPS).stat().st_mode & 0o777 == 0o700
    assert run_loops(tmp_path, PORELANG_CACHE=str(folder)) == ["6.0 as it was\n"]
    for path in (folder / cache.LOOPS).rglob("*.nb?"):  # what is damaged is compiled again
        path.write_bytes(b"no index")
    assert run_loops(tmp_path, PORELANG_CACHE=str(folder))[0] == "compiling"


def test_loops_are_not_kept_where_others_could_lay_some(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "cache"
    monkeypatch.setenv("PORELANG_CACHE", str(folder))
    assert compiled._own_folder() == folder / cache.LOOPS
    (folder / cache.LOOPS).chmod(0o777)
    assert compiled._own_folder() is None
    monkeypatch.setenv("PORELANG_CACHE", "/dev/null/nowhere")
    assert compiled._own_folder() is None


def test_a_full_disk_keeps_no_loop_and_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    @compiled.compiled
    def twice(value: float) -> float:
        return 2 * value

    def full(*arguments: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    @compiled.compiled
    def thrice(value: float) -> float:
        return 3 * value

    monkeypatch.setattr("numba.core.caching.IndexDataCacheFile.save", full)
    monkeypatch.setattr("numba.core.caching.IndexDataCacheFile.load", full)
    assert twice(2.0) == 4.0
    assert thrice(2.0) == 6.0


# ---- what is left of runs that were killed


def test_drafts_of_runs_that_were_killed_are_counted_and_cleared(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PORELANG_CACHE", str(tmp_path / "cache"))
    folder = tmp_path / "cache" / "results"
    folder.mkdir(mode=0o700, parents=True)
    (tmp_path / "cache").chmod(0o700)
    dead, alive = (folder / f".{i:032x}.result.{i:016x}.part" for i in (1, 2))
    for path in (dead, alive):
        path.write_bytes(b"x" * 5000)
        path.chmod(0o600)
        os.utime(path, (time.time() - 90,) * 2)
    with open(alive, "rb") as writing:
        fcntl.flock(writing, fcntl.LOCK_EX)
        assert store.usage().left == 5000
        assert main(["cache"]) == 0
        assert "5 kB left by runs that were killed" in capsys.readouterr().out
        assert main(["cache", "clear", "--json"]) == 0
        assert json.loads(capsys.readouterr().out) == {"freed": 5000}
        assert not dead.exists()
        assert alive.exists()


SWAP = """
import json, sys
from pathlib import Path
from porelang.slices.folder import MANIFEST, digest_of, replace_folder
for _ in range(40):
    with replace_folder(Path(sys.argv[1])) as draft:
        (draft / "layer_0000.png").write_bytes(b"layer")
        made = {"files": ["layer_0000.png"], "sha256": [digest_of(draft / "layer_0000.png")]}
        (draft / MANIFEST).write_text(json.dumps({"layers": 1, "format": "png", **made}))
"""


def test_processes_that_write_the_same_layers_take_turns(tmp_path: Path) -> None:
    running = [
        subprocess.Popen(
            [sys.executable, "-c", SWAP, str(tmp_path / "layers")], env=environment(), stderr=subprocess.PIPE
        )
        for _ in range(3)
    ]
    for one in running:
        _, said = one.communicate(timeout=120)
        assert (one.returncode, said) == (0, b"")
    assert names(tmp_path) == ["layers"]
    assert names(tmp_path / "layers") == ["layer_0000.png", "layers.json"]


# ---- Python


@pytest.mark.parametrize(
    ("call", "says"),
    [
        ("porelang.compile(5)", "a program is a text"),
        ("porelang.compile(b'sphere(5)')", "a program is a text"),
        ("porelang.compile('specimen.pore')", "compile(path='specimen.pore')"),
        ("porelang.compile(path=5)", "a path is a text"),
        ("program.design(5)", "5 are no settings"),
        ("program.field(settings='w=5')", "'w=5' are no settings"),
        ("program.field(threads='x')", "'x' is no number of threads"),
        ("program.field(threads=0)", "0 is no number of threads"),
    ],
)
def test_python_answers_nonsense_in_words(call: str, says: str) -> None:
    import porelang

    program = porelang.compile("param w = 5mm in 1mm..9mm\ngyroid(w) & sphere(9)")
    with pytest.raises((PoreError, TypeError)) as caught:
        eval(call, {"porelang": porelang, "program": program})
    assert says in str(caught.value)
