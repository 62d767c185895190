"""Friction and force over position and load, identified from a log whose joint is known."""

import math
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from synthetic_logs import JOINT, coloured, motion

from adaptive_ff import InputError
from adaptive_ff.adaptive.learning.friction_map import map_value
from adaptive_ff.adaptive.learning.map_settings import map_parameters
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.open_loop.score import score_log
from adaptive_ff.identify.terms import FORCE_OVER, LOAD
from adaptive_ff.identify.words.scenario_text import scenario_text
from adaptive_ff.logs.log import KNOWN, Log

AMPLITUDE, PHASE = 0.3, 0.3


def mapped_log(period=0.4, amplitude=AMPLITUDE, force=0.0, share=0.0, step=0.002, seed=101):
    """Friction times ``1 + A sin(2 pi q/P + phase)`` and ``1 + share |u|``; a force over position beside it."""
    time = step * np.arange(round(30.0 / step))
    position, velocity, acceleration = motion(time)
    wave = np.sin(2.0 * math.pi * position / period + PHASE)
    known = 10.0 * np.sin(0.7 * time)
    friction = JOINT["coulomb"] * np.sign(velocity) + JOINT["viscous"] * velocity
    torque = JOINT["inertia"] * acceleration + JOINT["offset"] + force * wave
    torque += friction * (1.0 + amplitude * wave) * (1.0 + share * np.abs(known))
    torque += coloured(time.size, step, 0.1, np.random.default_rng(seed))
    return Log("log", time, torque, position=position, extra={KNOWN: known})


@pytest.fixture(scope="module")
def known_period():
    return identify_log(mapped_log(), position_periods=(0.4,))


@pytest.mark.parametrize("step", [0.002, 0.01])
def test_known_period_is_found_with_the_joint_around_it(step):
    found = identify_log(mapped_log(step=step), position_periods=(0.4,), held_out=0.0)
    cosine, sine = found.position_map.coefficients
    assert cosine == pytest.approx(AMPLITUDE * math.sin(PHASE), abs=0.02)
    assert sine == pytest.approx(AMPLITUDE * math.cos(PHASE), abs=0.02)
    assert found.position_map.force is None
    for name, true in JOINT.items():
        estimate = found.parameters[name].estimate
        assert estimate.lower < true < estimate.upper or estimate.value == pytest.approx(true, rel=0.01)


def test_it_is_drawn_with_a_band_that_holds_the_truth(known_period):
    learnt = known_period.position_map
    truth = 1.0 + AMPLITUDE * np.sin(2.0 * math.pi * learnt.position / 0.4 + PHASE)
    half = 0.5 * (learnt.friction.upper - learnt.friction.lower)
    assert np.all(np.abs(learnt.friction.value - truth) < 2.0 * half)
    assert 0.0 < np.min(half) <= np.max(half) < 0.02
    assert list(known_period.plot()) == ["identified_torque", "friction", "lag", "identified_map"]


def test_it_is_told_and_saved(known_period):
    told = next(sentence for sentence in known_period.verdict if sentence.startswith("Friction depends on position"))
    place = (0.25 - PHASE / (2.0 * math.pi)) * 0.4
    assert f"rises by 30 % at {place:.2f}" in told  # and a digit that depends on the noise
    assert told.endswith("and repeats every 0.4 rad.")
    assert "A force over position is not used: held-out data gain nothing from it." in known_period.verdict
    saved = known_period.to_dict()["friction_map"]
    assert (saved["position_periods"], saved["position_hats"]) == ([0.4], 0)
    assert len(saved["coefficients"]) == len(saved["standard_errors"]) == 2


def test_what_is_held_out_is_said_with_the_map(known_period):
    assert known_period.validation.relative_error < 1.5 * known_period.fit.relative_error
    without = identify_log(mapped_log())
    assert without.fit.relative_error > 5.0 * known_period.fit.relative_error


def test_hats_are_those_of_the_controller():
    log = mapped_log(period=0.8)
    learnt = identify_log(log, position_hats=13, held_out=0.0).position_map
    assert learnt.hats == 13
    assert learnt.range == pytest.approx((np.min(log.position), np.max(log.position)))
    parameters = map_parameters((), learnt.hats, learnt.range, 0.0, 1.0)
    said = [1.0 + map_value(parameters, np.array(learnt.coefficients), place, 0.0) for place in learnt.position]
    assert said == pytest.approx(learnt.friction.value)
    truth = 1.0 + AMPLITUDE * np.sin(2.0 * math.pi * learnt.position / 0.8 + PHASE)
    inner = slice(40, -40)
    assert np.max(np.abs(learnt.friction.value - truth)[inner]) < 0.1
    half = np.interp(np.linspace(*learnt.range, 13), learnt.position, learnt.friction.upper - learnt.friction.value)
    assert np.array(learnt.standard_errors) * 1.96 == pytest.approx(half, rel=0.05)  # at its own place a hat is the map


def test_a_force_over_position_is_told_apart_from_friction():
    found = identify_log(mapped_log(amplitude=0.0, force=1.0), position_periods=(0.4,), held_out=0.0)
    assert found.position_map.friction is None
    written = scenario_text(found, "reference.csv")
    assert "left out of the log: offset." in written
    made = tomllib.loads(written)
    assert made["adaptation"]["ripple_periods"] == [made["actuator"]["ripple_period"]] == [0.4]
    assert made["actuator"]["ripple_amplitude"] == pytest.approx(1.0, abs=0.05)
    assert np.max(found.position_map.force.value) == pytest.approx(1.0, abs=0.05)
    assert {FORCE_OVER + "cosine_1", FORCE_OVER + "sine_1"} <= {*found.selection.chosen.terms}
    assert any(sentence.startswith("A force depends on position") for sentence in found.verdict)


def test_friction_rises_with_the_known_torque():
    found = identify_log(mapped_log(amplitude=0.0, share=0.03), load_friction=True, held_out=0.0)
    share = found.position_map.load_share
    assert share.lower < 0.03 < share.upper
    assert share.value == pytest.approx(0.03, rel=0.1)
    assert "Friction rises by 3 % for each N m of known torque." in found.verdict


@pytest.mark.parametrize("seed", [101, 102])
def test_nothing_is_chosen_where_friction_depends_on_nothing(seed):
    found = identify_log(
        mapped_log(amplitude=0.0, seed=seed), position_periods=(0.4,), position_hats=5, load_friction=True, held_out=0.0
    )
    assert found.position_map is None
    assert LOAD not in found.selection.chosen.terms
    missing = "Friction over position, a force over position and friction over load are not used"
    assert any(sentence.startswith(missing) for sentence in found.verdict)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"position_periods": (0.0,)}, "position_periods"),
        ({"position_hats": 1}, "position_hats = 1"),
        ({"position_hats": 41}, "at most 40"),
        ({"load_friction": True}, "takes a known torque; name its column with --known-torque"),
    ],
)
def test_what_cannot_be_is_refused(asked, message):
    log = replace(mapped_log(), extra={})
    with pytest.raises(InputError, match=message):
        identify_log(log, **asked)


@pytest.mark.parametrize("periods", [(50.0,), (0.4, 120.0)])
def test_period_far_beyond_the_travel_is_refused(periods):
    """Coulomb friction came out nine times too large, or negative."""
    log = mapped_log()
    travel = float(np.ptp(log.position[: round(0.75 * log.time.size)]))
    said = rf"position_periods = {periods[-1]:g} is not allowed: the log travels {travel:.3g}, .* {3.0 * travel:.3g}$"
    with pytest.raises(InputError, match=said):
        identify_log(log, position_periods=periods)
    with pytest.raises(InputError, match="is not allowed: the log travels"):
        score_log(log, log, position_periods=periods)
    identify_log(log, position_periods=(2.9 * travel,))


def test_friction_that_comes_out_negative_has_no_map():
    time = 0.002 * np.arange(8000)
    velocity = 1.0 + 0.3 * np.sin(3.0 * time)  # one way only, and a torque that helps
    log = Log("log", time, 2.0 * 0.9 * np.cos(3.0 * time) + 4.0 * velocity - 3.0, position=np.cumsum(velocity) * 0.002)
    with pytest.raises(InputError, match="a map takes friction"):
        identify_log(log, position_periods=(0.4,))


def test_position_is_needed():
    log = mapped_log()
    with pytest.raises(InputError, match="takes a position"):
        identify_log(replace(log, position=None, velocity=np.gradient(log.position, log.time)), position_hats=5)
