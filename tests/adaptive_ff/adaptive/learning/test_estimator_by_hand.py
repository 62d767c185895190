"""The estimator beside a second one, written with matrices and without kernels, on random signals."""

import math

import numpy as np
import pytest

from adaptive_ff import AdaptiveController
from adaptive_ff.adaptive.learning import change_detection as changes
from adaptive_ff.adaptive.learning import estimator as kernels
from adaptive_ff.adaptive.learning.change_detection import NO_ALARM, Surprise, attribute_change, note_surprise
from adaptive_ff.adaptive.learning.estimator_state import Levels, initial_estimator_state, load_count
from adaptive_ff.adaptive.learning.forgetting import FIRST_ERRORS, LARGEST_FACTOR, LEAST_FACTOR, SUDDEN, forget_in_place
from adaptive_ff.estimation.instruments import AGREEMENT, EXCITED
from adaptive_ff.friction.model import ESTIMATED, PER_DIRECTION_WITH_GRAVITY, WITH_GRAVITY, WITH_OFFSET
from adaptive_ff.learning.torque_form import Signals

PERIOD = 0.01
TRUTH = np.array([23.0, 50.0, 80.0, 70.0, 0.03, 6.0, 8.0, 9.0])
LOADS = np.array([12.0, -7.0, 5.0])
BRISTLES = 30.0
"""Micro-damping of the candidate in use, N m."""


def parameters(names, regressors=0):
    controller = AdaptiveController(
        1256.6,
        15791.4,
        PERIOD,
        inertia=20.0,
        stribeck_velocity=0.05,
        memory=1.8,
        parameters=names,
        regressors=regressors,
    )
    return controller.parameters.estimator


def truth(estimator):
    size = estimator.first.size - load_count(estimator)
    return np.concatenate([TRUTH[:size], LOADS[: load_count(estimator)]])


def columns(estimator, signals, loads, ratio, factor=1.0):
    """Regressors of the equation: acceleration's derivative, then one for each parameter, then slopes of the loads.

    The inertia is so many times the estimated one, and so is friction.
    """
    pole, filters = estimator.form.pole, signals.filters
    second = pole**2 * (signals.velocity - filters[1, 0]) - 2.0 * pole * filters[1, 1]
    friction, asymmetry = factor * np.append(filters[2:4, 0], filters[1, 0]), factor * filters[4:, 0]
    plain = [ratio * second, ratio * filters[1, 1], *friction, -filters[0, 1], 1.0, *asymmetry]
    size = estimator.first.size - loads.shape[0]
    return np.concatenate([plain[: size + 1], loads[:, 0], loads[:, 1]])


def predicted(estimate, row):
    """The equation, term by term."""
    loads = row.size - estimate.size - 1
    size = estimate.size - loads
    inertia, lag = estimate[0], estimate[4]
    torque = inertia * (row[1] + lag * row[0]) + estimate[1:4] @ row[2:5] + lag * row[5]
    torque += estimate[5:size] @ row[6 : size + 1]
    return torque + estimate[size:] @ (row[size + 1 : size + 1 + loads] + lag * row[size + 1 + loads :])


def gradient(estimator, estimate, row):
    """The equation is linear in each parameter alone, so a difference is the derivative."""
    moved = [predicted(estimate + step, row) - predicted(estimate, row) for step in np.diag(np.ones(estimate.size))]
    return np.array(moved) * estimator.scale / estimator.torque_scale


def draw(estimator, rng, direction, factor, load, noise, speed=1.0, known=1.0):
    """Measured and modelled signals of a joint whose friction is so many times what it was, and loads.

    Another factor on friction is known, of the position.
    """
    count = 6 if estimator.first.size - load_count(estimator) > 6 else 4
    shape = np.array([[40.0, 300.0], [0.2, 1.0], [0.6, 3.0], [0.4, 3.0], [0.4, 3.0], [0.2, 1.0]])[:count]
    drawn = shape * rng.uniform(0.3, 1.0, shape.shape) * rng.choice([-1.0, 1.0], shape.shape)
    model = Signals(drawn, 0.0, np.zeros((2, 2)))
    model.filters[1:4, 0] = direction * np.abs(model.filters[1:4, 0])
    model.filters[4:] = np.abs(model.filters[4:])
    bent = np.array([[0.0, 0.0], [rng.uniform(-0.1, 0.1), 0.0]])
    model = model._replace(velocity=model.filters[1, 0] + 0.01 * rng.standard_normal(), bent=bent)
    loads = rng.uniform(-1.0, 1.0, (load_count(estimator), 3))
    measured = model._replace(filters=model.filters * (1.0 + noise * rng.standard_normal(shape.shape)))
    measured.filters[1] *= speed
    there = truth(estimator).copy()
    there[1:4] *= factor
    there[5:8] *= factor
    if estimator.first.size - load_count(estimator) > 5:
        there[5] += load
    for signals in (measured, model):
        signals.filters[0, 0] = predicted(there, columns(estimator, signals, loads, 1.0, known))
        signals.filters[0, 0] += BRISTLES * signals.bent[1, 0]
    measured.filters[0, 0] += rng.standard_normal()
    return measured, model, loads


class Twin:
    """The estimator with matrices."""

    def __init__(self, estimator):
        self.estimator = estimator
        state = initial_estimator_state(estimator)
        self.estimate, self.information = estimator.first.copy(), state.recursion.information.copy()
        self.agreement = np.zeros((self.estimate.size, 2))
        self.levels, self.surprise, self.alarm = state.levels, Surprise(0.0, 0.0, 0.0), NO_ALARM
        self.forgotten = 0

    def learn(self, measured, model, loads, duration, ratio, factor):
        estimator = self.estimator
        row = columns(estimator, measured, loads, ratio, factor)
        z = gradient(estimator, self.estimate, columns(estimator, model, loads, ratio, factor))
        x = gradient(estimator, self.estimate, row)
        keep = math.exp(-duration / estimator.memory)
        squared_error, peak, speed, learnt, stuck = self.levels
        if learnt > kernels.PEAK_MEMORIES * estimator.memory:
            fading = 1.0 - (1.0 - keep) / kernels.PEAK_MEMORIES
            peak, speed = fading * peak, fading * speed
        speed = max(speed, abs(model.filters[1, 0]))
        if abs(measured.filters[1, 0]) >= kernels.SPEED_FACTOR * speed:
            self.levels = Levels(squared_error, peak, speed, learnt, stuck)
            return
        torque = measured.filters[0, 0]
        peak, learnt = max(peak, abs(torque)), learnt + duration
        torque -= BRISTLES * measured.bent[1, 0]
        largest = kernels.PEAK_FACTOR * peak
        floor = min(kernels.FLOOR * squared_error + kernels.SMALLEST_FLOOR, kernels.LARGEST_FLOOR)
        unit = estimator.torque_scale
        error = np.clip((torque - predicted(self.estimate, row)) / unit, -largest / unit, largest / unit)
        friction = self.friction() @ row[1 : self.estimate.size + 1] / unit
        window = changes.JUMP_WINDOW / estimator.form.pole
        self.surprise = note_surprise(self.surprise, friction, error, duration, window)
        usual = changes.JUMP * (squared_error + changes.LEAST_ERROR)
        product, square, _ = self.surprise
        there = np.where(np.isin(np.arange(x.size), (0, 4)), 0.0, x)  # inertia and lag are not what is in doubt
        doubt = there @ np.linalg.solve(self.information, there) * window / estimator.memory
        larger = 1.0 + doubt if self.alarm.cause == changes.NOTHING else 1.0
        noticed = learnt > estimator.memory and product**2 / square > usual * larger
        squared, followed = error**2, False
        if self.estimate.size - load_count(estimator) > 5:
            longest = changes.LONGEST_WAIT * estimator.memory
            self.alarm = attribute_change(self.alarm, noticed, self.surprise, friction, window, longest, duration)
            followed = noticed and changes.is_decided(self.alarm)
            if followed and self.alarm.cause == changes.FRICTION:
                self.follow(self.alarm.product / square)
                error = (torque - predicted(self.estimate, row)) / unit
                squared = error**2
            if followed and self.alarm.cause == changes.LOAD:
                error = self.surprise.error
            elif self.alarm.cause == changes.NOTHING and learnt > estimator.memory:
                first = FIRST_ERRORS * math.sqrt(usual / changes.JUMP)
                error = np.clip(error, -first, first)
            if self.alarm.cause == changes.UNDECIDED:
                self.levels = Levels(squared_error, peak, speed, learnt, stuck)
                return
        instrument = self.instrument(z, x, 1.0 if self.alarm.cause == changes.LOAD else keep, floor)
        if noticed:
            squared = min(squared, usual)
            self.forget(window / estimator.memory)
        self.levels = Levels(keep * squared_error + (1.0 - keep) * squared, peak, speed, learnt, stuck)
        self.information = keep * self.information + (1.0 - keep) * (
            np.outer(instrument, instrument) + floor * np.eye(instrument.size)
        )
        step = (1.0 - keep) * error * np.linalg.solve(self.information, instrument)
        if self.alarm.cause == changes.LOAD:
            size = step.size - load_count(estimator)
            step[[i for i in range(size) if i != 5]] = 0.0
            if followed:
                if step @ x * error > 0.0:
                    step *= error / (step @ x)
                self.surprise = Surprise(0.0, square, 0.0)
        self.correct(step, largest, speed)

    def instrument(self, z, x, keep, floor):
        self.agreement = keep * self.agreement + (1.0 - keep) * np.column_stack([z * z, z * x])
        power, common = self.agreement.T
        if np.any((common < AGREEMENT[0] * power - floor) | (common > AGREEMENT[1] * power + floor)):
            return x
        return np.where(power < EXCITED * floor, 0.0, z)

    def friction(self):
        """The parameters of friction, the others zero."""
        size = self.estimate.size - load_count(self.estimator)
        places = [1, 2, 3, *range(6, size)]
        only = np.zeros(self.estimate.size)
        only[places] = self.estimate[places]
        return only

    def follow(self, change):
        """What the short window says of friction holds at once."""
        factor = np.clip(1.0 + change, LEAST_FACTOR, LARGEST_FACTOR)
        self.estimate += (factor - 1.0) * self.friction()

    def forget(self, share):
        estimator, cause = self.estimator, self.alarm.cause
        if cause != changes.LOAD:
            self.release(self.friction() / estimator.scale, share * self.surprise.friction_squared)
        if cause in (changes.LOAD, changes.EITHER) and self.estimate.size - load_count(estimator) > 5:
            unit = np.zeros(self.estimate.size)
            unit[5] = 1.0
            share *= SUDDEN if cause == changes.LOAD else 1.0
            self.release(unit, share * (estimator.scale[5] / estimator.torque_scale) ** 2)

    def release(self, direction, known):
        """What a large variance along the direction makes of the covariance, until so much is known."""
        total = direction @ self.information @ direction
        if total > known:
            self.forgotten += 1
            covariance = np.linalg.inv(self.information) + (1.0 / known - 1.0 / total) * np.outer(direction, direction)
            self.information = np.linalg.inv(covariance)

    def correct(self, step, peak, speed):
        """Move each parameter that would leave its range back, the others where the quadratic form is least."""
        size, scale = self.estimate.size - load_count(self.estimator), self.estimator.scale
        inertia, lag = self.estimator.ranges[0], self.estimator.ranges[4]
        low = np.array([inertia[0], 0.0, 0.0, 0.0, lag[0], -peak, -peak, -peak / speed][:size] + [-peak] * LOADS.size)
        high = np.array([inertia[1], peak, peak, peak / speed, lag[1], peak, peak, peak / speed][:size])
        high = np.concatenate([high, [peak] * LOADS.size])[: self.estimate.size]
        low = low[: self.estimate.size]
        covariance = np.linalg.inv(self.information)
        for i in range(self.estimate.size):
            value = self.estimate[i] + step[i] * scale[i]
            possible = np.clip(value, low[i], high[i])
            step = step + (possible - value) / scale[i] * covariance[:, i] / covariance[i, i]
        self.estimate = np.clip(self.estimate + step * scale, low, high)


def course(estimator, seed, stroke=1):
    """Samples: learning, friction and load that change, errors of sensors, a time that varies.

    The direction is drawn for each sample, or turns with each stroke of so many.
    """
    rng = np.random.default_rng(seed)
    for k in range(800 if stroke == 1 else 1300):
        factor = 1.0 if k < 200 else 2.5 if k < 400 else 0.7
        load = 60.0 if 500 <= k < 600 else 300.0 if k >= 1000 else 0.0
        speed = 40.0 if rng.uniform() < 0.01 else 1.0
        noise = 2.0 if 700 <= k < 750 else 0.02
        direction = rng.choice([-1.0, 1.0]) if stroke == 1 else (-1.0) ** (k // stroke)
        known = rng.uniform(0.8, 1.2)
        drawn = draw(estimator, rng, direction, factor, load, noise, speed, known)
        yield *drawn, rng.uniform(0.5, 1.5) * PERIOD, rng.uniform(0.8, 1.2), known


@pytest.mark.parametrize(
    ("names", "regressors", "stroke"),
    [
        *((ESTIMATED, 0, stroke) for stroke in (1, 30)),
        (ESTIMATED, 1, 1),
        *((WITH_OFFSET, 0, stroke) for stroke in (1, 30)),
        *((WITH_GRAVITY, 0, stroke) for stroke in (1, 30)),
        *((PER_DIRECTION_WITH_GRAVITY, 1, stroke) for stroke in (1, 30)),
    ],
)
def test_estimator_is_the_one_with_matrices(names, regressors, stroke):
    estimator = parameters(names, regressors)
    state, twin = initial_estimator_state(estimator), Twin(estimator)
    causes, first = set(), True
    state.candidates.estimates[:, -1] = BRISTLES
    for measured, model, loads, duration, ratio, factor in course(estimator, 201, stroke):
        state.loads[:] = loads
        state = kernels.learn_in_place(estimator, state, measured, model, duration, ratio, factor)
        twin.learn(measured, model, loads, duration, ratio, factor)
        causes.add(state.alarm.cause)
        if first:  # before rounding has grown
            assert state.recursion.information == pytest.approx(twin.information, rel=1e-13, abs=1e-15)
            first = False
        assert np.allclose(state.recursion.estimate, twin.estimate, rtol=1e-5, atol=1e-6)
        assert np.allclose(state.levels, twin.levels, rtol=1e-6, atol=0.0)
        assert state.alarm.cause == twin.alarm.cause
    assert state.recursion.information == pytest.approx(twin.information, rel=1e-4, abs=1e-7)
    assert twin.forgotten > 0 or load_count(estimator) > 0
    assert names != WITH_OFFSET or changes.UNDECIDED in causes
    assert (names, stroke) != (WITH_OFFSET, 30) or {changes.LOAD, changes.FRICTION} <= causes


@pytest.mark.parametrize("cause", [changes.NOTHING, changes.FRICTION, changes.LOAD, changes.EITHER])
@pytest.mark.parametrize("names", [ESTIMATED, WITH_OFFSET, PER_DIRECTION_WITH_GRAVITY])
def test_what_a_change_is_attributed_to_is_forgotten(names, cause):
    estimator = parameters(names)
    rng, twin = np.random.default_rng(301), Twin(estimator)
    rows = rng.standard_normal((3 * twin.estimate.size, twin.estimate.size))
    twin.estimate, twin.information = truth(estimator), 50.0 * rows.T @ rows
    twin.surprise, twin.alarm = Surprise(0.0, 0.3, 0.0), NO_ALARM._replace(cause=cause)
    recursion = initial_estimator_state(estimator).recursion
    recursion.estimate[:], recursion.information[:] = twin.estimate, twin.information
    forget_in_place(estimator, recursion, 0.3, twin.alarm, 0.1)
    twin.forget(0.1)
    assert recursion.information == pytest.approx(twin.information, rel=1e-8, abs=1e-9)
    assert twin.forgotten == {changes.LOAD: 0, changes.EITHER: 1}.get(cause, 1) + (
        names != ESTIMATED and cause in (changes.LOAD, changes.EITHER)
    )


@pytest.mark.parametrize(
    ("direction", "size", "cause", "change"),
    [
        (1.0, 1.5, changes.NOTHING, True),
        (1.0, 0.9, changes.NOTHING, False),
        (-1.0, 1.5, changes.NOTHING, False),
        (-1.0, 500.0, changes.NOTHING, True),
        (-1.0, 1.5, changes.UNDECIDED, True),
    ],
)
def test_first_motion_the_other_way_is_no_change(direction, size, cause, change):
    """It shows how offset and Coulomb friction share the torque, so errors beyond the usual ones are to be expected."""
    estimator, rng = parameters(WITH_OFFSET), np.random.default_rng(401)
    # one way only: Coulomb friction (1) and offset (5) are one column; the others vary
    rows = rng.standard_normal((500, 6))
    rows[:, [1, 5]] = 1.0
    state = initial_estimator_state(estimator)
    state.recursion.information[:] = rows.T @ rows / len(rows) + 1e-3 * np.eye(6)
    state.scratch.measured_gradient[:] = rows[0] * [1.0, direction, 1.0, 1.0, 1.0, 1.0]
    surprise, state = Surprise(math.sqrt(size), 1.0, 0.0), state._replace(alarm=NO_ALARM._replace(cause=cause))
    assert kernels.is_change(estimator, state, surprise, 1.0, 0.1 * estimator.memory) == change
