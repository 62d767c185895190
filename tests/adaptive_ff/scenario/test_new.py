"""``adaptive-ff new``: a first scenario from data-sheet numbers, complete and plausible."""

import re
import tomllib
from itertools import product

import numpy as np
import pytest
from command_line import refusal, run_command_line

from adaptive_ff import load_scenario, parse_scenario
from adaptive_ff.comparison.own_bandwidth import settled_error, with_bandwidth
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.errors import InputError
from adaptive_ff.scenario.content import MAIN_JOB
from adaptive_ff.scenario.loop import loop_at, tried_bandwidths
from adaptive_ff.scenario.new import new_scenario_text

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


def test_command_prints_a_file_that_is_read_again():
    outcome = run_command_line("new", "--inertia", "2e-4", "--torque", "1.3", "--speed", "314")
    assert (outcome.status, outcome.err) == (0, "")
    assert outcome.out == new_scenario_text(2e-4, 1.3, 314.0)


ENCODERS = {
    "joint side": (("--encoder", "4096"), 2.0 * np.pi / 4096),
    "coarse, filtered": (("--encoder", "4096", "--velocity-cutoff", "50"), 2.0 * np.pi / 4096),
    "motor side": (("--encoder", "4096", "--encoder-side", "motor", "--gear-ratio", "50"), 2.0 * np.pi / 4096 / 50),
    "late": (("--encoder", "65536", "--delay", "0.0015"), 2.0 * np.pi / 65536),
    "linear": (("--encoder", "1e5", "--linear"), 1e-5),
}


@pytest.mark.parametrize(("options", "resolution"), ENCODERS.values(), ids=ENCODERS)
def test_loop_suits_the_encoder(options, resolution):
    """Of the loops that are sound and do not tremble, neither half nor double the bandwidth leaves PI much less."""
    outcome = run_command_line("new", "--inertia", 0.5, "--torque", 20, "--speed", 6, *options)
    assert (outcome.status, outcome.err) == (0, "")
    scenario = parse_scenario(tomllib.loads(outcome.out), "new").modified(duration=10.0)
    assert scenario.sensor.encoder_resolution == pytest.approx(resolution, rel=1e-6)
    assert list(scenario.cautions()) == []
    added = [line for line in outcome.out.splitlines() if line.startswith(("cutoff", "encoder", "delay", "gear"))]
    assert all("#" in line for line in added)
    chosen = scenario.feedback.hertz
    largest = 0.501 * tried_bandwidths(scenario)[-1]
    assert chosen <= largest
    slower_and_faster = [one for one in (0.5 * chosen, 2.0 * chosen) if one <= largest]
    others = [one for one in slower_and_faster if loop_at(scenario, one).noise_torque < 2.0]
    error = settled_error(scenario, CONTROLLERS["pi"])
    assert all(error < 1.1 * settled_error(with_bandwidth(scenario, one), CONTROLLERS["pi"]) for one in others)
    assert settled_error(scenario, CONTROLLERS["oracle"]) < 0.9 * error  # friction is what is left, not counts


def test_loop_that_is_too_fast_for_its_encoder_is_warned_of(tmp_path, without_pictures):
    """61 Hz with 4096 counts behind 50 Hz: a sensitivity of 2.7 and 24 degrees, and nothing but counts in the error."""
    text = run_command_line("new", "--inertia", 0.5, "--torque", 20, "--speed", 6, *ENCODERS["coarse, filtered"][0]).out
    file = tmp_path / "joint.toml"
    file.write_text(re.sub(r"bandwidth = \S+", "bandwidth = 61", f"duration = 10.0\n{text}"))
    outcome = run_command_line("compare", file, "--out", tmp_path / "out")
    assert outcome.status == 0, outcome.err
    said = " ".join(outcome.warnings)
    assert "the velocity loop oscillates: its maximum sensitivity is 2.7 and its phase margin 24 degrees" in said
    assert "Error due to noise:" in outcome.out
    named = float(re.search(r"feedback.bandwidth = (\S+) Hz or less", said)[1])
    assert named < 61.0
    assert re.search(r"oracle, which is fed the true friction, settles at .* noise of the measurement dominates", said)
    trembles = r"the command of pi, .*, adaptive trembles by up to \S+ N m \(rms\), \S+ % of "
    assert re.search(trembles + r"actuator.torque_limit = 20 N m", said)
    calm = load_scenario(file).modified(feedback={"bandwidth": named})
    assert not [line for line in calm.cautions() if "oscillates" in line]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--velocity-cutoff", "3"), "--velocity-cutoff and --encoder-side need an --encoder"),
        (("--encoder", "4096", "--encoder-side", "motor"), "gear_ratio is missing; it must be given for an encoder on"),
        (("--encoder", "0"), "encoder = 0 is not allowed: it must be positive and finite"),
        (("--encoder", "0.5"), "encoder = 0.5 is not allowed: it must be one count or more"),
        (("--encoder", "9", "--velocity-cutoff", "nan"), "velocity_cutoff = nan is not allowed"),
        (("--delay", "-1"), "delay = -1 s is not allowed: it must be zero or more and finite"),
        (("--delay", "0.00012345"), "delay = 0.00012345 s is not allowed: it must be a whole number of thousandths"),
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


PERIOD = r"^period = .* s is not allowed: it must be from 3e-07 s to less than 0.5 s$"


@pytest.mark.parametrize(
    ("inertia", "period", "message"),
    [
        (1e-12, 1e-6, r"in steps of 3e-07 s; give the inertia"),  # more solver steps than a run has
        (1.0, 0.0, "period = 0 is not allowed"),
        *((20.0, period, PERIOD) for period in (1e-9, 0.5, 10.0)),
    ],
)
def test_function_refuses_what_gives_no_scenario(inertia, period, message):
    with pytest.raises(InputError, match=message):
        new_scenario_text(inertia, 1.0, 1.0, period=period)
