"""The options of `pore render`."""

from __future__ import annotations

from porelang import values
from porelang.cli.options.option import Option

PICTURES: dict[str, Option] = {
    "bodies": (("--bodies",), {"action": "store_true", "help": "draw all solid outputs, each in its colour"}),
    "axes": (("--axes",), {"action": "store_true", "help": "draw which way x, y and z point, in a corner"}),
    "frame": (
        ("--frame",),
        {
            "choices": ("surface", "bounds"),
            "default": "surface",
            "help": "what fills the picture: the surface that is seen, or the bounds of the part (default: surface)",
        },
    ),
    "scale_bar": (
        ("--scale-bar",),
        {
            "action": "store_true",
            "dest": "scale_bar",
            "help": "draw a round length in mm; in perspective it is true in the middle of the part",
        },
    ),
    "view": (
        ("--view",),
        {
            "metavar": "VIEW",
            "type": values.view,
            "default": "iso",
            "help": "iso, front, back, left, right, top, bottom, or AZIMUTH,ELEVATION in degrees (default: iso)",
        },
    ),
    "projection": (
        ("--projection",),
        {
            "choices": ("perspective", "orthographic"),
            "default": "perspective",
            "help": "how depth is drawn (default: perspective)",
        },
    ),
    "size": (
        ("--size",),
        {
            "metavar": "WxH",
            "type": values.picture_size,
            "default": (800, 600),
            "help": "in pixels (default: 800x600)",
        },
    ),
    "zoom": (
        ("--zoom",),
        {"metavar": "FACTOR", "type": values.factor, "default": 1.0, "help": "2 shows the middle twice as large"},
    ),
    "cut": (
        ("--cut",),
        {
            "metavar": "'y<0'",
            "type": values.cut,
            "action": "append",
            "default": [],
            "help": "take away what lies on that side of a plane, or on both sides named in 'y<0 & z>0': a quarter; "
            "repeat it for several",
        },
    ),
    "slice": (
        ("--slice",),
        {
            "metavar": "x=0",
            "type": values.plane,
            "action": "append",
            "default": [],
            "help": "draw the field on a plane: red negative, yellow near zero, blue positive; repeat it for several",
        },
    ),
    "field": (
        ("--field",),
        {
            "metavar": "NAME",
            "help": "which output, `let` or expression of these (s.von_mises) the planes show (default: the part); "
            "without planes, the surface does",
        },
    ),
    "fields": (
        ("--field",),
        {
            "metavar": "NAME",
            "action": "append",
            "dest": "fields",
            "default": [],
            "help": "a further output, `let` or expression of these (s.von_mises); may be given several times",
        },
    ),
    "range": (
        ("--range",),
        {
            "metavar": "LO..HI",
            "type": values.value_range,
            "help": "the values at the ends of the colours (default: found in the picture)",
        },
    ),
    "legend": (
        ("--legend",),
        {
            "metavar": "TEXT",
            "nargs": "?",
            "const": "",
            "help": "draw the scale of the colours with its numbers, and TEXT above it (default: the field's unit); "
            "of several outputs their names",
        },
    ),
    "deform": (
        ("--deform",),
        {
            "metavar": "[N] [STUDY]",
            "nargs": "?",
            "const": "auto",
            "type": values.deform,
            "help": "draw the part as a study deforms it (default: the only study), displacements N times as large "
            "(default: the greatest a tenth of the part): --deform s, --deform 100, --deform '100 s'",
        },
    ),
    "ghost": (
        ("--ghost",),
        {"action": "store_true", "help": "with --deform: draw the edges of the undeformed part too"},
    ),
    "solid": (
        ("--solid",),
        {
            "choices": ("none", "opaque", "glass"),
            "help": "how the part is drawn (default: opaque, with --slice glass)",
        },
    ),
    "background": (
        ("--background",),
        {"choices": ("white", "transparent"), "default": "white", "help": "behind the part (default: white)"},
    ),
    "samples": (
        ("--samples",),
        {
            "metavar": "N",
            "type": values.fineness,
            "default": 3,
            "help": "N x N samples are averaged for each pixel (default: 3)",
        },
    ),
}
