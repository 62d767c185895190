"""Noise floor and tuned oracle: where the limits of a loop are."""

import numpy as np
import pytest

from adaptive_ff import load_scenario, simulate
from adaptive_ff.comparison.own_bandwidth import TUNING_SEEDS
from adaptive_ff.comparison.registry import suitable_lag
from adaptive_ff.comparison.run import frictionless, noise_floor
from adaptive_ff.scenario.library import SCENARIOS
from adaptive_ff.simulation.metrics import rms

SHORT = load_scenario().modified(duration=16.0)


@pytest.mark.parametrize(
    "name", ["asymmetric", "lugre", "elastic", "gravity_100", "load_step_80", "warm_up", "backlash"]
)
def test_joint_of_the_floor_has_no_friction_load_or_gravity_and_the_same_loop(name):
    scenario = load_scenario(SCENARIOS / f"{name}.toml")
    plain = frictionless(scenario)
    for curve in (plain.joint.friction, plain.joint.friction_backward):
        assert curve[:3] == (0.0, 0.0, 0.0)
    assert (plain.joint.offset, plain.joint.gravity, plain.joint.inertia) == (0.0, 0.0, scenario.joint.inertia)
    assert all(change.load == 0.0 and change.friction_scale == 1.0 for change in plain.change)
    assert not plain.plan.varies
    assert plain.last_change == scenario.last_change
    for same in ("feedback", "sensor", "actuator", "sampling", "reference", "seed"):
        assert getattr(plain, same) == getattr(scenario, same)


def test_floor_is_the_noise_of_the_closed_loop_with_an_inertia():
    """The error that white noise makes in PI around an inertia, computed from its impulse response."""
    scenario = load_scenario().modified(duration=60.0)
    run = noise_floor(scenario)
    proportional, integral = scenario.feedback.gains
    step, velocity, integrated, impulse = 0.01 / 20.0, 0.0, 0.0, []
    for k in range(2000):
        error = -velocity - (1.0 if k == 0 else 0.0)
        integrated += integral * 0.01 * error  # backward Euler, as PI says
        torque = proportional * error + integrated
        velocity += step * torque
        impulse.append(velocity)
    expected = 0.002 * float(np.sqrt(np.sum(np.square(impulse))))
    samples = scenario.sample_steps[:-1]
    assert rms((run.reference - run.velocity)[samples]) == pytest.approx(expected, rel=0.05)


def test_tuned_oracle_is_better_than_the_oracle_on_seeds_that_it_does_not_know():
    lag = suitable_lag(SHORT)
    assert 0.001 < lag < 0.008  # what is best at 100 Hz is some 23 ms for a true 20 ms
    plain, tuned = [], []
    for seed in (1, 2, 3):
        scenario = SHORT.modified(seed=seed)
        plain.append(simulate(scenario, "oracle").metrics.rms_error_settled)
        tuned.append(simulate(scenario, "oracle_tuned").metrics.rms_error_settled)
    assert rms(np.array(tuned)) < 0.98 * rms(np.array(plain))
    assert {1, 2, 3}.isdisjoint(TUNING_SEEDS)
