"""Observer of the torque that the feedforward lacks, and its gain.

    d = 0.85 low-pass(u - fed + J de/dt + sigma e)
    gain = min(1, 2 R^2),      R^2 = <e0 G d>^2 / (max(<e0^2>, noise) <(G d)^2>)

What is fed holds viscous friction along the reference; the joint's own is less by ``sigma e``, which is no disturbance.
``e0`` is the error without the observer, ``G d`` the response of the loop to what is observed: how much of that error
it explains is their coefficient of determination, over the last second. At first it explains all, of a small
error: before anything is learnt the observer is what moves a joint off. As any disturbance observer it needs the torque
``u`` that acted, from the drive or within a known limit (K. Ohnishi et al. 1996); while that is unknown nothing is
observed, since what a drive keeps would be lacking, too.
"""

import math

from adaptive_ff.adaptive.state import AdaptiveParameters, AdaptiveState, Observer
from adaptive_ff.friction.columns import VISCOUS
from adaptive_ff.learning.kalman import LOOP
from controllers import delayed


def judged(observer: Observer, bare: float, brought: float, weight: float) -> Observer:
    """Return the observer after a sample.

    Parameters
    ----------
    observer : Observer
        The observer.
    bare : float
        Error without it, rad/s.
    brought : float
        Response to the observed torque in full, rad/s.
    weight : float
        Weight of a new product in the means.
    """
    error = observer.error + weight * (bare * bare - observer.error)
    product = observer.product + weight * (bare * brought - observer.product)
    square = observer.brought + weight * (brought * brought - observer.brought)
    return Observer(observer.torque, observer.gain, error, product, square)


def gate(parameters: AdaptiveParameters, observer: Observer, level: float) -> float:
    """Return the gain from the fraction of the error that the observer explains; an error has a noise level, rad/s."""
    if observer.product <= 0.0 or observer.brought <= 0.0:
        return 0.0
    determination = observer.product / observer.brought * (observer.product / max(observer.error, level * level))
    return min(1.0, determination / parameters.tuning.explained)


def observed(
    parameters: AdaptiveParameters,
    state: AdaptiveState,
    torque: float,
    error: float,
    acceleration: float,
    duration: float,
) -> float:
    """Return the observed torque after a period, N m.

    Parameters
    ----------
    parameters, state : AdaptiveParameters, AdaptiveState
        The controller.
    torque : float
        Torque that acted, N m.
    error : float
        Error, rad/s.
    acceleration : float
        Change of the error, rad/s^2.
    duration : float
        The period, s.
    """
    lacking = torque - delayed(state.modelled, parameters.feedback.delay) + parameters.machine.inertia * acceleration
    lacking += float(state.estimate.mean[LOOP + VISCOUS]) * error
    follows = -math.expm1(-parameters.machine.observer_pole * duration)
    return state.observer.torque + follows * (parameters.tuning.observed_fraction * lacking - state.observer.torque)
