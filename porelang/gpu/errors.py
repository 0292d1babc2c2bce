"""What can go wrong with OpenGL, in words that a user can act on."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from porelang.limits import memory_limit


class GpuMissing(Exception):  # noqa: N818 - says what is the case, as FileNotFound does
    """This machine has no OpenGL 4.3; `reason` says what was tried and `install` is the command that brings it."""

    def __init__(self, reason: str, install: str) -> None:
        self.reason, self.install = reason, install
        super().__init__(f"{reason}; {install}" if install else reason)

    def __reduce__(self) -> tuple[type[GpuMissing], tuple[str, str]]:
        return GpuMissing, (self.reason, self.install)


class GpuEnded(GpuMissing):
    """There is a driver, but its process was ended before it answered: nothing has to be installed."""

    def __reduce__(self) -> tuple[type[GpuEnded], tuple[str, str]]:
        return GpuEnded, (self.reason, self.install)


class GpuFailed(Exception):  # noqa: N818
    """A shader could not be compiled or run; `reason` says why and `log` is what the driver said about it.

    `ended` says that the driver's process was ended from outside, or by its own crash.
    """

    def __init__(self, reason: str, log: str = "", ended: bool = False) -> None:
        self.reason, self.log, self.ended = reason, log.strip(), ended
        super().__init__(f"{reason}\n{self.log}" if self.log else reason)

    def __reduce__(self) -> tuple[type[GpuFailed], tuple[str, str, bool]]:
        return GpuFailed, (self.reason, self.log, self.ended)


def way_out_of_an_end() -> str:
    """What to do where the driver's process was ended."""
    if memory_limit() is not None:
        return "allow it more memory, as with `ulimit -v unlimited`, or use NumPy: --backend numpy"
    return "try again, with more memory free; NumPy needs no driver: --backend numpy"


def install_command(driver: str = "auto") -> str:
    """The command that brings software OpenGL to this system, or a sentence where there is none."""
    if sys.platform == "darwin":
        return "compute shaders do not exist on macOS: nothing to install, NumPy is used instead"
    if sys.platform != "linux":
        return "OpenGL through EGL or OSMesa is for Linux: nothing to install, NumPy is used instead"
    family = _distribution()
    sudo = "" if os.geteuid() == 0 else "sudo "
    if family & {"debian", "ubuntu"}:
        return f"{sudo}apt-get install " + ("libosmesa6" if driver == "osmesa" else "libegl1 libgl1")
    if family & {"fedora", "rhel", "centos"}:
        return f"{sudo}dnf install " + ("mesa-libOSMesa" if driver == "osmesa" else "mesa-libEGL mesa-dri-drivers")
    if "arch" in family:
        return f"{sudo}pacman -S mesa"
    if "alpine" in family:
        return f"{sudo}apk add mesa-egl mesa-dri-gallium"
    return "install Mesa's EGL library (libEGL.so.1) and its software driver with the package manager of this system"


def _distribution() -> set[str]:
    """The name of this Linux system and those it derives from, as /etc/os-release has them."""
    try:
        lines = Path("/etc/os-release").read_text(encoding="utf-8").splitlines()
    except OSError:
        return set()
    facts = dict(line.split("=", 1) for line in lines if "=" in line)
    return set(f"{facts.get('ID', '')} {facts.get('ID_LIKE', '')}".replace('"', "").lower().split())
