"""The closed loop: a controller, a drive and a joint, sample by sample.

The loop is written once. Compiled, it serves every joint and every controller whose kernels are registered; in plain
Python it serves any object that has a ``step`` method, and checks the compiled one.
"""

import math
import warnings
from typing import Any, NamedTuple

from adaptive_ff.simulation.experiment import Record, RunSetup
from controllers import (
    Controller,
    Inputs,
    PositionLoopState,
    compiled,
    compiles,
    dispatched,
    estimate_velocity,
    initial_velocity_state,
    natural,
    step,
    step_position_loop,
    write_estimates,
    write_monitors,
)
from controllers.kernels.compiler import NoCompiler
from plant import (
    CHANGE_JOINT,
    INITIAL_STATE,
    READY_JOINT,
    SCALE_JOINT,
    SENSED_VELOCITY,
    STEP_READY,
    ActuatorParameters,
    FrictionSchedule,
    encoder_reading,
    friction_factor,
    gravity_torque,
    heated,
    lagged_torque,
    measured_angle,
    measured_speed,
    phase_change,
    realise_torque,
    ripple_torque,
)

ready_joint = dispatched(READY_JOINT)
"""Any joint with the constants of its step for a solver period (s)."""

step_ready = dispatched(STEP_READY)
"""One solver period of any joint that :func:`ready_joint` returned."""

scale_joint = dispatched(SCALE_JOINT)
"""Any joint with its friction times a factor."""

change_joint = dispatched(CHANGE_JOINT)
"""Any joint with a change of its parameters."""

sensed_velocity = dispatched(SENSED_VELOCITY)
"""Velocity (rad/s) at the sensor of any joint."""


def joint_in_phase(joint: Any, plan: FrictionSchedule, phase: int) -> Any:
    """Return the parameters of a joint in a phase of its changes, in plain Python."""
    return scale_joint(change_joint(joint, phase_change(plan, phase)), plan.scales[phase])


NEVER = 2**62
"""A solver step that no run comes to."""


class Position(NamedTuple):
    """Where a run has come to, so that it can go on in parts."""

    joint: Any  # state of the joint
    observer: Any  # state of what makes a velocity of the measurement
    reading: float  # last reading of the sensor, rad/s, or of the encoder, rad
    sample: int = 0  # next sample
    phase: int = 0  # phase of the joint's friction
    acting: int = -1  # sample whose command acts; -1 before the first
    given_torque: float = 0.0  # torque that the drive gives for the last command, N m
    realised_torque: float = math.nan  # mean torque that the drive gave over the last period, N m
    current_torque: float = 0.0  # torque that the drive's current makes, N m
    outer: PositionLoopState = PositionLoopState()  # state of the position loop
    # temperature of the joint above that of its surroundings, K; zero where friction does not depend on it
    warmth: float = 0.0


def is_plain(setup: RunSetup) -> bool:
    """Tell whether the last command acts as it is, on friction that only jumps: one test a step instead of five."""
    actuator = setup.actuator
    as_given = setup.delay == 0 and actuator.lag == 0.0 and actuator.gain == 1.0 and actuator.ripple_amplitude == 0.0
    return as_given and not setup.plan.varies and setup.gravity.amplitude == 0.0


def next_change(plan: FrictionSchedule, phase: int) -> int:
    """Return the solver step at which the next phase begins; after the last phase, one that no run comes to."""
    return plan.starts[phase + 1] if phase + 1 < plan.starts.size else NEVER


def joint_of_phase(setup: RunSetup, phase: int) -> tuple[Any, Any]:
    """Return the joint of a phase without what scales its friction, and with that, ready to be stepped."""
    changed = change_joint(setup.joint, phase_change(setup.plan, phase))
    return changed, ready_joint(scale_joint(changed, setup.plan.scales[phase]), setup.solver_period)


def read_sensor(setup: RunSetup, motion: Any, sample: int, last: float) -> float:
    """Return what the sensor reads, rad of an encoder and else rad/s; the last reading where it holds that."""
    if setup.held[sample]:
        return last
    if setup.resolution > 0.0:
        return encoder_reading(setup.resolution, measured_angle(setup.angle_ripple, motion.position))
    speed = measured_speed(setup.angle_ripple, motion.position, sensed_velocity(motion))
    return speed + setup.noise[sample]  # type: ignore[no-any-return]


def planned_at(setup: RunSetup, place: int) -> float:
    """Return the reference at a solver step, rad/s; not a number beyond its end."""
    return setup.reference[natural(place)] if place < setup.reference.size else math.nan


def inputs_at(
    setup: RunSetup, sample: int, velocity: float, position: float, correction: float, realised: float, elapsed: float
) -> Inputs:
    """Return what a controller is given at a sample: what is planned, and what is measured.

    The realised torque is not a number where the drive reports none, N m; the time since the last sample is in s. When
    the next sample will really come, where sampling jitters, no plan knows.
    """
    now = setup.samples[sample]
    return Inputs(
        reference=planned_at(setup, now),
        velocity=velocity,
        next_reference=planned_at(setup, now + setup.spacing),
        correction=correction,
        position=position,
        realised_torque=realised,
        feedforward=0.0,
        inertia=math.nan,
        dt=elapsed,
        acting_reference=planned_at(setup, now + setup.lead),
        next_acting_reference=planned_at(setup, now + setup.lead + setup.spacing),
    )


def acting_command(setup: RunSetup, acting: int, sample: int, step: int) -> int:
    """Return the sample whose command acts at a solver step of a sample, after the one that has acted."""
    while acting < sample and setup.samples[acting + 1] + setup.delay <= step:
        acting += 1
    return acting


def torque_at_joint(actuator: ActuatorParameters, torque: float, position: float) -> float:
    """Return what reaches the joint of a torque (N m) of the drive: its constant is off, and it has a ripple."""
    torque *= actuator.gain
    if actuator.ripple_amplitude > 0.0:
        torque += ripple_torque(actuator, position)
    return torque


def run_plain(
    parameters: Any, state: Any, setup: RunSetup, position: Position, stop: int, record: Record
) -> tuple[Any, Position]:
    """Run the loop from a position up to a sample; return the new state of the controller and the position there.

    The record is filled in; it must hold what earlier parts filled in.
    """
    phase, motion, observer, acting = position.phase, position.joint, position.observer, position.acting
    given, realised, current = position.given_torque, position.realised_torque, position.current_torque
    outer, warmth, reading = position.outer, position.warmth, position.reading
    actuator, plan, period = setup.actuator, setup.plan, setup.solver_period
    reports = actuator.reports  # asked once: the loop of a fixed feedforward takes a twentieth less time
    changed, joint = joint_of_phase(setup, phase)
    plain, watched = is_plain(setup), record.monitors.shape[1] > 0
    averaged, change = setup.delay > 0 or actuator.lag > 0.0, next_change(plan, phase)
    k = position.sample
    while k < stop:
        sample = natural(k)
        first, last = setup.samples[sample], setup.samples[natural(k + 1)]
        begin = natural(first)
        previous = setup.samples[k - 1] if k > 0 else first - (last - first)
        elapsed = (first - previous) * period
        record.velocity[begin] = motion.velocity
        record.position[begin] = motion.position
        reading = read_sensor(setup, motion, sample, reading)
        measured, observer = estimate_velocity(setup.observer, observer, reading, elapsed)
        angle = encoder_reading(setup.position_step, measured_angle(setup.angle_ripple, motion.position))
        correction = 0.0
        if setup.outer.gain > 0.0:
            correction, outer = step_position_loop(setup.outer, outer, setup.planned[begin], angle)
        reported = realised if reports else math.nan
        inputs = inputs_at(setup, sample, measured, angle, correction, reported, elapsed)
        output, state = step(parameters, state, inputs)
        given = realise_torque(actuator, output.torque, given, elapsed)
        record.friction[sample] = motion.friction_torque
        record.measured[sample] = measured
        record.given[sample] = given
        record.feedforward[sample] = output.feedforward
        write_estimates(parameters, state, record.estimates[sample])
        if watched:  # compiled code would write beyond a row that has no place for them
            write_monitors(parameters, state, record.monitors[sample])
        torque, realised, total, i = given, given, 0.0, first
        while i < last:
            while i >= change:
                phase += 1
                changed, joint = joint_of_phase(setup, phase)
                change = next_change(plan, phase)
            if not plain:
                acting = acting_command(setup, acting, k, i)
                torque = record.given[acting] if acting >= 0 else 0.0
                if actuator.lag > 0.0:
                    torque, current = lagged_torque(actuator, torque, current, period)
                total += torque
                weight = gravity_torque(setup.gravity, motion.position) if setup.gravity.amplitude > 0.0 else 0.0
                if plan.varies:
                    time = i * period
                    factor = friction_factor(plan, phase, time, motion.position, weight, warmth)
                    joint = ready_joint(scale_joint(changed, factor), period)
                torque = torque_at_joint(actuator, torque, motion.position) - weight
            motion = step_ready(joint, motion, torque, period)
            if not plain:
                if plan.thermal_resistance > 0.0:
                    warmth = heated(plan, warmth, motion.friction_torque * sensed_velocity(motion), period)
                if averaged and i + 1 == last:
                    realised = total / (last - first)
            i += 1
            reached = natural(i)
            record.velocity[reached] = motion.velocity
            record.position[reached] = motion.position
        if setup.delay == 0:
            acting = k
        record.torque[sample] = realised
        k += 1
    return state, Position(
        joint=motion,
        observer=observer,
        reading=reading,
        sample=stop,
        phase=phase,
        acting=acting,
        given_torque=given,
        realised_torque=realised,
        current_torque=current,
        outer=outer,
        warmth=warmth,
    )


run_in_memory = compiled(run_plain)
"""The loop, compiled, of a controller in memory: of its parameters a ``NativeParameters``, of its state nothing."""


def run_controller(controller: Controller, setup: RunSetup, position: Position, stop: int, record: Record) -> Position:
    """Run the loop with a controller, whose state goes on; return the position where the run has come to."""
    if compiles():
        try:
            return run_in_memory(controller.native, 0, setup, position, stop, record)[1]
        except NoCompiler as error:
            warnings.warn(f"{type(controller).__name__} runs as plain Python: {error}", stacklevel=2)
    parameters, state = controller.parameters, controller.state
    controller.state, position = run_plain(parameters, state, setup, position, stop, record)
    return position


def start_position(setup: RunSetup, velocity: float | None = None) -> Position:
    """Return the position at the start of a run, by default at the velocity of the reference (rad/s)."""
    start = float(setup.reference[0]) if velocity is None else velocity
    joint = INITIAL_STATE[type(setup.joint)](setup.joint, start)
    observer = initial_velocity_state(setup.observer, joint.position, start)
    return Position(joint, observer, joint.position if setup.resolution > 0.0 else start)
