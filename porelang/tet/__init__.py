"""A part to tetrahedra, straight from its field."""
