"""Blocks for python-control give the series of ``simulate``, and no step is ever done twice."""

import math

import control
import numpy as np
import pytest

from adaptive_ff import load_scenario, simulate
from adaptive_ff.blocks import controller_block, drive_block, joint_block, rebuilt, state_names, state_vector
from adaptive_ff.comparison.registry import make_controller
from controllers import PI, PositionLoop
from plant import Actuator, ElasticJoint, Joint

WITHOUT_POSITION = {"adaptation": {"identify": "offset"}}
SCENARIO = load_scenario().modified(duration=0.5, reference={"fade_in": 0.2}, **WITHOUT_POSITION)
PERIOD = SCENARIO.sampling.period
CONNECTIONS = [
    ["controller.velocity", "sensor.measured"],
    ["controller.realised_torque", "drive.realised_torque"],
    ["drive.command", "controller.torque"],
    ["joint.torque", "drive.torque"],
    ["sensor.velocity", "joint.velocity"],
]


def closed_loop(controller, reference):
    joint = joint_block(SCENARIO.joint, PERIOD, velocity=float(reference[0]))
    drive, feedback = drive_block(SCENARIO.actuator, PERIOD), controller_block(controller)
    sensor = control.summing_junction(["velocity", "noise"], "measured", dt=PERIOD, name="sensor")
    given = {"inplist": ["controller.reference", "controller.next_reference", "sensor.noise"]}
    given["outlist"] = ["joint.velocity", "drive.torque", "controller.feedforward_torque"]
    blocks = [feedback, drive, joint, sensor]
    loop = control.interconnect(blocks, connections=CONNECTIONS, check_unused=False, **given)
    return loop, np.concatenate([block.initial_state for block in (feedback, drive, joint)])


@pytest.mark.parametrize("name", ["pi", "adaptive"])
def test_interconnected_blocks_give_the_series_of_simulate(name):
    run = simulate(SCENARIO, name)
    reference = run.reference[SCENARIO.sample_steps]
    controller = make_controller(SCENARIO, name)
    before = controller.state_to_json()
    loop, start = closed_loop(controller, reference)
    signals = np.array([reference[:-1], reference[1:], SCENARIO.noise()])
    found = control.input_output_response(loop, run.time, signals, start)
    velocity = run.velocity[SCENARIO.sample_steps[:-1]]
    assert np.max(np.abs(velocity)) > 0.1
    assert found.outputs[0] == pytest.approx(velocity, abs=1e-12, rel=0.0)
    assert found.outputs[1] == pytest.approx(run.torque, abs=1e-9, rel=0.0)
    assert found.outputs[2] == pytest.approx(run.feedforward, abs=1e-9, rel=0.0)
    assert controller.state_to_json() == before


def test_without_a_state_it_starts_in_that_of_the_controller():
    """python-control starts at zeros, with which the inertia was zero."""
    controller, plan = make_controller(SCENARIO, "adaptive"), np.array([0.1, 0.2, 0.3, 0.4])
    block = controller_block(controller, inputs=("reference", "velocity"))
    signals = np.array([plan, np.zeros(4)])
    found = control.input_output_response(block, SCENARIO.sampling.period * np.arange(4), signals)
    assert found.outputs[0] == pytest.approx([controller.step(reference, 0.0) for reference in plan])


def test_zeros_are_a_state_of_a_pi_loop_and_are_taken_as_they_are():
    controller = make_controller(SCENARIO, "pi")
    for _ in range(50):
        controller.step(0.1, 0.0)
    block = controller_block(controller, inputs=("reference", "velocity"))
    assert block.outfcn(0.0, np.zeros(block.nstates), np.zeros(2), {})[0] == 0.0
    torque = block.outfcn(0.0, block.initial_state, np.zeros(2), {})[0]
    assert torque > 0.0
    block.initial_state[:] = 0.0
    assert block.outfcn(0.0, state_vector(controller.state), np.zeros(2), {})[0] == torque


def test_evaluating_a_learning_block_twice_changes_nothing():
    controller = make_controller(SCENARIO, "adaptive")
    for k in range(200):  # until it learns
        controller.step(0.3 * math.sin(0.05 * k), 0.29 * math.sin(0.05 * k), next_reference=0.0, realised_torque=50.0)
    block = controller_block(controller)
    state, signals = block.initial_state.copy(), np.array([0.1, 0.09, 0.12, 40.0])
    first, again = (block.updfcn(0.0, state, signals, {}) for _ in range(2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, state)
    assert np.array_equal(state, block.initial_state)
    torque = block.outfcn(0.0, state, signals, {})[0]
    expected = controller.step(0.1, 0.09, next_reference=0.12, realised_torque=40.0)
    assert torque == expected
    assert np.array_equal(first, state_vector(controller.state))
    estimates = block.outfcn(0.0, state, signals, {})[2:]
    names = [name.removeprefix("estimated_") for name in block.output_labels[2:]]
    assert dict(zip(names, estimates, strict=True)) == controller.estimates


@pytest.mark.parametrize("name", ["pi", "kalman_disturbance", "canudas", "repetitive", "adaptive_paper", "adaptive"])
def test_state_goes_into_a_vector_and_back(name):
    state = make_controller(SCENARIO, name).state
    vector, labels = state_vector(state), state_names(state)
    assert len(labels) == len(set(labels)) == vector.size
    again = rebuilt(state, vector)
    assert str(again) == str(state)
    assert np.array_equal(state_vector(again), vector)
    with pytest.raises(ValueError, match="the vector has"):
        rebuilt(state, np.append(vector, 1.0))


def test_joint_block_steps_any_kind_of_joint_as_the_joint_does():
    fields = {"inertia": 20.0, "coulomb": 60.0, "stiction": 90.0, "viscous": 80.0, "stribeck_velocity": 0.05}
    model = ElasticJoint(**fields, kind="elastic", link_share=0.5, link_stiffness=8e4, link_damping=100.0, gravity=40.0)
    block, joint = joint_block(model, PERIOD), Joint(model)
    torques = 150.0 * np.sin(np.arange(100) * 0.1)
    found = control.input_output_response(block, np.arange(100) * PERIOD, torques[None, :], block.initial_state)
    positions = [joint.state.position]
    for torque in torques[:-1]:
        joint.step(float(torque), PERIOD)
        positions.append(joint.state.position)
    assert found.outputs[1] == pytest.approx(np.array(positions), abs=1e-15, rel=0.0)
    assert max(map(abs, positions)) > 0.01


def test_systems_in_continuous_time_cannot_be_mixed_in():
    plant = control.tf([1.0], [1.0, 0.0], inputs="torque", outputs="velocity")
    with pytest.raises(ValueError, match="timebase"):
        control.interconnect([controller_block(PI(1.0, 1.0, PERIOD)), plant], check_unused=False)


class Stateful:
    def step(self, reference, velocity, **_):
        return 0.0


@pytest.mark.parametrize("other", [Stateful(), PositionLoop(1.0)], ids=["own", "position loop"])
def test_objects_whose_step_cannot_be_repeated_are_refused(other):
    with pytest.raises(ValueError, match="a solver evaluates a block several times a sample"):
        controller_block(other)


@pytest.mark.parametrize(
    ("inputs", "said"),
    [
        (("reference", "velocity", "torque"), "inputs = 'torque' is not known; there are reference"),
        (("reference",), "velocity is missing"),
        (("reference", "velocity", "velocity"), "a signal is there twice"),
    ],
)
def test_wrong_signals_are_refused(inputs, said):
    with pytest.raises(ValueError, match=said):
        controller_block(PI(1.0, 1.0, PERIOD), inputs=inputs)


def test_what_acts_between_the_samples_is_refused():
    with pytest.raises(ValueError, match=r"delay = 0.01 is not allowed in a block: it must be 0; adaptive_ff.simulate"):
        drive_block(Actuator(delay=0.01), PERIOD)
    with pytest.raises(ValueError, match=r"gain = 0.9 is not allowed in a block: it must be 1"):
        drive_block(Actuator(gain=0.9), PERIOD)
    with pytest.raises(ValueError, match="period = -1 is not allowed"):
        drive_block(Actuator(), -1)
    with pytest.raises(ValueError, match=r"period = 0.0105 s is not allowed: it must be a whole number"):
        joint_block(SCENARIO.joint, 0.0105)
    with pytest.raises(ValueError, match="velocity = nan is not allowed"):
        joint_block(SCENARIO.joint, PERIOD, velocity=math.nan)
