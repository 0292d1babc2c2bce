"""The folder of layers: replaced as a whole, and only if every file in it is one that we have written, as we have.

A new folder is filled under a hidden name. Then the old one is renamed aside, the new one renamed in, and the old one's
files are deleted one by one. A run that is killed in between leaves the old layers whole under their hidden name: the
next run to the same place finds them and puts them back before it begins.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import stat
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from porelang.atomic import followed, keep_owner, read_only, undone, unused_name, unwritable
from porelang.diagnostics import fail

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]  # a module, or none

MANIFEST = "layers.json"
PATIENCE = 20.0  # seconds to wait for another process that renames a folder beside
_LARGEST = 1 << 28  # bytes of a manifest: more than a million layers take a third of it
_NEW = "name a new folder, or an older one of layers"


@contextmanager
def replace_folder(path: str | Path) -> Iterator[Path]:
    """A folder to be filled, which takes the place of `path` at the end of the block, and is gone if the block fails.

    What the block writes are layers and their manifest. Errors: E113 as in `layers_folder`, also where something came
    into the old folder in the meantime.
    """
    target = layers_folder(path)
    draft, aside = target.with_name(unused_name("layers")), _aside(target)
    try:
        with undone(lambda: _tidy(target, draft)):
            _tidy(target, draft)
            layers_folder(path)
            if _is_stranger(target):
                hint = "a run that was stopped left it, and something was added: move it elsewhere"
                raise fail("E113", f"cannot write `{path}`: `{aside}` is in the way", hint=hint)
            draft.mkdir()
            yield draft
            with _turn(target.parent):
                _settle(target)
                _replaceable(path)
                if target.exists():
                    keep_owner(target, draft)
                    os.rename(target, aside)
                os.rename(draft, target)
                _settle(target)
                left = os.path.lexists(aside)
    except OSError as error:
        raise unwritable(path, error) from error
    if left:
        raise fail("E113", f"`{path}` is written, and what came into the old folder meanwhile is kept in `{aside}`",
                   hint="move it elsewhere")  # fmt: skip


def _is_stranger(target: Path) -> bool:
    """Whether something lies where the old folder is put aside that is not to be deleted."""
    with _turn(target.parent):
        _settle(target)
        return os.path.lexists(_aside(target))


def layers_folder(path: str | Path) -> Path:
    """The folder that layers written to `path` make or replace: `path` without links. What is refused is untouched.

    Errors: E113 for a file, for a folder that holds anything but layers of ours, for one that is read-only, that this
    process works in, or that is a disk of its own, and where there is no folder to make one in.
    """
    try:
        with _turn(followed(path)[0].parent):  # or another process puts its own in place while we look into the old one
            return _replaceable(path)
    except OSError as error:
        raise unwritable(path, error) from error


def _replaceable(path: str | Path) -> Path:
    """What `layers_folder` says, for one whose turn it is."""
    target, found = followed(path)
    if found is not None and not stat.S_ISDIR(found.st_mode):
        raise fail("E113", f"`{path}` is a file, and layers need a folder", hint="name a new folder")
    if not target.parent.is_dir():
        raise fail("E113", f"cannot write `{path}`: its folder does not exist", hint=f"mkdir -p {target.parent}")
    if found is not None:
        here = Path(os.path.realpath(os.getcwd()))
        if here.is_relative_to(target) or os.path.ismount(target):
            what = "this process works in it" if here.is_relative_to(target) else "it is a disk of its own"
            raise fail("E113", f"the folder `{path}` cannot be replaced: {what}",
                       hint=f"name a folder in it: {Path(path) / 'layers'}")  # fmt: skip
        _refuse_others(path, target)
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise fail("E113", f"cannot write `{path}`: the folder {target.parent} is read-only",
                   hint="choose a folder that you may write to")  # fmt: skip
    return target


def _refuse_others(path: str | Path, folder: Path) -> None:
    """Refuse a folder that holds anything but what its manifest lists, or that was made read-only. Errors: E113."""
    try:
        if read_only(os.stat(folder), folder):
            raise fail("E113", f"the folder `{path}` is read-only", hint="name a new folder")
        digests = _listed(folder)
        ours = set(digests)
        with os.scandir(folder) as entries:
            found = sorted(entries, key=lambda e: e.name)
        others = [e.name for e in found if e.name not in ours or not e.is_file(follow_symlinks=False)]
        if others:
            more = f" and {len(others) - 1} more" if len(others) > 1 else ""
            raise fail("E113", f"the folder `{path}` holds other things than layers: `{others[0]}`{more}", hint=_NEW)
        changed = next((e.name for e in found if not _is_as_listed(folder, e.name, digests)), None)
        if changed is not None:
            raise fail("E113", f"`{changed}` in the folder `{path}` was changed after it was written", hint=_NEW)
        kept = [e.name for e in found if not e.stat(follow_symlinks=False).st_mode & stat.S_IWUSR]
        if kept:
            raise fail("E113", f"`{kept[0]}` in the folder `{path}` is read-only", hint="name a new folder")
    except OSError as error:
        raise unwritable(path, error) from None


def _listed(folder: Path) -> dict[str, str]:
    """The files that a folder's manifest lists, with their SHA-256, and last the manifest with none; none at all where
    there is no manifest, or one not of ours."""
    manifest = folder / MANIFEST
    try:
        found = os.lstat(manifest)
        if not stat.S_ISREG(found.st_mode) or found.st_size > _LARGEST:
            return {}
        files = _files(json.loads(manifest.read_bytes()))
    except (OSError, ValueError, RecursionError):
        return {}
    return files | {MANIFEST: ""} if files else {}


def _files(manifest: Any) -> dict[str, str]:
    """The files in a manifest: `layer_0007.png` and its like, as many as there are layers. Paths are none of ours."""
    match manifest:
        case {"layers": int(count), "format": "png" | "svg" as form, "files": list(files), "sha256": list(digests)}:
            plain = re.compile(rf"layer_[0-9]{{4,}}\.{form}")
            texts = all(isinstance(text, str) for text in (*files, *digests))
            if texts and len(files) == len(digests) == count and all(map(plain.fullmatch, files)):
                return dict(zip(files, digests, strict=True))
    return {}


def _is_as_listed(folder: Path, name: str, digests: Mapping[str, str]) -> bool:
    """Whether a file is what was written: of the manifest itself nobody knows."""
    return name == MANIFEST or digest_of(folder / name) == digests[name]


def digest_of(path: Path) -> str:
    """The SHA-256 of a file's content."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _aside(target: Path) -> Path:
    """Where the old folder is while the new one takes its place: a short name that the next run finds again."""
    return target.with_name(f".pore-{hashlib.sha256(os.fsencode(target.name)).hexdigest()[:16]}.old")


def _tidy(target: Path, draft: Path) -> None:
    """Put the old folder back where there is no new one, else delete its layers; delete what was drafted."""
    if os.path.lexists(_aside(target)):
        with _turn(target.parent):
            _settle(target)
    if draft.is_dir():
        _remove(draft, os.listdir(draft))


def _settle(target: Path) -> None:
    """The old folder, if it is aside, back where there is no new one, else deleted; in this process's turn."""
    aside = _aside(target)
    if aside.is_dir() and not aside.is_symlink():
        if target.exists():
            _remove(aside, list(_listed(aside)))
        else:
            os.rename(aside, target)


@contextmanager
def _turn(folder: Path) -> Iterator[None]:
    """While this lasts no other process of ours renames in a folder: between two renames its layers have no name.

    The lock is on the folder itself, so that nothing is left of it. Where a file system knows no locks there is none.
    """
    if fcntl is None:
        yield
        return
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError:  # it is gone, or may not be looked into: what is done in it will say so
        yield
        return
    try:
        last = time.monotonic() + PATIENCE
        while True:
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                if time.monotonic() > last:
                    raise
                time.sleep(0.01)
            except OSError:
                break
        yield
    finally:
        os.close(handle)


def _remove(folder: Path, names: list[str]) -> None:
    """Delete these files of a folder, and then the folder, unless something else is in it."""
    for name in names:
        (folder / name).unlink(missing_ok=True)
    with suppress(OSError):
        folder.rmdir()
