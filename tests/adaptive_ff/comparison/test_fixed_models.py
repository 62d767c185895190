"""Fixed feedforwards: what each form and source tells, and what it is worth."""

import math

import numpy as np
import pytest
from closed_loops import SCENARIO

from adaptive_ff import InputError, simulate
from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.comparison.fixed_models import SPREAD, fixed_model, nominal_source
from adaptive_ff.comparison.registry import CONTROLLERS, FIXED
from adaptive_ff.friction.model import model_friction
from adaptive_ff.scenario.truth import true_model

TRUTH = true_model(SCENARIO)
FAST = SCENARIO.modified(sampling={"period": 0.001})
ESTIMATED = ("inertia", "coulomb", "stiction", "viscous")


def model(form, source, scenario=SCENARIO):
    return fixed_model(scenario, true_model(scenario), form, source)


def error_with(scenario, assumed):
    loop = ModelBased(*scenario.feedback.gains, scenario.sampling.period, assumed)
    return simulate(scenario, loop).metrics.rms_error_settled


def test_every_form_comes_from_every_source_and_the_oracle_is_the_true_lagged_one():
    names = {
        f"{form}_{source}"
        for form in ("coulomb", "stribeck", "lagged")
        for source in ("nominal", "stale", "batch", "true")
    }
    assert set(FIXED) == names - {"lagged_true"}
    assert set(FIXED) <= set(CONTROLLERS)
    assert model("lagged", "true") == TRUTH == CONTROLLERS["oracle"](SCENARIO).parameters.model


@pytest.mark.parametrize("name", sorted(FIXED))
def test_every_fixed_feedforward_runs(name):
    controller = CONTROLLERS[name](SCENARIO)
    assumed = controller.parameters.model
    lagged = name.startswith("lagged")
    assert (assumed.friction_lag > 0.0) == lagged
    assert (assumed.stiction == assumed.coulomb) == name.startswith("coulomb")
    run = simulate(SCENARIO.modified(duration=4.0), controller)
    assert np.ptp(run.feedforward) > 50.0


@pytest.mark.parametrize("scenario", [SCENARIO, FAST], ids=["100 Hz", "1 kHz"])
def test_on_a_joint_with_lag_the_form_that_has_it_is_by_far_the_best(scenario):
    """And the Stribeck curve without lag is worse than a flat one: it jumps further where friction only follows."""
    errors = {form: error_with(scenario, model(form, "true", scenario)) for form in ("coulomb", "stribeck", "lagged")}
    assert errors["lagged"] < 0.4 * errors["coulomb"] < 0.4 * errors["stribeck"]


def test_on_a_joint_without_lag_each_part_of_the_model_pays():
    scenario = FAST.modified(joint={"friction_lag": 0.0})
    errors = {form: error_with(scenario, model(form, "true", scenario)) for form in ("coulomb", "stribeck", "lagged")}
    assert errors["lagged"] == errors["stribeck"] < 0.5 * errors["coulomb"]


def test_the_coulomb_viscous_form_is_the_least_squares_line_through_the_curve():
    """Oracle: numpy's least squares over every moment of the motion."""
    scenario = SCENARIO.modified(reference={"peak": 1.5})
    reference = scenario.reference_velocity()
    speeds = np.abs(reference[reference != 0.0])[::7]
    friction = [model_friction(TRUTH, speed) for speed in speeds]
    line = np.column_stack([np.ones_like(speeds), speeds])
    coulomb, viscous = np.linalg.lstsq(line, friction, rcond=None)[0]
    found = model("coulomb", "true", scenario)
    assert (found.coulomb, found.viscous) == pytest.approx((coulomb, viscous), rel=0.01)
    assert found.inertia == TRUTH.inertia


def test_the_viscous_coefficient_is_not_negative_and_a_joint_that_stands_has_a_form():
    slow = SCENARIO.modified(reference={"peak": 0.05})
    assert model("coulomb", "true", slow).viscous == 0.0
    still = SCENARIO.modified(reference={"amplitudes": [1e-300] * 7, "peak": 1e-300})
    assert all(math.isfinite(value) for value in model("coulomb", "true", still))


def test_nominal_parameters_are_off_by_a_factor_of_their_own_that_the_seed_draws():
    assumed = SCENARIO.modified(adaptation={"stribeck_velocity": 0.07}, feedback={"inertia": 15.0})
    drawn = [nominal_source(assumed.model_copy(update={"seed": seed}), TRUTH) for seed in range(400)]
    names = ("coulomb", "stiction", "viscous", "friction_lag")
    factors = np.log([[getattr(row, name) / getattr(TRUTH, name) for name in names] for row in drawn])
    limit = math.log(SPREAD)
    assert np.max(np.abs(factors)) <= limit * (1.0 + 1e-12)
    free = factors[:, [0, 2, 3]]  # stiction is at least Coulomb friction
    assert np.mean(free, axis=0) == pytest.approx(0.0, abs=4.0 * limit / math.sqrt(3.0 * 400))
    assert np.std(free, axis=0) == pytest.approx(limit / math.sqrt(3.0), rel=0.1)
    assert np.max(np.abs(np.corrcoef(factors.T) - np.eye(4))) < 0.2
    assert all((row.inertia, row.stribeck_velocity) == (15.0, 0.07) for row in drawn)
    assert all(row.stiction >= row.coulomb for row in drawn)


def test_a_stale_model_is_exact_where_friction_is_what_it_was():
    scenario = SCENARIO.modified(joint={"coulomb": 78.0, "stiction": 117.0, "viscous": 104.0})
    assert model("lagged", "stale") == pytest.approx(true_model(scenario), rel=1e-12)


@pytest.mark.parametrize("noise", [0.002, 0.0])
def test_batch_identification_finds_the_joint(noise):
    found = model("lagged", "batch", FAST.modified(seed=101, sensor={"velocity_noise": noise}))
    for name in ESTIMATED:
        assert getattr(found, name) == pytest.approx(getattr(TRUTH, name), rel=0.05), name
    assert found.friction_lag == pytest.approx(TRUTH.friction_lag, rel=0.15)


def test_changes_of_friction_are_not_in_the_calibration_run_and_the_seed_is():
    changed = SCENARIO.modified(change=[{"time": 1.0, "friction_scale": 0.5}])
    assert model("stribeck", "batch", changed) == model("stribeck", "batch")
    assert model("stribeck", "batch", SCENARIO.modified(seed=2)) != model("stribeck", "batch")


@pytest.mark.parametrize("form", ["coulomb", "stribeck", "lagged"])
def test_what_is_identified_is_possible_even_where_what_is_told_is_wrong(form):
    """A light joint under loud noise, assumed to have half of its inertia and a fifth of its Stribeck velocity."""
    scenario = SCENARIO.modified(
        joint={"inertia": 4.0, "viscous": 0.0, "friction_lag": 0.0},
        sensor={"velocity_noise": 0.02},
        adaptation={"stribeck_velocity": 0.01},
        feedback={"inertia": 2.0},
    )
    found = model(form, "batch", scenario)
    assert 2.0 < found.inertia < 8.0
    assert found.stiction >= found.coulomb >= 0.0
    assert min(found.viscous, found.friction_lag) >= 0.0
    assert all(map(math.isfinite, found))


def test_a_joint_that_does_not_move_cannot_be_identified_and_says_so():
    stuck = SCENARIO.modified(actuator={"torque_limit": 10.0}, sensor={"velocity_noise": 0.0})
    with pytest.raises(InputError, match=r"calibration run: .*move"):
        model("stribeck", "batch", stuck)


def test_a_calibration_serves_all_forms_of_a_scenario(monkeypatch):
    from adaptive_ff.comparison import calibration

    counted = []
    original = calibration.build_setup
    monkeypatch.setattr(calibration, "build_setup", lambda scenario: counted.append(1) or original(scenario))
    scenario = SCENARIO.modified(seed=555)
    for form in ("coulomb", "stribeck", "coulomb", "lagged", "lagged"):
        model(form, "batch", scenario)
    assert len(counted) == 1
