"""Parts of a body that has come apart, and which of them carry nothing any more."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.body import Body
from cfmpm.equilibrium.balance import Equilibrium

# Energy of a part, relative to modulus times displacement squared, that is only the round-off of
# its motion as a whole: measured 1e-28 to 1e-26 for parts between grips.
NOTHING = 1e-22


def relieved_nodes(body: Body, balance: Equilibrium) -> NDArray[np.bool_]:
    """Tell which nodes belong to a part that has come off and carries nothing, (n,).

    What is computed there is round-off: tips have no values, and supports no force.

    Parameters
    ----------
    body : Body
    balance : Equilibrium
        Of the body.
    """
    relieved = np.zeros(len(body.grid.nodes), bool)
    part_of = body.grid.parts
    if not part_of.any():
        return relieved
    points = balance.points
    energy = np.bincount(part_of[points.element], points.energy * points.volume, part_of.max() + 1)
    largest = np.abs(balance.displacement).max()
    carries = energy > NOTHING * body.materials.elastic.max() * largest**2
    relieved[body.grid.elements[~carries[part_of]]] = True
    return relieved
