import dataclasses
import struct
from time import process_time

import matplotlib
import numpy as np
import pytest

from adaptive_ff import Comparison, InputError, __version__, compare, load_scenario, simulate
from adaptive_ff.friction.model import model_friction
from adaptive_ff.report import style
from adaptive_ff.report.comparison_pictures import PICTURES, plot_comparison, plot_run
from adaptive_ff.report.tables import estimates_table
from plant import sliding_friction

pytestmark = pytest.mark.usefixtures("drawn")

SHORT = load_scenario().modified(duration=16.0)
CHANGED = SHORT.modified(change=[{"time": 4.0, "friction_scale": 0.6}, {"time": 6.0, "friction_scale": 1.5}])
FOUR = ["tracking", "torque", "estimates", "stribeck"]
FIVE = [*FOUR, "supervision"]


@pytest.fixture(scope="module")
def comparison():
    return compare(CHANGED)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("pictures") / "not" / "there yet"


@pytest.fixture(scope="module")
def settings():
    """Settings of matplotlib before anything is drawn."""
    return dict(matplotlib.rcParams)


@pytest.fixture(scope="module")
def figures(comparison, folder, settings):
    return plot_comparison(comparison, folder)


class Proportional:
    """A user's own controller: no estimates, no feedforward."""

    def step(self, reference, velocity, **others):
        return 1500.0 * (reference - velocity)


def still(tmp_path, **tables):
    file = tmp_path / "still.csv"
    file.write_text("time,velocity\n" + "".join(f"{second},0\n" for second in range(21)))
    return SHORT.modified(reference={"kind": "csv", "path": str(file)}, duration=16.0, **tables)


def lines(axes):
    """Lines with a name in the legend, by it."""
    return {line.get_label(): line for line in axes.lines if not line.get_label().startswith("_")}


def legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def png_size(file):
    content = file.read_bytes()
    assert content[:8] == b"\x89PNG\r\n\x1a\n"
    return struct.unpack(">II", content[16:24])


def with_series(run, **series):
    return dataclasses.replace(run, **series)


def test_pictures_are_png_files_of_readable_size_and_nothing_else_is_left(figures, folder):
    assert list(figures) == FIVE
    assert sorted(file.name for file in folder.iterdir()) == sorted(f"{name}.png" for name in FIVE)
    for name, figure in figures.items():
        file = folder / f"{name}.png"
        assert png_size(file) == tuple((150 * figure.get_size_inches()).round())
        assert png_size(file)[0] == 1200
        assert 10_000 < file.stat().st_size < 500_000


def test_every_picture_names_its_scenario_seed_and_version(comparison, figures):
    single = plot_run(comparison.runs["pi"])
    for figure in (*figures.values(), single):
        assert figure.get_supxlabel() == f"built-in scenario, changed, seed 1, adaptive-ff {__version__}"


def test_estimates_stand_in_bands_of_their_uncertainty(comparison, figures):
    run = comparison.runs["adaptive"]
    assert set(run.uncertainties) == set(run.estimates)
    assert 100 <= run.uncertainty_time.size <= 130
    assert "± 2 standard deviations" in legend(figures["estimates"])
    assert comparison.runs["adaptive_paper"].uncertainties == {}
    for axes, name in zip(figures["estimates"].axes, run.estimates, strict=True):
        (band,) = axes.collections
        width = np.ptp(band.get_paths()[0].vertices[:, 1])
        assert width >= 4.0 * np.min(run.uncertainties[name])
        end = run.uncertainties[name][-1]
        assert 0.0 < end < np.max(run.uncertainties[name])


def test_one_controller_that_runs_away_does_not_set_the_limits(comparison):
    paper = comparison.runs["adaptive_paper"]
    wild = {name: 1e6 * np.ones_like(series) for name, series in paper.estimates.items()}
    runs = {**comparison.runs, "adaptive_paper": with_series(paper, estimates=wild)}
    figures = plot_comparison(Comparison(comparison.scenario, runs))
    inertia = figures["estimates"].axes[0]
    assert inertia.get_ylim()[1] < 2.0 * comparison.scenario.joint.inertia
    assert "adaptive_paper reaches 1e+06" in [text.get_text() for text in inertia.texts]


def test_failed_writing_leaves_neither_the_picture_nor_a_part_of_it(comparison, tmp_path, monkeypatch):
    (tmp_path / "tracking.png").write_bytes(b"older")

    def fail(*_):
        raise OSError("disk full")

    monkeypatch.setattr(style.os, "replace", fail)
    with pytest.raises(InputError, match=r"tracking\.png: cannot be written: disk full"):
        plot_comparison(comparison, tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["tracking.png"]
    assert (tmp_path / "tracking.png").read_bytes() == b"older"


def test_writing_leaves_the_figure_as_it_was(comparison, tmp_path):
    figure = plot_run(comparison.runs["adaptive"], tmp_path / "run.png")
    assert type(figure.get_layout_engine()).__name__ == "ConstrainedLayoutEngine"
    figure.savefig(tmp_path / "again.png", dpi=150)
    assert png_size(tmp_path / "again.png") == png_size(tmp_path / "run.png")


def test_drawing_leaves_no_global_state(settings, figures):
    assert dict(matplotlib.rcParams) == settings


def test_error_lines_are_reference_minus_true_velocity_in_the_settled_close_up(comparison, figures):
    error = figures["tracking"].axes[1]
    drawn = lines(error)
    assert list(drawn) == list(comparison.runs)
    for name, run in comparison.runs.items():
        time = np.asarray(drawn[name].get_xdata())
        part = np.searchsorted(run.solver_time, time)
        assert np.array_equal(run.solver_time[part], time)
        assert np.array_equal(np.diff(part), np.ones(time.size - 1))
        np.testing.assert_allclose(drawn[name].get_ydata(), 1e3 * (run.reference - run.velocity)[part], atol=1e-12)
        assert time[0] >= 10.0  # the settled part begins there: 6 s change, 16 s end
        assert time[-1] - time[0] == pytest.approx(5.0, abs=1.01)


def test_tracking_shows_the_reference_the_baseline_and_the_adaptive_controller(comparison, figures):
    drawn = lines(figures["tracking"].axes[0])
    assert list(drawn) == ["reference", "pi", "adaptive"]
    run = comparison.runs["adaptive"]
    part = np.searchsorted(run.solver_time, drawn["adaptive"].get_xdata())
    assert np.array_equal(drawn["adaptive"].get_ydata(), run.velocity[part])
    assert np.array_equal(drawn["reference"].get_ydata(), run.reference[part])


def test_close_up_has_the_most_reversals_of_the_settled_part():
    run = simulate(SHORT.modified(duration=30.0), "pi")
    time = run.solver_time
    turns = np.array([3.0, 3.5, 4.0, 16.0, 22.0, 22.5, 23.0, 29.5])  # most of them before the settled part
    reference = np.where(np.searchsorted(turns, time, side="right") % 2 == 0, 0.1, -0.1)
    figure = plot_comparison(Comparison(run.scenario, {"pi": with_series(run, reference=reference)}))["tracking"]
    low, high = figure.axes[0].get_xlim()
    assert low < 22.0
    assert high > 23.0
    assert high - low == pytest.approx(6.0, abs=0.01)


def test_running_rms_error_is_that_of_the_last_two_seconds(comparison, figures):
    rms = figures["tracking"].axes[2]
    assert rms.get_yscale() == "log"
    assert "over the last 2 s" in rms.get_ylabel()
    for name, run in comparison.runs.items():
        line = lines(rms)[name]
        moments, values = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
        assert moments[-1] == run.solver_time[-1]
        for index in (100, 300, -1):
            last = (run.solver_time > moments[index] - 2.0) & (run.solver_time <= moments[index])
            expected = 1e3 * np.sqrt(np.mean((run.reference - run.velocity)[last] ** 2))
            assert values[index] == pytest.approx(expected, rel=0.03)  # window of whole blocks


def test_changes_of_friction_are_marked(figures):
    for axes in (figures["tracking"].axes[2], *figures["estimates"].axes):
        marks = [line.get_xdata()[0] for line in axes.lines if list(line.get_ydata()) == [0, 1]]
        assert marks == [4.0, 6.0]
    assert "friction changes" in legend(figures["tracking"])


def test_single_change_is_named_in_the_legend():
    scenario = SHORT.modified(controllers=["pi"], change=[{"time": 4.0, "friction_scale": 0.6}])
    assert "friction × 0.6" in legend(plot_comparison(compare(scenario))["tracking"])


def test_true_values_follow_the_changes_and_estimates_are_the_runs(comparison, figures):
    labels = {axes.get_ylabel(): axes for axes in figures["estimates"].axes}
    assert list(labels) == [
        "inertia (kg m²)",
        "coulomb (N m)",
        "stiction (N m)",
        "viscous (N m s/rad)",
        "friction lag (s)",
        "offset (N m)",
        "gravity sin (N m)",
        "gravity cos (N m)",
        "stribeck velocity (rad/s)",
        "presliding (rad)",
    ]
    for label, value, scales in [
        ("inertia (kg m²)", 20.0, (1.0, 1.0, 1.0)),
        ("coulomb (N m)", 60.0, (1.0, 0.6, 1.5)),
        ("stiction (N m)", 90.0, (1.0, 0.6, 1.5)),
        ("viscous (N m s/rad)", 80.0, (1.0, 0.6, 1.5)),
        ("friction lag (s)", 0.02, (1.0, 1.0, 1.0)),
        ("offset (N m)", 0.0, (1.0, 1.0, 1.0)),
    ]:
        true = lines(labels[label])["true"]
        assert true.get_linestyle() == "--"
        assert true.get_drawstyle() == "steps-post"
        np.testing.assert_allclose(true.get_xdata(), [0.0, 4.0, 6.0, 16.0])
        np.testing.assert_allclose(true.get_ydata(), value * np.array([*scales, scales[-1]]))
    drawn = lines(labels["coulomb (N m)"])
    assert set(drawn) == {"true", "adaptive", "adaptive_paper"}
    assert np.array_equal(drawn["adaptive"].get_ydata(), comparison.runs["adaptive"].estimates["coulomb"])


def test_wild_estimates_leave_the_panel_and_are_named(comparison):
    run = comparison.runs["adaptive"]
    wild = {**run.estimates, "coulomb": 1e5 * np.sin(run.time)}
    other = dataclasses.replace(run, name="wild", estimates=wild)
    figure = plot_comparison(Comparison(CHANGED, {"adaptive": run, "wild": other}))["estimates"]
    coulomb = figure.axes[1]
    assert coulomb.get_ylim()[0] > -250.0
    assert 90.0 < coulomb.get_ylim()[1] < 250.0
    assert "wild reaches 100,000" in [text.get_text() for text in coulomb.texts]


def test_friction_curves_are_those_of_the_truth_the_estimates_and_the_fixed_model(comparison, figures):
    (axes,) = figures["stribeck"].axes
    drawn = lines(axes)
    assert set(drawn) == {"true", "fixed", "adaptive", "adaptive_paper"}
    speeds = np.asarray(drawn["true"].get_xdata())
    assert speeds[0] == 0.0
    assert speeds[-1] == pytest.approx(0.35)
    scenario = comparison.scenario
    truth = [1.5 * sliding_friction(scenario.joint.friction, speed) for speed in speeds]
    np.testing.assert_allclose(drawn["true"].get_ydata(), truth, rtol=1e-12)
    fixed = [model_friction(scenario.fixed.model, speed) for speed in speeds]
    np.testing.assert_allclose(drawn["fixed"].get_ydata(), fixed, rtol=1e-12)
    final = comparison.runs["adaptive"].final_estimates
    curve = final["coulomb"] + (final["stiction"] - final["coulomb"]) * np.exp(-speeds / final["stribeck_velocity"])
    np.testing.assert_allclose(drawn["adaptive"].get_ydata(), curve + final["viscous"] * speeds, rtol=1e-12)


def test_torque_and_feedforward_of_the_controllers_that_feed_forward(comparison, figures):
    figure = figures["torque"]
    names = [axes.get_ylabel().removeprefix("torque (N m) with ") for axes in figure.axes]
    assert names == ["fixed", "oracle", "adaptive_paper", "adaptive"]
    for name, axes in zip(names, figure.axes, strict=True):
        run, drawn = comparison.runs[name], lines(axes)
        part = np.searchsorted(run.time, drawn["torque"].get_xdata())
        assert np.array_equal(drawn["torque"].get_ydata(), run.torque[part])
        assert np.array_equal(drawn["feedforward in it"].get_ydata(), run.feedforward[part])
    assert legend(figure) == ["torque", "feedforward in it"]  # 400 N m are far


def test_torque_limit_is_drawn_where_it_is_near():
    scenario = SHORT.modified(actuator={"torque_limit": 100.0}, controllers=["pi", "adaptive"])
    run = simulate(scenario, "adaptive")
    run.torque[-300:] = 100.0
    figure = plot_comparison(Comparison(scenario, {"adaptive": run}))["torque"]
    assert legend(figure)[-1] == "torque limit"
    limits = [line.get_ydata()[0] for line in figure.axes[0].lines if line.get_label() == "torque limit"]
    assert limits == [100.0, -100.0]
    assert figure.axes[0].get_ylim()[1] > 100.0


def test_run_shows_all_of_it_in_three_panels(comparison, tmp_path):
    run = comparison.runs["adaptive"]
    figure = run.plot(tmp_path / "run.png")
    assert png_size(tmp_path / "run.png") == (1200, 900)
    tracking, error, torque = figure.axes
    assert [axes.get_ylabel() for axes in figure.axes] == ["velocity (rad/s)", "error (mrad/s)", "torque (N m)"]
    assert torque.get_xlabel() == "time (s)"
    assert torque.get_xlim() == (0.0, 16.0)
    drawn = lines(error)["adaptive"]
    part = np.searchsorted(run.solver_time, drawn.get_xdata())
    np.testing.assert_allclose(drawn.get_ydata(), 1e3 * (run.reference - run.velocity)[part], atol=1e-12)
    assert {"reference", "adaptive"} <= set(lines(tracking))
    assert np.array_equal(lines(torque)["feedforward in it"].get_ydata(), run.feedforward)


def test_long_series_keep_every_peak_and_their_order():
    run = simulate(SHORT.modified(duration=120.0), "pi")
    velocity = run.reference.copy()
    velocity[[5_003, 77_777, 120_000]] += [0.5, -0.5, 0.25]  # spikes a single step long
    drawn = lines(plot_run(with_series(run, velocity=velocity)).axes[1])["pi"]
    moments, errors = np.asarray(drawn.get_xdata()), np.asarray(drawn.get_ydata())
    assert moments.size < 10_000 < run.solver_time.size
    assert np.all(np.diff(moments) >= 0.0)
    peaks = np.flatnonzero(np.abs(errors) > 1.0)
    np.testing.assert_allclose(errors[peaks], [-500.0, 500.0, -250.0])
    np.testing.assert_allclose(moments[peaks], [5.003, 77.777, 120.0])


def test_drawing_an_hour_sampled_at_1_khz_takes_seconds():
    run = simulate(SHORT, "pi")
    many = 225  # times 16 s
    grid = run.scenario.joint.solver_period * np.arange(many * 16_000 + 1)
    wide = {name: np.tile(getattr(run, name)[:-1], many) for name in ("reference", "velocity")}
    long = with_series(
        run,
        time=grid[:-1],
        solver_time=grid,
        torque=wide["velocity"],
        feedforward=wide["reference"],
        **{name: np.append(series, 0.0) for name, series in wide.items()},
    )
    begin = process_time()
    plot_comparison(Comparison(run.scenario, {"pi": long}))
    assert process_time() - begin < 10.0


def test_own_controllers_have_lines_of_their_own_and_no_estimates(tmp_path):
    scenario = SHORT.modified(duration=6.0, controllers=["pi"])
    own = {name: lambda _: Proportional() for name in ("mine", "_hidden$1", *(f"number {i}" for i in range(20)))}
    figures = plot_comparison(compare(scenario, own=own), tmp_path)
    assert list(figures) == ["tracking", "torque"]
    assert list(lines(figures["tracking"].axes[0])) == ["reference", "pi", "mine", r" _hidden\$1"]
    looks = {(line.get_color(), line.get_linestyle()) for line in figures["tracking"].axes[1].lines[:19]}
    assert len(looks) == 19
    assert len(figures["torque"].axes) == 23  # where none feeds forward, all torques are shown
    assert legend(figures["torque"]) == ["torque"]


def test_estimates_under_other_names_have_a_panel_but_no_truth_and_make_no_friction_curve():
    run = simulate(SHORT, "adaptive")
    slope = np.full(run.time.size, np.nan)
    slope[800:] = 3.0
    figures = plot_comparison(Comparison(SHORT, {"mine": with_series(run, estimates={"friction_slope": slope})}))
    assert list(figures) == ["tracking", "torque", "estimates", "supervision"]
    (axes,) = figures["estimates"].axes
    assert axes.get_ylabel() == "friction slope"
    assert list(lines(axes)) == ["mine"]
    assert axes.get_ylim()[0] <= 0.0
    assert 3.0 < axes.get_ylim()[1] < 4.0


@pytest.mark.parametrize("controllers", [["pi"], ["adaptive"], ["fixed", "oracle"]])
def test_few_controllers(controllers, tmp_path):
    figures = plot_comparison(compare(SHORT.modified(controllers=controllers)), tmp_path)
    assert list(figures) == (FIVE if controllers == ["adaptive"] else FOUR[:2])
    assert set(lines(figures["tracking"].axes[0])) == {"reference", *controllers}


@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_reference_at_rest(noise, tmp_path):
    scenario = still(tmp_path, sensor={"velocity_noise": noise}, controllers=["pi", "fixed", "adaptive"])
    comparison = compare(scenario)
    figures = plot_comparison(comparison, tmp_path / "pictures")
    resting = not any(np.any(run.velocity) for run in comparison.runs.values())
    assert resting or noise > 0.0
    assert figures["tracking"].axes[2].get_yscale() == ("linear" if resting else "log")
    plot_run(comparison.runs["pi"], tmp_path / "run.png")


def test_one_perfect_run_beside_another(comparison):
    run = comparison.runs["pi"]
    perfect = with_series(run, velocity=run.reference)
    rms = plot_comparison(Comparison(CHANGED, {"pi": run, "perfect": perfect}))["tracking"].axes[2]
    assert rms.get_yscale() == "log"
    assert 0.0 < rms.get_ylim()[0] < 1e3 * run.metrics.rms_error_settled < rms.get_ylim()[1]


@pytest.mark.parametrize("duration", [0.01, 4.0])
def test_run_shorter_than_the_close_up_is_shown_whole(duration, tmp_path):
    scenario = SHORT.modified(duration=duration, sampling={"period": 0.001}, controllers=["pi", "adaptive"])
    comparison = compare(scenario)
    figures = plot_comparison(comparison, tmp_path)
    assert figures["tracking"].axes[0].get_xlim() == (0.0, duration)
    assert figures["torque"].axes[0].get_xlim() == (0.0, duration)
    plot_run(comparison.runs["adaptive"], tmp_path / "run.png")


def test_change_shortly_before_the_end_is_marked_in_the_close_up():
    scenario = SHORT.modified(controllers=["pi"], change=[{"time": 15.99, "friction_scale": 0.6}])
    axes = plot_comparison(compare(scenario))["tracking"].axes[0]
    assert axes.get_xlim() == (10.0, 16.0)
    assert [line.get_xdata()[0] for line in axes.lines if list(line.get_ydata()) == [0, 1]] == [15.99]


def test_comparison_without_runs_is_refused():
    with pytest.raises(ValueError, match=r"comparison.runs is empty"):
        plot_comparison(Comparison(SHORT, {}))


def test_pictures_and_tables_of_a_linear_axis_have_its_units():
    linear = SHORT.modified(
        joint={"axis": "linear"},
        duration=3.0,
        controllers=["pi", "adaptive"],
        adaptation={"position_hats": 3, "position_range": [-0.5, 0.5]},
    )
    found = compare(linear)
    figures = {**plot_comparison(found), "run": plot_run(found.runs["adaptive"])}
    assert figures.keys() == {*PICTURES, "run"} == {*FIVE, "friction_map", "run"}
    panels = [axes for figure in figures.values() for axes in figure.axes]
    labels = [label for axes in panels for label in (axes.get_xlabel(), axes.get_ylabel())]
    labels += estimates_table(found).column("parameter")
    assert not [label for label in labels if "rad" in label or "N m" in label or "torque" in label]
    assert any("mm/s" in label for label in labels)
    assert "inertia, kg" in labels


def test_the_table_of_estimates_says_how_far_each_may_be_off():
    found = compare(SHORT.modified(duration=3.0, controllers=["pi", "adaptive_paper", "adaptive"]))
    table = estimates_table(found)
    adaptive = found.runs["adaptive"]
    row = list(adaptive.estimates).index("coulomb")
    spread = 2.0 * adaptive.uncertainties["coulomb"][-1]
    cells = dict(zip(table.heads, table.rows[row], strict=True))
    assert cells["adaptive"] == f"{adaptive.final_estimates['coulomb']:#.4g} ± {spread:.2g}"
    assert "±" not in cells["adaptive_paper"]  # which does not say
    assert str(table.title).endswith("± 2 standard deviations")


def test_the_table_of_estimates_has_truth_and_unit_of_the_stribeck_velocity():
    found = compare(SHORT.modified(duration=3.0, controllers=["adaptive"]))
    names, true = (estimates_table(found).column(name) for name in ("parameter", "true"))
    assert dict(zip(names, true, strict=True))["stribeck_velocity, rad/s"] == f"{SHORT.joint.stribeck_velocity:#.4g}"
    assert names[-1] == "presliding, rad"
