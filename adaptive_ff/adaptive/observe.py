"""Observer of the torque that the feedforward lacks, and its gate.

    d = 0.8 low-pass(u - fed - J de/dt),      gate from <(e0 - G d)^2> over <e0^2>

Where a drive gives less torque than it is asked for and does not say so, what it keeps is lacking, too; observed in
part, it stays below four times what else is asked for. ``e0`` is the error without the observer: the response of the
loop tells it, and what the observer would make of it.
"""

import math

from adaptive_ff.adaptive.state import AdaptiveParameters, AdaptiveState, Observer
from controllers import delayed


def judged(observer: Observer, bare: float, brought: float, share: float) -> Observer:
    """Return the observer after a sample.

    Parameters
    ----------
    observer : Observer
        The observer.
    bare : float
        Error without it, rad/s.
    brought : float
        Response to the observed torque in full, rad/s.
    share : float
        Share that a new square has in the means.
    """
    left = bare - brought
    without = observer.without + share * (bare * bare - observer.without)
    with_it = observer.with_it + share * (left * left - observer.with_it)
    return Observer(observer.torque, observer.gain, without, with_it, observer.handed, observer.shifted)


def gate(parameters: AdaptiveParameters, observer: Observer) -> float:
    """Return the gain from what the observer brings."""
    tuning = parameters.tuning
    if observer.without <= 0.0:
        return observer.gain
    ratio = observer.with_it / observer.without
    return min(1.0, max(0.0, (1.0 - ratio) / (1.0 - tuning.gate_on)))


def observed(
    parameters: AdaptiveParameters, state: AdaptiveState, torque: float, acceleration: float, duration: float
) -> float:
    """Return the observed torque after a period, N m.

    Parameters
    ----------
    parameters, state : AdaptiveParameters, AdaptiveState
        The controller.
    torque : float
        Torque that acted, N m.
    acceleration : float
        Change of the error, rad/s^2.
    duration : float
        The period, s.
    """
    lacking = torque - delayed(state.modelled, parameters.feedback.delay) + parameters.machine.inertia * acceleration
    follows = -math.expm1(-parameters.machine.observer_pole * duration)
    return state.observer.torque + follows * (parameters.tuning.observed_share * lacking - state.observer.torque)
