"""The loop of a joint that changes, against the joint stepped by hand under the torque that the loop gave."""

import math

import numpy as np
import pytest

from adaptive_ff import load_scenario, simulate
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.simulation.metrics import rms
from plant import JointModel, gravity_torque, initial_state, step_joint

BASE = load_scenario().modified(duration=6.0)
FIELDS = {"inertia": 20.0, "coulomb": 60.0, "stiction": 90.0, "viscous": 80.0, "stribeck_velocity": 0.05}


def stepped(run, before, after, change, *, lag=0.0, gain=1.0):
    """True velocity under the recorded torque, a current loop and a weight; ``after`` is in force from ``change`` s."""
    period = before.solver_period
    state, current, velocity = initial_state(before.parameters, float(run.reference[0])), 0.0, []
    for command in np.repeat(run.torque, 10):
        velocity.append(state.velocity)
        mean = command
        if lag > 0.0:
            decay = math.exp(-period / lag)
            mean = command + (current - command) * (1.0 - decay) * lag / period
            current = command + (current - command) * decay
        joint = before if len(velocity) <= round(change / period) else after
        torque = gain * mean - gravity_torque(joint.weight, state.position)
        state = step_joint(joint.parameters, state, torque, period)
    return np.array([*velocity, state.velocity])


@pytest.mark.parametrize("name", ["pi", "oracle"])
def test_changed_joint_moves_as_one_made_with_the_changed_fields(name):
    change = {"time": 3.0, "friction_scale": 1.2, "coulomb_scale": 0.5, "viscous_scale": 2.0}
    change |= {"inertia_scale": 2.0, "lag_scale": 0.5, "load": 30.0}
    run = simulate(BASE.modified(change=[change]), name)
    before = JointModel(**FIELDS, friction_lag=0.02)
    new = {"inertia": 40.0, "coulomb": 36.0, "stiction": 54.0, "viscous": 192.0, "stribeck_velocity": 0.05}
    after = JointModel(**new, friction_lag=0.01, offset=30.0)
    assert run.velocity == pytest.approx(stepped(run, before, after, 3.0), rel=1e-9, abs=1e-12)


def test_gravity_and_torque_constant_act_on_the_joint_and_are_not_reported():
    joint = JointModel(**FIELDS, friction_lag=0.02, gravity=80.0, gravity_phase=0.3)
    scenario = BASE.modified(joint={"gravity": 80.0, "gravity_phase": 0.3}, actuator={"gain": 0.9})
    run = simulate(scenario, "pi")
    assert run.velocity == pytest.approx(stepped(run, joint, joint, 9.0, gain=0.9), rel=1e-9, abs=1e-12)


def test_oracle_knows_gravity_load_and_payload():
    def error(name, **tables):
        run = simulate(BASE.modified(sensor={"velocity_noise": 0.0}, duration=20.0, **tables), name)
        return rms((run.reference - run.velocity)[10_000:])

    plain = error("oracle")
    change = [{"time": 5.0, "load": 60.0, "inertia_scale": 2.0}]
    for tables in ({"joint": {"gravity": 100.0}}, {"change": change, "actuator": {"torque_limit": 600.0}}):
        assert error("oracle", **tables) < 1.3 * plain
        assert error("pi", **tables) > 3.0 * plain


def test_assumed_delay_is_that_of_all_controllers_but_the_oracle():
    scenario = BASE.modified(actuator={"delay": 0.01}, feedback={"bandwidth": 5.0, "delay": 0.0})
    assert (scenario.delay, scenario.assumed_delay) == (1.0, 0.0)
    assert make_controller(scenario, "pi").parameters.delay == 0.0
    assert make_controller(scenario, "adaptive").parameters.feedback.delay == 0.0
    assert make_controller(scenario, "oracle").parameters.feedback.delay == 1.0
    assert BASE.modified(actuator={"delay": 0.01}, feedback={"bandwidth": 5.0}).assumed_delay == 1.0
