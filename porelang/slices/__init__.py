"""Layers for printing, straight from the field.

`stack` is which layers there are and computes them piece by piece, `outline` finds the contours of one, `write` puts
them into a folder, or into one file (`layer_interface`).
"""

from porelang.slices.folder import MANIFEST
from porelang.slices.stack import Format, Stack, stack_of
from porelang.slices.write import SLICING, write_layer_file, write_slices

__all__ = ["MANIFEST", "SLICING", "Format", "Stack", "stack_of", "write_layer_file", "write_slices"]
