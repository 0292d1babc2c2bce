"""What reading samples has come to: kept with them, told by the commands that read them."""

from __future__ import annotations

from dataclasses import dataclass

from porelang.data import SampledField, coordinates
from porelang.tasks.readers.tensors import SIX

#: An error of so much of the range of values is doubted.
_COARSE = 0.1
#: Where `outside` holds in the middles of so many of the cells, it is doubted.
_LOST = 0.02


@dataclass(frozen=True, slots=True)
class Got:
    """What is known of a field that was read from a file: in `SampledField.facts`, in this order.

    The cells, and those that were left out for they have no volume; the spacing that was aimed at, in mm; by how much
    lookups differ from what the file says at its points (or in the middles of its cells): of 95 % of these less than
    the first, of all at most the second; the least and the greatest value of the file; the share of the cells in whose
    middles `outside` would hold; the cells of higher order of which the corners alone count; whether the file names
    the components of a tensor; the box of the data, in mm. Of a regular grid there are no cells, and its samples are
    what the file says.
    """

    cells: int
    left: int
    voxel: float
    error: float
    largest_error: float
    least: float
    greatest: float
    lost: float
    corners: int
    named: bool
    low_x: float
    low_y: float
    low_z: float
    high_x: float
    high_y: float
    high_z: float

    @classmethod
    def of(cls, field: SampledField) -> Got:
        cells, left, *rest = field.facts
        return cls(int(cells), int(left), *rest)  # type: ignore[arg-type]  # `named` is 0 or 1

    def told(self, field: SampledField, components: int) -> str:
        """What it is in a line, of so many numbers in each place."""
        from_, to = (self.low_x, self.low_y, self.low_z), (self.high_x, self.high_y, self.high_z)
        where = f"from ({coordinates(from_)}) to ({coordinates(to)}) mm"
        if self.cells:
            share = f" ({self.share:.2g} of their range)" if self.share else ""
            off = f"95 % of lookups differ from the file by less than {self.error:.3g}{share}"
            most = f"none of those looked at by more than {self.largest_error:.3g}"
            said = f"{self.cells:,} cells {where}, sampled every {self.voxel:.3g} mm: {off}, {most}"
        else:
            said = f"{' x '.join(map(str, field.shape))} nodes {where}"
        if self.corners:
            said += f"; of {self.corners:,} cells of higher order the corners alone count"
        if components == 6 and not self.named:
            said += f"; the file does not name the components of its tensors: they are taken as {', '.join(SIX)}"
        return said

    @property
    def share(self) -> float:
        """The error as a share of the range of values; 0 where they are all one."""
        return self.error / (self.greatest - self.least) if self.greatest > self.least else 0.0

    @property
    def coarse(self) -> bool:
        """Whether samples are too far apart for what the cells hold."""
        return self.share > _COARSE

    @property
    def holed(self) -> bool:
        """Whether samples are too far apart to tell what lies in cells from what lies outside."""
        return self.lost > _LOST
