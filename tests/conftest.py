"""The suite has a cache of its own: no number that an earlier run found stands in for one that the code finds now."""

from __future__ import annotations

import os
import tempfile

import pytest


def pytest_configure(config: pytest.Config) -> None:
    folder = tempfile.TemporaryDirectory(prefix="porelang-tests-")
    os.environ["PORELANG_CACHE"] = folder.name
    config.add_cleanup(folder.cleanup)
