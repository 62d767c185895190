"""Recursive instrumental variables with a gain that is bounded: for regressors with noise of their own.

The recursion is that of exponential resetting with the instruments ``z`` in the place of the regressors ``x`` in gain
and information, see ``resetting``: its fixed point solves ``E z (y - x' P) = 0``, which noise in ``x`` that ``z`` does
not have does not move. It finds that point where ``z`` resembles ``x``; where on the average an instrument does not,
the regressors take its place, as in ``estimator``, which is biased by their noise but safe.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import ArrayLike, NDArray

from adaptive_ff.estimation.exponential_resetting import (
    ResettingParameters,
    ResettingState,
    correct_resetting,
    initial_resetting_state,
    make_resetting,
)
from adaptive_ff.estimation.instruments import gradients_agree
from adaptive_ff.estimation.recursive_estimator import RecursiveEstimator, make_settings
from adaptive_ff.estimation.updates import CORRECTIONS, Progress, Settings
from controllers import check_positive


class InstrumentalParameters(NamedTuple):
    """Parameters of the estimator.

    Attributes
    ----------
    settings : Settings
        What it is told.
    resetting : ResettingParameters
        The recursion, which is told the same.
    instrument : ndarray, shape (n,)
        Scratch.
    """

    settings: Settings
    resetting: ResettingParameters
    instrument: NDArray[np.float64]


class InstrumentalState(NamedTuple):
    """State of the estimator.

    Attributes
    ----------
    progress : Progress
        Estimate, its covariance, level of the error.
    information : ndarray, shape (n, n)
        Information of the scaled parameters; changed in place.
    agreement : ndarray, shape (n, 2)
        Fading means of ``z^2`` and ``z x``; changed in place.
    """

    progress: Progress
    information: NDArray[np.float64]
    agreement: NDArray[np.float64]


def initial_instrumental_state(block: InstrumentalParameters) -> InstrumentalState:
    """Return the state of an estimator that has seen nothing."""
    return InstrumentalState(*initial_resetting_state(block.resetting), np.zeros((block.settings.first.size, 2)))


@register_jitable(forceinline=True)
def correct_instrumental(
    block: InstrumentalParameters,
    state: InstrumentalState,
    regressors: NDArray[np.float64],
    instruments: NDArray[np.float64],
    output: float,
    error: float,
    duration: float,
) -> None:
    """Correct the estimate with the instruments while they resemble the regressors, and fill in the gain."""
    keep = math.exp(-duration / block.settings.memory)
    inner = ResettingState(state.progress, state.information)
    for i in range(regressors.size):
        block.instrument[i] = instruments[i]  # the check may change what it is given
    if not gradients_agree(state.agreement, block.instrument, regressors, keep, 0.0):
        for i in range(regressors.size):
            block.instrument[i] = regressors[i]
    correct_resetting(block.resetting, inner, regressors, block.instrument, output, error, duration)


CORRECTIONS[InstrumentalParameters] = correct_instrumental


class InstrumentalVariable(RecursiveEstimator):
    """Recursive instrumental variables; ``update`` and ``run`` need ``instruments``.

    Parameters
    ----------
    first : array_like, shape (n,)
        First estimate.
    period : float
        Nominal time between equations, s.
    first_deviation : float or array_like, shape (n,)
        How far, as a standard deviation, each parameter may be from the first estimate; see ``ExponentialResetting``.
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
    >>> from adaptive_ff.estimation import InstrumentalVariable
    >>> estimator = InstrumentalVariable([0.0, 0.0], 0.01, first_deviation=100.0, noise=0.1, memory=5.0)
    >>> estimator.update([1.0, 0.21], 76.0, instruments=[1.0, 0.2])
    76.0
    """

    takes_instruments = True

    def __init__(
        self, first: ArrayLike, period: float, *, first_deviation: ArrayLike, noise: float, memory: float
    ) -> None:
        check_positive(period=period, memory=memory)
        settings = make_settings(first, first_deviation, noise, memory)
        block = InstrumentalParameters(settings, make_resetting(settings, period), np.zeros(settings.first.size))
        super().__init__(block, period, initial_instrumental_state)
