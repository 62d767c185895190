"""Noise that a filter has made slow, told from white noise and from motion."""

import numpy as np
import pytest

from adaptive_ff import load_scenario
from adaptive_ff.adaptive.supervision.colour import (
    EARLY,
    FELT,
    advance_colour,
    initial_colour,
    is_coloured,
    mean_length,
)
from adaptive_ff.adaptive.supervision.noise_level import RISE, advance_noise, initial_noise
from adaptive_ff.adaptive.supervision.observer_gates import AT_ONCE, MUCH, helping_share
from adaptive_ff.adaptive.supervision.observer_state import initial_observer
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.comparison.run import simulate
from adaptive_ff.scenario.library import SCENARIOS
from controllers import check_gains
from tests.helpers.judged import judge

PERIOD, LENGTH, GAIN = 0.001, 8, 100.0


def followed(errors, *, tells=True, begin=None):
    """Return noise and colour after a series of errors."""
    noise, colour = (initial_noise(), initial_colour()) if begin is None else begin
    for error in errors:
        noise = advance_noise(noise, float(error), tells, PERIOD)
        colour = advance_colour(colour, float(error), tells, LENGTH, PERIOD)
    return noise, colour


def white(seconds, seed, deviation=0.01):
    return deviation * np.random.default_rng(seed).standard_normal(round(seconds / PERIOD))


def slow(seconds, seed, deviation=0.01, pole=100.0):
    """White noise behind a low-pass of second order."""
    share, filtered = 1.0 - np.exp(-pole * PERIOD), white(seconds, seed, deviation)
    for _ in range(2):
        state, made = 0.0, []
        for value in filtered:
            state += share * (value - state)
            made.append(state)
        filtered = np.array(made)
    return filtered


def coloured(found, friction=1.0):
    noise, colour = found
    return is_coloured(colour, noise, LENGTH, GAIN, friction)


@pytest.mark.parametrize("seed", [101, 102, 103])
def test_noise_behind_a_filter_is_coloured_and_white_noise_is_not(seed):
    assert coloured(followed(slow(3.0, seed)))
    assert not coloured(followed(white(3.0, seed)))


@pytest.mark.parametrize("seed", [101, 102, 103])
def test_means_of_white_noise_have_its_variance_over_their_length(seed):
    states = followed(white(20.0, seed))
    assert LENGTH * states[1].variance == pytest.approx(states[0].variance, rel=0.5)
    assert LENGTH * states[1].variance < states[0].variance  # the minimum of fewer values is a lower one


def test_it_is_told_early_and_not_at_once():
    assert coloured(followed(slow(EARLY + 0.05, 101)))
    assert not coloured(followed(slow(EARLY, 101)))


def test_what_the_feedback_makes_little_of_beside_the_friction_does_not_count():
    found = followed(slow(3.0, 104))
    felt = GAIN * np.sqrt(found[1].variance) / FELT
    assert coloured(found, 0.99 * felt)
    assert not coloured(found, 1.01 * felt)


def test_a_ramp_of_the_error_is_no_noise():
    errors = white(3.0, 105) + 5.0 * PERIOD * np.arange(3000)
    assert not coloured(followed(errors))


def test_noise_that_grows_is_followed_slowly_and_what_shows_none_begins_the_means_anew():
    found = followed(slow(3.0, 106))
    louder = followed(slow(2.0, 107, deviation=0.1), begin=found)
    assert 1.0 < louder[1].variance / found[1].variance <= np.exp(2.0 / RISE) * (1.0 + 1e-6)
    rested = followed(np.zeros(5), tells=False, begin=louder)[1]
    assert (rested.samples, rested.means, rested.variance) == (0, 0, louder[1].variance)


def test_means_are_taken_over_a_quarter_of_the_time_constant_and_one_sample_at_least():
    assert mean_length(62.5, 0.001) == 4
    assert mean_length(62.5, 0.01) == 1


def behind_a_kalman_filter(counts, seed):
    return load_scenario().modified(
        seed=seed,
        sampling={"period": 0.001},
        sensor={"velocity_noise": 0.0, "encoder_resolution": 2.0 * np.pi / counts},
        velocity={"method": "kalman"},
    )


def judged(scenarios):
    """Return judgements on a few references: what a single one does depends on the last digits of its plan."""
    return [judge(scenario, draws=1) for scenario in scenarios]


def geometric_mean(ratios):
    return float(np.exp(np.mean(np.log(ratios))))


@pytest.mark.parametrize(("counts", "least"), [(16384, 1.8), (32768, 2.8)])
def test_counts_behind_a_kalman_filter_leave_hardly_a_window_that_is_worse_than_the_loop_alone(counts, least):
    """They settled at 1.5 and 2.3, and the median of the worst windows was at 1.8 of PI's error."""
    found = judged(behind_a_kalman_filter(counts, seed) for seed in range(101, 105))
    assert geometric_mean([judgement.settled for judgement in found]) > least
    assert np.median([judgement.worst_window for judgement in found]) < 1.3


def test_a_minimum_begins_with_the_first_second_difference():
    """Where every tenth value is repeated no mean is full, and the minimum was that of none for good."""
    begin = initial_noise(), initial_colour()
    for error in slow(2.0, 108):
        begin = followed([error], begin=begin)
        begin = followed([error], tells=bool(begin[1].samples != LENGTH - 1), begin=begin)
    assert begin[1].measured == 0.0
    assert coloured(followed(slow(3.0, 109), begin=begin))


@pytest.mark.parametrize(("name", "least"), [("load_step_80", 3.0), ("friction_triples", 6.0)])
def test_a_change_beside_such_noise_is_observed_all_the_same(name, least):
    """With the observer let go of altogether they settled at 1.8 and 4.5, and the 5 s after were at 0.8 and 0.7."""
    base, encoder = load_scenario(SCENARIOS / f"{name}.toml"), behind_a_kalman_filter(65536, 101)
    changed = base.modified(sampling={"period": 0.001}, sensor=encoder.sensor, velocity=encoder.velocity)
    found = judged(changed.modified(seed=seed) for seed in range(101, 105))
    assert geometric_mean([judgement.settled for judgement in found]) > least
    assert geometric_mean([judgement.after[0] for judgement in found]) < 0.65


def test_beside_such_noise_an_observer_that_does_not_help_is_used_for_much_torque_alone():
    state = initial_observer(check_gains(1000.0, 0.0, PERIOD))
    state = state._replace(effect=state.effect._replace(help=0.1))
    level = MUCH * 60.0
    assert helping_share(state._replace(squared=level**2), 60.0) == pytest.approx(0.1)
    assert helping_share(state._replace(squared=1.5 * level**2), 60.0) == pytest.approx(0.55)
    assert helping_share(state._replace(squared=2.0 * level**2), 60.0) == pytest.approx(1.0)
    assert helping_share(state._replace(disturbance=level * np.sqrt(2.0 / AT_ONCE)), 60.0) == pytest.approx(1.0)


def test_that_the_observer_does_not_help_beside_such_noise_is_said():
    scenario = behind_a_kalman_filter(16384, 102).modified(duration=15.0)
    controller = make_controller(scenario, "adaptive")
    simulate(scenario, controller)
    said = " ".join(controller.diagnose().supervision)
    assert "the noise of the measured velocity changes slowly" in said
    assert controller.state.observer.effect.help < 0.5


@pytest.mark.parametrize(
    ("name", "value"),
    [("squared", -1.0), ("variance", -1.0), ("samples", -1), ("means", -1), ("time", -1.0), ("measured", -1.0)],
)
def test_an_impossible_state_is_refused(name, value):
    scenario = load_scenario()
    controller = make_controller(scenario, "adaptive")
    observer = controller.state.observer
    changed = observer._replace(colour=observer.colour._replace(**{name: value}))
    controller.state = controller.state._replace(observer=changed)
    with pytest.raises(ValueError, match=rf"state\.observer\.colour\.{name} = {value} is not allowed"):
        controller.state_from_json(controller.state_to_json())
