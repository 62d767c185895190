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
from typing import TYPE_CHECKING

from adaptive_ff.errors import InputError, check_positive
from adaptive_ff.files import template
from adaptive_ff.identify.columns import is_mapped

if TYPE_CHECKING:
    from adaptive_ff.identify.result import LogIdentification

EARTH = 9.81
"""Acceleration of gravity, m/s^2."""

NOT_EXPRESSED = ("friction_lag", "path", "load_friction", "viscous_asymmetry", "torque_delay")
"""What no engine has, beside a torque over the position."""

GEARED = {"coulomb": 1, "stiction": 1, "stiction_excess": 1, "offset": 1, "path": -1, "stribeck_velocity": -1}
GEARED |= dict.fromkeys(("inertia", "viscous", "viscous_asymmetry"), 2)
"""Power of the gear ratio by which the motor's number is the joint's."""

ENDINGS = {"mjcf": "joint.xml", "urdf": "joint.urdf", "isaac": "joint_isaac.py", "drake": "joint_drake.py"}
"""Names of the files that are written, and of their templates, by the simulator."""


def simulator_text(found: "LogIdentification", kind: str, *, gear_ratio: float = 1.0) -> str:
    """Return the joint as a file of a simulator, with what this cannot express as a comment.

    Parameters
    ----------
    found : LogIdentification
        The joint.
    kind : str
        ``mjcf``, ``urdf``, ``isaac`` or ``drake``.
    gear_ratio : float, optional
        Turns of the motor in one of the joint: of a log on the motor's side the joint's values are written.
    """
    if kind not in ENDINGS:
        raise InputError(f"simulator {kind!r} is not known; allowed: {', '.join(ENDINGS)}")
    check_positive(gear_ratio=gear_ratio)
    found.check_joint("joint of a simulator")
    model = found.torque_model(1.0 if found.units["torque"] == "A" else None)
    own = found.best.values | model._asdict()
    joint = {name: value * gear_ratio ** GEARED.get(name, int(is_mapped(name))) for name, value in own.items()}
    joint["gravity"] = found.gravity[0] * gear_ratio
    mass, centre = _weight(joint["inertia"], joint["gravity"], found.gravity[1])
    lines = [f"Joint identified from {found.source}: {found.grade}."]
    if found.units["torque"] == "A":
        lines.append("The torque of the log is a current: every number is per ampere; times the torque constant.")
    lines += _not_expressed(found, joint, kind)
    return template("adaptive_ff.identify", ENDINGS[kind]).render(
        **joint,
        linear=found.linear,
        axis="1 0 0" if found.linear else "0 1 0",
        mass=mass,
        centre=centre,
        link_inertia=0.5 * joint["inertia"] if mass else joint["inertia"],
        lines=lines,
    )


def _not_expressed(found: "LogIdentification", joint: dict[str, float], kind: str) -> list[str]:
    """Return what the joint has and the engines have not."""
    lost = []
    if joint["stiction"] > joint["coulomb"]:
        lost.append(f"stiction {joint['stiction']:.4g} with a Stribeck velocity of {joint['stribeck_velocity']:.4g}")
    if joint.get("stiction_excess", 0.0) < 0.0:
        lost.append(f"friction that is {-joint['stiction_excess']:.4g} less at low speed")
    beside = [name for name in found.best.values if name in NOT_EXPRESSED or is_mapped(name)]
    lost += [f"{name.replace('_', ' ')} {joint[name]:.4g}" for name in beside if joint[name]]
    lost += [f"{name}, which is not identified" for name in found.unidentified]
    if joint["offset"]:
        lost.append(f"offset {joint['offset']:.4g} (a constant torque against the motor's)")
    if joint["gravity"] and kind not in ("mjcf", "urdf"):
        lost.append(f"gravity {joint['gravity']:.4g} sin(q + {found.gravity[1]:.4g}): mass and centre of the link")
    return [f"Not among the joint's numbers: {'; '.join(lost)}."] if lost else []


def _weight(inertia: float, gravity: float, phase: float) -> tuple[float, tuple[float, float, float]]:
    """Return mass, kg, and centre, m, of a link with the joint's gravity about the axis y, and half of its inertia.

    A hanging link points to -z; turned by ``q`` about y its centre is at ``distance (-sin q, 0, -cos q)``.
    """
    if not gravity:
        return 0.0, (0.0, 0.0, 0.0)
    moment = gravity / EARTH
    distance = 0.5 * inertia / moment
    centre = (-distance * math.sin(phase), 0.0, -distance * math.cos(phase))
    return moment / distance, centre
