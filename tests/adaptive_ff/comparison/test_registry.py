"""Controllers that the registry makes of a scenario: fixed feedforwards, observers, limits of the loop."""

import math

import numpy as np
import pytest
from closed_loops import SCENARIO

from adaptive_ff import load_scenario, simulate
from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.comparison import fixed_models
from adaptive_ff.comparison.fixed_models import SPREAD, fixed_model, nominal_source
from adaptive_ff.comparison.own_bandwidth import TUNING_SEEDS
from adaptive_ff.comparison.registry import CONTROLLERS, FIXED, balance, suitable_lag
from adaptive_ff.comparison.run import frictionless, noise_floor
from adaptive_ff.friction.model import model_friction
from adaptive_ff.scenario.truth import true_model
from adaptive_ff.simulation.metrics import rms
from controllers import DisturbanceObserver, ExtendedState, KalmanDisturbance

TRUTH = true_model(SCENARIO)
FAST = SCENARIO.modified(sampling={"period": 0.001})


def model(form, source, scenario=SCENARIO):
    return fixed_model(scenario, true_model(scenario), form, source)


def test_every_form_comes_from_every_source_and_the_oracle_is_the_true_lagged_one():
    forms, sources = ("coulomb", "stribeck", "lagged"), ("nominal", "stale", "batch", "true")
    names = {f"{form}_{source}" for form in forms for source in sources}
    assert set(FIXED) == names - {"lagged_true"}
    assert set(FIXED) <= set(CONTROLLERS)
    assert model("lagged", "true") == TRUTH == CONTROLLERS["oracle"](SCENARIO).parameters.model


@pytest.mark.parametrize("scenario", [SCENARIO, FAST], ids=["100 Hz", "1 kHz"])
def test_on_a_joint_with_lag_the_form_that_has_it_is_by_far_the_best(scenario):
    """And the Stribeck curve without lag is worse than a flat one: it jumps further where friction only follows."""
    errors, loop = {}, (*scenario.feedback.gains, scenario.sampling.period)
    for form in ("coulomb", "stribeck", "lagged"):
        run = simulate(scenario, ModelBased(*loop, model(form, "true", scenario)))
        errors[form] = run.metrics.rms_error_settled
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
    light, assumed = {"inertia": 4.0, "viscous": 0.0, "friction_lag": 0.0}, {"stribeck_velocity": 0.01}
    loud = {"velocity_noise": 0.02}
    scenario = SCENARIO.modified(joint=light, sensor=loud, adaptation=assumed, feedback={"inertia": 2.0})
    found = model(form, "batch", scenario)
    assert 2.0 < found.inertia < 8.0
    assert found.stiction >= found.coulomb >= 0.0
    assert min(found.viscous, found.friction_lag) >= 0.0
    assert all(map(math.isfinite, found))


def test_a_calibration_serves_all_forms_of_a_scenario(monkeypatch):
    counted = []
    original = fixed_models.build_setup
    monkeypatch.setattr(fixed_models, "build_setup", lambda scenario: counted.append(1) or original(scenario))
    scenario = SCENARIO.modified(seed=555)
    for form in ("coulomb", "stribeck", "coulomb", "lagged", "lagged"):
        model(form, "batch", scenario)
    assert len(counted) == 1


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


@pytest.mark.parametrize("name", ["disturbance_observer", "extended_state", "kalman_disturbance"])
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


@pytest.mark.parametrize(
    "name", ["asymmetric", "lugre", "elastic", "gravity_100", "load_step_80", "warm_up", "backlash"]
)
def test_joint_of_the_floor_has_no_friction_load_or_gravity_and_the_same_loop(name):
    scenario = load_scenario(name)
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
    scenario = SCENARIO.modified(duration=60.0)
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
    lag = suitable_lag(SCENARIO.modified(duration=16.0))
    assert 0.001 < lag < 0.008  # what is best at 100 Hz is some 23 ms for a true 20 ms
    plain, tuned = [], []
    for seed in (1, 2, 3):
        scenario = SCENARIO.modified(duration=16.0, seed=seed)
        plain.append(simulate(scenario, "oracle").metrics.rms_error_settled)
        tuned.append(simulate(scenario, "oracle_tuned").metrics.rms_error_settled)
    assert rms(np.array(tuned)) < 0.98 * rms(np.array(plain))
    assert {1, 2, 3}.isdisjoint(TUNING_SEEDS)
