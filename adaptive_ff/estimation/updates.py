"""Recursive linear estimators behind one interface: ``output = regressors . estimate + error``, equation by equation.

An estimator is a kernel ``correct(block, state, regressors, instruments, output, error, duration)`` that corrects the
estimate by its recursion and fills in the gain ``g`` of that correction, ``g error``; it is registered by the class of
its parameters in ``CORRECTIONS``. What all have in common is done around it, once: equations that are not finite are
left out, the covariance of the estimate follows the gain (see ``spread``), and the level of the equation errors is
tallied.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.estimation.quadratic import quadratic_form
from adaptive_ff.estimation.spread import update_spread
from controllers import compiled_in_place, dispatched

WEIGHT, WEIGHT_SQUARED, SQUARES, TAKEN, REJECTED = range(5)
"""Entries of a tally."""

LARGEST_NUMBER = 1e100
"""What is larger is no measurement; its square may lie beyond what a floating-point number can hold."""


class Settings(NamedTuple):
    """What every estimator is told.

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
    gain, projected : ndarray, shape (n,)
        Scratch, of its own for each estimator.
    """

    first: NDArray[np.float64]
    deviation: NDArray[np.float64]
    noise: float
    memory: float
    gain: NDArray[np.float64]
    projected: NDArray[np.float64]


class Progress(NamedTuple):
    """What every estimator keeps; the arrays are changed in place.

    Attributes
    ----------
    estimate : ndarray, shape (n,)
        The parameters.
    spread : ndarray, shape (n, n)
        Their covariance, in units of the variance of an equation's error.
    tally : ndarray, shape (5,)
        Fading sums over the equations of their weights, of the squares of the weights, and of the weighted squares of
        the errors, for the level of the error; numbers of equations taken into account and rejected.
    """

    estimate: NDArray[np.float64]
    spread: NDArray[np.float64]
    tally: NDArray[np.float64]


CORRECTIONS: dict[type, Callable[..., Any]] = {}
"""Kernel of each class of parameters."""


def initial_progress(settings: Settings) -> Progress:
    """Return the state of an estimator that has seen nothing."""
    return Progress(settings.first.copy(), np.diag((settings.deviation / settings.noise) ** 2), np.zeros(5))


def _correct(block: Any, state: Any, regressors: Any, instruments: Any, output: Any, error: Any, duration: Any) -> Any:
    return CORRECTIONS[type(block)](block, state, regressors, instruments, output, error, duration)


correct = dispatched(CORRECTIONS, _correct)
"""Correct any estimator's estimate and fill in the gain of the correction."""


@register_jitable(forceinline=True)
def usable(regressors: NDArray[np.float64], instruments: NDArray[np.float64], output: float) -> bool:
    """Tell whether all numbers of an equation are finite, and none is beyond reckoning."""
    for i in range(regressors.size):
        if not (abs(regressors[i]) <= LARGEST_NUMBER and abs(instruments[i]) <= LARGEST_NUMBER):
            return False
    return abs(output) <= LARGEST_NUMBER


@register_jitable(forceinline=True)
def count_error(tally: NDArray[np.float64], error: float, predicted: float, keep: float) -> None:
    """Count an error in units of the expected one.

    What the uncertain estimate adds to the variance of the error, ``x' C x``, is divided out, and an equation counts
    the less, the more that is: the first ones tell of the first estimate, not of the level of the error.
    """
    weight = 1.0 / (1.0 + predicted)
    tally[WEIGHT] = keep * tally[WEIGHT] + weight
    tally[WEIGHT_SQUARED] = keep * keep * tally[WEIGHT_SQUARED] + weight * weight
    tally[SQUARES] = keep * tally[SQUARES] + weight * weight * error * error
    tally[TAKEN] += 1.0


@register_jitable(forceinline=True)
def update_estimator(
    block: Any,
    state: Any,
    regressors: NDArray[np.float64],
    instruments: NDArray[np.float64],
    output: float,
    duration: float,
) -> float:
    """Take one equation into account; return the error of its prediction, not a number where it was rejected."""
    settings, progress = block.settings, state.progress
    if not usable(regressors, instruments, output):
        progress.tally[REJECTED] += 1.0
        return math.nan
    error = output
    for i in range(regressors.size):
        error -= regressors[i] * progress.estimate[i]
    correct(block, state, regressors, instruments, output, error, duration)
    predicted = quadratic_form(progress.spread, regressors, settings.projected)  # variance, in that of the error
    count_error(progress.tally, error / settings.noise, predicted, math.exp(-duration / settings.memory))
    update_spread(progress.spread, settings.gain, settings.projected, predicted)
    return error


def _single_update(block: Any, state: Any, regressors: Any, instruments: Any, output: float, duration: float) -> float:
    error: float = update_estimator(block, state, regressors, instruments, output, duration)
    return error


single_update = compiled_in_place(_single_update)


def _run_updates(
    block: Any,
    state: Any,
    rows: Any,
    instruments: Any,
    outputs: Any,
    durations: Any,
    errors: Any,
    estimates: Any,
) -> None:
    for k in range(outputs.size):
        errors[k] = update_estimator(block, state, rows[k], instruments[k], outputs[k], durations[k])
        for i in range(rows.shape[1]):
            estimates[k, i] = state.progress.estimate[i]


run_updates = compiled_in_place(_run_updates)
