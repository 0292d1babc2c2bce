"""What may stand on the command line, as data and an `argparse` parser that speaks in the voice of the language."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

from porelang.diagnostics import fail, suggest
from porelang.units import LENGTH, UNITS


@dataclass(frozen=True, slots=True)
class Command:
    """A command: what it does in a line, the options it takes (keys of OPTIONS), and an example."""

    name: str
    doc: str
    options: tuple[str, ...]
    example: str


ASK = ("file", "set", "out")
REFINE = ("smooth", "sharp", "simplify")
COMMANDS: dict[str, Command] = {
    c.name: c
    for c in (
        Command(
            "check",
            "say everything that is wrong or doubtful in a program",
            ("file", "set", "measure", "json", "quiet"),
            "pore check specimen.pore",
        ),
        Command(
            "mesh",
            "write the surface of the part, watertight, in mm: .stl .obj .ply .3mf .glb .vtp",
            (*ASK, "output", "voxel", "resolution", "bounds", *REFINE, "backend", "dtype", "json", "quiet"),
            "pore mesh specimen.pore -o part.stl --voxel 1mm --set w=25mm",
        ),
        Command(
            "measure",
            "volume, porosity, area, components and more, each with its error; and the checks of the program",
            (*ASK, "within", "voxel", "resolution", "bounds", "backend", "dtype", "json", "quiet"),
            "pore measure specimen.pore --within cyl",
        ),
        Command(
            "slices",
            "write layers for printing into a folder, as PNG or as SVG contours",
            (*ASK, "folder", "step", "format", "voxel", "bounds", "backend", "dtype", "json", "quiet"),
            "pore slices specimen.pore -o layers --step 0.1mm",
        ),
        Command(
            "eval",
            "the value of the field at points",
            (*ASK, "points", "values", "backend", "dtype", "json", "quiet"),
            "pore eval specimen.pore --points points.csv",
        ),
        Command(
            "show",
            "the graph that a program becomes, after any pass",
            ("file", "out", "after", "json"),
            "pore show specimen.pore --after simplify",
        ),
        Command(
            "glsl", "the shader that a program becomes", ("file", "out", "stage", "json"), "pore glsl specimen.pore"
        ),
        Command(
            "notation",
            "each step in the notation of the paper, as in (F)(C)(W)(F)",
            ("file", "json"),
            "pore notation specimen.pore",
        ),
        Command(
            "render",
            "draw the part, cut open or with fields on planes: .png",
            (
                *ASK,
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
                "solid",
                "background",
                "samples",
                "bounds",
                "json",
                "quiet",
            ),
            "pore render specimen.pore -o specimen.png --cut 'y<0' --view -60,20",
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


def length(text: str) -> float:
    """`1mm`, `0.5`, `1e-1cm` in mm."""
    match = re.fullmatch(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([A-Za-z]*)", text.strip())
    unit = UNITS.get(match[2] or "mm") if match else None
    if match is None or unit is None or unit.dimension != LENGTH:
        raise argparse.ArgumentTypeError(f"`{text}` is no length: write 1mm or 0.5")
    value = float(match[1]) * unit.scale
    if not (math.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f"{text} is no length to sample at: it must be above 0")
    return value


def count(text: str) -> int:
    """A whole number above 0."""
    if not text.isascii() or not text.isdigit() or len(text) > 10 or int(text) < 1:
        raise argparse.ArgumentTypeError(f"`{text}` is no count: write a whole number above 0")
    return int(text)


def box(text: str) -> tuple[float, ...]:
    """`x0,y0,z0,x1,y1,z1` in mm, the lower corner first."""
    try:
        values = tuple(float(v) for v in text.split(","))
    except ValueError:
        values = ()
    if len(values) != 6 or not all(map(math.isfinite, values)):
        raise argparse.ArgumentTypeError(f"`{text}` are no bounds: write six numbers, x0,y0,z0,x1,y1,z1, in mm")
    for axis, lo, hi in zip("xyz", values[:3], values[3:], strict=True):
        if lo >= hi:
            raise argparse.ArgumentTypeError(
                f"the bounds are empty along {axis}, from {lo:g} to {hi:g}: the lower corner comes first"
            )
    return values


def setting(text: str) -> tuple[str, str]:
    """`NAME=VALUE`."""
    name, sign, value = text.partition("=")
    if not (sign and name.strip() and value.strip()):
        raise argparse.ArgumentTypeError(f"`{text}` sets nothing: write NAME=VALUE, as in w=25mm")
    return name.strip(), value.strip()


def lazily(name: str) -> Callable[[str], Any]:
    """A reader of values from `porelang.cli.render`, imported only by those who draw."""

    def read(text: str) -> Any:
        from porelang.cli import render

        return getattr(render, name)(text)

    return read


OPTIONS: dict[str, tuple[tuple[str, ...], dict[str, Any]]] = {
    "file": (("file",), {"metavar": "FILE", "help": "the program, a .pore file"}),
    "code": (("code",), {"metavar": "CODE", "nargs": "?", "help": "the code of a diagnostic, as in E012"}),
    "action": (
        ("action",),
        {
            "metavar": "ACTION",
            "nargs": "?",
            "choices": ("list", "size", "clear"),
            "default": "size",
            "help": "list, size or clear (default: size); PORELANG_CACHE_LIMIT=500MB in the environment sets the limit",
        },
    ),
    "set": (
        ("--set",),
        {
            "metavar": "NAME=VALUE",
            "type": setting,
            "action": "append",
            "default": [],
            "dest": "settings",
            "help": "give a param a value, units allowed; repeat it for several",
        },
    ),
    "out": (("--out",), {"metavar": "NAME", "help": "which output of the program (default: part)"}),
    "measure": (
        ("--measure",),
        {"action": "store_true", "help": "look at checks about whole fields too (a porosity): takes seconds"},
    ),
    "within": (
        ("--within",),
        {
            "metavar": "NAME",
            "help": "the envelope: an output or a let (default: the largest shape the part is intersected with)",
        },
    ),
    "folder": (("-o", "--output"), {"metavar": "DIR", "required": True, "help": "the folder to write"}),
    "step": (
        ("--step",),
        {"metavar": "LENGTH", "type": length, "required": True, "help": "the thickness of a layer, as in 0.1mm"},
    ),
    "format": (("--format",), {"choices": ("png", "svg"), "default": "png", "help": "pictures, or contours in mm"}),
    "output": (("-o", "--output"), {"metavar": "FILE", "required": True, "help": "the file to write"}),
    "values": (("-o", "--output"), {"metavar": "V.npy", "help": "write the values to a file, not to standard output"}),
    "points": (
        ("--points",),
        {
            "metavar": "P",
            "required": True,
            "help": ".npy of shape (n, 3), or .csv of x,y,z; `-` reads CSV from standard input",
        },
    ),
    "voxel": (("--voxel",), {"metavar": "LENGTH", "type": length, "help": "the spacing of the samples, as in 0.5mm"}),
    "resolution": (
        ("--resolution",),
        {"metavar": "N", "type": count, "help": "samples along the longest side (default: 128)"},
    ),
    "smooth": (("--smooth",), {"action": "store_true", "help": "move the vertices onto the field"}),
    "sharp": (("--sharp",), {"action": "store_true", "help": "sharp rims where surfaces meet; includes --smooth"}),
    "simplify": (
        ("--simplify",),
        {
            "metavar": "DEVIATION",
            "type": length,
            "help": "as few triangles as stay within this distance of the mesh, as in 0.05mm",
        },
    ),
    "bounds": (
        ("--bounds",),
        {
            "metavar": "x0,y0,z0,x1,y1,z1",
            "type": box,
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
            "type": lazily("view"),
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
            "type": lazily("picture_size"),
            "default": (800, 600),
            "help": "in pixels (default: 800x600)",
        },
    ),
    "zoom": (
        ("--zoom",),
        {"metavar": "FACTOR", "type": lazily("factor"), "default": 1.0, "help": "2 shows the middle twice as large"},
    ),
    "cut": (
        ("--cut",),
        {
            "metavar": "'y<0'",
            "type": lazily("cut"),
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
            "type": lazily("plane"),
            "action": "append",
            "default": [],
            "help": "draw the field on a plane: red negative, yellow near zero, blue positive; repeat it for several",
        },
    ),
    "field": (("--field",), {"metavar": "NAME", "help": "which output or `let` the planes show (default: the part)"}),
    "range": (
        ("--range",),
        {
            "metavar": "LO..HI",
            "type": lazily("value_range"),
            "help": "the values of full red and full blue (default: found on the planes)",
        },
    ),
    "legend": (
        ("--legend",),
        {
            "metavar": "TEXT",
            "nargs": "?",
            "const": "",
            "help": "draw the scale of the planes with its numbers, and TEXT above it (default: the field's unit)",
        },
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
            "type": lazily("fineness"),
            "default": 3,
            "help": "N x N samples are averaged for each pixel (default: 3)",
        },
    ),
    "after": (
        ("--after",),
        {"metavar": "PASS", "help": "stop after this pass, with what it found out beside each node"},
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
        {"metavar": "N", "type": count, "default": 500, "help": "random programs to try (default: 500)"},
    ),
    "seed": (("--seed",), {"metavar": "N", "type": count, "help": "the seed of the random programs (default: drawn)"}),
    "quiet": (("-q", "--quiet"), {"action": "store_true", "help": "say nothing but errors and results"}),
}


class Parser(argparse.ArgumentParser):
    """An `argparse` parser whose errors are diagnostics."""

    def error(self, message: str) -> NoReturn:
        text, hint = _restated(self.prog, message)
        raise fail("E108", text, hint=hint)


def _restated(prog: str, message: str) -> tuple[str, str]:
    """`argparse`'s message, with a hint, in our words."""
    text, hint = message, f"`{prog} --help` lists the options"
    if match := re.fullmatch(r"argument ([^:]+): (.*)", message, re.DOTALL):
        option, reason = match[1].split("/")[-1], match[2]
        if choice := re.match(r"invalid choice: '(.*?)' \(choose from (.*)\)", reason):
            options = [o.strip(" '") for o in choice[2].split(",")]
            near = suggest(choice[1], options)
            text = f"`{option}` cannot be `{choice[1]}`"
            hint = f"did you mean `{near}`?" if near else f"choose from {', '.join(options)}"
        elif reason.startswith("expected"):
            text = f"`{option}` needs a value"
        else:
            head, sign, tail = reason.rpartition(": ")
            text, hint = (head, tail) if sign else (reason, hint)
            text = f"`{option}`: {text}"
    elif match := re.fullmatch(r"the following arguments are required: (.*)", message):
        missing = [m.split("/")[-1] for m in match[1].split(", ")]
        text = f"`{prog}` needs {' and '.join(missing)}"
        command = COMMANDS.get(prog.split()[-1])
        hint = f"write `{command.example}`" if command else hint
    return text, hint


def parse(argv: Sequence[str]) -> argparse.Namespace:
    """The command and its options. Errors: E108. Asked for help or the version, it prints them and exits."""
    if argv and not argv[0].startswith("-") and argv[0] not in COMMANDS:
        near = suggest(argv[0], COMMANDS)
        if argv[0].endswith(".pore"):
            raise fail("E108", f"`{argv[0]}` is a file, not a command", hint=f"write `pore check {argv[0]}`")
        raise fail(
            "E108",
            f"there is no command `{argv[0]}`",
            hint=f"did you mean `{near}`?" if near else f"the commands are {', '.join(COMMANDS)}",
        )
    parser = _parser(argv[0] if argv and argv[0] in COMMANDS else None)
    options, rest = parser.parse_known_args(_joined(argv))
    if rest:
        _refuse(options.command, rest[0])
    return options


def _parser(only: str | None) -> Parser:
    """The parser; of the commands in full only the one that is used, which halves the time to start."""
    from porelang import __version__

    parser = Parser(
        "pore",
        description="Porous parts as text: check, evaluate and mesh .pore programs.",
        allow_abbrev=False,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="exit status: 0 well; 1 the program or a check is at fault; 2 wrong usage;\n"
        "3 a missing piece of this machine. `pore COMMAND --help` says more.",
    )
    parser.add_argument("--version", action="version", version=f"pore {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", title="commands")
    for c in COMMANDS.values():
        if only not in (None, c.name):
            continue
        sub = commands.add_parser(
            c.name,
            prog=f"pore {c.name}",
            help=c.doc,
            description=f"{c.doc[0].upper()}{c.doc[1:]}.",
            epilog=f"example: {c.example}",
            allow_abbrev=False,
        )
        for name in c.options:
            flags, more = OPTIONS[name]
            sub.add_argument(*flags, **more)
    return parser


def _joined(argv: Sequence[str]) -> list[str]:
    """`--bounds -1,-1,...` as one word: `argparse` would take a value that begins with `-` for an option."""
    out: list[str] = []
    numbers = ("--bounds", "--voxel", "--resolution", "--step", "--view", "--range")
    for word in argv:
        if out and out[-1] in numbers and re.match(r"-[\d.]", word):
            out[-1] += f"={word}"
        else:
            out.append(word)
    return out


def _refuse(command: str | None, word: str) -> NoReturn:
    """Say why a word of the command line has no place there."""
    if command is None:
        raise fail("E108", f"`pore` has no option `{word}`", hint="a command comes first: `pore check specimen.pore`")
    if not word.startswith("-") or word == "-":
        raise fail(
            "E108", f"`{word}` is one word too many for `pore {command}`", hint=f"write `{COMMANDS[command].example}`"
        )
    name = word.split("=")[0]
    flags = [flag for option in COMMANDS[command].options for flag in OPTIONS[option][0] if flag.startswith("-")]
    near = suggest(name, flags)
    raise fail(
        "E108",
        f"`pore {command}` has no option `{name}`",
        hint=f"did you mean `{near}`?" if near else f"it has {', '.join(flags) or 'none'}",
    )
