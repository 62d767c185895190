"""Pictures of comparisons and of sweeps: what is in them."""

from dataclasses import fields, replace
from time import process_time
from unittest.mock import Mock

import matplotlib
import numpy as np
import pytest
from matplotlib.image import imread

from adaptive_ff import Comparison, InputError, __version__, compare, load_scenario, simulate
from adaptive_ff.friction.model import model_friction
from adaptive_ff.report.comparison_pictures import changes_of, plot_comparison, plot_run
from adaptive_ff.report.study_pictures import plot_sweep
from adaptive_ff.simulation.metrics import Metrics
from adaptive_ff.studies.sweep import Outcome
from plant import sliding_friction

pytestmark = pytest.mark.usefixtures("drawn")

SHORT = load_scenario().modified(duration=16.0)
CHANGED = SHORT.modified(change=[{"time": 4.0, "friction_scale": 0.6}, {"time": 6.0, "friction_scale": 1.5}])
FIVE = ["tracking", "torque", "estimates", "stribeck", "supervision"]


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


def lines(axes):
    """Lines with a name in the legend, by it."""
    return {line.get_label(): line for line in axes.lines if not line.get_label().startswith("_")}


def test_pictures_are_png_files_of_readable_size_and_nothing_else_is_left(settings, figures, folder):
    assert dict(matplotlib.rcParams) == settings
    assert list(figures) == FIVE
    assert sorted(file.name for file in folder.iterdir()) == sorted(f"{name}.png" for name in FIVE)
    for name, figure in figures.items():
        file = folder / f"{name}.png"
        height, width, _ = imread(file, format="png").shape
        assert (width, height) == tuple((150 * figure.get_size_inches()).round())
        assert width == 1200
        assert 10_000 < file.stat().st_size < 500_000


def test_every_picture_names_its_scenario_seed_and_version(comparison, figures):
    single = plot_run(comparison.runs["pi"])
    for figure in (*figures.values(), single):
        assert figure.get_supxlabel() == f"built-in scenario, changed, seed 1, adaptive-ff {__version__}"


@pytest.mark.parametrize(("axis", "unit"), [("rotary", "N m"), ("linear", "N")])
def test_a_change_of_the_load_has_the_unit_of_its_axis(axis, unit):
    scenario = SHORT.modified(joint={"axis": axis}, change=[{"time": 4.0, "load": 3.0}])
    assert [look["label"] for look in changes_of(scenario)[1]] == [f"load 3 {unit}"]


def test_without_runs_it_is_refused_and_failed_writing_leaves_no_part_of_a_picture(tmp_path, monkeypatch):
    with pytest.raises(ValueError, match=r"comparison.runs is empty"):
        plot_comparison(Comparison(SHORT, {}))
    (tmp_path / "tracking.png").write_bytes(b"older")
    monkeypatch.setattr("os.replace", Mock(side_effect=OSError("disk full")))
    with pytest.raises(InputError, match=r"tracking\.png: cannot be written: disk full"):
        plot_comparison(compare(SHORT.modified(duration=1.0, controllers=["pi"])), tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["tracking.png"]
    assert (tmp_path / "tracking.png").read_bytes() == b"older"


def test_errors_are_drawn_in_the_settled_close_up_and_as_the_rms_of_the_last_two_seconds(comparison, figures):
    _, error, rms = figures["tracking"].axes
    assert rms.get_yscale() == "log"
    assert "over the last 2 s" in rms.get_ylabel()
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
        line = lines(rms)[name]
        moments, values = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
        assert moments[-1] == run.solver_time[-1]
        for index in (100, 300, -1):
            last = (run.solver_time > moments[index] - 2.0) & (run.solver_time <= moments[index])
            expected = 1e3 * np.sqrt(np.mean((run.reference - run.velocity)[last] ** 2))
            assert values[index] == pytest.approx(expected, rel=0.03)  # window of whole blocks


def test_close_up_has_the_most_reversals_of_the_settled_part():
    run = simulate(SHORT.modified(duration=30.0), "pi")
    time = run.solver_time
    turns = np.array([3.0, 3.5, 4.0, 16.0, 22.0, 22.5, 23.0, 29.5])  # most of them before the settled part
    reference = np.where(np.searchsorted(turns, time, side="right") % 2 == 0, 0.1, -0.1)
    figure = plot_comparison(Comparison(run.scenario, {"pi": replace(run, reference=reference)}))["tracking"]
    low, high = figure.axes[0].get_xlim()
    assert low < 22.0
    assert high > 23.0
    assert high - low == pytest.approx(6.0, abs=0.01)


def test_wild_estimates_leave_the_panel_and_are_named(comparison):
    """Those of the paper's controller, which has no bounds, and those of any other."""
    run, paper = comparison.runs["adaptive"], comparison.runs["adaptive_paper"]
    far = {name: 1e6 * np.ones_like(series) for name, series in paper.estimates.items()}
    wild = replace(run, name="wild", estimates={**run.estimates, "coulomb": 1e5 * np.sin(run.time)})
    runs = {"adaptive": run, "wild": wild, "adaptive_paper": replace(paper, estimates=far)}
    inertia, coulomb, *_ = plot_comparison(Comparison(CHANGED, runs))["estimates"].axes
    assert inertia.get_ylim()[1] < 2.0 * CHANGED.joint.inertia
    assert "adaptive_paper reaches 1e+06" in [text.get_text() for text in inertia.texts]
    assert coulomb.get_ylim()[0] > -250.0
    assert 90.0 < coulomb.get_ylim()[1] < 250.0
    assert "wild reaches 100,000, adaptive_paper reaches 1e+06" in [text.get_text() for text in coulomb.texts]


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


def test_long_series_keep_every_peak_and_their_order():
    run = simulate(SHORT.modified(duration=120.0), "pi")
    velocity = run.reference.copy()
    velocity[[5_003, 77_777, 120_000]] += [0.5, -0.5, 0.25]  # spikes a single step long
    drawn = lines(plot_run(replace(run, velocity=velocity)).axes[1])["pi"]
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
    series = {name: np.append(one, 0.0) for name, one in wide.items()} | {"time": grid[:-1], "solver_time": grid}
    long = replace(run, torque=wide["velocity"], feedforward=wide["reference"], **series)
    begin = process_time()
    plot_comparison(Comparison(run.scenario, {"pi": long}))
    assert process_time() - begin < 10.0


def test_one_perfect_run_beside_another(comparison):
    run = comparison.runs["pi"]
    perfect = replace(run, velocity=run.reference)
    rms = plot_comparison(Comparison(CHANGED, {"pi": run, "perfect": perfect}))["tracking"].axes[2]
    assert rms.get_yscale() == "log"
    assert 0.0 < rms.get_ylim()[0] < 1e3 * run.metrics.rms_error_settled < rms.get_ylim()[1]


def outcome(draw, adaptive, **own):
    """An outcome in which errors of pi are one."""
    errors, count = {"pi": 1.0, "adaptive": adaptive, **own}, len(fields(Metrics))
    return Outcome(draw, {name: Metrics(*[error] * count) for name, error in errors.items()}, fall=draw)


def test_distributions_and_worst_cases_of_a_sweep_are_drawn():
    outcomes = [outcome(draw, 0.1 * draw, mine=1.0) for draw in (3, 1, 2)] + [Outcome(9, {}, "refused")]
    figure = plot_sweep(outcomes, "around joint.toml, seed 7", 2)
    settled, whole, cases = figure.axes
    drawn = {line.get_color(): np.unique(line.get_xdata()) for line in whole.lines if len(line.get_xdata()) > 2}
    assert drawn["#d55e00"] == pytest.approx([1.0 / 0.3, 1.0 / 0.2, 1.0 / 0.1])
    assert np.unique(settled.lines[0].get_xdata()) == pytest.approx([1.0 / 0.3, 1.0 / 0.2, 1.0 / 0.1])
    assert {text.get_text(): text.xy[0] for text in cases.texts} == {"1": 3, "2": 2}
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert legend[:2] == ["adaptive", "mine"]
    assert "around joint.toml, seed 7, adaptive-ff" in figure.get_supxlabel()
    figure.draw_without_rendering()
    assert settled.get_tightbbox().y0 - cases.get_tightbbox().y1 > 15.0  # between the texts, pixels
