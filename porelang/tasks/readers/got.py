"""What sampling cells has come to: kept with the samples, told by the commands that read them."""

from __future__ import annotations

from dataclasses import dataclass

from porelang.data import SampledField

#: An error of so much of the range of values is doubted.
_COARSE = 0.1
#: Cells that all lie within so many mm are doubted: their file may be in metres.
_SMALL = 1.0


@dataclass(frozen=True, slots=True)
class Got:
    """What is known of a field that was rasterised: in `SampledField.facts`, in this order.

    The cells, and those that were left out for they have no volume; the spacing that was aimed at, in mm; by how much
    lookups differ from what the file says at its points (or in the middles of its cells): of 95 % of these less than
    the first, of all at most the second; the least and the greatest value of the file.
    """

    cells: int
    left: int
    voxel: float
    error: float
    largest_error: float
    least: float
    greatest: float

    @classmethod
    def of(cls, field: SampledField) -> Got:
        cells, left, *rest = field.facts
        return cls(int(cells), int(left), *rest)

    def __str__(self) -> str:
        share = f" ({self.share:.2g} of their range)" if self.share else ""
        off = f"95 % of lookups differ from the file by less than {self.error:.3g}{share}"
        most = f"none of those looked at by more than {self.largest_error:.3g}"
        return f"{self.cells:,} cells sampled every {self.voxel:.3g} mm: {off}, {most}"

    @property
    def share(self) -> float:
        """The error as a share of the range of values; 0 where they are all one."""
        return self.error / (self.greatest - self.least) if self.greatest > self.least else 0.0

    @property
    def coarse(self) -> bool:
        """Whether samples are too far apart for what the cells hold."""
        return self.share > _COARSE


def small(field: SampledField) -> str:
    """The size of cells that is hardly one in mm; "" of others."""
    size = [s * (n - 3) for s, n in zip(field.spacing, field.shape, strict=True)]
    return " x ".join(f"{s:.3g}" for s in size) if max(size) < _SMALL else ""
