"""The baselines from the literature against their own equations, and on motions that they were made for."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from adaptive_ff import load_scenario
from adaptive_ff.baselines.feedback_learning import FIRST, LearntFeedforward
from adaptive_ff.baselines.lugre_observer import LuGreObserver, bent
from adaptive_ff.baselines.repetitive import Repetitive
from adaptive_ff.comparison.registry import cycle_of
from adaptive_ff.friction.model import TorqueModel
from controllers import PI
from plant import Joint, JointModel, MaxwellJoint

GAINS = (1256.0, 15_000.0)
LEARNT = {"inertia": 20.0, "stribeck_velocity": 0.05}
FRICTION = {"inertia": 20.0, "coulomb": 60.0, "stiction": 60.0, "viscous": 80.0, "stribeck_velocity": 0.05}
MODEL = TorqueModel(20.0, 60.0, 90.0, 80.0, 0.0, 0.05, 1.0)


def plan(seconds, period=0.01):
    """A motion with a period of 2 s, known one sample ahead."""
    time = period * np.arange(round(seconds / period) + 1)
    return 0.2 * np.sin(math.pi * time) + 0.1 * np.sin(3.0 * math.pi * time)


def errors(controller, joint, reference, period=0.01):
    """Tracking error at the samples, in plain Python."""
    controller.run_uncompiled()
    moving, found = Joint(joint), []
    for now, following in zip(reference[:-1].tolist(), reference[1:].tolist(), strict=True):
        velocity = float(moving.state.velocity)
        found.append(now - velocity)
        moving.step(controller.step(now, velocity, next_reference=following), period)
    return np.array(found)


def rms(values):
    return math.sqrt(np.mean(values**2))


def test_elements_are_stop_operators_of_the_planned_way():
    controller = LearntFeedforward(*GAINS, 0.01, **LEARNT, reaches=[1e-3, 5e-3]).run_uncompiled()
    reference, loads, way = plan(1.5), np.zeros(2), np.array([1e-3, 5e-3])
    for now, following in zip(reference[:-1].tolist(), reference[1:].tolist(), strict=True):
        controller.step(now, now, next_reference=following)
        loads = np.clip(loads + 0.005 * (now + following) / way, -1.0, 1.0)
        assert controller.state.features[FIRST:] == pytest.approx(loads, abs=1e-12)
    assert np.ptp(reference) > 0.3


def test_bells_stand_over_the_planned_velocity_and_follow_with_their_lag():
    centres = [-2.0, -0.5, 0.5, 2.0]
    controller = LearntFeedforward(*GAINS, 0.01, **LEARNT, centres=centres, lag=0.02).run_uncompiled()
    for _ in range(3):
        controller.step(0.06, 0.06, next_reference=0.06)
    places = np.arcsinh(centres)
    bells = np.exp(-0.5 * ((math.asinh(0.06 / 0.05) - places) / np.mean(np.diff(places))) ** 2)
    assert controller.state.features[FIRST:] == pytest.approx(bells * (1.0 - math.exp(-1.5)), rel=1e-12)


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


def test_adaptive_maxwell_slip_compensates_the_joint_that_it_describes():
    joint = MaxwellJoint(**FRICTION, displacements=[5e-4, 1e-3, 2e-3, 4e-3])
    reference = plan(12.0)
    learnt = LearntFeedforward(*GAINS, 0.01, **LEARNT, reaches=[5e-4, 1e-3, 2e-3, 4e-3], rate=20.0)
    assert rms(errors(learnt, joint, reference)[800:]) < 0.2 * rms(errors(PI(*GAINS, 0.01), joint, reference)[800:])


def test_bristles_follow_their_differential_equation():
    def slope(t, y):
        return [1e5 * (0.03 + 0.002) - 1e5 * 0.03 / 80.0 * y[0]]

    exact = solve_ivp(slope, (0.0, 0.01), [-30.0], rtol=1e-11, atol=1e-11).y[0, -1]
    assert bent(-30.0, 80.0, 1e5, 0.03, 0.002, 0.01) == pytest.approx(exact, rel=1e-8)
    assert bent(-30.0, 80.0, 1e5, 0.0, 0.002, 0.01) == pytest.approx(-28.0, rel=1e-12)
    assert bent(-30.0, 80.0, 1e9, 0.03, 0.0, 0.01) == pytest.approx(80.0, rel=1e-12)


def test_lugre_observer_feeds_the_friction_curve_forward_at_constant_speed():
    controller = LuGreObserver(*GAINS, 0.01, MODEL, stiffness=1e5).run_uncompiled()
    for velocity in (0.1, -0.02):
        for _ in range(200):
            torque = controller.step(velocity, velocity, next_reference=velocity)
        curve = 60.0 + 30.0 * math.exp(-abs(velocity) / 0.05) + 80.0 * abs(velocity)
        assert torque == pytest.approx(math.copysign(curve, velocity), rel=1e-6)


def test_gain_of_the_lugre_observer_bends_the_bristles_against_the_error():
    corrected = LuGreObserver(*GAINS, 0.01, MODEL, stiffness=1e5, gain=0.5).run_uncompiled()
    plain = LuGreObserver(*GAINS, 0.01, MODEL, stiffness=1e5).run_uncompiled()
    for controller in (corrected, plain):
        controller.step(1e-3, 0.0, next_reference=1e-3)
    assert corrected.state.bristles > plain.state.bristles > 0.0


def test_memory_learns_the_smoothed_feedback_a_lead_earlier():
    controller = Repetitive(100.0, 0.0, 0.01, inertia=20.0, cycle=10, lead=2, gain=0.5).run_uncompiled()
    asked = []
    for k in range(10):
        error = 0.01 * math.sin(k)
        controller.step(0.0, -error, next_reference=0.0)
        asked.append(100.0 * error)
    expected = np.zeros(10)
    for k in range(2, 10):
        expected[(k - 3) % 10] += 0.5 * 0.25 * (asked[k] + 2.0 * asked[k - 1] + asked[k - 2])
    assert controller.state.memory == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_periodic_motion_is_learnt_from_period_to_period():
    joint, reference = JointModel(**FRICTION, friction_lag=0.02), plan(16.0)
    found = errors(Repetitive(*GAINS, 0.01, inertia=20.0, cycle=200, lead=1, gain=0.5), joint, reference)
    first, last = rms(found[:200]), rms(found[-200:])
    assert last < 0.1 * first
    without = errors(Repetitive(*GAINS, 0.01, inertia=20.0, cycle=0, lead=0), joint, reference)
    assert rms(without[-200:]) > 0.5 * first


def test_period_of_a_motion_is_that_of_its_frequencies():
    scenario = load_scenario()
    assert cycle_of(scenario) == 0  # 100 s in a run of 60 s
    periodic = scenario.modified(reference={"frequencies": [0.5, 0.75], "amplitudes": [1.0, 1.0]})
    assert cycle_of(periodic) == 400


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: LearntFeedforward(*GAINS, 0.01, **LEARNT, reaches=[1e-3, 1e-3]), "reaches"),
        (lambda: LearntFeedforward(*GAINS, 0.01, **LEARNT, centres=[1.0]), "two at least"),
        (
            lambda: Repetitive(*GAINS, 0.01, inertia=20.0, cycle=5, lead=5),
            "lead = 5 is not allowed: it must be less than the cycle, 5",
        ),
        (lambda: Repetitive(*GAINS, 0.01, inertia=20.0, cycle=5, gain=2.0), "gain = 2.0 is not allowed"),
    ],
)
def test_wrong_setting_is_refused_and_named(make, message):
    with pytest.raises(ValueError, match=message):
        make()
