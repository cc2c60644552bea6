"""Fixed-interval smoothing: what all measurements say of every instant, those that came later too.

After a filter has gone forward, one pass back (Rauch, Tung and Striebel 1965, AIAA J. 3(8), eqs. 3.28 to
3.31). With P the covariance of the filter after the corrections of an instant, P- that before them, and F the
transition to the next instant ::

    C_k = P_k F_k' (P-_k+1)^-1
    d_k = C_k (c_k+1 + d_k+1)
    S_k = P_k + C_k (S_k+1 - P-_k+1) C_k'

where c is by how much the filter corrected its estimate at an instant, d by how much the smoother moves it
besides, and S the covariance of what is left. The filter's own covariances and corrections come in and none
of its measurements, so that whatever it did with those is smoothed as it was done; and an estimate that is no
vector, such as an attitude, needs no more than differences on its group.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Forward(NamedTuple):
    """What a filter did at n instants with s states.

    Attributes
    ----------
    transition : ndarray, shape (n - 1, s, s)
        From each instant to the next.
    predicted, filtered : ndarray, shape (n, s, s)
        Covariance before and after the corrections of each instant.
    correction : ndarray, shape (n, s)
        Corrected minus predicted estimate.
    """

    transition: Array
    predicted: Array
    filtered: Array
    correction: Array


def smooth(forward: Forward, severed: NDArray[np.bool_] | None = None) -> tuple[Array, Array]:
    """Go back over what a filter did.

    Parameters
    ----------
    forward : Forward
        The pass that it went.
    severed : ndarray, shape (n - 1,), optional
        Intervals over which nothing is carried back.

    Returns
    -------
    tuple of ndarray, shapes (n, s) and (n, s, s)
        Smoothed minus filtered estimate, and the smoothed covariance.
    """
    deviation, covariance = np.zeros_like(forward.correction), forward.filtered.copy()
    for k in reversed(range(len(forward.transition))):
        if severed is not None and severed[k]:
            continue
        filtered, predicted = forward.filtered[k], forward.predicted[k + 1]
        size = np.sqrt(predicted.diagonal())  # states of many units
        cross = forward.transition[k] @ filtered / size[:, None]
        gain = (np.linalg.solve(predicted / np.outer(size, size), cross) / size[:, None]).T
        deviation[k] = gain @ (forward.correction[k + 1] + deviation[k + 1])
        smoothed = filtered + gain @ (covariance[k + 1] - predicted) @ gain.T
        covariance[k] = (smoothed + smoothed.T) / 2
    return deviation, covariance
