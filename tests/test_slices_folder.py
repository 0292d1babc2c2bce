"""The folder of layers: what is not ours stays, and old layers or new ones are there whenever a run is killed."""

from __future__ import annotations

import hashlib
import json
import os
import stat
from pathlib import Path

import pytest

import porelang
from porelang import atomic
from porelang.diagnostics import PoreError
from porelang.slices import folder, write_slices
from porelang.slices.folder import replace_folder

BALL = "sphere(4)\n"
pytestmark = pytest.mark.skipif(os.name != "posix", reason="links, pipes and modes of files")


def names(where: Path) -> list[str]:
    return sorted(os.listdir(where))


def files(where: Path) -> dict[str, bytes]:
    return {p.relative_to(where).as_posix(): p.read_bytes() for p in sorted(where.rglob("*")) if p.is_file()}


@pytest.fixture
def layers(tmp_path: Path) -> Path:
    """A folder of layers, alone in its folder."""
    write_slices(porelang.compile(BALL).design(), tmp_path / "layers", 2)
    return tmp_path / "layers"


def again(folder: Path) -> None:
    write_slices(porelang.compile("sphere(3)").design(), folder, 1)


def kept(folder: Path, names_it: str) -> None:
    """The folder is refused for what is in it, and stays as it is."""
    before, beside = files(folder), names(folder.parent)
    with pytest.raises(PoreError, match="E113") as caught:
        again(folder)
    assert names_it in str(caught.value)
    assert files(folder) == before
    assert names(folder.parent) == beside


def test_a_folder_with_anything_else_in_it_is_left_alone(layers: Path) -> None:
    (layers / "photo.jpg").write_bytes(b"dear")
    kept(layers, "photo.jpg")
    (layers / "photo.jpg").unlink()
    (layers / "more").mkdir()
    kept(layers, "more")
    (layers / "more").rmdir()
    (layers / "layer_9999.png").write_bytes(b"mine")  # like ours, but not listed
    kept(layers, "layer_9999.png")
    (layers / "layer_9999.png").unlink()
    (layers / "layer_0001.png").unlink()
    (layers / "layer_0001.png").symlink_to(layers / "layer_0002.png")
    kept(layers, "layer_0001.png")
    (layers / "layer_0001.png").unlink()
    (layers / "layer_0001.png").write_bytes(b"a photograph")  # of somebody who did not know what the folder is
    with pytest.raises(PoreError, match=r"`layer_0001.png` in .* was changed after it was written"):
        again(layers)
    assert (layers / "layer_0001.png").read_bytes() == b"a photograph"
    (layers / "layer_0001.png").unlink()  # a layer that is missing is no hindrance
    again(layers)
    assert json.loads((layers / "layers.json").read_text())["layers"] == 6
    assert names(layers.parent) == ["layers"]


@pytest.mark.parametrize(
    "manifest",
    [
        b'{"layers": 1, "format": "png", "files": ["photo.jpg"], "sha256": [""]}',
        b'{"layers": 1, "format": "png", "files": ["../photo.jpg"], "sha256": [""]}',
        b'{"layers": 2, "format": "png", "files": ["layer_0000.png"], "sha256": [""]}',
        b'{"layers": 1, "format": "png", "files": ["layer_0000.png"], "sha256": []}',
        b'{"layers": 1, "format": "png", "files": ["layer_0000.png"], "sha256": [null]}',
        b'{"layers": 1, "format": "png", "files": ["layer_0000.png"]}',
        b'{"layers": 1, "format": "svg", "files": ["layer_0000.png"], "sha256": [""]}',
        b'{"layers": 1, "format": "png", "files": "layer_0000.png", "sha256": [""]}',
        b'{"layers": 1, "format": "png", "files": [["layer_0000.png"]], "sha256": [""]}',
        b'["layer_0000.png"]',
        b"[" * 100_000,
        b"\xff\xfe",
        b"",
    ],
)
def test_a_manifest_that_is_not_ours_lists_nothing(manifest: bytes, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "layers.json").write_bytes(manifest)
    kept(folder, "layers.json")  # of another program
    (folder / "photo.jpg").write_bytes(b"dear")
    (folder / "layer_0000.png").write_bytes(b"mine")
    (tmp_path / "photo.jpg").write_bytes(b"dear")
    kept(folder, "layer_0000.png")


def test_a_manifest_that_is_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "folder" / "layers.json")
    with pytest.raises(PoreError, match="holds other things"):
        again(tmp_path / "folder")


def photographed(layers: Path) -> None:
    with replace_folder(layers) as draft:
        (draft / "layer_0000.png").write_bytes(b"new")
        (layers / "photo.jpg").write_bytes(b"dear")


def test_what_comes_into_the_folder_while_layers_are_made_is_not_lost(layers: Path) -> None:
    before = files(layers)
    with pytest.raises(PoreError, match=r"photo\.jpg"):
        photographed(layers)
    assert files(layers) == {**before, "photo.jpg": b"dear"}
    assert names(layers.parent) == ["layers"]


def test_folders_that_cannot_be_renamed_or_were_made_read_only_are_refused(
    layers: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = files(layers)
    monkeypatch.chdir(layers)
    for name in (".", "../layers", "..", "/", "/proc"):
        with pytest.raises(PoreError, match="E113"):
            again(Path(name))
    monkeypatch.chdir(layers.parent)
    layers.chmod(0o555)
    with pytest.raises(PoreError, match="read-only"):
        again(layers)
    layers.chmod(0o755)
    (layers / "layer_0002.png").chmod(0o444)
    with pytest.raises(PoreError, match=r"layer_0002\.png.*read-only"):
        again(layers)
    assert files(layers) == before
    assert names(layers.parent) == ["layers"]


def test_a_link_to_a_folder_stays(layers: Path) -> None:
    link = layers.parent / "link"
    link.symlink_to("layers")
    layers.chmod(0o750)
    again(link)
    assert link.is_symlink()
    assert len(files(layers)) == 7
    assert stat.S_IMODE(layers.stat().st_mode) == 0o750
    new = layers.parent / "to come"
    link.unlink()
    link.symlink_to("to come")
    again(link)
    assert len(files(new)) == 7
    assert names(layers.parent) == ["layers", "link", "to come"]


@pytest.mark.parametrize("name", ["x" * 225, "x" * 255, "\N{GREEK SMALL LETTER PI}" * 127])
def test_names_may_be_as_long_as_the_system_lets_them(name: str, tmp_path: Path) -> None:
    for _ in range(2):
        again(tmp_path / name)
        assert names(tmp_path) == [name]
    with pytest.raises(PoreError, match="too long"):
        again(tmp_path / (name * 2))


class Killed(BaseException):
    """Nothing after it runs: the process is gone."""


def steps(monkeypatch: pytest.MonkeyPatch, at: int) -> None:
    """Kill the process before its `at`-th change of the file system from now on."""
    count = 0

    def counted(name: str) -> None:
        real = getattr(os, name)

        def change(*given: object, **more: object) -> object:
            nonlocal count
            count += 1
            if count > at:  # nor does anything that would clean up
                raise Killed
            return real(*given, **more)

        monkeypatch.setattr(os, name, change)

    for name in ("rename", "unlink", "rmdir", "chmod", "chown"):
        counted(name)


def test_old_layers_or_new_ones_are_there_after_a_kill_at_any_moment(layers: Path) -> None:
    """And the next run leaves nothing of the one that was killed but its draft, which it cannot know to be dead."""
    old = files(layers)
    for at in range(40):
        with pytest.MonkeyPatch.context() as patch:
            try:
                with replace_folder(layers) as draft:
                    for k in range(3):
                        (draft / f"layer_000{k}.png").write_bytes(b"new")
                    listed = sorted(files(draft))
                    digests = [hashlib.sha256(b"new").hexdigest()] * 3
                    manifest = {"layers": 3, "format": "png", "files": listed, "sha256": digests}
                    new = {**files(draft), "layers.json": json.dumps(manifest).encode()}
                    (draft / "layers.json").write_bytes(new["layers.json"])
                    steps(patch, at)
            except Killed:
                atomic._pending.clear()
            else:
                assert files(layers) == new
                assert at > 5
                return
        whole = [f for f in map(files, layers.parent.iterdir()) if f in (old, new)]
        assert whole
        if layers.exists():
            assert files(layers) in (old, new)
        with pytest.raises(KeyboardInterrupt), replace_folder(layers):
            raise KeyboardInterrupt
        assert files(layers) in (old, new)
        for left in layers.parent.glob(".pore-*.layers"):
            for file in left.iterdir():
                file.unlink()
            left.rmdir()
        assert names(layers.parent) == ["layers"]
        write_slices(porelang.compile(BALL).design(), layers, 2)
        assert files(layers) == old
    pytest.fail("it never came to an end")


def test_what_lies_where_old_layers_are_put_aside_is_not_touched(layers: Path) -> None:
    aside = folder._aside(layers)
    precious = layers.parent / "precious"
    write_slices(porelang.compile(BALL).design(), precious, 2)
    aside.symlink_to("precious")
    before = files(precious)
    with pytest.raises(PoreError, match="in the way"):
        again(layers)
    aside.unlink()
    aside.mkdir()
    (aside / "photo.jpg").write_bytes(b"dear")
    with pytest.raises(PoreError, match="in the way"):
        again(layers)
    assert files(precious) == before
    assert (aside / "photo.jpg").read_bytes() == b"dear"
