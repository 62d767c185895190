"""Torques that controllers with an observer reckon with."""

import math
from typing import Any

from controllers.pi import PIState, feed_back
from controllers.plausibility import Guard
from controllers.registry import Inputs, Output, acts_on_plan, present_inertia, with_feedforward


def acting_torque(inputs: Inputs, command: float, known_torque: float) -> float:
    """Return the torque (N m) that moved the joint over the period that ends, known loads taken out.

    What the drive realised counts, where it is known: so an observer knows of saturation, and does not wind up.

    Parameters
    ----------
    inputs : Inputs
        Inputs of the sample that ends the period.
    command : float
        Torque commanded for the period, N m; taken for the realised one where that is not known.
    known_torque : float
        Torque in it that carried a load known from elsewhere, N m.
    """
    realised = inputs.realised_torque if math.isfinite(inputs.realised_torque) else command
    return realised - known_torque


def slope_torque(inertia: float, inputs: Inputs, last_reference: float, started: bool, period: float) -> float:
    """Return the torque (N m) that makes an inertia follow the slope of the reference over the coming period.

    Parameters
    ----------
    inertia : float
        Inertia, kg m^2, where the inputs give none of the present configuration.
    inputs : Inputs
        Inputs now. The slope is that over the period in which the torque acts where it is known, else that to the next
        sample; without a preview the last slope of the reference is continued.
    last_reference : float
        Reference at the last sample, rad/s.
    started : bool
        Whether there was a last sample.
    period : float
        Nominal length of the coming period, s; the real one is not known yet.
    """
    inertia = present_inertia(inputs, inertia)
    if acts_on_plan(inputs):
        return inertia * (inputs.next_acting_reference - inputs.acting_reference) / period
    if math.isfinite(inputs.next_reference):
        return inertia * (inputs.next_reference - inputs.reference) / period
    return inertia * (inputs.reference - last_reference) / inputs.dt if started else 0.0


def feed_ahead_and_back(
    parameters: Any, state: Any, inputs: Inputs, guard: Guard, disturbance: float
) -> tuple[Output, PIState]:
    """Do one sample of the PI loop with the inertia's torque along the reference and a disturbance (N m) added."""
    started = state.feedback.samples > 0
    ahead = slope_torque(parameters.inertia, inputs, state.reference, started, parameters.period)
    fed = with_feedforward(inputs, ahead + disturbance)
    output, feedback = feed_back(parameters.feedback, state.feedback, fed, guard)
    return Output(output.torque, inputs.feedforward + ahead), feedback
