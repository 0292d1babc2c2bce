"""The phase of a lattice whose cells have the size that a field says: found on a grid, measured, kept as samples."""
