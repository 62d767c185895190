"""Commissioning: from a simulated recording, or a log of a real joint, to a scenario with a bandwidth that suits."""

import json

import numpy as np
import pytest
from command_line import refusal, run_command_line, search_shortly
from scenario_files import built_in, write_scenario

from adaptive_ff import InputError, load_scenario, simulate
from adaptive_ff.files import write_csv
from adaptive_ff.report import page
from adaptive_ff.studies import motion


@pytest.fixture(scope="module")
def commissioned(tmp_path_factory):
    """Run the command once, with a search that is short: the folder, what it printed, and the scenario."""
    folder = tmp_path_factory.mktemp("commissioned")
    content = {**built_in(), "duration": 4.0, "sampling": {"period": 0.002}, "sensor": {"velocity_noise": 5e-4}}
    scenario = write_scenario(folder, content)
    with pytest.MonkeyPatch.context() as monkey:
        search_shortly(monkey)
        monkey.setattr(motion, "ITERATIONS", 10)
        monkey.setattr(page, "_encoded", lambda *_, **__: "")  # its pictures, drawn with others of their kind
        outcome = run_command_line("commission", scenario, "--period", 5, "--out", folder / "out", "--report")
    return folder / "out", outcome, scenario


def test_everything_is_written_and_said_and_the_identified_joint_is_near_the_true_one(commissioned):
    folder, outcome, _ = commissioned
    assert outcome.status == 0, outcome.err
    names = {path.name for path in folder.iterdir()}
    assert names >= {"excitation.csv", "excitation.toml", "log.csv", "scenario.toml"}
    assert names >= {"commission.json", "tune.png", "report.html"}
    assert "On the simulated joint: settled rms error" in outcome.out
    assert "give the log with --log" in outcome.out
    found = load_scenario(folder / "scenario.toml")
    assert found.joint.inertia == pytest.approx(20.0, rel=0.1)
    assert found.joint.coulomb == pytest.approx(60.0, rel=0.15)
    assert found.joint.viscous == pytest.approx(80.0, rel=0.2)
    assert found.feedback.inertia == found.fixed.inertia == found.joint.inertia
    assert found.sampling.period == 0.002


def test_gain_is_that_of_runs_on_the_true_joint(commissioned):
    folder, _, given = commissioned
    summary = json.loads((folder / "commission.json").read_text())
    gain, result = summary["gain"], load_scenario(folder / "scenario.toml")
    assert gain["after_bandwidth"] == result.feedback.hertz
    assert gain["after_bandwidth"] == pytest.approx(summary["bandwidth"]["adaptive"]["best_bandwidth"], rel=1e-3)
    assert gain["after"] < gain["before"]
    seeded = [load_scenario(given).modified(seed=seed) for seed in range(1, 6)]
    before = sorted(simulate(one, "pi").metrics.rms_error_settled for one in seeded)
    assert gain["before"] == before[2]


def test_log_takes_the_place_of_the_recording(commissioned, tmp_path, monkeypatch, without_pictures):
    folder, _, scenario = commissioned
    search_shortly(monkeypatch)
    held = ("--torque-delay", "0.001")  # over the period of 2 ms that begins with a row
    outcome = run_command_line("commission", scenario, "--log", folder / "log.csv", *held, "--out", tmp_path / "again")
    assert outcome.status == 0, outcome.err
    assert "On the simulated joint" not in outcome.out
    said = " ".join(outcome.out.split())
    assert "Columns: time time, velocity velocity, torque torque." in said
    assert f"sampling, drive, sensor and reference are those of {scenario}, not of the log" in said
    assert not (tmp_path / "again" / "excitation.csv").exists()
    again, first = (load_scenario(path / "scenario.toml") for path in (tmp_path / "again", folder))
    assert again == first


def test_torque_of_a_log_acts_at_its_stamp_unless_said_otherwise(commissioned, tmp_path, monkeypatch):
    folder, _, scenario = commissioned
    delays = []

    def seen(log, *, torque_delay, **_):
        delays.append(torque_delay)
        raise InputError("seen")

    monkeypatch.setattr("adaptive_ff.identify_log", seen)
    given = ("commission", scenario, "--log", folder / "log.csv", "--out", tmp_path / "again")
    assert refusal(*given) == "adaptive-ff: seen"
    assert refusal(*given, "--torque-delay", "0.003") == "adaptive-ff: seen"
    assert delays == [None, 0.003]  # not known is taken for zero
    assert "--torque-delay are those of a --log" in refusal("commission", scenario, "--torque-delay", "0.003")
    assert "are those of a --log; give one" in refusal("commission", scenario, "--torque-column", "u")


def test_log_in_other_columns_and_units_is_the_same_log(commissioned, tmp_path, monkeypatch, without_pictures):
    folder, _, scenario = commissioned
    search_shortly(monkeypatch)
    series = np.genfromtxt(folder / "log.csv", delimiter=",", names=True)
    changed = {"ms": 1e3 * series["time"], "w": np.degrees(series["velocity"]), "i_q": series["torque"] / 8.0}
    write_csv(tmp_path / "log.csv", changed)
    named = ["--time-column", "ms", "--velocity-column", "w", "--torque-column", "i_q"]
    scaled = ["--scale", "ms=1e-3", "--scale", "w=pi/180", "--torque-constant", "8", "--torque-delay", "0.001"]
    again = ["commission", scenario, "--log", tmp_path / "log.csv", "--out", tmp_path / "again"]
    assert run_command_line(*again, *named, *scaled).status == 0
    found, first = (load_scenario(path / "scenario.toml") for path in (tmp_path / "again", folder))
    assert found.joint.coulomb == pytest.approx(first.joint.coulomb, rel=1e-4)
    assert found.feedback.bandwidth == pytest.approx(first.feedback.bandwidth, rel=1e-3)
    assert "the column i_q seems to be a current in A; give --torque-constant" in refusal(*again, *named, *scaled[:4])
    assert "--torque-column must name a column, as none is called torque" in refusal(*again, *named[:4])


def test_log_that_tells_nothing_is_refused(commissioned, tmp_path):
    rows = "\n".join(f"{0.002 * k:g},0,1" for k in range(2000))
    (tmp_path / "log.csv").write_text(f"time,velocity,torque\n{rows}\n")
    line = refusal("commission", commissioned[2], "--log", tmp_path / "log.csv", "--out", tmp_path / "out")
    assert "log.csv" in line
    assert not (tmp_path / "out").exists()
