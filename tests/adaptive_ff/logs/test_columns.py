"""Columns of the regression: lag and delay against scipy and closed forms, the grid of Stribeck velocities."""

import numpy as np
import pytest
from scipy import signal
from synthetic_logs import make_log, motion

from adaptive_ff.identify.fitting.fit import correlation_length
from adaptive_ff.identify.preparation import prepare, split
from adaptive_ff.identify.rows.filtering import condition
from adaptive_ff.identify.rows.regressors import piece_columns
from adaptive_ff.logs.defects import Piece
from adaptive_ff.logs.derivatives import lowpass
from adaptive_ff.logs.log import Log

MIDDLE = slice(100, -100)


@pytest.fixture(scope="module")
def piece():
    prepared = prepare(make_log(), 10.0)
    return condition(prepared.log, prepared.pieces[0], 10.0, prepared.period, prepared.rest), prepared.rest


def test_rows_of_a_smooth_motion_are_its_own_velocity_and_acceleration(piece):
    rows = piece[0]
    _, velocity, acceleration = motion(rows.time)
    assert rows.velocity == pytest.approx(velocity, abs=2e-3)
    assert rows.acceleration[MIDDLE] == pytest.approx(acceleration[MIDDLE], abs=2e-3)
    assert rows.period == pytest.approx(0.02)


def test_lag_is_that_of_a_first_order_system(piece):
    rows, rest = piece
    lagged = piece_columns(rows, rest.speeds, ["viscous"], {"friction_lag": 0.03})[:, 0]
    fine = np.linspace(rows.time[0], rows.time[-1], 20 * rows.time.size)
    _, velocity, _ = motion(fine)
    expected = signal.lsim(([1.0], [0.03, 1.0]), velocity, fine - fine[0])[1]
    assert lagged[MIDDLE] == pytest.approx(np.interp(rows.time, fine, expected)[MIDDLE], abs=2e-3)


def test_negative_lag_undoes_a_positive_one_on_the_reversed_record(piece):
    rows, rest = piece
    between = {"coulomb": rows.between["coulomb"][::-1]}
    backward = rows._replace(direction=rows.direction[::-1], between=between)
    lead = piece_columns(rows, rest.speeds, ["coulomb"], {"friction_lag": -0.03})[:, 0]
    lag = piece_columns(backward, rest.speeds, ["coulomb"], {"friction_lag": 0.03})[::-1, 0]
    assert lead == pytest.approx(lag, abs=1e-9)


def test_lag_does_not_touch_inertia_and_offset(piece):
    rows, rest = piece
    columns = piece_columns(rows, rest.speeds, ["inertia", "offset"], {"friction_lag": 0.03})
    assert np.array_equal(columns[:, 0], rows.acceleration)
    assert np.all(columns[:, 1] == 1.0)


def test_torque_that_acts_later_is_shifted():
    log = make_log()
    log = Log("log", log.time, motion(log.time)[1], position=log.position)
    prepared = prepare(log, 10.0)
    arguments = log, prepared.pieces[0], 10.0, prepared.period, prepared.rest
    rows, late = condition(*arguments), condition(*arguments, 0.007)
    assert late.torque[MIDDLE] == pytest.approx(motion(rows.time - 0.007)[1][MIDDLE], abs=2e-3)
    assert late.moving_torque == pytest.approx(late.torque)
    assert np.array_equal(late.velocity, rows.velocity)


def test_column_of_stiction_is_interpolated_between_stribeck_velocities(piece):
    rows, rest = piece
    log = make_log()
    _, velocity, _ = motion(log.time)
    speeds = rest.speeds["stiction_excess"]
    between = float(np.sqrt(speeds[7] * speeds[8]))
    exact = lowpass(np.sign(velocity) * np.exp(-np.abs(velocity) / between), (49.0, 10.0), 0.002)
    column = piece_columns(rows, rest.speeds, ["stiction_excess"], {"stribeck_velocity": between})[:, 0]
    at_rows = np.interp(rows.time, log.time, exact)
    assert column == pytest.approx(at_rows, abs=0.01 * np.max(np.abs(exact)))
    for place in (0, 7, 15):
        column = piece_columns(rows, rest.speeds, ["stiction_excess"], {"stribeck_velocity": speeds[place]})
        assert column[:, 0] == pytest.approx(rows.bent["stiction_excess"][place], abs=1e-9)


def test_rest_is_left_out_with_what_the_filters_smear():
    time = 0.002 * np.arange(15000)
    moving = (time < 10.0) | (time > 16.0)
    velocity = np.where(moving, np.sin(2.0 * np.pi * 0.5 * time), 0.0)
    log = make_log()
    log = type(log)("log", time, np.sin(time), velocity=velocity)
    prepared = prepare(log, 10.0)
    rows = condition(log, prepared.pieces[0], 10.0, prepared.period, prepared.rest)
    near = (rows.time > 10.0 - 0.07) & (rows.time < 16.0 + 0.07)  # three quarters of a cycle
    assert not np.any(rows.slides[near])
    assert np.all(rows.slides[(rows.time < 9.9) | (rows.time > 16.1)])
    assert np.all(rows.rests[(rows.time > 10.1) & (rows.time < 15.9)])
    assert not np.any(rows.rests & rows.slides)


@pytest.mark.parametrize("share", [0.0, 0.25, 0.6, 0.999])
def test_split_keeps_the_order_and_every_sample(share):
    pieces = [Piece(0, 100), Piece(120, 150), Piece(150, 400)]
    first, second = split(pieces, share)
    joined = [place for piece in [*first, *second] for place in range(piece.start, piece.stop)]
    assert joined == [place for piece in pieces for place in range(piece.start, piece.stop)]
    assert sum(piece.size for piece in second) == round(share * 380)


def test_correlation_length_grows_with_correlation():
    generator = np.random.default_rng(101)
    white = generator.standard_normal(2000)
    related = signal.lfilter([1.0], [1.0, -0.9], white)
    assert correlation_length(white) <= 6
    assert correlation_length(related) == pytest.approx(2.0 * 1.1447 * (4 * 0.81 * 2000 / 0.19**2) ** (1 / 3), rel=0.15)
    assert correlation_length(np.zeros(100)) == 0
