"""T3: three nodes and one material point at the centroid (paper section 2.3, Fig. 2(a)).

Linear displacement, constant strain.
"""

from __future__ import annotations

import numpy as np

from cfmpm.elements.record import Element

T3 = Element(
    order=1,
    points=np.full((1, 3), 1.0 / 3.0),
    weights=np.ones(1),
    # Constant volume of every triangle gives as many constraints as degrees of freedom.
    locks=True,
    domains=(np.eye(3),),
)
