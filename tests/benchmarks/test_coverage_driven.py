"""Logs of joints under PI alone: what they record, and that the command counts and writes what it finds."""

import numpy as np
import pytest

from benchmarks.cases.driven_logs import driven_case
from benchmarks.cases.logs import run_driven
from benchmarks.cases.other_joints import draw


@pytest.mark.parametrize("seed", [101, 102, 103, 104, 105, 106])
def test_the_recorded_torque_is_what_the_joint_needs(seed):
    """Over the log, inertia gives back what it takes: what is left of the work is done against friction and load."""
    case = driven_case(seed)
    joint, loop, _ = draw(seed)
    log = case.log
    assert case.delay == 0.5 * loop.period
    assert (log.velocity is None) != (loop.sensor == "tachometer")
    velocity = np.gradient(log.position, log.time) if log.velocity is None else log.velocity
    friction = joint.coulomb * np.abs(velocity) + joint.viscous * velocity**2
    done = float(np.mean((log.torque - joint.load) * velocity))
    assert float(np.mean(friction)) == pytest.approx(done, rel=0.25)


def test_inertia_of_joints_that_stick_for_long_is_within_its_interval():
    found = [run_driven(seed, ["identify"])["identify"] for seed in (315, 332, 364)]
    assert [one["inertia_inside"] for one in found] == [[1.0]] * 3
    for name in ("inertia", "coulomb"):
        assert np.median([abs(one[f"{name}_error"][0]) for one in found]) < 0.05, name
