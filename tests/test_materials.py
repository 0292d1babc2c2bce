"""The table of materials: physical, sourced, and found by name."""

from __future__ import annotations

import pytest

from porelang.materials import MATERIALS, named, nearest


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
    assert named("Ti6Al4V") is named("ti-6al-4v") is MATERIALS["Ti-6Al-4V"]
    assert named("PA 12") is MATERIALS["PA12"]
    assert named("unobtainium") is None
    assert (nearest("stel"), nearest("unobtainium")) == ("steel", None)
