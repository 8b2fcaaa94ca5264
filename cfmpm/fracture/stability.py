"""Whether growth is stable: what the load has to do so that the crack goes on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:  # grids bring Numba along, which who reads results has no need of
    from cfmpm.body.grid import Floats

STABILITY = ("undefined", "stable", "unstable", "snap_back")


def classify(force: Floats, displacement: Floats) -> NDArray[np.int8]:
    """Classify the growth that starts from each state of an equilibrium path.

    Parameters
    ----------
    force, displacement : (step,) float
        Of the loads along the path on which the criterion is just met; their product is twice the
        work stored in a linear body.

    Returns
    -------
    (step,) int8
        Index into `STABILITY`. Stable: the force has to rise so that the crack goes on. Unstable:
        the force falls and the displacement rises, so that only a prescribed displacement holds
        the crack. Snap-back: the displacement falls, and neither does. Undefined: the last state,
        and where the load or the crack stays as it is.

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
