"""What every controller of a run shares (joint, drive, reference, noise), and the series that the run fills in."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.scenario.scenario import Scenario
from controllers import direct_velocity
from plant import Actuator, ActuatorParameters, AnyJoint, FrictionSchedule, Gravity, schedule


class Course(NamedTuple):
    """Everything of a run that does not depend on the controller, computed before it starts.

    Attributes
    ----------
    joint : NamedTuple
        Parameters of the joint, of a class in ``plant.STEP_JOINT``, before it changes.
    plan : FrictionSchedule
        How it changes.
    actuator : ActuatorParameters
        The drive.
    delay : int
        Solver steps between a sample and the moment from which its command acts.
    resolution : float
        Step of the encoder, rad; zero where the velocity is measured.
    observer : NamedTuple
        What makes a velocity of the measurement, of a class in ``controllers.VELOCITY_ESTIMATORS``.
    solver_period : float
        Solver period, s.
    samples : ndarray of int64, shape (n + 1,)
        Solver step of each sample, and of the end.
    reference : ndarray, shape (steps + 1,)
        Reference velocity on the solver's grid, rad/s.
    noise : ndarray, shape (n,)
        Noise of the measured velocity, rad/s.
    gravity : Gravity
        Weight on the joint.
    """

    joint: Any
    plan: FrictionSchedule
    actuator: ActuatorParameters
    delay: int
    resolution: float
    observer: Any
    solver_period: float
    samples: NDArray[np.int64]
    reference: NDArray[np.float64]
    noise: NDArray[np.float64]
    gravity: Gravity


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
    given : ndarray, shape (n,)
        Torque that the drive gives for the command of the sample, N m.
    torque : ndarray, shape (n,)
        Mean torque that the drive gave over the period that begins with the sample, N m.
    feedforward : ndarray, shape (n,)
        Feedforward torque in the command, N m.
    estimates : ndarray, shape (n, m)
        Physical estimates of the controller, where it has any.
    """

    velocity: NDArray[np.float64]
    friction: NDArray[np.float64]
    measured: NDArray[np.float64]
    given: NDArray[np.float64]
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
        np.zeros(count),
        np.zeros((count, estimates)),
    )


def lay_plain_course(
    joint: AnyJoint,
    samples: NDArray[np.int64],
    reference: NDArray[np.float64],
    noise: NDArray[np.float64],
    actuator: Actuator | None = None,
) -> Course:
    """Make a course by hand: a joint whose friction does not change, a velocity sensor, samples at will.

    Parameters
    ----------
    joint : JointModel, LuGreJoint or ElasticJoint
        The joint.
    samples, reference, noise : ndarray
        As in :class:`Course`.
    actuator : Actuator, optional
        The drive; by default one without limits and without delay.
    """
    drive = Actuator() if actuator is None else actuator
    period = joint.solver_period
    return Course(
        joint.parameters,
        schedule([], period),
        drive.parameters,
        round(drive.delay / period),
        0.0,
        direct_velocity(period),
        period,
        samples,
        reference,
        noise,
        joint.weight,
    )


def lay_course(scenario: Scenario) -> Course:
    """Compute everything of a scenario that does not depend on the controller."""
    return Course(
        scenario.joint.parameters,
        scenario.plan,
        scenario.actuator.parameters,
        round(scenario.actuator.delay / scenario.joint.solver_period),
        scenario.sensor.encoder_resolution or 0.0,
        scenario.velocity_estimator,
        scenario.joint.solver_period,
        scenario.sample_steps,
        scenario.reference_velocity(),
        scenario.noise(),
        scenario.joint.weight,
    )
