"""Meshes for a page to download: made in a folder of their own, which is gone when the page is."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from porelang import values
from porelang.asked import keep_checks, length
from porelang.mesh.export import write, writer_of
from porelang.mesh.made import make
from porelang.mesh.part import notes_of
from porelang.preview.words import on_page
from porelang.program import Design


class Made:
    """The files of one page. `close` removes them."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="pore-view-")

    def mesh(
        self, design: Design, output: str, ending: str, voxel: str = "auto", force: bool = False
    ) -> tuple[str, str]:
        """Mesh an output into a file: its name, and what is in it; with `force` also a mesh that has lost much of the
        part. Errors: those of `pore mesh`."""
        design.program.solid(output)
        name = f"{Path(design.program.source.name).stem}-{output}{ending}"
        writer_of(name)
        keep_checks(design)
        made = make(design, output, length("voxel", voxel, values.spacing), force=force)
        write(made.surface, self.path(name), notes_of(design, output))
        size = os.path.getsize(self.path(name)) / 1e6
        what = f"{len(made.surface.faces):,} triangles, voxel {made.facts['voxel']:.3g} mm, {size:.1f} MB"
        return name, "\n".join([what, *(on_page(d).message for d in made.doubts)])

    def path(self, name: str) -> Path:
        """Where a file of this name is, or would be."""
        return Path(self._folder.name) / os.path.basename(name)

    def close(self) -> None:
        self._folder.cleanup()
