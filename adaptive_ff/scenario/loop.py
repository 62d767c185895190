"""What the PI loop of a scenario is like at a bandwidth: gains, margins, what noise does in it, and how stiff it is."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.scenario.content import Content
from controllers import (
    LoopSystems,
    design_pi,
    estimate_velocity,
    fastest_bandwidth,
    initial_velocity_state,
    loop_margins_of,
)
from controllers.checks import PI_SENSITIVITY
from controllers.design.margins import loop_margins
from controllers.design.sampled_loop import SampledLoop, open_loop
from controllers.design.velocity_filter import filter_of
from plant import steepest_fall

SETTLED = 40.0  # time constants of the integral part over which a response to noise is followed
MOST_SAMPLES = 20_000  # samples after which a filter of the velocity has forgotten a reading
LOAD_FRACTION = 0.4  # step of the load that a loop is to stand, over the rated torque, the limit of the drive
TREMBLING = 0.1  # torque that measurement noise may cost (rms), over the rated torque
HUNTING = 1.0  # fall of the friction over the proportional gain from which the loop itself hunts at low speed
REVERSALS = 1.0  # reversals of a motion in a second that the error of friction is reckoned for
SLOWEST, SLOWEST_FRACTION = 1.0, 0.25  # slowest loop that is tried, Hz, and over the fastest one where that is less
STEP = 2.0**0.5  # ratio of one bandwidth that is tried to the next


class LoopAtBandwidth(NamedTuple):
    """A PI loop of a scenario."""

    bandwidth: float  # bandwidth that the gains are made for, Hz
    # gains, N m s/rad and N m/rad
    proportional: float
    integral: float
    # margins without friction, with delay and velocity filter; the last in degrees
    maximum_sensitivity: float
    gain_margin: float
    phase_margin: float
    hunts: bool  # whether the loop is unstable where friction of the scenario's joint falls most steeply
    noise_torque: float  # torque that the noise of the measured velocity makes, N m rms
    noise_velocity: float  # velocity that this torque makes, rad/s rms: the error of the loop without friction
    # velocity that Coulomb friction makes where it turns once a second, rad/s rms, without feedforward
    friction_velocity: float
    angle_lost: float  # angle that the joint gives way for each N m of a load, ``1/Ki``, rad/(N m)
    peak_speed: float  # largest speed after a step of the load of :func:`load_step`, rad/s


def sampled(scenario: Content) -> dict[str, Any]:
    """Return what a design of the velocity loop takes: period, s, delay, whole periods, and velocity estimator."""
    delay = math.ceil(scenario.assumed_delay - 1e-6)
    return {"period": scenario.sampling.period, "delay": delay, "velocity": scenario.velocity_estimator}


def tried_bandwidths(scenario: Content, fraction: float = 1.0) -> list[float]:
    """Return the bandwidths (Hz) that are tried, ascending, up to a fraction of the fastest that the margin allows."""
    fastest = fraction * fastest_bandwidth(**sampled(scenario))
    slowest = min(SLOWEST, SLOWEST_FRACTION * fastest)
    count = math.floor(math.log(fastest / slowest) / math.log(STEP) + 1e-9) + 1
    return [fastest / STEP**step for step in reversed(range(count))]


def load_step(scenario: Content, load: float = LOAD_FRACTION) -> float:
    """Return the load (N m) that a loop is to stand, of the rated torque; where none is given, 0.4 is the stiction."""
    limit = scenario.actuator.torque_limit
    return scenario.joint.stiction * (load / LOAD_FRACTION) if limit is None else load * limit


def loop_at(scenario: Content, bandwidth: float, load: float = LOAD_FRACTION) -> LoopAtBandwidth:
    """Return what the PI loop of a scenario is like at a bandwidth (Hz).

    Rounding errors of an encoder are taken as independent and even, and go through what makes a velocity of them.
    """
    joint, inertia = scenario.joint, scenario.feedback.inertia
    design = design_pi(inertia, bandwidth=bandwidth, **sampled(scenario))
    systems, relative = design.systems(), bandwidth * scenario.sampling.period
    fall = max(map(steepest_fall, (joint.friction, joint.friction_backward)))
    steep = design.systems(friction_slope=-fall) if math.isfinite(fall) else None
    torque, velocity = noise_gains(systems, relative, noise_response(scenario))
    resolution = scenario.sensor.encoder_resolution
    noise = scenario.sensor.velocity_noise if resolution is None else resolution / math.sqrt(12.0)
    yielded = load_response(systems, relative, inertia)
    energy = float(np.sum(yielded**2)) * scenario.sampling.period
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
        friction_velocity=2.0 * joint.coulomb * math.sqrt(REVERSALS * energy),
        angle_lost=1.0 / design.integral,
        peak_speed=load_step(scenario, load) * float(np.max(np.abs(yielded))),
    )


def noise_response(scenario: Content) -> NDArray[np.float64]:
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

    The bandwidth of the loop is given times its period, and the velocity after a unit of noise by
    :func:`noise_response`.
    """
    noise = np.append(response, np.zeros(_samples(relative_bandwidth)))
    torque = _filtered(systems.controller, _filtered(systems.sensitivity, noise))
    return float(np.linalg.norm(torque)), float(np.linalg.norm(_filtered(systems.plant, torque)))


def load_response(systems: LoopSystems, relative_bandwidth: float, inertia: float) -> NDArray[np.float64]:
    """Return the velocity (rad/s) at the samples after a step of the load of 1 N m, friction aside."""
    step = np.ones(_samples(relative_bandwidth))
    period: float = systems.plant.dt
    return np.cumsum(_filtered(systems.sensitivity, step)) * (period / inertia)


def _samples(relative_bandwidth: float) -> int:
    return math.ceil(SETTLED * 5.0 / (2.0 * math.pi * relative_bandwidth))


def _filtered(system: Any, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the output of a transfer function in ``z``; in powers of the delay short numerators begin with zeros."""
    numerator, denominator = system.num[0][0], system.den[0][0]
    padded = np.concatenate([np.zeros(denominator.size - numerator.size), numerator])
    found: NDArray[np.float64] = scipy.signal.lfilter(padded, denominator, values)
    return found


def fall_over_gain(scenario: Content) -> float:
    """Return how steeply friction falls at worst, over the proportional gain; above one the loop hunts at low speed."""
    steepest = max(map(steepest_fall, (scenario.joint.friction, scenario.joint.friction_backward)))
    return float(steepest / scenario.feedback.gains[0])


def loop_cautions(scenario: Content) -> Iterator[str]:
    """Yield a sentence where the velocity loop oscillates, by its margins or because friction falls too steeply."""
    gains, inertia = scenario.feedback.gains, scenario.feedback.inertia
    given = sampled(scenario)
    period, measured = given["period"], filter_of(given["velocity"])
    loop = SampledLoop(gains[0] * period / inertia, gains[1] * period**2 / inertia, given["delay"], measured)
    reached = loop_margins(*open_loop(loop), 1e-2 * min(loop.proportional, 1.0))
    if reached.maximum_sensitivity > PI_SENSITIVITY * (1.0 + 1e-3):
        shown = (
            f"the velocity loop oscillates: its maximum sensitivity is {reached.maximum_sensitivity:.3g} and its phase "
            f"margin {reached.phase_margin:.2g} degrees"
            if reached.stable
            else "the velocity loop is unstable"
        )
        yield (
            f"{shown}, delay and velocity filter included; feedback.bandwidth = "
            f"{fastest_bandwidth(**given):.3g} Hz or less keeps a sensitivity of {PI_SENSITIVITY:g}"
        )
    if (fall := fall_over_gain(scenario)) > HUNTING:
        unit = axis_unit(scenario.joint.axis, "N m s/rad")
        yield (
            f"the friction curve falls by up to {fall * gains[0]:.4g} {unit}, more than the proportional gain of "
            f"{gains[0]:.4g} {unit} can hold: the loop will hunt at low speed"
        )
