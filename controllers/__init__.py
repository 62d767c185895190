"""What closes the loop without identifying anything."""

from controllers.checks import check_positive
from controllers.compiled import compiled, compiled_in_place, dispatched, is_cached
from controllers.delay import delay_line, delayed, remember
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
from controllers.pi import PI, PIParameters, PIState, asked_torque, check_gains, hand_over, initial_pi_state, step_pi
from controllers.saving import plain_state, rebuilt_state
from controllers.torques import acting_torque, slope_torque
from controllers.velocity import (
    INITIAL_VELOCITY_STATES,
    VELOCITY_ESTIMATORS,
    DirectVelocity,
    direct_velocity,
    estimate_velocity,
    initial_velocity_state,
)
from controllers.velocity_difference import DifferenceVelocity, difference_velocity
from controllers.velocity_kalman import KalmanVelocity, kalman_velocity
from controllers.velocity_low_pass import LowPassVelocity, low_pass_velocity

__all__ = [
    "ESTIMATES",
    "INITIAL_VELOCITY_STATES",
    "PI",
    "STEPS",
    "VELOCITY_ESTIMATORS",
    "Controller",
    "DifferenceVelocity",
    "DirectVelocity",
    "DisturbanceObserver",
    "ExtendedState",
    "Inputs",
    "KalmanDisturbance",
    "KalmanVelocity",
    "LowPassVelocity",
    "ObserverDesign",
    "Output",
    "PIDesign",
    "PIParameters",
    "PIState",
    "acting_torque",
    "asked_torque",
    "check_gains",
    "check_positive",
    "compiled",
    "compiled_in_place",
    "delay_line",
    "delayed",
    "design_pi",
    "difference_velocity",
    "direct_velocity",
    "dispatched",
    "estimate_velocity",
    "fastest_bandwidth",
    "feedback_state",
    "hand_over",
    "initial_pi_state",
    "initial_velocity_state",
    "is_cached",
    "kalman_velocity",
    "low_pass_velocity",
    "pi_gains",
    "plain_state",
    "rebuilt_state",
    "remember",
    "slope_torque",
    "step",
    "step_pi",
    "with_feedforward",
    "with_velocity",
    "without_estimates",
    "write_estimates",
]
