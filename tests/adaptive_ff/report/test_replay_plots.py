"""Pictures of a replay."""

import numpy as np
import pytest
from synthetic_logs import make_log

from adaptive_ff.replay.replay import replay_log
from adaptive_ff.report.replay_plots import elapsed


@pytest.fixture(scope="module")
def replayed():
    return replay_log(make_log(duration=50.0, noise=0.1))  # 25000 samples: two in a bin


def test_pictures_are_written(replayed, tmp_path):
    figures = replayed.plot(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["estimates.png", "replay.png"]
    assert set(figures) == {"replay", "estimates"}


def test_needed_torque_and_each_feedforward_are_drawn(replayed):
    whole, *others = replayed.plot()["replay"].axes
    near, left = others[:2], others[2:]  # fixed and adaptive each
    assert [len(axes.lines) for axes in (whole, *near, *left)] == [1, 2, 2, 1, 1]
    assert left[0].get_ylim() == left[1].get_ylim()
    low, high = replayed.series.needed
    drawn = whole.lines[0].get_ydata()
    assert drawn.min() == pytest.approx(np.nanmin(low))
    assert drawn.max() == pytest.approx(np.nanmax(high))
    assert whole.get_ylabel() == "log: torque that was needed (N m), band 20 Hz; shaded: the close-up"


def test_estimates_are_drawn_with_their_units(replayed):
    panels = replayed.plot()["estimates"].axes
    labels = [axes.get_ylabel() for axes in panels]
    assert labels[0] == "log: inertia (kg m²)"
    assert labels[-1] == "offset (N m)"
    assert panels[1].lines[0].get_ydata()[-1] == pytest.approx(replayed.estimates["adaptive"]["coulomb"])


def test_times_ascend_where_the_clock_does_not():
    time = np.array([5.0, 5.1, 5.2, np.nan, 5.4, 2.0, 2.1, 2.1])
    assert elapsed(time) == pytest.approx([5.0, 5.1, 5.2, 5.3, 5.4, 5.5, 5.6, 5.7])


@pytest.mark.parametrize(("is_linear", "unit"), [(False, "N m"), (True, "N")])
def test_ripples_are_drawn_as_torques(is_linear, unit):
    """As where the fixed model finds one in the log by itself."""
    replayed = replay_log(make_log(noise=0.1), ripple_periods=(0.4,), linear=is_linear)
    labels = [axes.get_ylabel() for axes in replayed.plot()["estimates"].axes]
    assert labels[-2:] == [f"ripple sin 1 ({unit})", f"ripple cos 1 ({unit})"]
