"""What is simulated: friction laws, joints and their steps, sensors, drives, friction that changes."""

from plant.actuator import Actuator, ActuatorParameters, realise_torque, ripple_torque
from plant.friction import Stribeck, sliding_friction, steepest_fall, stribeck_decay
from plant.joint import JointModel, whole_multiple
from plant.kinds import (
    CHECK_PERIOD,
    INITIAL_STATE,
    SCALE_JOINT,
    SENSED_VELOCITY,
    STEP_JOINT,
    Joint,
    initial_state,
)
from plant.schedule import (
    FrictionChange,
    FrictionSchedule,
    FrictionVariation,
    check_factor,
    friction_factor,
    schedule,
)
from plant.sensor import Sensor, encoder_reading
from plant.step import JointParameters, JointState, scaled_joint, step_joint

__all__ = [
    "CHECK_PERIOD",
    "INITIAL_STATE",
    "SCALE_JOINT",
    "SENSED_VELOCITY",
    "STEP_JOINT",
    "Actuator",
    "ActuatorParameters",
    "FrictionChange",
    "FrictionSchedule",
    "FrictionVariation",
    "Joint",
    "JointModel",
    "JointParameters",
    "JointState",
    "Sensor",
    "Stribeck",
    "check_factor",
    "encoder_reading",
    "friction_factor",
    "initial_state",
    "realise_torque",
    "ripple_torque",
    "scaled_joint",
    "schedule",
    "sliding_friction",
    "steepest_fall",
    "step_joint",
    "stribeck_decay",
    "whole_multiple",
]
