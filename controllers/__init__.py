"""What closes the loop without identifying anything."""

from controllers.compiled import compiled, compiled_in_place, dispatched, is_cached
from controllers.design import PIDesign, design_pi, fastest_bandwidth, pi_gains
from controllers.interface import (
    ESTIMATES,
    STEPS,
    Controller,
    Inputs,
    Output,
    feedback_state,
    step,
    with_feedforward,
    without_estimates,
    write_estimates,
)
from controllers.pi import PI, PIParameters, PIState, check_gains, hand_over, initial_pi_state, step_pi
from controllers.velocity import DirectVelocity, estimate_velocity, initial_velocity

__all__ = [
    "ESTIMATES",
    "PI",
    "STEPS",
    "Controller",
    "DirectVelocity",
    "Inputs",
    "Output",
    "PIDesign",
    "PIParameters",
    "PIState",
    "check_gains",
    "compiled",
    "compiled_in_place",
    "design_pi",
    "dispatched",
    "estimate_velocity",
    "fastest_bandwidth",
    "feedback_state",
    "hand_over",
    "initial_pi_state",
    "initial_velocity",
    "is_cached",
    "pi_gains",
    "step",
    "step_pi",
    "with_feedforward",
    "without_estimates",
    "write_estimates",
]
