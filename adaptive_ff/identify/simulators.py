"""An identified joint in the terms of simulators: MuJoCo, URDF, Isaac (PhysX) and Drake.

=========  ==================  ===================  ============================  ===============
engine     inertia             Coulomb friction     viscous friction              load, gravity
=========  ==================  ===================  ============================  ===============
MuJoCo     ``armature``        ``frictionloss``     ``damping``                   of the bodies
URDF       of the link         ``friction``         ``damping``                   of the link
Isaac      ``armature``        ``friction``         ``damping`` of the drive      of the bodies
Drake      rotor inertia       not for revolute     ``damping``                   of the bodies
=========  ==================  ===================  ============================  ===============

``armature`` is added to what the bodies have: where these are modelled, write the rotor's inertia times the square of
the gear ratio alone. No engine has a Stribeck curve behind a lag; static friction above Coulomb's is in Isaac alone.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from adaptive_ff.errors import InputError
from adaptive_ff.identify.first_estimate import torque_model
from adaptive_ff.identify.result import IdentifiedJoint

EARTH = 9.81
"""Acceleration of gravity, m/s^2."""


class JointNumbers(NamedTuple):
    """What simulators take, on the joint's side: kg m^2, N m, N m s/rad, or kg, N, N s/m."""

    inertia: float
    coulomb: float
    stiction: float
    viscous: float
    stribeck_velocity: float
    gravity: float
    gravity_phase: float
    offset: float
    linear: bool


def numbers_of(found: IdentifiedJoint, gear_ratio: float) -> JointNumbers:
    """Return the numbers of a joint; of a log on the motor's side those behind a gear."""
    if not (gear_ratio > 0.0 and gear_ratio < float("inf")):
        raise InputError(f"gear_ratio = {gear_ratio:g} is not allowed: it must be positive and finite")
    model = torque_model(found, 1.0 if found.units["torque"] == "A" else None)
    square = gear_ratio**2
    amplitude, phase = found.gravity
    return JointNumbers(
        model.inertia * square,
        model.coulomb * gear_ratio,
        model.stiction * gear_ratio,
        model.viscous * square,
        model.stribeck_velocity / gear_ratio,
        amplitude * gear_ratio,
        phase,
        model.offset * gear_ratio,
        found.linear,
    )


def simulator_text(found: IdentifiedJoint, kind: str, *, gear_ratio: float = 1.0) -> str:
    """Return the joint in the words of a simulator: a file, with what it cannot express as a comment."""
    if kind not in SIMULATORS:
        raise InputError(f"simulator {kind!r} is not known; allowed: {', '.join(SIMULATORS)}")
    joint = numbers_of(found, gear_ratio)
    lines = [f"Joint identified from {found.source}: {found.grade}."]
    if found.units["torque"] == "A":
        lines.append("The torque of the log is a current: every number is per ampere; times the torque constant.")
    lines += _not_expressed(found, joint, kind)
    return SIMULATORS[kind](joint, lines)


def _not_expressed(found: IdentifiedJoint, joint: JointNumbers, kind: str) -> list[str]:
    """Return what the joint has and the engines have not."""
    lost = []
    if joint.stiction > joint.coulomb:
        lost.append(f"stiction {joint.stiction:.4g} with a Stribeck velocity of {joint.stribeck_velocity:.4g}")
    lost += [
        f"{name.replace('_', ' ')} {found.value(name):.4g}" for name in ("friction_lag", "path") if found.value(name)
    ]
    if joint.offset:
        lost.append(f"offset {joint.offset:.4g} (a constant torque against the motor's)")
    if joint.gravity and kind not in ("mjcf", "urdf"):
        lost.append(f"gravity {joint.gravity:.4g} sin(q + {joint.gravity_phase:.4g}): mass and centre of the link")
    return [f"Not among the joint's numbers: {'; '.join(lost)}."] if lost else []


def _comment(lines: list[str]) -> str:
    return "".join(f"<!-- {line.replace('--', '- -')} -->\n" for line in lines)


def _weight(joint: JointNumbers) -> tuple[float, tuple[float, float, float]]:
    """Return mass, kg, and centre, m, of a link with the joint's gravity about the axis y, and half of its inertia.

    A hanging link points to -z; turned by ``q`` about y its centre is at ``distance (-sin q, 0, -cos q)``.
    """
    if not joint.gravity:
        return 0.0, (0.0, 0.0, 0.0)
    moment = joint.gravity / EARTH
    distance = 0.5 * joint.inertia / moment
    centre = (-distance * math.sin(joint.gravity_phase), 0.0, -distance * math.cos(joint.gravity_phase))
    return moment / distance, centre


def _mjcf(joint: JointNumbers, lines: list[str]) -> str:
    mass, centre = _weight(joint)
    inertia = 0.5 * joint.inertia if mass else joint.inertia
    kind, axis = ("slide", "1 0 0") if joint.linear else ("hinge", "0 1 0")
    place = " ".join(f"{value:.9g}" for value in centre)
    friction = f'damping="{joint.viscous:.9g}" frictionloss="{joint.coulomb:.9g}"'
    return (
        _comment([*lines, "armature: inertia beside that of the bodies; damping: viscous; frictionloss: Coulomb."])
        + f"""<mujoco model="identified">
  <option timestep="0.0005" gravity="0 0 -9.81" integrator="implicitfast"/>
  <worldbody>
    <body name="link">
      <joint name="joint" type="{kind}" axis="{axis}" armature="{inertia:.9g}" {friction}/>
      <inertial pos="{place}" mass="{max(mass, 1e-9):.9g}" diaginertia="1e-9 1e-9 1e-9"/>
    </body>
  </worldbody>
  <actuator>
    <motor name="motor" joint="joint"/>
  </actuator>
</mujoco>
"""
    )


def _urdf(joint: JointNumbers, lines: list[str]) -> str:
    mass, centre = _weight(joint)
    kind = "prismatic" if joint.linear else "continuous"
    inertia = 0.5 * joint.inertia if mass else joint.inertia
    if joint.linear:
        mass = joint.inertia
    limit = '\n    <limit effort="1e9" velocity="1e9" lower="-1e9" upper="1e9"/>' if joint.linear else ""
    place = " ".join(f"{value:.9g}" for value in centre)
    axis = "1 0 0" if joint.linear else "0 1 0"
    return (
        '<?xml version="1.0"?>\n'
        + _comment([*lines, "damping: viscous; friction: Coulomb. URDF has no armature: the link has the inertia."])
        + f"""<robot name="identified">
  <link name="base"/>
  <link name="link">
    <inertial>
      <origin xyz="{place}"/>
      <mass value="{max(mass, 1e-9):.9g}"/>
      <inertia ixx="{inertia:.9g}" ixy="0" ixz="0" iyy="{inertia:.9g}" iyz="0" izz="{inertia:.9g}"/>
    </inertial>
  </link>
  <joint name="joint" type="{kind}">
    <parent link="base"/>
    <child link="link"/>
    <axis xyz="{axis}"/>
    <dynamics damping="{joint.viscous:.9g}" friction="{joint.coulomb:.9g}"/>{limit}
  </joint>
</robot>
"""
    )


def _isaac(joint: JointNumbers, lines: list[str]) -> str:
    notes = [
        *lines,
        "Actuator of Isaac Lab (joint friction of PhysX 5.6): armature adds to the bodies' inertia; friction is the",
        "static effort, dynamic_friction the Coulomb effort, viscous_friction that per velocity. Before Isaac Sim 5",
        "friction was a coefficient without unit: leave it at zero there. damping is a gain of the drive, no friction.",
    ]
    comment = "".join(f"# {line}\n" for line in notes)
    return (
        comment
        + f"""from isaaclab.actuators import ImplicitActuatorCfg

joint = ImplicitActuatorCfg(
    joint_names_expr=["joint"],
    stiffness=0.0,
    damping=0.0,
    armature={joint.inertia:.9g},
    friction={joint.stiction:.9g},
    dynamic_friction={joint.coulomb:.9g},
    viscous_friction={joint.viscous:.9g},
)
"""
    )


def _drake(joint: JointNumbers, lines: list[str]) -> str:
    notes = [
        *lines,
        "Drake: damping of the joint is viscous; rotor inertia (reflected) adds to that of the bodies. A revolute or",
        "prismatic joint has no Coulomb friction: apply it as a force element, as below.",
    ]
    comment = "".join(f"# {line}\n" for line in notes)
    kind = "Prismatic" if joint.linear else "Revolute"
    return (
        comment
        + f"""import math

COULOMB, STICTION, STRIBECK_VELOCITY = {joint.coulomb:.9g}, {joint.stiction:.9g}, {joint.stribeck_velocity:.9g}


def set_joint(joint, actuator):
    \"\"\"Set a {kind}Joint before the plant is finalized, and its actuator.\"\"\"
    joint.set_default_damping({joint.viscous:.9g})
    actuator.set_default_rotor_inertia({joint.inertia:.9g})
    actuator.set_default_gear_ratio(1.0)


def coulomb_torque(velocity, slow=1e-3):
    \"\"\"Return the torque to subtract from the actuator's.\"\"\"
    size = COULOMB + (STICTION - COULOMB) * math.exp(-abs(velocity) / STRIBECK_VELOCITY)
    return size * math.tanh(velocity / slow)
"""
    )


SIMULATORS: dict[str, Callable[[JointNumbers, list[str]], str]] = {
    "mjcf": _mjcf,
    "urdf": _urdf,
    "isaac": _isaac,
    "drake": _drake,
}
"""What writes a joint, by the simulator."""

ENDINGS = {"mjcf": "joint.xml", "urdf": "joint.urdf", "isaac": "joint_isaac.py", "drake": "joint_drake.py"}
"""Names of the files."""
