"""A period of a lattice, as voxels, and what all of it does: stiffness and conductivity."""
