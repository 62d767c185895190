"""From a log to the first model of a controller: values, units, how sure it is, and what it is worth in the loop."""

from dataclasses import replace
from statistics import NormalDist

import numpy as np
import pytest
from synthetic_logs import JOINT, make_log, motion

from adaptive_ff import (
    PER_DIRECTION_WITH_GRAVITY,
    WITH_GRAVITY,
    WITH_OFFSET,
    AdaptiveController,
    InputError,
    TorqueModel,
    identify_log,
    load_scenario,
    simulate,
)
from adaptive_ff.friction.model import model_friction
from adaptive_ff.identify.first_estimate import ASSUMED_LAG
from adaptive_ff.logs.log import Log
from controllers import PI

AMPERE = 0.11
"""Torque constant of the tests, N m/A."""


def with_torque(log, torque):
    return Log("log", log.time, torque, position=log.position)


@pytest.fixture(scope="module")
def found():
    return identify_log(make_log(noise=0.05))


@pytest.fixture(scope="module")
def of_current():
    log = make_log(noise=0.05)
    return identify_log(with_torque(log, log.torque / AMPERE), is_current=True)


def controller_of(first, **further):
    design = PI.design(inertia=first.inertia, period=0.01, bandwidth=5.0)
    return AdaptiveController(design.proportional, design.integral, 0.01, **first._asdict(), **further)


def test_model_has_the_values_of_the_joint():
    model = identify_log(make_log()).torque_model()
    assert isinstance(model, TorqueModel)
    for name, true in JOINT.items():
        assert getattr(model, name) == pytest.approx(true, rel=2e-3)
    assert model.stiction == model.coulomb
    assert model.friction_lag < 1e-3
    largest = np.max(np.abs(motion(make_log().time)[1]))
    assert model.stribeck_velocity == pytest.approx(0.05 * largest, rel=0.05)


def test_deviations_are_those_of_the_intervals(found):
    first = found.first_estimate()
    for name in ("inertia", "coulomb", "viscous", "offset"):
        lower, upper = found.parameters[name].estimate[2:]
        widest = max(upper - first.model[name], first.model[name] - lower)
        assert first.deviation[name] * NormalDist().inv_cdf(0.975) == pytest.approx(widest)
    assert 0.0 < first.deviation["inertia"] < 0.01 * first.inertia
    vague = identify_log(make_log(noise=0.5)).first_estimate().deviation
    assert all(vague[name] > 2.0 * first.deviation[name] for name in ("inertia", "coulomb", "viscous"))


def test_controller_begins_with_what_was_identified(found):
    first = found.first_estimate()
    estimates = controller_of(first).estimates
    assert first.parameters == WITH_GRAVITY
    assert {name: estimates[name] for name in first.parameters} == {n: first.model[n] for n in first.parameters}
    assert estimates["stribeck_velocity"] == first.stribeck_velocity == found.torque_model().stribeck_velocity


def test_gravity_and_its_deviation_go_along():
    log = make_log(noise=0.05)
    found = identify_log(with_torque(log, log.torque + 5.0 * np.sin(log.position) - 2.0 * np.cos(log.position)))
    first = found.first_estimate()
    assert (first.model["gravity_sin"], first.model["gravity_cos"]) == pytest.approx((5.0, -2.0), rel=0.05)
    assert 0.0 < first.deviation["gravity_sin"] < 0.5
    assert controller_of(first).estimates["gravity_cos"] == first.model["gravity_cos"]
    fewer = found.first_estimate(parameters=WITH_OFFSET)
    assert set(fewer.deviation) <= set(WITH_OFFSET)
    assert "gravity_sin" not in fewer.model
    assert "gravity_sin" not in controller_of(fewer).estimates


def test_friction_by_direction_is_identified_by_direction():
    first = identify_log(make_log(noise=0.02, asymmetry=1.0)).first_estimate()
    assert first.parameters == PER_DIRECTION_WITH_GRAVITY
    assert first.model["viscous_asymmetry"] == pytest.approx(1.0, rel=0.1)
    assert controller_of(first).estimates["viscous_asymmetry"] == first.model["viscous_asymmetry"]


def test_friction_that_saturates_is_right_as_a_whole_at_the_speeds_of_the_log():
    log = make_log(noise=0.02)
    velocity = motion(log.time)[1]
    found = identify_log(with_torque(log, log.torque + 4.0 * np.tanh(velocity / 0.5)))
    assert any(found.value(shape) > 0.0 for shape in ("saturation", "slow_saturation", "long_saturation"))
    model, deviation = found.torque_model(), found.first_estimate().deviation
    for speed in (0.3, 0.6, 1.0):
        true = 3.0 + 4.0 * speed + 4.0 * np.tanh(speed / 0.5)
        assert model_friction(model, speed) == pytest.approx(true, rel=0.12)
    assert 0.1 < deviation["coulomb"] < 2.0
    assert 0.1 < deviation["viscous"] < 2.0


def test_current_takes_a_torque_constant(found, of_current):
    with pytest.raises(
        InputError, match=r"^torque_constant is missing: the log of log holds a current, A, .* N m/A, or 1"
    ):
        of_current.torque_model()
    with pytest.raises(InputError, match=r"^torque_constant is missing"):
        of_current.first_estimate()
    assert of_current.torque_model(AMPERE) == pytest.approx(found.torque_model(), rel=1e-6)
    first, same = of_current.first_estimate(AMPERE), found.first_estimate()
    assert first.deviation == pytest.approx(same.deviation, rel=0.02)  # the search ends a little apart
    assert first.model == pytest.approx(same.model, rel=1e-6)
    assert of_current.first_estimate(1.0).inertia == pytest.approx(same.inertia / AMPERE)


@pytest.mark.parametrize("constant", [0.0, -1.0, np.nan, np.inf])
def test_impossible_torque_constant_is_refused(of_current, constant):
    with pytest.raises(InputError, match=r"^torque_constant = .* N m/A is not allowed: it must be positive and finite"):
        of_current.first_estimate(constant)


@pytest.mark.parametrize("constant", ["x", True, [0.11], 1j])
def test_a_torque_constant_that_is_no_number_is_refused(found, of_current, constant):
    for one in (found, of_current):
        with pytest.raises(InputError, match=r"^torque_constant = .* is not allowed: it must be a number of N m/A$"):
            one.torque_model(constant)


@pytest.mark.parametrize("parameters", [("zz",), (), "gravity", 5, WITH_GRAVITY[:-1]])
def test_parameters_that_no_controller_identifies_are_refused(found, parameters):
    with pytest.raises(InputError) as refused:
        found.first_estimate(parameters=parameters)
    assert str(refused.value).startswith(f"parameters = {parameters!r} is not allowed: it must be ('inertia', ")
    with pytest.raises(ValueError, match=r"^parameters = ") as by_controller:
        AdaptiveController(1.0, 1.0, 0.01, inertia=1.0, stribeck_velocity=0.1, parameters=parameters)
    assert str(by_controller.value) == str(refused.value)


def test_torque_needs_no_constant(found):
    with pytest.raises(InputError, match=r"^torque_constant = 0.11 N m/A is not allowed: the log of log holds N m"):
        found.torque_model(AMPERE)


def test_linear_axis_has_no_gravity():
    log = make_log(noise=0.05)
    first = identify_log(log, linear=True).first_estimate()
    assert first.parameters == WITH_OFFSET
    assert controller_of(first).estimates["coulomb"] == pytest.approx(3.0, rel=0.05)
    of_current = identify_log(with_torque(log, log.torque / AMPERE), linear=True, is_current=True)
    with pytest.raises(InputError, match=r"^torque_constant is missing: .* N/A"):
        of_current.first_estimate()
    assert of_current.first_estimate(AMPERE).model == pytest.approx(first.model, rel=1e-6)


def test_without_inertia_there_is_no_model(found):
    inertia = found.parameters["inertia"]._replace(identifiable=False)
    with pytest.raises(InputError, match=r"^log: the inertia is not identifiable, so there is no model"):
        replace(found, parameters={**found.parameters, "inertia": inertia}).torque_model()


def test_a_lag_that_was_not_estimated_is_assumed(found):
    others = {name: one for name, one in found.parameters.items() if name != "friction_lag"}
    first = replace(found, parameters=others).first_estimate()
    assert first.model["friction_lag"] == ASSUMED_LAG
    assert "friction_lag" not in first.deviation


@pytest.mark.parametrize("seed", [1, 101])
def test_without_friction_there_is_no_lag_but_the_assumed_one(seed):
    found = identify_log(make_log(noise=0.05, coulomb=0.0, viscous=0.0, seed=seed))
    first = found.first_estimate()
    assert first.model["friction_lag"] == ASSUMED_LAG
    assert "friction_lag" not in first.deviation
    assert first.model["inertia"] == pytest.approx(JOINT["inertia"], rel=0.01)


@pytest.mark.parametrize("ends", [(-0.01, 0.2), (-0.3, 0.05), (-np.inf, np.inf)])
def test_a_lag_that_the_log_does_not_bound_is_assumed(found, ends):
    reported = found.parameters["friction_lag"]
    vague = reported._replace(estimate=reported.estimate._replace(value=0.04, lower=ends[0], upper=ends[1]))
    first = replace(found, parameters={**found.parameters, "friction_lag": vague}).first_estimate()
    assert first.model["friction_lag"] == ASSUMED_LAG
    assert "friction_lag" not in first.deviation


@pytest.mark.parametrize(
    ("ends", "first"), [((-0.02, 0.006), 0.006), ((-0.02, 0.03), ASSUMED_LAG), ((0.002, 0.03), 0.004)]
)
def test_of_a_lag_that_may_be_zero_the_assumed_one_is_taken_as_far_as_it_may_be(found, ends, first):
    reported = found.parameters["friction_lag"]
    known = reported._replace(estimate=reported.estimate._replace(value=0.004, lower=ends[0], upper=ends[1]))
    assert (
        replace(found, parameters={**found.parameters, "friction_lag": known}).first_estimate().model["friction_lag"]
        == first
    )


@pytest.mark.parametrize("lag", [0.0, 0.02, 0.05])
def test_first_seconds_are_better_than_without_a_model(lag):
    base = load_scenario().modified(joint={"friction_lag": lag})
    columns = simulate(base.modified(duration=60.0, sampling={"period": 0.001}, seed=101), "pi").columns()
    log = Log("run", columns["time"], columns["torque"], velocity=columns["measured"])
    first = identify_log(log, torque_delay=0.0005).first_estimate()
    cold = {name: getattr(first, name) for name in ("inertia", "stribeck_velocity")}
    errors = {name: [] for name in ("cold", "first")}
    for seed in (1, 2, 3):
        scenario = base.modified(duration=2.0, seed=seed)
        for name, arguments in (("cold", cold), ("first", first._asdict())):
            controller = AdaptiveController(*scenario.feedback.gains, 0.01, **arguments)
            run = simulate(scenario, controller)
            errors[name].append(np.sqrt(np.mean((run.reference - run.velocity) ** 2)))
    assert np.median(errors["first"]) < np.median(errors["cold"])


def mapped_log(period=0.4, part=slice(None), **options):
    """A log whose friction is ``1 + 0.3 sin(2 pi q/period)`` times that of the joint, or a part of it."""
    log = make_log(noise=0.02, **options)
    velocity = np.gradient(log.position, log.time)
    friction = JOINT["coulomb"] * np.sign(velocity) + JOINT["viscous"] * velocity
    torque = log.torque + 0.3 * np.sin(2.0 * np.pi / period * log.position) * friction
    return Log("log", log.time[part], torque[part], position=log.position[part])


def test_friction_over_a_period_goes_along_with_its_deviation():
    found = identify_log(mapped_log(), position_periods=(0.4,), held_out=0.0)
    first = found.first_estimate()
    assert (first.position_periods, first.position_hats, first.position_range) == ((0.4,), 0, None)
    assert first.position_map == found.position_map.coefficients
    assert first.position_map == pytest.approx((0.0, 0.3), abs=0.03)
    for name, deviation in zip(("cosine_1", "sine_1"), first.map_deviation, strict=True):
        estimate = found.selection.chosen.regression.estimate("friction_over_" + name)
        half = 0.5 * (estimate.upper - estimate.lower)
        assert deviation * NormalDist().inv_cdf(0.975) == pytest.approx(half)
    curve = controller_of(first).learnt_map
    assert curve.share == 1.0
    truth = 1.0 + 0.3 * np.sin(2.0 * np.pi / 0.4 * curve.position)
    assert np.max(np.abs(curve.factor - truth)) < 0.04


def test_of_a_current_the_map_is_the_same_as_it_is_a_share():
    log = mapped_log()
    of_current = with_torque(log, log.torque / AMPERE)
    asked = {"position_periods": (0.4,), "held_out": 0.0}
    scaled = identify_log(of_current, is_current=True, **asked).first_estimate(AMPERE)
    assert scaled.position_map == pytest.approx(identify_log(log, **asked).first_estimate().position_map, rel=1e-6)


def test_without_a_map_none_goes_along(found):
    first = found.first_estimate()
    assert (first.position_periods, first.position_hats, first.position_map) == ((), 0, None)
    assert controller_of(first).learnt_map is None


def test_hats_of_which_the_log_says_nothing_are_unknown_to_the_controller():
    log = mapped_log(period=0.8)
    found = identify_log(log, position_hats=13, held_out=0.0)
    learnt = found.position_map
    errors = (*learnt.standard_errors[:-2], np.inf, np.inf)
    unvisited = learnt._replace(coefficients=(*learnt.coefficients[:-2], 0.0, 2.5), standard_errors=errors)
    first = replace(found, position_map=unvisited).first_estimate()
    assert (first.position_hats, first.position_range) == (13, learnt.range)
    assert first.position_map[-1] == 2.0
    assert first.map_deviation[-2:] == (np.inf, np.inf)
    state = controller_of(first).state.estimator.friction_map
    assert np.flatnonzero(state.information == 0.0).tolist() == [11, 12]
    assert state.coefficients[11:].tolist() == [0.0, 0.0]


def test_first_seconds_over_position_are_better_with_the_map_than_without():
    base = load_scenario().modified(variation={"position_amplitude": 0.3, "position_period": 0.3})
    columns = simulate(base.modified(duration=60.0, sampling={"period": 0.001}, seed=101), "pi").columns()
    velocity = columns["velocity"]
    position = np.concatenate([[0.0], np.cumsum(0.0005 * (velocity[1:] + velocity[:-1]))])
    position += 1e-5 * np.random.default_rng(101).standard_normal(position.size)
    log = Log("run", columns["time"], columns["torque"], position=position)
    first = identify_log(log, torque_delay=0.0005, position_periods=(0.3,)).first_estimate()
    variants = {
        "carried": first,
        "learnt": first._replace(position_map=None),
        "none": first._replace(position_map=None, position_periods=()),
    }
    errors = {name: [] for name in variants}
    for seed in (1, 2, 3):
        scenario = base.modified(duration=5.0, seed=seed)
        for name, arguments in variants.items():
            controller = AdaptiveController(*scenario.feedback.gains, 0.01, **arguments._asdict())
            run = simulate(scenario, controller)
            errors[name].append(np.sqrt(np.mean((run.reference - run.velocity) ** 2)))
    for without in ("learnt", "none"):
        ratios = np.array(errors["carried"]) / errors[without]
        assert np.max(ratios) < 0.85
        assert np.median(ratios) < 0.7
