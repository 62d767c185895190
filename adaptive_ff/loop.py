"""The closed loop: a controller, a drive and a joint, sample by sample.

The loop is written once. Compiled, it serves every controller whose kernel is registered; in plain Python it
serves any object that has a ``step`` method, and checks the compiled one.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers import Inputs, compiled_in_place, step, write_estimates
from plant import ActuatorParameters, JointSchedule, JointState, joint_in_phase, realise_torque, step_joint


class Course(NamedTuple):
    """What is laid down before a run starts.

    Attributes
    ----------
    plan : JointSchedule
        The joint and how its friction changes.
    actuator : ActuatorParameters
        The drive.
    solver_period : float
        Solver period, s.
    samples : ndarray of int64, shape (n + 1,)
        Solver step of each sample, and of the end.
    reference : ndarray, shape (steps + 1,)
        Reference velocity on the solver's grid, rad/s.
    noise : ndarray, shape (n,)
        Noise of the measured velocity, rad/s.
    """

    plan: JointSchedule
    actuator: ActuatorParameters
    solver_period: float
    samples: NDArray[np.int64]
    reference: NDArray[np.float64]
    noise: NDArray[np.float64]


class Record(NamedTuple):
    """Series that a run fills in.

    Attributes
    ----------
    velocity : ndarray, shape (steps + 1,)
        True velocity on the solver's grid, rad/s.
    friction : ndarray, shape (n,)
        True friction torque at the samples, N m.
    measured : ndarray, shape (n,)
        Measured velocity, rad/s.
    torque : ndarray, shape (n,)
        Realised torque over the period that begins with the sample, N m.
    feedforward : ndarray, shape (n,)
        Feedforward torque in it, N m.
    estimates : ndarray, shape (n, m)
        Physical estimates of the controller, where it has any.
    """

    velocity: NDArray[np.float64]
    friction: NDArray[np.float64]
    measured: NDArray[np.float64]
    torque: NDArray[np.float64]
    feedforward: NDArray[np.float64]
    estimates: NDArray[np.float64]


def empty_record(course: Course, estimates: int) -> Record:
    """Return the series of a run, to be filled in."""
    count = course.noise.size
    return Record(
        np.zeros(course.reference.size),
        np.zeros(count),
        np.zeros(count),
        np.zeros(count),
        np.zeros(count),
        np.zeros((count, estimates)),
    )


class Position(NamedTuple):
    """Where a run has come to, so that it can go on in parts.

    Attributes
    ----------
    sample : int
        Next sample.
    phase : int
        Phase of the joint's friction.
    joint : JointState
        State of the joint.
    realised_torque : float
        Torque of the last period, N m; not a number before the first.
    """

    sample: int
    phase: int
    joint: JointState
    realised_torque: float


def run_plain(
    block: Any, state: Any, course: Course, position: Position, stop: int, record: Record
) -> tuple[Any, Position]:
    """Run the loop from a position to a sample.

    Parameters
    ----------
    block, state : NamedTuple
        Parameters and state of the controller.
    course : Course
        What is laid down.
    position : Position
        Where to start.
    stop : int
        Sample to stop before.
    record : Record
        Filled in.

    Returns
    -------
    state : NamedTuple
        New state of the controller.
    position : Position
        Where the run has come to.
    """
    phase, joint_state, realised = position.phase, position.joint, position.realised_torque
    joint = joint_in_phase(course.plan, phase)
    for k in range(position.sample, stop):
        first, last = course.samples[k], course.samples[k + 1]
        previous = course.samples[k - 1] if k > 0 else first - (last - first)
        record.velocity[first] = joint_state.velocity
        measured = joint_state.velocity + course.noise[k]
        inputs = Inputs(
            course.reference[first],
            measured,
            course.reference[last],
            realised,
            0.0,
            (first - previous) * course.solver_period,
        )
        output, state = step(block, state, inputs)
        realised = realise_torque(course.actuator, output.torque)
        record.friction[k] = joint_state.friction_torque
        record.measured[k] = measured
        record.torque[k] = realised
        record.feedforward[k] = output.feedforward
        write_estimates(block, state, record.estimates[k])
        for i in range(first, last):
            while phase + 1 < course.plan.starts.size and i >= course.plan.starts[phase + 1]:
                phase += 1
                joint = joint_in_phase(course.plan, phase)
            joint_state = step_joint(joint, joint_state, realised, course.solver_period)
            record.velocity[i + 1] = joint_state.velocity
    return state, Position(stop, phase, joint_state, realised)


run_compiled = compiled_in_place(run_plain)


def start_position(course: Course, joint: JointState) -> Position:
    """Return the position at the start of a run."""
    return Position(0, 0, joint, math.nan)
