"""The peak of a multisine by default, and warnings of references that do not suit the joint."""

import numpy as np
import pytest
from scenario_files import REMOVED, built_in, changed

from adaptive_ff import load_scenario, parse_scenario

FREE = parse_scenario(changed(built_in(), "reference.peak", REMOVED), "test")


def peak(scenario):
    return float(np.max(np.abs(scenario.reference_velocity())))


def test_default_peak_of_the_built_in_joint_is_the_one_that_its_file_gives():
    assert peak(FREE) == pytest.approx(0.35)
    assert peak(load_scenario()) == pytest.approx(0.35)
    assert np.allclose(FREE.reference_velocity(), load_scenario().reference_velocity(), rtol=1e-12, atol=0.0)


def test_default_peak_is_seven_stribeck_velocities_unless_the_torque_limit_is_low():
    assert peak(FREE.modified(joint={"stribeck_velocity": 0.02})) == pytest.approx(0.14)
    weak = FREE.modified(actuator={"torque_limit": 150.0})
    reference, joint = weak.reference_velocity(), weak.joint
    assert peak(weak) < 0.2
    fastest = np.max(np.abs(np.diff(reference))) / joint.solver_period
    assert joint.inertia * fastest + joint.viscous * peak(weak) + joint.stiction == pytest.approx(0.7 * 150.0)
    assert peak(FREE.modified(actuator={"torque_limit": 100.0})) == pytest.approx(0.35)  # cannot move it anyway


def test_reference_that_is_too_slow_or_too_fast_is_warned_of_with_a_peak_that_suits():
    assert load_scenario().cautions() == []
    (slow,) = load_scenario().modified(reference={"peak": 0.06}).cautions()
    assert slow.startswith("the reference never exceeds 0.06 rad/s, 1.2 times joint.stribeck_velocity = 0.05 rad/s")
    assert slow.endswith("a peak of 0.35 rad/s would")
    (fast,) = load_scenario().modified(reference={"peak": 8.0}).cautions()
    assert fast.startswith("the reference needs more than actuator.torque_limit = 400 N m in ")
    suggested = float(fast.partition("a peak of ")[2].partition(" ")[0])
    assert load_scenario().modified(reference={"peak": suggested}).cautions() == []
    twice = load_scenario().modified(reference={"peak": 2.0 * suggested}).cautions()
    assert len(twice) <= 1


def test_warnings_of_a_linear_axis_have_its_units():
    linear = load_scenario().modified(joint={"axis": "linear"})
    (slow,) = linear.modified(reference={"peak": 0.06}).cautions()
    assert slow.startswith("the reference never exceeds 0.06 m/s, 1.2 times joint.stribeck_velocity = 0.05 m/s")
    weak = linear.modified(actuator={"torque_limit": 80.0}).cautions()
    assert weak[0].startswith("actuator.torque_limit = 80 N is below joint.stiction = 90 N: ")
    (steep,) = linear.modified(joint={"stiction": 1000.0}, actuator={"torque_limit": 4000.0}).cautions()
    assert " N s/m, more than the proportional gain" in steep
