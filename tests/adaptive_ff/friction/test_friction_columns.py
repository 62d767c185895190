"""Unit torques along a motion, against fine numerical integration and differences."""

import math

import numpy as np
import pytest

from adaptive_ff.friction.columns import COULOMB, INERTIA, PATHS, STICTION, VISCOUS, Curve, Hypothesis, columns_along

PERIOD, FINE = 0.01, 40
CURVE = Curve(lag=0.02, stribeck_velocity=0.05, coulomb=60.0, stiction=90.0, viscous=80.0, hold=0.0)
HYPOTHESIS = Hypothesis(1.0, np.array([0.01]), False, np.ones(1), np.zeros(0), 0, 0.0, 1.0, False, 0, 1.0)


def a_motion():
    time = np.arange(0.0, 12.0, PERIOD)
    return 0.3 * np.sin(2.0 * math.pi * 0.3 * time) + 0.1 * np.sin(2.0 * math.pi * 0.71 * time)


def finely(velocity):
    time = PERIOD * np.arange(velocity.size)
    return np.interp(np.arange(0.0, time[-1], PERIOD / FINE), time, velocity)


def means(values, size):
    return values[: size * FINE].reshape(size, FINE).mean(axis=1)


@pytest.mark.parametrize("place", [VISCOUS, COULOMB, STICTION])
def test_friction_follows_its_static_curve_with_the_lag(place):
    velocity = a_motion()
    fine = finely(velocity)
    sticking = np.exp(-np.abs(fine) / CURVE.stribeck_velocity)
    static = {COULOMB: np.sign(fine) * (1.0 - sticking), STICTION: np.sign(fine) * sticking, VISCOUS: fine}[place]
    lagged, follows = np.zeros(fine.size), math.exp(-PERIOD / FINE / CURVE.lag)
    for k in range(1, fine.size):
        lagged[k] = static[k] + (lagged[k - 1] - static[k]) * follows
    column = columns_along(HYPOTHESIS, CURVE, velocity, PERIOD)[:, place]
    error = column[:-1] - means(lagged, column.size - 1)
    assert math.sqrt(np.mean(error**2)) < 0.01


def test_friction_over_a_path_is_a_solution_of_its_equation():
    velocity = a_motion()
    fine = finely(velocity)
    bent = np.zeros(fine.size)
    for k in range(1, fine.size):
        bent[k] = np.sign(fine[k]) + (bent[k - 1] - np.sign(fine[k])) * math.exp(-abs(fine[k]) * PERIOD / FINE / 0.01)
    column = columns_along(HYPOTHESIS, CURVE, velocity, PERIOD)[:, PATHS]
    error = column[:-1] - means(bent, column.size - 1)
    assert math.sqrt(np.mean(error**2)) < 0.01


@pytest.mark.parametrize(("field", "place"), [("lag", -2), ("stribeck_velocity", -1)])
def test_sensitivities_are_those_of_differences(field, place):
    velocity, step = a_motion(), 1e-4
    moved = CURVE._replace(**{field: getattr(CURVE, field) * math.exp(step)})
    first, second = (columns_along(HYPOTHESIS, curve, velocity, PERIOD) for curve in (CURVE, moved))
    coefficients = np.array([CURVE.coulomb, CURVE.stiction, CURVE.viscous])
    differences = (second - first)[:, [COULOMB, STICTION, VISCOUS]] @ coefficients / step
    np.testing.assert_allclose(first[:, place], differences, atol=2e-3 * np.abs(differences).max())


def test_inertia_and_gravity_are_what_they_say():
    velocity, position = a_motion(), np.linspace(0.0, 3.0, a_motion().size - 1)
    columns = columns_along(HYPOTHESIS, CURVE, velocity, PERIOD, position)
    np.testing.assert_allclose(columns[:, INERTIA], np.diff(velocity) / PERIOD)
    np.testing.assert_allclose(columns[:, PATHS + 1], np.sin(position))
    np.testing.assert_allclose(columns[:, PATHS + 2], np.cos(position))


def test_friction_turns_where_the_motion_is_beyond_zero_by_the_hold():
    velocity = np.linspace(1.0, -1.0, 201)
    columns = columns_along(HYPOTHESIS, CURVE._replace(lag=1e-6, hold=0.2), velocity, PERIOD)
    friction = columns[:, COULOMB] + columns[:, STICTION]
    middle = 0.5 * (velocity[1:] + velocity[:-1])
    np.testing.assert_allclose(friction[middle > -0.2], 1.0, atol=1e-3)
    np.testing.assert_allclose(friction[middle < -0.2], -1.0, atol=1e-3)


def test_a_reversed_motion_reverses_friction_and_inertia():
    velocity = a_motion()
    forward, backward = (columns_along(HYPOTHESIS, CURVE, sign * velocity, PERIOD) for sign in (1.0, -1.0))
    np.testing.assert_allclose(forward[:, : PATHS + 1], -backward[:, : PATHS + 1], atol=1e-12)
