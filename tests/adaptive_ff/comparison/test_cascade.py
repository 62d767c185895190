"""A position loop around the controllers of a comparison."""

import math

import numpy as np
import pytest
from closed_loops import SCENARIO

from adaptive_ff import compare, simulate
from adaptive_ff.simulation.metrics import rms
from controllers import PI, PositionLoop
from plant import Joint

MOVES = {"kind": "point_to_point", "distance": 0.2, "speed": 0.3, "acceleration": 1.0, "jerk": 20.0, "dwell": 1.0}
PLAIN = SCENARIO.modified(duration=12.0, seed=101, reference=MOVES, controllers=["pi", "oracle"])
CASCADE = PLAIN.modified(position={})


@pytest.fixture(scope="module")
def comparison():
    return compare(CASCADE)


def test_loop_of_steps_is_the_whole_run():
    """A user's own cascade around the joint of the package, with the plan summed up by the user."""
    scenario = CASCADE.modified(sensor={"velocity_noise": 0.0}, position={"encoder_resolution": 1e-5})
    run = simulate(scenario, "pi")
    period, reference = scenario.sampling.period, run.reference[scenario.sample_steps]
    planned = np.append(0.0, np.cumsum(run.reference[1:]) * scenario.joint.solver_period)[scenario.sample_steps]
    outer, inner = PositionLoop(2.0 * math.pi * 10.0 / 6.0), PI(*scenario.feedback.gains, period)
    joint, realised, torques = Joint(scenario.joint), None, []
    for k in range(scenario.samples):
        correction = outer.step(planned[k], 1e-5 * math.floor(joint.state.position / 1e-5 + 0.5))
        torque = inner.step(reference[k], joint.state.velocity, correction=correction, realised_torque=realised)
        realised = min(max(torque, -400.0), 400.0)
        torques.append(realised)
        joint.step(realised, period)
    assert np.ptp(run.torque) > 150.0
    assert run.torque == pytest.approx(np.array(torques), abs=1e-8)


def test_position_error_is_the_plan_minus_what_the_joint_travelled(comparison):
    run = comparison.runs["pi"]
    step = CASCADE.joint.solver_period
    travelled = np.append(0.0, np.cumsum(run.reference[1:] - run.velocity[1:]) * step)
    assert run.position_error == pytest.approx(travelled, abs=1e-12)
    settled = run.solver_time >= 6.0
    assert run.position_metrics.rms_position_error == rms(run.position_error)
    assert run.position_metrics.rms_position_error_settled == rms(run.position_error[settled])
    assert run.position_metrics.max_position_error == np.max(np.abs(run.position_error))
    assert run.position_metrics.max_position_error_settled == np.max(np.abs(run.position_error[settled]))


def test_position_loop_keeps_the_joint_on_its_path():
    drifting, kept = (simulate(scenario, "pi") for scenario in (PLAIN, CASCADE))
    drift = PLAIN.joint.solver_period * np.abs(np.sum(drifting.reference - drifting.velocity))
    assert drift > 3.0 * abs(kept.position_error[-1])


def test_own_controller_without_a_correction_follows_plan_and_correction_as_one_velocity():
    class Plain:
        def __init__(self):
            self.loop = PI(*CASCADE.feedback.gains, CASCADE.sampling.period)

        def step(self, reference, velocity, *, realised_torque):
            return self.loop.step(reference, velocity, realised_torque=realised_torque)

    short = CASCADE.modified(duration=2.0)
    assert simulate(short, Plain()).torque == pytest.approx(simulate(short, "pi").torque, rel=1e-9, abs=1e-9)


def test_gain_limit_and_resolution_come_from_the_table():
    assert CASCADE.position_loop.gain == pytest.approx(2.0 * math.pi * 10.0 / 6.0)
    assert CASCADE.position_loop.limit == math.inf
    own = CASCADE.modified(position={"gain": 5.0, "limit": 0.1, "encoder_resolution": 1e-4})
    assert own.position_loop == (5.0, 0.1)
    assert own.position_resolution == 1e-4
    encoder = {"encoder_resolution": 2e-5, "velocity_noise": 0.0}
    assert CASCADE.modified(sensor=encoder).position_resolution == 2e-5
    assert PLAIN.position_loop is None
