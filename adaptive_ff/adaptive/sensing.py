"""What a sample of the supervised controller says, once it has been checked: stage by stage, doubtful inputs go."""

from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.command import machine_inputs
from adaptive_ff.adaptive.faults.doubt import Doubt, advance_doubt, believed_plan, undoubted_inputs
from adaptive_ff.adaptive.faults.drive_limit import watch_drive
from adaptive_ff.adaptive.faults.drive_limit_state import DriveLimit
from adaptive_ff.adaptive.faults.seen_velocity import SeenVelocity, advance_seen_velocity, seen_inputs
from adaptive_ff.adaptive.step import given_inertia_torque
from adaptive_ff.adaptive.supervised_state import SupervisedParameters, SupervisedState
from controllers import Inputs, plausible_inputs
from controllers.plausibility import Guard


class Sensed(NamedTuple):
    """What a sample says of plan, joint, drive and sensor.

    Attributes
    ----------
    inputs : Inputs
        What is observed and learnt from: without what is doubted, with the torque that the drive has probably given.
    checked : Inputs
        What the feedback goes by: plausible, and what the machine makes of it.
    guard : Guard
        What the check of the inputs remembers.
    given : float
        Torque of the inertia along the plan that is given with the torque known from elsewhere, N m.
    doubt : Doubt
        Doubt about what is measured.
    drive : DriveLimit
        What the motion has shown of the drive.
    seen : SeenVelocity
        What is remembered of measured velocities.
    """

    inputs: Inputs
    checked: Inputs
    guard: Guard
    given: float
    doubt: Doubt
    drive: DriveLimit
    seen: SeenVelocity


@register_jitable
def sense(block: SupervisedParameters, state: SupervisedState, inputs: Inputs) -> Sensed:
    """Return what a sample says of plan, joint, drive and sensor."""
    plausible, guard = plausible_inputs(block.feedback, state.feedback, inputs)
    given = given_inertia_torque(block, state, plausible)
    checked = machine_inputs(block.command, block.feedback, state.feedback, plausible, given)
    doubt = advance_doubt(block, state, checked, guard)
    drive, answered = watch_drive(block, state, checked)
    believed = undoubted_inputs(doubt, believed_plan(block, state, doubt, answered))
    seen = advance_seen_velocity(block, state, believed)
    return Sensed(seen_inputs(seen, believed), checked, guard, given, doubt, drive, seen)
