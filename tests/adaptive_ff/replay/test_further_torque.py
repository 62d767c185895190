"""Gravity, ripples and saturating friction of a replay's fixed model, against fine sums."""

import numpy as np
import pytest

from adaptive_ff.replay.further_torque import FurtherTorque, Ripple
from adaptive_ff.replay.watching import Seen

PERIOD = 0.01


def seen(size=400):
    time = PERIOD * np.arange(size + 1)
    reference = np.sin(2.0 * time)
    position = 0.5 * (1.0 - np.cos(2.0 * time))
    nothing = np.full(size, np.nan)
    return Seen(reference[:-1], reference[1:], position[:-1], nothing, np.full(size, PERIOD), nothing), time


def test_gravity_is_that_at_the_middle_of_the_period():
    given, time = seen()
    torque, lagged = FurtherTorque(sine=2.0, cosine=-1.0).along(given._replace(position=given.measurement), PERIOD, 0.0)
    middle = 0.5 * (1.0 - np.cos(2.0 * (time[:-1] + 0.5 * PERIOD)))
    assert torque == pytest.approx(2.0 * np.sin(middle) - np.cos(middle), abs=1e-4)
    assert lagged == 0.0
    without, _ = FurtherTorque(sine=2.0).along(given, PERIOD, 0.0)
    assert not np.any(without)


def test_a_ripple_is_a_gravity_of_another_period():
    given, _ = seen()
    given = given._replace(position=given.measurement)
    model = FurtherTorque(ripples=(Ripple(2.0 * np.pi, 2.0, -1.0), Ripple(0.4, 0.5, 0.0)))
    gravity, _ = FurtherTorque(sine=2.0, cosine=-1.0).along(given, PERIOD, 0.0)
    torque, _ = model.along(given, PERIOD, 0.0)
    middle = given.position + 0.25 * PERIOD * (given.reference + given.coming)
    assert torque - gravity == pytest.approx(0.5 * np.sin(2.0 * np.pi * middle / 0.4), abs=1e-12)
    assert not np.any(model.along(seen()[0], PERIOD, 0.0)[0])
    assert not model.has_gravity
    assert "a ripple of 2.24 every 6.28 and a ripple of 0.5 every 0.4, too" in model.sentence()


def test_saturating_friction_lags_and_goes_on_from_part_to_part():
    given, time = seen()
    model = FurtherTorque(shape="saturation", size=3.0, bend=0.3, lag=0.04)
    torque, _ = model.along(given, PERIOD, 0.0)
    fine = np.arange(0.0, time[-1], PERIOD / 100)
    friction, value = [], 0.0
    for static in 3.0 * np.tanh(np.sin(2.0 * fine) / 0.3):
        value += PERIOD / 100 / 0.04 * (static - value)
        friction.append(value)
    mean = np.array(friction).reshape(-1, 100).mean(axis=1)
    assert torque == pytest.approx(mean, abs=0.03)
    halves, state = [], 0.0
    for part in (slice(0, 150), slice(150, 400)):
        half, state = model.along(Seen(*(series[part] for series in given)), PERIOD, state)
        halves.append(half)
    assert np.concatenate(halves) == pytest.approx(torque, abs=1e-12)


def test_the_sentence_has_one_sign_between_sine_and_cosine():
    assert "gravity of 2 sin q - 0.5 cos q" in FurtherTorque(sine=2.0, cosine=-0.5).sentence()
    assert "gravity of -2 sin q + 0.5 cos q" in FurtherTorque(sine=-2.0, cosine=0.5).sentence()
