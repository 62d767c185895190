"""Gains of a Kalman filter that has settled, by filterpy."""

import numpy as np
from numpy.typing import NDArray

SETTLED = 1e-13
"""Relative change of the covariance in a step at which it counts as settled."""

LONGEST = 100_000
"""Steps after which the search gives up."""


def stationary_gain(transition: NDArray[np.float64], process_noise: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the stationary gain of a filter that measures the first state with a variance of 1."""
    # here, not above: filterpy loads scipy.stats, half a second that only the Kalman observers need
    from filterpy.kalman import KalmanFilter

    size = transition.shape[0]
    kalman = KalmanFilter(dim_x=size, dim_z=1)
    kalman.F, kalman.Q, kalman.P = transition, process_noise, np.eye(size) + process_noise
    kalman.H, kalman.R = np.eye(1, size), np.eye(1)
    for _ in range(LONGEST):
        last = kalman.P
        kalman.predict()
        kalman.update(np.zeros(1))
        # not the gain: it may stand still for a step long before the end
        if np.all(np.abs(kalman.P - last) <= SETTLED * np.abs(kalman.P)):
            return np.array(kalman.K[:, 0], dtype=float)
    raise ValueError(
        f"the process noise is too small against that of the measurement: after {LONGEST} periods the gain of the "
        "filter has not settled"
    )
