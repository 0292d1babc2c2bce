"""3MF beyond triangles: the field itself as a graph of functions, and bars as bars, in their packages."""
