"""A ripple over the position, such as cogging, of a period that the controller is told."""

import json
import math

import numpy as np
import pytest

from adaptive_ff import WITH_OFFSET, AdaptiveController, JointGroup, compare, load_scenario
from adaptive_ff.adaptive.settings import MOST_REGRESSORS
from adaptive_ff.comparison.reference_lines import noise_floor
from controllers import pi_gains
from tests.helpers.driven_joint import PERIOD, drive, reference_joint, rms

GAINS = pi_gains(20.0, 10.0)
END, AMPLITUDE, LENGTH = 30.0, 20.0, 0.02  # s, N m, rad: up to 20 Hz at the speeds of the plan
MODEL = {"inertia": 20.0, "friction_lag": 0.02, "coulomb": 60.0, "stiction": 90.0, "viscous": 80.0}


def make(**options):
    common = {"inertia": 20.0, "stribeck_velocity": 0.05, "parameters": WITH_OFFSET}
    return AdaptiveController(*GAINS, period=PERIOD, **common | options)


def told(**options):
    return make(ripple_periods=[LENGTH], **options)


def cogging(time, position):
    return AMPLITUDE * math.sin(2.0 * math.pi * position / LENGTH + 0.6)


def known_position(time, position):
    return position


def settled(run):
    return rms(run.error[run.time > 0.6 * END])


@pytest.fixture(scope="module")
def smooth():
    return settled(drive(make(), reference_joint(), 0.0, END, position=known_position))


def test_joint_with_cogging_settles_as_without(smooth):
    controller = told()
    run = drive(controller, reference_joint(), 0.0, END, load=cogging, position=known_position)
    assert settled(run) < 1.15 * smooth
    assert controller.estimates["ripple_sin_1"] == pytest.approx(AMPLITUDE * math.cos(0.6), abs=0.1 * AMPLITUDE)
    assert controller.estimates["ripple_cos_1"] == pytest.approx(AMPLITUDE * math.sin(0.6), abs=0.1 * AMPLITUDE)
    assert controller.estimates["coulomb"] == pytest.approx(60.0, abs=3.0)


def test_what_cogging_costs_where_its_period_is_not_told(smooth):
    """The margin of the test above means something."""
    assert settled(drive(make(), reference_joint(), 0.0, END, load=cogging, position=known_position)) > 3.0 * smooth


def test_several_periods_are_told_apart(smooth):
    def both(time, position):
        return cogging(time, position) + 10.0 * math.cos(2.0 * math.pi * position / 0.3)

    controller = make(ripple_periods=[LENGTH, 0.3])
    run = drive(controller, reference_joint(), 0.0, END, load=both, position=known_position)
    assert settled(run) < 1.2 * smooth
    assert controller.estimates["ripple_cos_2"] == pytest.approx(10.0, abs=1.0)


def test_the_period_is_that_of_the_joint_behind_a_gear():
    ratio = -50.0
    direct, geared = told(), told(gear_ratio=ratio)
    first = drive(direct, reference_joint(), 0.0, 5.0, load=cogging, position=known_position)
    scaled = AdaptiveController(
        GAINS[0],
        GAINS[1],
        PERIOD,
        inertia=20.0,
        stribeck_velocity=0.05,
        parameters=WITH_OFFSET,
        gear_ratio=ratio,
        ripple_periods=[LENGTH / abs(ratio)],
    )
    second = drive(scaled, reference_joint(), 0.0, 5.0, load=cogging, position=known_position)
    np.testing.assert_allclose(second.torque, first.torque, rtol=1e-6, atol=1e-6)
    assert scaled.estimates["ripple_sin_1"] == pytest.approx(-direct.estimates["ripple_sin_1"], rel=1e-6)
    assert geared.parameters.estimator.waves.tolist() == direct.parameters.estimator.waves.tolist()


class BehindALowPass:
    """Shows a controller the velocity behind a low-pass, and the position as it is."""

    def __init__(self, controller, lag):
        self.controller, self.share, self.seen = controller, -math.expm1(-PERIOD / lag), 0.0

    def step(self, reference, velocity, **given):
        self.seen += self.share * (velocity - self.seen)
        return self.controller.step(reference, self.seen, **given)


def test_where_the_velocity_lags_the_ripple_is_that_of_what_it_shows():
    """Taken where the joint is now, the error with the lag told is 1.2 times the one with it untold, not half."""
    time_constant = 0.02
    lag = PERIOD / math.expm1(PERIOD / time_constant)
    gains, errors = pi_gains(20.0, 3.0), []
    for told_lag in (0.0, lag):
        controller = AdaptiveController(
            *gains,
            PERIOD,
            inertia=20.0,
            stribeck_velocity=0.05,
            parameters=WITH_OFFSET,
            velocity_lag=told_lag,
            ripple_periods=[LENGTH],
        )
        behind = BehindALowPass(controller, time_constant)
        errors.append(settled(drive(behind, reference_joint(), 0.0, END, load=cogging, position=known_position)))
    assert errors[1] < 0.6 * errors[0]


def test_without_a_position_nothing_of_a_ripple_is_identified_or_fed():
    blind = told()
    first, second = (drive(one, reference_joint(), 0.0, 3.0) for one in (make(), blind))
    assert blind.estimates["ripple_sin_1"] == blind.estimates["ripple_cos_1"] == 0.0
    np.testing.assert_array_equal(first.torque, second.torque)
    assert not any("ripple" in one.name for one in blind.diagnose().parameters)


def test_a_first_model_is_fed_from_the_first_position_on():
    known = {"ripple_sin_1": 8.0, "ripple_cos_1": -3.0}
    with_ripple, without = told(model=MODEL | known), told(model=MODEL)
    place = 0.0123
    torques = [one.step(0.0, 0.0, position=place, next_reference=0.0) for one in (with_ripple, without)]
    phase = 2.0 * math.pi * place / LENGTH
    assert torques[0] - torques[1] == pytest.approx(8.0 * math.sin(phase) - 3.0 * math.cos(phase), rel=1e-9)


def test_a_saved_state_goes_on_and_belongs_to_its_periods():
    controller = told()
    drive(controller, reference_joint(), 0.0, 3.0, load=cogging, position=known_position)
    text = controller.state_to_json()
    again = told()
    again.state_from_json(text)
    assert again.estimates == controller.estimates
    assert again.step(0.1, 0.1, position=0.3) == controller.step(0.1, 0.1, position=0.3)
    with pytest.raises(ValueError, match="ripple_waves"):
        make(ripple_periods=[1.1 * LENGTH]).state_from_json(text)
    saved = json.loads(text)
    saved["state"]["estimator"]["recursion"]["estimate"][-1] = 1e9
    with pytest.raises(ValueError, match="estimate"):
        again.state_from_json(json.dumps(saved))


@pytest.mark.parametrize("periods", [[0.0], [-1.0], [math.nan], [math.inf], [[0.1]], [0.1] * 9])
def test_periods_that_are_none_are_refused(periods):
    with pytest.raises(ValueError, match=r"^ripple_periods = .* is not allowed: at most 8 positive numbers of rad$"):
        make(ripple_periods=periods)


def test_more_columns_than_can_be_learnt_are_refused():
    periods = [0.1, 0.2, 0.3]
    assert len(make(ripple_periods=periods, regressors=MOST_REGRESSORS - 6).estimate_names) > MOST_REGRESSORS
    with pytest.raises(ValueError, match=r"^regressors = 15 is not allowed: with 3 ripple_periods"):
        make(ripple_periods=periods, regressors=MOST_REGRESSORS - 5)


@pytest.mark.parametrize("over", [{"ripple_periods": [0.1]}, {"position_periods": [0.1]}, {"position_hats": 5}])
def test_in_a_chain_only_a_joint_on_the_base_knows_its_own_position(over):
    joint = {**dict(zip(("proportional", "integral"), GAINS, strict=True)), "inertia": 20.0, "stribeck_velocity": 0.05}
    lower, upper = {**joint, **over}, {**joint, "preceding": ["lower"]}
    JointGroup.from_table({"period": PERIOD, "joints": {"lower": lower, "upper": upper}})
    with pytest.raises(ValueError, match=r"^upper\.preceding is not allowed with ripple_periods"):
        JointGroup.from_table({"period": PERIOD, "joints": {"lower": joint, "upper": {**upper, **over}}})


def test_in_a_scenario_it_is_as_good_as_the_true_parameters():
    drive_with = {"ripple_amplitude": AMPLITUDE, "ripple_period": LENGTH}
    scenario = load_scenario().modified(
        seed=101,
        controllers=["pi", "adaptive", "oracle"],
        actuator=drive_with,
        adaptation={"ripple_periods": [LENGTH]},
    )
    comparison = compare(scenario)
    errors = {name: run.metrics.rms_error_settled for name, run in comparison.runs.items()}
    assert errors["adaptive"] < 1.1 * errors["oracle"] < 0.2 * errors["pi"]
    assert comparison.runs["adaptive"].final_estimates["ripple_sin_1"] == pytest.approx(-AMPLITUDE, rel=0.05)
    plain = load_scenario().modified(seed=101)
    floors = [noise_floor(one).metrics.rms_error_settled for one in (scenario, plain)]
    assert floors[0] == floors[1]
