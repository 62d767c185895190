"""A log to validate on whose torque or motion is in other units, or has the other sign: the machine is not blamed."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_logs import make_log

from adaptive_ff.identify.identification import identify_log

BLAMED = "Friction or inertia differs there."

OTHERS = {
    "sign": (lambda log: replace(log, torque=-log.torque), "friction would drive the joint there"),
    "reversed": (lambda log: replace(log, position=-log.position), "friction would drive the joint there"),
    "degrees": (lambda log: replace(log, position=np.degrees(log.position)), "one is in degrees, the other in radians"),
    "turns": (lambda log: replace(log, position=log.position / (2.0 * np.pi)), "the motion is in another unit"),
    "milli": (lambda log: replace(log, torque=1e3 * log.torque), "the torque is in another unit"),
}


@pytest.mark.parametrize("name", OTHERS)
def test_log_in_other_units_is_said_to_be_that(name):
    """Of the joint it was said that its friction or inertia was another."""
    change, said = OTHERS[name]
    other = make_log(duration=20.0, noise=0.2, seed=103)
    found = identify_log(make_log(noise=0.2), validation=change(other))
    assert said in found.verdict[1]
    assert not found.has_changed
    assert BLAMED not in found.verdict[1]


@pytest.mark.parametrize("seed", range(8))
def test_torque_that_has_nothing_to_do_with_the_motion_is_in_no_other_unit(seed):
    other = make_log(duration=20.0, noise=0.2, seed=103)
    noise = np.random.default_rng(seed).standard_normal(other.time.size)
    torque = 60.0 * np.convolve(noise, np.ones(50) / 50.0, mode="same")
    assert identify_log(make_log(noise=0.2), validation=replace(other, torque=torque)).other_units is None


@pytest.mark.parametrize("change", [{"coulomb": 6.0}, {"inertia": 4.0, "viscous": 6.0}, {"inertia": 0.9}])
def test_joint_that_is_another_there_is_still_blamed(change):
    found = identify_log(make_log(noise=0.2), validation=make_log(duration=20.0, noise=0.2, seed=103, **change))
    assert found.other_units is None
    assert found.verdict[1].endswith(BLAMED)
