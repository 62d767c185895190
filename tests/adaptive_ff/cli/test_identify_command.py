"""``adaptive-ff identify`` and ``score``: what they write, what they print, and what they refuse."""

import json

import numpy as np
import pytest
from command_line import content_of, refusal, run_command_line
from synthetic_logs import JOINT, make_log, motion, write_log

from adaptive_ff import compare, load_scenario
from adaptive_ff.files import write_csv
from adaptive_ff.report import page

FILES = {"identification.json", "scenario.toml", "reference.csv", "identified_torque.png", "friction.png"}


CURRENT = (
    "warning: the torque of the log is a current, so scenario.toml has A and A s²/rad where it says N m and kg m²; for "
    "these give --torque-constant, in N m/A"
)


def found_in(folder):
    return json.loads((folder / "identification.json").read_text(encoding="utf-8"))


def identified(log, *options):
    """Identify a log into the folder ``out`` beside it; return how the command ended, and what was found."""
    out = log.parent / "out"
    outcome = run_command_line("identify", log, *options, "--out", out)
    assert outcome.status == 0, outcome
    return outcome, found_in(out)


@pytest.fixture
def log():
    """A log of 15 s at 200 Hz, to be written with other columns."""
    return make_log(noise=0.05, period=0.005, duration=15.0)


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("identify")
    log = write_log(folder / "log.csv", period=0.005)
    outcome = run_command_line("identify", log, "--out", folder / "out", "--json", folder / "own" / "copy.json")
    assert (outcome.status, outcome.messages) == (0, []), outcome
    return folder, outcome


def test_files_json_and_table_of_a_log(result):
    folder, outcome = result
    assert set(content_of(folder / "out")) == FILES
    assert "current" not in (folder / "out" / "scenario.toml").read_text(encoding="utf-8")
    for name in FILES:
        if name.endswith(".png"):
            assert (folder / "out" / name).read_bytes().startswith(b"\x89PNG")
    found = json.loads((folder / "own" / "copy.json").read_text(encoding="utf-8"))
    assert found == found_in(folder / "out")
    for name, true in JOINT.items():
        entry = found[name]
        assert entry["value"] == pytest.approx(true, rel=0.02)
        assert entry["lower"] < entry["value"] < entry["upper"]
    assert found["inertia"]["unit"] == "kg m²"
    assert found["scenario"] == "scenario.toml"
    assert found["samples"] == {"log": 6000, "used": 6000}
    assert found["skipped"] == []
    assert 0.0 < found["left"] < 0.01
    assert found["refined"] is found["validation"] is None
    assert found["verdict"] == "good"
    assert 5.0 < found["bandwidth"] < 20.0
    printed = " ".join(outcome.out.split())
    assert "kg m²" in printed
    assert "Verdict: good." in printed
    assert "Next: adaptive-ff compare" in printed
    assert len(outcome.out.splitlines()) <= 25
    assert max(map(len, outcome.out.splitlines()[:8])) <= 80
    assert "Columns: time time, position position, torque torque." in printed


def test_scenario_is_the_joint_on_the_motion_of_the_log_and_one_that_compare_takes(result):
    folder, _ = result
    scenario = load_scenario(folder / "out" / "scenario.toml")
    assert [scenario.joint.inertia, scenario.joint.viscous] == pytest.approx([2.0, 4.0], rel=0.01)
    assert scenario.joint.coulomb == scenario.joint.stiction == pytest.approx(3.0, rel=0.01)
    assert scenario.joint.offset == pytest.approx(-0.5, rel=0.02)
    assert scenario.sampling.period == 0.005
    text = (folder / "out" / "scenario.toml").read_text(encoding="utf-8")
    assert "assumed: the log shows none of what is above coulomb" in text
    times, reference = scenario.times(), scenario.reference_velocity()
    inner = (times > 1.0) & (times < 29.0)
    assert np.max(np.abs(reference - motion(times)[1])[inner]) <= 0.02
    steepest = np.max(np.abs(motion(times)[2]))
    assert np.max(np.abs(np.diff(reference))) < 1.1 * steepest * 0.001  # it repeats without a jump
    comparison = compare(scenario.modified(duration=5.0, controllers=["pi", "oracle"]))
    assert comparison.improvement["oracle"] > 2.0


def test_other_log_is_validated_on_and_nothing_is_held_out(tmp_path, without_pictures):
    log = write_log(tmp_path / "log.csv", period=0.005)
    other = write_log(tmp_path / "other.csv", period=0.005, viscous=6.0, seed=102)
    outcome, found = identified(log, "--validate", other)
    assert found["validation"]["on"] == str(other)
    assert found["validation"]["left"] > 10.0 * found["left"]
    assert f"of the torque of {other} are left" in " ".join(outcome.out.split())


def test_units_are_given_by_factors_and_linear_axes_have_their_own(log, tmp_path, without_pictures):
    columns = {"ms": 1e3 * log.time, "deg": np.degrees(log.position), "volt": -log.torque / 48.0}
    write_csv(tmp_path / "log.csv", columns)
    options = ["--time", "ms", "--position", "deg", "--torque", "volt", "--linear"]
    scales = ["--scale", "ms=1e-3", "--scale", "deg=pi/180", "--scale", "volt=-48"]
    _, found = identified(tmp_path / "log.csv", *options, *scales)
    assert found["inertia"]["value"] == pytest.approx(2.0, rel=0.01)
    assert (found["inertia"]["unit"], found["viscous"]["unit"]) == ("kg", "N s/m")
    assert load_scenario(tmp_path / "out" / "scenario.toml").joint.axis == "linear"


def test_current_is_found_by_its_name_and_keeps_its_units_where_the_motion_is_scaled(log, tmp_path, without_pictures):
    path = tmp_path / "log.csv"
    write_csv(path, {"time": log.time, "q": np.degrees(log.position), "current": log.torque})
    said = "has A and A s²/m where it says N and kg; for these give --torque-constant, in N/A"
    for linear, warning, unit in (((), CURRENT, "A s²/rad"), (("--linear",), said, "A s²/m")):
        outcome, found = identified(path, "--scale", "q=pi/180", *linear)
        assert [line.endswith(warning) for line in outcome.warnings] == [True]
        scenario = (tmp_path / "out" / "scenario.toml").read_text(encoding="utf-8")
        assert "# The torque of the log is a current: read A where units say N m (N), or give" in scenario
        assert found["inertia"]["value"] == pytest.approx(2.0, rel=0.01)
        assert found["inertia"]["unit"] == unit


def test_units_that_columns_say_are_pointed_out_and_milliamperes_become_amperes(log, tmp_path, without_pictures):
    path = tmp_path / "log.csv"
    write_csv(path, {"t": log.time, "lage": np.degrees(log.position), "strom": 1e3 * log.torque})
    header, rows = path.read_text(encoding="utf-8").split("\n", 1)
    path.write_text(f"{header}\n[s],[deg],[mA]\n{rows}", encoding="utf-8")
    columns = ["--position", "lage", "--torque", "strom"]
    said = " ".join(identified(path, *columns)[0].err.split())
    assert "the column lage seems to be in degrees, but is taken as rad: give --scale lage=pi/180" in said
    assert "the column strom seems to be in mA, but is taken as A: give --scale strom=1e-3" in said
    outcome, found = identified(path, *columns, "--scale", "lage=pi/180", "--scale", "strom=1e-3")
    assert outcome.warnings == [CURRENT]
    assert found["inertia"]["value"] == pytest.approx(2.0, rel=0.01)
    assert found["inertia"]["unit"] == "A s²/rad"


def test_millimetres_of_an_axis_that_is_taken_as_rotary_are_pointed_out(log, tmp_path, without_pictures):
    write_csv(tmp_path / "log.csv", {"time": log.time, "z_mm": log.position, "force [N]": log.torque})
    options = ["--position", "z_mm", "--torque", "force [N]"]
    said = " ".join(identified(tmp_path / "log.csv", *options)[0].err.split())
    for column, unit in (("z_mm", "millimetres"), ("force [N]", "N")):
        assert f"the column {column} seems to be in {unit}, but the axis is taken as rotary; --linear, or" in said
    said = " ".join(identified(tmp_path / "log.csv", *options, "--linear")[0].err.split())
    assert "give --scale z_mm=1e-3" in said
    assert "taken as linear" not in said


@pytest.mark.parametrize(("name", "factor"), [("current", "-1"), ("current_mA", "-1e-3")])
def test_current_with_the_other_sign_stays_one(log, tmp_path, without_pictures, name, factor):
    write_csv(tmp_path / "log.csv", {"time": log.time, "q": log.position, name: log.torque / float(factor)})
    _, found = identified(tmp_path / "log.csv", "--torque", name, "--scale", f"{name}={factor}")
    assert found["inertia"]["unit"] == "A s²/rad"


@pytest.mark.parametrize("command", ["identify", "replay"])
def test_file_that_cannot_be_read_is_named_though_all_columns_are_given(tmp_path, command):
    path = tmp_path / "log.csv"
    path.write_bytes("time,position,Moment °\n0,0,0\n".encode("latin-1"))
    columns = ["--time", "time", "--position", "position", "--torque", "Moment"]
    assert "it is no text in UTF-8" in refusal(command, path, *columns)
    assert "cannot be read" in refusal(command, tmp_path / "missing.csv", *columns)


def test_period_serves_instead_of_a_time_and_tables_are_picked_from(log, tmp_path, without_pictures):
    said = "adaptive-ff: warning: the column Time is not read, as --period = 0.005 s is given"
    for clock, warned in (({}, []), ({"Time": log.time}, [said])):
        np.savez(tmp_path / "log.npz", all=np.column_stack([log.position, log.torque]), **clock)
        given = ("--period", "0.005", "--position", "all[0]", "--torque", "all[1]")
        assert identified(tmp_path / "log.npz", *given)[0].warnings == warned


def test_log_whose_clock_begins_anew_is_cut_there_and_nothing_of_it_is_called_skipped(log, tmp_path, without_pictures):
    np.savez(tmp_path / "log.npz", t=np.where(log.time < 7.5, log.time, log.time - 7.5), q=log.position, u=log.torque)
    outcome, _ = identified(tmp_path / "log.npz")
    said = "cut before sample 1500 of the cleaned log: the clock jumps back, from 7.495 s to 0 s"
    assert outcome.warnings == [f"warning: {said}"]


def test_shape_of_an_array_that_holds_several_columns_is_said(tmp_path):
    np.savez(tmp_path / "log.npz", data=np.zeros((100, 3)))
    assert "there are data (100, 3)" in refusal("identify", tmp_path / "log.npz", "--out", tmp_path / "out")


def test_skipped_stretches_are_said_and_listed(log, tmp_path, without_pictures):
    log.torque[2000:2200] = np.nan
    np.savez(tmp_path / "log.npz", t=log.time, q=log.position, u=log.torque)
    outcome, found = identified(tmp_path / "log.npz")
    said = "samples 2000 to 2199 of the cleaned log: values that are no finite numbers"
    assert outcome.warnings == [f"warning: skipped: {said}"]
    assert found["skipped"] == [{"start": 2000, "stop": 2200, "reason": "values that are no finite numbers"}]


def test_joint_that_moves_one_way_gets_no_scenario(tmp_path):
    time = 0.005 * np.arange(8000)
    velocity = 1.0 + 0.5 * np.sin(2.0 * np.pi * 0.5 * time)
    torque = 2.0 * np.gradient(velocity, time) + 3.0 + 4.0 * velocity
    torque += 0.1 * np.random.default_rng(103).standard_normal(time.size)
    write_csv(tmp_path / "log.csv", {"time": time, "velocity": velocity, "torque": torque})
    outcome, found = identified(tmp_path / "log.csv")
    assert found["unidentified"] == {"coulomb": "one_way"}
    assert found["viscous"]["lower"] < 4.0 < found["viscous"]["upper"]
    assert set(content_of(tmp_path / "out")) == FILES - {"scenario.toml", "reference.csv"}
    assert "No scenario is written" in outcome.out
    assert "record both directions" in outcome.out
    assert found["scenario"] is None
    earlier = tmp_path / "out" / "scenario.toml"
    earlier.write_text("# edited by hand\n", encoding="utf-8")
    outcome, _ = identified(tmp_path / "log.csv")
    said = f"so there is no scenario. The scenario.toml in {tmp_path / 'out'} is of an earlier log, not of this one"
    assert said in " ".join(outcome.out.split())
    assert earlier.read_text(encoding="utf-8") == "# edited by hand\n"


def test_simulators_are_written_and_details_printed(tmp_path):
    log = write_log(tmp_path / "log.csv", period=0.005, duration=10.0)
    outcome, _ = identified(log, "--write", "mjcf,urdf", "--details")
    assert set(content_of(tmp_path / "out")) == FILES | {"joint.xml", "joint.urdf"}
    assert "behind one zero-phase low-pass" in outcome.out
    assert 'frictionloss="' in (tmp_path / "out" / "joint.xml").read_text(encoding="utf-8")


def test_voltage_becomes_a_torque_and_its_back_emf_is_said(log, tmp_path, without_pictures):
    write_csv(tmp_path / "log.csv", {"time": log.time, "position": log.position, "duty": log.torque * 2.0 / 0.5 / 24.0})
    motor = ["--voltage", "duty", "--scale", "duty=24", "--resistance", "2", "--torque-constant", "0.5"]
    outcome, found = identified(tmp_path / "log.csv", *motor)
    assert outcome.warnings == ["warning: the torque is that of a voltage: 0.125 N m s/rad of viscous are the back-EMF"]
    assert found["inertia"]["value"] == pytest.approx(2.0, rel=0.01)
    said = refusal("identify", tmp_path / "log.csv", "--voltage", "duty", "--out", tmp_path / "other")
    assert "--voltage takes --resistance, in ohm, positive, and --torque-constant" in said


def test_pictures_and_reports_that_an_earlier_run_left_are_said(tmp_path, monkeypatch):
    log, out = write_log(tmp_path / "log.csv", period=0.005, duration=10.0), tmp_path / "out"
    monkeypatch.setattr(page, "_encoded", lambda *_, **__: "")
    first, _ = identified(log, "--report", "--format", "pdf")
    assert "Of an earlier run" not in first.out
    (out / "identified_map.png").write_bytes(b"of another log")
    (out / "friction.csv").write_text("of a user", encoding="utf-8")
    second, _ = identified(log)
    left = "friction.pdf, identified_map.png, identified_torque.pdf, report.html"
    assert second.out.endswith(f"Of an earlier run, not of this one, in {out}: {left}\n")


REFUSALS = [
    (["--torque", "tau"], "there is no column tau; there are time, position, torque"),
    (["--time", "t"], "there is no column t; there are time, position, torque"),
    (["--position", "position", "--velocity", "w"], "--position and --velocity are both given; give one of them"),
    (["--time", "time", "--period", "0.1"], "--time and --period are both given; give one of them"),
    (["--scale", "torque"], "--scale torque is not allowed: it must be NAME=FACTOR"),
    (["--scale", "torque=x"], "--scale torque=x is not allowed: the factor must be numbers and pi"),
    (["--scale", "torque=1/0"], "--scale torque=1/0 is not allowed"),
    (["--scale", "torque="], "--scale torque= is not allowed"),
    (["--scale", "torque=2", "--scale", "torque=3"], "--scale torque=3 is not allowed: torque has a factor already"),
    (["--scale", "u=2"], "scale: u is no column that is used; these are torque, time, position"),
    (["--scale", "torque=-1"], "friction would drive the joint"),
    (["--scale", "torque=-1"], "are exchanged: give --scale 'torque=-1*-1', or name the others"),
    (["--scale", "time=1e3"], "is the time in milliseconds? Then give --scale 'time=1000*1e-3'"),
    (["--torque", "position"], "the column position is given as torque and as position; each must have its own"),
    (["--bandwidth", "101"], "bandwidth = 101 Hz is not allowed"),
    (["--held-out", "1"], "held_out = 1 is not allowed"),
    (["--gear-ratio", "0"], "--gear-ratio = 0 is not allowed"),
    (["--validate", "missing.csv"], "missing.csv: cannot be read: No such file"),
]


def test_bad_options_are_answered_with_one_line_and_leave_nothing(tmp_path, without_pictures):
    log = write_log(tmp_path / "log.csv", duration=4.0, period=0.004)
    before = content_of(tmp_path)
    for options, message in REFUSALS:
        assert message in refusal("identify", log, *options, "--out", tmp_path / "new" / "out")
        assert content_of(tmp_path) == before


UNNAMED = {
    "stamp,position,torque": "--time must name {} time or t or timestamp; there are stamp, position",
    "time,angle,torque": "--position or --velocity must name {} position or q or",
    "time,position,amps": "--torque must name {} torque or u or effort or current",
}


@pytest.mark.parametrize(("columns", "message"), UNNAMED.items())
def test_column_without_a_usual_name_must_be_named(columns, message, tmp_path):
    (tmp_path / "log.csv").write_text(f"{columns}\n" + "0,1,2\n" * 9, encoding="utf-8")
    said = message.format("a column, as none is called")
    assert said in refusal("identify", tmp_path / "log.csv", "--out", tmp_path / "out")
    assert "--velocity" not in refusal("score", *[tmp_path / "log.csv"] * 2)  # which has no such option


def test_friction_over_a_turn_of_the_motor_is_told_and_drawn(log, tmp_path):
    turn = 2.0 * np.pi / 15.0
    friction = JOINT["coulomb"] * np.sign(motion(log.time)[1])
    torque = log.torque + 0.2 * np.sin(2.0 * np.pi * log.position / turn) * friction
    write_csv(tmp_path / "log.csv", {"time": log.time, "position": log.position, "torque": torque})
    outcome, _ = identified(tmp_path / "log.csv", "--gear-ratio", "15")
    assert outcome.messages == []
    assert set(content_of(tmp_path / "out")) == FILES | {"identified_map.png"}
    assert "friction sine 1" in outcome.out
    scenario = load_scenario(tmp_path / "out" / "scenario.toml")
    assert scenario.adaptation.position_periods == pytest.approx([turn], rel=1e-5)
    assert scenario.variation.position_amplitude == pytest.approx(0.2, abs=0.02)
    assert scenario.variation.position_period == pytest.approx(turn, rel=1e-5)


def test_model_of_a_log_is_scored_on_another_one(tmp_path):
    logs = [write_log(tmp_path / f"{seed}.csv", period=0.005, seed=seed) for seed in (101, 102)]
    outcome = run_command_line("score", *logs, "--out", tmp_path / "out", "--json", tmp_path / "copy.json")
    assert outcome.status == 0, outcome
    assert set(content_of(tmp_path / "out")) == {"score.json", "score.png"}
    assert "in windows of 1 s" in outcome.out
    assert "Verdict: the model follows the joint." in outcome.out
    assert len(outcome.out.splitlines()) <= 25
    found = json.loads((tmp_path / "copy.json").read_text(encoding="utf-8"))
    assert found == json.loads((tmp_path / "out" / "score.json").read_text(encoding="utf-8"))
    assert found["columns"] == {"time": "time", "position": "position", "torque": "torque"}
    assert found["verdict"] == "follows"
    assert found["model"]["inertia"] == pytest.approx(2.0, rel=0.01)
    said = refusal("score", *logs, "--torque-delay", "2", "--out", tmp_path / "other")
    assert "torque_delay = 2 s is not allowed: it must be from -1 to 1 s" in said
