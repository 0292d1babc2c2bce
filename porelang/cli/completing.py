"""`pore completion`: words of a command line completed by bash, zsh and fish.

The shell asks `pore completion -- WORDS` at every tab, which takes a tenth of a second; so it offers what is there now:
the commands and options of this version, and the params, outputs and presets of the program that the line names.
"""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from porelang.cli.arguments import COMMANDS
from porelang.cli.options import OPTIONS
from porelang.diagnostics import PoreError
from porelang.error_codes import CODES

#: What a shell carries out once, to ask at every tab. Where nothing is offered, files are.
SCRIPTS = {
    "bash": """\
_pore() {
    local IFS=$'\\n'
    COMPREPLY=($(pore completion -- "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null |
        while read -r one; do printf '%q\\n' "$one"; done))
    [[ ${#COMPREPLY[@]} == 1 && "${COMPREPLY[0]}" == *[=/] ]] && compopt -o nospace
}
complete -o default -F _pore pore
""",
    "zsh": """\
#compdef pore
_pore() {
    local -a found
    found=("${(@f)$(pore completion -- "${(@)words[2,CURRENT]}" 2>/dev/null)}")
    if [[ -n "${found[1]}" ]]; then
        compadd -S '' -- ${(M)found:#*[=/]}
        compadd -- ${found:#*[=/]}
    else
        _files
    fi
}
compdef _pore pore
""",
    "fish": """\
function __pore
    set -l words (commandline -opc)[2..-1] (commandline -ct)
    pore completion -- $words 2>/dev/null; or __fish_complete_path $words[-1]
end
complete -c pore -f -a '(__pore)'
""",
}


def completion(options: Namespace) -> int:
    """Print what a shell carries out; or, asked for words, what the last of them may become, a line each."""
    words = getattr(options, "words", None)
    if words is None:
        print(SCRIPTS[options.shell], end="")
        return 0
    found = offered(words)
    for one in found:
        print(one)
    return 0 if found else 1


def offered(words: Sequence[str]) -> list[str]:
    """What the last word may become; nothing where it names a file of any kind."""
    *before, word = words or [""]
    if not before:
        return _begins(word, [*COMMANDS, "--help", "--version"])
    command = COMMANDS.get(before[0])
    if command is None:
        return []
    if command.name == "watch" and (at := _command_of_watch(before)) is not None:
        return offered([before[at], *before[1:at], *before[at + 1 :], word])
    flags = {flag: more for key in command.options for flag in OPTIONS[key][0] for more in OPTIONS[key][1:]
             if flag.startswith("-")}  # fmt: skip
    asked = flags.get(before[-1])
    if asked is not None and asked.get("action") != "store_true":
        return _begins(word, _values(before[-1], asked, before))
    if word.startswith("-"):
        return _begins(word, [*flags, "--help"])
    for key in command.options:
        names, more = OPTIONS[key]
        if names[0].startswith("-"):
            continue
        if "choices" in more:
            return _begins(word, more["choices"])
        if key in _WORDS:
            return _begins(word, _WORDS[key]())
        if more["metavar"] == "FILE":
            return _programs(word)
    return []


def _command_of_watch(before: Sequence[str]) -> int | None:
    """Where the command stands that `pore watch FILE -- COMMAND` carries out."""
    rest = [i for i, word in enumerate(before) if i > 1 and word in COMMANDS]
    return rest[0] if rest else None


def _examples() -> Iterable[str]:
    from porelang.cli.starting import shown

    return shown()


#: What stands for no file, by the key of the option.
_WORDS: dict[str, Callable[[], Iterable[str]]] = {"code": lambda: sorted(CODES), "examples": _examples}


def _values(flag: str, more: dict[str, Any], before: Sequence[str]) -> list[str]:
    """What may follow an option: its choices, or names of the program that the line names."""
    if "choices" in more:
        return list(more["choices"])
    file = next((word for word in before[1:] if word.endswith(".pore") and Path(word).is_file()), None)
    if file is None or flag not in _NAMES:
        return []
    from porelang.compiler import compile

    try:
        return list(_NAMES[flag](compile(path=file)))
    except PoreError:
        return []  # a program that does not compile has none; `pore check` says why


#: The names of a program that an option takes.
_NAMES: dict[str, Callable[[Any], Iterable[str]]] = {
    "--set": lambda program: (f"{name}=" for name in program.params),
    "--bind": lambda program: (f"{name}=" for name in program.data),
    "--out": lambda program: program.outputs,
    "--iterate": lambda program: program.outputs,
    "--preset": lambda program: program.presets,
}


def _programs(word: str) -> list[str]:
    """Programs and folders whose path begins so."""
    head, slash, name = word.rpartition("/")
    folder = Path(head + slash) if slash else Path()
    try:
        there = sorted(folder.iterdir())
    except OSError:
        return []
    named = [f"{head}{slash}{p.name}/" if p.is_dir() else f"{head}{slash}{p.name}" for p in there
             if (p.is_dir() and (name or not p.name.startswith("."))) or p.suffix == ".pore"]  # fmt: skip
    return _begins(word, named)


def _begins(word: str, found: Iterable[str]) -> list[str]:
    return [one for one in found if one.startswith(word)]
