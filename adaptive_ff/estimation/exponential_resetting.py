"""Least squares with exponential resetting as an estimator of one's own regression: forgetting that cannot wind up.

The recursion is ``resetting.update_resetting_in_place``, in units of the first deviations and of the noise. Its floor
is such that without excitation the covariance returns to the first one.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import ArrayLike, NDArray

from adaptive_ff.estimation.recursive_estimator import RecursiveEstimator, make_settings
from adaptive_ff.estimation.resetting import initial_resetting_state, total_of, update_resetting_in_place
from adaptive_ff.estimation.updates import CORRECTIONS, EstimationState, Settings, initial_state
from controllers import check_positive


class ResettingParameters(NamedTuple):
    """Parameters of the estimator.

    Attributes
    ----------
    settings : Settings
        Its settings.
    floor : float
        Floor of the information, per unit of memory.
    """

    settings: Settings
    floor: float


def make_resetting(settings: Settings, period: float) -> ResettingParameters:
    """Return the parameters of an estimator whose information falls back to that of the first estimate."""
    return ResettingParameters(settings, -math.expm1(-period / settings.memory))


def initial_exponential_resetting_state(block: ResettingParameters) -> EstimationState:
    """Return the state of an estimator that has seen nothing."""
    first = block.settings.first
    return initial_state(block.settings, initial_resetting_state(first, block.floor * np.eye(first.size)))


@register_jitable
def correct_with_instrument_in_place(
    block: ResettingParameters, state: EstimationState, error: float, duration: float
) -> None:
    """Correct the estimate with the instrument in the state, which is in the unit of the regressors.

    Equations so large that the floor is less than their rounding leave a matrix that has no factor: then nothing is
    corrected, and what the equations said is forgotten.
    """
    settings, recursion = block.settings, state.recursion
    for i in range(recursion.estimate.size):
        recursion.instrument[i] = recursion.instrument[i] * settings.deviation[i] / settings.noise
    update_resetting_in_place(recursion, block.floor, math.exp(-duration / settings.memory), 1.0)
    if not math.isfinite(total_of(recursion.gain)):
        for i in range(recursion.gain.size):
            recursion.gain[i] = 0.0
            for j in range(recursion.gain.size):
                recursion.information[i, j] = block.floor if i == j else 0.0
    for i in range(recursion.estimate.size):
        recursion.gain[i] *= settings.deviation[i] / settings.noise
        recursion.estimate[i] += recursion.gain[i] * error


@register_jitable
def correct_resetting_in_place(
    block: ResettingParameters,
    state: EstimationState,
    regressors: NDArray[np.float64],
    instruments: NDArray[np.float64],
    output: float,
    error: float,
    duration: float,
) -> None:
    """Correct the estimate with the regressors for an instrument: plain least squares."""
    for i in range(regressors.size):
        state.recursion.instrument[i] = regressors[i]
    correct_with_instrument_in_place(block, state, error, duration)


CORRECTIONS[ResettingParameters] = correct_resetting_in_place


class ExponentialResetting(RecursiveEstimator):
    """Recursive least squares with exponential resetting.

    Parameters
    ----------
    first : array_like, shape (n,)
        First estimate.
    period : float
        Nominal time between equations, s.
    first_deviation : float or array_like, shape (n,)
        How far, as a standard deviation, each parameter may be from the first estimate. What the data do not excite
        falls back to being as uncertain as that, and to following new data as fast; the estimate itself stays.
    noise : float
        Expected standard deviation of an equation's error, unit of the output.
    memory : float
        Memory, s: an equation counts ``exp(-age/memory)``.

    Raises
    ------
    ValueError
        A value is out of range.

    Examples
    --------
    >>> from adaptive_ff.estimation import ExponentialResetting
    >>> estimator = ExponentialResetting([0.0, 0.0], 0.01, first_deviation=100.0, noise=0.1, memory=5.0)
    >>> estimator.update([1.0, 0.2], 76.0)
    76.0
    """

    def __init__(
        self, first: ArrayLike, period: float, *, first_deviation: ArrayLike, noise: float, memory: float
    ) -> None:
        check_positive(period=period, memory=memory)
        settings = make_settings(first, first_deviation, noise, memory)
        super().__init__(make_resetting(settings, period), period, initial_exponential_resetting_state)
