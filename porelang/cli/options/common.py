"""The options of more than one room, and of commands that look at a program."""

from __future__ import annotations

from porelang import values
from porelang.cli.options.option import Option

COMMON: dict[str, Option] = {
    "file": (
        ("file",),
        {"metavar": "FILE", "required": True, "help": "the program, a .pore file; - reads standard input"},
    ),
    "no_browser": (
        ("--no-browser",),
        {"action": "store_true", "dest": "no_browser", "help": "print the address of the page, and open it nowhere"},
    ),
    "window": (
        ("--window",),
        {
            "action": "store_true",
            "help": "in a window of the system in place of a page, params by keys",
        },
    ),
    "port": (
        ("--port",),
        {"metavar": "N", "type": values.count, "help": "of this machine, for the page (default: one that is free)"},
    ),
    "stats": (("--stats",), {"action": "store_true", "help": "show on the page how long pictures take"}),
    "fresh": (
        ("name",),
        {"metavar": "NAME", "required": True, "help": "the program; no file of that name is there yet"},
    ),
    "examples": (("names",), {"metavar": "NAME", "nargs": "+", "help": "examples to copy into this folder"}),
    "shell": (
        ("shell",),
        {"metavar": "SHELL", "required": True, "choices": ("bash", "zsh", "fish"), "help": "bash, zsh or fish"},
    ),
    "begun": (("file",), {"metavar": "FILE", "help": "a program whose statements are there at once"}),
    "files": (
        ("files",),
        {
            "metavar": "FILE",
            "nargs": "+",
            "required": True,
            "help": "programs; - writes standard input anew",
        },
    ),
    "keep": (
        ("--check",),
        {"action": "store_true", "dest": "check", "help": "write nothing; exit status 1 where a file would be changed"},
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
