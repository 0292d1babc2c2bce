"""The table of materials: physical, sourced, and found by name."""

from __future__ import annotations

import pytest

from porelang.diagnostics import PoreError
from porelang.materials import MATERIALS, material


@pytest.mark.parametrize("name", MATERIALS)
def test_material_is_physical_and_has_a_source(name: str) -> None:
    m = MATERIALS[name]
    assert 0 < m.poisson < 0.5
    assert 1e3 < m.young < 1e6
    assert 0.5 < m.density < 10
    assert m.yields is None or 1e-4 < m.yields / m.young < 0.03  # strains at yield
    assert len(m.source) > 10
    assert m.doubt


def test_material_is_found_by_name() -> None:
    assert material("Ti6Al4V") is MATERIALS["ti6al4v"]
    with pytest.raises(PoreError, match="did you mean `steel`"):
        material("stel")
    with pytest.raises(PoreError, match="there are pla, pa12"):
        material("unobtainium")
