"""What is simulated: friction laws, the joint and its step, sensor, actuator, friction that changes."""

from plant.actuator import Actuator, ActuatorParameters, realise_torque
from plant.elastic import ElasticParameters, ElasticState, scaled_elastic, step_elastic
from plant.elastic_joint import ElasticJoint
from plant.friction import Stribeck, sliding_friction, steepest_fall, stribeck_decay
from plant.joint import JointModel, whole_multiple
from plant.kinds import (
    CHECK_PERIOD,
    INITIAL_STATE,
    SCALE_JOINT,
    SENSED_VELOCITY,
    STEP_JOINT,
    AnyJoint,
    Joint,
    initial_state,
)
from plant.lugre import LuGreParameters, LuGreState, scaled_lugre, step_lugre
from plant.lugre_joint import LuGreJoint
from plant.schedule import FrictionChange, JointSchedule, joint_in_phase, schedule
from plant.sensor import VelocitySensor
from plant.step import JointParameters, JointState, scaled_joint, step_joint

__all__ = [
    "CHECK_PERIOD",
    "INITIAL_STATE",
    "SCALE_JOINT",
    "SENSED_VELOCITY",
    "STEP_JOINT",
    "Actuator",
    "ActuatorParameters",
    "AnyJoint",
    "ElasticJoint",
    "ElasticParameters",
    "ElasticState",
    "FrictionChange",
    "Joint",
    "JointModel",
    "JointParameters",
    "JointSchedule",
    "JointState",
    "LuGreJoint",
    "LuGreParameters",
    "LuGreState",
    "Stribeck",
    "VelocitySensor",
    "initial_state",
    "joint_in_phase",
    "realise_torque",
    "scaled_elastic",
    "scaled_joint",
    "scaled_lugre",
    "schedule",
    "sliding_friction",
    "steepest_fall",
    "step_elastic",
    "step_joint",
    "step_lugre",
    "stribeck_decay",
    "whole_multiple",
]
