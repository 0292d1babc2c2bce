"""Meshes as shapes: the signed distance to the surface of a file, measured in a process of its own, kept as samples."""

from __future__ import annotations

from porelang.tasks.shape.ask import corners_of, look_at_shape, read_shape
from porelang.tasks.shape.found import Found, told_of

__all__ = ["Found", "corners_of", "look_at_shape", "read_shape", "told_of"]
