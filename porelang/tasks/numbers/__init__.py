"""Numbers found from whole fields, before the fields that need them: porosities, volumes, extremes, solutions.

Each comes with an error that holds: a proven gap for extremes, three standard deviations of a randomised estimate for
what is integrated. Each is a function of formulas: what a number depends on has been found and bound before.
"""
