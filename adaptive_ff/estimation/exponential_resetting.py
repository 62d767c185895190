"""Least squares with exponential resetting as an estimator of one's own regression: forgetting that cannot wind up.

The recursion is ``resetting.update_resetting``, in units of the first deviations and of the noise. Its floor is such
that without excitation the covariance returns to the first one.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import ArrayLike, NDArray

from adaptive_ff.estimation.recursive_estimator import RecursiveEstimator, make_settings
from adaptive_ff.estimation.resetting import update_resetting
from adaptive_ff.estimation.updates import CORRECTIONS, Progress, Settings, initial_progress
from controllers import check_positive


class ResettingParameters(NamedTuple):
    """Parameters of the estimator.

    Attributes
    ----------
    settings : Settings
        What it is told.
    floor : float
        Floor of the information, per unit of memory.
    scaled : ndarray, shape (n,)
        Scratch.
    factor : ndarray, shape (n, n)
        Scratch.
    """

    settings: Settings
    floor: float
    scaled: NDArray[np.float64]
    factor: NDArray[np.float64]


class ResettingState(NamedTuple):
    """State of the estimator.

    Attributes
    ----------
    progress : Progress
        Estimate, its covariance, level of the error.
    information : ndarray, shape (n, n)
        Information of the scaled parameters; changed in place.
    """

    progress: Progress
    information: NDArray[np.float64]


def make_resetting(settings: Settings, period: float) -> ResettingParameters:
    """Return the parameters of an estimator whose information falls back to that of the first estimate."""
    size = settings.first.size
    floor = -math.expm1(-period / settings.memory)
    return ResettingParameters(settings, floor, np.zeros(size), np.zeros((size, size)))


def initial_resetting_state(block: ResettingParameters) -> ResettingState:
    """Return the state of an estimator that has seen nothing."""
    return ResettingState(initial_progress(block.settings), block.floor * np.eye(block.settings.first.size))


@register_jitable(forceinline=True)
def correct_resetting(
    block: ResettingParameters,
    state: ResettingState,
    regressors: NDArray[np.float64],
    instruments: NDArray[np.float64],
    output: float,
    error: float,
    duration: float,
) -> None:
    """Correct the estimate with what stands for the regressors, and fill in the gain."""
    settings = block.settings
    keep = math.exp(-duration / settings.memory)
    for i in range(regressors.size):
        block.scaled[i] = instruments[i] * settings.deviation[i] / settings.noise
    update_resetting(state.information, block.floor, keep, block.scaled, 1.0, settings.gain, block.factor)
    for i in range(regressors.size):
        settings.gain[i] *= settings.deviation[i] / settings.noise
        state.progress.estimate[i] += settings.gain[i] * error


CORRECTIONS[ResettingParameters] = correct_resetting


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
        super().__init__(make_resetting(settings, period), period, initial_resetting_state)
