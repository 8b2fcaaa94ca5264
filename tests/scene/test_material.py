"""Constants of materials from the table of laws."""

from __future__ import annotations

import pytest

from cfmpm.registry.laws import Constant, Law
from cfmpm.scene import material


def table(*constants: Constant) -> dict[str, Law]:
    """One law for each constant."""
    return {f"law_{i}": Law("", "", (constant,)) for i, constant in enumerate(constants)}


def test_laws_may_share_a_constant(monkeypatch):
    both = Constant("k", "of one", above=0), Constant("k", "of the other", above=0)
    monkeypatch.setattr(material, "LAWS", table(*both))
    assert material._constants() == {"k": Constant("k", "of one; of the other", above=0)}


@pytest.mark.parametrize("other", [{"least": 0}, {"above": 0, "default": 1.0}, {}])
def test_a_constant_has_the_same_limits_in_all_laws(monkeypatch, other):
    both = Constant("k", "of one", above=0), Constant("k", "of the other", **other)
    monkeypatch.setattr(material, "LAWS", table(*both))
    with pytest.raises(ValueError, match="two laws differ in what their constant k may be"):
        material._constants()
