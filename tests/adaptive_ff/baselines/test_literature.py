"""The baselines from the literature against their own equations, and on motions that they were made for."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from adaptive_ff.baselines.feedback_learning import FIRST, LearntFeedforward
from adaptive_ff.baselines.lee_tomizuka import zero_phase_torque
from adaptive_ff.baselines.lugre_observer import bent

GAINS = (1256.0, 15_000.0)
LEARNT = {"inertia": 20.0, "stribeck_velocity": 0.05}


def plan(seconds, period=0.01):
    """A motion with a period of 2 s, known one sample ahead."""
    time = period * np.arange(round(seconds / period) + 1)
    return 0.2 * np.sin(math.pi * time) + 0.1 * np.sin(3.0 * math.pi * time)


def test_elements_are_stop_operators_of_the_planned_way():
    controller = LearntFeedforward(*GAINS, 0.01, **LEARNT, reaches=[1e-3, 5e-3]).run_uncompiled()
    reference, loads, way = plan(1.5), np.zeros(2), np.array([1e-3, 5e-3])
    for now, following in zip(reference[:-1].tolist(), reference[1:].tolist(), strict=True):
        controller.step(now, now, next_reference=following)
        loads = np.clip(loads + 0.005 * (now + following) / way, -1.0, 1.0)
        assert controller.state.features[FIRST:] == pytest.approx(loads, abs=1e-12)
    assert np.ptp(reference) > 0.3


def test_weights_move_along_the_last_features_as_the_normalised_gradient_says():
    controller = LearntFeedforward(1000.0, 0.0, 0.01, **LEARNT, reaches=[1e-3], rate=5.0).run_uncompiled()
    controller.step(0.1, 0.1, next_reference=0.11)
    before, features = controller.state.weights.copy(), controller.state.features.copy()
    controller.step(0.11, 0.108, next_reference=0.12)
    scale = np.array([20.0, 100.0, 50.0, 50.0])  # inertia, share of the gain, gain times Vs
    step = (1.0 - math.exp(-0.05)) * scale**2 * features * 1000.0 * 0.002 / np.sum((scale * features) ** 2)
    assert controller.state.weights - before == pytest.approx(step, rel=1e-9)
    controller.state = controller.state._replace(enabled=False)
    held = controller.state.weights.copy()
    controller.step(0.12, 0.1, next_reference=0.13)
    assert np.array_equal(controller.state.weights, held)


def test_bristles_follow_their_differential_equation():
    def slope(t, y):
        return [1e5 * (0.03 + 0.002) - 1e5 * 0.03 / 80.0 * y[0]]

    exact = solve_ivp(slope, (0.0, 0.01), [-30.0], rtol=1e-11, atol=1e-11).y[0, -1]
    assert bent(-30.0, 80.0, 1e5, 0.03, 0.002, 0.01) == pytest.approx(exact, rel=1e-8)
    assert bent(-30.0, 80.0, 1e5, 0.0, 0.002, 0.01) == pytest.approx(-28.0, rel=1e-12)
    assert bent(-30.0, 80.0, 1e9, 0.03, 0.0, 0.01) == pytest.approx(80.0, rel=1e-12)


PERIOD = 0.01


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_inverse_is_that_of_tomizuka_for_a_plan_of_third_order(delay):
    """``J/(2 T^2) (1 - z^-1)^2 (1 + z) q_ref(k+1+d)``, with nothing continued."""

    def position(k):
        time = PERIOD * k
        return 0.3 + 0.2 * time - 0.5 * time**2 + 4.0 * time**3

    def velocity(k):
        time = PERIOD * k
        return 0.2 - time + 12.0 * time**2

    def seconds(k):
        return sum(position(one) - 2.0 * position(one - 1) + position(one - 2) for one in (k + 1, k + 2))

    k = 7
    expected = 20.0 / (2.0 * PERIOD**2) * seconds(k + delay)
    found = zero_phase_torque(20.0, velocity(k - 1), velocity(k), velocity(k + 1), PERIOD, float(delay))
    assert found == pytest.approx(expected, rel=1e-9)
    assert (seconds(k) == seconds(k + delay)) is (delay == 0)


def test_inverse_times_the_joint_has_no_phase_at_low_frequency():
    """Of the joint from held torque to position, behind a delay of two periods."""
    delay, frequency = 2, 1.0
    phase = 2.0 * math.pi * frequency * PERIOD
    shift = np.exp(1j * phase)  # z
    plan = {k: np.exp(1j * phase * k) for k in (-1, 0, 1)}
    torque = zero_phase_torque(20.0, plan[-1], plan[0], plan[1], PERIOD, float(delay))
    velocity = torque * PERIOD / 20.0 / (shift - 1.0) * shift**-delay
    assert velocity == pytest.approx(1.0, abs=0.02)
    assert abs(np.angle(velocity)) < 2e-3
