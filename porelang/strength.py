"""The studies of a design in elements: what is solved for a study of its program, as a result to look at and to write.

What a program reads of a study are samples, found by the same solve (`porelang.tasks.study`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from porelang.data import Reduced
from porelang.diagnostics import Diagnostic, PoreError, fail, suggest
from porelang.formula import Formula
from porelang.ir import Node, node
from porelang.measure import envelope_of
from porelang.ops.studies import NUMBERS
from porelang.program import Design
from porelang.source import Span
from porelang.tasks.study import question, solid_of
from porelang.tasks.study.solved import Solved, refined, solved
from porelang.tasks.study.got import told
from porelang.tasks.telling import Told
