"""The options of commands, as data: how each is written, what it takes, and what `--help` says of it."""

from __future__ import annotations

from typing import Any

from porelang import values

#: What `argparse` is told of each option, but for `type`, `choices` and `required`, which are ours: its own words for
#: what it misses differ from one Python to the next.
OPTIONS: dict[str, tuple[tuple[str, ...], dict[str, Any]]] = {
    "file": (
        ("file",),
        {"metavar": "FILE", "required": True, "help": "the program, a .pore file; - reads standard input"},
    ),
    "words": (
        ("words",),
        {"metavar": "COMMAND", "help": "a command with its options, without the file: mesh -o a.stl"},
    ),
    "code": (("code",), {"metavar": "CODE", "help": "the code of a diagnostic, as in E012"}),
    "action": (
        ("action",),
        {
            "metavar": "ACTION",
            "choices": ("list", "size", "clear"),
            "default": "size",
            "help": "list, size or clear (default: size); PORELANG_CACHE_LIMIT=500MB in the environment sets the limit",
        },
    ),
    "set": (
        ("--set",),
        {
            "metavar": "NAME=VALUE",
            "type": values.setting,
            "action": "append",
            "default": [],
            "dest": "settings",
            "help": "give a param a value, units allowed; repeat it for several",
        },
    ),
    "preset": (
        ("--preset",),
        {"metavar": "NAME", "help": "set the params as a `preset` of the program says; --set goes over it"},
    ),
    "bind": (
        ("--bind",),
        {
            "metavar": "NAME=FILE:ARRAY",
            "type": values.binding,
            "action": "append",
            "default": [],
            "dest": "bindings",
            "help": "give a param that takes data the array of a file, as `load` reads it, with its options behind: "
            "stress=a.vtu:mises,unit=Pa,lengths=m; what is not said is as the default has it; repeat it for several",
        },
    ),
    "out": (("--out",), {"metavar": "NAME", "help": "which output of the program (default: part)"}),
    "outs": (
        ("--out",),
        {
            "metavar": "NAME",
            "action": "append",
            "default": [],
            "dest": "outs",
            "help": "which output of the program (default: part); repeat it to draw several, each in its colour",
        },
    ),
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
    "measure": (
        ("--measure",),
        {
            "action": "store_true",
            "help": "look at checks about whole fields and at the ends of params too: takes seconds",
        },
    ),
    "within": (
        ("--within",),
        {
            "metavar": "NAME",
            "help": "the envelope: an output or a let (default: shapes a part is cut from or to, or its bounds)",
        },
    ),
    "folder": (
        ("-o", "--output"),
        {"metavar": "DIR", "type": values.output, "required": True, "help": "the folder to write"},
    ),
    "step": (
        ("--step",),
        {"metavar": "LENGTH", "type": values.length, "required": True, "help": "the thickness of a layer, as in 0.1mm"},
    ),
    "cell": (
        ("--cell",),
        {
            "metavar": "A,B,C",
            "type": values.cell,
            "help": "the sides of the period along x, y and z, in mm, or one (default: the period of its lattices)",
        },
    ),
    "nu": (
        ("--nu",),
        {
            "metavar": "NU",
            "type": values.poisson,
            "default": 0.3,
            "help": "Poisson's ratio of the solid (default: 0.3)",
        },
    ),
    "voxels": (
        ("--resolution",),
        {
            "metavar": "N",
            "type": values.voxels,
            "default": 64,
            "help": "voxels along the longest side of the finest grid, in eights; 3/4, 1/2 and 3/8 of them are "
            "solved too (default: 64)",
        },
    ),
    "sweep": (
        ("--sweep",),
        {
            "metavar": "NAME=LO..HI:N",
            "type": values.swept,
            "help": "at N values of a param: the density, what resists, and the power C rho^n through it",
        },
    ),
    "reports": (
        ("-o", "--output"),
        {
            "metavar": "FILE",
            "type": values.output,
            "action": "append",
            "default": [],
            "dest": "outputs",
            "help": ".png Young's modulus by direction, .csv the same as numbers, .json all; of a sweep its plot, its "
            "table, all; repeat it for several",
        },
    ),
    "format": (("--format",), {"choices": ("png", "svg"), "default": "png", "help": "pictures, or contours in mm"}),
    "output": (
        ("-o", "--output"),
        {"metavar": "FILE", "type": values.output, "required": True, "help": "the file to write"},
    ),
    "result": (
        ("-o", "--output"),
        {
            "metavar": "FILE.vtu",
            "type": values.output,
            "help": "write the elements with stresses and displacements, as ParaView opens them",
        },
    ),
    "study": (
        ("--study",),
        {
            "metavar": "NAME",
            "help": "which study of the program (default: the only one); or one of the output, as a program calls it: "
            "'compress(part, 10kN, axis=z, material=\"PA12\")'",
        },
    ),
    "refine": (
        ("--refine",),
        {"action": "store_true", "help": "solve again with finer elements where stresses err most"},
    ),
    "iterate": (("--iterate",), {"metavar": "NAME", "help": "the output that adapts (default: part)"}),
    "until": (
        ("--until",),
        {
            "metavar": "CHANGE",
            "type": values.until,
            "default": 0.005,
            "help": "end where the compliance changes by less, as in 'change<0.5%%' (default)",
        },
    ),
    "most": (
        ("--max",),
        {"metavar": "N", "type": values.count, "default": 15, "dest": "most", "help": "steps at most (default: 15)"},
    ),
    "rule": (
        ("--rule",),
        {
            "metavar": "RULE",
            "choices": ("energy", "von_mises", "optimum"),
            "default": "energy",
            "help": "energy, the strain energy of the solid (default), von_mises, the designer's, or optimum, found on "
            "the homogenised lattice by its own law and then made real",
        },
    ),
    "early": (
        ("--early",),
        {
            "metavar": "WHERE",
            "choices": ("homogenised",),
            "help": "homogenised: go the first steps on voxels of the homogenised lattice, the last ones in tetrahedra",
        },
    ),
    "limits": (
        ("--limits",),
        {
            "metavar": "LOW..HIGH",
            "type": values.limits,
            "default": (0.2, 0.8),
            "help": "the least and the greatest density (default: 0.2..0.8)",
        },
    ),
    "porosity": (
        ("--porosity",),
        {
            "metavar": "SHARE",
            "type": values.share,
            "help": "the porosity to be kept, as in 50%% (default: that of the program as it stands)",
        },
    ),
    "adapt": (
        ("--adapt",),
        {"metavar": "NAME", "help": "the param that adapts (default: the only one with data that the output reads)"},
    ),
    "which": (
        ("--study",),
        {"metavar": "NAME", "help": "which study of the output (default: the only one)"},
    ),
    "averaged": (
        ("--cell",),
        {
            "metavar": "LENGTH",
            "type": values.length,
            "help": "what all is averaged over (default: the period of the lattice)",
        },
    ),
    "damping": (
        ("--damping",),
        {
            "metavar": "SHARE",
            "type": values.share,
            "default": 1.0,
            "help": "the share of each change that is made (default: 1)",
        },
    ),
    "resume": (("--resume",), {"action": "store_true", "help": "go on with the record in the folder, if there is one"}),
    "anew": (
        ("--force",),
        {"action": "store_true", "help": "begin anew in a folder that holds the record of a loop, which is removed"},
    ),
    "loop": (
        ("-o", "--output"),
        {
            "metavar": "DIR",
            "type": values.output,
            "help": "the folder of record, samples, table and picture (default: FILE with .loop for its ending)",
        },
    ),
    "values": (
        ("-o", "--output"),
        {
            "metavar": "V.npy",
            "type": values.output,
            "help": "write the values to a file, not to standard output",
        },
    ),
    "points": (
        ("--points",),
        {
            "metavar": "P",
            "required": True,
            "help": ".npy of shape (n, 3), or .csv of x,y,z; `-` reads CSV from standard input",
        },
    ),
    "voxel": (
        ("--voxel",),
        {"metavar": "LENGTH", "type": values.length, "help": "the spacing of the samples, as in 0.5mm"},
    ),
    "spacing": (
        ("--voxel",),
        {
            "metavar": "LENGTH",
            "type": values.spacing,
            "help": "the spacing of the samples, as in 0.5mm; auto (the default) finds it from the walls",
        },
    ),
    "force": (("--force",), {"action": "store_true", "help": "write a mesh also if it lost much of the part"}),
    "resolution": (
        ("--resolution",),
        {"metavar": "N", "type": values.count, "help": "in place of a voxel: samples along the longest side"},
    ),
    "smooth": (("--smooth",), {"action": "store_true", "help": "move the vertices onto the field"}),
    "sharp": (("--sharp",), {"action": "store_true", "help": "sharp rims where surfaces meet; includes --smooth"}),
    "simplify": (
        ("--simplify",),
        {
            "metavar": "DEVIATION",
            "type": values.length,
            "help": "as few triangles as stay within this distance of the mesh, as in 0.05mm",
        },
    ),
    "bounds": (
        ("--bounds",),
        {
            "metavar": "x0,y0,z0,x1,y1,z1",
            "type": values.box,
            "help": "the box to look at, in mm (default: found from the program)",
        },
    ),
    "backend": (
        ("--backend",),
        {
            "choices": ("auto", "numpy", "glsl"),
            "default": "auto",
            "help": "auto: GLSL where there is OpenGL and f32 is asked for, else NumPy",
        },
    ),
    "dtype": (("--dtype",), {"choices": ("f32", "f64"), "help": "the numbers to compute with"}),
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
    "tet_size": (
        ("--size",),
        {
            "metavar": "LENGTH",
            "type": values.size,
            "help": "how long the edges of tetrahedra are, as in 3mm; or the name of an output or a `let` that says it "
            "at every place; auto (the default) finds it from the walls",
        },
    ),
    "surface_size": (
        ("--surface-size",),
        {
            "metavar": "LENGTH",
            "type": values.length,
            "help": "how long they are at the surface (default: as inside)",
        },
    ),
    "mesher": (
        ("--mesher",),
        {
            "choices": ("direct", "ftetwild"),
            "default": "direct",
            "help": "direct: straight from the field (the default); ftetwild: from a surface, by fTetWild",
        },
    ),
    "phases": (
        ("--phases",),
        {
            "metavar": "solid[,void]",
            "type": values.phases,
            "default": ("solid",),
            "help": "what to fill: the solid (the default), or the void in the part's box too, with triangles shared",
        },
    ),
    "keep_islands": (
        ("--keep-islands",),
        {"action": "store_true", "help": "keep pieces that do not hang together with the largest"},
    ),
    "time_limit": (
        ("--time-limit",),
        {
            "metavar": "TIME",
            "type": values.duration,
            "help": "the time fTetWild has, as in 90s or 2h (default: 30min)",
        },
    ),
    "force_tets": (("--force",), {"action": "store_true", "help": "write tetrahedra also if much of the part is lost"}),
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
    "after": (
        ("--after",),
        {"metavar": "PASS", "help": "stop after this pass"},
    ),
    "note": (
        ("--note",),
        {
            "choices": ("stage", "axes", "bounds"),
            "help": "what is known of each node, beside it: when its value is "
            "known, which coordinates it depends on, or its range",
        },
    ),
    "stages": (
        ("--stages",),
        {"action": "store_true", "help": "the plan of an output: what is found first, once, and at every point"},
    ),
    "stage": (
        ("--stage",),
        {
            "choices": ("compute", "fragment", "webgl"),
            "default": "compute",
            "help": "compute (the default), or the fragment shader of a picture, for OpenGL or for WebGL 2",
        },
    ),
    "json": (("--json",), {"action": "store_true", "help": "print one JSON value on standard output, nothing else"}),
    "quick": (("--quick",), {"action": "store_true", "help": "a run of a few seconds"}),
    "count": (
        ("--count",),
        {"metavar": "N", "type": values.count, "default": 500, "help": "random programs to try (default: 500)"},
    ),
    "seed": (
        ("--seed",),
        {"metavar": "N", "type": values.count, "help": "the seed of the random programs (default: drawn)"},
    ),
    "quiet": (("-q", "--quiet"), {"action": "store_true", "help": "say nothing but errors and results"}),
}
