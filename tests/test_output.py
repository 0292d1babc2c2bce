"""Output: where it goes and where it does not, and that nothing is left behind or lost, whatever happens."""

from __future__ import annotations

import errno
import os
import socket
import stat
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

import numpy as np
import pytest

from porelang import atomic
from porelang.atomic import destination, save, undone
from porelang.cli import main
from porelang.diagnostics import PoreError

ROOT = Path(__file__).resolve().parent.parent
BALL = "sphere(4)\n"
POSIX = pytest.mark.skipif(os.name != "posix", reason="links, pipes and modes of files")
pytestmark = POSIX


def put(path: Path, content: bytes = b"new") -> None:
    save(path, lambda file: file.write(content) and None)


def refused(path: str | Path) -> str:
    with pytest.raises(PoreError) as caught:
        put(Path(path))
    (found,) = caught.value.diagnostics
    assert found.code == "E113"
    assert found.hint
    return str(found)


def names(folder: Path) -> list[str]:
    return sorted(os.listdir(folder))


def device(path: Path) -> None:
    os.mknod(path, stat.S_IFCHR | 0o666, os.makedev(1, 7))  # of our own, in a folder of the test


def pipe(path: Path) -> None:
    os.mkfifo(path)


def bound_socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as s:
        s.bind(str(path))


KINDS = [
    pytest.param(pipe, stat.S_ISFIFO, id="pipe"),
    pytest.param(bound_socket, stat.S_ISSOCK, id="socket"),
    pytest.param(Path.mkdir, stat.S_ISDIR, id="folder"),
    pytest.param(device, stat.S_ISCHR, id="device",
                 marks=pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="root makes nodes")),
]  # fmt: skip


@pytest.mark.parametrize(("make", "is_one"), KINDS)
def test_only_regular_files_are_replaced(
    make: Callable[[Path], None], is_one: Callable[[int], bool], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # the name of a socket is short
    try:
        make(Path("there"))
    except PermissionError:
        pytest.skip("this container makes no such nodes")
    os.symlink("there", "link")
    for name in ("there", "link"):
        refused(name)
        assert is_one(os.stat(name).st_mode)
    assert os.path.islink("link")
    assert names(tmp_path) == ["link", "there"]


@pytest.mark.parametrize("command", ["mesh", "eval", "render", "slices", "tet"])
def test_every_command_refuses_what_is_no_file_before_it_computes(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    source, points = tmp_path / "a.pore", tmp_path / "p.csv"
    source.write_text(BALL)
    points.write_text("0,0,0\n")
    ending = {"mesh": ".stl", "eval": ".npy", "render": ".png", "slices": "", "tet": ".vtu"}[command]
    more = {"eval": ["--points", str(points)], "slices": ["--step", "1mm"]}.get(command, [])
    pipe(tmp_path / "pipe")
    out = tmp_path / f"out{ending}"
    out.symlink_to("pipe")
    monkeypatch.setattr("porelang.doors.make_field", None)  # nothing is evaluated
    assert main([command, str(source), "-o", str(out), *more]) == 2
    assert "E113" in capsys.readouterr().err
    assert out.is_symlink()
    assert stat.S_ISFIFO(os.stat(tmp_path / "pipe").st_mode)
    assert names(tmp_path) == sorted(["a.pore", "p.csv", "pipe", out.name])


def test_a_link_stays_and_the_file_that_it_names_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    real, link = tmp_path / "other" / "real.bin", tmp_path / "link.bin"
    link.symlink_to("other/real.bin")
    put(link)  # whose file does not exist yet
    assert real.read_bytes() == b"new"
    put(link, b"newer")
    assert real.read_bytes() == b"newer"
    assert link.is_symlink()
    lost = tmp_path / "lost.bin"
    lost.symlink_to("nowhere/real.bin")
    assert "no folder" in refused(lost)
    ring = tmp_path / "ring.bin"
    ring.symlink_to("ring.bin")
    refused(ring)
    assert names(tmp_path) == ["link.bin", "lost.bin", "other", "ring.bin"]
    assert names(tmp_path / "other") == ["real.bin"]


def test_another_name_of_a_file_keeps_the_old_content(tmp_path: Path) -> None:
    put(tmp_path / "a", b"old")
    os.link(tmp_path / "a", tmp_path / "b")
    put(tmp_path / "a")
    assert [(tmp_path / n).read_bytes() for n in "ab"] == [b"new", b"old"]


def test_a_file_that_was_made_read_only_is_not_replaced(tmp_path: Path) -> None:
    """Root, who may write anything, is held to it as well."""
    path = tmp_path / "kept"
    path.write_bytes(b"old")
    path.chmod(0o444)
    assert "chmod u+w" in refused(path)
    link = tmp_path / "link"
    link.symlink_to(path)
    refused(link)
    assert path.read_bytes() == b"old"


def test_owner_and_permissions_of_a_file_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"old")
    path.chmod(0o640)
    if os.geteuid() == 0:
        os.chown(path, 1234, 2345)
    before = path.stat()
    put(path)
    after = path.stat()
    assert path.read_bytes() == b"new"
    assert (after.st_mode, after.st_uid, after.st_gid) == (before.st_mode, before.st_uid, before.st_gid)
    old = os.umask(0o027)
    try:
        put(tmp_path / "b")
    finally:
        os.umask(old)
    assert stat.S_IMODE((tmp_path / "b").stat().st_mode) == 0o640


@pytest.mark.parametrize("name", ["x" * 255, "\N{GREEK SMALL LETTER PI}" * 127, "\N{GRINNING FACE}" * 63])
def test_names_may_be_as_long_as_the_system_lets_them(name: str, tmp_path: Path) -> None:
    put(tmp_path / name)
    assert names(tmp_path) == [name]
    assert "too long" in refused(tmp_path / (name * 2))
    assert names(tmp_path) == [name]


def half(file: BinaryIO, error: BaseException) -> None:
    file.write(b"half")
    file.flush()
    raise error


def test_whatever_ends_a_block_nothing_is_left(tmp_path: Path) -> None:
    path = tmp_path / "a"
    for error in (KeyboardInterrupt(), ValueError(), MemoryError()):
        with pytest.raises(type(error)):
            save(path, lambda file, error=error: half(file, error))
        assert names(tmp_path) == []
    with pytest.raises(PoreError, match="no space left"):
        save(path, lambda file: half(file, OSError(errno.ENOSPC, "No space left on device")))
    with pytest.raises(PoreError, match="E113"):  # in NumPy's words
        save(path, lambda file: half(file, OSError("4096 requested and 0 written")))
    assert names(tmp_path) == []


def test_what_could_not_be_undone_at_once_is_undone_at_the_end(tmp_path: Path) -> None:
    """An interruption may fall into the undoing."""
    calls = []

    def undo() -> None:
        calls.append(len(calls))
        if len(calls) == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), undone(undo):
        pass
    atomic._undo_the_rest()
    assert calls == [0, 1]
    atomic._pending.clear()


def test_destination_gives_the_file_that_will_be_written(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "folder").symlink_to("real")
    assert destination(tmp_path / "folder" / "a.stl") == tmp_path / "real" / "a.stl"


@pytest.mark.parametrize("way", ["by its name", "through a link", "under another name"])
@pytest.mark.parametrize("command", ["mesh", "render", "eval"])
def test_what_is_read_is_not_replaced(
    command: str, way: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A program that was called `part.stl`, a link to one, the points: they would be gone."""
    ending = {"mesh": ".stl", "render": ".png", "eval": ".npy"}[command]
    source, points = tmp_path / "a.pore", tmp_path / "points.npy"
    source.write_text(BALL)
    np.save(points, np.zeros((1, 3)))
    read = points if command == "eval" else source
    out = tmp_path / f"out{ending}"
    if way == "by its name":
        read = read.rename(out)
        points, source = (out, source) if command == "eval" else (points, out)
    elif way == "through a link":
        out.symlink_to(read)
    else:
        out.hardlink_to(read)
    before = read.read_bytes()
    more = ["--points", str(points)] if command == "eval" else []
    assert main([command, str(source), "--output", str(out), *more]) == 2
    assert "which is read for it" in capsys.readouterr().err
    assert read.read_bytes() == before


def test_used_files_and_data_are_not_replaced(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    used, data, source = tmp_path / "lib.pore", tmp_path / "heat.npz", tmp_path / "a.pore"
    used.write_text("let r = 5")
    np.savez(data, heat=np.zeros((2, 2, 2)), origin=[0, 0, 0], spacing=1.0)
    source.write_text(f'use "lib.pore" as lib\nsphere(lib.r) + load("{data}", "heat")')
    for read in (used, data):
        out = tmp_path / "out.stl"
        out.symlink_to(read)
        assert main(["mesh", str(source), "-o", str(out)]) == 2
        assert "which is read for it" in capsys.readouterr().err
        out.unlink()
    assert used.read_text() == "let r = 5"
