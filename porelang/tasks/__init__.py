"""What is computed before a field: found when a root reads it, known by its content, kept.

`resolve` finds what roots read, `identity` says when two questions are the same one, `run` is what computes each row of
the table of tasks (`porelang.ops.tasks`): `numbers/` from whole fields, `bake` a field into samples, `load` and `frame`
from files.

Nothing is imported here: children that measure need no part of the language.
"""
