"""What the estimator forgets, and corrects at once, after a change that was attributed to friction or to a load.

Along a direction ``d`` of the parameters the information ``M`` is reduced to ``known``, what the short window holds:

    M  ->  M - (1 - known / d'M d) M d d'M / (d'M d)        where d'M d > known

with ``m`` the length of the short window as a share of the memory:

- *Friction*: ``d`` is the friction of the estimate, ``known = m <f^2>``. Friction is multiplied at once by the factor
  ``1 + <e f>/<f^2>``, from 0.2 to 5. Where no offset is estimated every change is one of friction, without the factor.
- *A load*: ``d`` is the offset, ``known = 0.01 m`` times the square of its unit over the torque scale. The mean error
  ``<e>`` of the short window is corrected at once, and while the load settles offset and known loads alone are learnt.
- *Either*: both are forgotten, the offset to ``m`` times that square.

Why a change needs that, and how it is attributed, is in :mod:`adaptive_ff.adaptive.learning.change_detection`.
"""

import math

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.adaptive.learning.change_detection import EITHER, LOAD, NOTHING, Alarm, Surprise
from adaptive_ff.adaptive.learning.estimator_state import EstimatorParameters, load_count
from adaptive_ff.estimation.quadratic import quadratic_form, take_square_in_place, write_unit_in_place
from adaptive_ff.estimation.resetting import ResettingState
from adaptive_ff.friction.bounds import COULOMB, FRICTION_LAG, OFFSET

LEAST_FACTOR, LARGEST_FACTOR = 0.2, 5.0
"""Range of the factor by which friction is multiplied at once."""

FIRST_ERRORS = 5.0
"""Largest prediction error that is learnt from while no change is noticed, over the usual one."""

SUDDEN = 0.01
"""Information on the offset that is left after a load, over that of the short window.

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
    """Multiply all friction of an estimate by a factor; so many known loads at the end stay."""
    for i in range(estimate.size - loads):
        if COULOMB <= i < FRICTION_LAG or i > OFFSET:
            estimate[i] *= factor


@register_jitable
def follow_friction_in_place(estimate: NDArray[np.float64], product: float, squared: float, loads: int) -> None:
    """Multiply friction by ``1 + <e f>/<f^2>``, from 0.2 to 5; so many known loads at the end stay."""
    if squared > 0.0:
        factor = min(max(1.0 + product / squared, LEAST_FACTOR), LARGEST_FACTOR)
        scale_estimate_in_place(estimate, factor, loads)


@register_jitable
def leave_to_loads_in_place(correction: NDArray[np.float64], loads: int) -> None:
    """Set a correction to zero but for that of the offset and of known loads, while a load settles.

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

    - Where a change has just been attributed to a load it is the mean error ``<e>`` of the short window.
    - While no change is noticed it is the error of the sample, limited to 5 times the usual one. It may be the first of
      a change that will be noticed, and what such errors did to the estimates would stay.
    - Otherwise it is the error of the sample.

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
    """Reduce the information on the size of friction to what the short window holds.

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
    """Reduce the information on the offset to what the short window holds.

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
    """Reduce the information on what a sudden change is attributed to: friction, the offset, or both.

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
