"""``adaptive-ff score``: a model of one log, simulated on another one."""

import json

import pytest
from command_line import content_of, refusal, run_command_line
from synthetic_logs import write_log


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("score")
    logs = [write_log(folder / "train.csv"), write_log(folder / "test.csv", seed=102)]
    outcome = run_command_line("score", *logs, "--out", folder / "out", "--json", folder / "copy.json")
    return folder, outcome


def test_it_prints_errors_and_verdict_and_writes_its_files(result):
    folder, outcome = result
    assert outcome.status == 0, outcome
    assert set(content_of(folder / "out")) == {"score.json", "score.png"}
    assert "in windows of 1 s" in outcome.out
    assert "Verdict: the model follows the joint." in outcome.out
    assert len(outcome.out.splitlines()) <= 25


def test_the_copy_is_the_same_and_names_the_columns(result):
    folder, _ = result
    found = json.loads((folder / "copy.json").read_text(encoding="utf-8"))
    assert found == json.loads((folder / "out" / "score.json").read_text(encoding="utf-8"))
    assert found["columns"] == {"time": "time", "position": "position", "torque": "torque"}
    assert found["verdict"] == "follows"
    assert found["model"]["inertia"] == pytest.approx(2.0, rel=0.01)


def test_the_delay_of_the_torque_is_taken(result):
    folder, _ = result
    logs = folder / "train.csv", folder / "test.csv"
    said = refusal("score", *logs, "--torque-delay", "2", "--out", folder / "other")
    assert "torque_delay = 2 s is not allowed: it must be from -1 to 1 s" in said
