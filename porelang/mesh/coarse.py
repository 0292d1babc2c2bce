"""What is doubtful about a mesh: whether it holds the part."""

from __future__ import annotations

from porelang.analysis.box import block
from porelang.diagnostics import Diagnostic
from porelang.field import Bounds, checked_bounds
from porelang.ir import node
from porelang.program import Design
from porelang.tasks.numbers.integrals import volume

#: A mesh whose volume is further than this from the part's is not the part.
COARSE = 0.03


def too_coarse(design: Design, name: str | None, bounds: Bounds | None, meshed: float) -> list[Diagnostic]:
    """A warning where a mesh of `meshed` mm3 is not the part: walls thinner than a voxel come out as specks."""
    part = design.of(name)
    if bounds is not None:
        part = part.with_roots(node("max", part.root, block(checked_bounds(bounds))))
    true = volume(part, accuracy=2e-3)
    off = abs(meshed - true.value)
    if off <= COARSE * true.value + true.error:
        return []
    return [
        Diagnostic(
            "W202",
            f"the voxel is too coarse: the mesh holds {meshed:.4g} mm3, the part "
            f"{true.value:.4g} +- {true.error:.2g} mm3",
            design.program.outputs[design.program.output(name)].span,
            "what is thinner than a voxel is lost or torn",
            hint="use a smaller --voxel, a few to the thinnest wall",
            severity="warning",
        )
    ]
