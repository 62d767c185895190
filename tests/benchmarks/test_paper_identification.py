"""The experiments of the paper on identification, and the command that runs them."""

import itertools
import json
import math

import numpy as np
import pytest
from matplotlib.figure import Figure
from stepped_joint import FRICTION
from typer import Typer
from typer.testing import CliRunner

from adaptive_ff.friction.model import ESTIMATED, TorqueModel
from adaptive_ff.learning.batch import identify_series
from adaptive_ff.learning.rls import RLSState
from adaptive_ff.learning.series import series_coefficients
from adaptive_ff.simulation.metrics import rms
from benchmarks.cases.reports import Row
from benchmarks.paper import __main__ as command
from benchmarks.paper import estimators, misprints, offline, online, reversal, rounding
from benchmarks.paper.estimators import series
from benchmarks.paper.experiment import Experiment, deviations
from benchmarks.paper.records import MORE_SEEDS, PERIOD, SEED, TRUE, predict, simulate_noise
from plant import Joint, JointModel

SEEDS = range(1, 6)


@pytest.fixture(scope="module")
def data():
    return simulate_noise(SEED)


@pytest.fixture(scope="module")
def found(data):
    return offline.identify_all(data)


@pytest.fixture(scope="module")
def worst():
    """Largest deviation of each parameter over some seeds, %."""
    return offline.worst_deviations(SEEDS)


@pytest.fixture(scope="module")
def online_run(data):
    return online.identify_online(data)


def test_data_are_those_of_the_issue(data):
    assert data.time[-1] == pytest.approx(60.0)
    assert np.diff(data.time) == pytest.approx(0.01)
    assert rms(data.acting[1:]) == pytest.approx(1.5 * 90.0, rel=1e-12)
    power = np.abs(np.fft.rfft(data.acting[1:])) ** 2
    frequency = np.fft.rfftfreq(6000, 0.01)
    assert np.sum(power[frequency < 2.0]) > 0.7 * np.sum(power)
    slope = np.polyfit(np.log(frequency[300:1200]), np.log(power[300:1200]), 1)[0]  # 5 to 20 Hz: second order
    assert slope == pytest.approx(-4.0, abs=0.6)
    assert set(MORE_SEEDS).isdisjoint(range(101, 1000))  # where settings were chosen


def test_data_are_those_of_the_joint_under_the_held_torque_also_every_millisecond(data):
    joint = Joint(JointModel(inertia=20.0, **FRICTION, friction_lag=0.02))
    expected = [0.0, *(joint.step(torque, PERIOD) for torque in data.commanded[:300])]
    assert data.velocity[:301] == pytest.approx(expected, rel=1e-12, abs=1e-15)
    assert np.array_equal(data.acting[1:], data.commanded[:-1])
    fine = data.every(0.001)
    assert np.array_equal(fine.velocity[::10], data.velocity)
    assert np.array_equal(fine.acting[10::10], data.acting[1:])
    assert np.array_equal(fine.acting[1:11], np.repeat(data.commanded[0], 10))


TARGETS = {offline.SLIDING: (10.0, 10.0, 10.0, 10.0, 30.0), offline.FILTERED: (2.0, 1.0, 3.0, 1.0, 15.0)}
TARGETS[offline.FINE] = (1.0, 1.0, 1.0, 1.0, 1.0)


@pytest.mark.parametrize(("way", "limits"), TARGETS.items())
@pytest.mark.parametrize("place", range(5), ids=ESTIMATED)
def test_targets_of_figure_4(worst, way, limits, place):
    assert worst[way][ESTIMATED[place]] <= limits[place]
    assert offline.LIMITS[way][ESTIMATED[place]] == limits[place]


def test_all_samples_and_the_commanded_torque_mislead_and_the_torque_form_predicts_far_better(data, found):
    of_series = rms(estimators.series_one_step(found[offline.SHIFTED].regression.values, data.velocity, data.acting))
    form = rms(predict(found[offline.FILTERED].model, data, one_step=True) - data.velocity)
    assert form < 0.2 * of_series
    off = {name: deviations(way.model) for name, way in found.items()}  # %
    assert off[offline.SHIFTED]["stiction"] < -15.0
    assert off[offline.PLAIN]["friction_lag"] < -50.0
    assert off[offline.SLIDING_PLAIN]["friction_lag"] < -50.0
    assert off[offline.SLIDING_PLAIN]["stiction"] < -5.0
    assert abs(off[offline.SLIDING]["stiction"]) < 1.0


def test_the_lag_that_series_finds_comes_nearer_with_the_sampling_period(data):
    errors = []
    for period in (0.01, 0.005, 0.002):
        record = data.every(period)
        found = series(record.velocity, record.acting, sliding=True, period=period)
        errors.append(abs(deviations(found.model)["friction_lag"]))
    assert errors[0] > 1.5 * errors[1] > 2.0 * errors[2]


def test_the_true_model_predicts_its_own_data_exactly(data):
    for one_step in (True, False):
        assert np.array_equal(predict(TRUE, data, one_step=one_step), data.velocity)
    wrong = TRUE._replace(viscous=90.0)
    one_step, free = (rms(predict(wrong, data, one_step=one) - data.velocity) for one in (True, False))
    assert 0.0 < one_step < free


def test_free_run_of_the_series_follows_its_own_recursion(data, found):
    torque, coefficients = data.acting[:60], found[offline.SLIDING].regression.values
    expected = list(data.velocity[:2])
    for k in range(2, 60):
        last = expected[-1]
        share = math.exp(-abs(last) / 0.05)
        terms = (last, -expected[-2], torque[k], -torque[k - 1], -np.sign(last) * (1 - share), -np.sign(last) * share)
        expected.append(float(np.dot(terms, coefficients)))
    free = estimators.series_free_run(coefficients, data.velocity[:60], torque)
    assert free == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_rls_without_forgetting_is_least_squares_with_a_prior_that_fades_as_its_covariance_grows(data):
    rows, outputs = estimators.regression(data.velocity, data.acting)
    plain = identify_series(data.velocity, data.acting, PERIOD, stribeck_velocity=0.05).regression.values
    scale, distances = np.linalg.norm(rows, axis=0), []
    for covariance in (1e2, 1e4, 1e6, 1e8):
        found = estimators.run_rls(rows, outputs, 1.0, covariance)[0][-1]
        augmented = np.vstack([rows, np.eye(6) / math.sqrt(covariance)]) / scale
        expected = np.linalg.lstsq(augmented, np.append(outputs, np.zeros(6)))[0] / scale
        assert found == pytest.approx(expected, rel=1e-9)
        distances.append(online.largest_difference(found, plain))
    for nearer, farther in itertools.pairwise(reversed(distances)):
        assert nearer < 0.02 * farther


@pytest.mark.parametrize("seed", SEEDS)
def test_target_of_figure_5(seed):
    ratio, form = online.online_ratios(online.identify_online(simulate_noise(seed)))
    assert 0.01 < ratio <= 0.2
    assert form < 0.2 * ratio


def test_online_estimates_end_where_offline_ones_do(data, found, online_run):
    last = estimators.model_of(estimators.physical_series(online_run.series.coefficients[-1:], PERIOD)[0])
    assert last == pytest.approx(found[offline.SHIFTED].model, rel=1e-4)
    assert max(map(abs, deviations(online_run.form.estimates[-1]).values())) < 5.0
    assert rms(online_run.series.errors["last"][400:]) > 5.0 * rms(online_run.series.errors["prior"][400:])


@pytest.mark.parametrize("form", rounding.FORMS)
def test_every_form_of_the_recursion_is_13_word_for_word(form):
    rng = np.random.default_rng(3)
    estimate, covariance = rng.standard_normal(6), np.diag(rng.uniform(1.0, 9.0, 6))
    expected, matrix = estimate.copy(), covariance.copy()
    state = RLSState(estimate, covariance, np.zeros(6))
    for _ in range(50):
        row, output = rng.standard_normal(6), rng.standard_normal()
        error = output - row @ expected
        gain = matrix @ row / (row @ matrix @ row + 0.97)  # (12)
        expected = expected + gain * error  # (11)
        matrix = (np.eye(6) - np.outer(gain, row)) @ matrix / 0.97  # (13)
        assert rounding.update_rls(form, state, row, output, 0.97) == pytest.approx(error, rel=1e-9)
    assert estimate == pytest.approx(expected, rel=1e-9)
    assert covariance == pytest.approx(matrix, rel=1e-9, abs=1e-12)
    assert np.array_equal(covariance, covariance.T) is (form == rounding.SYMMETRIC)


def test_rounding_harms_only_the_form_that_saves_a_product_and_without_excitation_every_form_winds_up():
    long = simulate_noise(SEED, duration=120.0)
    rows, outputs = estimators.regression(long.velocity, long.acting)
    histories = {form: rounding.watch(form, rows, outputs, 1e4) for form in rounding.FORMS}
    assert 0.0 < np.max(histories[rounding.PRINTED].asymmetry) < 1e-9
    assert np.max(histories[rounding.SYMMETRIC].asymmetry) == 0.0
    for form in (rounding.PRINTED, rounding.SYMMETRIC):
        assert math.isinf(histories[form].indefinite())
    economical = histories[rounding.ECONOMICAL]
    assert economical.indefinite() < 100.0
    assert math.log(rounding.growth_per_sample(economical)) == pytest.approx(-math.log(0.99), rel=0.2)
    assert rms(economical.errors) > 5.0 * rms(histories[rounding.SYMMETRIC].errors)
    steady = rounding.steady_motion()
    assert max(rounding.watch(form, *steady, 1e4).indefinite() for form in rounding.FORMS) < 60.0


def test_fraction_of_the_error_on_reversals_grows_with_their_speed_its_size_does_not(found):
    coefficients = found[offline.SLIDING].regression.values
    records = (simulate_noise(SEED, duration=100.0, corner=corner) for corner in (0.5, 2.0, 8.0))
    measured = [reversal.measure(record, coefficients) for record in records]
    for slower, faster in itertools.pairwise(measured):
        assert slower.speed < faster.speed
        assert slower.fractions["reversal"] < faster.fractions["reversal"]
        assert slower.fractions["rest"] > faster.fractions["rest"]
    for each in measured:
        assert sum(each.fractions.values()) == pytest.approx(1.0)
        assert each.sizes["reversal"] == pytest.approx(reversal.old_sign_error(), rel=0.5)
        assert each.form < 0.2 * each.sizes["reversal"]


def test_kinds_of_samples():
    kinds = reversal.kinds_of(np.array([3.0, 2.0, -1.0, -2.0, -3.0, 0.0, 0.0, 2.0, 3.0, 4.0]))
    names = [next(name for name, kind in kinds.items() if kind[k]) for k in range(8)]
    assert names == ["reversal", "next", "sliding", "rest", "rest", "rest", "rest", "sliding"]


@pytest.mark.parametrize("reading", misprints.READINGS)
def test_each_reading_of_the_coefficients_inverts_its_own_formulae(reading):
    for model, period in ((TRUE, 0.01), (TorqueModel(3.0, 5.0, 9.0, 2.0, 0.1, 0.05, 1.0), 0.022)):
        coefficients = np.array(misprints.coefficients_of(model, period, reading))
        joint = {name: getattr(model, name) for name in ESTIMATED}
        assert misprints.joint_of_reading(coefficients, period, reading) == pytest.approx(joint, rel=1e-8)


def test_misprints_shift_inertia_viscous_friction_and_lag_as_the_notes_say():
    found = misprints.joint_of_reading(np.array(series_coefficients(TRUE, PERIOD)), PERIOD, "all as printed")
    assert found["inertia"] == pytest.approx(20.0 + 0.4 / 0.01, rel=1e-9)
    assert found["viscous"] == pytest.approx(80.0 - 0.4 / 0.01**2, rel=1e-9)
    assert found["friction_lag"] == pytest.approx(0.02 / 0.01, rel=1e-9)
    assert (found["coulomb"], found["stiction"]) == pytest.approx((60.0, 90.0), rel=1e-9)


def test_experiments_hand_over_rows_notes_and_figures(monkeypatch):
    monkeypatch.setattr(offline, "MORE_SEEDS", range(1, 3))
    monkeypatch.setattr(online, "MORE_SEEDS", range(1, 3))
    monkeypatch.setattr(reversal, "CORNERS", (0.5, 2.0, 8.0))
    monkeypatch.setattr(rounding, "LONG", 60.0)
    figures = {}
    for module in (misprints, reversal, offline, online, rounding):
        experiment = module.run()
        figures |= experiment.figures
        assert experiment.notes
        for row in experiment.rows:
            assert isinstance(row.value, str) or math.isfinite(row.value)
            assert (row.met is None) == (row.target == "")
            assert row.met in (True, None), row
    assert sorted(figures) == ["figure_03", "figure_04", "figure_05"]
    for figure in figures.values():
        figure.canvas.draw()
        assert len(figure.axes) >= 2
        assert all(axes.lines or axes.collections for axes in figure.axes)


def experiment(name="figure_99"):
    rows = [Row("speed [rad/s]", 0.123456), Row("reached", 3.0, "<= 4", True), Row("missed", "5, 6", "<= 4", False)]
    drawn = Figure(layout="constrained")
    drawn.subplots()
    return Experiment("Fig. 99: a thing", rows, ["It agrees."], {name: drawn})


def invoke(*arguments):
    app = Typer()
    app.command()(command.main)
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_it_prints_the_table_draws_the_figures_and_writes_the_result(monkeypatch, tmp_path):
    monkeypatch.setattr(command, "EXPERIMENTS", {"one": experiment, "two": lambda: experiment("figure_98")})
    done = invoke("--out", tmp_path / "out", "--json", tmp_path / "result" / "paper.json")
    assert done.exit_code == 0
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["figure_98.png", "figure_99.png"]
    assert (tmp_path / "out" / "figure_98.png").read_bytes().startswith(b"\x89PNG")
    result = json.loads((tmp_path / "result" / "paper.json").read_text())
    assert (result["targets_met"], result["targets_missed"]) == (2, 2)
    assert result["experiments"][0]["rows"][1] == {"quantity": "reached", "value": 3.0, "target": "<= 4", "met": True}
    assert result["experiments"][1]["figures"] == ["figure_98"]
    missed = next(line for line in done.output.splitlines() if "missed" in line)
    assert "5, 6" in missed
    assert "NOT MET" in missed
    assert "speed [rad/s]" in done.output
    assert "- It agrees." in done.output
    assert "Wall time" in done.output


def test_nothing_is_written_where_a_folder_cannot_be_made_or_an_experiment_fails(monkeypatch, tmp_path):
    def broken():
        raise ZeroDivisionError

    monkeypatch.setattr(command, "EXPERIMENTS", {"one": experiment, "two": broken})
    (tmp_path / "file").write_text("")
    for arguments in (("--out", tmp_path / "file" / "out"), ("--out", tmp_path / "out", "--json", tmp_path)):
        done = invoke(*arguments)
        assert done.exit_code == 2  # in one line, before anything runs
        assert done.stderr.count("\n") == 1
        assert "cannot be written" in done.stderr
    done = invoke("--out", tmp_path / "out", "--json", tmp_path / "paper.json")
    assert isinstance(done.exception, ZeroDivisionError)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_every_figure_of_the_paper_has_its_experiment():
    runs = list(command.EXPERIMENTS.values())
    assert len(set(runs)) == 7
    modules = {run.__module__.removeprefix("benchmarks.paper.") for run in runs}
    assert modules == {"misprints", "reversal", "offline", "online", "rounding", "stribeck", "closed_loop"}
