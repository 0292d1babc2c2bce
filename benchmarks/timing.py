"""Competitors take turns, round after round, so that what else the machine does falls on all of them alike."""

from __future__ import annotations

import os
import platform
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

Case = Callable[[], Any]


class Times(NamedTuple):
    """The median of wall seconds and the mean of CPU seconds."""

    wall: float
    cpu: float


def in_turn(cases: dict[str, Case], rounds: int, pid: int | None = None) -> dict[str, Times]:
    """Each case is run once to warm up, then once a round. `pid` is another process whose CPU seconds count too."""
    for case in cases.values():
        case()
    taken: dict[str, list[Times]] = {name: [] for name in cases}
    for _ in range(rounds):
        for name, case in cases.items():
            wall, cpu = time.perf_counter(), time.process_time() + cpu_of(pid)
            case()
            taken[name].append(Times(time.perf_counter() - wall, time.process_time() + cpu_of(pid) - cpu))
    return {name: middle(times) for name, times in taken.items()}


def middle(times: list[Times]) -> Times:
    return Times(statistics.median(t.wall for t in times), statistics.mean(t.cpu for t in times))


def cpu_of(pid: int | None) -> float:
    """CPU seconds that another process has used (0 where the system does not tell)."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def machine() -> str:
    """The processor, how many of its cores there are, the system and the interpreter."""
    name = platform.machine()
    try:
        info = Path("/proc/cpuinfo").read_text()
    except OSError:
        info = ""
    for line in info.splitlines():
        if line.startswith("model name"):
            name = line.partition(":")[2].strip()
            break
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return f"{name}, {cores} cores, {platform.system()}, Python {platform.python_version()}"
