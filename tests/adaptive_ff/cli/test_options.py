"""Options as ``--help`` describes them: each takes effect where it is given, and every option is used by a test."""

import inspect
import json
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest
import typer
from command_line import run_command_line
from scenario_files import short, write_scenario
from synthetic_logs import make_log

from adaptive_ff.cli import compare, identify, options
from adaptive_ff.cli.main import app
from adaptive_ff.comparison.fixed_models import FORMS, SOURCES
from adaptive_ff.comparison.gate import GATED
from adaptive_ff.comparison.registry import CONTROLLERS, FIXED
from adaptive_ff.files import write_csv
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.replay.replay import replay_log
from adaptive_ff.reported import Reported
from adaptive_ff.studies.motion import MotionLimits

LONG = {"excite", "commission"}
"""Commands that take minutes; a test holds their options against the function that they are the arguments of."""

BASE = ("--position", "position", "--torque", "torque")
CASES = {
    "known torque": ("identify", ("--known-torque", "known")),
    "load friction": ("identify", ("--known-torque", "known", "--load-friction")),
    "position period": ("identify", ("--position-period", "0.5")),
    "position hats": ("identify", ("--position-hats", "4")),
    "known torque of a score": ("score", ("--known-torque", "known")),
    "position period of a score": ("score", ("--position-period", "0.5")),
    "position hats of a score": ("score", ("--position-hats", "4")),
    "known torque of a replay": ("replay", ("--known-torque", "known")),
    "ripple": ("replay", ("--ripple-period", "0.5")),
}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Returns the result of a command on a log of a joint with all that options are for."""
    folder, log = tmp_path_factory.mktemp("options"), make_log(duration=6.0, period=0.004, noise=0.05)
    known = 40.0 * np.cos(2.0 * log.position)
    beside = 15.0 * np.sin(2.0 * np.pi * log.position / 0.5) + 60.0 * (log.position > 0.0) + np.abs(known)
    felt = log.torque + known + beside * np.sign(np.gradient(log.position))
    columns = {"time": log.time, "position": log.position, "torque": felt, "known": known}
    write_csv(folder / "log.csv", columns)

    @cache
    def run(command, options):
        logs = [folder / "log.csv"] * (2 if command == "score" else 1)
        with patch.object(Reported, "plot", lambda result, folder: {}):
            outcome = run_command_line(command, *logs, *BASE, *options, "--out", folder / "out", "--json", "-")
        assert outcome.status == 0, outcome
        return json.loads(outcome.out)

    return run


def numbers(value):
    """All numbers of a result, in order."""
    if isinstance(value, dict | list):
        return [number for one in (value.values() if isinstance(value, dict) else value) for number in numbers(one)]
    return [value] if isinstance(value, float) else []


@pytest.mark.parametrize(("command", "options"), CASES.values(), ids=CASES)
def test_option_takes_effect(results, command, options):
    without = options[:-1] if options[-1] == "--load-friction" else ()
    assert numbers(results(command, options)) != numbers(results(command, without))


def test_thinned_series_are_short_and_figures_of_the_whole_run(tmp_path, without_pictures):
    scenario = write_scenario(tmp_path, {**short(), "duration": 2.0, "controllers": ["pi"]})
    found = {}
    for thin in (1, 10):
        out = tmp_path / str(thin)
        assert run_command_line("compare", scenario, "--thin", thin, "--out", out).status == 0
        rows = len((out / "pi.csv").read_text(encoding="utf-8").splitlines())
        found[thin] = (rows, json.loads((out / "result.json").read_text(encoding="utf-8"))["controllers"]["pi"])
    assert 9.0 < found[1][0] / found[10][0] <= 10.0
    assert found[10][1] == pytest.approx(found[1][1], rel=1e-9)


def test_stiffness_leaves_slow_loops_out_and_details_show_all(tmp_path, without_pictures):
    scenario = write_scenario(tmp_path, {**short(), "duration": 2.0})
    once = ("tune", scenario, "--controller", "pi", "--seeds", 1, "--tuning-seeds", 1, "--out", tmp_path / "out")
    assert run_command_line(*once).status == 0
    loops = json.loads((tmp_path / "out" / "tune.json").read_text(encoding="utf-8"))["loops"]
    outcome = run_command_line(*once, "--details", "--stiffness", 0.99 / loops[-1]["angle_lost"])
    assert outcome.status == 0, outcome
    content = json.loads((tmp_path / "out" / "tune.json").read_text(encoding="utf-8"))
    assert content["controllers"]["pi"]["best_bandwidth"] == loops[-1]["bandwidth"]
    assert "angle lost to a load" in outcome.out
    assert "Pareto front" in outcome.out


def test_every_option_is_used_by_a_test():
    sources = "\n".join(path.read_text(encoding="utf-8") for path in Path(__file__).parents[2].rglob("test_*.py"))
    unused = [
        f"{name} {option}"
        for name, command in typer.main.get_command(app).commands.items()
        for parameter in command.params
        for option in getattr(parameter, "opts", [])
        if name not in LONG and not parameter.hidden and option.startswith("--") and f'"{option}"' not in sources
    ]
    assert unused == []


@dataclass
class Described:
    """A group.

    name: of nothing
    """

    # above the field,
    # in two lines
    above: int = 0
    beside: int = 0  # beside the field
    bare: int = 0


def test_comment_above_or_beside_an_option_is_its_help():
    assert options.described(Described) == {"above": "Above the field, in two lines.", "beside": "Beside the field."}
    assert options.described(dataclass(type("Made", (), {}))) == {}


@pytest.mark.parametrize(
    ("group", "function"),
    [(identify.Regression, identify_log), (identify.Learning, replay_log), (options.Limits, MotionLimits)],
)
def test_options_are_arguments_of_the_function_that_they_fill_with_its_defaults(group, function):
    arguments = inspect.signature(function).parameters
    for one in fields(group):
        default = arguments[one.name].default
        assert one.default == (None if default is inspect.Parameter.empty else default)


def test_names_in_help_are_those_that_there_are():
    assert list(compare.METRIC_NAMES) == list(GATED)
    assert [name for name in CONTROLLERS if name not in FIXED] == list(compare.CONTROLLER_NAMES)
    assert (tuple(FORMS), tuple(SOURCES)) == (compare.FORM_NAMES, compare.SOURCE_NAMES)
