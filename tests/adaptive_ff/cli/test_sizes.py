"""What every command prints by default fits a terminal of 80 columns and 30 lines, paths apart."""

import pytest
from command_line import run_command_line, search_shortly
from scenario_files import short, write_scenario
from synthetic_logs import write_log

from adaptive_ff.report.matrix_files import matrix_tables
from adaptive_ff.report.tables import gains_table, ranking_table
from adaptive_ff.scenario.library import scenario_names
from adaptive_ff.scenario.loop import tried_bandwidths
from adaptive_ff.studies import bandwidth_study
from adaptive_ff.studies.matrix import Job, collect

WIDTH, HEIGHT = 80, 30

pytestmark = pytest.mark.usefixtures("compiled")


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    return write_log(tmp_path_factory.mktemp("sizes") / "log.csv", duration=10.0, period=0.005, noise=0.1)


def check(text, height=HEIGHT):
    lines = text.splitlines()
    assert len(lines) <= height, text
    assert [line for line in lines if len(line) > WIDTH and " " in line.strip()] == []


@pytest.mark.parametrize(
    "command",
    [
        ["compare"],
        ["compare", "SCENARIO"],
        ["scenarios"],
        ["scenarios", "lugre"],
        ["sweep", "--runs", "2", "--controller", "fixed"],
        ["identify", "LOG"],
        ["replay", "LOG"],
        ["score", "LOG", "LOG"],
        ["tune", "SCENARIO", "--seeds", "1", "--tuning-seeds", "1"],
        ["matrix", "--only", "paper_100hz", "--seeds", "1"],
        ["excite", "--period", "5", "--fastest", "1"],
        ["commission", "SCENARIO", "--log", "LOG"],
        ["new", "--inertia", "20", "--torque", "400", "--speed", "3"],
        ["new", "--inertia", "20", "--torque", "400", "--speed", "3", "--encoder", "100000", "--gear-ratio", "50"],
        ["export"],
        ["version"],
    ],
    ids=" ".join,
)
def test_output_fits_a_terminal(command, log, tmp_path, monkeypatch, without_pictures):
    monkeypatch.chdir(tmp_path)
    search_shortly(monkeypatch)
    monkeypatch.setattr(bandwidth_study, "tried_bandwidths", lambda scenario: tried_bandwidths(scenario)[-2:])
    places = {"LOG": log, "SCENARIO": write_scenario(tmp_path, {**short(), "duration": 2.0})}
    outcome = run_command_line(*(places.get(word, word) for word in command), columns=WIDTH)
    assert outcome.status == 0, outcome.err
    check(outcome.out, 36 if command[0] == "new" else HEIGHT)  # a file, to be redirected


def test_matrix_of_all_scenarios_fits_a_terminal():
    names = ("pi", "oracle", "lagged_batch", "adaptive")
    found = {Job(name, 1, False): {one: {"rms_error_settled": 1e-3} for one in names} for name in scenario_names()}
    (table,) = matrix_tables(found)
    assert len(table.rows) <= HEIGHT - 10
    assert sum(max(map(len, column)) + 2 for column in zip(*table.rows, strict=True)) <= WIDTH
    heads = [head for make in (gains_table, ranking_table) for head in make(collect(found), "").heads]
    assert not any("own" in head or " it" in f" {head} " for head in heads)
