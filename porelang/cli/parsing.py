"""From words to options: `argparse` does the parsing, and everything that it refuses is said in our words.

Nothing here reads the texts of `argparse`, which differ from one Python to the next: values are read by functions of
ours, what is required is looked for afterwards, and of an `ArgumentError` only the name of the option counts.
"""

from __future__ import annotations

import argparse
import re
from argparse import Namespace
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

from porelang import values
from porelang.cli.arguments import COMMANDS, Command
from porelang.cli.options import OPTIONS
from porelang.diagnostics import PoreError, fail, suggest

#: What other programs call our options.
CALLED = {
    **dict.fromkeys(("--section", "--clip", "--clip-plane"), "--cut"),
    **dict.fromkeys(("--cell-size", "--spacing", "--pitch"), "--voxel"),
    **dict.fromkeys(("--element-size", "--edge-length", "--mesh-size"), "--size"),
    **dict.fromkeys(("--define", "--param"), "--set"),
}
_OF_STUDY = "that is an argument of the study: "
#: What is said elsewhere than by an option, of a command.
ELSEWHERE = {
    **{(command, option): f"{_OF_STUDY}`{how}`" for command in ("fea", "optimize") for option, how in (
        ("--size", "compress(part, 10kN, ..., size=3mm)"), ("--element-size", "compress(part, 10kN, ..., size=3mm)"),
        ("--order", "compress(part, 10kN, ..., order=1)"), ("--material", 'compress(part, 10kN, ..., material="PA12")'),
    )},
    ("fea", "--voxel"): f"elements have a size, and {_OF_STUDY}`compress(part, 10kN, ..., size=3mm)`",
}  # fmt: skip


def parse(argv: Sequence[str]) -> Namespace:
    """The command and its options. Errors: E108. Asked for help or the version, it prints them and exits."""
    if not argv:
        return Namespace(command=None)
    name = argv[0]
    if name == "watch":
        return _parse_watch(argv[1:])
    if name == "completion" and argv[1:2] == ["--"]:
        return Namespace(command=name, words=list(argv[2:]))  # words of another command line, whatever they are
    if name in COMMANDS:
        return _parse(COMMANDS[name], argv[1:])
    if name in ("-h", "--help"):
        _overview().print_help()
        raise SystemExit(0)
    if name == "--version":
        from porelang import __version__

        print(f"pore {__version__}")
        raise SystemExit(0)
    if name.startswith("-") and name != "-":
        raise fail("E108", f"`pore` has no option `{name}`", hint="a command comes first: `pore check specimen.pore`")
    if name.endswith(".pore"):
        raise fail("E108", f"`{name}` is a file, not a command", hint=f"write `pore check {name}`")
    near = suggest(name, COMMANDS)
    raise fail(
        "E108",
        f"there is no command `{name}`",
        hint=f"did you mean `{near}`?" if near else f"the commands are {', '.join(COMMANDS)}",
    )


def _parse(command: Command, words: Sequence[str]) -> Namespace:
    try:
        options, rest = _parser(command).parse_known_args(_joined(words))
    except argparse.ArgumentError as error:
        raise _unusable(command, error.argument_name or "") from None
    if rest:
        raise _unknown(command, rest[0])
    missing = [
        _name(flags, more)
        for flags, more in (OPTIONS[name] for name in command.options)
        if more.get("required") and getattr(options, _attribute(flags, more)) is None
    ]
    if missing:
        raise fail("E108", f"`pore {command.name}` needs {' and '.join(missing)}", hint=f"write `{command.example}`")
    options.command = command.name
    settings: dict[str, str] = {}
    for name, value in getattr(options, "settings", ()):
        if settings.setdefault(name, value) != value:
            raise fail("E084", f"`{name}` is set twice: {settings[name]} and {value}", hint="leave one of the two out")
    return options


def _parse_watch(words: Sequence[str]) -> Namespace:
    """The options of `pore watch` up to its file; what follows is the command line that it carries out."""
    at = next((i for i, word in enumerate(words) if not word.startswith("-") or word == "--"), len(words))
    options = _parse(COMMANDS["watch"], words[: at + 1])
    rest = list(words[at + 1 :])
    options.words = rest[1:] if rest[:1] == ["--"] else rest
    return options


def _name(flags: tuple[str, ...], more: dict[str, Any]) -> str:
    """What an option is called in messages."""
    return flags[-1] if flags[0].startswith("-") else str(more["metavar"])


def _attribute(flags: tuple[str, ...], more: dict[str, Any]) -> str:
    """Where the value of an option stands in the namespace."""
    return str(more.get("dest") or flags[-1].lstrip("-"))


class _Parser(argparse.ArgumentParser):
    """An `argparse` parser that never speaks: whatever it refuses is an `ArgumentError` or a `PoreError`."""

    def error(self, message: str) -> NoReturn:
        raise fail("E108", "the command line cannot be read", hint=f"`{self.prog} --help` lists the options")


class _Once(argparse.Action):
    """An option that has one value: of two the first would be dropped without a word."""

    found: Any = None

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: Namespace, values: Any, option_string: str | None = None
    ) -> None:
        if option_string is not None and self.found not in (None, values):
            raise fail("E108", f"`{option_string}` is given twice", hint="leave one of the two out")
        self.found = values
        setattr(namespace, self.dest, values)


def _parser(command: Command) -> _Parser:
    usage = [f"pore {command.name}"]
    for flags, more in (OPTIONS[name] for name in command.options):
        if not flags[0].startswith("-"):
            usage.append(more["metavar"] if more.get("required") else f"[{more['metavar']}]")
        elif more.get("required"):
            usage.append(f"{flags[0]} {more['metavar']}")
    parser = _Parser(
        f"pore {command.name}",
        usage=" ".join([*usage, "[options]"]),
        description=f"{command.doc[0].upper()}{command.doc[1:]}.",
        epilog=f"example: {command.example}",
        allow_abbrev=False,
        exit_on_error=False,
    )
    for name in command.options:
        flags, more = OPTIONS[name]
        told = {key: value for key, value in more.items() if key not in ("required", "choices", "type")}
        if "action" not in more:
            told["action"] = _Once
        if not flags[0].startswith("-") and told.get("nargs") != "+":
            told.pop("nargs", None)  # before options `argparse` would take it for left out
        if "choices" in more:
            told.setdefault("metavar", f"{{{','.join(more['choices'])}}}")
            told["type"] = _one_of(_name(flags, more), more["choices"])
        elif "type" in more:
            told["type"] = _reader(_name(flags, more), more["type"])
        parser.add_argument(*flags, **told).required = False
    return parser


def _one_of(flag: str, choices: Sequence[str]) -> Callable[[str], str]:
    """A reader of one of these words."""

    def read(text: str) -> str:
        if text in choices:
            return text
        near = suggest(text, choices)
        raise fail(
            "E108",
            f"`{flag}` cannot be `{text}`",
            hint=f"did you mean `{near}`?" if near else f"choose from {', '.join(choices)}",
        )

    return read


def _reader(flag: str, read: Callable[[str], Any]) -> Callable[[str], Any]:
    """The reader of an option's value, whose refusal names the option. It passes through `argparse` as it is."""

    def named(text: str) -> Any:
        try:
            return read(text)
        except values.Unreadable as no:
            raise fail("E108", f"`{flag}`: {no.text}", hint=no.hint) from None

    return named


def _unusable(command: Command, name: str) -> PoreError:
    """Why `argparse` could not give an option, whose spellings it joins with `/`, what it takes."""
    flag = name.split("/")[-1]
    takes = any("action" not in more or more["action"] == "append"
                for flags, more in (OPTIONS[o] for o in command.options) if flag in flags)  # fmt: skip
    return fail(
        "E108",
        f"`{flag}` needs a value" if takes else f"`{flag}` takes no value",
        hint=f"`pore {command.name} --help` lists the options",
    )


def _overview() -> argparse.ArgumentParser:
    """What `pore --help` prints."""
    parser = argparse.ArgumentParser(
        "pore",
        usage="pore COMMAND [options]",
        description="Porous parts as text: check, evaluate and mesh .pore programs.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="exit status: 0 well; 1 the program or a check is at fault; 2 wrong usage;\n"
        "3 a missing piece of this machine. `pore COMMAND --help` says more.",
    )
    parser.add_argument("--version", action="store_true", help="print the version")
    commands = parser.add_subparsers(metavar="COMMAND", title="commands")
    for c in COMMANDS.values():
        commands.add_parser(c.name, help=c.doc)
    return parser


def _joined(words: Sequence[str]) -> list[str]:
    """`--bounds -1,-1,...` as one word: `argparse` would take a value that begins with `-` for an option."""
    out: list[str] = []
    lengths = ("--voxel", "--step", "--size", "--surface-size")
    numbers = (*lengths, "--bounds", "--resolution", "--view", "--range", "--time-limit", "--cell", "--nu")
    for word in words:
        if out and out[-1] in numbers and re.match(r"-[\d.]", word):
            out[-1] += f"={word}"
        else:
            out.append(word)
    return out


def _unknown(command: Command, word: str) -> PoreError:
    """Why a word of the command line has no place there."""
    name = word.split("=")[0]
    flags = [flag for option in command.options for flag in OPTIONS[option][0] if flag.startswith("-")]
    if not word.startswith("-") or word == "-" or name in flags:  # after `--` an option is a word like others
        hint = f"write `{command.example}`"
        if word.endswith(".pore"):
            hint = "one program at a time"
        elif "=" in word and "--set" in flags:
            hint = f"each setting has its own option: `--set {word}`"
        elif "-o" in flags:
            hint = f"what is to be written is named after -o: `-o {word}`"
        return fail("E108", f"`{word}` is one word too many for `pore {command.name}`", hint=hint)
    if why := ELSEWHERE.get((command.name, name)):
        return fail("E108", f"`pore {command.name}` has no option `{name}`", hint=why)
    ours = CALLED.get(name, "")
    near = ours if ours in flags else suggest(name, flags)
    hint = f"did you mean `{near}`?" if near else f"it has {', '.join(flags) or 'none'}"
    if not near and "=" in word and "--set" in flags:
        hint = f"a param is set by `--set {word.lstrip('-')}`"
    return fail("E108", f"`pore {command.name}` has no option `{name}`", hint=hint)
