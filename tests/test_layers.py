"""The storeys of docs/architecture.md: a module imports from its own or those below; the lower ones are pure."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parent.parent / "porelang"

#: The storey of a module or a package by its name below `porelang`; the longest name that fits counts.
STOREYS = {
    "": 0,  # porelang/__init__.py: names only, and what it hands on it imports when asked
    "source": 0, "diagnostics": 0, "error_codes": 0, "units": 0, "resources": 0, "cache": 0, "progress": 0,
    "compiled": 0,
    "interval": 1, "ir": 1, "data": 1, "store": 1, "ops": 1, "rewrite": 1,
    "rewrites": 2, "analysis": 2, "backends": 2,
    "syntax": 3, "elaborate": 3,
    "tasks": 4, "gpu": 4, "files": 4,
    "contracts": 5, "program": 5, "settings": 5, "mesh": 5, "measure": 5, "render": 5, "slices": 5, "notation": 5,
    "conformance": 5,
    "cli": 6, "__main__": 6,
}  # fmt: skip
PURE = 3
#: What a pure storey does without: files, devices, other programs, and packages that take long to import.
WORLDLY = {"moderngl", "numba", "trimesh", "scipy", "subprocess", "socket", "time", "tempfile", "shutil"}
#: Where the package's own resources and the user's cache are read: the only files of the lower storeys.
READERS = {"resources", "cache", "store", "elaborate.prelude"}
#: The one place that knows of the compiler of loops.
COMPILER = "compiled"


MODULES = {
    ".".join(path.relative_to(PACKAGE).with_suffix("").parts).removesuffix("__init__").removesuffix("."): path
    for path in sorted(PACKAGE.rglob("*.py"))
}


def storey(name: str) -> int:
    top = name.split(".")[0]
    assert top in STOREYS, f"porelang.{name} has no storey: say in STOREYS and in docs/architecture.md where it belongs"
    return STOREYS[top]


def imports(path: Path) -> Iterator[tuple[str, int]]:
    """The modules that a file imports at run time, with the line; imports for the type checker alone do not count."""

    def visit(node: ast.AST) -> Iterator[tuple[str, int]]:
        match node:
            case ast.If(test=ast.Name(id="TYPE_CHECKING")):
                return
            case ast.Import():
                for alias in node.names:
                    yield alias.name, node.lineno
            case ast.ImportFrom():
                assert node.level == 0, f"{path}:{node.lineno}: relative import"
                yield node.module or "", node.lineno
                for alias in node.names:
                    yield f"{node.module}.{alias.name}", node.lineno
        for child in ast.iter_child_nodes(node):
            yield from visit(child)

    yield from visit(ast.parse(path.read_text(encoding="utf-8")))


def own(name: str) -> str | None:
    """The module of ours that an import names, without `porelang.`; None for another's, or for a name in a module."""
    top, _, rest = name.partition(".")
    return rest if top == "porelang" and rest in MODULES and rest else None


@pytest.mark.parametrize("name", sorted(MODULES))
def test_module_imports_from_its_storey_or_below(name: str) -> None:
    if not name:
        return  # `porelang` hands on `compile`, lazily
    here = storey(name)
    above = [
        f"porelang/{name.replace('.', '/')}:{line} (storey {here}) imports porelang.{target} (storey {storey(target)})"
        for imported, line in imports(MODULES[name])
        if (target := own(imported)) is not None and storey(target) > here
    ]
    assert not above


@pytest.mark.parametrize("name", sorted(n for n in MODULES if storey(n) <= PURE))
def test_lower_storeys_are_pure(name: str) -> None:
    if name in READERS:
        return
    path = MODULES[name]
    worldly = WORLDLY - ({"numba"} if name == COMPILER else set())
    found = [f"{imported} (line {line})" for imported, line in imports(path) if imported.split(".")[0] in worldly]
    calls = [
        f"{node.func.id if isinstance(node.func, ast.Name) else node.func.attr} (line {node.lineno})"
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call)
        and (
            (isinstance(node.func, ast.Name) and node.func.id == "open")
            or (isinstance(node.func, ast.Attribute) and node.func.attr in {"read_text", "read_bytes", "write_text"})
        )
    ]
    assert not found + calls


def test_every_storey_is_in_the_picture() -> None:
    """docs/architecture.md names every module or package of the table above."""
    text = (PACKAGE.parent / "docs" / "architecture.md").read_text(encoding="utf-8")
    missing = [top for top in STOREYS if top and f"`{top}.py`" not in text and f"`{top}/`" not in text]
    assert not missing


def test_nothing_is_imported_that_check_does_not_need() -> None:
    """`pore check` is fast because the heavy packages are imported only by those who need them."""
    code = (
        "import sys; from porelang.cli import main; assert main(['check', sys.argv[1], '-q']) == 0;"
        "print([m for m in ('trimesh', 'moderngl', 'numba', 'scipy', 'PIL') if m in sys.modules])"
    )
    example = PACKAGE.parent / "examples" / "specimen.pore"
    done = subprocess.run([sys.executable, "-c", code, str(example)], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
