"""E163-E165: tetrahedra by fTetWild."""

from __future__ import annotations

from porelang.error_codes.page import Code

FTETWILD = (
    Code(
        "E163",
        "no fTetWild on this machine",
        "fTetWild comes with the package pytetwild: `pip install 'porelang[ftetwild]'`. The direct mesher needs no\n"
        "other program, is faster, and has the better angles: leave --mesher out.",
        "",
        "",
    ),
    Code(
        "E164",
        "fTetWild made no tetrahedra",
        "fTetWild is native code and runs in a process of its own. That process crashed, was ended for want of\n"
        "memory, or took longer than it may: half an hour, or --time-limit. What helps is a larger --size, or the\n"
        "direct mesher, which has none of these troubles.",
        "",
        "",
    ),
    Code(
        "E165",
        "what fTetWild is not given",
        "On a surface that is empty or open, on numbers that are none and on a size of 0 fTetWild crashes, never\n"
        "ends, or gives a wrong mesh without a word. So it is not asked then, nor for so many tetrahedra that it\n"
        "would take hours.",
        "",
        "",
    ),
)
