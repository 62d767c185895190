"""Unit torques along a motion, against matrix exponentials of their equations and differences of those."""

import itertools
import math

import numpy as np
import pytest
from scipy.linalg import expm

from adaptive_ff.friction import columns as module
from adaptive_ff.friction.columns import Curve, Hypothesis, column_count, hold, is_friction, write_columns

PERIOD = 0.01
CURVE = Curve(lag=0.02, stribeck_velocity=0.05, coulomb=60.0, stiction=90.0, viscous=80.0, hold=0.006)
WAVES, MAPPED = np.array([1.0, 7.0]), np.array([3.0, 5.0])
EVERY = Hypothesis(1.5, np.array([2e-4, 3e-3]), True, WAVES, MAPPED, 4, -0.2, 0.3, True, 2, -2.0)
WAVE = 0.08 * np.sin(0.55 * np.arange(1, 24))
MOTION = np.concatenate([[0.0, 0.0], WAVE, [0.0] * 4, -0.4 * WAVE[:4], [-0.02, 0.001, 0.004, 0.004]])
RESTS = 2 + WAVE.size + 1  # period from which on friction is held
PERIODS = np.array([*itertools.pairwise(MOTION), (0.03, 0.05), (-0.05, -0.02), (-0.02, 0.04)])  # it leaps at the end


def behind_lag(value, first, last, lag, duration):
    """Integral and end of what follows a ramp with a lag, by the exponential of the linear system."""
    rates = [[0.0, 1.0, 0.0, 0.0], [0.0, -1.0 / lag, 1.0 / lag, 0.0], [0.0, 0.0, 0.0, 1.0], [0.0] * 4]
    return (expm(duration * np.array(rates)) @ [0.0, value, first, (last - first) / duration])[:2]


def known_means(curve, periods, held):
    """Means over each period of slip, stiction, lagged speed and bent parts, and the direction after it."""
    lagged, bent, direction, holding, rows = np.zeros(3), np.zeros(EVERY.distances.size), 0.0, 0.0, []
    for k, (start, end) in enumerate(periods):
        if k == RESTS:
            holding, bent[:] = held, held
        direction = direction or np.sign(start + end)
        rests, total = start == end == 0.0, np.zeros(3 + bent.size)
        if not rests:
            lagged[1], holding = lagged[1] + holding, 0.0
        turn = (start + direction * curve.hold) / (start - end) if start != end else 0.0
        cuts = [0.0, *([turn] if 0.0 < turn < 1.0 else []), 1.0]
        total[2], lagged[2] = behind_lag(lagged[2], start, end, curve.lag, PERIOD)
        for first, last in itertools.pairwise(cuts):
            duration, ends = (last - first) * PERIOD, start + np.array([first, last]) * (end - start)
            if direction * ends.mean() < -curve.hold:
                direction = -direction
            sticks = np.exp(-((np.abs(ends) / curve.stribeck_velocity) ** EVERY.shape))
            sign = 0.0 if rests else direction
            for i, static in enumerate((sign * (1.0 - sticks), sign * sticks)):
                integral, lagged[i] = behind_lag(lagged[i], *static, curve.lag, duration)
                total[i] += integral
            early = abs(ends[0] + ends.mean()) / 2.0 * duration / 2.0
            total[3:] += duration * (sign + (bent - sign) * np.exp(-early / EVERY.distances))
            bent = sign + (bent - sign) * np.exp(-abs(ends.mean()) * duration / EVERY.distances)
        total[1] += holding * PERIOD
        rows.append([*total / PERIOD, direction])
    return np.array(rows).T


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_every_column_is_the_mean_of_its_equation(sign):
    """Through rests, one with friction that is held, reversals, and creeping that does not turn friction."""
    held, periods = sign * 0.4, sign * PERIODS
    state, psi, rows = module.initial_friction_state(EVERY), np.zeros(column_count(EVERY)), []
    generator, count = np.random.default_rng(1), len(periods)
    position, load, regressors = generator.uniform(-3.0, 3.0, count), generator.normal(size=count), [0.3, -0.7]
    position[5] = math.nan
    for k, ends in enumerate(periods):
        state = hold(state, held) if k == RESTS else state
        state = write_columns(EVERY, state, CURVE, *ends, PERIOD, position[k], load[k], np.array(regressors), psi)
        rows.append(psi.copy())
    slip, stick, speed, *bent, direction = known_means(CURVE, periods, held)

    def by_logarithm(name):
        ends = []
        for factor in (math.exp(1e-4), math.exp(-1e-4)):
            moved = known_means(CURVE._replace(**{name: getattr(CURVE, name) * factor}), periods, held)
            ends.append(np.array([60.0, 90.0, 80.0]) @ moved[:3])
        return (ends[0] - ends[1]) / 2e-4

    q = position / EVERY.gear_ratio
    waves = [part(wave * q) for wave in WAVES for part in (np.sin, np.cos)]
    friction, places = slip + stick, EVERY.lowest + EVERY.spacing * np.arange(-1, EVERY.hats + 1)
    hats = [np.interp(q, places, one) for one in np.eye(places.size)[1:-1]]
    mapped = [friction * part(wave * q) for wave in MAPPED for part in (np.sin, np.cos)]
    mapped += [friction * one for one in hats]
    expected = [np.diff(periods)[:, 0] / PERIOD, speed, slip, stick, *bent, direction * stick, np.abs(speed), *waves]
    expected += [*mapped, friction * np.abs(load), *np.outer(regressors, np.ones(count))]
    expected += [by_logarithm("lag"), by_logarithm("stribeck_velocity")]
    known = np.nan_to_num(np.array(expected).T)  # without a position nothing depends on it
    sizes = np.abs(known).max(axis=0)
    np.testing.assert_allclose(rows / sizes, known / sizes, atol=1e-6)


def named_columns(hypothesis):
    """Columns along a motion by name, in their order, and whether each is friction."""
    parts = {"inertia": 1, "viscous": 1, "slip": 1, "stick": 1, "path": hypothesis.distances.size}
    parts |= {"asymmetry": 2 * hypothesis.directions, "wave": 2 * hypothesis.waves.size}
    parts |= {"map": 2 * hypothesis.map_waves.size, "hat": hypothesis.hats, "load": int(hypothesis.over_load)}
    parts |= {"regressor": hypothesis.regressors, "lag": 1, "stribeck": 1}
    names = [f"{part} {number}" for part, size in parts.items() for number in range(size)]
    position = np.where(np.arange(MOTION.size - 1) == 4, math.nan, np.linspace(-1.0, 3.0, MOTION.size - 1))
    columns = module.columns_along(hypothesis, CURVE, MOTION, PERIOD, position, np.cos(position))
    assert columns.shape == (position.size, column_count(hypothesis))
    other = ("inertia", "wave", "regressor", "lag", "stribeck")
    assert [is_friction(hypothesis, place) for place in range(len(names))] == [not n.startswith(other) for n in names]
    return dict(zip(names, columns.T, strict=True))


FEWER = {"distances": EVERY.distances[:1], "directions": False, "waves": np.zeros(0), "map_waves": MAPPED[:1]}
FEWER |= {"hats": 0, "over_load": False, "regressors": 0}


@pytest.mark.parametrize("left_out", [*itertools.combinations(FEWER, 1), tuple(FEWER)], ids=str)
def test_columns_do_not_depend_on_what_else_is_learnt(left_out):
    whole = named_columns(EVERY)
    assert all(np.any(column != 0.0) for name, column in whole.items() if "regressor" not in name)
    for name, column in named_columns(EVERY._replace(**{name: FEWER[name] for name in left_out})).items():
        np.testing.assert_array_equal(column, whole[name], name)
