"""``adaptive-ff score``: a model trained on one log and judged on another, with all that a terminal shows."""

import json

import pytest
from command_line import content_of, refusal, run_command_line
from synthetic_logs import write_log

from adaptive_ff.identify.open_loop.slopes import follow_with_slopes
from controllers import is_cached


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("score")
    logs = [write_log(folder / name) for name in ("train.csv", "test.csv")]
    outcome = run_command_line("score", *logs, "--out", folder / "out", "--json", folder / "copy.json")
    return folder, outcome


def test_it_prints_the_errors_and_writes_its_files(result):
    folder, outcome = result
    assert outcome.status == 0, outcome
    assert all("compiled, once" in message for message in outcome.messages)
    assert set(content_of(folder / "out")) == {"score.json", "score.png"}
    assert "mrad" in outcome.out
    assert str(folder / "out") in outcome.out


def test_the_copy_is_the_same_and_names_the_columns(result):
    folder, _ = result
    found = json.loads((folder / "copy.json").read_text(encoding="utf-8"))
    assert found == json.loads((folder / "out" / "score.json").read_text(encoding="utf-8"))
    assert found["columns"] == {"time": "time", "position": "position", "torque": "torque"}


def test_what_has_been_compiled_is_known_to_be(result):
    assert is_cached(follow_with_slopes)


def test_the_delay_of_the_torque_is_taken(result):
    folder, _ = result
    logs = folder / "train.csv", folder / "test.csv"
    said = refusal("score", *logs, "--torque-delay", "2", "--out", folder / "other")
    assert "torque_delay = 2 s is not allowed: it must be from -1 to 1 s" in said
