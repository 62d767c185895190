"""How fast an observer of the disturbing torque may be in a scenario: what the noise hides, what the margin allows."""

import math
from collections.abc import Callable

from adaptive_ff.errors import InputError
from adaptive_ff.scenario.scenario import Scenario
from controllers import ObserverDesign
from controllers.design.observer_design import SLOWEST

LARGEST_BEHIND_FILTER = 4.5
"""Largest maximum sensitivity, for the measured velocity, with which an observer is as fast as for the true one.

With 2 the observers alone are up to 1.7 times worse with a fine encoder and its Kalman filter (``encoder``,
``positioning``), where they have 3 to 4.1 with their usual bandwidth; without a bound a fast loop oscillates.
"""


def balance(scenario: Scenario) -> float:
    """Return the frequency (Hz) at which what friction does and what the noise hides balance.

    It is the bandwidth of a Kalman filter for the noise of the measured velocity and for a disturbance that walks by
    ``Kp Vs``, a torque, in a root of a second; infinite without noise.
    """
    noise = scenario.velocity_noise
    if noise == 0.0:
        return math.inf
    walk = scenario.feedback.gains[0] * scenario.adaptation.stribeck_velocity
    return math.sqrt(walk / (scenario.feedback.inertia * noise * math.sqrt(scenario.sampling.period))) / (2.0 * math.pi)


def observer_bandwidth(
    scenario: Scenario, multiple: float, design: Callable[..., ObserverDesign], *gains: float, bounded: bool = True
) -> float:
    """Return a multiple of the balance, Hz, or the most that a maximum sensitivity of 2 allows where that is less.

    ``design`` is the observer's, with the gains that it takes. Where an encoder's velocity leaves the loop with a
    maximum sensitivity beyond :data:`LARGEST_BEHIND_FILTER` it is less, and where the PI loop itself has more, it is
    the slowest that a design looks at; not bounded so is an observer that knows its lag.
    """
    inertia, period = scenario.feedback.inertia, scenario.sampling.period
    delay = math.ceil(scenario.assumed_delay - 1e-6)
    try:
        largest = design(inertia, period, *gains, delay=delay).bandwidth
    except ValueError as error:
        raise InputError(f"feedback: {error}") from error
    bandwidth = min(multiple * balance(scenario), largest)
    if scenario.sensor.encoder_resolution is None or not bounded:
        return bandwidth
    measured = {"delay": delay, "velocity": scenario.velocity_estimator}
    if design(inertia, period, *gains, bandwidth, **measured).maximum_sensitivity <= LARGEST_BEHIND_FILTER:
        return bandwidth
    try:
        slower = design(inertia, period, *gains, maximum_sensitivity=LARGEST_BEHIND_FILTER, **measured).bandwidth
    except ValueError:
        slower = SLOWEST * gains[0] / (2.0 * math.pi * inertia)
    return min(bandwidth, slower)
