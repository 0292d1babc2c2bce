"""From samples of a field to a sound mesh in a file; this storey knows nothing of the language."""

from porelang.mesh.export import write
from porelang.mesh.extract import extract
from porelang.mesh.grid import Grid
from porelang.mesh.surface import Surface

__all__ = ["Grid", "Surface", "extract", "write"]
