"""Files that appear whole or not at all, and only where a regular file is or can be.

What is written has another name in the same folder until it is complete. Devices, pipes, sockets and folders are never
replaced, nor is a file that its owner has made read-only; a link stays, and the file that it names is replaced. Another
name of that file (a hard link) keeps the old content.
"""

from __future__ import annotations

import atexit
import errno
import os
import secrets
import stat
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from porelang.diagnostics import PoreError, fail
from porelang.limits import no_memory

_KINDS = (
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
)
#: What unfinished blocks still have to undo, with the process that has to do it.
_pending: dict[object, tuple[int, Callable[[], None]]] = {}


def destination(path: str | Path, reads: Iterable[str | Path] = ()) -> Path:
    """The regular file that output to `path` makes or replaces: `path` without links.

    Errors: E113 for what is there and no such file, for a file or folder that is read-only, for no folder at all, and
    for a file that what is written is made from, by whatever name: one of those that are read.
    """
    target, found = followed(path)
    for source in reads:
        if _is_same(found, source):
            raise fail("E113", f"cannot write {path}: it is `{source}`, which is read for it",
                       hint="choose another name")  # fmt: skip
    if found is not None and stat.S_ISDIR(found.st_mode):
        raise fail("E113", f"cannot write {path}: it is a folder", hint=f"name a file: {Path(path) / 'part.stl'}")
    if found is not None and not stat.S_ISREG(found.st_mode):
        kind = next((name for is_one, name in _KINDS if is_one(found.st_mode)), "no file")
        raise fail("E113", f"cannot write {path}: it is {kind}, and output goes to files",
                   hint="name a new file, or one to be replaced")  # fmt: skip
    if not target.parent.is_dir():
        raise fail("E113", f"cannot write {path}: there is no folder {target.parent}",
                   hint=f"make it first: mkdir -p {target.parent}")  # fmt: skip
    if found is not None and read_only(found, target):
        raise fail("E113", f"cannot write {path}: it is read-only",
                   hint=f"choose another name, or make it writable: chmod u+w {target}")  # fmt: skip
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise fail("E113", f"cannot write {path}: the folder {target.parent} is read-only",
                   hint="choose a folder that you may write to")  # fmt: skip
    return target


def _is_same(found: os.stat_result | None, path: str | Path) -> bool:
    try:
        return found is not None and os.path.samestat(found, os.stat(path))
    except (OSError, ValueError):  # a program may come from no file
        return False


def followed(path: str | Path) -> tuple[Path, os.stat_result | None]:
    """A path without links, and what is there, if anything is.

    Errors: E113 where the system does not let us look, for an empty name, and for one that leads through a folder that
    is not there to something that is: `nowhere/..` is no name of this folder.
    """
    if not os.fspath(path):
        raise fail("E113", "nothing is named to be written", hint="name a file or a folder: -o part.stl")
    try:
        target = Path(os.path.realpath(path))
        return target, os.stat(path)
    except FileNotFoundError as error:
        if error.filename is None:  # the current folder has been deleted
            raise unwritable(path, error) from None
        if os.path.lexists(target):
            raise unwritable(path, error) from None
        return target, None
    except (OSError, ValueError) as error:  # the latter for a NUL in the name
        raise unwritable(path, error) from None


def read_only(found: os.stat_result, path: Path) -> bool:
    """Whether a file or folder was made read-only, which root is held to as well, or belongs to somebody else."""
    return not found.st_mode & stat.S_IWUSR or not os.access(path, os.W_OK)


@contextmanager
def replace_path(path: str | Path) -> Iterator[Path]:
    """The name of a file to be made, for those who take names: it takes its place at the end of the block, and is gone
    if the block fails. It is in the same folder, and has no ending.

    Owner and permissions of a file that is replaced are kept where the system lets us. Errors: E113.
    """
    target = destination(path)
    try:
        with draft_in(target.parent) as draft:
            yield draft
            with open(draft, "rb") as made:
                os.fsync(made.fileno())
            if target.exists():
                keep_owner(target, draft)
            os.replace(draft, target)
    except OSError as error:
        raise unwritable(path, error) from error


@contextmanager
def replace_file(path: str | Path) -> Iterator[BinaryIO]:
    """A file to write to, which takes its place at the end of the block, as that of `replace_path`. Errors: E113."""
    with replace_path(path) as draft, open(draft, "xb") as file:
        yield file


def save(path: str | Path, write_to: Callable[[BinaryIO], None]) -> None:
    """Have `write_to` write a file, whole or not at all. Errors: E113."""
    with replace_file(path) as file:
        write_to(file)


@contextmanager
def draft_in(folder: Path, ending: str = "part") -> Iterator[Path]:
    """A name in a folder for what is not complete yet; a file that still has it after the block is deleted."""
    draft = folder / unused_name(ending)
    with undone(lambda: draft.unlink(missing_ok=True)):
        yield draft


def unused_name(ending: str) -> str:
    """A hidden name that nobody else has, and short: that of the target may itself be as long as names can be."""
    return f".pore-{secrets.token_hex(8)}.{ending}"


@contextmanager
def undone(undo: Callable[[], None]) -> Iterator[None]:
    """Call `undo` after the block, however it ends; it must do no harm when it is called twice.

    An interruption may fall into the undoing itself: then it is done when the process ends.
    """
    key = object()
    _pending[key] = os.getpid(), undo
    try:
        yield
    finally:
        undo()
        del _pending[key]


@atexit.register
def _undo_the_rest() -> None:
    for owner, undo in list(_pending.values()):
        if owner == os.getpid():  # a process that was forked inside of a block leaves it to its parent
            with suppress(OSError):
                undo()


def keep_owner(old: Path, new: Path) -> None:
    """Give a file or folder the owner and the permissions of the one that it replaces, as far as the system allows."""
    found = os.stat(old)
    with suppress(OSError, AttributeError):  # only root may give files away, and Windows knows no such owners
        os.chown(new, found.st_uid, found.st_gid)
    with suppress(OSError):
        os.chmod(new, found.st_mode & 0o777)


#: What to do about a reason that the system gives, where it is not to choose another folder.
_WAYS_OUT = {
    errno.ENAMETOOLONG: "choose a shorter name: most systems take 255 letters",
    errno.ENOSPC: "make room there, or choose another folder",
    errno.EFBIG: "this disk, or `ulimit -f`, allows no larger files: make it coarser, or choose another folder",
    errno.EROFS: "choose a folder on a disk that can be written to",
    errno.ENOENT: "check the path: a folder in it is not there",
    errno.ENOTDIR: "check the path: what is named as a folder in it is a file",
    errno.EAGAIN: "another process is writing there: try again when it has ended",
    errno.ELOOP: "check the path: its links lead in a ring",
    errno.EMFILE: "close some files first, or raise their number: ulimit -n 1024",
    getattr(errno, "EDQUOT", -1): "make room in your quota, or choose another folder",
}


def unwritable(path: str | Path, error: OSError | ValueError) -> PoreError:
    """E113 for a reason that the system gives; E124 where that is want of memory."""
    number = getattr(error, "errno", None)
    if number == errno.ENOMEM:
        return PoreError(no_memory())
    reason = (getattr(error, "strerror", None) or str(error)).lower()
    hint = _WAYS_OUT.get(number or 0, "choose a folder with room that you may write to")
    return fail("E113", f"cannot write {path}: {reason}", hint=hint)
