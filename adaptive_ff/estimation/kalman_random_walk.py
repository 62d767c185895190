"""Kalman filter for parameters that walk at random: forgetting with settings in physical units.

Between equations the variance of each parameter grows by ``walk^2 dt``; no variance grows beyond a largest one, so
without excitation nothing winds up. Where one would, its row and column are scaled down, which keeps all correlations
and the matrix positive semidefinite. The covariance is kept in units of the variance of the noise, and is the one that
all estimators here keep (see ``spread``): corrected in Joseph's form, valid for this gain as for every other.

Source: R. E. Kalman, 1960, with the random-walk model of the parameters as in L. Ljung and S. Gunnarsson, "Adaptation
and Tracking in System Identification - A Survey" (Automatica 26, 1990).
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import ArrayLike, NDArray

from adaptive_ff.estimation.quadratic import quadratic_form
from adaptive_ff.estimation.recursive_estimator import RecursiveEstimator, check_deviations, make_settings
from adaptive_ff.estimation.updates import CORRECTIONS, EstimationState, Settings, initial_state
from controllers.arrays import MutableArray


class RandomWalkParameters(NamedTuple):
    """Parameters of the estimator.

    Attributes
    ----------
    settings : Settings
        Its settings.
    walk : ndarray, shape (n,)
        Growth of each standard deviation, in units of the noise, per square root of a second.
    largest : ndarray, shape (n,)
        Largest standard deviation of each parameter, in units of the noise.
    """

    settings: Settings
    walk: NDArray[np.float64]
    largest: NDArray[np.float64]


class RandomWalkState(NamedTuple):
    """State of the recursion; its arrays are changed in place. The covariance is the one that all estimators keep.

    Attributes
    ----------
    estimate : ndarray, shape (n,)
        The parameters.
    gain : ndarray, shape (n,)
        Kalman's gain of the last equation.
    """

    estimate: MutableArray
    gain: MutableArray


def initial_random_walk_state(block: RandomWalkParameters) -> EstimationState:
    """Return the state of an estimator that has seen nothing."""
    first = block.settings.first
    return initial_state(block.settings, RandomWalkState(first.copy(), np.zeros(first.size)))


@register_jitable
def walk_in_place(
    spread: NDArray[np.float64], walk: NDArray[np.float64], largest: NDArray[np.float64], duration: float
) -> None:
    """Let the parameters walk for a time, s, as far as they may."""
    for i in range(walk.size):
        spread[i, i] += walk[i] * walk[i] * duration
        if spread[i, i] > largest[i] * largest[i]:
            share = largest[i] / math.sqrt(spread[i, i])
            for j in range(walk.size):
                spread[i, j] *= share
                spread[j, i] = spread[i, j]
            spread[i, i] = largest[i] * largest[i]


@register_jitable
def correct_random_walk_in_place(
    block: RandomWalkParameters,
    state: EstimationState,
    regressors: NDArray[np.float64],
    instruments: NDArray[np.float64],
    output: float,
    error: float,
    duration: float,
) -> None:
    """Let the parameters walk, fill in Kalman's gain, and correct the estimate."""
    estimate, gain = state.recursion.estimate, state.recursion.gain
    walk_in_place(state.spread, block.walk, block.largest, duration)
    predicted = quadratic_form(state.spread, regressors, gain)
    for i in range(regressors.size):
        gain[i] /= 1.0 + predicted
        estimate[i] += gain[i] * error


CORRECTIONS[RandomWalkParameters] = correct_random_walk_in_place


class KalmanRandomWalk(RecursiveEstimator):
    """Kalman filter for parameters that walk at random.

    Parameters
    ----------
    first : array_like, shape (n,)
        First estimate.
    period : float
        Nominal time between equations, s.
    first_deviation : float or array_like, shape (n,)
        How far, as a standard deviation, each parameter may be from the first estimate.
    noise : float
        Standard deviation of an equation's error, unit of the output. The gain depends on it.
    walk : float or array_like, shape (n,)
        How far, as a standard deviation, each parameter may walk in a second: unit of the parameter per square root of
        a second; zero for one that does not change.
    largest_deviation : float or array_like, shape (n,), optional
        Largest standard deviation of each parameter; by default, and at least, the first one.

    Raises
    ------
    ValueError
        A value is out of range.

    Examples
    --------
    >>> from adaptive_ff.estimation import KalmanRandomWalk
    >>> estimator = KalmanRandomWalk([0.0, 0.0], 0.01, first_deviation=100.0, noise=0.1, walk=[1.0, 0.5])
    >>> estimator.update([1.0, 0.2], 76.0)
    76.0
    """

    def __init__(
        self,
        first: ArrayLike,
        period: float,
        *,
        first_deviation: ArrayLike,
        noise: float,
        walk: ArrayLike,
        largest_deviation: ArrayLike | None = None,
    ) -> None:
        settings = make_settings(first, first_deviation, noise, math.inf)
        size = settings.first.size
        steps = check_deviations("walk", walk, size, zero=True)
        largest = settings.deviation
        if largest_deviation is not None:
            largest = check_deviations("largest_deviation", largest_deviation, size)
            if np.any(largest < settings.deviation):
                raise ValueError(
                    f"largest_deviation = {largest.tolist()} is not allowed: it must be at least first_deviation = "
                    f"{settings.deviation.tolist()}"
                )
        block = RandomWalkParameters(settings, steps / settings.noise, largest / settings.noise)
        super().__init__(block, period, initial_random_walk_state)

    @property
    def noise(self) -> float:
        """Standard deviation of the equation errors, unit of the output, as it was given."""
        return self._settings.noise

    @property
    def consistency(self) -> float:
        """Mean squared error of the predictions over what is expected: near 1 where the settings suit the data."""
        return (super().noise / self._settings.noise) ** 2

    def _degrees_of_freedom(self) -> float:
        return math.inf
