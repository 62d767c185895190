"""Set-up of a run (joint, drive, reference, noise), common to all controllers, and the series that it records."""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.scenario.scenario import Scenario
from controllers import PositionLoopParameters, direct_velocity
from plant import (
    Actuator,
    ActuatorParameters,
    AngleRipple,
    AnyJoint,
    FrictionSchedule,
    Gravity,
    JointParameters,
    LuGreParameters,
    Sensor,
    schedule,
)

POSITION_STEP = 1e-5
"""Step to which the position that controllers are given is rounded where there is no encoder, rad."""

FINE = 1e-12
"""Resolution of the encoder of a sensor without noise, rad."""

NO_POSITION_LOOP = PositionLoopParameters(0.0, math.inf)
"""A position loop that does nothing."""


class RunSetup(NamedTuple):
    """Everything of a run that does not depend on the controller, computed before it starts."""

    joint: Any  # parameters of the joint, of a class in ``plant.STEP_JOINT``, before it changes
    plan: FrictionSchedule  # how it changes
    actuator: ActuatorParameters  # the drive
    delay: int  # solver steps between a sample and the moment from which its command acts
    resolution: float  # step of the encoder, rad; zero where the velocity is measured
    angle_ripple: AngleRipple  # by how much the measured angle is off, in the velocity and in the position
    observer: Any  # what makes a velocity of the measurement, of a class in ``controllers.VELOCITY_ESTIMATORS``
    solver_period: float  # solver period, s
    samples: NDArray[np.int64]  # shape (n + 1,); solver step of each sample, and of the end
    reference: NDArray[np.float64]  # shape (steps + 1,); reference velocity on the solver's grid, rad/s
    # shape (n,); noise of the measured velocity, rad/s; not a number where the measurement is lost
    noise: NDArray[np.float64]
    held: NDArray[np.bool_]  # shape (n,); where the sensor gives its last value once more
    gravity: Gravity  # weight on the joint
    outer: PositionLoopParameters  # the position loop; its gain is zero where there is none
    position_step: float  # step of the measured position, rad
    # shape (steps + 1,); planned position on the solver's grid, rad: the integral of the reference; zero without a
    # position loop
    planned: NDArray[np.float64]
    spacing: int  # solver steps between two samples, as they are planned
    # solver steps from a sample until its command begins to act, as the controller reckons it; ``loop.NEVER`` if the
    # plan of then is not known
    lead: int


class Record(NamedTuple):
    """Series that a run fills in."""

    velocity: NDArray[np.float64]  # shape (steps + 1,); true velocity on the solver's grid, rad/s
    position: NDArray[np.float64]  # shape (steps + 1,); true position on the solver's grid, rad
    friction: NDArray[np.float64]  # shape (n,); true friction torque at the samples, N m
    measured: NDArray[np.float64]  # shape (n,); measured velocity, rad/s
    given: NDArray[np.float64]  # shape (n,); torque that the drive gives for the command of the sample, N m
    # shape (n,); mean torque that the drive gave over the period that begins with the sample, N m
    torque: NDArray[np.float64]
    feedforward: NDArray[np.float64]  # shape (n,); feedforward torque in the command, N m
    estimates: NDArray[np.float64]  # shape (n, m); physical estimates of the controller, where it has any
    monitors: NDArray[np.float64]  # shape (n, k); what the controller watches itself by, where it does


def empty_record(setup: RunSetup, estimates: int, monitors: int = 0) -> Record:
    """Return the series of a run, to be filled in."""
    count = setup.noise.size
    return Record(
        velocity=np.zeros(setup.reference.size),
        position=np.zeros(setup.reference.size),
        friction=np.zeros(count),
        measured=np.zeros(count),
        given=np.zeros(count),
        torque=np.zeros(count),
        feedforward=np.zeros(count),
        estimates=np.zeros((count, estimates)),
        monitors=np.zeros((count, monitors)),
    )


def without_noise(setup: RunSetup) -> RunSetup:
    """Return a setup whose sensor has neither noise nor the steps of its encoder."""
    return setup._replace(noise=np.zeros_like(setup.noise), resolution=min(setup.resolution, FINE))


def planned_position(joint: Any, reference: NDArray[np.float64], period: float) -> NDArray[np.float64]:
    """Return the position (rad) of a joint that follows a reference exactly, on the solver's grid of a period (s).

    The position of a joint follows from its velocity by a rule of its solver; the plan follows by the same one, for the
    two rules differ by half a period times the velocity, more than a good loop leaves.
    """
    implicit = isinstance(joint, (JointParameters, LuGreParameters))  # backward Euler; else the trapezoidal rule
    planned = np.zeros(reference.size)
    planned[1:] = reference[1:] if implicit else 0.5 * (reference[:-1] + reference[1:])
    planned[1:] *= period
    return np.cumsum(planned, out=planned)


def build_plain_setup(
    joint: AnyJoint,
    samples: NDArray[np.int64],
    reference: NDArray[np.float64],
    noise: NDArray[np.float64],
    actuator: Actuator | None = None,
) -> RunSetup:
    """Make a setup by hand: a joint whose friction does not change, a velocity sensor, samples at will.

    By default the drive has neither limits nor a delay.
    """
    drive = Actuator() if actuator is None else actuator
    period = joint.solver_period
    return RunSetup(
        joint=joint.parameters,
        plan=schedule([], period),
        actuator=drive.parameters,
        delay=round(drive.delay / period),
        resolution=0.0,
        angle_ripple=Sensor().angle_ripple,
        observer=direct_velocity(period),
        solver_period=period,
        samples=samples,
        reference=reference,
        noise=noise,
        held=np.zeros(noise.size, dtype=bool),
        gravity=joint.weight,
        outer=NO_POSITION_LOOP,
        position_step=POSITION_STEP,
        planned=np.zeros(reference.size),
        spacing=round(float(np.mean(np.diff(samples)))),
        lead=round(drive.delay / period),
    )


def build_setup(scenario: Scenario) -> RunSetup:
    """Compute everything of a scenario that does not depend on the controller."""
    noise, held = scenario.sensed()
    reference, actuator = scenario.reference_velocity(), scenario.actuator
    plain = build_plain_setup(scenario.joint, scenario.sample_steps, reference, noise, actuator)
    assumed_delay = scenario.assumed_delay * scenario.sampling.period
    setup = plain._replace(
        plan=scenario.plan,
        resolution=scenario.sensor.encoder_resolution or 0.0,
        angle_ripple=scenario.sensor.angle_ripple,
        observer=scenario.velocity_estimator,
        held=held,
        outer=scenario.position_loop or NO_POSITION_LOOP,
        position_step=scenario.position_resolution or POSITION_STEP,
        spacing=round(scenario.sampling.period / plain.solver_period),
        lead=round(assumed_delay / plain.solver_period),
    )
    if scenario.position is not None:
        setup = setup._replace(planned=planned_position(setup.joint, reference, setup.solver_period))
    return setup
