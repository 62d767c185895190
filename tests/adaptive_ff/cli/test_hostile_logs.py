"""Logs and scenarios that are broken or made to mislead: one line says what is wrong."""

import numpy as np
import pytest
from command_line import refusal, run_command_line
from scenario_files import short, write_scenario
from synthetic_logs import make_log

from adaptive_ff import load_scenario
from adaptive_ff.files import write_csv

COLUMNS = ("--position", "q", "--torque", "u")


def write_log(path, names=("time", "q", "u"), **changed):
    log = make_log(duration=20.0, period=0.01, noise=0.05)
    series = {"time": log.time.copy(), "q": log.position.copy(), "u": log.torque.copy()}
    for name, change in changed.items():
        series[name] = change(series[name])
    write_csv(path, dict(zip(names, series.values(), strict=True)))
    return path


def one_time(value):
    def change(time):
        time[700] = value
        return time

    return change


@pytest.mark.parametrize("value", [np.inf, -np.inf, 1e306])
def test_a_replay_of_a_time_that_cannot_be_says_so_in_a_line(tmp_path, without_pictures, value):
    log = write_log(tmp_path / "log.csv", time=one_time(value))
    outcome = run_command_line("replay", log, *COLUMNS, "--out", tmp_path / "out")
    assert outcome.status in (0, 2)
    assert "Traceback" not in outcome.err
    assert outcome.status == 0 or len(outcome.messages) == 1, outcome.err


def test_a_log_of_denormal_numbers_is_refused_for_what_it_is(tmp_path):
    path = write_log(tmp_path / "log.csv", time=lambda t: 5e-324 * np.arange(t.size), q=lambda q: 1e-320 * q)
    line = refusal("identify", path, *COLUMNS, "--out", tmp_path / "out")
    assert "cannot convert" not in line
    assert "time" in line


@pytest.mark.parametrize("command", ["identify", "replay"])
def test_names_of_columns_do_not_reach_the_terminal_as_commands(tmp_path, without_pictures, command):
    evil = "u\x1b]0;owned\x07"
    path = write_log(tmp_path / "log.csv", names=("time", "q\x1b[2J", evil))
    outcome = run_command_line(command, path, "--position", "q\x1b[2J", "--torque", evil, "--out", tmp_path / "out")
    asked = run_command_line(command, path, "--torque", "nothing", "--out", tmp_path / "out")
    assert asked.status == 2
    for text in (outcome.out, outcome.err, asked.out, asked.err):
        assert "\x1b]" not in text
        assert "\x07" not in text
        assert "[2J" not in text.replace("\\x1b[2J", "")


def test_a_scenario_with_a_byte_order_mark_is_one(tmp_path):
    path = write_scenario(tmp_path, short())
    marked = tmp_path / "marked.toml"
    marked.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert load_scenario(marked) == load_scenario(path)
