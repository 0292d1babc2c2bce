"""Volumes: values on a grid, read back by others and by `load`."""

from __future__ import annotations

import re
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import porelang
from porelang import volume
from porelang.cli import main
from porelang.volume import write_volume

TEXT = "let s = 2 * x + y\nlet v = grad(s * z)\nout part = gyroid(5) & box([10, 8, 6])\nout rest = s * 1\n"


def read_vti(path: Path) -> tuple[dict[str, NDArray[Any]], NDArray[np.float64], NDArray[np.float64]]:
    """The arrays (x, y, z, components) of a .vti, its origin and its spacing, by the words of its header alone."""
    head, _, tail = path.read_bytes().partition(b'<AppendedData encoding="raw">\n_')
    text = head.decode()

    def numbers(name: str) -> NDArray[np.float64]:
        found = re.search(rf'{name}="([^"]*)"', text)
        assert found is not None
        return np.array(found[1].split(), float)

    counts = (numbers("WholeExtent")[1::2] + 1).astype(int)
    arrays = {}
    for kind, name, count, offset in re.findall(
        r'type="Float(32|64)" Name="([^"]*)" NumberOfComponents="(\d)" format="appended" offset="(\d+)"', text
    ):
        size = int.from_bytes(tail[int(offset) : int(offset) + 8], "little")
        values = np.frombuffer(tail[int(offset) + 8 :][:size], f"<f{int(kind) // 8}")
        arrays[name] = values.reshape(*counts[::-1], int(count)).transpose(2, 1, 0, 3)
    assert tail.endswith(b"</AppendedData>\n</VTKFile>\n")
    return arrays, numbers("Origin"), numbers("Spacing")


def read_npz(path: Path) -> tuple[dict[str, NDArray[Any]], NDArray[np.float64], NDArray[np.float64]]:
    with np.load(path) as file:
        arrays = {k: file[k] for k in file.files if k not in ("origin", "spacing")}
        whole = {k: a if a.ndim == 4 else a[..., None] for k, a in arrays.items()}
        return whole, file["origin"], file["spacing"]


@pytest.mark.parametrize(("ending", "read"), [("vti", read_vti), ("npz", read_npz)])
def test_values_stand_where_they_are(ending: str, read: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(volume, "AT_ONCE", 500)  # several slabs
    program = porelang.compile(TEXT)
    path = tmp_path / f"a.{ending}"
    found = write_volume(program.design(), path, name="part", fields=["s", "v", "s / 2"], voxel=0.5, dtype="f64")
    arrays, origin, spacing = read(path)
    assert (found["nodes"], found["origin"]) == ([23, 19, 15], [-5.5, -4.5, -3.5])  # a voxel more on every side
    np.testing.assert_array_equal(origin, [-5.5, -4.5, -3.5])
    np.testing.assert_array_equal(spacing, [0.5] * 3)
    assert list(arrays) == ["part", "s", "v", "s / 2"]
    axes = [o + 0.5 * np.arange(n) for o, n in zip(origin, found["nodes"], strict=True)]
    x, y, z = np.meshgrid(*axes, indexing="ij")
    at = np.stack([x, y, z], -1)
    part = np.asarray(program.field("part", dtype="f64")(at.reshape(-1, 3))).reshape(x.shape)
    np.testing.assert_allclose(arrays["part"][..., 0], part, atol=1e-12)
    np.testing.assert_allclose(arrays["s"][..., 0], 2 * x + y, atol=1e-12)
    np.testing.assert_allclose(arrays["s / 2"][..., 0], x + y / 2, atol=1e-12)
    np.testing.assert_allclose(arrays["v"], np.stack([2 * z, z, 2 * x + y], -1), atol=1e-12)


@pytest.mark.parametrize("ending", ["vti", "npz"])
def test_what_is_written_can_be_loaded(ending: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.pore").write_text(TEXT)
    asked = ["--out", "part", "--field", "s", "--bounds", "0,0,0,4,3,2", "-q"]
    assert main(["volume", "a.pore", "-o", f"a.{ending}", *asked]) == 0
    program = porelang.compile(f'load("a.{ending}", "s")')
    places = np.random.default_rng(1).uniform((0, 0, 0), (4, 3, 2), (50, 3))
    np.testing.assert_allclose(program.field("part")(places), 2 * places[:, 0] + places[:, 1], atol=1e-5)


def test_memory_goes_with_a_slab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(volume, "AT_ONCE", 2**14)
    design = porelang.compile("x + y * z").design()
    tracemalloc.start()
    write_volume(design, tmp_path / "a.vti", resolution=160, bounds=(0, 0, 0, 1, 1, 1))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert (tmp_path / "a.vti").stat().st_size > 16e6
    assert peak < 6e6


def test_what_cannot_be_written_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.pore").write_text(TEXT)
    for words, told in (
        (["-o", "a.raw"], ".vti or .npz"),
        (["-o", "a.vti", "--voxel", "1um"], "too many"),
        (["-o", "a.vti", "--voxel", "1mm", "--resolution", "9"], "the same thing twice"),
        (["-o", "a.vti", "--field", "nothing"], "nothing"),
        (["-o", "a.pore"], ""),
    ):
        assert main(["volume", "a.pore", "--out", "part", *words]) != 0
        assert told in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["a.pore"]
    assert Path("a.pore").read_text() == TEXT
