"""Pictures of an identified log: what is in them."""

import numpy as np
import pytest
from synthetic_logs import make_log, sines_log

from adaptive_ff.identify.identification import identify_log
from adaptive_ff.logs.log import Log
from adaptive_ff.report import identification_plots

NAMES = [name for name in identification_plots.PICTURES if name != "identified_map"]


@pytest.fixture(scope="module")
def found():
    log = make_log(noise=0.1)
    log.torque[5000:5200] = np.nan
    log.time[9000:] -= 5.0
    return identify_log(log)


@pytest.fixture(scope="module")
def figures(found):
    return found.plot()


def lines_of(axes):
    return [line for line in axes.get_lines() if line.get_xdata().size > 2]


def test_pictures_are_written(found, tmp_path):
    assert list(found.plot(tmp_path / "new")) == NAMES
    for name in NAMES:
        assert (tmp_path / "new" / f"{name}.png").read_bytes().startswith(b"\x89PNG")


def test_torque_is_shown_measured_and_identified_with_times_that_ascend(found, figures):
    whole, near, left = figures["identified_torque"].axes
    pieces = [*found.rows, *found.held_out]
    lines = lines_of(whole)
    assert len(lines) == 2 * len(pieces)
    starts = [line.get_xdata()[0] for line in lines[::2]]
    assert np.all(np.diff(starts) > 0.0)  # though the clock of the log jumps back
    for rows, measured, model in zip(pieces, lines[::2], lines[1::2], strict=True):
        assert np.array_equal(measured.get_ydata(), rows.torque)
        assert np.array_equal(model.get_ydata()[rows.slides], rows.fitted[rows.slides])
        assert np.all(np.isnan(model.get_ydata()[~rows.slides]))
    low, high = near.get_xlim()
    assert high - low < 0.1 * (whole.get_xlim()[1] - whole.get_xlim()[0])
    assert left.get_xlabel() == "time (s)"


def test_close_up_of_short_pieces_far_apart_is_in_one_of_them():
    log = make_log(noise=0.1)
    pieces = np.minimum(np.arange(log.time.size) // 1200, 9)
    log.time[:] += 100.0 * pieces
    found = identify_log(log)
    (_, near, _) = found.plot()["identified_torque"].axes
    low, high = near.get_xlim()
    (ends,) = [(rows.time[0], rows.time[-1]) for rows in found.rows if rows.time[0] <= low <= rows.time[-1]]
    assert ends[0] <= low < high <= ends[1]
    assert high - low < 0.1 * log.time.size * found.period


def test_friction_curve_is_the_identified_one(found, figures):
    curve = figures["friction"].axes[0]
    backward, forward = (line for line in curve.get_lines() if line.get_xdata().size == 400)
    values = found.selection.chosen.values
    velocity = np.concatenate([rows.velocity[rows.slides] for rows in found.rows])
    for line, side, farthest in ((backward, -1.0, np.min(velocity)), (forward, 1.0, np.max(velocity))):
        expected = values["offset"] + side * values["coulomb"] + values["viscous"] * line.get_xdata()
        assert line.get_ydata() == pytest.approx(expected)
        assert line.get_xdata()[-1] == pytest.approx(farthest, rel=1e-12)


def test_friction_of_a_joint_that_moves_one_way_has_one_branch_over_its_velocities():
    time = 0.005 * np.arange(8000)
    velocity = 1.0 + 0.5 * np.sin(2.0 * np.pi * 0.5 * time)
    torque = 2.0 * np.gradient(velocity, time) + 6.0 + 3.0 * velocity
    torque += np.random.default_rng(2).standard_normal(time.size)
    curve = identify_log(Log("log", time, torque, velocity=velocity)).plot()["friction"].axes[0]
    (forward,) = (line for line in curve.get_lines() if line.get_xdata().size == 400)
    assert forward.get_xdata()[[0, -1]] == pytest.approx([0.5, 1.5], abs=0.01)
    low, high = curve.get_ylim()
    assert low < np.min(forward.get_ydata()) < np.max(forward.get_ydata()) < high


def test_friction_that_leaves_its_panel_is_named_above_it(found, figures, monkeypatch):
    assert [text.get_text() for text in figures["friction"].axes[0].texts] == [""]
    monkeypatch.setattr(identification_plots, "_curve", lambda _, speeds, side: side * (1.0 + 1e3 * (speeds < 0.01)))
    texts = found.plot()["friction"].axes[0].texts
    assert [text.get_text() for text in texts] == ["the identified curve reaches 1,001"]


def test_residual_is_shown_over_the_velocity(found, figures):
    points = figures["friction"].axes[1].get_lines()[0]
    residual = np.concatenate([(rows.torque - rows.fitted)[rows.slides] for rows in found.rows])
    assert np.array_equal(points.get_ydata(), residual)


def test_lag_is_shown_with_its_interval(found, figures):
    (axes,) = figures["lag"].axes
    profile = axes.get_lines()[0]
    assert np.array_equal(profile.get_xdata(), 1e3 * found.lags)
    assert np.min(profile.get_ydata()) == pytest.approx(100.0 * found.fit.relative_error, rel=0.05)
    (span,) = axes.patches
    estimate = found.parameters["friction_lag"].estimate
    assert span.get_x() == pytest.approx(1e3 * estimate.lower)
    assert span.get_width() == pytest.approx(1e3 * (estimate.upper - estimate.lower))


def test_gravity_is_not_drawn_as_friction():
    """Of a weight of 8 N m rows of 3 N m of friction were drawn from -5 to 12 N m."""
    log, _ = sines_log(lambda q, w: 3.0 * np.sign(w) + 8.0 * np.sin(q))
    found = identify_log(log)
    assert "gravity_sine" in found.selection.chosen.terms
    axes = found.plot()["friction"].axes[0]
    assert "what depends on the position" in axes.get_ylabel()
    rows = next(line for line in axes.get_lines() if line.get_xdata().size > 1000)
    speeds, torques = rows.get_xdata(), rows.get_ydata()
    assert np.allclose(torques, 3.0 * np.sign(speeds) + 0.5 * speeds, atol=0.3)
