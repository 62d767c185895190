"""A ripple of the torque over the position is found without being told; nothing is where there is none."""

import math
import tomllib

import numpy as np
import pytest
import synthetic_logs
from bristle_logs import bristle_log

from adaptive_ff import AdaptiveController, Log, identify_log
from adaptive_ff.identify.maps.map_columns import MapAsked
from adaptive_ff.identify.terms import FORCE_OVER
from adaptive_ff.identify.words.scenario_text import left_out, scenario_text
from adaptive_ff.logs.log import KNOWN
from benchmarks.coverage_driven import driven_case
from controllers import pi_gains


def sines_log(further, **options):
    """The log of a joint with a Coulomb friction of 2 N m and a further torque over the position."""
    return synthetic_logs.sines_log(lambda q, w: 2.0 * np.sign(w) + further(q), **options)[0]


def ripple(position):
    return 0.3 * np.sin(2.0 * np.pi * position / 0.17)


@pytest.mark.parametrize("period", [0.17, 0.9])
def test_period_and_size_are_found(period):
    found = identify_log(sines_log(lambda q: 0.3 * np.sin(2.0 * np.pi * q / period + 0.7)))
    assert found.map_asked.found
    assert found.map_asked.periods[0] == pytest.approx(period, rel=0.01)
    assert found.position_map.friction is None
    assert found.position_map.force_periods == found.map_asked.periods
    assert np.max(found.position_map.force.value) == pytest.approx(0.3, rel=0.1)
    assert found.parameters["inertia"].estimate.value == pytest.approx(0.5, rel=0.01)
    assert found.validation.relative_error < 0.02
    assert any(f"a period of {period:.2g}" in one and "found in the log" in one for one in found.verdict)
    assert found.to_dict()["friction_map"]["force_periods"] == list(found.map_asked.periods)


@pytest.mark.parametrize("seed", [401, 408])
def test_inertia_of_a_joint_that_follows_its_cogging_is_right(seed):
    """Under feedback the joint accelerates where its cogging helps: inertia came out at a half and a quarter."""
    case, delay, _ = driven_case(seed)
    found = identify_log(case.log, held_out=0.0, torque_delay=delay)
    true, inertia = case.truth["inertia"], found.parameters["inertia"]
    assert inertia.estimate.value == pytest.approx(true, rel=0.02)
    assert inertia.estimate.lower <= true <= inertia.estimate.upper
    assert inertia.confounded == ()
    assert found.map_asked.periods[0] == pytest.approx(2.0 * math.pi / 36.0, rel=0.02)
    without = identify_log(case.log, held_out=0.0, torque_delay=delay, model="offset")
    assert without.parameters["inertia"].estimate.value < 0.6 * true


def test_the_simulated_drive_has_the_ripple():
    found = identify_log(sines_log(ripple))
    written = tomllib.loads(scenario_text(found, "reference.csv"))
    assert written["actuator"]["ripple_amplitude"] == pytest.approx(0.3, rel=0.1)
    assert written["actuator"]["ripple_period"] == pytest.approx(0.17, rel=0.01)
    assert "force over position" not in left_out(found)
    assert written["adaptation"]["ripple_periods"] == [written["actuator"]["ripple_period"]]
    assert "actuator" not in tomllib.loads(scenario_text(identify_log(sines_log(np.zeros_like)), "reference.csv"))


def test_a_controller_begins_with_the_ripple():
    log = sines_log(lambda q: 0.3 * np.sin(2.0 * np.pi * q / 0.17 + 0.7))
    found = identify_log(log)
    first = found.first_estimate()
    assert first.ripple_periods == pytest.approx((0.17,), rel=0.01)
    assert first.model["ripple_sin_1"] == pytest.approx(0.3 * math.cos(0.7), abs=0.05)
    assert first.model["ripple_cos_1"] == pytest.approx(0.3 * math.sin(0.7), abs=0.05)
    assert 0.0 < first.deviation["ripple_sin_1"] < 0.05
    controller = AdaptiveController(*pi_gains(first.inertia, 3.0), 0.01, **first._asdict())
    assert controller.estimates["ripple_cos_1"] == first.model["ripple_cos_1"]
    of_current = Log("log", log.time, log.torque / 0.5, position=log.position)
    scaled = identify_log(of_current, is_current=True).first_estimate(0.5)
    assert scaled.model["ripple_sin_1"] == pytest.approx(first.model["ripple_sin_1"], rel=1e-3)
    assert scaled.deviation["ripple_sin_1"] == pytest.approx(first.deviation["ripple_sin_1"], rel=1e-2)
    assert identify_log(sines_log(np.zeros_like)).first_estimate().ripple_periods == ()


def test_nothing_is_found_where_there_is_nothing():
    found = identify_log(sines_log(np.zeros_like))
    assert found.map_asked == MapAsked()
    assert found.position_map is None
    assert not any("over position" in one or "ripple" in one for one in found.verdict)


@pytest.mark.parametrize("seed", [1, 3])
def test_reversals_that_come_back_at_the_same_places_are_no_ripple(seed):
    """Of bristles that bend at each reversal periods of 13 and 30 mrad were found, which other logs do not have."""
    assert not identify_log(bristle_log(seed), held_out=0.0).map_asked.found
    found = identify_log(bristle_log(seed, ripple=0.3), held_out=0.0)
    assert found.map_asked.periods[0] == pytest.approx(0.17, rel=0.01)


def test_a_ripple_is_no_part_of_a_model_that_was_told_nor_looked_for_beside_a_map():
    log = sines_log(ripple)
    assert identify_log(log, model="offset").position_map is None
    assert identify_log(log, position_periods=(0.9,)).map_asked == MapAsked((0.9,))


def test_a_log_to_validate_on_without_positions_takes_a_model_without_positions():
    found = identify_log(sines_log(ripple), validation=sines_log(ripple, as_position=False))
    assert not any(term.startswith(FORCE_OVER) for term in found.selection.chosen.terms)


def test_positions_are_added_up_from_velocities_where_there_is_no_gap():
    log = sines_log(ripple, as_position=False)
    found = identify_log(log)
    assert found.map_asked.periods[0] == pytest.approx(0.17, rel=0.01)
    assert found.validation.relative_error < 0.02  # the end of the log goes on from where its begin has come to
    torque = log.torque.copy()
    torque[9000:9500] = np.nan
    assert identify_log(Log("gap", log.time, torque, velocity=log.velocity)).position_map is None


def test_positions_are_not_asked_of_a_log_of_velocities_for_friction_over_load():
    """They end at a gap, and a jittered clock is undone by splines, which take no gap."""
    log = sines_log(np.zeros_like, as_position=False)
    time = log.time + 2e-4 * np.random.default_rng(1).uniform(-1.0, 1.0, log.time.size)
    velocity = log.velocity.copy()
    velocity[9000:9500] = np.nan
    load = {KNOWN: 5.0 * np.sin(0.7 * time)}
    found = identify_log(Log("gap", time, log.torque, velocity=velocity, extra=load), load_friction=True)
    assert found.parameters["inertia"].estimate.value == pytest.approx(0.5, rel=0.01)
