"""Monte Carlo over drawn joints, and over draws of the noise."""

import json

import numpy as np
import pytest
from command_line import refusal, run_command_line
from hypothesis import given
from hypothesis import strategies as st
from scenario_files import write_scenario

from adaptive_ff import InputError, load_scenario
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.comparison.run import simulate
from adaptive_ff.scenario.file import to_toml
from adaptive_ff.scenario.scenario import parse_scenario
from adaptive_ff.simulation.metrics import rms
from adaptive_ff.studies import sweep as studies
from adaptive_ff.studies.tracking import noisy_setups, run_errors, track_scenario
from controllers import PI
from plant import JointModel, whole_multiple

SHORT = load_scenario().modified(duration=4.0, sweep={"velocity_noise": [0.0, 0.001]})


@pytest.fixture(scope="module")
def outcomes(one_thread):
    return studies.sweep(SHORT, 24, seed=5, executor=one_thread)


@given(st.integers(0, 10**6))
def test_draws_lie_in_their_ranges_and_none_is_refused(draw):
    drawn = studies.draw_scenario(SHORT, 3, draw)
    ranges, joint, base = SHORT.sweep, drawn.joint, SHORT.joint
    for name in ("inertia", "coulomb", "viscous"):
        low, high = getattr(ranges, name)
        assert low * 0.999 <= getattr(joint, name) / getattr(base, name) <= high * 1.001
    assert 1.0 <= joint.stiction / joint.coulomb <= 2.0
    assert 0.0 <= joint.friction_lag <= 0.05
    assert 0.0 <= drawn.sensor.velocity_noise <= 0.001
    assert 0.499 <= drawn.adaptation.stribeck_velocity / joint.stribeck_velocity <= 2.001
    assert 0.699 <= drawn.feedback.inertia / joint.inertia <= 1.301
    assert whole_multiple(base.solver_period, joint.solver_period) is not None
    same_share = drawn.actuator.torque_limit / studies.needed_torque(drawn)
    assert same_share == pytest.approx(SHORT.actuator.torque_limit / studies.needed_torque(SHORT), rel=1e-3)


def test_drive_without_a_limit_keeps_none():
    free = SHORT.model_dump(exclude_unset=True)
    del free["actuator"]["torque_limit"]
    drawn = studies.draw_scenario(parse_scenario(free, "free"), 3, 1)
    assert drawn.actuator.torque_limit is None
    assert drawn.joint == studies.draw_scenario(SHORT, 3, 1).joint


def test_joint_that_the_solver_period_is_too_long_for_gets_the_longest_that_is_not():
    light = {"inertia": 2.0, "coulomb": 600.0, "stiction": 1200.0, "friction_lag": 0.0}
    period = studies.drawn_joint(SHORT, light).solver_period
    fields = {**light, "viscous": 80.0, "stribeck_velocity": 0.05}
    assert JointModel(**fields, solver_period=period).solver_period < 0.001
    with pytest.raises(ValueError, match="too long for this joint"):
        JointModel(**fields, solver_period=2.0 * period)
    assert studies.drawn_joint(SHORT, {}) == SHORT.joint


def test_draw_depends_on_seed_and_number_only(outcomes):
    assert studies.draw_scenario(SHORT, 5, 7) == studies.draw_scenario(SHORT, 5, 7)
    assert studies.draw_scenario(SHORT, 5, 7) != studies.draw_scenario(SHORT, 6, 7)
    ran = next(outcome for outcome in outcomes if not outcome.refused)
    again = simulate(studies.draw_scenario(SHORT, 5, ran.draw), "adaptive").metrics
    assert again == ran.metrics["adaptive"]


def test_several_workers_give_the_same_as_one(outcomes):
    shares = []
    assert studies.sweep(SHORT, 24, seed=5, progress=shares.append) == outcomes
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_summary_counts_and_ranks(outcomes):
    result = studies.summary(outcomes, seed=5)
    ran = [outcome for outcome in outcomes if not outcome.refused]
    assert (result["draws"], result["refused"]) == (24, 24 - len(ran))
    whole = sorted((studies.quantities(outcome)["whole_run"] for outcome in ran), reverse=True)
    assert [case["whole_run"] for case in result["worst"]] == whole[:3]
    assert result["quantiles"]["whole_run"]["0.5"] == pytest.approx(np.median(whole))
    assert set(result["quantiles"]) == set(studies.QUANTITIES)
    assert result["worse_than_pi"] == sum(value > 1.05 for value in whole) / len(whole)


def test_scenario_written_as_toml_reads_back_equal(tmp_path):
    scenario = SHORT.modified(change=[{"time": 1.0, "friction_scale": 0.5}, {"time": 2.0, "friction_scale": 1.5}])
    path = tmp_path / "scenario.toml"
    path.write_text(to_toml(scenario), encoding="utf-8")
    assert load_scenario(path) == scenario


def test_command_line_writes_the_worst_cases(tmp_path, without_pictures):
    scenario = write_scenario(tmp_path, SHORT.model_dump(mode="json", exclude_none=True))
    out = tmp_path / "out"
    outcome = run_command_line("sweep", scenario, "--runs", 6, "--seed", 5, "--out", out, "--json", tmp_path / "r.json")
    assert outcome.status == 0, outcome.err
    result = json.loads((out / "sweep.json").read_text())
    assert result == json.loads((tmp_path / "r.json").read_text())
    worst = load_scenario(out / "worst-1.toml")
    assert worst == studies.draw_scenario(SHORT, 5, result["worst"][0]["draw"])
    assert "draws" in outcome.out


def test_bad_input_is_refused(tmp_path):
    with pytest.raises(ValueError, match="runs"):
        studies.sweep(SHORT, 0)
    assert "--runs" in refusal("sweep", "--runs", 0, "--out", tmp_path / "out")
    for table in ({"inertia": [2.0, 1.0]}, {"stiction": [0.5, 2.0]}, {"inertia": [1.0]}, {"inertia": [-1.0, 1.0]}):
        with pytest.raises(InputError, match=rf"sweep\.{next(iter(table))}"):
            SHORT.modified(sweep=table)


@pytest.mark.parametrize("name", ["asymmetric", "lugre", "elastic", "backlash", "maxwell", "rolling", "elasto_plastic"])
def test_joints_of_every_kind_are_drawn(name, one_thread):
    scenario = load_scenario(name).modified(duration=5.0)
    outcomes = studies.sweep(scenario, 6, 101, executor=one_thread)
    ran = [outcome for outcome in outcomes if not outcome.refused]
    assert ran
    for outcome in ran:
        drawn = studies.draw_scenario(scenario, 101, outcome.draw).joint
        assert drawn.kind == scenario.joint.kind
        forward, backward = drawn.friction, drawn.friction_backward
        before = scenario.joint.friction_backward.coulomb / scenario.joint.coulomb
        assert backward.coulomb / forward.coulomb == pytest.approx(before, rel=1e-12)
        assert backward.stiction / forward.stiction == pytest.approx(before, rel=1e-12)


def half(proportional, period):
    """Half of PI's proportional gain."""
    return PI(0.5 * proportional, 0.0, period)


def test_own_controller_is_run_on_every_joint_and_summed_up(one_thread):
    found = studies.sweep(SHORT, 2, seed=5, own={"half": half}, executor=one_thread)
    drawn = studies.draw_scenario(SHORT, 5, 1)
    alone = simulate(drawn, half(drawn.feedback.gains[0], drawn.sampling.period))
    assert found[1].metrics["half"] == alone.metrics
    own = studies.summary(found, 5)["own"]["half"]
    assert own["failed"] == 0
    ratios = sorted(one.ratio("rms_error_settled", "pi", "half") for one in found)
    assert [own["improvement"]["0.0"], own["improvement"]["1.0"]] == pytest.approx(ratios)
    with pytest.raises(InputError, match="'pi' is not allowed"):
        studies.sweep(SHORT, 2, own={"pi": half})


def test_rival_of_the_package_is_run_on_every_joint_and_kept(tmp_path, one_thread):
    found = studies.sweep(SHORT, 2, seed=5, further=["pi_inertia", "pi"], folder=tmp_path, executor=one_thread)
    assert studies.sweep(SHORT, 2, seed=5, further=["pi_inertia"], folder=tmp_path, executor=one_thread) == found
    alone = simulate(studies.draw_scenario(SHORT, 5, 1), "pi_inertia")
    assert found[1].metrics["pi_inertia"] == alone.metrics
    assert list(studies.summary(found, 5)["own"]) == ["pi_inertia"]
    with pytest.raises(InputError, match="'pid' is not known; there are pi, "):
        studies.sweep(SHORT, 2, further=["pid"])


def test_interrupted_sweep_goes_on_where_it_stopped(tmp_path, monkeypatch, outcomes, one_thread):
    ran = []
    run = studies.run_draw
    monkeypatch.setattr(studies, "run_draw", lambda *arguments: ran.append(arguments[3]) or run(*arguments))
    studies.sweep(SHORT, 3, seed=5, folder=tmp_path, executor=one_thread)
    assert sorted(ran) == [0, 1, 2]
    again = studies.sweep(SHORT, 4, seed=5, folder=tmp_path, executor=one_thread)
    assert ran[3:] == [3]
    assert again == outcomes[:4]
    studies.sweep(SHORT.modified(duration=1.0), 2, seed=5, folder=tmp_path, executor=one_thread)
    assert ran[4:] == [0, 1]


def test_beside_an_encoder_no_noise_of_the_velocity_is_drawn():
    scenario = load_scenario("encoder").modified(duration=2.0)
    drawn = studies.draw_scenario(scenario, 1, 0)
    assert drawn.sensor == scenario.sensor
    assert drawn.joint.inertia != scenario.joint.inertia


def test_reasons_for_refusals_are_counted_by_kind_and_a_sweep_of_them_alone_is_bad_input(tmp_path):
    reasons = ("period = 0.5 is too long", "period = 0.25 is too long", "no")
    found = [studies.Outcome(draw, {}, reason) for draw, reason in enumerate(reasons)]
    assert studies.refusals([*found, studies.Outcome(3, {})]) == {"period = 0.5 is too long": 2, "no": 1}
    coarse = SHORT.modified(sweep={"coulomb": [1e5, 2e5], "friction_lag": [0.0, 0.0]})
    scenario = write_scenario(tmp_path, coarse.model_dump(mode="json", exclude_none=True))
    line = refusal("sweep", scenario, "--runs", 2, "--out", tmp_path / "out")
    assert "none of 2 joints can be run; 2 joints refused: " in line


SCENARIO = load_scenario().modified(duration=23.0, change=[{"time": 11.0, "load": 30.0}])


def test_errors_are_roots_of_mean_squares_over_draws():
    found = track_scenario(SCENARIO, ["oracle"], draws=3)["oracle"]
    runs = [simulate(SCENARIO, "oracle", setup=setup) for setup in noisy_setups(SCENARIO, 3)]
    joined = np.array([run.reference - run.velocity for run in runs])
    assert found["error"] == pytest.approx(rms(joined[:, 17_000:]), rel=1e-12)


def test_behind_a_position_loop_the_error_is_that_of_the_position():
    run = simulate(SCENARIO.modified(position={}), "pi")
    found = run_errors(run)
    assert found.settled == pytest.approx(rms(run.position_error[17_000:]), rel=1e-12)
    assert found.settled < 0.2 * rms((run.reference - run.velocity)[17_000:])


def test_first_draw_is_the_scenario_itself_and_the_others_differ_in_noise_where_there_is_any():
    own, *others = noisy_setups(SCENARIO, 3)
    assert np.array_equal(own.noise, SCENARIO.noise())
    assert all(np.array_equal(setup.reference, own.reference) for setup in others)
    noises = np.array([own.noise, *(setup.noise for setup in others)])
    assert np.std(noises, axis=1) == pytest.approx(0.002, rel=0.05)
    assert np.max(np.abs(np.corrcoef(noises) - np.eye(3))) < 0.1
    assert len(list(noisy_setups(SCENARIO.modified(sensor={"velocity_noise": 0.0}), 5))) == 1


def test_pi_against_itself_is_one_everywhere_and_a_better_controller_is_better():
    found = track_scenario(SCENARIO, ["pi", "oracle", "noise_floor"])
    assert {found["pi"][name] for name in ("settled", "window", "start", "after", "torque_variation")} == {1.0}
    assert found["oracle"]["settled"] > 2.0
    assert found["oracle"]["window"] < 0.8
    assert found["noise_floor"]["error"] < found["oracle"]["error"]


class Runaway:
    calls = 0

    def step(self, reference, velocity):
        self.calls += 1
        return 10.0**self.calls if self.calls < 300 else 0.0


def test_a_loop_that_does_not_stay_finite_is_infinitely_worse(monkeypatch):
    monkeypatch.setitem(CONTROLLERS, "runaway", lambda _: Runaway())
    scenario = load_scenario().modified(duration=5.0, actuator={"torque_limit": 1e300})
    found = track_scenario(scenario, ["runaway"])["runaway"]
    assert (found["settled"], found["window"]) == (0.0, float("inf"))


def test_draws_must_be_positive():
    with pytest.raises(ValueError, match="draws = 0 is not allowed"):
        track_scenario(SCENARIO, ["pi"], draws=0)
