"""The step of the rigid joint, with one exponential, beside Newton's method to the end on all joints of the matrix."""

import math

import numpy as np

from adaptive_ff import load_scenario
from adaptive_ff.scenario.library import SCENARIOS
from plant import JointModel, JointState
from plant.sliding import velocity_under_friction
from plant.step import friction_at, step_joint

TOLERANCE = 1e-15
"""Difference of the velocities after a step, relative to the terms of the free speed: five units in the last place."""

STATES = 100


def rigid_joints():
    loaded = [load_scenario(file) for file in sorted(SCENARIOS.glob("*.toml"))]
    return {scenario.name: scenario for scenario in loaded if isinstance(scenario.joint, JointModel)}


def newton(joint, state, torque, period):
    """Velocity after a step by Newton's method from the last velocity, and the size of the terms of the free speed."""
    weight = joint.friction_lag + period
    kappa = period * period / (joint.inertia * weight)
    carried = joint.friction_lag * state.friction_torque / weight
    free = state.velocity + period / joint.inertia * (torque - joint.offset - carried)
    size = abs(state.velocity) + period / joint.inertia * (abs(torque) + abs(joint.offset) + abs(carried))
    return velocity_under_friction(joint.friction, joint.backward, free, kappa, abs(state.velocity)), size


def test_step_is_newtons_to_the_last_digits_on_every_joint_of_the_matrix():
    scenarios, generator = rigid_joints(), np.random.default_rng(1)
    assert len(scenarios) > 40
    for name, scenario in scenarios.items():
        joint, period = scenario.joint.parameters, scenario.joint.solver_period
        reference = scenario.reference_velocity()
        for k in np.linspace(1, reference.size - 2, STATES).astype(int).tolist():
            velocity = float(reference[k]) * (k % 7 > 0)  # some from rest
            friction = friction_at(joint.friction, joint.backward, velocity) + float(generator.normal(0.0, 10.0))
            push = joint.inertia * float(reference[k + 1] - reference[k]) / period + float(generator.normal(0.0, 20.0))
            state, torque = JointState(velocity, friction, 0.0), joint.offset + friction + push
            own = step_joint(joint, state, torque, period).velocity
            expected, size = newton(joint, state, torque, period)
            assert math.isclose(own, expected, rel_tol=0.0, abs_tol=TOLERANCE * size), (name, k)
