"""The wheel holds all that a program needs, away from the checkout."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)],
        cwd=ROOT, check=True, capture_output=True,
    )  # fmt: skip
    (built,) = folder.glob("*.whl")
    return built


def test_wheel_holds_what_lies_beside_the_package_in_a_checkout(wheel: Path) -> None:
    inside = set(zipfile.ZipFile(wheel).namelist())
    for folder in ("grammar", "shaders", "examples", "porelang/prelude", "porelang/cli"):
        for path in (ROOT / folder).rglob("*.*"):
            name = path.relative_to(ROOT).as_posix().removeprefix("porelang/")
            assert f"porelang/{name}" in inside or path.suffix == ".pyc"
    assert not [name for name in inside if name.startswith(("tests", "examples"))]


@pytest.mark.slow
def test_installed_wheel_works_from_another_folder(wheel: Path, tmp_path: Path) -> None:
    site = tmp_path / "site"
    subprocess.run(
        [sys.executable, "-m", "pip", "install", "--no-deps", "--no-index", "--target", str(site), str(wheel)],
        check=True, capture_output=True,
    )  # fmt: skip
    environment = {**os.environ, "PYTHONPATH": str(site), "PORELANG_CACHE": str(tmp_path / "cache")}
    work = tmp_path / "work"
    work.mkdir()
    (work / "part.pore").write_text("gyroid(10) |> shell(1) & sphere(20)", encoding="utf-8")

    def run(*command: str) -> str:
        done = subprocess.run(command, cwd=work, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout + done.stderr

    told = run(sys.executable, str(site / "bin" / "pore"), "check", "part.pore")
    assert told == "part.pore: no errors, no warnings\n"
    assert "float field(vec3 p)" in run(sys.executable, "-m", "porelang", "glsl", "part.pore")
    code = "import porelang; print(porelang.__file__); print(porelang.compile('sphere(3)').field()([[0, 0, 0]])[0])"
    where, value = run(sys.executable, "-c", code).split()
    assert Path(where).is_relative_to(site)
    assert value == "-3.0"
