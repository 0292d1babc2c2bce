"""The storeys of docs/architecture.md: a module imports from its own or those below, and in no circle; the lower ones
are pure."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator, Mapping, Set
from functools import cache
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parent.parent / "porelang"

#: The storey of a module or a package by its name below `porelang`; the longest name that fits counts.
STOREYS = {
    "": 0,  # porelang/__init__.py: names only, and what it hands on it imports when asked
    "source": 0, "diagnostics": 0, "error_codes": 0, "units": 0, "resources": 0, "cache": 0, "once": 0, "progress": 0,
    "atomic": 0, "limits": 0, "failures": 0, "parallel": 0,
    "compiled": 0,
    "interval": 1, "ir": 1, "data": 1, "store": 1, "ops": 1, "rewrite": 1,
    "tape": 2, "formula": 2, "rewrites": 2, "analysis": 2, "backends": 2,
    "syntax": 3, "elaborate": 3,
    "materials": 0,
    "solid": 4, "walls": 4, "children": 4, "tet": 4, "fea": 4, "unitcell": 4, "tasks": 4, "gpu": 4, "files": 4,
    "stamps": 4,
    "settings": 5, "program": 5, "field": 5, "doors": 5, "contracts": 5, "doubts": 5, "checks": 5, "refusals": 5,
    "compiler": 5, "extents": 5, "outputs": 5, "expression": 5,
    "mesh": 6, "measure": 6, "pieces": 6, "render": 6, "slices": 6, "volume": 6, "threemf": 6, "notation": 6,
    "tetrahedra": 6, "strength": 6, "homogenize": 6, "optimize": 6,
    "conformance": 6, "session": 6, "assist": 6, "cli": 7, "lsp": 7, "repl": 7, "preview": 7, "__main__": 7,
    "html": 0, "highlight": 6, "bound": 5, "values": 5, "picture": 5, "asked": 6, "notebook": 7,
}  # fmt: skip
PURE = 3
#: What a pure storey does without: files, devices, other programs, and packages that take long to import.
WORLDLY = {
    "moderngl", "numba", "trimesh", "scipy", "skfem", "pyamg", "meshio", "pytetwild",
    "subprocess", "socket", "time", "tempfile", "shutil",
}  # fmt: skip
#: Where the package's own resources and the user's cache are read and files are written: the only ones below.
READERS = {"resources", "cache", "store", "elaborate.prelude", "atomic"}
#: The one place that knows of the compiler of loops.
COMPILER = "compiled"
#: Methods that only hand on to a storey above: an import, and a call of what it brought.
DOORS = {
    "doors": {
        "mesh", "measure", "tet", "study", "iterate", "slices", "render", "homogenize", "view", "_repr_mimebundle_",
    },
    "field": {"_repr_png_"},
}  # fmt: skip

MODULES = {
    ".".join(path.relative_to(PACKAGE).with_suffix("").parts).removesuffix("__init__").removesuffix("."): path
    for path in sorted(PACKAGE.rglob("*.py"))
}


def storey(name: str) -> int:
    top = name.split(".")[0]
    assert top in STOREYS, f"porelang.{name} has no storey: say in STOREYS and in docs/architecture.md where it belongs"
    return STOREYS[top]


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


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

    yield from visit(tree(path))


def doors_of(path: Path, names: Set[str]) -> set[int]:
    """The lines on which doors import: methods of these names that hold nothing but that import and a call."""
    lines: set[int] = set()
    for node in ast.walk(tree(path)):
        match node:
            case ast.FunctionDef(
                name=name, body=[ast.Expr(), ast.ImportFrom(lineno=line), ast.Return(value=ast.Call())]
            ):
                lines |= {line} if name in names else set()
    return lines


def named(path: Path, doors: Set[str] = frozenset()) -> set[str]:
    """The modules of ours that a file names in any import: also those for the type checker, and inside functions."""
    found: set[str] = set()
    skipped = doors_of(path, doors)
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.lineno not in skipped:
            module = node.module or ""
            parts = {f"{module}.{alias.name}" for alias in node.names}
            modules = {part for part in parts if own(part) is not None}
            found |= modules | ({module} if parts - modules else set())
    return {target for name in found if (target := own(name)) is not None}


def circles(uses: Mapping[str, Set[str]]) -> list[list[str]]:
    """The groups of modules each of which needs all others of its group (R. Tarjan, Depth-first search, 1972)."""
    number: dict[str, int] = {}
    low: dict[str, int] = {}
    waiting: list[str] = []
    found: list[list[str]] = []

    def visit(name: str) -> None:
        number[name] = low[name] = len(number)
        waiting.append(name)
        for other in sorted(uses[name]):
            if other not in number:
                visit(other)
                low[name] = min(low[name], low[other])
            elif other in waiting:
                low[name] = min(low[name], number[other])
        if low[name] == number[name]:
            at = waiting.index(name)
            if len(waiting) - at > 1 or name in uses[name]:
                found.append(sorted(waiting[at:]))
            del waiting[at:]

    for name in sorted(uses):
        if name not in number:
            visit(name)
    return sorted(found)


def own(name: str) -> str | None:
    """The module of ours that an import names, without `porelang.`; None for another's, or for a name in a module."""
    top, _, rest = name.partition(".")
    return rest if top == "porelang" and rest in MODULES and rest else None


@pytest.mark.parametrize("name", sorted(MODULES))
def test_module_imports_from_its_storey_or_below(name: str) -> None:
    if not name:
        return  # `porelang` hands on `compile`, lazily
    here = storey(name)
    doors = doors_of(MODULES[name], DOORS.get(name, set()))
    above = [
        f"porelang/{name.replace('.', '/')}:{line} (storey {here}) imports porelang.{target} (storey {storey(target)})"
        for imported, line in imports(MODULES[name])
        if (target := own(imported)) is not None and storey(target) > here and line not in doors
    ]
    assert not above


def test_no_module_is_in_a_circle() -> None:
    """A circle is one module in several files: none of them can be read, tested or replaced without the others."""
    uses = {name: named(path, DOORS.get(name, frozenset())) for name, path in MODULES.items() if name}
    assert circles(uses) == []


def test_circles_are_found() -> None:
    uses = {"a": {"b"}, "b": {"c"}, "c": {"b", "d"}, "d": set(), "e": {"e"}, "f": {"a", "e"}}
    assert circles(uses) == [["b", "c"], ["e"]]


def test_imports_for_types_and_inside_functions_count(tmp_path: Path) -> None:
    path = tmp_path / "module.py"
    path.write_text(
        "from porelang import units\nif TYPE_CHECKING:\n    from porelang.program import Program\n"
        "def f():\n    import porelang.cache\n    from porelang.ops import TABLE\n    from porelang.mesh import weld\n"
    )
    assert named(path) == {"units", "program", "cache", "ops", "mesh.weld"}


@pytest.mark.parametrize("name", sorted(n for n in MODULES if storey(n) <= PURE))
def test_lower_storeys_are_pure(name: str) -> None:
    if name in READERS:
        return
    path = MODULES[name]
    worldly = WORLDLY - ({"numba"} if name == COMPILER else set())
    found = [f"{imported} (line {line})" for imported, line in imports(path) if imported.split(".")[0] in worldly]
    calls = [
        f"{node.func.id if isinstance(node.func, ast.Name) else node.func.attr} (line {node.lineno})"
        for node in ast.walk(tree(path))
        if isinstance(node, ast.Call)
        and (
            (isinstance(node.func, ast.Name) and node.func.id == "open")
            or (isinstance(node.func, ast.Attribute) and node.func.attr in {"read_text", "read_bytes", "write_text"})
        )
    ]
    assert not found + calls


def test_nothing_that_is_read_can_run_code() -> None:
    """Files are data: no module reads a format that can. (The GPU's child is spoken to through a socket of our own.)"""
    unsafe = {"pickle", "marshal", "shelve", "dill", "joblib"}
    assert not [
        f"{name}:{line} imports {imported}"
        for name, path in MODULES.items()
        for imported, line in imports(path)
        if imported.split(".")[0] in unsafe
    ]


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
