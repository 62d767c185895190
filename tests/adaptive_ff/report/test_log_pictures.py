"""Pictures and words of an identified log and of a replay: what is in them."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_logs import make_log, sines_log

from adaptive_ff.identify.identification import identify_log
from adaptive_ff.replay.replay import replay_log
from adaptive_ff.report.log_pictures import PICTURES
from adaptive_ff.report.log_words import map_table, next_step, parameters_table

pytestmark = pytest.mark.usefixtures("drawn")

NAMES = [name for name in PICTURES if name != "identified_map"]


@pytest.fixture(scope="module")
def found():
    log = make_log(noise=0.1, period=0.005)
    log.torque[2000:2080] = np.nan
    return identify_log(log)


@pytest.fixture(scope="module")
def refined():
    log, _ = sines_log(lambda q, w: np.sign(w) * (0.8 + 0.6 * np.exp(-np.abs(w) / 0.3)) + 8.0 * np.sin(q))
    return identify_log(log)


def test_pictures_are_written_and_torque_is_shown_measured_and_identified(found, tmp_path):
    figures = found.plot(tmp_path / "new")
    assert list(figures) == NAMES
    for name in NAMES:
        assert (tmp_path / "new" / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    whole, near, left = figures["identified_torque"].axes
    measured, model = whole.get_lines()
    assert np.nanmax(measured.get_ydata()) == np.max(found.data.torque)
    assert np.nanmax(np.abs(left.get_lines()[0].get_ydata())) < 0.2 * np.max(found.data.torque)
    for line in (measured, model):
        assert np.any(np.isnan(line.get_ydata()))  # across the gap there is none
    low, high = near.get_xlim()
    assert high - low < 0.1 * (whole.get_xlim()[1] - whole.get_xlim()[0])


def test_nothing_leaves_the_picture_however_long_the_name_of_the_log_is(found):
    log = replace(found.data.log, name=f"/{'measurements/' * 30}log.csv")
    for figure in replace(found, data=found.data._replace(log=log)).plot().values():
        figure.draw_without_rendering()
        words = [figure._supxlabel, *figure.legends, *(axes.yaxis.label for axes in figure.axes)]
        boxes = [one.get_window_extent() for one in words]
        assert min(box.x0 for box in boxes) >= 0.0
        assert max(box.x1 for box in boxes) <= figure.bbox.width


@pytest.mark.parametrize("which", ["found", "refined"])
def test_friction_curve_is_the_identified_one(which, request):
    identified = request.getfixturevalue(which)
    drawn = identified.plot()["friction"].axes[0].get_lines()
    lines = [line for line in drawn if line.get_xdata().size == 400]
    assert len(lines) == (4 if which == "refined" else 2)  # with the textbook's beside it
    for line in (lines[0], lines[-2 if which == "refined" else -1]):
        assert line.get_ydata() == pytest.approx(identified.friction(line.get_xdata()))
    if which == "refined":  # gravity is not drawn as friction
        rows = next(line for line in drawn if line.get_xdata().size > 400)
        speeds, torques = rows.get_xdata(), rows.get_ydata()
        expected = np.sign(speeds) * (0.8 + 0.6 * np.exp(-np.abs(speeds) / 0.3)) + 0.5 * speeds
        moving = np.abs(speeds) > 0.3
        assert np.allclose(torques[moving], expected[moving], atol=0.2)


def test_a_point_of_the_friction_curve_is_of_one_direction(found):
    points = found.friction_points(bins=31)
    assert np.sum(points["count"]) > 0.9 * found.data.velocity.size
    assert np.all(np.abs(points["torque"]) > 0.8 * found.friction(np.abs(points["velocity"])))


def test_table_holds_textbook_and_refined(found, refined):
    plain = parameters_table(found)
    assert plain.heads == ("", "textbook", "unit")
    both = parameters_table(refined)
    assert both.heads == ("", "textbook", "refined", "unit")
    rows = {row[0]: row[1:3] for row in both.rows}
    assert rows["stiction − coulomb"][0] == ""
    assert float(rows["coulomb"][1].split(" ± ")[0]) == pytest.approx(0.8, rel=0.05)
    assert map_table(found) is None


def test_what_is_given_and_the_next_step_are_named(found):
    assert found.to_dict()["given"] == ["stiction", "friction_lag", "stribeck_velocity"]
    assert found.to_dict()["identified"] == list(found.parameters)
    scenario = "Next: adaptive-ff compare out/scenario.toml"
    assert next_step(found, "out", written=True, simulated=True) == f"{scenario}."
    assert next_step(found, "out", written=True, simulated=False).startswith(f"{scenario}, or --write mjcf")
    one_way = replace(found, unidentified={"coulomb": "one_way"})
    assert next_step(one_way, "out", written=False, simulated=False) == "Next: record again as said above."


def test_map_is_drawn_where_there_is_one(tmp_path):
    turn = 2.0 * np.pi / 15.0
    log, _ = sines_log(lambda q, w: np.sign(w) * (0.8 + 0.3 * np.sin(2.0 * np.pi * q / turn)), seconds=15)
    found = identify_log(log, position_periods=(turn,))
    assert set(found.plot(tmp_path)) == set(PICTURES)
    assert len(map_table(found).rows) == 2


def test_needed_torque_each_feedforward_and_estimates_of_a_replay_are_drawn(tmp_path):
    replayed = replay_log(make_log(duration=50.0, noise=0.1))  # 25000 samples: two in a bin
    figures = replayed.plot(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["estimates.png", "replay.png"]
    assert set(figures) == {"replay", "estimates"}
    whole, *others = figures["replay"].axes
    near, left = others[:2], others[2:]  # fixed and adaptive each
    assert [len(axes.lines) for axes in (whole, *near, *left)] == [1, 2, 2, 1, 1]
    assert left[0].get_ylim() == left[1].get_ylim()
    drawn = whole.lines[0].get_ydata()
    assert drawn.min() == pytest.approx(np.min(replayed.series.needed))
    assert drawn.max() == pytest.approx(np.max(replayed.series.needed))
    assert whole.get_ylabel() == "torque that was needed (N m), band 20 Hz; shaded: the close-up"
    panels = figures["estimates"].axes
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
