"""Pareto-optimal runs by cost and error."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def pareto_front(cost: ArrayLike, error: ArrayLike) -> NDArray[np.intp]:
    """Return the runs for which no other run has both lower cost and lower error.

    Parameters
    ----------
    cost, error : (n,) float
        Runs in which either is nan are left out.

    Returns
    -------
    (k,) int
        By rising cost and falling error.
    """
    cost, error = np.asarray(cost, float), np.asarray(error, float)
    order = np.lexsort((error, cost))
    order = order[np.isfinite(cost[order]) & np.isfinite(error[order])]
    least = np.minimum.accumulate(error[order])
    return order[np.append(True, least[1:] < least[:-1])] if order.size else order
