"""`pore doctor` and `pore conformance`: this machine examined."""

from __future__ import annotations

from argparse import Namespace

from porelang.conformance import report


def doctor(options: Namespace) -> int:
    """What of this machine is used, and what is missing."""
    return report.doctor(options.json)


def conformance(options: Namespace) -> int:
    """The backends compared on this machine."""
    return report.certificate(options.json, options.count, options.seed, options.quick)
