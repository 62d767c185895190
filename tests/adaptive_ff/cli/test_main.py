"""The command line: what it writes and prints, and what it leaves alone when it refuses."""

import json
import os
import subprocess
import sys
from concurrent.futures.process import BrokenProcessPool
from importlib.metadata import version
from unittest.mock import patch

import numpy as np
import pytest
from command_line import content_of, refusal, run_command_line
from scenario_files import changed, short, to_toml, write_scenario

from adaptive_ff import compare, load_scenario

pytestmark = pytest.mark.usefixtures("compiled")

METRICS = {*("rms_error", "max_error", "rms_error_start", "rms_error_settled", "max_error_settled", "torque_variation")}
ESTIMATED = {"inertia", "coulomb", "stiction", "viscous", "friction_lag", "offset", "gravity_sin", "gravity_cos"}
ESTIMATED |= {"stribeck_velocity", "presliding"}
COLUMNS = ["time", "reference", "velocity", "measured", "torque", "feedforward", "friction"]


def motion_file(folder, lines=None):
    path = folder / "motion.csv"
    lines = [f"{0.1 * k},{0.1 * np.sin(0.2 * np.pi * k / 10)}" for k in range(101)] if lines is None else lines
    path.write_text("\n".join(["time,velocity", *lines]), encoding="utf-8")
    return path


def test_comparison_writes_the_documented_files_and_nothing_else(tmp_path):
    content = {**short(), "controllers": ["pi", "adaptive"], "change": [{"time": 0.2, "friction_scale": 0.6}]}
    scenario = write_scenario(tmp_path, content)
    out, copy = tmp_path / "new" / "out", tmp_path / "other" / "copy.json"
    outcome = run_command_line("compare", scenario, "--out", out, "--json", copy)
    assert (outcome.status, outcome.err) == (0, "")
    pictures = {"tracking.png", "torque.png", "estimates.png", "stribeck.png", "supervision.png"}
    assert set(content_of(out)) == {"pi.csv", "adaptive.csv", "result.json", *pictures}
    for name in pictures:
        assert (out / name).read_bytes().startswith(b"\x89PNG")
    assert set(content_of(copy.parent)) == {"copy.json"}
    assert copy.read_bytes() == (out / "result.json").read_bytes()
    result = json.loads(copy.read_text(encoding="utf-8"))
    assert set(result) == {"version", "scenario", "controllers", "improvement", "verdict"}
    assert result.pop("version") == version("adaptive-ff")
    assert result.pop("verdict")["best"] in ("pi", "adaptive")
    assert set(result["controllers"]["pi"]) == METRICS
    assert set(result["controllers"]["adaptive"]) == {*METRICS, "estimates"}
    assert set(result["controllers"]["adaptive"]["estimates"]) == ESTIMATED
    settled = {name: result["controllers"][name]["rms_error_settled"] for name in ("pi", "adaptive")}
    assert result["improvement"] == {"pi": 1.0, "adaptive": settled["pi"] / settled["adaptive"]}
    assert result == compare(load_scenario(scenario)).to_dict()
    assert load_scenario(write_scenario(tmp_path, result["scenario"], "again.toml")) == load_scenario(scenario)


def test_csv_and_printed_table_hold_the_series_and_the_figures_of_the_runs(tmp_path, without_pictures):
    scenario = write_scenario(tmp_path, {**short(), "controllers": ["pi", "oracle", "adaptive"]})
    outcome = run_command_line("compare", scenario, "--out", tmp_path / "out")
    assert outcome.status == 0
    comparison = compare(load_scenario(scenario))
    adaptive = comparison.runs["adaptive"]
    values = np.genfromtxt(tmp_path / "out" / "adaptive.csv", delimiter=",", names=True)
    header = list(values.dtype.names)
    assert header[:7] == COLUMNS
    watched = {"change_probability", "observer_gain", "observer_torque"}
    assert set(header[7:]) == {f"estimated_{name}" for name in adaptive.estimates} | watched
    assert values["time"] == pytest.approx(0.01 * np.arange(50), abs=1e-12)
    assert values["velocity"] == pytest.approx(adaptive.velocity[:-1:10], rel=1e-9)
    assert values["torque"] == pytest.approx(adaptive.torque, rel=1e-9)
    assert values["estimated_inertia"][-1] == pytest.approx(adaptive.final_estimates["inertia"], rel=1e-9)
    rows = {line.split()[0]: line.split()[1:] for line in outcome.out.splitlines() if line.strip()}
    for name, run in comparison.runs.items():
        assert float(rows[name][0]) == pytest.approx(1e3 * run.metrics.rms_error_settled, rel=1e-2)
        assert float(rows[name][1]) == pytest.approx(comparison.improvement[name], abs=0.01)
    assert float(rows["viscous,"][-3]) == pytest.approx(adaptive.final_estimates["viscous"], rel=1e-3)
    assert outcome.out.rstrip().endswith(f"are in {tmp_path / 'out'}")


def test_files_of_a_former_run_are_replaced_and_others_stay(tmp_path, scenario, without_pictures):
    out = tmp_path / "out"
    out.mkdir()
    (out / "pi.csv").write_text("old", encoding="utf-8")
    (out / "notes.txt").write_text("mine", encoding="utf-8")
    for name in ("oracle.csv", "stribeck.png"):
        (out / name).write_text("of other controllers", encoding="utf-8")
    outcome = run_command_line("compare", scenario, "--out", out)
    assert outcome.status == 0
    assert outcome.out.endswith(f"Of an earlier run, not of this one, in {out}: oracle.csv, stribeck.png\n")
    assert set(content_of(out)) == {"pi.csv", "result.json", "notes.txt", "oracle.csv", "stribeck.png"}
    assert (out / "pi.csv").read_text(encoding="utf-8").startswith("time,")
    assert (out / "notes.txt").read_text(encoding="utf-8") == "mine"


def test_without_a_file_it_runs_the_built_in_scenario_into_the_folder_results(tmp_path, monkeypatch, without_pictures):
    monkeypatch.chdir(tmp_path)

    def brief(scenario, **options):
        return compare(scenario.modified(duration=0.1))

    with patch("adaptive_ff.comparison.comparison.compare", brief):
        outcome = run_command_line("compare")
    assert outcome.status == 0
    result = json.loads((tmp_path / "results" / "result.json").read_text(encoding="utf-8"))
    assert result["scenario"]["joint"]["inertia"] == 20.0
    assert set(result["controllers"]) == {"pi", "fixed", "oracle", "adaptive_paper", "adaptive"}


def test_recorded_reference_takes_the_place_of_that_of_the_file(tmp_path, monkeypatch, without_pictures):
    gone = {"kind": "csv", "path": "gone.csv"}
    scenario = write_scenario(tmp_path, {**short(), "reference": gone})
    assert "gone.csv: cannot be read" in refusal("compare", scenario, "--out", tmp_path / "out")
    motion_file(tmp_path)
    monkeypatch.chdir(tmp_path)  # given on the command line, a path is relative to where that is
    outcome = run_command_line("compare", scenario, "--reference", "motion.csv", "--out", "out")
    assert (outcome.status, outcome.err) == (0, "")
    result = json.loads((tmp_path / "out" / "result.json").read_text(encoding="utf-8"))
    assert (result["scenario"]["reference"]["kind"], result["scenario"]["reference"]["path"]) == ("csv", "motion.csv")
    reference = np.loadtxt("out/pi.csv", delimiter=",", skiprows=1)[:, 1]
    assert reference == pytest.approx(0.1 * np.sin(0.2 * np.pi * 0.01 * np.arange(50)), abs=1e-4)


def test_joint_that_never_moves_is_compared_all_the_same(tmp_path, without_pictures):
    scenario = write_scenario(tmp_path, changed({**short(), "controllers": ["pi", "oracle"]}, "sensor", {}))
    motion = motion_file(tmp_path, [f"{k},0" for k in range(61)])
    outcome = run_command_line("compare", scenario, "--reference", motion, "--out", tmp_path / "out")
    assert (outcome.status, outcome.err) == (0, "")
    assert json.loads((tmp_path / "out" / "result.json").read_text(encoding="utf-8"))["improvement"] == {}


@pytest.mark.parametrize(("field", "value"), [("actuator.torque_limit", 50.0), ("joint.stribeck_shape", 0.9)])
def test_what_is_probably_not_meant_is_warned_of_and_runs(tmp_path, without_pictures, field, value):
    content = changed(changed(short(), "joint.solver_period", 0.0001), field, value)
    scenario = write_scenario(tmp_path, content)
    outcome = run_command_line("compare", scenario, "--out", tmp_path / "out")
    assert (outcome.status, outcome.messages) == (0, [])
    assert outcome.warnings == [f"warning: {caution}" for caution in load_scenario(scenario).cautions()]
    assert len(outcome.warnings) == 1


@pytest.mark.parametrize(("axis", "unit"), [("rotary", "rad/s"), ("linear", "m/s")])
def test_seam_of_a_repeated_motion_is_warned_of(tmp_path, without_pictures, axis, unit):
    scenario = write_scenario(tmp_path, changed({**short(), "duration": 9.0}, "joint.axis", axis))
    motion = motion_file(tmp_path, ["0,0", "1,0.1", "2,0.1", "3,0.1"])
    outcome = run_command_line("compare", scenario, "--reference", motion, "--out", tmp_path / "out")
    assert (outcome.status, outcome.messages) == (0, [])
    assert set(outcome.warnings) == {
        f"adaptive-ff: warning: {motion}: the motion is repeated every 3 s, but ends 0.1 {unit} away from where it "
        "starts: the reference jumps there"
    }


def test_without_a_command_it_shows_the_commands():
    outcome = run_command_line()
    assert (outcome.status, outcome.err) == (2, "")
    assert "compare" in outcome.out


def test_numbers_without_a_solution_are_refused_and_a_defect_of_the_program_is_not_taken_for_one(tmp_path, scenario):
    command, compared = ("compare", scenario, "--out", tmp_path / "out"), "adaptive_ff.comparison.comparison.compare"
    with patch(compared, lambda *_, **__: np.linalg.inv(np.zeros((2, 2)))):
        line = refusal(*command)
    assert "numbers are too large, too small or too much alike to compute with (Singular matrix)" in line
    with patch(compared, side_effect=BrokenProcessPool):
        assert "a worker process ended" in refusal(*command)
    with patch(compared, lambda *_, **__: 1 + None), pytest.raises(TypeError):
        run_command_line(*command)
    assert not (tmp_path / "out").exists()


UNDRAWN = """
import runpy
from matplotlib.figure import Figure
from adaptive_ff.report import style
write = style.write_figure
style.write_figure = lambda _, path: write(Figure((1.0, 1.0), layout="tight"), path)
runpy.run_module("adaptive_ff", run_name="__main__")
"""
"""``python -m adaptive_ff``, its pictures blank."""


def run_module(*arguments, folder):
    command = [sys.executable, "-c", UNDRAWN, *arguments]
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "COLUMNS": "120"}  # a terminal without a superscript two
    environment.pop("FORCE_COLOR", None)
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def test_as_a_process_of_its_own(tmp_path):
    write_scenario(tmp_path, {**short(), "controllers": ["adaptive"]})
    done = run_module("compare", "scenario.toml", "--out", "out", "--json", "copy.json", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "inertia, kg m?" in done.stdout
    assert {"adaptive.csv", "result.json", "tracking.png"} <= set(content_of(tmp_path / "out"))
    (tmp_path / "scenario.toml").write_text(to_toml({**short(), "seed": -1}), encoding="utf-8")
    before = content_of(tmp_path)
    done = run_module("compare", "scenario.toml", "--out", "again", folder=tmp_path)
    said = "adaptive-ff: scenario.toml: seed = -1 is not allowed: it must be greater than or equal to 0\n"
    assert (done.returncode, done.stdout, done.stderr) == (2, "", said)
    assert content_of(tmp_path) == before


def test_a_scenario_with_a_byte_order_mark_is_one(tmp_path):
    path = write_scenario(tmp_path, short())
    marked = tmp_path / "marked.toml"
    marked.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert load_scenario(marked) == load_scenario(path)
