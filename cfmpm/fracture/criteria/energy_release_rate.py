"""The energy release rate of a kink as driving force (Griffith 1921)."""

from __future__ import annotations

import math

from cfmpm.fracture.criteria.protocols import TipValues


def energy_release_rate(values: TipValues) -> float:
    """Return G in the direction of growth [N/mm]; G straight ahead where K is not defined."""
    kinked = float(values.get("G_kink", math.nan))
    return float(values["G"]) if math.isnan(kinked) else kinked
