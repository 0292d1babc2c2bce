"""Files of data: what is right is read to the bit, and what is hostile gets a diagnostic at the call."""

from __future__ import annotations

import io
import json
import os
import pickle
import random
import socket
import struct
import subprocess
import sys
import time
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refused import refused

from porelang.diagnostics import Diagnostic, PoreError
from porelang.source import Source, Span
from porelang.tasks import datafile
from porelang.tasks.frame import read_frame
from porelang.tasks.readers import npz, read_grid

SPAN = Span(Source("part.pore", 'load("grid.npz", "stress")'), 0, 26)
ONES = np.ones((2, 3, 4))
PLACE = {"origin": [0.0, 0.0, 0.0], "spacing": 0.5}


@pytest.fixture(autouse=True)
def _afresh() -> None:
    datafile.forget()


def grid(path: Path, values: Any = ONES, **more: Any) -> Path:
    np.savez(path, **{"stress": values, **PLACE, **more})
    return path


def told(path: str | Path, name: str = "stress") -> Diagnostic:
    """What is said of a file; that it stands at the call, with a way out, and takes little memory to say."""
    tracemalloc.start()
    try:
        frame = str(path).endswith(".json")
        found = refused(lambda: read_frame(str(path), SPAN) if frame else read_grid(str(path), name, SPAN), SPAN)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 300e6
    return found


# -- grids ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
@pytest.mark.parametrize("kind", ["<f4", ">f4", "<f8", ">f8", "f2", "i1", "u2", ">i4", "i8", "?"])
@pytest.mark.parametrize("shape", [(2, 3, 4), (2, 3, 4, 1), (2, 3, 4, 3), (2, 3, 4, 6)])
def test_grid_is_read_to_the_bit(save: Any, kind: str, shape: tuple[int, ...], tmp_path: Path) -> None:
    values = (np.random.default_rng(1).random(shape) * 100).astype(kind)
    save(tmp_path / "g.npz", stress=np.asfortranarray(values), other=values[0], origin=[1, 2, 3], spacing=[0.5, 1, 2])
    found = read_grid(str(tmp_path / "g.npz"), "stress")
    assert found.values.dtype == (np.float32 if kind.endswith("f4") else np.float64)
    np.testing.assert_array_equal(found.values, values.reshape(2, 3, 4, -1))
    assert not found.values.flags.writeable
    assert (found.origin, found.spacing) == ((1, 2, 3), (0.5, 1, 2))


def test_one_spacing_stands_for_three(tmp_path: Path) -> None:
    for spacing in (0.5, [0.5], [0.5, 0.5, 0.5]):
        assert read_grid(str(grid(tmp_path / "g.npz", spacing=spacing)), "stress").spacing == (0.5, 0.5, 0.5)


class Bomb:
    def __reduce__(self) -> tuple[Any, ...]:
        return os.mkdir, ("it-ran",)


def raw(path: Path, name: str, content: bytes, **more: Any) -> Path:
    """A file in which the bytes of one array are made by hand."""
    with zipfile.ZipFile(path, "w", **more) as archive:
        archive.writestr(f"{name}.npy", content)
        for key, value in {"stress": ONES, **PLACE}.items():
            if key != name:
                file = io.BytesIO()
                np.save(file, value)
                archive.writestr(f"{key}.npy", file.getvalue())
    return path


def header(text: str, version: int = 1) -> bytes:
    length = struct.pack("<H" if version == 1 else "<I", len(text))
    return b"\x93NUMPY" + bytes([version, 0]) + length + text.encode()


def claim(shape: Any, kind: str = "'<f8'") -> bytes:
    return header(f"{{'descr': {kind}, 'fortran_order': False, 'shape': {shape}}}\n")


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def flip(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[content.index(ONES.tobytes()) + 5] ^= 1
    path.write_bytes(content)


def many_entries(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as archive:
        for i in range(30_000):
            archive.writestr(f"{i:030}.npy", b"")


def nan(count: int) -> np.ndarray[Any, Any]:
    out = np.ones((3, 3, 3))
    out[2, 2, 3 - count :] = np.nan
    return out


HOSTILE: dict[str, tuple[str, Callable[[Path], object], str]] = {
    "a folder": ("E130", Path.mkdir, "is a folder"),
    "a pipe": ("E130", os.mkfifo, "is a pipe"),
    "a link to a pipe": ("E130", lambda p: (os.mkfifo(f"{p}.x"), p.symlink_to(f"{p}.x")), "is a pipe"),
    "a link to a device": ("E130", lambda p: p.symlink_to("/dev/zero"), "is a device"),
    "a link to itself": ("E130", lambda p: p.symlink_to(p), "cannot be read"),
    "a link to nothing": ("E130", lambda p: p.symlink_to(f"{p}.x"), "no file"),
    "empty": ("E131", lambda p: p.write_bytes(b""), "damaged"),
    "no zip": ("E131", lambda p: p.write_bytes(b"PK\x03\x04 no zip" * 99), "damaged"),
    "one array": ("E131", lambda p: np.save(p.open("wb"), ONES), "damaged"),
    "cut": ("E131", lambda p: cut(grid(p)), "damaged"),
    "a bit flipped": ("E131", lambda p: flip(grid(p)), "CRC"),
    "empty zip": ("E132", lambda p: zipfile.ZipFile(p, "w").close(), "no array `stress`"),
    "many entries": ("E131", many_entries, "too large"),
    "another array": ("E132", lambda p: np.savez(p, strain=ONES, **PLACE), "no array"),
    "no origin": ("E132", lambda p: np.savez(p, stress=ONES, spacing=1), "no `origin`"),
    "no place": ("E132", lambda p: np.savez(p, stress=ONES), "no `origin` and no `spacing`"),
    "objects": ("E133", lambda p: np.savez(p, stress=np.array([[[Bomb()]]]), **PLACE), "Python objects"),
    "objects as origin": ("E133", lambda p: grid(p, origin=np.array([Bomb()] * 3)), "Python objects"),
    "a pickle": ("E131", lambda p: raw(p, "stress", pickle.dumps(Bomb())), "damaged"),
    "text": ("E133", lambda p: grid(p, np.full((2, 2, 2), "1")), "text"),
    "complex": ("E133", lambda p: grid(p, ONES + 1j), "complex"),
    "dates": ("E133", lambda p: grid(p, np.zeros((2, 2, 2), "M8[s]")), "dates"),
    "records": ("E133", lambda p: grid(p, np.zeros((2, 2, 2), [("a", "f8")])), "records"),
    "two axes": ("E133", lambda p: grid(p, ONES[0]), "(3, 4)"),
    "two numbers a node": ("E133", lambda p: grid(p, np.ones((2, 2, 2, 2))), "(2, 2, 2, 2)"),
    "five axes": ("E133", lambda p: grid(p, np.ones((2, 2, 2, 3, 1))), "no grid"),
    "one node": ("E133", lambda p: grid(p, ONES[:, :1]), "1 node along y"),
    "no nodes": ("E133", lambda p: grid(p, ONES[:, :, :0]), "no nodes along z"),
    "nan": ("E134", lambda p: grid(p, nan(1)), "1 value is not a finite number, at node (2, 2, 2)"),
    "nans": ("E134", lambda p: grid(p, nan(2)), "2 values are not finite numbers, the first at node (2, 2, 1)"),
    "infinity": ("E134", lambda p: grid(p, np.float32(np.inf) * ONES), "24 values"),
    "beyond float64": ("E134", lambda p: grid(p, np.full((2, 2, 2), np.longdouble("1e4000"))), "8 values"),
    "beyond float32": ("E134", lambda p: grid(p, 1e38 * ONES), "goes to 1e+38, beyond 1e+37"),
    "beyond float32 below": ("E134", lambda p: grid(p, -1e38 * ONES.astype(np.float64)), "beyond 1e+37"),
    "negative spacing": ("E134", lambda p: grid(p, spacing=[1, -1, 1]), "spacing"),
    "zero spacing": ("E134", lambda p: grid(p, spacing=0), "spacing"),
    "no spacing at all": ("E134", lambda p: grid(p, spacing=1e-300), "nanometre"),
    "nan spacing": ("E134", lambda p: grid(p, spacing=np.nan), "spacing"),
    "nan origin": ("E134", lambda p: grid(p, origin=[0, np.nan, 0]), "origin"),
    "far away": ("E134", lambda p: grid(p, origin=[0, 0, 1e9]), "along z"),
    "very wide": ("E134", lambda p: grid(p, spacing=9e4), "along y"),
    "two origins": ("E133", lambda p: grid(p, origin=np.zeros((2, 3))), "three numbers"),
    "one number as origin": ("E133", lambda p: grid(p, origin=1), "three numbers"),
    "a claim of 10^12": ("E135", lambda p: raw(p, "stress", claim((10**4,) * 3)), "8,000,000,000,000 bytes"),
    "a claim of 10^4000": ("E135", lambda p: raw(p, "stress", claim((10**1300,) * 3)), "too large"),
    "too many to count": ("E135", lambda p: raw(p, "stress", claim((2**24 + 1, 2, 2))), "16,777,217 nodes"),
    "a claim of 1 GB": ("E131", lambda p: raw(p, "stress", claim((500, 500, 500))), "1,000,000,000 bytes"),
    "a large origin": ("E133", lambda p: raw(p, "origin", claim((10**9,))), "three numbers"),
    "negative sizes": ("E131", lambda p: raw(p, "stress", claim((-2, -3, 4))), "shape"),
    "true as a size": ("E131", lambda p: raw(p, "stress", claim("(True, 2, 2)")), "shape"),
    "more than claimed": ("E131", lambda p: raw(p, "stress", claim((2, 2, 2)) + bytes(65)), "65"),
    "an odd type": ("E131", lambda p: raw(p, "stress", claim((2, 2, 2), "'<f7'")), "damaged"),
    "code as a header": ("E131", lambda p: raw(p, "stress", claim("__import__('os').mkdir('it-ran')")), "damaged"),
    "a deep header": ("E131", lambda p: raw(p, "stress", claim("(" * 5000 + ")" * 5000)), "damaged"),
    "a chain of signs": ("E131", lambda p: raw(p, "stress", claim(f"({'-' * 9000}1,)")), "damaged"),
    "a long header": ("E131", lambda p: raw(p, "stress", header(" " * 10**8, 2), compression=8), "damaged"),
    "a future version": ("E131", lambda p: raw(p, "stress", header("{}", 9)), "damaged"),
    "a rare compression": ("E131", lambda p: raw(p, "stress", claim((2, 2, 2)), compression=zipfile.ZIP_LZMA), "compr"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_grid_is_refused(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    code, make, words = HOSTILE[name]
    make(tmp_path / "grid.npz")
    found = told("grid.npz")
    assert found.code == code
    assert words in found.message
    assert not (tmp_path / "it-ran").exists()


def test_a_bomb_is_not_unpacked(tmp_path: Path) -> None:
    """A small file that unpacks to 400 MB, of which the header claims 64 bytes: the directory tells in time."""
    raw(tmp_path / "grid.npz", "stress", claim((2, 2, 2)) + bytes(4 * 10**8), compression=zipfile.ZIP_DEFLATED)
    assert (tmp_path / "grid.npz").stat().st_size < 1.1e6
    assert told(tmp_path / "grid.npz").code == "E131"


def test_a_directory_that_lies_about_sizes(tmp_path: Path) -> None:
    """The zip says 200 bytes where deflated there are 400 MB: no more than it says is unpacked."""
    raw(tmp_path / "grid.npz", "stress", claim((2, 2, 2)) + bytes(4 * 10**8), compression=zipfile.ZIP_DEFLATED)
    content = (tmp_path / "grid.npz").read_bytes()
    size = len(claim((2, 2, 2)))
    (tmp_path / "grid.npz").write_bytes(
        content.replace(struct.pack("<I", size + 4 * 10**8), struct.pack("<I", size + 64))
    )
    assert told(tmp_path / "grid.npz").code == "E131"


def test_names_that_are_near_are_offered(tmp_path: Path) -> None:
    grid(tmp_path / "grid.npz", others=ONES)
    assert "`grid.npz`" not in told(tmp_path / "gird.npy").hint
    assert f"{tmp_path}/grid.npz" in told(tmp_path / "gird.npz").hint
    assert "no folder" in told(tmp_path / "no" / "grid.npz").message
    missing = told(tmp_path / "grid.npz", "stres")
    assert "`stress`" in missing.hint
    assert "`others`" in missing.hint
    assert told(tmp_path / "grid\0.npz".replace("\0", "\\0")).code == "E130"


def test_the_ending_says_the_kind(tmp_path: Path) -> None:
    for name in ("grid.csv", "grid", "grid.npy"):
        (tmp_path / name).write_text("1,2,3")
        found = told(tmp_path / name)
        assert found.code == "E131"
        assert ".npz" in found.message


def test_a_socket_is_never_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with socket.socket(socket.AF_UNIX) as made:
        made.bind("grid.npz")
        assert "a socket" in told("grid.npz").message


def test_what_may_not_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> int:  # as root may read everything, a mode would not do
        raise PermissionError(13, "Permission denied")

    path = grid(tmp_path / "grid.npz")
    monkeypatch.setattr(os, "open", refuse)
    found = told(path)
    assert found.code == "E130"
    assert "permissions" in found.hint


@pytest.mark.parametrize("change", [lambda p: grid(p, ONES * 2), cut, lambda p: os.utime(p, (1, 1))])
def test_a_file_that_changes_while_it_is_read(
    change: Callable[[Path], object], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = grid(tmp_path / "grid.npz")
    old(path)
    members = npz._members

    def late(*args: Any) -> Any:
        change(path)
        return members(*args)

    monkeypatch.setattr(npz, "_members", late)
    assert "changed while" in told(path).message


def test_a_broken_grid_never_ends_in_a_traceback(tmp_path: Path) -> None:
    """Two hundred files with bytes changed at random: a grid or a diagnostic."""
    good = grid(tmp_path / "grid.npz").read_bytes()
    dice = random.Random(7)
    refused = 0
    for _ in range(200):
        content = bytearray(good)
        for _ in range(dice.randint(1, 8)):
            content[dice.randrange(len(content))] = dice.randrange(256)
        (tmp_path / "grid.npz").write_bytes(content)
        try:
            read_grid(str(tmp_path / "grid.npz"), "stress", SPAN)
        except PoreError:
            refused += 1
    assert refused > 100


def old(path: Path) -> None:
    """Make a file look as if it had been there for a while."""
    before = time.time() - 3600
    os.utime(path, (before, before))


def test_a_file_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As long as it stays the same; what changed just now is not remembered, for it may change within one tick."""
    monkeypatch.setattr(datafile, "_TICK", -1.0)
    path = grid(tmp_path / "grid.npz", other=ONES * 3)
    first = read_grid(str(path), "stress")
    assert read_grid(str(path), "stress") is first
    assert read_grid(str(path), "other").values[0, 0, 0, 0] == 3
    grid(path, ONES * 2)
    assert read_grid(str(path), "stress").values[0, 0, 0, 0] == 2
    monkeypatch.setattr(datafile, "_TICK", 3600.0)
    grid(path, ONES * 4)
    assert read_grid(str(path), "stress") is not read_grid(str(path), "stress")


# -- frames --------------------------------------------------------------------------------------------------------

GOOD: dict[str, Any] = {"nodes": [[0, 0, 0], [10, 0, 0.5], [0, 1e1, 0]], "bars": [[0, 1], [1, 2.0]], "radii": [1, 0.5]}


def test_frame_is_read(tmp_path: Path) -> None:
    path = tmp_path / "truss.json"
    path.write_text(json.dumps({**GOOD, "comment": "[[[]"}), encoding="utf-8-sig")
    found = read_frame(str(path))
    assert found.starts.tolist() == [[0, 0, 0], [10, 0, 0.5]]
    assert found.ends.tolist() == [[10, 0, 0.5], [0, 10, 0]]
    assert found.radii.tolist() == [1, 0.5]
    assert not any(a.flags.writeable for a in (found.starts, found.ends, found.radii))
    path.write_text(json.dumps({**{k: v for k, v in GOOD.items() if k != "radii"}, "radius": 2}))
    assert read_frame(str(path)).radii.tolist() == [2, 2]


def but(**more: Any) -> str:
    return json.dumps({k: v for k, v in {**GOOD, **more}.items() if v is not ...})


FRAMES: dict[str, tuple[str, str | bytes, str]] = {
    "empty": ("E131", "", "no JSON"),
    "no json": ("E131", "nodes: 1", "line 1"),
    "cut": ("E131", but()[:-9], "no JSON"),
    "no text": ("E131", but().encode("utf-16"), "UTF-8"),
    "deep": ("E131", "[" * 10**6, "nested"),
    "deep objects": ("E131", '{"nodes":' * 10**5, "nested"),
    "deep and closed": ("E131", "[" * 50_000 + "]" * 50_000, "nested"),
    "a list": ("E133", "[1, 2]", "a list"),
    "a number": ("E133", "3", "a number"),
    "twice": ("E131", '{"nodes": [], "nodes": []}', "twice"),
    "no nodes": ("E132", but(nodes=...), "no `nodes`"),
    "no bars": ("E132", but(bars=...), "no `bars`"),
    "no radii": ("E132", but(radii=...), "no `radii`"),
    "empty nodes": ("E133", but(nodes=[]), "no nodes"),
    "empty bars": ("E133", but(bars=[], radii=[]), "no bars"),
    "nodes as an object": ("E133", but(nodes={"0": [0, 0, 0]}), "an object"),
    "a node of two": ("E133", but(nodes=[[0, 0, 0], [1, 2], [0, 1, 0]]), "node 1"),
    "a node that is a number": ("E133", but(nodes=[1, 2, 3]), "node 0"),
    "a true": ("E133", but(nodes=[[0, 0, 0], [1, True, 0], [0, 1, 0]]), "true or false"),
    "a text": ("E133", but(nodes=[[0, 0, 0], [1, 0, 0], [0, "1", 0]]), "node 2"),
    "a null": ("E133", but(nodes=[[0, 0, 0], [1, 0, 0], [0, None, 0]]), "null"),
    "a list in a node": ("E133", but(nodes=[[0, 0, 0], [1, 0, [0]], [0, 1, 0]]), "a list"),
    "nan": ("E134", but(nodes=[[0, 0, float("nan")]]), "`NaN`"),
    "infinity": ("E134", but(nodes=[[0, 0, -float("inf")]]), "`-Infinity`"),
    "1e999": ("E134", but().replace("10.0", "1e999"), "node 2"),
    "10^400": ("E134", but(nodes=[[0, 0, 0], [10**400, 0, 0], [0, 1, 0]]), "node 1"),
    "10^9999": ("E134", but().replace("10.0", "1" * 9999), "too long"),
    "far": ("E134", but(nodes=[[0, 0, 0], [1, 0, 0], [0, 100_001, 0]]), "node 2"),
    "a bar of three": ("E133", but(bars=[[0, 1], [0, 1, 2]]), "bar 1"),
    "out of range": ("E136", but(bars=[[0, 1], [1, 3]]), "bar 1 of"),
    "negative": ("E136", but(bars=[[0, -1], [1, 2]]), "the node -1"),
    "not whole": ("E136", but(bars=[[0, 1], [1, 1.5]]), "1.5, which is no whole number"),
    "a huge index": ("E136", but(bars=[[0, 1], [1, 10**400]]), "bar 1 of"),
    "itself": ("E136", but(bars=[[0, 1], [2, 2]]), "bar 1 of `truss.json` joins node 2 with itself"),
    "one place": ("E136", but(nodes=[[0, 0, 1], [1, 0, 0], [0, 0, 1]], bars=[[0, 1], [2, 0]]), "both lie at (0, 0, 1)"),
    "nearly one place": ("E136", but(nodes=[[0, 0, 1], [1, 0, 0], [1e-200, 0, 1]], bars=[[0, 1], [2, 0]]), "bar 1"),
    "zero radius": ("E134", but(radii=[1, 0]), "bar 1"),
    "negative radius": ("E134", but(radii=[-1, 1]), "bar 0"),
    "endless radius": ("E134", but(radii=[1, 10**400]), "bar 1"),
    "a text as radius": ("E133", but(radii=[1, "1"]), "radius 1"),
    "too few radii": ("E133", but(radii=[1]), "2 bars and 1 radii"),
    "radii as a number": ("E133", but(radii=1), "a number"),
    "radius and radii": ("E133", but(radius=1), "both"),
    "radius null": ("E133", but(radii=..., radius=None), "null"),
    "radius zero": ("E134", but(radii=..., radius=0), "bar 0"),
}


@pytest.mark.parametrize("name", FRAMES)
def test_hostile_frame_is_refused(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    code, content, words = FRAMES[name]
    Path("truss.json").write_bytes(content if isinstance(content, bytes) else content.encode())
    found = told("truss.json")
    assert found.code == code
    assert words in found.message


def test_a_near_key_is_offered_and_counting_from_one_is_explained(tmp_path: Path) -> None:
    path = tmp_path / "truss.json"
    path.write_text(but(radii=..., radi=[1, 2]))
    assert "`radi`" in told(path).hint
    path.write_text(but(bars=[[1, 2], [2, 3]]))
    assert "counted from 0" in told(path).hint


def test_a_huge_frame_is_not_read(tmp_path: Path) -> None:
    with (tmp_path / "truss.json").open("wb") as file:
        file.truncate(10**12)  # a file with a hole
    assert told(tmp_path / "truss.json").code == "E135"


def test_nesting_is_counted_before_parsing(tmp_path: Path) -> None:
    """In a process whose recursion limit was raised, the parser of the text alone would run out of stack and die."""
    (tmp_path / "truss.json").write_text("[" * 10**6)
    code = (
        "import sys; sys.setrecursionlimit(10**6)\n"
        "from porelang.tasks.frame import read_frame\n"
        "try: read_frame(sys.argv[1])\nexcept Exception as e: print(e.diagnostics[0].code)"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "truss.json")]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "E131\n"


def test_a_hundred_thousand_bars(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    nodes, count = rng.uniform(-100, 100, (40_000, 3)), 100_000
    first = rng.integers(0, 20_000, count)
    bars = np.stack([first, first + rng.integers(1, 20_000, count)], axis=1)
    radii = rng.uniform(0.1, 1, count)
    path = tmp_path / "truss.json"
    path.write_text(json.dumps({"nodes": nodes.tolist(), "bars": bars.tolist(), "radii": radii.tolist()}))
    found = read_frame(str(path))
    np.testing.assert_array_equal(found.starts, nodes[bars[:, 0]])
    np.testing.assert_array_equal(found.ends, nodes[bars[:, 1]])
    np.testing.assert_array_equal(found.radii, radii)
