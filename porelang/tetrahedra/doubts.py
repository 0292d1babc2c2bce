"""What is doubtful about tetrahedra: pieces left out that were much of the part, a volume that is not the part's."""

from __future__ import annotations

from porelang.data import Reduced, figures
from porelang.diagnostics import Diagnostic, fail
from porelang.source import Span
from porelang.tetrahedra.fineness import Fineness
from porelang.walls import rounded

#: Parts of the volume: a mesh that is off by more is doubtful, or useless.
DOUBTFUL, USELESS = 0.03, 0.2


def refuse_loss(pieces: int, share: float, span: Span | None) -> None:
    """Errors: E118 where the pieces that were left out are more than a fifth of the part."""
    if share <= USELESS:
        return
    which = f"{pieces} piece{' does' if pieces == 1 else 's do'} not hang together with the largest"
    hint = "keep them, --keep-islands, or write the largest alone, --force"
    raise fail("E118", f"{which}, and {'is' if pieces == 1 else 'are'} {share:.0%} of the volume", span,
               label="in several pieces", hint=hint)  # fmt: skip


def volume_doubts(
    held: float, true: Reduced, fine: Fineness, force: bool, span: Span | None, lost: float = 0.0
) -> list[Diagnostic]:
    """W202, where the tetrahedra hold another volume (mm3) than the part by more than 3 % and its error; `lost`
    (mm3) of that were islands. Errors: E118 where it is another by more than a fifth, unless `force`."""
    off = (abs(held - true.value) - true.error) / max(true.value, 1e-300)
    if off <= DOUBTFUL:
        return []
    numbers = f"{held:.6g} mm3, the part {figures(true.value, true.error)}"
    least = fine.size if isinstance(fine.size, float) else None
    size = None if least is None else least / 2
    if fine.wanted is not None and (least is None or fine.wanted < least):
        size = fine.wanted  # as the report and W250 say
    hint = f"give a smaller --size{'' if size is None else f', {rounded(size)}mm'}"
    if off > USELESS and not force:
        raise fail("E118", f"the tetrahedra are not the part: they hold {numbers}", span,
                   label="too fine for the size", hint=f"{hint}; or keep them as they are, --force")  # fmt: skip
    much = f"{abs(held - true.value) / true.value:.1%} {'less' if held < true.value else 'more'}"
    islands = f", {lost:.3g} mm3 of it in islands that were left out" if lost else ""
    message = f"the tetrahedra hold {numbers}: {much}{islands}"
    return [Diagnostic("W202", message, span, "too fine for the size", hint=hint, severity="warning")]
