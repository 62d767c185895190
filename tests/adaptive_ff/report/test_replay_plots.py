"""Pictures of a replay."""

import numpy as np
import pytest
from synthetic_logs import make_log

from adaptive_ff.replay.replay import replay_log

pytestmark = pytest.mark.usefixtures("drawn")


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
    drawn = whole.lines[0].get_ydata()
    assert drawn.min() == pytest.approx(np.min(replayed.series.needed))
    assert drawn.max() == pytest.approx(np.max(replayed.series.needed))
    assert whole.get_ylabel() == "torque that was needed (N m), band 20 Hz; shaded: the close-up"


def test_estimates_are_drawn_with_their_units(replayed):
    panels = replayed.plot()["estimates"].axes
    labels = [axes.get_ylabel() for axes in panels]
    assert labels[0] == "inertia (kg m²)"
    assert labels[-1] == "offset (N m)"
    assert labels[2] == "coulomb (N m)"
    assert panels[2].lines[0].get_ydata()[-1] == pytest.approx(replayed.estimates["adaptive"]["coulomb"])


@pytest.mark.parametrize(("is_linear", "unit"), [(False, "N m"), (True, "N")])
def test_ripples_are_drawn_as_torques(is_linear, unit):
    replayed = replay_log(make_log(noise=0.1, duration=10.0), ripple_periods=(0.4,), linear=is_linear)
    labels = [axes.get_ylabel() for axes in replayed.plot()["estimates"].axes]
    assert labels[-3:-1] == [f"ripple sin 1 ({unit})", f"ripple cos 1 ({unit})"]
