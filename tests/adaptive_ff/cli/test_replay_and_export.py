"""``adaptive-ff replay`` and ``adaptive-ff export``: what they write and print, and what they refuse."""

import json
import re

import numpy as np
import pytest
from command_line import content_of, refusal, run_command_line
from exports import inputs, made, steps_in_python
from synthetic_logs import make_log

from adaptive_ff.files import write_csv
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.replay import replay_log
from adaptive_ff.scenario.new import new_scenario_text

FILES = {"replay.json", "replay.png", "estimates.png"}
OPTIONS = ("--position", "q_deg", "--scale", "q_deg=pi/180", "--feedforward", "own")


def write_log(path):
    log = make_log(noise=0.05, duration=20.0, period=0.005)
    columns = {"time": log.time, "q_deg": np.degrees(log.position), "torque": log.torque}
    write_csv(path, {**columns, "own": 0.5 * log.torque})
    return path


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("replay")
    log = write_log(folder / "log.csv")
    run_command_line("replay", log, *OPTIONS, "--out", folder / "compiled")
    places = ("--out", folder / "out", "--json", folder / "own" / "copy.json", "--save-state", folder / "state.json")
    outcome = run_command_line("replay", log, *OPTIONS, *places)
    assert (outcome.status, outcome.messages) == (0, []), outcome
    return folder, outcome


@pytest.mark.usefixtures("result")  # a first run says that it compiles
def test_values_that_no_machine_has_are_refused_in_a_line(tmp_path):
    log = write_log(tmp_path / "log.csv")
    for option, value in (("--stribeck-velocity", "-1"), ("--band", "0"), ("--memory", "0"), ("--inertia", "nan")):
        line = refusal("replay", log, *OPTIONS, option, value, "--out", tmp_path / "out")
        assert line.startswith(f"adaptive-ff: {option.removeprefix('--').replace('-', '_')} = ")
    assert not (tmp_path / "out").exists()


def test_files_table_and_function_say_the_same(result):
    folder, outcome = result
    assert set(content_of(folder / "out")) == FILES
    found = json.loads((folder / "own" / "copy.json").read_text(encoding="utf-8"))
    assert found == json.loads((folder / "out" / "replay.json").read_text(encoding="utf-8"))
    left = found["left"]
    assert list(left) == ["none", "fixed", "recorded", "adaptive"]
    assert left["recorded"]["whole"] == pytest.approx(0.5 * left["none"]["whole"], rel=1e-2)
    assert left["adaptive"]["second_half"] < 0.1 * left["none"]["second_half"]
    assert found["samples"] == {"log": 4000, "used": 4000}
    for words, name in (("none", "none"), ("the machine's own", "recorded"), ("adaptive, cold", "adaptive")):
        (line,) = [line for line in outcome.out.splitlines() if line.strip().startswith(words)]
        assert f"{1e3 * left[name]['whole']:.0f}" in line or f"{left[name]['whole']:#.3g}" in line
    assert "in its loop the controller learns along its reference" in outcome.out
    table = np.loadtxt(folder / "log.csv", delimiter=",", skiprows=1)
    extra = {"feedforward": table[:, 3]}
    log = Log("log", table[:, 0], table[:, 2], position=table[:, 1] * (np.pi / 180.0), extra=extra)
    assert replay_log(log).to_dict()["left"] == left


def test_saved_state_is_where_the_next_log_starts(result, without_pictures):
    folder, _ = result
    state = folder / "state.json"
    outcome = run_command_line("replay", folder / "log.csv", *OPTIONS, "--state", state, "--out", folder / "next")
    assert (outcome.status, outcome.messages) == (0, []), outcome
    found = json.loads((folder / "next" / "replay.json").read_text(encoding="utf-8"))
    assert found["left"]["adaptive_saved"]["whole"] < found["left"]["adaptive"]["whole"]
    again, broken = ("replay", folder / "log.csv", *OPTIONS, "--out", folder / "x", "--state"), folder / "broken.json"
    broken.write_text("{", encoding="utf-8")
    assert "identify and ripple_periods must be alike" in refusal(*again, state, "--identify", "gravity")
    assert f"{broken}: is no saved state of a replay" in refusal(*again, broken)
    assert "; there must be at least 30: record for longer, or widen the band" in refusal(*again[:-1], "--band", "1e-3")


def test_linear_axis_has_its_units(result, tmp_path, without_pictures):
    folder, _ = result
    outcome = run_command_line("replay", folder / "log.csv", *OPTIONS, "--linear", "--out", tmp_path)
    assert re.search(r"^ +[mµ]?N +[mµ]?N +[mµ]?N$", outcome.out, re.MULTILINE)
    assert json.loads((tmp_path / "replay.json").read_text(encoding="utf-8"))["unit"] == "N"


def test_it_writes_the_adaptive_controller_of_the_built_in_scenario(tmp_path):
    outcome = run_command_line("export", "--out", tmp_path / "out")
    assert outcome.status == 0
    assert outcome.err == ""
    names = {"adaptive.h", "adaptive.c", "adaptive_selftest.c", "main.c", "CMakeLists.txt"}
    assert {path.name for path in (tmp_path / "out").iterdir()} == names
    assert all(name in outcome.out for name in names)
    assert ".torque_limit = 400.0" in (tmp_path / "out" / "adaptive.c").read_text()


def test_controller_prefix_precision_and_fmu_are_chosen(tmp_path):
    options = ("--controller", "oracle", "--prefix", "axis1", "--float", "--fmu", "3.0")
    assert run_command_line("export", *options, "--out", tmp_path).status == 0
    assert "float torque;" in (tmp_path / "axis1.h").read_text()
    assert (tmp_path / "axis1.fmu").stat().st_size > 5000
    assert run_command_line("export", "--controller", "pi", "--out", tmp_path).status == 0
    assert "realised_torque" in (tmp_path / "main.c").read_text()  # which is not given the limit of the drive


def test_it_starts_in_a_saved_state(tmp_path):
    controller = made("adaptive")
    steps_in_python(controller, inputs(controller, 60))
    (tmp_path / "state.json").write_text(controller.state_to_json())
    assert run_command_line("export", "--state", tmp_path / "state.json", "--out", tmp_path / "out").status == 0
    text = (tmp_path / "out" / "adaptive.c").read_text()
    assert repr(controller.estimates["inertia"]) in text[text.index("START_STATE") :]


def test_refusals_name_what_is_wrong_and_write_nothing(tmp_path):
    texts = {"broken": "{", "number": "3", "replay": '{"replay": ["inertia"]}', "file": ""}
    texts["pi"] = made("pi").state_to_json()
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    of_a_replay = "is the state of a replay, not of a controller; identify the log, and give its scenario.toml"
    out, file = ("--out", tmp_path / "out"), tmp_path / "file"
    cases = {
        ("--controller", "none"): "controllers = 'none' is not known; there are pi,",
        ("--fmu", "1.0"): "version of FMI '1.0' is not known; there are 2.0, 3.0",
        ("--prefix", "1st"): "prefix = '1st' is not allowed",
        ("--state", tmp_path / "pi"): "controller = 'PI' is not allowed: this is a 'AdaptiveController'",
        ("--state", tmp_path / "broken"): "is no saved state",
        ("--state", tmp_path / "number"): "must be a JSON object",
        ("--state", tmp_path / "replay"): of_a_replay,
        ("--state", tmp_path / "missing.json"): "cannot be read",
        (tmp_path / "missing.toml",): "missing.toml",
    }
    for options, message in cases.items():
        assert message in refusal("export", *options, *out)
    assert "cannot be written" in refusal("export", "--out", file)
    assert not (tmp_path / "out").exists()
    assert file.read_text() == ""


def test_a_scenario_without_a_limit_of_the_drive_is_exported_without_one(tmp_path):
    """As ``identify`` writes it: no log tells the limit."""
    text = new_scenario_text(0.5, 123.5, 6.0)
    scenario = "".join(line for line in text.splitlines(keepends=True) if not line.startswith("torque_limit"))
    (tmp_path / "scenario.toml").write_text(scenario)
    outcome = run_command_line("export", tmp_path / "scenario.toml", "--out", tmp_path / "out")
    assert (outcome.status, outcome.err) == (0, "")
    assert ".torque_limit = (double)INFINITY" in (tmp_path / "out" / "adaptive.c").read_text()
