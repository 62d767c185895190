"""Scenarios: the built-in one, those of the package by name, fields beside each other, derived and unreadable ones."""

import math
import re

import numpy as np
import pytest
from command_line import refusal, run_command_line
from scenario_files import REMOVED, built_in, changed, refused, short, to_toml, write_scenario

from adaptive_ff import InputError, Scenario, TorqueModel, load_scenario, parse_scenario
from adaptive_ff.scenario.library import SCENARIOS, scenario_names, scenario_title
from adaptive_ff.scenario.reference import Multisine, Recorded

MAIN_JOB = ["pi", "fixed", "oracle", "adaptive_paper", "adaptive"]

JOINT = {"inertia": 20.0, "coulomb": 60.0, "stiction": 90.0, "viscous": 80.0, "stribeck_velocity": 0.05}
FREQUENCIES, AMPLITUDES = [0.01, 0.05, 0.11, 0.23, 0.41, 0.7, 1.0], [0.12, 0.1, 0.08, 0.06, 0.05, 0.04, 0.03]
WAVES = {"kind": "multisine", "frequencies": FREQUENCIES, "amplitudes": AMPLITUDES}
DESIGNED = {
    "duration": 60.0,
    "seed": 1,
    "joint": {**JOINT, "stribeck_shape": 1.0, "friction_lag": 0.02, "solver_period": 0.001},
    "sampling": {"period": 0.01},
    "sensor": {"velocity_noise": 0.002},
    "actuator": {"torque_limit": 400.0},
    "reference": {**WAVES, "peak": 0.35, "fade_in": 2.0},
    "feedback": {"inertia": 20.0, "bandwidth": 10.0},
    "adaptation": {"stribeck_velocity": 0.05, "stribeck_shape": 1.0},
    "fixed": {"inertia": 20.0, "coulomb": 60.0, "viscous": 80.0},
}


def load(folder, content):
    return load_scenario(write_scenario(folder, content))


def write_motion(path):
    """Write a minute of a constant velocity."""
    path.write_text("time,velocity\n" + "".join(f"{t},0.1\n" for t in range(61)), encoding="utf-8")
    return {"kind": "csv", "path": str(path)}


def refusal_of(folder, content):
    return refused(f"{folder / 'scenario.toml'}: ", load, folder, content)


def test_built_in_scenario_is_the_designed_one():
    scenario = load_scenario()
    assert scenario.model_dump(exclude_unset=True) == DESIGNED
    assert scenario.controllers == MAIN_JOB
    assert scenario.change == []
    assert (scenario.length, scenario.samples, scenario.substeps) == (60.0, 6000, 10)
    assert scenario.times()[[0, 1, -1]] == pytest.approx([0.0, 0.001, 60.0], rel=1e-15)


def test_what_may_be_left_out_has_the_stated_value(tmp_path):
    feedback, adaptation = {"inertia": 20.0, "bandwidth": 10.0}, {"stribeck_velocity": 0.05}
    scenario = load(tmp_path, {"joint": JOINT, "feedback": feedback, "adaptation": adaptation})
    assert (scenario.duration, scenario.length, scenario.seed, scenario.controllers) == (None, 60.0, 1, MAIN_JOB)
    assert (scenario.joint.stribeck_shape, scenario.joint.friction_lag, scenario.joint.solver_period) == (1, 0, 0.001)
    assert (scenario.sampling.period, scenario.sensor.velocity_noise) == (0.01, 0.0)
    assert scenario.actuator.torque_limit is None
    assert scenario.actuator.parameters.torque_limit == math.inf
    assert scenario.reference == Multisine(**{**DESIGNED["reference"], "peak": None})
    assert np.max(np.abs(scenario.reference_velocity())) == pytest.approx(DESIGNED["reference"]["peak"])
    assert (scenario.adaptation.stribeck_shape, scenario.adaptation.memory) == (1.0, None)
    assert scenario.fixed.model == TorqueModel(0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0)
    assert scenario.change == []


def test_fixed_stiction_equals_its_coulomb_friction_unless_given():
    scenario = load_scenario()
    assert scenario.fixed.model == TorqueModel(20.0, 60.0, 60.0, 80.0, 0.0, 1.0, 1.0)
    given = scenario.modified(fixed={"stiction": 90.0, "stribeck_velocity": 0.05, "friction_lag": 0.02})
    assert given.fixed.model == TorqueModel(20.0, 60.0, 90.0, 80.0, 0.02, 0.05, 1.0)


def test_feedback_takes_a_bandwidth_or_both_gains(tmp_path):
    crossover = 2.0 * math.pi * 10.0
    designed = load_scenario().feedback.gains
    assert designed == pytest.approx((crossover * 20.0, crossover * 20.0 * crossover / 5.0), rel=1e-14)
    gains = {"inertia": 20.0, "proportional": 5000.0, "integral": 0.0}  # faster than the design allows: not checked
    assert load(tmp_path, {**built_in(), "feedback": gains}).feedback.gains == (5000.0, 0.0)
    for taken in ("proportional", "integral"):
        message = refusal_of(tmp_path, changed({**built_in(), "feedback": gains}, f"feedback.{taken}", REMOVED))
        assert message == "feedback: bandwidth is missing; give it, or both proportional and integral"
        message = refusal_of(tmp_path, changed(built_in(), f"feedback.{taken}", 100.0))
        assert message == "feedback: bandwidth = 10 is given beside gains; give it or both gains, not both"


@pytest.mark.parametrize("period", [0.001, 0.01, 0.022])
def test_bandwidth_that_the_design_refuses_is_answered_with_one_that_it_accepts(tmp_path, period):
    content = changed(changed(built_in(), "sampling.period", period), "feedback.bandwidth", 400.0)
    message = refusal_of(tmp_path, content)
    assert message.startswith(f"feedback.bandwidth = 400 Hz is not allowed: with a period of {period:g} s")
    named = float(re.search(r"at most (\S+) Hz", message)[1])
    assert load(tmp_path, changed(content, "feedback.bandwidth", named)).feedback.bandwidth == named
    assert "is not allowed" in refusal_of(tmp_path, changed(content, "feedback.bandwidth", 1.001 * named))


@pytest.mark.parametrize(
    ("duration", "period", "samples"),
    [(0.01, 0.01, 1), (0.3, 0.1, 3), (0.1 + 0.2, 0.1, 3), (0.019, 0.01, 1), (7, 1, 7)],
)
def test_run_has_the_whole_samples_that_its_duration_holds(duration, period, samples):
    slow = {"frequencies": [0.01], "amplitudes": [1.0]}
    scenario = load_scenario().modified(
        duration=duration, sampling={"period": period}, feedback={"bandwidth": 0.01}, reference=slow
    )
    assert scenario.samples == samples
    assert scenario.times()[-1] == pytest.approx(samples * period, rel=1e-12)
    assert scenario.noise().shape == (samples,)
    assert scenario.reference_velocity().shape == scenario.times().shape


def test_seed_draws_noise_and_reference_and_nothing_else_does():
    scenario = load_scenario()
    other, again = scenario.modified(seed=2), scenario.modified(joint={"viscous": 70.0})
    assert np.std(scenario.noise()) == pytest.approx(0.002, rel=0.05)
    for draw in (Scenario.noise, Scenario.reference_velocity):
        assert np.array_equal(draw(scenario), draw(again))
        assert np.max(np.abs(draw(scenario) - draw(other))) > 0.002


def test_modified_merges_into_a_table_and_leaves_the_original_alone():
    scenario = load_scenario()
    modified = scenario.modified(seed=2, joint={"viscous": 70.0}, change=[{"time": 30.0, "friction_scale": 0.6}])
    assert scenario == load_scenario()
    assert modified.model_dump(exclude_unset=True) == {
        **built_in(),
        "seed": 2,
        "joint": {**built_in()["joint"], "viscous": 70.0},
        "change": [{"time": 30.0, "friction_scale": 0.6}],
    }
    assert modified.modified(change=[]).change == []
    content = changed(built_in(), "reference", REMOVED)  # into a table that was left out
    modified = parse_scenario(content, "here").modified(reference={"peak": 0.1}, fixed={"inertia": 1.0})
    assert modified.reference == Multisine(peak=0.1)
    without = parse_scenario(changed(content, "fixed", REMOVED), "here")
    assert without.modified(fixed={"inertia": 1.0}).fixed.coulomb == 0


def test_modified_replaces_a_reference_of_another_kind_and_merges_into_one_of_the_same(tmp_path):
    recorded = write_motion(tmp_path / "motion.csv")
    scenario = load_scenario().modified(reference=recorded)
    assert scenario.reference == Recorded(**recorded)
    assert load_scenario().modified(reference={"kind": "multisine", "peak": 0.1}).reference.fade_in == 2.0
    assert scenario.modified(reference={"kind": "multisine", "fade_in": 1.0}).reference == Multisine(fade_in=1.0)


def test_modified_checks_like_a_file():
    with pytest.raises(InputError, match=r"^scenario: joint\.inertia = -1\.0 is not allowed: it must be positive$"):
        load_scenario().modified(joint={"inertia": -1.0})
    with pytest.raises(InputError, match=r"^scenario: load = 1 is not known; allowed there: duration, seed"):
        load_scenario().modified(load=1)


FREE = parse_scenario(changed(built_in(), "reference.peak", REMOVED), "test")


def peak(scenario):
    return float(np.max(np.abs(scenario.reference_velocity())))


def test_default_peak_of_the_built_in_joint_is_the_one_that_its_file_gives():
    assert np.allclose(FREE.reference_velocity(), load_scenario().reference_velocity(), rtol=1e-12, atol=0.0)


def test_default_peak_is_seven_stribeck_velocities_unless_the_torque_limit_is_low():
    assert peak(FREE.modified(joint={"stribeck_velocity": 0.02})) == pytest.approx(0.14)
    weak = FREE.modified(actuator={"torque_limit": 150.0})
    reference, joint = weak.reference_velocity(), weak.joint
    assert peak(weak) < 0.2
    fastest = np.max(np.abs(np.diff(reference))) / joint.solver_period
    assert joint.inertia * fastest + joint.viscous * peak(weak) + joint.stiction == pytest.approx(0.7 * 150.0)
    assert peak(FREE.modified(actuator={"torque_limit": 100.0})) == pytest.approx(0.35)  # cannot move it anyway


def test_reference_that_is_too_slow_or_too_fast_is_warned_of_with_a_peak_that_suits():
    assert load_scenario().cautions() == load_scenario("servo").cautions() == []
    (slow,) = load_scenario().modified(reference={"peak": 0.06}).cautions()
    assert slow.startswith("the reference never exceeds 0.06 rad/s, 1.2 times joint.stribeck_velocity = 0.05 rad/s")
    assert slow.endswith("a peak of 0.35 rad/s would")
    (fast,) = load_scenario().modified(reference={"peak": 8.0}).cautions()
    assert fast.startswith("the reference needs more than actuator.torque_limit = 400 N m in ")
    suggested = float(fast.partition("a peak of ")[2].partition(" ")[0])
    assert load_scenario().modified(reference={"peak": suggested}).cautions() == []
    twice = load_scenario().modified(reference={"peak": 2.0 * suggested}).cautions()
    assert len(twice) <= 1


def test_joint_that_the_loop_cannot_move_smoothly_is_cautioned_against():
    assert load_scenario().modified(actuator={"torque_limit": 90.0}).cautions() == []
    assert load_scenario().modified(actuator={"torque_limit": 80.0}).cautions() == [
        "actuator.torque_limit = 80 N m is below joint.stiction = 90 N m: tracking is impossible, the joint cannot "
        "break away from rest"
    ]
    slow = {"inertia": 20.0, "proportional": 521.0, "integral": 1000.0}  # the curve falls by 30/0.05 - 80 = 520 at rest
    content = {**built_in(), "feedback": slow}
    assert parse_scenario(content, "here").cautions() == []
    assert parse_scenario(changed(content, "feedback.proportional", 519.0), "here").cautions() == [
        "the friction curve falls by up to 520 N m s/rad, more than the proportional gain of 519 N m s/rad can hold: "
        "the loop will hunt at low speed"
    ]


def test_warnings_of_a_linear_axis_have_its_units():
    linear = load_scenario().modified(joint={"axis": "linear"})
    (slow,) = linear.modified(reference={"peak": 0.06}).cautions()
    assert slow.startswith("the reference never exceeds 0.06 m/s, 1.2 times joint.stribeck_velocity = 0.05 m/s")
    weak = linear.modified(actuator={"torque_limit": 80.0}).cautions()
    assert weak[0].startswith("actuator.torque_limit = 80 N is below joint.stiction = 90 N: ")
    (steep,) = linear.modified(joint={"stiction": 1000.0}, actuator={"torque_limit": 4000.0}).cautions()
    assert " N s/m, more than the proportional gain" in steep


@pytest.mark.parametrize(
    "content",
    [b"duration = ", b"[joint", b"a = 1\na = 2", b"\xff\xfeduration = 1", b"\x00", b"[[[[", b"x = " + b"[" * 3000],
)
def test_file_that_is_no_toml_is_refused_with_its_name(tmp_path, content):
    path = tmp_path / "scenario.toml"
    path.write_bytes(content)
    assert refused(f"{path}: is not valid TOML: ", load_scenario, path)


@pytest.mark.parametrize("name", [".", "missing.toml", "scenario.toml/inside", "x" * 300])
def test_file_that_cannot_be_read_is_refused_with_its_name(tmp_path, name):
    write_scenario(tmp_path, short())
    assert refused(f"{tmp_path / name}: cannot be read: ", load_scenario, tmp_path / name)


def test_path_of_a_recorded_reference_is_relative_to_the_scenario_file(tmp_path, monkeypatch):
    folder = tmp_path / "inside"
    folder.mkdir()
    write_motion(folder / "motion.csv")
    path = write_scenario(folder, {**built_in(), "reference": {"kind": "csv", "path": "motion.csv"}})
    monkeypatch.chdir(tmp_path)
    assert load_scenario("inside/scenario.toml").motion.duration == 60.0
    assert load_scenario(path).motion.duration == 60.0
    path.write_text(to_toml({**built_in(), "reference": {"kind": "csv", "path": "gone.csv"}}), encoding="utf-8")
    with pytest.raises(InputError, match=r"gone\.csv: cannot be read: No such file"):
        load_scenario(path)
    assert load_scenario(path, reference="inside/motion.csv").motion.duration == 60.0


def test_modified_merges_into_a_joint_of_the_same_kind_and_replaces_one_of_another():
    scenario = load_scenario()
    assert scenario.modified(joint={"kind": "stribeck", "inertia": 5.0}).joint.coulomb == scenario.joint.coulomb
    bristles = {name: getattr(scenario.joint, name) for name in ("inertia", "coulomb", "stiction", "viscous")}
    bristles |= {"kind": "lugre", "stribeck_velocity": 0.05, "stiffness": 1e5}
    other = scenario.modified(joint=bristles)
    assert other.joint.kind == "lugre"
    assert other.modified(joint={"stiffness": 2e5}).joint.coulomb == 60.0
    said = r"joint\.inertia, joint\.coulomb, joint\.stiction, joint\.viscous and .* are missing"
    with pytest.raises(InputError, match=said):
        scenario.modified(joint={"kind": "lugre", "stiffness": 1e5})


def test_a_scenario_is_found_by_its_name():
    assert load_scenario("encoder") == load_scenario(SCENARIOS / "encoder.toml")
    assert load_scenario("triangle").reference_velocity().size > 0  # its recorded reference lies beside it


def test_a_file_of_that_name_comes_first(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "encoder").write_text((SCENARIOS / "delay.toml").read_text())
    assert load_scenario("encoder") == load_scenario("delay")
    with pytest.raises(InputError, match="no_such"):
        load_scenario("no_such")


def test_every_scenario_says_in_a_line_what_it_is():
    assert [name for name in scenario_names() if not 10 < len(scenario_title(name)) < 130] == []


def test_command_lists_them_and_every_command_takes_their_names():
    outcome = run_command_line("scenarios")
    assert outcome.status == 0
    listed = [line for line in outcome.out.splitlines() if line.startswith("  ")]
    assert sorted(name for line in listed for name in line.strip().rstrip(",").split(", ")) == scenario_names()
    described = run_command_line("scenarios", "steep_2").out.splitlines()
    assert described == [f"{name:8}  {scenario_title(name)}" for name in ("steep_2", "steep_20")]
    assert "TEXT = 'nothing' is in no scenario" in refusal("scenarios", "nothing")
