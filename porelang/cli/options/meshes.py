"""The options of what is made of a part: meshes, tetrahedra, layers."""

from __future__ import annotations

from porelang import values
from porelang.cli.options.option import Option

MESHES: dict[str, Option] = {
    "folder": (
        ("-o", "--output"),
        {"metavar": "DIR", "type": values.output, "required": True, "help": "the folder to write, or a .cli file"},
    ),
    "step": (
        ("--step",),
        {"metavar": "LENGTH", "type": values.length, "required": True, "help": "the thickness of a layer, as in 0.1mm"},
    ),
    "format": (("--format",), {"choices": ("png", "svg"), "help": "pictures (the default), or contours in mm"}),
    "output": (
        ("-o", "--output"),
        {"metavar": "FILE", "type": values.output, "required": True, "help": "the file to write"},
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
    "beams": (
        ("--beams",),
        {"action": "store_true", "help": "in .3mf, write a truss or a frame as bars in place of triangles"},
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
}
