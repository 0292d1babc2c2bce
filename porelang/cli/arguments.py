"""The commands, as data: what each does and which options it takes (`options` says what these are)."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Command:
    """A command: what it does in a line, the options it takes (keys of OPTIONS), and an example."""

    name: str
    doc: str
    options: tuple[str, ...]
    example: str


ASK = ("file", "set", "preset", "bind", "out")
REFINE = ("smooth", "sharp", "simplify")
COMMANDS: dict[str, Command] = {
    c.name: c
    for c in (
        Command(
            "check",
            "say everything that is wrong or doubtful in a program",
            ("file", "set", "preset", "bind", "measure", "json", "quiet"),
            "pore check specimen.pore",
        ),
        Command(
            "mesh",
            "write the surface of the part, watertight, in mm: .stl .obj .ply .3mf .glb .vtp",
            (
                *ASK,
                "output",
                "spacing",
                "resolution",
                "bounds",
                *REFINE,
                "force",
                "beams",
                "backend",
                "dtype",
                "json",
                "quiet",
            ),
            "pore mesh specimen.pore -o part.stl --voxel 1mm --set w=25mm",
        ),
        Command(
            "measure",
            "volume, porosity, area, components and more, each with its error; and the checks of the program",
            (*ASK, "within", "voxel", "resolution", "bounds", "backend", "dtype", "json", "quiet"),
            "pore measure specimen.pore --within cyl",
        ),
        Command(
            "fea",
            "solve a study of the program (`let s = compress(part, ...)`): stiffness, stresses, displacements; to .vtu",
            (
                "file",
                "set",
                "preset",
                "bind",
                "out",
                "result",
                "study",
                "refine",
                "within",
                "json",
                "quiet",
            ),
            "pore fea closed_loop.pore -o result.vtu",
        ),
        Command(
            "optimize",
            "the loop from stress back to geometry: solve, thicken where it is borne, restore the porosity, again",
            (
                "file",
                "set",
                "preset",
                "bind",
                "iterate",
                "until",
                "most",
                "rule",
                "early",
                "limits",
                "porosity",
                "adapt",
                "which",
                "within",
                "averaged",
                "damping",
                "resume",
                "anew",
                "loop",
                "json",
                "quiet",
            ),
            "pore optimize beam.pore --until 'change<0.5%' --max 15 -o beam.loop",
        ),
        Command(
            "slices",
            "write layers for printing: PNG or SVG contours in a folder, or one .cli file",
            (*ASK, "folder", "step", "format", "voxel", "bounds", "backend", "dtype", "json", "quiet"),
            "pore slices specimen.pore -o layers --step 0.1mm",
        ),
        Command(
            "volume",
            "write the values of the field on a grid, and of others: .vti for ParaView, .npz for NumPy; "
            "or the field as a function: .3mf",
            (*ASK, "output", "fields", "voxel", "resolution", "bounds", "backend", "dtype", "json", "quiet"),
            "pore volume specimen.pore -o specimen.vti --voxel 1mm",
        ),
        Command(
            "homogenize",
            "what a period of a lattice does as a material: stiffness, moduli by direction, conductivity, with errors",
            (*ASK, "cell", "nu", "voxels", "sweep", "reports", "json", "quiet"),
            "pore homogenize lattice.pore --nu 0.3 -o modulus.png",
        ),
        Command(
            "tet",
            "write the part as tetrahedra, for analysis: .vtu .msh .inp .nas .mesh",
            (
                *ASK,
                "output",
                "tet_size",
                "surface_size",
                "mesher",
                "phases",
                "bounds",
                "keep_islands",
                "time_limit",
                "force_tets",
                "json",
                "quiet",
            ),
            "pore tet specimen.pore -o part.vtu --size 3mm",
        ),
        Command(
            "eval",
            "the value of the field at points",
            (*ASK, "points", "values", "backend", "dtype", "json", "quiet"),
            "pore eval specimen.pore --points points.csv",
        ),
        Command(
            "show",
            "the graph that a program becomes, after any pass; or with --stages the plan of an output",
            (*ASK, "after", "note", "stages", "json"),
            "pore show specimen.pore --after simplify",
        ),
        Command("glsl", "the shader that a program becomes", (*ASK, "stage", "json"), "pore glsl specimen.pore"),
        Command(
            "notation",
            "each step in the notation of the paper, as in (F)(C)(W)(F)",
            ("file", "set", "preset", "bind", "json"),
            "pore notation specimen.pore",
        ),
        Command(
            "render",
            "draw the part, or several outputs, cut open or with fields on planes or on the surface: .png",
            (
                "file",
                "set",
                "preset",
                "bind",
                "outs",
                "bodies",
                "output",
                "view",
                "projection",
                "size",
                "zoom",
                "cut",
                "slice",
                "field",
                "range",
                "legend",
                "deform",
                "ghost",
                "solid",
                "background",
                "samples",
                "axes",
                "scale_bar",
                "frame",
                "bounds",
                "json",
                "quiet",
            ),
            "pore render specimen.pore -o specimen.png --cut 'y<0' --view -60,20",
        ),
        Command(
            "view",
            "draw the part on a page in the browser while the program is written; sliders set its params",
            ("file", "set", "preset", "bind", "window", "port", "no_browser", "stats"),
            "pore view specimen.pore --set w=40mm",
        ),
        Command(
            "watch",
            "carry out a command (check, unless one is named) again at every save of a program or of a file it names",
            ("file", "words"),
            "pore watch specimen.pore -- mesh -o part.stl",
        ),
        Command("new", "write a commented program to begin with", ("fresh",), "pore new bracket.pore"),
        Command("examples", "list the examples, or copy some with the files they read", ("examples",), "pore examples"),
        Command(
            "fmt",
            "write programs in the one style: blanks, indentation, docs and remarks in columns; remarks and lines stay",
            ("files", "keep", "quiet"),
            "pore fmt specimen.pore",
        ),
        Command(
            "repl",
            "a program a line at a time: statements are kept, expressions are shown as what they are",
            ("begun",),
            "pore repl specimen.pore",
        ),
        Command("lsp", "the language server, for editors: on standard input and output", (), "pore lsp"),
        Command(
            "completion",
            "what has bash, zsh or fish complete commands, options and the names of a program",
            ("shell",),
            'eval "$(pore completion bash)"',
        ),
        Command(
            "explain",
            "what a diagnostic means, with an example; all of them without a code",
            ("code", "json"),
            "pore explain E012",
        ),
        Command(
            "cache",
            "what tasks have left on disk: its size (the default), a list, or clear it",
            ("action", "json", "quiet"),
            "pore cache list",
        ),
        Command("doctor", "what of this machine is used, and what is missing", ("json",), "pore doctor"),
        Command(
            "conformance",
            "compare the backends with each other on this machine",
            ("quick", "count", "seed", "json"),
            "pore conformance --quick",
        ),
    )
}
