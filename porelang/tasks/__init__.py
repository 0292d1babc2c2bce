"""What is computed before a field: found when a root reads it, known by its content, kept.

`resolve` finds what roots read, `identity` says when two questions are the same one, `run` is what computes each row of
the table of tasks (`porelang.ops.tasks`): `numbers/` from whole fields, `bake` a field into samples, `load` and `frame`
from files.
"""

from porelang.tasks.resolve import Places, all_read, bind_files, bind_tasks, find, look

__all__ = ["Places", "all_read", "bind_files", "bind_tasks", "find", "look"]
