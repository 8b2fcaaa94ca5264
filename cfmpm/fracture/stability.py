"""Stability of crack growth: change of load and displacement along the equilibrium path."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:  # grids import Numba, which is not needed to read results
    from cfmpm.body.grid import Floats

STABILITY = ("undefined", "stable", "unstable", "snap_back")


def classify(force: Floats, displacement: Floats) -> NDArray[np.int8]:
    """Classify the growth that starts from each state of an equilibrium path.

    Parameters
    ----------
    force, displacement : (step,) float
        Of the loads along the path on which the criterion is just met; their product is twice the
        strain energy of a linear body.

    Returns
    -------
    (step,) int8
        Index into `STABILITY`. Stable: the force rises for further growth. Unstable: the force
        falls and the displacement rises; growth is controlled only by a prescribed displacement.
        Snap-back: the displacement falls, and neither controls growth. Undefined: the last state,
        and where load or crack do not change.

    Examples
    --------
    >>> flags = classify(np.array([1.0, 1.2, 0.9, 0.8]), np.array([1.0, 1.5, 1.7, 1.6]))
    >>> [STABILITY[flag] for flag in flags]
    ['stable', 'unstable', 'snap_back', 'undefined']
    """
    flags = np.zeros(len(force), np.int8)
    more_force, more_displacement = np.diff(force), np.diff(displacement)
    flags[:-1][more_force > 0.0] = STABILITY.index("stable")
    flags[:-1][more_force < 0.0] = STABILITY.index("unstable")
    flags[:-1][more_displacement < 0.0] = STABILITY.index("snap_back")
    return flags
