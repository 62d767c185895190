"""Recursive instrumental variables with a gain that is bounded: for regressors with noise of their own.

The recursion is that of exponential resetting with the instruments ``z`` in the place of the regressors ``x`` in gain
and information, see ``resetting``: its fixed point solves ``E z (y - x' P) = 0``, which noise in ``x`` that ``z`` does
not have does not move. It finds that point where ``z`` resembles ``x``; where on the average an instrument does not,
the regressors take its place, which is biased by their noise but safe; see ``instruments``.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import ArrayLike, NDArray

from adaptive_ff.estimation.exponential_resetting import (
    ResettingParameters,
    correct_with_instrument_in_place,
    make_resetting,
)
from adaptive_ff.estimation.instruments import choose_instrument_in_place
from adaptive_ff.estimation.recursive_estimator import RecursiveEstimator, make_settings
from adaptive_ff.estimation.resetting import initial_resetting_state
from adaptive_ff.estimation.updates import CORRECTIONS, EstimationState, Settings, initial_state
from controllers import check_positive


class InstrumentalParameters(NamedTuple):
    """Parameters of the estimator.

    Attributes
    ----------
    settings : Settings
        Its settings.
    resetting : ResettingParameters
        The recursion, with the same settings.
    """

    settings: Settings
    resetting: ResettingParameters


def initial_instrumental_state(block: InstrumentalParameters) -> EstimationState:
    """Return the state of an estimator that has seen nothing."""
    first = block.settings.first
    recursion = initial_resetting_state(first, block.resetting.floor * np.eye(first.size))
    return initial_state(block.settings, recursion, instruments=True)


@register_jitable
def correct_instrumental_in_place(
    block: InstrumentalParameters,
    state: EstimationState,
    regressors: NDArray[np.float64],
    instruments: NDArray[np.float64],
    output: float,
    error: float,
    duration: float,
) -> None:
    """Correct the estimate with the instruments while they resemble the regressors, and fill in the gain."""
    keep = math.exp(-duration / block.settings.memory)
    choose_instrument_in_place(state.agreement, instruments, regressors, keep, 0.0, state.recursion.instrument)
    correct_with_instrument_in_place(block.resetting, state, error, duration)


CORRECTIONS[InstrumentalParameters] = correct_instrumental_in_place


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
        block = InstrumentalParameters(settings, make_resetting(settings, period))
        super().__init__(block, period, initial_instrumental_state)
