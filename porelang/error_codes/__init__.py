"""Every code of a diagnostic with its page for `pore explain`; one module for each theme.

E001-E029 syntax, E030- names, E060- kinds and units, E080- params and contracts, E090- numbers found from fields,
E100- requests, E120- the machine, E130- files of data, E137- trusses, E140- meshes, E145- raw lattices, E147- phases,
E150- sampling and binding, E160- and W250- tetrahedra, E170- and W255- elasticity, E179 and W285 parts in pictures,
E180- and W260- unit cells, E184- studies, E190- loops, W200- warnings, W210- doubts, W273- studies, W280- elasticity
and studies. A code keeps its meaning for ever; one that is no longer given keeps its page.
"""

from __future__ import annotations

from porelang.error_codes.cells import CELLS
from porelang.error_codes.datafiles import DATAFILES
from porelang.error_codes.direct import DIRECT
from porelang.error_codes.doubts import DOUBTS
from porelang.error_codes.elasticity import ELASTICITY
from porelang.error_codes.found import FOUND
from porelang.error_codes.ftetwild import FTETWILD
from porelang.error_codes.kinds import KINDS
from porelang.error_codes.loops import LOOPS
from porelang.error_codes.machine import MACHINE
from porelang.error_codes.names import NAMES
from porelang.error_codes.page import Code
from porelang.error_codes.params import PARAMS
from porelang.error_codes.phases import PHASES
from porelang.error_codes.pictures import PICTURES
from porelang.error_codes.requests import REQUESTS
from porelang.error_codes.shapes import SHAPES
from porelang.error_codes.studies import STUDIES
from porelang.error_codes.syntax import SYNTAX
from porelang.error_codes.trusses import TRUSSES
from porelang.error_codes.walls import WALLS

THEMES: tuple[tuple[Code, ...], ...] = (
    SYNTAX,
    NAMES,
    KINDS,
    PARAMS,
    FOUND,
    REQUESTS,
    MACHINE,
    DATAFILES,
    TRUSSES,
    PHASES,
    SHAPES,
    WALLS,
    DIRECT,
    STUDIES,
    FTETWILD,
    ELASTICITY,
    PICTURES,
    LOOPS,
    CELLS,
    DOUBTS,
)
CODES: dict[str, Code] = {page.code: page for theme in THEMES for page in theme}
#: What is no longer given, and keeps its page: W284 says it.
RETIRED = frozenset({"W264", "W265", "W282"})

Page = Code  # what a reader sees of it

__all__ = ["CODES", "RETIRED", "THEMES", "Code", "Page"]
