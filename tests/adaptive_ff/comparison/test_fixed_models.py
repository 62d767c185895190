"""Fixed feedforwards: what each form and source tells, and what it is worth."""

import math

import numpy as np
import pytest
from closed_loops import SCENARIO

from adaptive_ff import simulate
from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.comparison.fixed_models import SPREAD, fixed_model, nominal_source
from adaptive_ff.comparison.registry import CONTROLLERS, FIXED
from adaptive_ff.friction.model import model_friction
from adaptive_ff.scenario.truth import true_model

TRUTH = true_model(SCENARIO)
FAST = SCENARIO.modified(sampling={"period": 0.001})


def model(form, source, scenario=SCENARIO):
    return fixed_model(scenario, true_model(scenario), form, source)


def error_with(scenario, assumed):
    loop = ModelBased(*scenario.feedback.gains, scenario.sampling.period, assumed)
    return simulate(scenario, loop).metrics.rms_error_settled


def test_every_form_comes_from_every_source_and_the_oracle_is_the_true_lagged_one():
    forms, sources = ("coulomb", "stribeck", "lagged"), ("nominal", "stale", "batch", "true")
    names = {f"{form}_{source}" for form in forms for source in sources}
    assert set(FIXED) == names - {"lagged_true"}
    assert set(FIXED) <= set(CONTROLLERS)
    assert model("lagged", "true") == TRUTH == CONTROLLERS["oracle"](SCENARIO).parameters.model


@pytest.mark.parametrize("scenario", [SCENARIO, FAST], ids=["100 Hz", "1 kHz"])
def test_on_a_joint_with_lag_the_form_that_has_it_is_by_far_the_best(scenario):
    """And the Stribeck curve without lag is worse than a flat one: it jumps further where friction only follows."""
    errors = {form: error_with(scenario, model(form, "true", scenario)) for form in ("coulomb", "stribeck", "lagged")}
    assert errors["lagged"] < 0.4 * errors["coulomb"] < 0.4 * errors["stribeck"]


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


def test_a_calibration_serves_all_forms_of_a_scenario(monkeypatch):
    from adaptive_ff.comparison import fixed_models

    counted = []
    original = fixed_models.build_setup
    monkeypatch.setattr(fixed_models, "build_setup", lambda scenario: counted.append(1) or original(scenario))
    scenario = SCENARIO.modified(seed=555)
    for form in ("coulomb", "stribeck", "coulomb", "lagged", "lagged"):
        model(form, "batch", scenario)
    assert len(counted) == 1
