"""What the task of a study finds: its fields as samples, with what is known of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from porelang.data import SampledField
from porelang.formula import Formula
from porelang.ops.studies import NUMBERS
from porelang.progress import activity
from porelang.tasks.study.asked import question
from porelang.tasks.study.got import Got, told
from porelang.tasks.study.numbers import form_error, shared_error
from porelang.tasks.study.samples import sampled
from porelang.tasks.study.solved import Solved, solved
from porelang.tasks.told import Doubt


def found(asked: Formula) -> SampledField:
    """The samples of a study, of the arguments of its task. Errors: those of `solved`."""
    return kept(solved(question(asked)))


def kept(study: Solved) -> SampledField:
    """The samples of a study that is solved."""
    fields = study.fields
    values = np.column_stack([fields.von_mises, fields.energy, fields.displacement, fields.stress, fields.strain])
    with activity("sampling a study"):
        samples, voxel, off = sampled(fields.mesh, values)
    return _known(study, samples, voxel, off)


def doubts_of(study: Solved) -> tuple[Doubt, ...]:
    """What is doubtful of a study that is solved, whoever reads it: of its samples nothing is said."""
    none = SampledField.from_array(np.zeros((2, 2, 2)), (0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    return told(_known(study, none, 0.0, 0.0)).doubts


def _known(study: Solved, samples: SampledField, voxel: float, off: float) -> SampledField:
    """Samples, with what is known of their study."""
    wall, missed = study.sized.wall, study.missed
    x, y, z = (0.0, 0.0, 0.0) if wall is None else map(float, wall.at)
    got = Got(
        len(study.mesh.tets), study.unknowns, study.iterations, study.residual, study.sized.size,
        study.sized.wanted, 0.0 if wall is None else wall.wall, x, y, z, study.lost, study.pieces, voxel, off,
        form_error(missed), missed.lacking, missed.beyond, missed.handles, missed.of, *missed.at,
        shared_error(study.shared), *study.seam,
        tuple(study.numbers[name].value for name in NUMBERS), tuple(study.numbers[name].error for name in NUMBERS),
    )  # fmt: skip
    return replace(samples, facts=got.facts)
