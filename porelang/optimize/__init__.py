"""The loop from stress back to geometry: solve, map what is borne to a density, restore the porosity, again."""
