"""Which data a child keeps on the device: the parent alone decides, the child does as it is told."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Collection

#: Bytes of data that stay on a device, the least recently used go first; what one call needs is kept whatever it takes.
MOST_KEPT = 1 << 30


class Resident:
    """The digests and sizes of what a child keeps, the least recently used first; empty for a fresh child."""

    def __init__(self, most: int = MOST_KEPT) -> None:
        self.most = most
        self._sizes: OrderedDict[str, int] = OrderedDict()

    def __contains__(self, digest: str) -> bool:
        return digest in self._sizes

    @property
    def size(self) -> int:
        """Bytes kept."""
        return sum(self._sizes.values())

    def use(self, digests: Collection[str]) -> None:
        """Note that a call reads these."""
        for digest in digests:
            self._sizes.move_to_end(digest)

    def to_drop(self, size: int, needed: Collection[str]) -> tuple[str, ...]:
        """What has to go to make room for `size` more bytes, but nothing of what is `needed`."""
        dropped, excess = [], self.size + size - self.most
        for digest, held in self._sizes.items():
            if excess > 0 and digest not in needed:
                dropped.append(digest)
                excess -= held
        return tuple(dropped)

    def drop(self, digests: Collection[str]) -> None:
        for digest in digests:
            del self._sizes[digest]

    def add(self, digest: str, size: int) -> None:
        self._sizes[digest] = size
