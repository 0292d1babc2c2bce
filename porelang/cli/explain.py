"""`pore explain`: what a diagnostic means."""

from __future__ import annotations

from argparse import Namespace
from dataclasses import asdict

from porelang.cli import report
from porelang.diagnostics import fail, suggest
from porelang.error_codes import CODES, Code


def explain(options: Namespace) -> int:
    """Print the page of a code; without one, the list of all. Errors: E108 for a code that does not exist."""
    code, as_json = options.code, options.json
    if code is None:
        if as_json:
            report.put([asdict(CODES[name]) for name in sorted(CODES)])
        else:
            for name, page in sorted(CODES.items()):
                print(f"{name}  {page.title}")
        return 0
    name = code.upper()
    if name.isdigit():
        name = f"E{name:0>3}"
    if name not in CODES:
        near = suggest(name, CODES)
        raise fail(
            "E108",
            f"there is no diagnostic `{code}`",
            hint=f"did you mean `{near}`? `pore explain` lists all" if near else "`pore explain` lists all",
        )
    if as_json:
        report.put(asdict(CODES[name]))
    else:
        print(page_text(CODES[name]))
    return 0


def page_text(page: Code) -> str:
    """A page as it is printed."""
    parts = [f"{page.code}: {page.title}", page.explanation]
    for heading, example in (("Wrong:", page.wrong), ("Right:", page.right)):
        if example:
            parts.append("\n".join([heading, *(f"    {line}" for line in example.strip().splitlines())]))
    return "\n\n".join(parts)
