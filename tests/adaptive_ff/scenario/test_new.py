"""``adaptive-ff new``: a first scenario from data-sheet numbers, complete and plausible."""

import tomllib
from itertools import product

import numpy as np
import pytest
from command_line import refusal, run_command_line

from adaptive_ff import parse_scenario
from adaptive_ff.errors import InputError
from adaptive_ff.scenario.new import new_scenario_text
from adaptive_ff.scenario.scenario import MAIN_JOB

DATA_SHEETS = {"geared joint": (20.0, 400.0, 2.5), "servo": (2e-4, 1.3, 314.0), "linear drive": (100.0, 400.0, 0.5)}


@pytest.mark.parametrize(("name", "rate"), list(product(DATA_SHEETS, (100.0, 1000.0, 8000.0))))
def test_every_data_sheet_gives_a_scenario_without_warnings(name, rate):
    inertia, torque, speed = DATA_SHEETS[name]
    text = new_scenario_text(inertia, torque, speed, period=1.0 / rate, linear=name == "linear drive")
    scenario = parse_scenario(tomllib.loads(text), name)
    assert (scenario.joint.inertia, scenario.actuator.torque_limit) == (inertia, torque)
    assert scenario.controllers == MAIN_JOB
    assert scenario.joint.axis == ("linear" if name == "linear drive" else "rotary")
    assert [caution for caution in scenario.cautions() if "reference" in caution or "limit" in caution] == []
    assert 0.0 < np.max(np.abs(scenario.reference_velocity())) < speed
    for line in text.splitlines():
        assert len(line) <= 120
        assert "=" not in line or "#" in line or line.startswith(("axis", "inertia", "coulomb", "viscous"))


def test_command_prints_a_file_that_is_read_again(tmp_path):
    outcome = run_command_line("new", "--inertia", "2e-4", "--torque", "1.3", "--speed", "314")
    assert (outcome.status, outcome.err) == (0, "")
    assert outcome.out == new_scenario_text(2e-4, 1.3, 314.0)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--inertia", "0"), "inertia = 0 is not allowed: it must be positive and finite"),
        (("--speed", "nan"), "speed = nan is not allowed"),
        (("--torque", "-inf"), "torque = -inf is not allowed"),
        (("--rate", "0"), "--rate = 0 is not allowed: it must be above 2 Hz and at most 3.33e+06 Hz"),
        (("--rate", "2"), "--rate = 2 is not allowed"),
        (("--rate", "1e9"), "--rate = 1e+09 is not allowed"),
        (("--rate", "inf"), "--rate = inf is not allowed"),
        (("--inertia", "1e-12"), "inertia = 1e-12 is too small beside the rated torque"),
    ],
)
def test_numbers_that_no_joint_has_are_refused(options, said):
    assert said in refusal("new", *options)


def test_slowest_and_fastest_period_give_a_scenario_that_can_be_run():
    slow = tomllib.loads(new_scenario_text(0.05, 20.0, 6.0, period=0.499))
    assert parse_scenario(slow, "slow").sampling.period == 0.499
    fast = tomllib.loads(new_scenario_text(0.05, 20.0, 6.0, period=3e-7))
    with pytest.raises(InputError, match=r"to 200000000 solver periods \(60 s\)$"):
        parse_scenario({**fast, "duration": 60.1}, "fast")


def test_joint_that_takes_more_solver_steps_than_a_run_has_is_refused():
    with pytest.raises(InputError, match=r"in steps of 3e-07 s; give the inertia"):
        new_scenario_text(1e-12, 1.0, 1.0, period=1e-6)


@pytest.mark.parametrize("period", [1e-9, 0.5, 10.0])
def test_period_of_no_scenario_is_refused(period):
    with pytest.raises(InputError, match=r"^period = .* s is not allowed: it must be from 3e-07 s to less than 0.5 s$"):
        new_scenario_text(20.0, 400.0, 2.5, period=period)


def test_function_refuses_like_the_command():
    with pytest.raises(InputError, match="period = 0 is not allowed"):
        new_scenario_text(1.0, 1.0, 1.0, period=0.0)
