"""A joint in other units of torque and angle moves alike: but for a few bounds, the second is all that is given."""

import math

import numpy as np
import pytest

from adaptive_ff import AdaptiveController
from controllers import pi_gains

PERIOD = 0.002
INERTIA, COULOMB, STICTION, VISCOUS, STRIBECK_VELOCITY = 0.5, 2.0, 2.5, 0.2, 0.1
PEAK = 1.0  # rad/s


def torques(torque_unit, angle_unit, count=3000):
    """Torques, N m, of a joint with a load of 1.5 N m in a loop whose controller has other units.

    The measurement is lost for 0.3 s now and then, and an outer loop corrects the plan.
    """
    speed_unit = angle_unit  # a second is a second
    inertia = INERTIA * torque_unit / angle_unit
    controller = AdaptiveController(
        *pi_gains(inertia, 20.0),
        PERIOD,
        inertia=inertia,
        stribeck_velocity=STRIBECK_VELOCITY * speed_unit,
        torque_limit=20.0 * torque_unit,
    )
    noise = np.random.default_rng(1).normal(0.0, 0.002, count)
    times = PERIOD * np.arange(count + 1)
    plan = PEAK * (np.sin(2.0 * times) + 0.4 * np.sin(5.1 * times))
    velocity, error, found = 0.0, 0.0, []
    for k in range(count):
        measured = math.nan if k % 1000 > 850 else (velocity + noise[k]) * speed_unit
        torque = controller.step(
            float(plan[k]) * speed_unit,
            measured,
            next_reference=float(plan[k + 1]) * speed_unit,
            correction=5.0 * error * speed_unit,
        )
        found.append(torque / torque_unit)
        velocity = moved(velocity, found[-1] - 1.5)
        error += PERIOD * (plan[k] - velocity)
    return np.array(found)


def moved(velocity, torque):
    """Velocity after a period, rad/s, by Euler's rule in steps of a quarter."""
    for _ in range(4):
        friction = COULOMB + (STICTION - COULOMB) * math.exp(-abs(velocity) / STRIBECK_VELOCITY)
        net = torque - VISCOUS * velocity
        if velocity == 0.0 and abs(net) <= friction:
            return 0.0
        after = velocity + 0.25 * PERIOD / INERTIA * (net - math.copysign(friction, velocity or net))
        velocity = 0.0 if after * velocity < 0.0 else after
    return velocity


@pytest.fixture(scope="module")
def expected():
    return torques(1.0, 1.0)


@pytest.mark.parametrize(
    ("torque_unit", "angle_unit"),
    [
        pytest.param(2.0**-30, 1.0, id="5e-10 kg m^2"),
        pytest.param(2.0**20, 1.0, id="5e5 kg m^2"),
        pytest.param(1.0, 2.0**10, id="a spindle"),
        pytest.param(1.0, 2.0**-17, id="rates of a telescope"),
    ],
)
def test_a_joint_in_other_units_moves_alike(torque_unit, angle_unit, expected):
    """In units that are powers of two, whose arithmetic is exact but for bounds that stand for rounding."""
    np.testing.assert_allclose(torques(torque_unit, angle_unit), expected, rtol=0.0, atol=1e-3)
