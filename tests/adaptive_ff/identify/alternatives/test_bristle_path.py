"""Friction that follows the path since a reversal: inertia came out up to 15 % too large, with intervals without it."""

import tomllib

import numpy as np
import pytest
from bristle_logs import COULOMB, INERTIA, VISCOUS, bristle_log

from adaptive_ff import AdaptiveController, load_scenario, simulate
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.terms import DAMPING, LAG, PATH
from adaptive_ff.identify.words.scenario_text import scenario_text
from adaptive_ff.logs.log import Log
from adaptive_ff.scenario.library import SCENARIOS
from plant.lugre import LuGreJoint


@pytest.fixture(scope="module")
def found():
    return identify_log(bristle_log(1, travel=4e-3, seconds=30))


@pytest.mark.parametrize(("seed", "travel"), [(1, 4e-3), (2, 2e-3), (3, 0.02)])
def test_intervals_hold_a_joint_whose_bristles_bend_over_a_path(seed, travel):
    found = identify_log(bristle_log(seed, travel=travel, seconds=30), held_out=0.0)
    assert PATH in found.selection.chosen.terms
    assert LAG not in found.selection.chosen.terms
    for name, true in (("inertia", INERTIA), ("coulomb", COULOMB), ("viscous", VISCOUS)):
        estimate = found.parameters[name].estimate
        assert estimate.lower < true < estimate.upper, name
        assert estimate.value == pytest.approx(true, rel=0.01), name
    assert found.value(PATH) == pytest.approx(travel, rel=0.02)


def test_the_path_is_said_with_its_unit_and_is_in_the_result(found):
    (sentence,) = (one for one in found.verdict if "follows the path" in one)
    assert "4 rad" not in sentence
    assert "N m/rad" in sentence
    assert found.units[PATH] == "rad"
    written = found.to_dict()
    assert written[PATH]["lower"] < written[PATH]["value"] < written[PATH]["upper"]
    assert {PATH, DAMPING} <= {*written["terms"]}
    assert found.validation.relative_error < 1.5 * found.fit.relative_error


def test_the_scenario_has_bristles_of_the_same_stiffness(found):
    joint = tomllib.loads(scenario_text(found, "motion.csv"))["joint"]
    assert joint["kind"] == "lugre"
    assert joint["stiffness"] == pytest.approx(COULOMB / 4e-3, rel=0.02)
    assert LuGreJoint(**joint).coulomb == pytest.approx(COULOMB, rel=0.01)


def test_a_controller_begins_with_the_path(found):
    model = found.torque_model()
    assert model.presliding == pytest.approx(4e-3, rel=0.02)
    assert model.friction_lag == 0.0
    AdaptiveController(5.0, 10.0, 0.004, **found.first_estimate()._asdict())


@pytest.mark.parametrize("lag", [0.005, 0.02, 0.04])
def test_friction_that_lags_is_not_taken_for_bristles_over_a_path(lag):
    found = identify_log(bristle_log(1, lag=lag, seconds=30), held_out=0.0)
    assert PATH not in found.parameters
    assert found.value(LAG) == pytest.approx(lag, rel=0.15)


def test_a_linear_axis_has_a_path_in_m():
    log = bristle_log(1, travel=4e-3, seconds=30)
    assert identify_log(log, held_out=0.0, linear=True).units[PATH] == "m"


def test_a_log_of_velocity_shows_the_path_too():
    log = bristle_log(1, travel=8e-3, seconds=30)
    velocity = np.gradient(log.position, log.time)
    found = identify_log(Log("velocity", log.time, log.torque, velocity=velocity), held_out=0.0)
    assert found.value(PATH) == pytest.approx(8e-3, rel=0.03)


def test_a_path_that_leaves_much_of_the_torque_has_intervals_over_friction_that_lags_too():
    """Coulomb friction of the joint, which sticks and slips, came out 12 to 15 % too large within 4 or 5 %."""
    scenario = load_scenario(SCENARIOS / "lugre_1e4.toml").modified(seed=201)
    columns = simulate(scenario, "pi").columns()
    log = Log("sticking", columns["time"], columns["torque"], velocity=columns["measured"])
    found = identify_log(log, held_out=0.0, torque_delay=0.5 * scenario.sampling.period)
    selection, true = found.selection, scenario.joint.coulomb
    assert PATH in selection.chosen.terms
    over_path = selection._replace(jumping=None).interval("coulomb")
    assert not over_path.lower < true < over_path.upper
    both = found.parameters["coulomb"].estimate
    assert both.lower < true < both.upper
    assert any("sticks and slips" in caution for caution in found.cautions)


def test_a_path_that_leaves_little_stands_alone(found):
    assert found.selection.jumping is None
    assert not any("sticks and slips" in caution for caution in found.cautions)
