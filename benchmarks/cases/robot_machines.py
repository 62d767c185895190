"""Machines for MuJoCo: a hinge, an arm of two links in a vertical plane, an arm of six axes.

Friction is MuJoCo's own: ``frictionloss``, a constraint that holds like Coulomb friction, or the LuGre friction of its
``dcmotor`` actuator, here without any motor. Masses and friction are those of machines of this size, chosen once; none
was tuned. Rotors turn with the joints (``armature``), so the inertia depends on the pose less than that of the links.
"""

from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PHYSICS = 5e-4  # time step of the physics, s; controllers step on a multiple of it

STIFFNESS = 1e3
"""Bristle stiffness of a LuGre joint over its Coulomb friction, 1/rad: a milliradian bends the bristles fully ..."""

MICRO_DAMPING = 4.0  # ... and their damping over the Coulomb friction, s/rad.
STRIBECK = 0.05  # stribeck velocity of LuGre joints, rad/s; stiction is 1.3 times Coulomb friction

STICTION = 1.3

CREEP = 0.02
"""Time constant of MuJoCo's ``frictionloss`` (its ``solreffriction``), s: what it is where nothing is said.

A joint held by it creeps at a speed proportional to the torque; at 20 ms the friction of the roll axis is that of
Coulomb only from some 65 mrad/s on."""


class Axis(NamedTuple):
    """A joint as the controllers and the plan know it."""

    name: str  # its name
    coulomb: float  # coulomb, viscous: friction, N m and N m s/rad
    viscous: float
    preceding: tuple[str, ...]  # joints about parallel axes between the base and this one
    gravity: bool  # whether it carries a weight
    swing: float  # half of the range that it moves in, rad


class Machine(NamedTuple):
    """A machine."""

    name: str  # what the table calls it
    friction: str  # ``"coulomb"`` or ``"LuGre"``
    model: Any  # its physics; the first pose is the middle of the motion
    axes: tuple[Axis, ...]  # its joints, in the order of the model
    # shape (n,): inertia of each joint in the middle of the motion, kg m^2: what a designer would know
    inertia: Array


HINGE = (Axis("hinge", 60.0, 80.0, (), False, 0.6),)
ARM = (Axis("shoulder", 25.0, 20.0, (), True, 0.5), Axis("elbow", 12.0, 8.0, ("shoulder",), True, 0.6))
ROBOT = (
    Axis("waist", 25.0, 20.0, (), False, 0.6),
    Axis("upper", 30.0, 25.0, (), True, 0.4),
    Axis("fore", 20.0, 15.0, ("upper",), True, 0.4),
    Axis("roll", 6.0, 4.0, (), False, 0.4),
    Axis("pitch", 5.0, 4.0, ("upper", "fore"), True, 0.5),
    Axis("flange", 3.0, 2.0, (), False, 0.8),
)

KINDS = {"hinge": HINGE, "two-link arm": ARM, "six-axis arm": ROBOT}
BODIES = Path(__file__).parent / "machines"  # their bodies, NAME.xml


def make_machine(name: str, friction: str, creep: float = CREEP) -> Machine:
    """Make a machine by name, with ``"coulomb"`` friction that creeps with a time constant (s), or ``"LuGre"``."""
    axes, bodies = KINDS[name], (BODIES / f"{name}.xml").read_text()
    joints, bristles = {}, []
    for axis in axes:
        joints[axis.name] = f'damping="{axis.viscous}"'
        if friction == "coulomb":
            joints[axis.name] += f' frictionloss="{axis.coulomb}" solreffriction="{creep:g} 1"'
            continue
        law = (STIFFNESS * axis.coulomb, MICRO_DAMPING * axis.coulomb, axis.coulomb, STICTION * axis.coulomb, STRIBECK)
        numbers = " ".join(f"{value:g}" for value in law)
        bristles.append(
            f'<dcmotor joint="{axis.name}" motorconst="0 0" resistance="1" input="none" lugre="{numbers}"/>'
        )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{PHYSICS}" integrator="implicitfast"><flag contact="disable"/></option>'
        f'<compiler autolimits="true" angle="radian"/><worldbody>{bodies.format(**joints)}</worldbody>'
        f"<actuator>{''.join(bristles)}</actuator></mujoco>"
    )
    return Machine(name, friction, model, axes, inertia_of(model))


def inertia_of(model: Any) -> Array:
    """Return the inertia of each joint in the first pose, the others held, kg m^2."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    inertia = np.zeros(model.nv)
    for place, unit in enumerate(np.eye(model.nv)):
        row = np.zeros(model.nv)
        mujoco.mj_mulM(model, data, row, unit)
        inertia[place] = row[place]
    return inertia


def gravity_of(model: Any, data: Any, position: Array) -> Array:
    """Return the torques that hold a pose at rest, N m; ``data`` is scratch."""
    data.qpos[:], data.qvel[:] = position, 0.0
    mujoco.mj_forward(model, data)
    held: Array = data.qfrc_bias.copy()
    return held
