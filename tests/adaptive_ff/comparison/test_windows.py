"""Windows of PI against a controller, over draws of the noise."""

import numpy as np
import pytest

from adaptive_ff import load_scenario, simulate
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.comparison.windows import (
    Errors,
    Judgement,
    judge,
    judge_chance,
    noisy_courses,
    run_errors,
    window_slices,
)
from adaptive_ff.simulation.metrics import rms

SCENARIO = load_scenario().modified(duration=23.0, change=[{"time": 11.0, "load": 30.0}])


def errors(windows, settled=1.0, start=1.0, after=()):
    return Errors(np.array(windows), settled, start, tuple(after))


def test_errors_are_roots_of_mean_squares_over_draws_and_their_parts():
    found = run_errors(SCENARIO, "oracle", draws=3)
    series = []
    for course in noisy_courses(SCENARIO, 3):
        run = simulate(SCENARIO, "oracle", course=course)
        series.append(run.reference - run.velocity)
    joined = np.array(series)
    assert found.settled == pytest.approx(rms(joined[:, 17_000:]), rel=1e-12)
    assert found.windows == pytest.approx([rms(joined[:, a : a + 5000]) for a in (0, 5000, 10_000, 15_000)], rel=1e-12)
    assert found.after == pytest.approx((rms(joined[:, 11_000:16_000]),), rel=1e-12)
    assert found.start == pytest.approx(rms(joined[:, 1:5002]), rel=1e-12)  # it moves from the first step on


def test_behind_a_position_loop_the_error_is_that_of_the_position():
    cascade = SCENARIO.modified(position={})
    found, run = run_errors(cascade, "pi", draws=1), simulate(cascade, "pi")
    assert found.settled == pytest.approx(rms(run.position_error[17_000:]), rel=1e-12)
    assert found.settled < 0.2 * rms((run.reference - run.velocity)[17_000:])


def test_first_draw_is_the_scenario_itself_and_the_others_differ_in_noise_alone():
    own, *others = noisy_courses(SCENARIO, 3)
    assert np.array_equal(own.noise, SCENARIO.noise())
    assert all(np.array_equal(course.reference, own.reference) for course in others)
    noises = np.array([own.noise, *(course.noise for course in others)])
    assert np.std(noises, axis=1) == pytest.approx(0.002, rel=0.05)
    assert np.max(np.abs(np.corrcoef(noises) - np.eye(3))) < 0.1


def test_without_noise_there_is_one_draw():
    assert len(list(noisy_courses(SCENARIO.modified(sensor={"velocity_noise": 0.0}), 5))) == 1


def test_pi_against_itself_is_one_everywhere_and_a_better_controller_is_better():
    pi = judge(SCENARIO, "pi", draws=1)
    assert (pi.settled, pi.start, pi.after) == (1.0, 1.0, (1.0,))
    assert np.max(pi.windows) == 1.0
    oracle = judge(SCENARIO, lambda scenario: make_controller(scenario, "oracle"), draws=1, base=pi.base)
    assert oracle.settled > 2.0
    assert oracle.worst_window < 0.8


def test_what_chance_does_is_pi_against_itself_under_other_noise():
    found = judge_chance(SCENARIO, draws=2)
    others = run_errors(SCENARIO, "pi", draws=4)
    squares = np.mean([found.base.windows**2, found.own.windows**2], axis=0)
    np.testing.assert_allclose(np.sqrt(squares), others.windows)  # draws 0 and 1, then 2 and 3
    assert 0.5 < found.settled < 2.0
    assert found.settled != 1.0
    assert judge_chance(SCENARIO.modified(sensor={"velocity_noise": 0.0}), draws=2).worst_window == 1.0


def test_window_where_pi_has_nearly_no_error_counts_as_a_share_of_its_median_window():
    judgement = Judgement(errors([1.0, 0.01, 2.0, 1.0]), errors([0.5, 0.3, 1.0, 1.0]))
    assert judgement.windows == pytest.approx([0.5, 2.0, 0.5, 1.0])
    assert judgement.worst_window == pytest.approx(2.0)


def test_loop_that_does_not_stay_finite_is_infinitely_worse():
    class Runaway:
        calls = 0

        def step(self, reference, velocity, **others):
            self.calls += 1
            return 10.0**self.calls if self.calls < 300 else 0.0

    scenario = load_scenario().modified(duration=5.0, actuator={"torque_limit": 1e300})
    judgement = judge(scenario, lambda scenario: Runaway(), draws=1)
    assert judgement.settled == 0.0
    assert judgement.worst_window == np.inf


def test_vanishing_errors_are_compared_all_the_same():
    assert Judgement(errors([0.0], settled=0.0), errors([0.0], settled=0.0)).settled == 1.0
    assert Judgement(errors([0.0], settled=0.0), errors([1.0], settled=1.0)).settled == 0.0
    assert Judgement(errors([0.0]), errors([1.0])).worst_window == np.inf


def test_short_series_is_one_window_and_a_rest_is_left_out():
    assert window_slices(100, 0.1) == [slice(0, 50), slice(50, 100)]
    assert window_slices(149, 0.1) == [slice(0, 50), slice(50, 100)]
    assert window_slices(49, 0.1) == [slice(0, 49)]


def test_draws_must_be_positive():
    with pytest.raises(ValueError, match="draws = 0 is not allowed"):
        judge(SCENARIO, "pi", draws=0)
