"""The tools that people would use instead, each in an environment of its own under `.peers` (`make bench-peers`)."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import venv
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from porelang.mesh import Surface

HERE = Path(__file__).parent
ENVIRONMENTS = HERE.parent.parent / ".peers"


@dataclass(frozen=True)
class Peer:
    """A script beside this file, what it needs from PyPI (nothing: it runs in our own environment), and its rounds: one
    that takes half a minute is not run as often as one that takes a tenth of a second."""

    script: str
    title: str
    packages: tuple[str, ...] = ()
    rounds: int = 100

    @property
    def python(self) -> Path:
        return ENVIRONMENTS / self.script / "bin" / "python" if self.packages else Path(sys.executable)


PEERS = (
    Peer("porelang_mesh", "porelang, file to mesh"),
    Peer("vtk_by_hand", "NumPy by hand + VTK flying edges", ("numpy", "vtk")),
    Peer("scikit_image_by_hand", "NumPy by hand + scikit-image", ("numpy", "scikit-image")),
    Peer("porespy_region", "PoreSpy, voxels", ("porespy",), 3),
    Peer("microgen_infill", "microgen", ("microgen",), 1),
)
#: What makes tetrahedra: its script answers once.
TPMSLAB = Peer("tpmslab_block", "tpmslab", ("tpmslab",), 1)


def install() -> None:
    """Make the environments that are not there yet."""
    for peer in (*PEERS, TPMSLAB):
        if not peer.packages or peer.python.exists():
            continue
        print(f"== {peer.python.parent.parent.name}: {', '.join(peer.packages)}", flush=True)
        venv.create(peer.python.parent.parent, with_pip=True)
        command = [str(peer.python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *peer.packages]
        if subprocess.run(command).returncode:
            raise SystemExit(f"{', '.join(peer.packages)} cannot be installed here")


class Running:
    """A peer's process, waiting for its turn; `versions` of its packages, and the surface that it makes."""

    def __init__(self, peer: Peer) -> None:
        self.peer = peer
        with tempfile.TemporaryDirectory() as folder:
            made = Path(folder) / "mesh.npz"
            self.process = subprocess.Popen(
                [str(peer.python), str(HERE / "serve.py"), peer.script, str(made)],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            )  # fmt: skip
            self.versions = self._answer()["versions"]
            with np.load(made) as arrays:
                self.surface = Surface(arrays["vertices"].astype(np.float64), arrays["faces"].astype(np.int32))

    def run(self) -> dict[str, float]:
        """Wall and CPU seconds of one more run."""
        assert self.process.stdin
        self.process.stdin.write("again\n")
        self.process.stdin.flush()
        return self._answer()

    def end(self) -> None:
        self.process.communicate()

    def _answer(self) -> Any:
        assert self.process.stdout
        line = self.process.stdout.readline()
        if not line:
            _, error = self.process.communicate()
            raise SystemExit(f"{self.peer.title} failed:\n{error}")
        return json.loads(line)
