"""What the PI loop of a scenario is like at a bandwidth: gains, margins, and what sensor noise does in it."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from adaptive_ff.scenario.scenario import Scenario
from controllers import LoopSystems, design_pi, estimate_velocity, initial_velocity_state, loop_margins_of
from plant import steepest_fall

SETTLED = 40.0
"""Time constants of the integral part over which a response to noise is followed."""

MOST_SAMPLES = 20_000
"""Samples after which a filter of the velocity has forgotten a reading."""


class LoopAtBandwidth(NamedTuple):
    """A PI loop of a scenario.

    Attributes
    ----------
    bandwidth : float
        Bandwidth that the gains are made for, Hz.
    proportional, integral : float
        Gains, N m s/rad and N m/rad.
    maximum_sensitivity, gain_margin, phase_margin : float
        Margins without friction; the last in degrees.
    hunts : bool
        Whether the loop is unstable where friction of the scenario's joint falls most steeply.
    noise_torque : float
        Torque that the noise of the measured velocity makes, N m rms.
    noise_velocity : float
        Velocity that this torque makes, rad/s rms: the error of the loop without friction.
    """

    bandwidth: float
    proportional: float
    integral: float
    maximum_sensitivity: float
    gain_margin: float
    phase_margin: float
    hunts: bool
    noise_torque: float
    noise_velocity: float


def loop_at(scenario: Scenario, bandwidth: float) -> LoopAtBandwidth:
    """Return what the PI loop of a scenario is like at a bandwidth (Hz).

    Rounding errors of an encoder are taken as independent and even, and go through what makes a velocity of them. That
    filter is not part of the loop whose margins are returned.

    Raises
    ------
    ValueError
        The margins do not allow the bandwidth.
    """
    inertia, period = scenario.feedback.inertia, scenario.sampling.period
    design = design_pi(inertia, period, bandwidth, delay=math.ceil(scenario.assumed_delay - 1e-6))
    fall = max(map(steepest_fall, (scenario.joint.friction, scenario.joint.friction_backward)))
    steep = design.systems(friction_slope=-fall) if math.isfinite(fall) else None
    torque, velocity = noise_gains(design.systems(), bandwidth * period, noise_response(scenario))
    resolution = scenario.sensor.encoder_resolution
    noise = scenario.sensor.velocity_noise if resolution is None else resolution / math.sqrt(12.0)
    return LoopAtBandwidth(
        bandwidth=bandwidth,
        proportional=design.proportional,
        integral=design.integral,
        maximum_sensitivity=design.maximum_sensitivity,
        gain_margin=design.gain_margin,
        phase_margin=design.phase_margin,
        hunts=steep is None or not loop_margins_of(steep).stable,
        noise_torque=noise * torque,
        noise_velocity=noise * velocity,
    )


def noise_response(scenario: Scenario) -> NDArray[np.float64]:
    """Return the velocity that a unit of measurement noise at one sample makes at this and the following ones.

    Of a velocity sensor it is that velocity itself, rad/s; of an encoder a position, rad, that a filter turns into one.
    """
    if scenario.sensor.encoder_resolution is None:
        return np.ones(1)
    period, observer = scenario.sampling.period, scenario.velocity_estimator
    state, response, largest = initial_velocity_state(observer, 0.0, 0.0), [], 0.0
    for k in range(MOST_SAMPLES):
        velocity, state = estimate_velocity(observer, state, 1.0 if k == 1 else 0.0, period)
        response.append(velocity)
        largest = max(largest, abs(velocity))
        if k > 2 and max(map(abs, response[-3:])) < 1e-6 * largest:
            break
    return np.array(response[1:])


def noise_gains(systems: LoopSystems, relative_bandwidth: float, response: NDArray[np.float64]) -> tuple[float, float]:
    """Return the rms torque and velocity that white measurement noise of unit size makes in a loop.

    Parameters
    ----------
    systems : LoopSystems
        The loop.
    relative_bandwidth : float
        Its bandwidth times its period.
    response : ndarray, shape (k,)
        Measured velocity after a unit of noise, see :func:`noise_response`.
    """
    numerator, denominator = systems.controller.num[0][0], systems.controller.den[0][0]
    above, below = systems.plant.num[0][0], systems.plant.den[0][0]
    characteristic = np.polyadd(np.polymul(denominator, below), np.polymul(numerator, above))
    count = math.ceil(SETTLED * 5.0 / (2.0 * math.pi * relative_bandwidth))
    seen = np.append(response, np.zeros(count))
    # in powers of the delay, falling powers of z need leading zeros where the numerator is shorter
    gains = []
    for polynomial in (np.polymul(numerator, below), np.polymul(numerator, above)):
        padded = np.concatenate([np.zeros(characteristic.size - polynomial.size), polynomial])
        gains.append(float(np.linalg.norm(lfilter(padded, characteristic, seen))))
    return gains[0], gains[1]
