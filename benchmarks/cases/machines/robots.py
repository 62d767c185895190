"""Machines in MuJoCo, their plans, and the controllers that drive them.

They are a hinge, an arm of two links in a vertical plane, and an arm of six axes. Friction is MuJoCo's own:
``frictionloss``, a constraint that holds like Coulomb friction, or the LuGre friction of its ``dcmotor`` actuator, here
without any motor. Masses and friction are those of machines of this size, chosen once; none was tuned. Rotors turn with
the joints (``armature``), so the inertia depends on the pose less than that of the links.
"""

import math
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from adaptive_ff import JointGroup, TorqueModel, load_scenario
from adaptive_ff.baselines.model_based import ModelBased
from benchmarks.cases.holding import RESOLUTION, drawn_moves
from benchmarks.cases.stepped import controller_class
from controllers import PI, PositionLoop

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
    swing: float  # half of the range that it moves in, rad
    gravity: bool = False  # whether it carries a weight
    preceding: Sequence[str] = ()  # joints about parallel axes between the base and this one


class Machine(NamedTuple):
    """A machine."""

    friction: str  # ``"coulomb"`` or ``"LuGre"``
    model: Any  # its physics; the first pose is the middle of the motion
    axes: list[Axis]  # its joints, in the order of the model
    # shape (n,): inertia of each joint in the middle of the motion, kg m^2: what a designer would know
    inertia: Array


MACHINES = Path(__file__).parent  # their axes, ``axes.toml``, and bodies, NAME.xml
KINDS = {
    name: [Axis(**axis) for axis in axes]
    for name, axes in tomllib.loads((MACHINES / "axes.toml").read_text(encoding="utf-8")).items()
}


def make_machine(name: str, friction: str, creep: float = CREEP) -> Machine:
    """Make a machine by name, with ``"coulomb"`` friction that creeps with a time constant (s), or ``"LuGre"``."""
    axes, bodies = KINDS[name], (MACHINES / f"{name}.xml").read_text()
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
    data, inertia = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, inertia)
    return Machine(friction, model, axes, np.diag(inertia))


SINES = 6
SLOWEST, FASTEST = 0.1, 0.9  # Hz
FADE = 2.0  # s, in which a multisine rises from rest
SPEEDS, ACCELERATION = (0.3, 0.9), 2.0  # rad/s (drawn between these), rad/s^2


class Plan(NamedTuple):
    """What the joints are to do, at samples 0 to n inclusive."""

    velocity: Array  # velocity, position: shape (n + 1, joints): planned velocity, rad/s, and its integral, rad
    position: Array


def multisines(axes: Sequence[Axis], seed: int, duration: float, period: float) -> Plan:
    """Draw a sum of sines for each axis, which rises from rest and keeps within its swing."""
    time = period * np.arange(round(duration / period) + 1)
    fraction = np.clip(time / FADE, 0.0, 1.0)
    rise = fraction**3 * (10.0 - 15.0 * fraction + 6.0 * fraction**2)
    slope = 30.0 * fraction**2 * (1.0 - fraction) ** 2 / FADE
    velocity, position = np.zeros((2, time.size, len(axes)))
    for place, axis in enumerate(axes):
        generator = np.random.default_rng([seed, place, 5])
        omega = 2.0 * math.pi * generator.uniform(SLOWEST, FASTEST, (SINES, 1))
        phase = omega * time + generator.uniform(0.0, 2.0 * math.pi, (SINES, 1))
        wave, rate = np.sum(np.sin(phase) / omega, axis=0), np.sum(np.cos(phase), axis=0)
        size = axis.swing / np.max(np.abs(wave))
        position[:, place] = size * rise * wave
        velocity[:, place] = size * (slope * wave + rise * rate)
    return Plan(velocity, position)


def moves(axes: Sequence[Axis], seed: int, duration: float, period: float) -> Plan:
    """Draw moves from point to point for each axis, with a rest after each."""
    columns = []
    for place, axis in enumerate(axes):
        generator = np.random.default_rng([seed, place, 7])
        scenario = load_scenario().modified(
            duration=duration + period,
            reference=drawn_moves(generator, SPEEDS, axis.swing, ACCELERATION, duration),
            sampling={"period": period},
            joint={"solver_period": period},
        )
        columns.append(scenario.reference_velocity()[: round(duration / period) + 1])
    velocity = np.column_stack(columns)
    steps = 0.5 * period * (velocity[1:] + velocity[:-1])
    return Plan(velocity, np.vstack([np.zeros(len(axes)), np.cumsum(steps, axis=0)]))


def then_rest(plan: Plan, rest: float, period: float) -> Plan:
    """Let each axis end where it was last at rest in a plan, and stay there to its end and for ``rest`` (s) more."""
    velocity = np.vstack([plan.velocity, np.zeros((round(rest / period), plan.velocity.shape[1]))])
    position = np.vstack([plan.position, np.repeat(plan.position[-1:], round(rest / period), axis=0)])
    for place, planned in enumerate(plan.velocity.T):
        last = np.flatnonzero(planned == 0.0)[-1]
        velocity[last:, place], position[last:, place] = 0.0, plan.position[last, place]
    return Plan(velocity, position)


BANDWIDTH = 8.0  # Hz, of the velocity loop
VELOCITY_NOISE = 2e-3  # rad/s


class Setup(NamedTuple):
    """How a machine is driven."""

    rate: int  # sampling rate, Hz
    cascade: bool  # whether a position loop is outside; its encoder then gives the velocity, too
    gravity_given: bool  # whether all controllers are given the torque of gravity


class Driven(NamedTuple):
    """A run."""

    # velocity_error, position_error: shape (samples, joints): planned minus true velocity, rad/s, and position, rad,
    # at the samples
    velocity_error: Array
    position_error: Array
    torque: Array  # shape (samples, joints): torque, N m


class Separate:
    """Controllers of single joints with the call of a group."""

    def __init__(self, controllers: list[Any]) -> None:
        self.controllers = controllers

    def step(self, reference: Array, velocity: Array, **others: Array) -> Array:
        """Return the torques, N m; see :meth:`adaptive_ff.JointGroup.step`."""
        torques = []
        for place, controller in enumerate(self.controllers):
            own = {name: float(values[place]) for name, values in others.items() if name != "position"}
            torques.append(controller.step(float(reference[place]), float(velocity[place]), **own))
        return np.array(torques)


def make_controllers(name: str, machine: Machine, setup: Setup) -> Any:
    """Make the controllers of all joints by a name.

    There are PI; ``model_based``, with feedforward from the true friction and the inertia in the middle of the motion;
    and adaptive joints that know nothing of friction, and learn gravity where it is not given. A joint that MuJoCo's
    Coulomb friction holds at rest creeps, which is known here: with friction held, ``model_based`` is up to five times
    worse.
    """
    period, joints, holds = 1.0 / setup.rate, {}, machine.friction != "coulomb"
    lag = 0.5 * period if setup.cascade else 0.0  # of the velocity, where it is a difference of readings
    for axis, inertia in zip(machine.axes, machine.inertia.tolist(), strict=True):
        design = PI.design(inertia=inertia, period=period, bandwidth=BANDWIDTH)
        gains = {"proportional": design.proportional, "integral": design.integral}
        if name == "pi":
            joints[axis.name] = PI(**gains, period=period)
        elif name == "model_based":
            stiction = (STICTION if holds else 1.0) * axis.coulomb
            model = TorqueModel(inertia, axis.coulomb, stiction, axis.viscous, 0.0, STRIBECK, 1.0)
            joints[axis.name] = ModelBased(*gains.values(), period, model, velocity_lag=lag, held=float(holds))
        else:
            learns_gravity = axis.gravity and not setup.gravity_given
            joints[axis.name] = {
                **gains,
                "inertia": inertia,
                "stribeck_velocity": STRIBECK,
                "velocity_lag": lag,
                "torque_limit": math.inf,
                "identify": "gravity" if learns_gravity else "offset",
                **({} if setup.gravity_given else {"preceding": axis.preceding}),
            }
    if name in ("pi", "model_based"):
        return Separate(list(joints.values()))
    controller_class(name)  # known?
    return JointGroup.from_table({"period": period, "joints": joints})


def drive(machine: Machine, name: str, plan: Plan, setup: Setup, seed: int) -> Driven:
    """Run a machine along a plan with the controllers of a name, and return what was left."""
    controller = make_controllers(name, machine, setup)
    model, data, still = machine.model, mujoco.MjData(machine.model), mujoco.MjData(machine.model)
    generator, period = np.random.default_rng([seed, 11]), 1.0 / setup.rate
    substeps, count, joints = round(period / PHYSICS), plan.velocity.shape[0] - 1, len(machine.axes)
    data.qpos[:] = plan.position[0]
    outer = PositionLoop(PositionLoop.design(period=period, bandwidth=BANDWIDTH).gain)
    last = RESOLUTION * np.round(data.qpos / RESOLUTION)
    velocity_error, position_error, torques = np.zeros((3, count, joints))
    for k in range(count):
        read = RESOLUTION * np.round(data.qpos / RESOLUTION)
        noise = VELOCITY_NOISE * generator.standard_normal(joints)
        inputs = {"next_reference": plan.velocity[k + 1], "position": read}
        if setup.cascade:
            velocity, last = (read - last) / period, read
            pairs = zip(plan.position[k], read, strict=True)
            inputs["correction"] = np.array([outer.step(planned, measured) for planned, measured in pairs])
        else:
            velocity = data.qvel + noise
        if setup.gravity_given:
            still.qpos[:], still.qvel[:] = read, 0.0
            mujoco.mj_forward(model, still)
            inputs["feedforward"] = still.qfrc_bias.copy()
        velocity_error[k], position_error[k] = plan.velocity[k] - data.qvel, plan.position[k] - data.qpos
        torques[k] = controller.step(plan.velocity[k], velocity, **inputs)
        data.qfrc_applied[:] = torques[k]
        mujoco.mj_step(model, data, substeps)
    return Driven(velocity_error, position_error, torques)
