"""What closes the loop without identifying anything."""

from controllers.checks import check_positive
from controllers.compiled import compiled, compiled_in_place, dispatched, is_cached
from controllers.design import PIDesign, design_pi, fastest_bandwidth, pi_gains
from controllers.disturbance_observer import DisturbanceObserver
from controllers.extended_state import ExtendedState
from controllers.interface import (
    ESTIMATES,
    STEPS,
    Controller,
    Inputs,
    Output,
    feedback_state,
    step,
    with_feedforward,
    with_velocity,
    without_estimates,
    write_estimates,
)
from controllers.kalman_disturbance import KalmanDisturbance
from controllers.observer_design import ObserverDesign
from controllers.pi import PI, PIParameters, PIState, check_gains, hand_over, initial_pi_state, step_pi
from controllers.torques import acting_torque, slope_torque

__all__ = [
    "ESTIMATES",
    "PI",
    "STEPS",
    "Controller",
    "DisturbanceObserver",
    "ExtendedState",
    "Inputs",
    "KalmanDisturbance",
    "ObserverDesign",
    "Output",
    "PIDesign",
    "PIParameters",
    "PIState",
    "acting_torque",
    "check_gains",
    "check_positive",
    "compiled",
    "compiled_in_place",
    "design_pi",
    "dispatched",
    "fastest_bandwidth",
    "feedback_state",
    "hand_over",
    "initial_pi_state",
    "is_cached",
    "pi_gains",
    "slope_torque",
    "step",
    "step_pi",
    "with_feedforward",
    "with_velocity",
    "without_estimates",
    "write_estimates",
]
