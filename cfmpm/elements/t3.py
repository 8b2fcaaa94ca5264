"""Three nodes and one material point: linear displacement, constant strain."""

from __future__ import annotations

import numpy as np

from cfmpm.elements.record import Element

T3 = Element(
    order=1,
    points=np.full((1, 3), 1.0 / 3.0),
    weights=np.ones(1),
    # As many constraints as degrees of freedom, where the volume of each triangle is to be kept.
    locks=True,
    domains=(np.eye(3),),
)
