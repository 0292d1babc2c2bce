"""Cells of struts by name: bars in parts of a cubic cell that repeats, whose corner lies at the origin.

`met` are the numbers of bars that meet in its nodes. The cells of the reference tool are those of M. Bernhard, Axolotl
1.0 (`primitives/lattice.py`, 2018), which are written there as struts of an eighth of the cell, from its middle (0, 0,
0) to its corner (1/2, 1/2, 1/2), and mirrored: but for the last all are cells of other names, or several together.
`hextruss` is taken for the `hexgrid` of compas_vol (2019), its kin: no source that was found has that name.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import permutations, product

Place = tuple[float, float, float]
Bar = tuple[Place, Place]


@dataclass(frozen=True, slots=True)
class StrutCell:
    """A cell by name: its bars, how many meet in its nodes, what it is, and where it comes from."""

    name: str
    bars: tuple[Bar, ...]
    met: frozenset[int]
    doc: str
    source: str


def _place(values: Iterable[float]) -> Place:
    x, y, z = values
    return x, y, z


def _plus(a: Sequence[float], b: Sequence[float]) -> Place:
    return _place(u + v for u, v in zip(a, b, strict=True))


def _each_once(bars: Iterable[Bar]) -> tuple[Bar, ...]:
    """Bars without those that lie where one before lies, in this cell or in another."""
    found: dict[object, Bar] = {}
    for a, b in bars:
        middle = tuple(round((u + v) / 2 % 1.0, 9) % 1.0 for u, v in zip(a, b, strict=True))
        way = max([tuple(round(s * (v - u), 9) + 0.0 for u, v in zip(a, b, strict=True)) for s in (1, -1)])
        found.setdefault((middle, way), (a, b))
    return tuple(found.values())


def _bonds(nodes: Iterable[Place], ways: Iterable[Place]) -> tuple[Bar, ...]:
    """From each node a bar along each way."""
    return _each_once((n, _plus(n, w)) for n, w in product(nodes, list(ways)))


def _mirrored(*bars: Bar) -> tuple[Bar, ...]:
    """Bars of an eighth, measured from the middle of the cell, in all eight."""
    signs = list(product((1, -1), repeat=3))

    def at(p: Place, s: tuple[int, ...]) -> Place:
        return _place(0.5 + k * c for k, c in zip(s, p, strict=True))

    return _each_once((at(a, s), at(b, s)) for a, b in bars for s in signs)


def _moved(bars: Iterable[Bar], by: Place) -> tuple[Bar, ...]:
    return tuple((_plus(a, by), _plus(b, by)) for a, b in bars)


def _ways(*parts: float) -> list[Place]:
    """All directions with these parts along the axes, in any order and of any sign."""
    signs = product((1, -1), repeat=3)
    return sorted({_place(k * c + 0.0 for k, c in zip(s, p, strict=True)) for s in signs for p in permutations(parts)})


_CORNER: Place = (0.0, 0.0, 0.0)
_MIDDLE: Place = (0.5, 0.5, 0.5)
_FACES: list[Place] = [(0.0, 0.5, 0.5), (0.5, 0.0, 0.5), (0.5, 0.5, 0.0)]
_FCC = [_CORNER, *_FACES]
_CUBIC = _bonds([_CORNER], [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
_BCC = _bonds([_MIDDLE], _ways(0.5, 0.5, 0.5))
#: From the middle of each face to its corners.
_CORNERED = _bonds([_CORNER], _ways(0.5, 0.5, 0.0))
_OCTET = _bonds(_FCC, _ways(0.5, 0.5, 0.0))
_OCTAHEDRAL = tuple(bar for bar in _OCTET if bar not in _CORNERED)
#: The square of a truncated octahedron on each face, and from its corners the edges between hexagons.
_KELVIN = _mirrored(
    ((0.25, 0.0, 0.5), (0.0, 0.25, 0.5)), ((0.25, 0.5, 0.0), (0.0, 0.5, 0.25)), ((0.5, 0.25, 0.0), (0.5, 0.0, 0.25)),
    ((0.25, 0.0, 0.5), (0.5, 0.0, 0.25)), ((0.0, 0.25, 0.5), (0.0, 0.5, 0.25)), ((0.25, 0.5, 0.0), (0.5, 0.25, 0.0)),
)  # fmt: skip
_DIAMOND = _bonds(_FCC, [(0.25, 0.25, 0.25), (0.25, -0.25, -0.25), (-0.25, 0.25, -0.25), (-0.25, -0.25, 0.25)])
#: Half the length of an upright of the re-entrant cell: more than a quarter, so that the others come back.
_UP = 0.35


def _re_entrant() -> tuple[Bar, ...]:
    bars: list[Bar] = []
    for i, j in product((0, 1), repeat=2):
        low = 0.5 * ((i + j) % 2)  # uprights stand as the squares of a chessboard, every other half a cell higher
        x, y = i / 2, j / 2
        bars.append(((x, y, low - _UP), (x, y, low + _UP)))
        for dx, dy in ((0.5, 0.0), (-0.5, 0.0), (0.0, 0.5), (0.0, -0.5)):
            bars.append(((x, y, low + _UP), (x + dx, y + dy, low + 0.5 - _UP)))
    return _each_once(bars)


_AXOLOTL = "M. Bernhard, Axolotl 1.0, ETH Zurich 2018"
_DUAL = _moved(_CUBIC, _MIDDLE)

_ROWS = (
    StrutCell("cubic", _CUBIC, frozenset({6}), "The edges of cubes.",
              "L. J. Gibson, M. F. Ashby, Cellular solids, 1997"),
    StrutCell("bcc", _BCC, frozenset({8}), "From the middle of a cube to its corners.",
              "M. Smith, Z. Guan, W. J. Cantwell, Int. J. Mech. Sci. 67, 2013"),
    StrutCell("fcc", _CORNERED, frozenset({4, 12}), "The diagonals of the faces of a cube.",
              "M. Leary et al., Materials & Design 98, 2016"),
    StrutCell("octet", _OCTET, frozenset({12}), "Octahedra and tetrahedra.",
              "V. S. Deshpande, N. A. Fleck, M. F. Ashby, J. Mech. Phys. Solids 49, 2001"),
    StrutCell("octahedral", _OCTAHEDRAL, frozenset({8}), "Octahedra that meet at the middles of the cube's faces.",
              "V. S. Deshpande, N. A. Fleck, M. F. Ashby, J. Mech. Phys. Solids 49, 2001"),
    StrutCell("kelvin", _KELVIN, frozenset({4}), "Truncated octahedra.",
              "W. Thomson, On the division of space with minimum partitional area, Phil. Mag. 24, 1887"),
    StrutCell("diamond", _DIAMOND, frozenset({4}), "The bonds of diamond.",
              "W. H. Bragg, W. L. Bragg, The structure of the diamond, Proc. R. Soc. A 89, 1913"),
    StrutCell("rhombic_dodecahedral", _bonds(_FCC, _ways(0.25, 0.25, 0.25)), frozenset({4, 8}),
              "Rhombic dodecahedra.", "S. Babaee et al., Acta Materialia 60, 2012"),
    StrutCell("re_entrant", _re_entrant(), frozenset({5}),
              "Auxetic: uprights, and struts between them that lean back.",
              "L. Yang et al., Int. J. Solids and Structures 69-70, 2015; the proportions are ours"),
    StrutCell("bigx", _BCC, frozenset({8}), "`bcc`, as the reference tool calls it.", _AXOLOTL),
    StrutCell("grid", _CUBIC, frozenset({6}), "`cubic`, as the reference tool calls it.", _AXOLOTL),
    StrutCell("star", _CUBIC + _BCC, frozenset({8, 14}), "`cubic` and `bcc`.", _AXOLOTL),
    StrutCell("cross", _CORNERED, frozenset({4, 12}), "`fcc`, as the reference tool calls it.", _AXOLOTL),
    StrutCell("octagon", _OCTAHEDRAL, frozenset({8}), "`octahedral`, as the reference tool calls it.", _AXOLOTL),
    StrutCell("vintile", _moved(_KELVIN, (0.0, 0.0, 0.5)), frozenset({4}), "`kelvin`, half a cell higher.", _AXOLOTL),
    StrutCell("dual", _DUAL, frozenset({6}), "`cubic` about the middle of the cell.", _AXOLOTL),
    StrutCell("interlock", _CUBIC + _DUAL, frozenset({6}), "`cubic` and `dual`, which do not touch.", _AXOLOTL),
    StrutCell("isotrop", _moved(_CUBIC + _DUAL + _BCC, (0.0, 0.5, 0.5)), frozenset({14}),
              "`cubic`, `dual` and `bcc`, half a cell to the side: corners and middles of cubes, each with the "
              "fourteen nearest.", _AXOLOTL),
    StrutCell("hextruss", _mirrored(*(((0.5, 0.5, 0.5), _place(0.2 * (a == b) for b in range(3))) for a in range(3))),
              frozenset({4, 24}), "From the corners to places a fifth of the cell from its middle.",
              "M. Bernhard, compas_vol, ETH Zurich 2019, as `hexgrid`"),
)  # fmt: skip

#: The cells by name.
CELLS: dict[str, StrutCell] = {row.name: row for row in _ROWS}
