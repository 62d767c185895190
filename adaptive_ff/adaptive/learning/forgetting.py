"""What a change that was attributed makes the estimator forget, and take over at once.

What is forgotten, and how, is told in :mod:`adaptive_ff.adaptive.learning.change_detection`.
"""

import math

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.adaptive.learning.change_detection import EITHER, LOAD, NOTHING, Alarm, Surprise
from adaptive_ff.adaptive.learning.estimator_state import EstimatorParameters, load_count
from adaptive_ff.estimation.quadratic import quadratic_form, take_square_in_place, write_unit_in_place
from adaptive_ff.estimation.resetting import ResettingState
from adaptive_ff.model.bounds import COULOMB, FRICTION_LAG, OFFSET

LEAST_FACTOR, LARGEST_FACTOR = 0.2, 5.0
"""Range of the factor by which friction is taken to have changed at once."""

FIRST_ERRORS = 5.0
"""Largest error, times the usual one, that is learnt from before a change is noticed."""

SUDDEN = 0.01
"""What is left of the information of the offset when a change was a load, times that of the short window.

Gravity changes with the position, and not at once: with little left the offset takes all of a sudden load, so that
nothing of a push that ends stays in gravity.
"""


@register_jitable
def release_in_place(
    information: NDArray[np.float64], direction: NDArray[np.float64], known: float, work: NDArray[np.float64]
) -> None:
    """Reduce the information along a direction.

    Parameters
    ----------
    information : ndarray, shape (n, n)
        Information matrix ``M``; changed in place.
    direction : ndarray, shape (n,)
        The direction ``d``.
    known : float
        What is left of ``d'M d``, more than zero, where it was more.
    work : ndarray, shape (n,)
        Scratch.
    """
    total = quadratic_form(information, direction, work)
    if not total > known:
        return
    take_square_in_place(information, (1.0 - known / total) / total, work)


@register_jitable
def scale_estimate_in_place(estimate: NDArray[np.float64], factor: float, loads: int) -> None:
    """Multiply all friction of an estimate by a factor, but for so many loads at the end."""
    for i in range(estimate.size - loads):
        if COULOMB <= i < FRICTION_LAG or i > OFFSET:
            estimate[i] *= factor


@register_jitable
def follow_friction_in_place(estimate: NDArray[np.float64], product: float, squared: float, loads: int) -> None:
    """Scale friction, in place, by the factor that ``<e f>`` and ``<f^2>`` say, but for so many loads at the end."""
    if squared > 0.0:
        factor = min(max(1.0 + product / squared, LEAST_FACTOR), LARGEST_FACTOR)
        scale_estimate_in_place(estimate, factor, loads)


@register_jitable
def leave_to_loads_in_place(correction: NDArray[np.float64], loads: int) -> None:
    """Keep of a correction that of the offset and of known loads, while a change that was a load settles.

    What is left of the error is the load's then; inertia and friction would be made to explain its transients.
    """
    for i in range(correction.size - loads):
        if i != OFFSET:
            correction[i] = 0.0


@register_jitable
def explain_in_place(correction: NDArray[np.float64], gradient: NDArray[np.float64], error: float) -> None:
    """Scale a correction so that it explains an error, all in the scaled units of the gradient."""
    explained = 0.0
    for i in range(correction.size):
        explained += correction[i] * gradient[i]
    if explained * error > 0.0:
        for i in range(correction.size):
            correction[i] *= error / explained


@register_jitable
def error_to_learn(alarm: Alarm, followed: bool, surprise: Surprise, error: float, usual: float) -> float:
    """Return the prediction error that is learnt from, in units of the torque scale.

    A load that has just been told is followed by all of it. The first errors of a change, before it is noticed, are cut
    off; what they did to the estimates would stay.

    Parameters
    ----------
    alarm : Alarm
        The change.
    followed : bool
        Whether it has just been attributed, and holds.
    surprise : Surprise
        Means over the short window.
    error : float
        The error at this sample.
    usual : float
        Mean squared error that is usual; infinite while no change can be noticed.
    """
    if followed and alarm.cause == LOAD:
        return surprise.error
    if alarm.cause == NOTHING:
        largest = FIRST_ERRORS * math.sqrt(usual)
        return min(max(error, -largest), largest)
    return error


@register_jitable
def forget_friction_in_place(
    information: NDArray[np.float64],
    estimate: NDArray[np.float64],
    scale: NDArray[np.float64],
    mean: float,
    share: float,
    work: NDArray[np.float64],
    loads: int = 0,
) -> None:
    """Forget how large friction is, but for what the short window holds.

    Parameters
    ----------
    information : ndarray, shape (n, n)
        Information matrix of the scaled parameters; changed in place.
    estimate, scale : ndarray, shape (n,)
        The parameters, and the unit of each.
    mean : float
        Mean squared friction over the short window, in units of the torque scale squared.
    share : float
        Length of the short window as a share of the memory.
    work : ndarray, shape (n, n)
        Scratch.
    loads : int, optional
        How many of the last parameters are sizes of known loads, which are kept.
    """
    direction, size = work[0], estimate.size - loads
    for i in range(estimate.size):
        direction[i] = estimate[i] / scale[i] if COULOMB <= i < FRICTION_LAG or OFFSET < i < size else 0.0
    release_in_place(information, direction, share * mean, work[1])


@register_jitable
def forget_offset_in_place(
    information: NDArray[np.float64],
    scale: NDArray[np.float64],
    unit: float,
    share: float,
    work: NDArray[np.float64],
    loads: int = 0,
) -> None:
    """Forget the offset, but for what the short window holds.

    Arguments are those of :func:`forget_friction_in_place`, beside them the torque scale ``unit``, N m.
    """
    if scale.size - loads > OFFSET:
        direction = work[0]
        write_unit_in_place(direction, OFFSET)
        size = scale[OFFSET] / unit
        release_in_place(information, direction, share * (size * size), work[1])


@register_jitable
def forget_in_place(
    estimator: EstimatorParameters, recursion: ResettingState, mean: float, alarm: Alarm, share: float
) -> None:
    """Forget, but for what the short window holds, what a sudden change is attributed to.

    Parameters
    ----------
    estimator : EstimatorParameters
        The estimator.
    recursion : ResettingState
        Estimate and information; the latter is changed in place.
    mean : float
        Mean squared friction over the short window, in units of the torque scale squared.
    alarm : Alarm
        The change.
    share : float
        Length of the short window as a share of the memory.
    """
    information, scale, unit = recursion.information, estimator.scale, estimator.torque_scale
    loads, work = load_count(estimator), recursion.factor
    if alarm.cause != LOAD:
        forget_friction_in_place(information, recursion.estimate, scale, mean, share, work, loads)
    if alarm.cause == LOAD:
        forget_offset_in_place(information, scale, unit, SUDDEN * share, work, loads)
    elif alarm.cause == EITHER:
        forget_offset_in_place(information, scale, unit, share, work, loads)
