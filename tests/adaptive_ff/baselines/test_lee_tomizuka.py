"""Friction compensation, disturbance observer and zero-phase inverse against their equations."""

import math

import numpy as np
import pytest

from adaptive_ff.baselines.lee_tomizuka import LeeTomizuka, zero_phase_torque
from adaptive_ff.friction.model import TorqueModel
from plant import Joint, JointModel

PERIOD = 0.01
MODEL = TorqueModel(20.0, 60.0, 60.0, 80.0, 0.0, 0.05, 1.0)


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_inverse_is_that_of_tomizuka_for_a_plan_of_third_order(delay):
    """``J/(2 T^2) (1 - z^-1)^2 (1 + z) q_ref(k+1+d)``, with nothing continued."""

    def position(k):
        time = PERIOD * k
        return 0.3 + 0.2 * time - 0.5 * time**2 + 4.0 * time**3

    def velocity(k):
        time = PERIOD * k
        return 0.2 - time + 12.0 * time**2

    k = 7
    second = [position(k + ahead) - 2.0 * position(k + ahead - 1) + position(k + ahead - 2) for ahead in (1, 2)]
    later = [
        position(k + delay + ahead) - 2.0 * position(k + delay + ahead - 1) + position(k + delay + ahead - 2)
        for ahead in (1, 2)
    ]
    expected = 20.0 / (2.0 * PERIOD**2) * sum(later)
    found = zero_phase_torque(20.0, velocity(k - 1), velocity(k), velocity(k + 1), PERIOD, float(delay))
    assert found == pytest.approx(expected, rel=1e-9)
    assert (sum(second) == sum(later)) is (delay == 0)


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


def test_without_a_delay_the_inverse_is_the_slope_of_the_plan():
    controller = LeeTomizuka(100.0, 0.0, PERIOD, MODEL._replace(coulomb=0.0, stiction=0.0, viscous=0.0), bandwidth=2.0)
    controller.run_uncompiled()
    controller.step(0.1, 0.1, next_reference=0.11)
    assert controller.step(0.11, 0.11, next_reference=0.13, realised_torque=20.0) == pytest.approx(40.0, abs=1e-9)


def disturbances(controller, load, delay):
    """Estimated disturbance at the samples on a joint that slides, with a load from half-way on."""
    fields = {name: getattr(MODEL, name) for name in ("inertia", "coulomb", "stiction", "viscous", "stribeck_velocity")}
    joint, waiting, found = Joint(JointModel(**fields), 0.2), [80.0] * delay, []
    controller.run_uncompiled()
    for k in range(300):
        now, following = (0.2 + 0.1 * math.sin(math.pi * PERIOD * sample) for sample in (k, k + 1))
        waiting.append(controller.step(now, float(joint.state.velocity), next_reference=following))
        joint.step(waiting.pop(0) - (load if k >= 150 else 0.0), PERIOD)
        found.append(controller.disturbance)
    return np.array(found)


@pytest.mark.parametrize("delay", [0, 1])
def test_observer_sees_what_the_compensation_leaves(delay):
    controller = LeeTomizuka(600.0, 0.0, PERIOD, MODEL, bandwidth=3.0, delay=float(delay))
    found = disturbances(controller, 30.0, delay)
    assert np.max(np.abs(found[50:150])) < 2.0  # of 90 N m of friction
    assert found[-1] == pytest.approx(30.0, abs=1.5)
