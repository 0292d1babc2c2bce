"""What a command costs from the start of its process, in seconds."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from timing import Case, in_turn

PROGRAM = "param w = 30mm in 10mm..60mm\ngyroid(w) |> shell(1.53) & cylinder(75, 300)\n"


def starts(rounds: int) -> list[dict[str, Any]]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "specimen.pore"
        path.write_text(PROGRAM)

        def run(*command: str) -> Case:
            return lambda: subprocess.run([sys.executable, *command], check=True, capture_output=True)

        cases = {
            "python -c pass": run("-c", "pass"),
            "import numpy": run("-c", "import numpy"),
            "pore check": run("-m", "porelang", "check", str(path)),
            "pore mesh --resolution 64": run(
                "-m", "porelang", "mesh", str(path), "--resolution", "64", "-o", str(Path(folder) / "part.stl")
            ),
        }
        return [{"case": n, "seconds": t.wall} for n, t in in_turn(cases, rounds).items()]
