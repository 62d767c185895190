import math
import re

import numpy as np
import pytest

import controllers
from controllers.design.margins import MOST_DELAY, check_design

INERTIA = 20.0


def loop_response(design, period, delay, frequency):
    """Open loop at a frequency in Hz: PI with backward Euler sum, hold, inertia, delay."""
    z = np.exp(2j * np.pi * np.asarray(frequency) * period)
    controller = design.proportional + design.integral * period * z / (z - 1.0)
    return controller * period / (INERTIA * (z - 1.0)) / z**delay


def closed_loop_poles(design, period, delay, gain=1.0):
    """Roots of ``J (z - 1)^2 z^delay + gain Ts (Kp (z - 1) + Ki Ts z)``."""
    controller = np.array([design.proportional + design.integral * period, -design.proportional])
    return np.roots(np.polyadd(INERTIA * np.poly([1.0, 1.0] + [0.0] * delay), gain * period * controller))


CASES = [(0.001, 0, 10.0), (0.001, 0, 100.0), (0.01, 0, 10.0), (0.01, 1, 5.0), (0.022, 0, 5.0), (0.022, 2, 1.0)]


@pytest.mark.parametrize(("period", "delay", "bandwidth"), CASES)
def test_margins_agree_with_a_brute_force_frequency_response(period, delay, bandwidth):
    design = controllers.design_pi(INERTIA, period, bandwidth, delay=delay)
    frequency = np.linspace(1e-3 * bandwidth, 0.5 / period, 400_001)
    loop = loop_response(design, period, delay, frequency)
    assert design.maximum_sensitivity == pytest.approx(np.max(1.0 / np.abs(1.0 + loop)), rel=1e-4)
    crossing = np.nonzero(np.abs(loop) >= 1.0)[0][-1]
    assert design.crossover == pytest.approx(frequency[crossing], rel=0.01)
    # measured from the negative real axis, so no unwrapping is needed
    assert design.phase_margin == pytest.approx(math.degrees(np.angle(-loop[crossing])), abs=0.5)


@pytest.mark.parametrize(("period", "delay", "bandwidth"), CASES)
def test_closed_loop_is_stable_up_to_the_stated_gain_margin(period, delay, bandwidth):
    design = controllers.design_pi(INERTIA, period, bandwidth, delay=delay)
    assert design.gain_margin > 1.7 / 0.7  # follows from a maximum sensitivity of 1.7
    assert np.max(np.abs(closed_loop_poles(design, period, delay))) < 1.0
    assert np.max(np.abs(closed_loop_poles(design, period, delay, 0.98 * design.gain_margin))) < 1.0
    assert np.max(np.abs(closed_loop_poles(design, period, delay, 1.02 * design.gain_margin))) > 1.0


@pytest.mark.parametrize(
    ("period", "delay", "least", "most"),
    [(0.001, 0, 118.0, 122.0), (0.01, 0, 11.8, 12.2), (0.022, 0, 5.4, 5.6), (0.01, 1, 5.15, 5.25)],
)
def test_fastest_loop_for_a_maximum_sensitivity_of_1_7(period, delay, least, most):
    design = controllers.design_pi(INERTIA, period, delay=delay)
    assert least < design.bandwidth < most
    assert design.bandwidth == controllers.fastest_bandwidth(period, delay)
    frequency = np.linspace(1e-3 * design.bandwidth, 0.5 / period, 400_001)
    sensitivity = 1.0 / np.abs(1.0 + loop_response(design, period, delay, frequency))
    assert np.max(sensitivity) == pytest.approx(1.7, rel=1e-4)


@pytest.mark.parametrize("sensitivity", [1.2, 2.0, 3.0, 10.0, 30.0])
def test_bound_on_the_sensitivity_is_met_by_a_stable_loop_and_no_faster_one_meets_it(sensitivity):
    design = controllers.design_pi(INERTIA, 0.01, maximum_sensitivity=sensitivity)
    assert design.maximum_sensitivity == pytest.approx(sensitivity, rel=1e-4)
    assert np.max(np.abs(closed_loop_poles(design, 0.01, 0))) < 1.0
    with pytest.raises(ValueError, match="bandwidth"):
        controllers.design_pi(INERTIA, 0.01, 1.01 * design.bandwidth, maximum_sensitivity=sensitivity)
    with pytest.raises(
        ValueError, match=r"maximum_sensitivity = 1.0001 is not allowed: even the slowest loop has 1.\d"
    ):
        controllers.design_pi(INERTIA, 0.01, maximum_sensitivity=1.0001)


def test_longest_delay_is_designed_for():
    check_design(MOST_DELAY)
    with pytest.raises(ValueError, match=f"delay = {MOST_DELAY + 1} is not allowed: it must be a whole number"):
        check_design(MOST_DELAY + 1)


@pytest.mark.parametrize("bandwidth", [1.0, 10.0])
def test_gains_follow_the_stated_rule_and_scale_with_inertia(bandwidth):
    crossover = 2.0 * math.pi * bandwidth
    gains = controllers.pi_gains(INERTIA, bandwidth)
    assert gains == pytest.approx((crossover * 20.0, crossover * 20.0 * crossover / 5.0), rel=1e-14)
    design, light = controllers.design_pi(INERTIA, 0.001, bandwidth), controllers.PI.design(2.0, 0.001, bandwidth)
    assert (design.proportional, design.integral) == gains
    assert design.proportional == pytest.approx(10.0 * light.proportional, rel=1e-14)
    assert design.maximum_sensitivity == light.maximum_sensitivity


@pytest.mark.parametrize("period", [0.001, 0.004, 0.01, 0.022])
@pytest.mark.parametrize("delay", [0, 1, 2])
def test_too_fast_bandwidth_is_refused_and_the_one_named_is_accepted(period, delay):
    with pytest.raises(ValueError, match=r"bandwidth = 400 Hz is not allowed") as caught:
        controllers.design_pi(INERTIA, period, 400.0, delay=delay)
    named = float(re.search(r"at most (\S+) Hz", str(caught.value))[1])
    design = controllers.design_pi(INERTIA, period, named, delay=delay)
    assert design.bandwidth == named
    assert named > 0.995 * controllers.fastest_bandwidth(period, delay)


def stribeck(speed):
    """Friction that falls by up to 30/0.05 - 80 = 520 N m s/rad, at rest."""
    return 60.0 + 30.0 * math.exp(-speed / 0.05) + 80.0 * speed


def test_friction_that_falls_more_steeply_than_the_gain_is_warned_of():
    bandwidth = 500.0 / (2.0 * math.pi * INERTIA)  # Kp = 500 N m s/rad
    with pytest.warns(UserWarning, match=r"falls by up to 520 .* gain of 500 .* hunt") as said:
        controllers.design_pi(INERTIA, 0.01, bandwidth, friction=stribeck)
    assert said[0].filename == __file__


def encoders(period):
    """Three estimators of a velocity from an encoder of 4096 counts a turn."""
    kalman = controllers.kalman_velocity_gains(2.0 * math.pi / 4096 / math.sqrt(12.0), 20.0, period)
    return [
        controllers.difference_velocity(period),
        controllers.low_pass_velocity(50.0, period),
        controllers.kalman_velocity(*kalman, period),
    ]


def size_after(design, gain, periods=4000):
    """Speed of an inertia in the loop long after a kick, over that soon after it; the loop sees its position."""
    estimator, period = design.velocity, design.period
    state, commands = controllers.initial_velocity_state(estimator, 0.0, 0.0), [0.0] * design.delay
    position, velocity, integral, sizes = 0.0, 1.0, 0.0, []
    for _ in range(periods):
        measured, state = controllers.estimate_velocity(estimator, state, position, period)
        integral -= design.integral * period * measured
        commands.append(gain * (integral - design.proportional * measured))
        acceleration = commands.pop(0) / INERTIA
        position += period * (velocity + 0.5 * period * acceleration)
        velocity += period * acceleration
        sizes.append(abs(velocity))
    return max(sizes[-200:]) / max(sizes[200:400])


@pytest.mark.parametrize("kind", [0, 1, 2], ids=["difference", "low-pass", "kalman"])
@pytest.mark.parametrize("delay", [0, 1])
def test_loop_of_an_encoder_is_stable_up_to_the_stated_gain_margin_and_the_margins_are_those_of_its_systems(
    kind, delay
):
    design = controllers.PI.design(INERTIA, 0.001, delay=delay, velocity=encoders(0.001)[kind])
    assert design.maximum_sensitivity == pytest.approx(1.7, rel=1e-4)
    assert design.bandwidth < controllers.PI.design(INERTIA, 0.001, delay=delay).bandwidth
    assert size_after(design, 0.95 * design.gain_margin) < 0.5
    assert size_after(design, 1.05 * design.gain_margin) > 2.0
    found = controllers.loop_margins_of(design.systems())
    assert found.maximum_sensitivity == pytest.approx(1.7, rel=2e-3)
    assert (found.stable, found.phase_margin) == (True, pytest.approx(design.phase_margin, abs=0.5))
    with pytest.raises(ValueError, match=r"periods of delay and velocity filter and a maximum sensitivity of 1\.7"):
        controllers.PI.design(INERTIA, 0.001, 1.02 * design.bandwidth, delay=delay, velocity=design.velocity)
