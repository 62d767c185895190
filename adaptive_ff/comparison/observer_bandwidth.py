"""How fast an observer of the disturbing torque may be in a scenario: what the noise hides, what the margin allows."""

import math
from collections.abc import Callable

from adaptive_ff.errors import InputError
from adaptive_ff.scenario.scenario import Scenario
from controllers import ObserverDesign
from controllers.design.observer_design import SLOWEST


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
    scenario: Scenario, share: float, design: Callable[..., ObserverDesign], *gains: float, told: bool = False
) -> float:
    """Return a share of the balance, Hz, or the most that a maximum sensitivity of 2 allows where that is less.

    Where the velocity of an encoder leaves the PI loop itself with more than that, it is the slowest that is looked at.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    share : float
        Share of the balance.
    design : callable
        Design of the observer.
    *gains : float
        Gains that it takes.
    told : bool, optional
        Whether the observer is told the lag of the velocity, and needs no margin for it.
    """
    inertia, period = scenario.feedback.inertia, scenario.sampling.period
    delay = math.ceil(scenario.assumed_delay - 1e-6)
    velocity = None if told and scenario.velocity_lag > 0.0 else scenario.velocity_estimator
    try:
        largest = design(inertia, period, *gains, delay=delay, velocity=velocity).bandwidth
    except ValueError as error:
        if scenario.sensor.encoder_resolution is None:
            raise InputError(f"feedback: {error}") from error
        largest = SLOWEST * gains[0] / (2.0 * math.pi * inertia)
    return min(share * balance(scenario), largest)
