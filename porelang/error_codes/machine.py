"""E120-E199: this machine, and ourselves."""

from __future__ import annotations

from porelang.error_codes.page import Code

MACHINE = (
    Code(
        "E120",
        "no OpenGL on this machine",
        "GLSL runs on OpenGL 4.3 or newer, on a graphics card or on Mesa's software driver; the hint says how to\n"
        "install that. NumPy needs none of it and gives the same numbers.",
        "",
        "",
    ),
    Code(
        "E121",
        "a program that is too long for a shader",
        "Drivers take minutes over shaders of many thousand operations. NumPy does not: use --backend numpy.",
        "",
        "",
    ),
    Code(
        "E122",
        "a graphics driver that failed",
        "The driver rejected the shader, crashed or took too long. NumPy gives the same numbers; `pore doctor`\n"
        "examines the driver.",
        "",
        "",
    ),
    Code(
        "E123",
        "GLSL in double precision",
        "GLSL has no sines in double precision. Use f32, or NumPy.",
        "",
        "",
    ),
    Code(
        "E124",
        "not enough memory",
        "That does not fit into this machine's memory, or into what this process may use of it (`ulimit -v`): the\n"
        "message then names the limit. A larger voxel, smaller bounds or fewer points help.",
        "",
        "",
    ),
    Code(
        "E125",
        "a graphics driver whose process was ended",
        "Drivers run in a process of their own, for they crash. This one was ended before it answered, by the system\n"
        "where memory is short or a limit was set (`ulimit -v`, a container's), or by somebody. Nothing has to be\n"
        "installed. NumPy computes the same numbers without a driver: --backend numpy.",
        "",
        "",
    ),
    Code(
        "E126",
        "a package that a command needs",
        "Some commands need a package that the others do without; the hint says how to install it.",
        "",
        "",
    ),
    Code(
        "E199",
        "a bug in porelang",
        "Something went wrong in porelang itself. Please report it with the program and the command; with\n"
        "PORELANG_DEBUG=1 in the environment the place is shown.",
        "",
        "",
    ),
)
