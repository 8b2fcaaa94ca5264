"""The norm of the configurational force as driving force (the paper's criterion)."""

from __future__ import annotations

from cfmpm.fracture.criteria.protocols import TipValues


def cf_norm(values: TipValues) -> float:
    """Return the norm of the configurational force on the largest domain [N/mm]."""
    return float(values["cf_norm"])
