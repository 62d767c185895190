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
        (("--rate", "0"), "--rate = 0 is not allowed: it must be positive and finite"),
        (("--inertia", "1e-12"), "inertia = 1e-12 is too small beside the rated torque"),
    ],
)
def test_numbers_that_no_joint_has_are_refused(options, said):
    assert said in refusal("new", *options)


def test_function_refuses_like_the_command():
    with pytest.raises(InputError, match="period = 0 is not allowed"):
        new_scenario_text(1.0, 1.0, 1.0, period=0.0)
