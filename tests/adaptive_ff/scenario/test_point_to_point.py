import math

import numpy as np
import pytest

from adaptive_ff.scenario.waves import PointToPoint, Staircase, Triangle, plan_move

STEP = 1e-5
GENERATOR = np.random.default_rng(0)


@pytest.mark.parametrize("jerk", [None, 20.0])
@pytest.mark.parametrize("distance", [1e-4, -0.01, 0.08, 0.5, -3.0])
def test_move_keeps_its_limits_reaches_its_distance_and_is_the_fastest_that_does(distance, jerk):
    speed, acceleration = 0.3, 1.0
    move = plan_move(distance, speed, acceleration, jerk)
    time = np.arange(-0.1, move.duration + 0.1, STEP)
    velocity = move.velocity(time)
    assert np.sum(velocity) * STEP == pytest.approx(distance, rel=1e-6, abs=1e-9)
    assert np.all(velocity[(time <= 0.0) | (time >= move.duration)] == 0.0)
    assert np.all(velocity * distance >= 0.0)
    slopes = np.diff(velocity) / STEP
    tops = [np.max(np.abs(velocity)) / speed, np.max(np.abs(slopes)) / acceleration]
    if jerk is not None:
        tops.append(np.max(np.abs(np.diff(slopes))) / STEP / jerk)
    assert max(tops) == pytest.approx(1.0, abs=0.01)  # one of the limits is reached, none passed


def test_long_trapezoid_lasts_as_long_as_its_closed_form():
    assert plan_move(0.6, 0.3, 1.0).duration == pytest.approx(0.6 / 0.3 + 0.3 / 1.0)
    assert plan_move(0.6, 0.3, 1.0, 20.0).duration == pytest.approx(0.6 / 0.3 + 0.3 / 1.0 + 1.0 / 20.0)
    assert plan_move(0.01, 0.3, 1.0).duration == pytest.approx(2.0 * math.sqrt(0.01))
    assert plan_move(0.0, 0.3, 1.0).duration == 0.0


def test_all_positions_are_visited_in_turn_with_a_rest_at_each():
    reference = PointToPoint(kind="point_to_point", positions=[0.2, -0.1, 0.3], dwell=0.5)
    time = np.arange(0.0, 30.0, 1e-4)
    velocity = reference.velocity(time, GENERATOR)
    position = np.cumsum(velocity) * 1e-4
    rests = np.flatnonzero(np.diff((velocity == 0.0).astype(int)) == 1)[:7]
    assert position[rests] == pytest.approx([0.2, -0.1, 0.3, 0.2, -0.1, 0.3, 0.2], abs=1e-4)
    starts = np.flatnonzero(np.diff((velocity == 0.0).astype(int)) == -1)
    later = starts[starts > rests[0]][:6]
    assert (later - rests[:6]) * 1e-4 == pytest.approx(np.full(6, 0.5), abs=3e-4)


def test_repeats_end_in_rest_and_a_distance_goes_forth_and_back():
    time = np.arange(0.0, 20.0, 1e-3)
    reference = PointToPoint(kind="point_to_point", distance=0.2, dwell=0.3, repeats=2)
    twice = PointToPoint(kind="point_to_point", positions=[0.2, 0.0, 0.2, 0.0], dwell=0.3, repeats=1)
    velocity = reference.velocity(time, GENERATOR)
    assert velocity == pytest.approx(twice.velocity(time, GENERATOR), abs=1e-9)
    assert not np.any(velocity[time > 6.0])
    assert np.max(np.cumsum(velocity)) * 1e-3 == pytest.approx(0.2, rel=1e-3)


def test_a_single_position_is_reached_once():
    reference = PointToPoint(kind="point_to_point", positions=[0.2], dwell=0.0)
    velocity = reference.velocity(np.arange(0.0, 9.0, 1e-3), GENERATOR)
    assert np.sum(velocity) * 1e-3 == pytest.approx(0.2, rel=1e-3)


def test_triangle_has_its_peak_its_period_and_a_constant_slope():
    time = np.arange(0.0, 8.0, 1e-3)
    velocity = Triangle(kind="triangle", peak=0.2, period=2.0).velocity(time, GENERATOR)
    assert velocity[[0, 500, 1000, 1500, 2000, 2500]] == pytest.approx([0.0, 0.2, 0.0, -0.2, 0.0, 0.2], abs=1e-12)
    assert np.abs(np.diff(velocity)) == pytest.approx(0.2 / 0.5 * 1e-3, rel=1e-6)


def test_staircase_holds_each_velocity_and_begins_again():
    levels, time = [0.1, 0.3, -0.2], np.arange(0.0, 12.0, 1e-3)
    velocity = Staircase(kind="staircase", velocities=levels, hold=1.0, acceleration=1.0).velocity(time, GENERATOR)
    assert velocity[0] == 0.0
    assert np.max(np.abs(np.diff(velocity))) <= 1e-3 * (1.0 + 1e-9)
    middles = np.array([0.1 + 0.5, 0.1 + 1.0 + 0.2 + 0.5, 0.1 + 1.0 + 0.2 + 1.0 + 0.5 + 0.5])
    assert velocity[np.rint(1e3 * middles).astype(int)] == pytest.approx(levels)
    cycle = 0.3 + 1.0 + 0.2 + 1.0 + 0.5 + 1.0
    assert velocity[np.rint(1e3 * (middles[1:] + cycle)).astype(int)] == pytest.approx(levels[1:])
    assert [np.count_nonzero(velocity == level) > 1900 for level in levels] == [True] * 3
