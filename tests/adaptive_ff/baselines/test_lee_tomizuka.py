"""Friction compensation, disturbance observer and zero-phase inverse against their equations."""

import math

import numpy as np
import pytest

from adaptive_ff.baselines.lee_tomizuka import zero_phase_torque

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
