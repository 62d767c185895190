"""The filter ``S`` of each observer, as its design needs it."""

import math

from controllers.design.kalman_gains import scaled_disturbance_gains
from controllers.design.observer_design import on_measured_velocity, on_observed_velocity
from controllers.design.sampled_loop import Compensation, SampledLoop
from controllers.observers.inertia_observer import double_pole_gains


def disturbance_observer_compensation(loop: SampledLoop, angle: float) -> Compensation:
    """Return ``S`` of a disturbance observer with a bandwidth in radians a sample."""
    return on_measured_velocity(1.0, -math.expm1(-angle))


def extended_state_compensation(loop: SampledLoop, angle: float) -> Compensation:
    """Return ``S`` of an extended state observer with a bandwidth in radians a sample."""
    return on_observed_velocity(loop, *double_pole_gains(1.0, angle, 1.0))


def kalman_compensation(loop: SampledLoop, angle: float) -> Compensation:
    """Return ``S`` of a Kalman filter of the disturbance with a bandwidth in radians a sample."""
    return on_measured_velocity(*scaled_disturbance_gains(angle))
