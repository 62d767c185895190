"""``adaptive-ff replay``: what it writes, what it prints, and what it refuses."""

import inspect
import json

import numpy as np
import pytest
from command_line import content_of, refusal, run_command_line
from synthetic_logs import make_log

from adaptive_ff import InputError
from adaptive_ff.cli.replay import replay_command
from adaptive_ff.files import write_csv
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.replay import replay_log
from adaptive_ff.replay.settings import GIVEN

FILES = {"replay.json", "replay.png", "estimates.png"}


def write_log(path, **options):
    log = make_log(**{"noise": 0.05, "duration": 20.0, **options})
    velocity = make_log(duration=20.0, as_position=False).velocity
    columns = {"time": log.time, "q_deg": np.degrees(log.position), "torque": log.torque}
    write_csv(path, {**columns, "wanted": velocity, "own": 0.5 * log.torque})
    return path


OPTIONS = ("--position", "q_deg", "--scale", "q_deg=pi/180", "--reference-velocity", "wanted", "--feedforward", "own")


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("replay")
    log = write_log(folder / "log.csv")
    run_command_line("replay", log, *OPTIONS, "--out", folder / "compiled")
    places = ("--out", folder / "out", "--json", folder / "own" / "copy.json", "--save-state", folder / "state.json")
    outcome = run_command_line("replay", log, *OPTIONS, *places)
    assert (outcome.status, outcome.messages) == (0, []), outcome
    return folder, outcome


@pytest.mark.parametrize(
    ("option", "value"), [("--loop-bandwidth", "1e9"), ("--stribeck-velocity", "1e9"), ("--band", "1e-300")]
)
def test_values_that_no_machine_has_are_refused_in_a_line(tmp_path, option, value):
    line = refusal("replay", write_log(tmp_path / "log.csv"), *OPTIONS, option, value, "--out", tmp_path / "out")
    assert line.startswith(f"adaptive-ff: {option.removeprefix('--').replace('-', '_')} = ")
    assert not (tmp_path / "out").exists()


def test_degrees_of_a_reference_are_pointed_out(tmp_path):
    log = write_log(tmp_path / "log.csv")
    columns = ("--position", "q_deg", "--scale", "q_deg=pi/180", "--reference-position", "wanted_deg")
    text = log.read_text(encoding="utf-8").replace("wanted", "wanted_deg", 1)
    log.write_text(text, encoding="utf-8")
    outcome = run_command_line("replay", log, *columns, "--out", tmp_path / "out")
    assert "the column wanted_deg seems to be in degrees, but is taken as radians" in " ".join(outcome.err.split())
    assert "q_deg seems" not in outcome.err


def test_files_are_written(result):
    folder, _ = result
    assert set(content_of(folder / "out")) == FILES
    for name in FILES - {"replay.json"}:
        assert (folder / "out" / name).read_bytes().startswith(b"\x89PNG")


def test_json_and_table_say_the_same(result):
    folder, outcome = result
    found = json.loads((folder / "own" / "copy.json").read_text(encoding="utf-8"))
    assert found == json.loads((folder / "out" / "replay.json").read_text(encoding="utf-8"))
    left = found["left"]
    assert list(left) == ["none", "recorded", "fixed", "adaptive"]
    assert left["recorded"]["whole"] == pytest.approx(0.5 * left["none"]["whole"], rel=1e-6)
    assert left["adaptive"]["second_half"] < 0.1 * left["none"]["second_half"]
    assert found["settings"]["identify"] == "offset"
    assert found["samples"] == {"log": 10000, "used": 10000}
    for words, name in (
        ("none", "none"),
        ("the machine's own, as recorded", "recorded"),
        ("adaptive, cold", "adaptive"),
    ):
        (line,) = [line for line in outcome.out.splitlines() if line.strip().startswith(words)]
        assert f"{left[name]['whole']:.3g}" in line
        assert f"{left[name]['second_half']:.3g}" in line
    assert "Torque left to the feedback, rms in N m, in a band of 20 Hz" in outcome.out
    assert "Not given, but taken from the log" in outcome.out
    assert f"coulomb {found['estimates']['adaptive']['coulomb']:.4g} N m" in outcome.out


def test_saved_state_is_where_the_next_log_starts(result):
    folder, _ = result
    state = folder / "state.json"
    again = ("--state", state, "--save-state", folder / "second.json", "--out", folder / "next")
    outcome = run_command_line("replay", folder / "log.csv", *OPTIONS, *again)
    assert (outcome.status, outcome.messages) == (0, []), outcome
    found = json.loads((folder / "next" / "replay.json").read_text(encoding="utf-8"))
    assert found["left"]["adaptive_saved"]["whole"] < found["left"]["adaptive"]["whole"]
    assert "adaptive, from the saved state" in outcome.out
    second = json.loads((folder / "second.json").read_text(encoding="utf-8"))
    estimate = second["state"]["estimator"]["recursion"]["estimate"]
    assert estimate[:2] == [found["estimates"]["adaptive_saved"][name] for name in ("inertia", "coulomb")]


def test_command_and_function_agree(result):
    folder, _ = result
    found = json.loads((folder / "out" / "replay.json").read_text(encoding="utf-8"))
    table = np.loadtxt(folder / "log.csv", delimiter=",", skiprows=1)
    extra = {"reference_velocity": table[:, 3], "feedforward": table[:, 4]}
    log = Log("log", table[:, 0], table[:, 2], position=table[:, 1] * (np.pi / 180.0), extra=extra)
    assert replay_log(log).to_dict()["left"] == found["left"]


def test_linear_axis_has_its_units(result, tmp_path):
    folder, _ = result
    outcome = run_command_line("replay", folder / "log.csv", *OPTIONS, "--linear", "--out", tmp_path)
    assert "rms in N, in" in outcome.out
    assert json.loads((tmp_path / "replay.json").read_text(encoding="utf-8"))["unit"] == "N"


def test_skips_are_said(result, tmp_path):
    log = make_log(duration=20.0)
    torque = log.torque.copy()
    torque[100:110] = np.nan
    write_csv(tmp_path / "log.csv", {"time": log.time, "position": log.position, "torque": torque})
    outcome = run_command_line("replay", tmp_path / "log.csv", "--out", tmp_path / "out")
    assert outcome.status == 0
    assert outcome.warnings == ["warning: skipped: samples 100 to 109: values that are no finite numbers"]


@pytest.mark.parametrize(
    ("options", "parts"),
    [
        (("--reference-position", "wanted"), ("--reference-velocity and --reference-position are both given",)),
        (("--feedforward", "nothing"), ("there is no column nothing",)),
        (("--period", "1", "--time", "time"), ("--time and --period are both given",)),
        (("--memory", "0"), ("memory = 0 is not allowed: it must be positive",)),
        (("--band", "-1"), ("band = -1 Hz is not allowed",)),
        (("--identify", "all"), ("identify = 'all'", "symmetric, offset, directions")),
        (("--state", "missing.json"), ("missing.json: cannot be read",)),
    ],
)
def test_bad_options_are_refused_and_nothing_is_written(result, tmp_path, options, parts):
    folder, _ = result
    line = refusal("replay", folder / "log.csv", *OPTIONS, "--out", tmp_path / "out", *options)
    for part in parts:
        assert part in line
    assert content_of(tmp_path) == {}


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"settings": 3}', '{"settings": {}}', "\x00"])
def test_damaged_state_is_refused(result, tmp_path, text):
    folder, _ = result
    state = tmp_path / "state.json"
    state.write_text(text, encoding="utf-8")
    line = refusal("replay", folder / "log.csv", *OPTIONS, "--out", tmp_path / "out", "--state", state)
    assert line.startswith(f"adaptive-ff: {state}: ")


def test_state_with_a_field_of_another_kind_is_refused(result, tmp_path):
    folder, _ = result
    content = json.loads((folder / "state.json").read_text(encoding="utf-8"))
    content["settings"]["memory"] = "long"
    (tmp_path / "state.json").write_text(json.dumps(content), encoding="utf-8")
    options = ("--out", tmp_path / "out", "--state", tmp_path / "state.json")
    assert "memory = 'long' is not allowed" in refusal("replay", folder / "log.csv", *OPTIONS, *options)


def test_every_setting_of_a_replay_is_an_option():
    options = {name.replace("_periods", "_period") for name in GIVEN}  # an option is given once for each period
    assert options <= set(inspect.signature(replay_command).parameters)


def test_setting_that_there_is_not_is_refused():
    with pytest.raises(InputError, match="speed = 3 is no setting of a replay; allowed: inertia, stribeck_velocity"):
        replay_log(make_log(duration=20.0), speed=3)


def test_a_current_is_replayed_in_amperes_unless_its_constant_is_given(tmp_path):
    log = make_log(noise=0.05, duration=20.0)
    write_csv(tmp_path / "log.csv", {"time": log.time, "position": log.position, "current": 2.0 * log.torque})
    amperes = run_command_line("replay", tmp_path / "log.csv", "--torque", "current", "--out", tmp_path / "a")
    assert "rms in A," in " ".join(amperes.out.split())
    assert json.loads((tmp_path / "a" / "replay.json").read_text())["unit"] == "A"
    options = ("--torque", "current", "--torque-constant", "0.5", "--out", tmp_path / "b")
    run_command_line("replay", tmp_path / "log.csv", *options)
    found, inertia = json.loads((tmp_path / "b" / "replay.json").read_text()), 2.0
    assert found["unit"] == "N m"
    assert found["estimates"]["adaptive"]["inertia"] == pytest.approx(inertia, rel=0.1)
