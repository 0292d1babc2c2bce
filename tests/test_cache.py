"""The store of results: whole or absent, believed only where it is ours, never above its limit; and `pore cache`."""

from __future__ import annotations

import errno
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from porelang import cache, store
from porelang.cli import main
from porelang.data import Reduced, SampledField, Segments
from porelang.store import Result

ONE = Reduced(1.25, 0.5)
FIELD = replace(
    SampledField.from_array(np.random.default_rng(1).random((5, 6, 7, 3)), (1, 2, 3), (0.5, 1, 2)), facts=(1.05, 27.0)
)
BARS = Segments(np.zeros((4, 3)), np.arange(1.0, 13).reshape(4, 3), np.full(4, 0.25))


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("PORELANG_CACHE", str(tmp_path / "kept"))
    monkeypatch.delenv("PORELANG_CACHE_LIMIT", raising=False)
    store.forget()
    return tmp_path / "kept" / "results"


def key(i: int) -> str:
    return f"{i:064x}"[::-1]


def same(a: Result | None, b: Result) -> bool:
    if isinstance(b, Reduced):
        return a == b
    alike = a is not None and not isinstance(a, Reduced) and a.digest == b.digest
    return alike and getattr(a, "facts", ()) == getattr(b, "facts", ())


def kept(folder: Path) -> list[str]:
    return sorted(p.name for p in folder.iterdir()) if folder.exists() else []


# -- what is put is got --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("result", [ONE, Reduced(-0.0, 0.0), Reduced(1e-310, np.inf), FIELD, BARS])
def test_what_was_put_is_got_by_another_process(result: Result) -> None:
    store.put(key(1), result)
    assert store.get(key(1)) is result
    store.forget()  # what a new process knows
    found = store.get(key(1))
    assert found is not result
    assert same(found, result)
    assert type(found) is type(result)
    assert store.get(key(2)) is None


def test_float32_stays_float32_and_nothing_can_be_written(folder: Path) -> None:
    field = SampledField.from_array(np.ones((2, 2, 2), np.float32), (0, 0, 0), 1.0)
    store.put(key(1), field)
    store.put(key(2), BARS)
    store.forget()
    found, bars = store.get(key(1)), store.get(key(2))
    assert isinstance(found, SampledField)
    assert isinstance(bars, Segments)
    assert found.values.dtype == np.float32
    assert not any(a.flags.writeable for a in (found.values, bars.starts, bars.ends, bars.radii))


def test_a_key_is_a_digest() -> None:
    for wrong in ("", "../" + key(1), "ABCDEF0123456789" * 4, "a/b", "a" * 15, key(1) + "\n"):
        with pytest.raises(ValueError, match="digest"):
            store.put(wrong, ONE)
        with pytest.raises(ValueError, match="digest"):
            store.get(wrong)


def test_memory_forgets_what_was_not_used_for_longest(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PORELANG_CACHE_LIMIT", "0")  # memory alone
    monkeypatch.setattr(store, "_HELD_BYTES", 3 * FIELD.values.nbytes + 500)
    for i in range(3):
        store.put(key(i), FIELD)
    assert store.get(key(0)) is FIELD
    store.put(key(3), FIELD)
    assert [store.get(key(i)) is not None for i in range(4)] == [True, False, True, True]
    large = SampledField.from_array(np.zeros((50, 50, 50)), (0, 0, 0), 1)
    store.put(key(4), large)  # more than there is room for pushes nothing out
    assert [store.get(key(i)) is not None for i in range(5)] == [True, False, True, True, False]
    monkeypatch.setattr(store, "_HELD", 2)
    store.put(key(5), ONE)
    assert [store.get(key(i)) is not None for i in range(6)] == [False, False, False, True, False, True]


# -- what is damaged, or not ours, is absent -----------------------------------------------------------------------


def reheaded(content: bytes, **changes: Any) -> bytes:
    """A file whose header says something else, with the right digest of the header."""
    import hashlib

    magic, header, payload = content.split(b"\n", 2)
    about = {**json.loads(header), **changes}
    header = json.dumps(about).encode() + b"\n"
    return magic[:18] + hashlib.sha256(header).hexdigest().encode() + b"\n" + header + payload


DAMAGE: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda b: b"",
    "half": lambda b: b[: len(b) // 2],
    "a byte short": lambda b: b[:-1],
    "a byte long": lambda b: b + b"\0",
    "payload": lambda b: b[:-3] + bytes([b[-3] ^ 1]) + b[-2:],
    "header": lambda b: b.replace(b'"label": ""', b'"label": "x"'),
    "magic": lambda b: b"q" + b[1:],
    "version": lambda b: b.replace(b"result 1", b"result 2", 1),
    "zeros": lambda b: bytes(len(b)),
    "noise": lambda b: b"\xff\x00" * 400,
    "a pickle": lambda b: b"cos\nsystem\n(S'touch it-ran'\ntR.",
    "another key": lambda b: reheaded(b, key=key(2)),
    "another kind": lambda b: reheaded(b, kind="number" if b.find(b'"number"') < 0 else "segments"),
    "no kind": lambda b: reheaded(b, kind="study"),
    "a digest": lambda b: reheaded(b, digest="0" * 64),
    "huge": lambda b: reheaded(b, arrays=[["<f8", [10**6, 10**6]]]),
    "negative": lambda b: reheaded(b, arrays=[["<f8", [-1, -2]]]),
    "objects": lambda b: reheaded(b, arrays=[["|O", [2]]]),
    "no arrays": lambda b: reheaded(b, arrays=None),
    "odd arrays": lambda b: reheaded(b, arrays=[1, [2]]),
    "a list": lambda b: reheaded(b, arrays=[["<f8", "22"]]),
}


@pytest.mark.parametrize("result", [ONE, FIELD, BARS])
@pytest.mark.parametrize("damage", DAMAGE)
def test_what_is_damaged_is_absent_and_mended(damage: str, result: Result, folder: Path) -> None:
    store.put(key(1), result)
    path = folder / f"{key(1)}.result"
    path.write_bytes(DAMAGE[damage](path.read_bytes()))
    store.forget()
    assert store.get(key(1)) is None
    store.put(key(1), result)
    store.forget()
    assert same(store.get(key(1)), result)


def test_every_byte_counts(folder: Path) -> None:
    store.put(key(1), ONE, "porosity(a)")
    path = folder / f"{key(1)}.result"
    good = path.read_bytes()
    for i in range(len(good)):
        path.write_bytes(good[:i] + bytes([good[i] ^ 4]) + good[i + 1 :])
        store.forget()
        assert store.get(key(1)) is None


def unsound() -> list[Result]:
    values = FIELD.values.copy()
    values[0, 0, 0, 0] = np.nan
    return [
        Reduced(np.nan, 0.0),
        Reduced(0.0, -1.0),
        Reduced(0.0, np.nan),
        SampledField(values, (0, 0, 0), (1, 1, 1)),
        SampledField(FIELD.values, (0, 0, np.inf), (1, 1, 1)),
        SampledField(FIELD.values, (0, 0, 0), (1, 0, 1)),
        Segments(BARS.starts[:0], BARS.ends[:0], BARS.radii[:0]),
        Segments(BARS.starts, BARS.ends * np.inf, BARS.radii),
    ]


@pytest.mark.filterwarnings("ignore:invalid value")
def test_what_no_task_can_have_found_is_neither_written_nor_read(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for i, result in enumerate(unsound()):
        store.put(key(i), result)
        assert not kept(folder)
        with monkeypatch.context() as m:
            m.setattr(store, "_plausible", lambda _: True)
            store.put(key(i), result)
        assert len(kept(folder)) == 1
        store.forget()
        assert store.get(key(i)) is None
        store.clear()


def plant_link(path: Path) -> None:
    path.rename(path.parent.parent / "elsewhere")
    path.symlink_to(path.parent.parent / "elsewhere")


def plant_pipe(path: Path) -> None:
    path.unlink()
    os.mkfifo(path)


def plant_device(path: Path) -> None:
    path.unlink()
    path.symlink_to("/dev/zero")


def plant_folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


@pytest.mark.parametrize("plant", [plant_link, plant_pipe, plant_device, plant_folder, lambda p: p.chmod(0o666)])
def test_what_is_no_file_of_ours_alone_is_absent(plant: Callable[[Path], None], folder: Path) -> None:
    store.put(key(1), ONE)
    plant(folder / f"{key(1)}.result")
    store.forget()
    assert store.get(key(1)) is None
    assert store.usage().entries == ()
    assert store.clear() == 0
    assert kept(folder) == [f"{key(1)}.result"]


def test_a_device_is_never_opened(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """To open one can do something: a tape winds back."""
    store.put(key(1), ONE)
    plant_pipe(folder / f"{key(1)}.result")
    store.forget()
    monkeypatch.setattr(os, "open", lambda *_: pytest.fail("opened"))
    assert store.get(key(1)) is None


def test_what_is_put_in_its_place_at_the_last_moment_is_absent(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store.put(key(1), ONE)
    store.forget()
    path, open_file = folder / f"{key(1)}.result", os.open

    def late(*args: Any) -> int:
        path.chmod(0o666)
        return open_file(*args)

    monkeypatch.setattr(os, "open", late)
    assert store.get(key(1)) is None


def test_a_link_of_ours_to_a_folder_of_ours_is_used(folder: Path, tmp_path: Path) -> None:
    """A cache that was moved to a larger disk."""
    (tmp_path / "large").mkdir(mode=0o700)
    folder.parent.symlink_to(tmp_path / "large")
    store.put(key(1), ONE)
    store.forget()
    assert store.get(key(1)) == ONE
    assert kept(tmp_path / "large" / "results") == [f"{key(1)}.result"]


def test_a_planted_link_is_not_followed_when_writing(folder: Path, tmp_path: Path) -> None:
    precious = tmp_path / "precious"
    precious.write_text("mine")
    folder.mkdir(parents=True)
    (folder / f"{key(1)}.result").symlink_to(precious)
    store.put(key(1), ONE)
    store.forget()
    assert store.get(key(1)) == ONE
    assert precious.read_text() == "mine"
    assert not (folder / f"{key(1)}.result").is_symlink()


def of_another(monkeypatch: pytest.MonkeyPatch) -> None:
    """From now on this process is another user's."""
    other = os.geteuid() + 1
    monkeypatch.setattr(os, "geteuid", lambda: other)


def test_a_folder_of_another_user_is_not_used(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store.put(key(1), ONE)
    cache.put("prelude", b"x")
    before = kept(folder)
    store.forget()
    with monkeypatch.context() as m:
        of_another(m)
        assert store.get(key(1)) is None
        assert cache.get("prelude") is None
        store.put(key(2), ONE)
        cache.put("number", b"x")
        assert store.clear() == 0
        assert "another user" in store.usage().refusal
    assert kept(folder) == before
    assert not (folder.parent / "number").exists()


@pytest.mark.parametrize("mode", [0o770, 0o707, 0o1777])
@pytest.mark.parametrize("level", [0, 1])
def test_a_folder_that_others_can_write_is_not_used(mode: int, level: int, folder: Path) -> None:
    store.put(key(1), ONE)
    (folder, folder.parent)[level].chmod(mode)
    store.forget()
    assert store.get(key(1)) is None
    store.put(key(2), ONE)
    assert kept(folder) == [f"{key(1)}.result"]
    assert "written by others" in store.usage().refusal
    assert store.clear() == 0


def test_files_and_folders_are_ours_alone_whatever_the_umask(folder: Path) -> None:
    before = os.umask(0)
    try:
        store.put(key(1), ONE)
        cache.put("prelude", b"x")
    finally:
        os.umask(before)
    store.forget()
    assert store.get(key(1)) == ONE
    assert cache.get("prelude") == b"x"
    for path in (folder.parent, folder, *folder.iterdir(), folder.parent / "prelude"):
        assert path.stat().st_mode & 0o077 == 0


def test_the_cache_of_files_opens_no_links_and_no_pipes(folder: Path) -> None:
    cache.put("a", b"x")
    (folder.parent / "b").symlink_to(folder.parent / "a")
    os.mkfifo(folder.parent / "c")
    (folder.parent / "a").chmod(0o606)
    assert [cache.get(name) for name in ("a", "b", "c", "\0")] == [None] * 4


# -- a disk that does not do what is asked -------------------------------------------------------------------------


def test_a_full_disk_is_no_error_and_leaves_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as m:
        m.setattr(os, "replace", full)
        store.put(key(1), FIELD)
    assert kept(folder) == []
    assert store.get(key(1)) is FIELD


def test_a_place_that_is_no_folder_is_no_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("x")
    for where in (tmp_path / "file", tmp_path / "file" / "below", Path("/proc/none")):
        monkeypatch.setenv("PORELANG_CACHE", str(where))
        store.put(key(1), ONE)
        store.forget()
        assert store.get(key(1)) is None
        assert store.usage().total == 0
        assert store.clear() == 0
        assert main(["cache"]) == 0
    assert (tmp_path / "file").read_text() == "x"


@pytest.mark.parametrize("where", ["open", "replace"])
def test_an_interrupt_leaves_nothing(where: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> int:
        raise KeyboardInterrupt

    with monkeypatch.context() as m:
        m.setattr(os, where, interrupted)
        with pytest.raises(KeyboardInterrupt):
            store.put(key(1), FIELD)
    assert kept(folder) == []


def test_what_crashes_left_is_swept_after_an_hour(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store.put(key(1), ONE)
    old, new = (folder / f".{key(i)}.result.{i:016x}.part" for i in (1, 2))
    foreign = folder / ".notes.part"
    for path in (old, new, foreign):
        path.write_bytes(b"x" * 1000)
        path.chmod(0o600)
    for path in (old, foreign):
        os.utime(path, (1, 1))
    assert store.clear() > 1000
    assert kept(folder) == sorted([new.name, foreign.name])
    os.utime(new, (time.time() - 7200,) * 2)
    monkeypatch.setenv("PORELANG_CACHE_LIMIT", "1kB")
    for i in range(10):
        store.put(key(i), ONE)
    assert not new.exists()
    assert foreign.exists()


# -- the limit -----------------------------------------------------------------------------------------------------


def aged(folder: Path, i: int, seconds: int) -> None:
    os.utime(folder / f"{key(i)}.result", (seconds, seconds))


def test_the_least_recently_used_go_first(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    size = 0
    for i in range(8):
        store.put(key(i), FIELD)
        aged(folder, i, 1000 + i)
        size = (folder / f"{key(i)}.result").stat().st_size
    monkeypatch.setenv("PORELANG_CACHE_LIMIT", f"{size * 9 // 2}")
    store.forget()
    assert store.get(key(1)) is not None  # used now
    store.put(key(8), FIELD)
    assert set(kept(folder)) == {f"{key(i)}.result" for i in (1, 6, 7, 8)}
    for i in range(20, 60):
        store.put(key(i), FIELD)
        assert store.usage().total <= size * 9 // 2
    assert f"{key(59)}.result" in kept(folder)


def test_many_small_ones_are_counted_too(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store, "_FILES", 50)
    for i in range(300):
        store.put(key(i), ONE)
    assert 40 <= len(kept(folder)) <= 66  # listed one time in sixteen until the first listing
    assert store.get(key(299)) == ONE


def test_more_than_the_limit_is_not_kept(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store.put(key(1), ONE)
    monkeypatch.setenv("PORELANG_CACHE_LIMIT", "3kB")
    store.put(key(2), FIELD)
    assert kept(folder) == [f"{key(1)}.result"]  # nor is anything pushed out for it
    monkeypatch.setenv("PORELANG_CACHE_LIMIT", "0")
    store.put(key(3), ONE)
    assert kept(folder) == [f"{key(1)}.result"]


@pytest.mark.parametrize(
    ("text", "size"),
    [
        ("", 2 * 10**9),
        ("500MB", 5 * 10**8),
        ("1.5 gb", 15 * 10**8),
        ("2GiB", 2**31),
        ("100", 100),
        ("3k", 3000),
        ("0", 0),
    ],
)
def test_the_limit_is_read(text: str, size: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PORELANG_CACHE_LIMIT", text)
    assert store.limit() == size


@pytest.mark.parametrize("text", ["much", "-1", "1e9", "nan", "5 5", "1XB", "9" * 99])
def test_a_limit_that_is_no_size_is_said_by_the_command_alone(
    text: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PORELANG_CACHE_LIMIT", text)
    store.put(key(1), ONE)
    assert len(kept(folder)) == 1
    assert main(["cache"]) == 2
    assert "error[E108]" in capsys.readouterr().err
    assert main(["cache", "clear"]) == 0
    assert kept(folder) == []


# -- several at once -----------------------------------------------------------------------------------------------

WORK = """
import sys, random
import numpy as np
from porelang import store
from porelang.data import SampledField
dice = random.Random(int(sys.argv[1]))
for turn in range(150):
    i = dice.randrange(12)
    key = f"{i:064x}"[::-1]
    if dice.random() < 0.05:
        store.clear()
    store.forget()
    found = store.get(key)
    if found is None:
        values = np.full((10, 10, 10 + i), float(i))
        store.put(key, SampledField.from_array(values, (0, 0, 0), 1.0))
    else:
        assert found.values.shape == (10, 10, 10 + i, 1) and (found.values == i).all()
"""


def test_processes_write_delete_and_read_at_once(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PORELANG_CACHE_LIMIT", "80kB")  # about eight of the twelve
    running = [subprocess.Popen([sys.executable, "-c", WORK, str(i)], stderr=subprocess.PIPE) for i in range(3)]
    for process in running:
        _, error = process.communicate(timeout=120)
        assert process.returncode == 0, error.decode()
    assert all(re.fullmatch(r"[0-9a-f]{64}\.result", name) for name in kept(folder))


def test_threads_write_and_read_at_once() -> None:
    failed: list[str] = []

    def work(seed: int) -> None:
        for turn in range(100):
            i = (seed * 7 + turn) % 5
            store.put(key(i), Reduced(float(i), 0.5), f"number {i}")
            if turn % 10 == 0:
                store.forget()
            found = store.get(key(i))
            if found != Reduced(float(i), 0.5):
                failed.append(f"{i}: {found}")

    threads = [threading.Thread(target=work, args=(i,)) for i in range(8)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    assert not failed


def test_a_file_deleted_while_it_is_read_is_read_or_absent(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store.put(key(1), FIELD)
    store.forget()
    header = store._header

    def late(*args: Any) -> Any:
        store.clear()
        return header(*args)

    monkeypatch.setattr(store, "_header", late)
    assert same(store.get(key(1)), FIELD)  # it was open
    store.forget()
    assert store.get(key(1)) is None


def test_an_ended_process_leaves_no_half_of_a_file(folder: Path) -> None:
    """Ctrl-C at any moment of many writes."""
    code = (
        "import numpy as np, sys\nfrom porelang import store\nfrom porelang.data import SampledField\n"
        "field = SampledField.from_array(np.ones((60, 60, 60)), (0, 0, 0), 1.0)\nfield.digest\n"
        "print('ready', flush=True)\n"
        "while True:\n    for i in range(50): store.put(f'{i:064x}'[::-1], field)"
    )
    for wait in (0.05, 0.1, 0.17):
        running = subprocess.Popen(
            [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        assert running.stdout is not None
        try:
            running.stdout.readline()
            time.sleep(wait)
            running.send_signal(signal.SIGINT)
            running.wait(30)
        finally:
            running.kill()
            running.stdout.close()
        assert not [name for name in kept(folder) if name.startswith(".")]


# -- pore cache ----------------------------------------------------------------------------------------------------


def test_clear_leaves_alone_what_is_not_ours(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    store.put(key(1), FIELD, "load")
    store.put(key(2), ONE)
    cache.put("prelude-1", b"x")
    (folder / "photo.jpg").write_bytes(b"photo")
    (folder / f"{key(3)}.result").write_bytes(b"a thesis under an unlucky name")
    (folder / f"{key(4)}.result").symlink_to(tmp_path / "photo")
    (folder / "sub").mkdir()
    (tmp_path / "photo").write_bytes(b"porelang result 1 not really")
    size = store.usage().total
    assert main(["cache", "clear", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"freed": size}
    assert kept(folder) == sorted(["photo.jpg", f"{key(3)}.result", f"{key(4)}.result", "sub"])
    assert (tmp_path / "photo").exists()
    assert cache.get("prelude-1") == b"x"
    assert main(["cache", "clear"]) == 0
    assert capsys.readouterr().out == "0 B freed\n"


def test_the_list_says_what_is_there(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    store.put(key(1), ONE, "porosity(\n  gyroid(3),\tsphere(9)) \x1b[31m" + "x" * 500)
    store.put(key(2), FIELD, "stress in grid.npz")
    store.put(key(3), BARS)
    for i in (1, 2, 3):
        aged(folder, i, 10**9 + i)
    assert main(["cache", "list"]) == 0
    told = capsys.readouterr()
    lines = told.out.splitlines()
    assert lines[0].split()[-1] == key(3)[:16]  # the last used first, by its key for want of a label
    assert "stress in grid.npz" in lines[1]
    assert "porosity( gyroid(3), sphere(9))" in lines[2]
    assert "\x1b" not in told.out
    assert max(map(len, lines)) < 260
    assert "3 results" in told.err
    assert main(["cache", "list", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert [e["kind"] for e in listed["entries"]] == ["segments", "sampled field", "number"]
    assert listed["entries"][0]["used"] == "2001-09-09T01:46:43+00:00"
    assert sum(e["bytes"] for e in listed["entries"]) == listed["bytes"]
    assert listed["folder"] == str(folder)


def test_the_size_is_the_default_and_a_damaged_file_counts(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    store.put(key(1), FIELD)
    path = folder / f"{key(1)}.result"
    path.write_bytes(path.read_bytes().replace(b'"label"', b'"lapel"'))
    assert main(["cache"]) == 0
    said = capsys.readouterr().out
    assert main(["cache", "size"]) == 0
    assert capsys.readouterr().out == said
    assert said.startswith("1 result, ")
    assert " of 2 GB in " in said
    assert store.usage().entries[0].kind == "damaged"
    assert main(["cache", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["results"] == 1
    assert store.clear() > 0
    assert main(["cache"]) == 0
    assert capsys.readouterr().out.startswith("no results, 0 B of 2 GB in ")


def test_why_nothing_is_kept_is_said(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder.parent.mkdir()
    folder.parent.chmod(0o777)
    assert main(["cache"]) == 0
    assert "can be written by others" in capsys.readouterr().err
    monkeypatch.setattr(cache, "folder", lambda: None)
    assert main(["cache", "list", "--json"]) == 0
    told = capsys.readouterr()
    assert json.loads(told.out)["folder"] is None
    assert "PORELANG_CACHE" in told.err


def test_a_misspelt_action_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["cache", "claer"]) == 2
    assert "did you mean `clear`?" in capsys.readouterr().err
