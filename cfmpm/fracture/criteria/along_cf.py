"""The direction of the configurational force (the paper's criterion)."""

from __future__ import annotations

import numpy as np

from cfmpm.fracture.criteria.protocols import Floats, TipValues


class AlongCf:
    """Along the configurational force on the largest domain."""

    def heading(self, values: TipValues, tangent: Floats) -> Floats:
        """Return the unit vector along the force, (2,)."""
        force = np.array([values["cf_x"], values["cf_y"]])
        return force / np.hypot(*force)

    def kink_factor(self, values: TipValues) -> float:
        """Return 1: the configurational force is that before kinking."""
        return 1.0
