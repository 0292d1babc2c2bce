"""`pore doctor` and `pore conformance`: what this machine computes, in numbers that a user can act on."""

from __future__ import annotations

import json as jsons
import math
import os
import platform
import secrets
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

import porelang
from porelang.conformance.backend import NUMPY, Backend, glsl
from porelang.conformance.suite import Certificate, check_samples, has_samples, run_suite
from porelang.conformance.sweep import Measurement, sweep
from porelang.gpu import Gpu, GpuMissing, shared_gpu
from porelang.ops import TABLE

#: Random graphs of a quick certificate.
QUICK = 50
HELD, BROKEN, MISSING = 0, 1, 3
_WIDTH = 13  # of the column with the names of operations


def doctor(json: bool = False) -> int:
    """Measure every operation on every backend of this machine and print the result.

    Returns 0 if all keep to their tolerances, 1 if one does not, 3 if there is no OpenGL (it says how to install it).
    """
    device, missing = _device()
    backends = _backends(device)
    measured = [m for b in backends for m in sweep(b)]
    broken = [m for m in measured if m.broken]
    judged = {(n, b.name): check_samples(n, b, 0) for n in TABLE if has_samples(n) for b in backends}
    failures = [f.failure for found in judged.values() for f in found if f.failure]
    holds = not broken and not failures
    if json:
        record: dict[str, Any] = {
            "versions": _versions(),
            "opengl": asdict(device.info) if device else None,
            "missing": {"reason": missing.reason, "install": missing.install} if missing else None,
            "operations": [_record(m) for m in measured],
            "data": [
                {"op": op, "backend": name, "points": sum(f.points for f in found), "use": max(f.use for f in found)}
                for (op, name), found in judged.items()
            ],
            "holds": holds,
        }
        print(jsons.dumps(_plain(record)))
    else:
        print("  ".join(f"{name} {number}" for name, number in _versions().items()))
        print(_opengl(device, missing))
        print(
            "\nThe worst error of each operation, in units of the type's epsilon times the result (for sines times at"
        )
        print("least 1, for mod times the dividend), and the part of its tolerance that it uses:\n")
        print("\n".join(_table(measured, backends)))
        print("\nThe part of its bound that each operation on data uses, on a grid and a frame that are hard:\n")
        for op in dict.fromkeys(op for op, _ in judged):
            uses = (max(f.use for f in judged[op, b.name]) for b in backends)
            print(f"{op:<{_WIDTH}}" + "".join(f"{100 * use:>18.0f} %" for use in uses))
        print()
        for m in broken:
            print(f"BEYOND TOLERANCE  {m.example} ({m.broken} of {m.points} inputs)")
        for failure in failures:
            print(f"BEYOND ITS BOUND  {failure.where}, {failure.backend}: {failure.example}")
        if not holds:
            print(
                "This backend does not keep the law; use another: --backend numpy, or an update of the graphics driver."
            )
        else:
            print(
                f"All {len({m.op for m in measured} | {op for op, _ in judged})} operations keep to their tolerances."
            )
    return BROKEN if not holds else MISSING if missing else HELD


def certificate(json: bool = False, count: int = 500, seed: int | None = None, quick: bool = False) -> int:
    """Run the conformance suite with `count` random graphs and print its certificate.

    The seed is drawn, and printed, if none is given; `quick` is a run of a few seconds. Returns 0 if the law holds, 1
    if it is broken, 3 if it holds but there is no OpenGL, so that only NumPy was examined.
    """
    device, missing = _device()
    seed = secrets.randbelow(2**31) if seed is None else seed
    made = run_suite(_backends(device), min(count, QUICK) if quick else count, seed, _name(device))
    if json:
        print(jsons.dumps(_plain(_certificate(made, missing))))
    else:
        print("\n".join(lines(made, missing)))
    return BROKEN if not made.holds else MISSING if missing else HELD


def lines(made: Certificate, missing: GpuMissing | None = None) -> list[str]:
    """A certificate as text."""
    share = 100 * made.sharp / max(made.points, 1)
    out = [
        f"porelang {porelang.__version__}, {', '.join(made.backends)}{f' on {made.device}' if made.device else ''}",
        f"seed {made.seed}: `pore conformance --seed {made.seed}` repeats this run",
        f"operations  {len({m.op for m in made.measurements})} at {sum(m.points for m in made.measurements):,} inputs",
        f"programs    {made.programs}, with {made.expectations} expected values",
        f"graphs      {made.graphs} at random",
        f"points      {made.points:,} judged by the law, {share:.1f} % of them under a bound of 1 % or less",
        f"worst use   {made.use:.3f} of such a bound",
        "",
        *_table(made.measurements, made.backends, made.appearances),
        "",
    ]
    if missing is not None:
        out.append(f"Not examined: GLSL. {missing.reason}. {missing.install}")
    for f in made.failures:
        out.append(f"BROKEN  {f.where}, {f.backend}{f', operation `{f.operation}`' if f.operation else ''}")
        out.extend(f"        {line}" for line in f.example.splitlines())
    out.append("The law holds." if made.holds else f"The law is broken in {len(made.failures)} places.")
    return out


def _certificate(made: Certificate, missing: GpuMissing | None) -> dict[str, Any]:
    record = asdict(made)
    record["measurements"] = [_record(m) for m in made.measurements]
    return {
        "holds": made.holds,
        "versions": _versions(),
        "missing": {"reason": missing.reason, "install": missing.install} if missing else None,
        **record,
    }


def _device() -> tuple[Gpu | None, GpuMissing | None]:
    try:
        return shared_gpu(), None
    except GpuMissing as missing:
        return None, missing


def _backends(device: Gpu | None) -> list[Backend]:
    return [*NUMPY, glsl(device)] if device else [*NUMPY]


def _name(device: Gpu | None) -> str:
    return f"{device.info.renderer}, OpenGL {device.info.version}" if device else ""


def _opengl(device: Gpu | None, missing: GpuMissing | None) -> str:
    if device is None:
        assert missing is not None
        return f"OpenGL   none: {missing.reason}\n         {missing.install}\n         Until then NumPy is used."
    return f"OpenGL   {_name(device)} through {device.info.driver}, GLSL {device.info.glsl}"


def _versions() -> dict[str, str]:
    found = {"porelang": porelang.__version__, "Python": platform.python_version(), "NumPy": np.__version__}
    try:
        found["moderngl"] = version("moderngl")
    except PackageNotFoundError:
        found["moderngl"] = "missing"
    return found | {"system": f"{platform.system()} {platform.machine()}", "processors": str(os.cpu_count() or 1)}


def _record(m: Measurement) -> dict[str, Any]:
    return asdict(m) | {"example": m.example}


def _table(
    measured: Sequence[Measurement], backends: Sequence[Backend | str], appearances: dict[str, int] | None = None
) -> list[str]:
    """Operations down, backends across: worst error and use of the tolerance."""
    names = [b if isinstance(b, str) else b.name for b in backends]
    out = [f"{'':<{_WIDTH}}" + "".join(f"{name:>20}" for name in names) + ("   in graphs" if appearances else "")]
    for op in dict.fromkeys(m.op for m in measured):
        row = f"{op:<{_WIDTH}}"
        for name in names:
            mine = [m for m in measured if m.op == op and m.backend == name]
            error = max(m.ulp for m in mine)
            use = max(m.use for m in mine)
            row += f"{error:>12.3g} {f'{100 * use:.0f} %' if math.isfinite(use) else 'broken':>7}"
        out.append(row + (f"{appearances.get(op, 0):>12}" if appearances else ""))
    return out


def _plain(value: Any) -> Any:
    """A record with what JSON has no number for as text."""
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value
