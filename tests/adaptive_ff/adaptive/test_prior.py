"""What a controller begins with: a model as sure as it is said to be, a first map; slopes of physical estimates."""

import math

import numpy as np
import pytest
from exports import adaptive, adaptive_variants

from adaptive_ff import PER_DIRECTION_WITH_GRAVITY, WITH_OFFSET
from adaptive_ff.adaptive.estimates import HELD, fill_slopes, write_physical
from adaptive_ff.learning.kalman import LOOP
from controllers import pi_gains
from controllers.arrays import unpacked

PROPORTIONAL, _ = pi_gains(20.0, 10.0)
UNIT, RESPONSE = 0.05 * PROPORTIONAL, 20.0 / PROPORTIONAL
PATH = np.array([0.0, *(0.05 * RESPONSE * 4.0 ** np.arange(4))])  # presliding distances, rad
EVERY = {"ripple_periods": [0.1, 0.3], "regressors": 2, "position_hats": 3, "position_periods": [0.5, 1.0]}
SIDES = [(WITH_OFFSET, {}), (PER_DIRECTION_WITH_GRAVITY, EVERY | {"load_friction": True})]
MODEL = {"inertia": 20.0, "friction_lag": 0.02, "coulomb": 60.0, "presliding": 0.5 * PATH[1]}  # half of it slips


@pytest.mark.parametrize("presliding", [0.0, 0.5 * PATH[1], *PATH[2:] - 0.3 * PATH[1], 1.5 * PATH[4]])
@pytest.mark.parametrize(("parameters", "options"), SIDES)
def test_a_model_is_what_is_estimated_first_as_surely_as_is_said(parameters, options, presliding):
    every = adaptive(parameters, **options).estimate_names
    names = [name for name in every if name not in ("offset", "stribeck_velocity", "presliding")]
    model = {name: 30.0 + place for place, name in enumerate(names)} | {"coulomb": 60.0, "stiction": 90.0}
    model |= {"viscous": 80.0, "friction_lag": 0.04, "stribeck_velocity": 0.1, "presliding": min(presliding, PATH[4])}
    first = adaptive(parameters, model=model | {"presliding": presliding, "offset": 5.0}, deviation=0.1, **options)
    assert first.estimates == pytest.approx(dict.fromkeys(every, 0.0) | model | {"offset": 5.0})
    spread = {name: 0.1 * model[name] for name in names} | {"stiction": math.hypot(6.0, 9.0)}
    assert {name: first.uncertainties[name] for name in names} == pytest.approx(spread)
    each = {name: 150.0 + place for place, name in enumerate(names)} | {"friction_lag": 1e-9, "viscous": 1e-9}
    made = adaptive(parameters, model=model | {"presliding": 0.0}, deviation=each, **options).uncertainties
    each |= {"friction_lag": 0.01 * 0.04, "viscous": 0.01 * 0.4 * PROPORTIONAL}
    each |= {"presliding": 0.5 * each["coulomb"] / 60.0 * math.sqrt(5.0) * np.std(PATH)}
    each |= {"stiction": math.hypot(each["coulomb"], each["stiction"])}
    assert {name: made[name] for name in each} == pytest.approx(each)


def test_what_a_model_says_is_bounded():
    model = MODEL | {"friction_lag": 0.0, "stribeck_velocity": 9.0, "stiction": 20.0}
    made = adaptive(model=model).estimates
    assert (made["friction_lag"], made["stribeck_velocity"], made["stiction"]) == pytest.approx((0.001, 0.5, 30.0))
    assert adaptive(model=model | {"stribeck_velocity": 1e-3}).estimates["stribeck_velocity"] == pytest.approx(0.005)


@pytest.mark.parametrize(("parameters", "options"), [(WITH_OFFSET, {"regressors": 1}), SIDES[1]])
def test_a_first_map_is_the_friction_over_position(parameters, options):
    mapped = {"position_periods": [0.5, 1.0], "position_hats": 3, "position_range": [-0.4, 0.6]}
    mapped |= {"position_map": [-0.3, -0.2, 0.1, 0.05, -1.8, 0.4, -1.5]}
    spread = [0.1, math.inf, 0.3, 0.001, 0.5, 0.6, math.inf]
    first = adaptive(parameters, **options | mapped, model=MODEL, map_deviation=spread)
    found, q = first.learnt_map, np.linspace(-0.4, 0.6, 400)
    waves = [part(2.0 * math.pi * q / period) for period in (0.5, 1.0) for part in (np.cos, np.sin)]
    said = np.array([-0.3, 0.0, 0.1, 0.05]) @ waves + np.interp(q, [-0.4, 0.1, 0.6], [-1.8, 0.4, 0.0])
    factor = np.maximum(1.0 + said, 0.0)
    np.testing.assert_allclose([found.position, found.factor], [q, factor / factor.mean()])
    assert (*found.periods, found.load_share) == pytest.approx((0.5, 1.0, 0.0))
    further = 2 + options["regressors"] + ("load_friction" in options)
    variances = np.diag(unpacked(first.state.estimate.covariance))[LOOP:][-further - 7 : -further]
    unknown = 0.3 * UNIT / 60.0
    expected = 60.0 * np.array([unknown, 0.1, 0.01, 0.3, 0.5, 0.6, unknown])  # of each period the sine comes first
    np.testing.assert_allclose(variances, expected**2)


def test_the_observer_has_the_pole_that_it_is_given_and_the_loop_allows():
    poles = [adaptive(observer_bandwidth=one).parameters.machine.observer_pole for one in (None, 2.0)]
    assert poles == pytest.approx([20.0 * math.pi, 4.0 * math.pi])


def test_a_map_is_read_where_there_are_columns_for_one():
    new, loaded = adaptive(position_periods=[0.5, 1.0]).learnt_map, adaptive(load_friction=True, model=MODEL)
    np.testing.assert_allclose([new.position, new.factor], [np.linspace(0.0, 1.0, 400), np.ones(400)])
    loaded.state.estimate.mean[-3] = 6.0
    assert (loaded.learnt_map.position.size, loaded.learnt_map.load_share) == (0, pytest.approx(0.1))
    assert adaptive().learnt_map is None


VARIANTS = {name: make() for name, make in adaptive_variants().items()}
VARIANTS |= {"no offset, regressors": adaptive(regressors=2), "ripples": adaptive(ripple_periods=range(1, 9))}


@pytest.mark.parametrize("controller", VARIANTS.values(), ids=VARIANTS)
def test_slopes_are_the_derivatives_of_the_estimates(controller):
    parameters, state, count = controller.parameters, controller.state, len(controller.estimate_names)
    mean = np.random.default_rng(1).uniform(0.5, 2.0, state.estimate.mean.size)

    def with_mean(values):
        return state._replace(estimate=state.estimate._replace(mean=values))

    def estimates(values):
        row = np.zeros(count)
        write_physical(parameters, with_mean(values)._replace(steady=values[HELD]), row)
        return row

    slopes, steps = np.ones((count, mean.size)), 1e-5 * np.eye(mean.size)
    fill_slopes(parameters, with_mean(mean), slopes)
    expected = np.array([(estimates(mean + step) - estimates(mean - step)) / 2e-5 for step in steps]).T
    np.testing.assert_allclose(slopes, expected, rtol=1e-6, atol=1e-8)
    assert np.all(np.any(slopes[:, LOOP:], axis=1) | (np.array(controller.estimate_names) == "offset"))


@pytest.mark.parametrize("deviation", [-0.1, 0.0, math.inf])
def test_a_deviation_is_positive_and_finite(deviation):
    with pytest.raises(ValueError, match=f"^deviation = {deviation} is not allowed: it must be positive and finite"):
        adaptive(model=MODEL, deviation=deviation)


@pytest.mark.parametrize("parameters", ["inertia", 3])
def test_parameters_that_are_none_are_named_as_they_were_given(parameters):
    with pytest.raises(ValueError, match=f"^parameters = {parameters!r} is not allowed: it must be \\("):
        adaptive(parameters)
