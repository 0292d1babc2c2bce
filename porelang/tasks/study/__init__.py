"""Studies: a part as elements, what holds and loads it, its stresses and displacements, and these as samples."""
