"""What holds of every controller of the registry, whatever its law."""

import math

import numpy as np
import pytest
from closed_loops import LEARNING, NAMES, SAMPLE, SCENARIO, make
from scenario_files import in_other_units

from adaptive_ff import parse_scenario
from adaptive_ff.comparison.run import simulate

SHORT = SCENARIO.modified(duration=10.0, adaptation={"memory": 20.0})
SMOOTH = dict.fromkeys(("coulomb", "stiction", "viscous", "friction_lag"), 0.0)
FRICTIONLESS = SCENARIO.modified(duration=10.0, joint=SMOOTH, sensor={"velocity_noise": 0.0})
"""Nothing to compensate: the inertia is the one that is assumed, and there is no noise to learn from."""

SCALES = {"torque": (4.0, 1.0, 1.0), "time": (1.0, 4.0, 1.0), "angle": (1.0, 1.0, 4.0)}

FADES = "friction that is held at rest fades with a time constant in seconds"
WALKS = "the balance of its observer takes a torque for a torque in a root of a second"
IDENTITY = "its first covariance is a multiple of the identity in SI units, as in the paper"
WEIGHS = "a weight acts along the sine of an angle in rad"
HIDDEN = {
    **{("time", name): FADES for name in ("adaptive", "adaptive_unsupervised", "coulomb_nominal", "fixed", "oracle")},
    **{("time", name): WALKS for name in ("friction_observer", "observed_nominal")},
    **{(unit, "adaptive_paper"): IDENTITY for unit in SCALES},
    **{("angle", name): WEIGHS for name in ("adaptive", "adaptive_unsupervised")},
}
"""Constants with a unit that are known; what no longer has one has to leave this list."""

NOT_PI = {
    "pi": "it has no torque of the inertia",
    "fixed": "its model is given",
    "lugre_observer": "it refuses a joint without friction",
    "lugre_gradient": "its bristles keep the friction that it begins with",
    "adaptive_paper": "without friction and noise its regressors are collinear",
}


def cases(reasons, *units):
    """Parameters of a test: name by unit, the known failures marked, controllers beyond the sample nightly."""
    found = []
    for name in NAMES:
        for unit in units or ("",):
            marks = [] if name in SAMPLE else [pytest.mark.nightly]
            reason = reasons.get((unit, name) if unit else name)
            marks += [pytest.mark.xfail(reason=reason, strict=True)] if reason else []
            found.append(pytest.param(*((name, unit) if unit else (name,)), marks=marks))
    return found


@pytest.mark.parametrize(("name", "unit"), cases(HIDDEN, *SCALES))
def test_torque_is_the_same_in_other_units(name, unit):
    """Of the whole loop: a constant with a hidden unit, in joint, drive, sensor or controller, does not pass.

    With a scale that is a power of two there is no rounding that could be amplified.
    """
    scales = torque, time, angle = SCALES[unit]
    content = {key: value for key, value in SHORT.model_dump(exclude={"sweep"}).items() if value is not None}
    other = parse_scenario(in_other_units(content, scales), "other units")
    expected, found = simulate(SHORT, name), simulate(other, name)
    assert np.ptp(expected.torque) > 100.0
    assert found.torque / torque == pytest.approx(expected.torque, abs=1e-9 * np.ptp(expected.torque))
    assert found.metrics.rms_error * time / angle == pytest.approx(expected.metrics.rms_error, rel=1e-9)


@pytest.mark.parametrize("name", cases(NOT_PI))
def test_without_friction_it_is_pi_with_the_torque_of_the_inertia(name):
    expected, found = simulate(FRICTIONLESS, "pi_inertia"), simulate(FRICTIONLESS, name)
    assert np.ptp(expected.torque) > 10.0
    assert found.torque == pytest.approx(expected.torque, abs=1e-9 * np.ptp(expected.torque))


def test_feedforward_of_a_model_without_anything_is_pi():
    nothing = dict.fromkeys(("inertia", "coulomb", "stiction", "viscous", "friction_lag"), 0.0)
    scenario = SHORT.modified(fixed=nothing)
    assert np.array_equal(simulate(scenario, "fixed").torque, simulate(scenario, "pi").torque)


def torques(controller, inertia):
    """Torques along a motion with reversals that the joint follows late, less the torque of an inertia."""
    found = [0.0]
    for k in range(300):
        now, following = (0.3 * math.sin(0.06 * sample) for sample in (k, k + 1))
        velocity = 0.28 * math.sin(0.06 * k - 0.1) + 0.01 * math.sin(1.7 * k)
        known = -inertia * (following - now) / controller.period
        torque = controller.step(now, velocity, next_reference=following, feedforward=known, realised_torque=found[-1])
        found.append(torque)
    return np.array(found)


KEEP = ("adaptive", "lugre_gradient")
"""What observes a disturbance all the same, and what begins with bristles."""


@pytest.mark.parametrize("name", [name for name in LEARNING if name not in KEEP])
def test_what_has_learnt_nothing_is_pi_with_the_torque_of_the_inertia(name):
    controller = make(name).run_uncompiled()
    controller.enabled = False
    expected = torques(make("pi").run_uncompiled(), 0.0)
    assert np.ptp(expected) > 50.0
    assert torques(controller, SCENARIO.feedback.inertia) == pytest.approx(expected, abs=1e-9)
