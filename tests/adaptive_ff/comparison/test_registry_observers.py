"""The settings of the baselines with an observer."""

import math

import pytest
from closed_loops import SCENARIO

from adaptive_ff.comparison.registry import CONTROLLERS, balance
from controllers import DisturbanceObserver, ExtendedState, KalmanDisturbance

NAMES = ["disturbance_observer", "extended_state", "kalman_disturbance"]
FAST = SCENARIO.modified(sampling={"period": 0.001})

observing = pytest.mark.parametrize("name", NAMES)


def reached(controller, scenario):
    """Margins of a controller as it was made."""
    inertia, period, block = scenario.feedback.inertia, scenario.sampling.period, controller.parameters
    gains = (block.feedback.proportional, block.feedback.integral)
    if isinstance(controller, ExtendedState):
        return ExtendedState.design(inertia, period, gains[0], block.pole / (2.0 * math.pi))
    if isinstance(controller, DisturbanceObserver):
        return DisturbanceObserver.design(inertia, period, *gains, block.pole / (2.0 * math.pi))
    # bandwidth from the gains of a Kalman filter: q/(1 - l1) = (w0 Ts)^4 for a walk of the disturbance
    angle = (block.disturbance_gain * period / inertia) ** 0.5 / (1.0 - block.velocity_gain) ** 0.25
    return KalmanDisturbance.design(inertia, period, *gains, angle / (2.0 * math.pi * period))


@observing
@pytest.mark.parametrize("period", [0.01, 0.001])
@pytest.mark.parametrize("noise", [0.0, 0.0005, 0.005])
@pytest.mark.parametrize("inertia", [16.0, 24.0])
def test_maximum_sensitivity_stays_within_2(name, period, noise, inertia):
    loop = {"sampling": {"period": period}, "feedback": {"inertia": inertia}}
    scenario = SCENARIO.modified(sensor={"velocity_noise": noise}, **loop)
    found = reached(CONTROLLERS[name](scenario), scenario)
    assert found.maximum_sensitivity <= 2.0 * (1.0 + 1e-6)
    if noise == 0.0:
        assert found.maximum_sensitivity == pytest.approx(2.0, rel=1e-4) or found.bandwidth * period > 0.499


def test_balance_is_the_bandwidth_of_the_kalman_filter_of_the_stated_walk():
    (proportional, _), vs = FAST.feedback.gains, FAST.adaptation.stribeck_velocity
    walk = KalmanDisturbance.walk(20.0, 0.001, 0.002, balance(FAST))
    assert walk == pytest.approx(proportional * vs, rel=1e-12)
    assert balance(FAST.modified(sensor={"velocity_noise": 0.0})) == math.inf
    assumed = CONTROLLERS["kalman_disturbance"](FAST, multiple=1.0)
    expected = KalmanDisturbance.gains(20.0, 0.001, 0.002, proportional * vs)
    assert assumed.parameters[2:4] == pytest.approx(expected, rel=1e-9)
    observing = CONTROLLERS["disturbance_observer"](FAST, multiple=1.0)
    assert observing.parameters.pole == pytest.approx(2.0 * math.pi * balance(FAST))
