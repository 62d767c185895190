"""Intervals of friction that saturates, where the log hardly tells how far it has."""

import numpy as np
import pytest

from adaptive_ff.identify.fitting.fit import fit_terms
from adaptive_ff.identify.fitting.grid import BLOCKS, make_grid
from adaptive_ff.identify.fitting.grid_fit import fit_on_grid
from adaptive_ff.identify.fitting.shape_profile import profile_interval, shape_profiles
from adaptive_ff.identify.preparation import prepare, regression_problem
from adaptive_ff.identify.terms import SATURATIONS
from adaptive_ff.logs.log import Log

TERMS = ("inertia", "coulomb", "viscous", "offset", "long_saturation")


@pytest.fixture(scope="module")
def fitted():
    """A long tail: friction still bends at the largest speed."""
    time = np.arange(0.0, 30.0, 0.004)
    omegas = 2.0 * np.pi * np.array([[0.13], [0.29], [0.71]])
    velocity = np.sum(np.sin(omegas * time), axis=0)
    acceleration = np.sum(omegas * np.cos(omegas * time), axis=0)
    position = -np.sum(np.cos(omegas * time) / omegas, axis=0)
    noise = 0.02 * np.random.default_rng(101).standard_normal(time.size)
    torque = 0.5 * acceleration + 2.0 * np.sign(velocity) + 1.5 * velocity
    torque += 1.0 * velocity / (0.5 + np.abs(velocity)) + noise
    prepared = prepare(Log("log", time, torque, position=position))
    problem = regression_problem(prepared, prepared.pieces, 0.0)
    grid = make_grid(problem)
    start = fit_on_grid(grid, TERMS, np.ones(BLOCKS, dtype=bool), np.zeros(BLOCKS, dtype=bool))
    found = fit_terms(problem, TERMS, 0.95, start={"long_saturation_velocity": start.speed})
    return grid, found


def test_interval_holds_the_truth_and_that_of_the_fit_at_its_bend(fitted):
    grid, found = fitted
    profiles = shape_profiles(grid, TERMS)
    assert len(profiles) == len(SATURATIONS)
    for name, true in (("coulomb", 2.0), ("viscous", 1.5), ("inertia", 0.5)):
        lower, upper = profile_interval(grid, profiles, found, name, 0.95)
        assert lower < true < upper, name
        assert lower < found.values[name] < upper, name


def test_more_confidence_widens_it_and_a_further_shape_never_narrows_it(fitted):
    grid, found = fitted
    profiles = shape_profiles(grid, TERMS)
    usual, wider = (profile_interval(grid, profiles, found, "viscous", level) for level in (0.95, 0.999))
    assert wider[0] < usual[0] < usual[1] < wider[1]
    own = SATURATIONS.index("long_saturation")
    alone = [
        profile if place == own else profile._replace(squares=np.full_like(profile.squares, np.inf))
        for place, profile in enumerate(profiles)
    ]
    single = profile_interval(grid, alone, found, "viscous", 0.95)
    least = min(float(np.min(profile.squares)) for profile in profiles)
    if least == float(np.min(profiles[own].squares)):
        assert usual[0] <= single[0] < single[1] <= usual[1]


def test_shapes_are_compared_with_the_largest_inflation_and_at_least_one(fitted):
    grid, found = fitted
    profiles, names = shape_profiles(grid, TERMS), found.regression.names
    ends = []
    for bend, other in ((0.1, 0.1), (1.0, 1.0), (0.1, 9.0), (9.0, 0.1)):
        inflation = np.full(len(names), other)
        inflation[names.index("long_saturation_velocity")] = bend
        ends.append(profile_interval(grid, profiles, found._replace(inflation=inflation), "viscous", 0.95))
    assert ends[0] == ends[1]
    assert ends[2] == ends[3]
    assert ends[2][0] < ends[1][0] < ends[1][1] < ends[2][1]


def test_profile_at_the_best_bend_is_the_fit(fitted):
    grid, found = fitted
    profile = shape_profiles(grid, TERMS)[SATURATIONS.index("long_saturation")]
    place = int(np.argmin(np.abs(np.log(grid.speeds["long_saturation"] / found.values["long_saturation_velocity"]))))
    assert profile.values["inertia"][place] == pytest.approx(found.values["inertia"], rel=0.01)
    assert profile.values["coulomb"][place] == pytest.approx(found.values["coulomb"], rel=0.1)
