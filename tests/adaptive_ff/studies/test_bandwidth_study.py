"""Study of bandwidths: the loop at each, the errors, its table and picture, and the command."""

import inspect
import json
import math

import numpy as np
import pytest
from command_line import refusal, run_command_line
from scenario_files import short, write_scenario

from adaptive_ff import InputError, load_scenario, simulate
from adaptive_ff.cli.studies import tune_command
from adaptive_ff.report.tables import best_table, errors_table, loops_table
from adaptive_ff.scenario.loop import loop_at, noise_response
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.studies.bandwidth_study import study_bandwidths
from controllers import design_pi

SHORT = load_scenario().modified(duration=4.0)


def with_step(scenario):
    """The scenario with 0.4 of its torque limit of 400 N m as a load, a second before its end."""
    return scenario.modified(change=[{"time": 3.0, "load": 160.0}])


def parts(run):
    """Root mean square errors in the last third of the time before the load, and in the second after it."""
    squares = (run.reference - run.velocity) ** 2
    return pytest.approx((np.sqrt(np.mean(squares[2000:3000])), np.sqrt(np.mean(squares[3000:]))), rel=1e-9)


def without_friction(**tables):
    """The built-in scenario with a joint without friction, and with other tables in the place of its own."""
    content = load_scenario().model_dump(exclude_unset=True)
    free = {"coulomb": 0.0, "stiction": 0.0, "viscous": 0.0, "friction_lag": 0.0}
    return Scenario.model_validate({**content, "joint": {**content["joint"], **free}, **tables})


@pytest.fixture(scope="module")
def study():
    return study_bandwidths(SHORT, ["disturbance_observer"], tuning_seeds=[101], reported_seeds=[1])


def test_errors_are_those_of_runs_on_the_reported_seeds(study):
    best = study.own["disturbance_observer"].best
    run = simulate(with_step(SHORT.modified(seed=1, feedback={"bandwidth": best})), "disturbance_observer")
    assert study.own_errors["disturbance_observer"] == parts(run)
    assert study.common_errors["pi"] == parts(simulate(with_step(SHORT), "pi"))
    assert set(study.own) == {"pi", "disturbance_observer"}


def test_margins_are_those_of_the_design(study):
    for loop in study.loops:
        design = design_pi(20.0, 0.01, loop.bandwidth)
        assert (loop.maximum_sensitivity, loop.phase_margin) == (design.maximum_sensitivity, design.phase_margin)
    # friction falls by 600 N m s/rad at most: what Kp = 2 pi f J must hold, near 5 Hz
    hunts = {loop.bandwidth: loop.hunts for loop in study.loops}
    assert [hunts[bandwidth] for bandwidth in sorted(hunts)] == sorted(hunts.values(), reverse=True)
    assert 2.0 < max(bandwidth for bandwidth, hunting in hunts.items() if hunting) < 8.0


@pytest.mark.parametrize(
    "sensor", [{"velocity_noise": 0.002}, {"encoder_resolution": 1e-5}], ids=["velocity sensor", "encoder"]
)
def test_noise_is_that_of_a_run_without_friction(sensor):
    # slow and smooth: what is left of the error is noise
    slow = {"kind": "multisine", "frequencies": [0.05], "amplitudes": [1.0], "peak": 0.1}
    filtered = {"velocity": {"method": "low_pass", "cutoff": 200.0}, "sampling": {"period": 0.001}, "actuator": {}}
    scenario = without_friction(sensor=sensor, reference=slow, **filtered)
    loop = loop_at(scenario, 10.0)
    run = simulate(scenario, "pi_inertia")
    error = (run.reference - run.velocity)[20_000:]
    smooth = np.convolve(error, np.ones(2001) / 2001.0, "same")[2000:-2000]  # what is left of the motion itself
    assert float(np.std(error[2000:-2000] - smooth)) == pytest.approx(loop.noise_velocity, rel=0.15)


def test_response_to_noise_sums_to_nothing_behind_an_encoder():
    assert noise_response(SHORT).tolist() == [1.0]
    encoder = {"encoder_resolution": 1e-5, "velocity_noise": 0.0}
    for method in ("difference", "low_pass", "kalman"):
        response = noise_response(SHORT.modified(sensor=encoder, velocity={"method": method}))
        assert response[0] > 0.0
        assert float(np.sum(response)) == pytest.approx(0.0, abs=1e-4 * response[0])


def test_tables_name_the_best(study):
    tables = [loops_table(study), errors_table(study), best_table(study)]
    assert [len(table.rows) for table in tables] == [len(study.loops), 2 + 2 * len(study.loops), 2]
    marked = list(zip(tables[1].column("bandwidth"), tables[1].column(""), strict=True))
    assert tables[2].column("best") == [bandwidth for bandwidth, mark in marked if mark.startswith("best")]
    assert (tables[2].column("over pi")[0], len(tables[1].heads)) == ("1.00", 4)
    front, every = study.front(), [(name, place) for name in study.own for place in range(len(study.loops))]
    assert {point for point, (_, mark) in zip(every, marked, strict=True) if mark.endswith("front")} == front
    pairs = [pair for one in study.own.values() for pair in one.pairs]
    for name, one in study.own.items():
        for place, pair in enumerate(one.pairs):
            better = [other for other in pairs if other.settled <= pair.settled and other.loaded <= pair.loaded]
            assert ((name, place) in front) == all(other == pair for other in better)
    assert study.plot().axes[0].get_yscale() == "log"
    assert set(study.columns()) >= {"bandwidth", "maximum_sensitivity", "angle_lost", "error_pi", "loaded_error_pi"}
    json.dumps(study.to_dict(), allow_nan=False)


def test_study_without_a_bandwidth_of_its_own():
    scenario = SHORT.modified(feedback={"bandwidth": "auto"}, sensor={"velocity_noise": 0.0})
    found = study_bandwidths(scenario, ["pi"], tuning_seeds=[101], reported_seeds=[1])
    assert found.common_errors == {}
    assert [loop.noise_torque for loop in found.loops] == [0.0] * len(found.loops)
    assert best_table(found).heads == ("controller", "best", "", "error", "over pi", "loaded", "loaded over pi")
    assert found.plot().axes[0].get_lines()


def test_bound_on_the_stiffness_leaves_slow_loops_out():
    """A load of 1 N m turns the joint by 1/Ki: Ki = J (2 pi f)^2/5."""
    short = SHORT.modified(duration=2.0)
    options = {"tuning_seeds": [101], "reported_seeds": [1]}
    stiffest = study_bandwidths(short, ["pi"], **options).loops[-1]
    assert stiffest.angle_lost == pytest.approx(5.0 / (20.0 * (2.0 * math.pi * stiffest.bandwidth) ** 2), rel=1e-9)
    found = study_bandwidths(short, ["pi"], stiffness=0.9 / stiffest.angle_lost, **options)
    assert found.own["pi"].best == stiffest.bandwidth
    with pytest.raises(InputError, match=r"stiffness = 1e\+09 N m/rad is not allowed: the stiffest loop .* has "):
        study_bandwidths(short, ["pi"], stiffness=1e9, **options)


def test_a_joint_that_sees_no_load_is_weighed_without_one(study):
    found = study_bandwidths(SHORT, ["disturbance_observer"], load=0.0, tuning_seeds=[101], reported_seeds=[1])
    own, weighed = found.own["disturbance_observer"], study.own["disturbance_observer"]
    assert own.errors == weighed.errors  # before the step
    assert np.all(np.array(own.loaded) < np.array(weighed.loaded))
    run = simulate(SHORT.modified(seed=1, feedback={"bandwidth": own.best}), "disturbance_observer")
    assert found.own_errors["disturbance_observer"] == parts(run)
    assert {loop.peak_speed for loop in found.loops} == {0.0}
    assert inspect.signature(tune_command).parameters["load"].default == study.load


def test_peak_speed_after_a_load_is_that_of_a_run_without_friction():
    still = {"kind": "multisine", "frequencies": [0.05], "amplitudes": [1.0], "peak": 1e-9}
    without = without_friction(sensor={}, reference=still, duration=4.0)
    run = simulate(with_step(without.modified(feedback={"bandwidth": 6.0})), "pi")
    assert loop_at(without, 6.0).peak_speed == pytest.approx(np.max(np.abs(run.velocity)), rel=0.01)
    lost = np.sum(run.velocity[3000:]) * run.scenario.joint.solver_period
    assert abs(lost) == pytest.approx(160.0 * loop_at(without, 6.0).angle_lost, rel=0.02)


def test_wrong_arguments_are_refused():
    with pytest.raises(InputError, match="controller = 'none' is not known; there are pi,"):
        study_bandwidths(SHORT, ["none"])
    for tuning, reported in (([1, 2], [2]), ([], [1]), ([1], [])):
        with pytest.raises(InputError, match="seeds"):
            study_bandwidths(SHORT, ["pi"], tuning_seeds=tuning, reported_seeds=reported)


def test_command_prints_tables_and_writes_files(tmp_path, drawn):
    scenario = write_scenario(tmp_path, {**short(), "duration": 2.0})
    seeds = ("--seeds", 1, "--tuning-seeds", 1)
    options = ("--controller", "pi", "--load", 0.25, *seeds, "--out", tmp_path / "out", "--report")
    outcome = run_command_line("tune", scenario, *options)
    assert outcome.status == 0, outcome.err
    assert "sensor noise" not in outcome.out
    assert "over pi" in outcome.out
    assert "Weighed for a load of 0.25 of the torque limit" in outcome.out
    assert "sensor noise" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"tune.png", "tune.csv", "tune.json", "report.html"}
    content = json.loads((tmp_path / "out" / "tune.json").read_text())
    assert content["load"] == 0.25
    best = content["controllers"]["pi"]["best_bandwidth"]
    assert best in [loop["bandwidth"] for loop in content["loops"]]
    assert math.isfinite(content["controllers"]["pi"]["own_error"])
    assert "controller = 'mine' is not known" in refusal("tune", scenario, "--controller", "mine", "--out", tmp_path)
