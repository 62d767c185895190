"""What is simulated: friction laws, joints and their steps, sensors, drives, friction that changes."""

from plant.actuator import Actuator, ActuatorParameters, lagged_torque, realise_torque, ripple_torque
from plant.backlash import BacklashJoint, BacklashParameters, BacklashState, step_backlash
from plant.change import UNCHANGED, JointChange, scaled_friction
from plant.elastic import ElasticJoint, ElasticParameters, ElasticState, step_elastic
from plant.elasto_plastic import (
    ElastoPlasticJoint,
    ElastoPlasticParameters,
    ElastoPlasticState,
    step_elasto_plastic,
)
from plant.friction import Stribeck, sliding_friction, steepest_fall, stribeck_decay
from plant.gravity import Gravity, gravity_torque
from plant.joint import FrictionFields, JointModel, whole_multiple
from plant.kinds import AnyJoint, Joint, initial_state
from plant.lugre import LuGreJoint, LuGreParameters, LuGreState, scaled_lugre, step_lugre
from plant.maxwell import MaxwellJoint, MaxwellParameters, MaxwellState, RollingJoint, scaled_maxwell, step_maxwell
from plant.registry import (
    CHANGE_JOINT,
    CHECK_PERIOD,
    INITIAL_STATE,
    READY_JOINT,
    SCALE_JOINT,
    SENSED_VELOCITY,
    STEP_JOINT,
    STEP_READY,
)
from plant.schedule import (
    FrictionChange,
    FrictionSchedule,
    FrictionVariation,
    check_factor,
    friction_factor,
    heated,
    phase_change,
    schedule,
)
from plant.sensor import AngleRipple, Sensor, encoder_reading, measured_angle, measured_speed
from plant.step import JointParameters, JointState, scaled_joint, step_joint

__all__ = [
    "CHANGE_JOINT",
    "CHECK_PERIOD",
    "INITIAL_STATE",
    "READY_JOINT",
    "SCALE_JOINT",
    "SENSED_VELOCITY",
    "STEP_JOINT",
    "STEP_READY",
    "UNCHANGED",
    "Actuator",
    "ActuatorParameters",
    "AngleRipple",
    "AnyJoint",
    "BacklashJoint",
    "BacklashParameters",
    "BacklashState",
    "ElasticJoint",
    "ElasticParameters",
    "ElasticState",
    "ElastoPlasticJoint",
    "ElastoPlasticParameters",
    "ElastoPlasticState",
    "FrictionChange",
    "FrictionFields",
    "FrictionSchedule",
    "FrictionVariation",
    "Gravity",
    "Joint",
    "JointChange",
    "JointModel",
    "JointParameters",
    "JointState",
    "LuGreJoint",
    "LuGreParameters",
    "LuGreState",
    "MaxwellJoint",
    "MaxwellParameters",
    "MaxwellState",
    "RollingJoint",
    "Sensor",
    "Stribeck",
    "check_factor",
    "encoder_reading",
    "friction_factor",
    "gravity_torque",
    "heated",
    "initial_state",
    "lagged_torque",
    "measured_angle",
    "measured_speed",
    "phase_change",
    "realise_torque",
    "ripple_torque",
    "scaled_friction",
    "scaled_joint",
    "scaled_lugre",
    "scaled_maxwell",
    "schedule",
    "sliding_friction",
    "steepest_fall",
    "step_backlash",
    "step_elastic",
    "step_elasto_plastic",
    "step_joint",
    "step_lugre",
    "step_maxwell",
    "stribeck_decay",
    "whole_multiple",
]
