"""Recursive linear estimators behind one interface: ``output = regressors . estimate + error``, equation by equation.

An estimator is a kernel ``correct(block, state, regressors, instruments, output, error, duration)`` that corrects the
estimate of its recursion in place and fills in the gain ``g`` of that correction, ``g error``; it is registered by the
class of its parameters in ``CORRECTIONS``. What all have in common is done around it, once: equations that are not
finite are left out, the covariance of the estimate follows the gain (see ``spread``), and the level of the equation
errors is tallied.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.estimation.quadratic import quadratic_form
from adaptive_ff.estimation.spread import update_spread_in_place
from controllers import compiled, dispatched
from controllers.arrays import MutableArray

LARGEST_NUMBER = 1e100
"""What is larger is no measurement; its square may lie beyond what a floating-point number can hold."""


class Settings(NamedTuple):
    """Settings of every estimator; constant.

    Attributes
    ----------
    first : ndarray, shape (n,)
        First estimate.
    deviation : ndarray, shape (n,)
        Standard deviation of the first estimate.
    noise : float
        Expected standard deviation of an equation's error, unit of the output.
    memory : float
        Memory, s; infinite where nothing is forgotten.
    """

    first: NDArray[np.float64]
    deviation: NDArray[np.float64]
    noise: float
    memory: float


class Tally(NamedTuple):
    """Fading sums over the equations, for the level of their errors, and how many there were.

    Attributes
    ----------
    weight, weight_squared : float
        Sums of the weights, and of their squares.
    squares : float
        Sum of the weighted squares of the errors, in units of the expected one.
    taken, rejected : int
        Numbers of equations taken into account and rejected.
    """

    weight: float
    weight_squared: float
    squares: float
    taken: int
    rejected: int


class EstimationState(NamedTuple):
    """State of any estimator; its arrays, and those of the recursion, are changed in place.

    Attributes
    ----------
    recursion : RLSState, ResettingState or RandomWalkState
        State of the recursion, with the fields ``estimate`` and ``gain``.
    agreement : ndarray, shape (n, 2)
        Fading means of ``z^2`` and ``z x`` of the instruments; shape (0,) for an estimator that takes none.
    spread : ndarray, shape (n, n)
        Covariance of the estimate, in units of the variance of an equation's error.
    projected : ndarray, shape (n,)
        Scratch: the spread times the last regressors.
    tally : Tally
        Level of the error.
    """

    recursion: Any
    agreement: MutableArray
    spread: MutableArray
    projected: MutableArray
    tally: Tally


CORRECTIONS: dict[type, Callable[..., Any]] = {}
"""Kernel of each class of parameters."""


def initial_spread(settings: Settings) -> NDArray[np.float64]:
    """Return the covariance of the first estimate, in units of the variance of an equation's error."""
    return np.diag((settings.deviation / settings.noise) ** 2)


def initial_state(settings: Settings, recursion: Any, *, instruments: bool = False) -> EstimationState:
    """Return the state of an estimator that has seen nothing, around the state of its recursion."""
    size = settings.first.size
    agreement = np.zeros((size, 2)) if instruments else np.zeros(0)
    return EstimationState(recursion, agreement, initial_spread(settings), np.zeros(size), Tally(0.0, 0.0, 0.0, 0, 0))


def _correct(block: Any, state: Any, regressors: Any, instruments: Any, output: Any, error: Any, duration: Any) -> Any:
    return CORRECTIONS[type(block)](block, state, regressors, instruments, output, error, duration)


correct_in_place = dispatched(CORRECTIONS, _correct)
"""Correct any estimator's estimate and fill in the gain of the correction."""


@register_jitable
def usable(regressors: NDArray[np.float64], instruments: NDArray[np.float64], output: float) -> bool:
    """Return whether all numbers of an equation are finite, and their squares can be represented."""
    for i in range(regressors.size):
        if not (abs(regressors[i]) <= LARGEST_NUMBER and abs(instruments[i]) <= LARGEST_NUMBER):
            return False
    return abs(output) <= LARGEST_NUMBER


@register_jitable
def count_error(tally: Tally, error: float, predicted: float, keep: float) -> Tally:
    """Count an error in units of the expected one.

    What the uncertain estimate adds to the variance of the error, ``x' C x``, is divided out, and an equation counts
    the less, the more that is: the first ones show the error of the first estimate, not the level of the noise.
    """
    weight = 1.0 / (1.0 + predicted)
    return Tally(
        keep * tally.weight + weight,
        keep * keep * tally.weight_squared + weight * weight,
        keep * tally.squares + weight * weight * error * error,
        tally.taken + 1,
        tally.rejected,
    )


@register_jitable
def with_tally(state: EstimationState, tally: Tally) -> EstimationState:
    """Return the state with another tally; it shares the arrays."""
    return EstimationState(state.recursion, state.agreement, state.spread, state.projected, tally)


@register_jitable
def update_in_place(
    block: Any,
    state: EstimationState,
    regressors: NDArray[np.float64],
    instruments: NDArray[np.float64],
    output: float,
    duration: float,
) -> tuple[float, EstimationState]:
    """Take one equation into account.

    Returns
    -------
    error : float
        Error of the prediction; not a number where the equation was rejected.
    state : EstimationState
        The new state; it shares the arrays of the old one, which are changed in place.
    """
    settings, tally = block.settings, state.tally
    if not usable(regressors, instruments, output):
        counted = Tally(tally.weight, tally.weight_squared, tally.squares, tally.taken, tally.rejected + 1)
        return math.nan, with_tally(state, counted)
    error = output
    for i in range(regressors.size):
        error -= regressors[i] * state.recursion.estimate[i]
    correct_in_place(block, state, regressors, instruments, output, error, duration)
    predicted = quadratic_form(state.spread, regressors, state.projected)  # variance, in that of the error
    counted = count_error(tally, error / settings.noise, predicted, math.exp(-duration / settings.memory))
    update_spread_in_place(state.spread, state.recursion.gain, state.projected, predicted)
    return error, with_tally(state, counted)


def _single_update(
    block: Any, state: Any, regressors: Any, instruments: Any, output: float, duration: float
) -> tuple[float, Any]:
    return update_in_place(block, state, regressors, instruments, output, duration)


single_update = compiled(_single_update)


def _run_updates(
    block: Any,
    state: Any,
    rows: Any,
    instruments: Any,
    outputs: Any,
    durations: Any,
    errors: Any,
    estimates: Any,
) -> Any:
    for k in range(outputs.size):
        error, state = update_in_place(block, state, rows[k], instruments[k], outputs[k], durations[k])
        errors[k] = error
        for i in range(rows.shape[1]):
            estimates[k, i] = state.recursion.estimate[i]
    return state


run_updates = compiled(_run_updates)
