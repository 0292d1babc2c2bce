"""What the task of a study finds: its fields as samples, with what is known of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from porelang.data import SampledField
from porelang.formula import Formula
from porelang.ir import Stage
from porelang.ops.studies import NUMBERS
from porelang.progress import activity
from porelang.tasks.study.asked import question
from porelang.tasks.study.doubts import told
from porelang.tasks.study.got import Got
from porelang.tasks.study.numbers import form_error, shared_error
from porelang.tasks.study.samples import sampled
from porelang.tasks.study.solved import Solved, solved
from porelang.tasks.told import Doubt
from porelang.tet.gap import Gap
from porelang.tet.tetmesh import volumes

#: Elements beside a place that are looked at for their size.
_NEAR = 16


def found(asked: Formula) -> SampledField:
    """The samples of a study, of the arguments of its task. Errors: those of `solved`."""
    return kept(solved(question(asked)))


def kept(study: Solved) -> SampledField:
    """The samples of a study that is solved."""
    fields = study.fields
    values = np.column_stack([fields.von_mises, fields.energy, fields.displacement, fields.stress, fields.strain])
    with activity("sampling a study"):
        samples, voxel, *off = sampled(fields.mesh, values)
    return _known(study, samples, voxel, *off)


def doubts_of(study: Solved) -> tuple[Doubt, ...]:
    """What is doubtful of a study that is solved, whoever reads it: of its samples nothing is said."""
    none = SampledField.from_array(np.zeros((2, 2, 2)), (0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    return told(_known(study, none, 0.0, 0.0, 0.0)).doubts


def _known(study: Solved, samples: SampledField, voxel: float, off: float, jumps: float) -> SampledField:
    """Samples, with what is known of their study."""
    wall, missed = study.sized.wall, study.missed
    x, y, z = (0.0, 0.0, 0.0) if wall is None else map(float, wall.at)
    gap = study.gap or Gap(0.0, (0.0, 0.0), np.zeros(3), False)
    gap_x, gap_y, gap_z = map(float, gap.at)
    got = Got(
        len(study.mesh.tets), study.unknowns, study.iterations, study.residual, study.sized.order, study.sized.size,
        study.sized.finest, _beside(study), 0.0 if wall is None else wall.wall, x, y, z,
        gap.wide, *gap.reach, float(gap.tapers), float(gap.of), gap_x, gap_y, gap_z, study.sized.area,
        *_beyond(study),
        study.asked.yields, study.lost, study.pieces, voxel, off, jumps,
        form_error(missed), missed.lacking, missed.beyond, missed.handles, missed.of, *missed.at,
        shared_error(study.shared), *study.seam,
        tuple(study.numbers[name].value for name in NUMBERS), tuple(study.numbers[name].error for name in NUMBERS),
    )  # fmt: skip
    return replace(samples, facts=got.facts)


def _beside(study: Solved) -> float:
    """The size of the elements near the thinnest wall, in mm."""
    wall, mesh = study.sized.wall, study.mesh
    if wall is None or not study.sized.finest:
        return study.sized.size
    far = np.linalg.norm(mesh.vertices[mesh.tets].mean(axis=1) - wall.at, axis=1)
    near = np.argsort(far)[:_NEAR]
    return float(np.cbrt(12 * volumes(mesh)[near].mean()))  # twelve to a cube


def _beyond(study: Solved) -> tuple[float, float, float, float]:
    """The greatest displacement over the longest side of the part, the mean strain; the greatest Young's modulus (MPa)
    and density (g/cm3), 0 where the text of a program shows them."""
    asked, mesh, solution = study.asked, study.mesh, study.solution
    longest = float(np.ptp(mesh.vertices, axis=0).max())
    stiff = float((study.young * volumes(mesh)).sum())
    return (
        study.numbers["max_displacement"].value / longest,
        float(np.sqrt(abs(study.numbers["compliance"].value) / stiff)),
        0.0 if asked.young.root.stage is Stage.CONST else float(study.young.max()),
        0.0 if asked.density.root.stage is Stage.CONST else float(solution.density.max()),
    )
