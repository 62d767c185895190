"""Controllers that drive MuJoCo: PI, PI with fixed feedforward from true values, and a group of adaptive joints."""

from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from adaptive_ff import TorqueModel
from adaptive_ff.baselines.model_based import ModelBased
from benchmarks.cases.robot_machines import PHYSICS, STICTION, STRIBECK, Machine, gravity_of
from benchmarks.cases.robot_plans import Plan
from benchmarks.cases.stepped import GROUPS, controller_class
from controllers import PI, PositionLoop

Array = NDArray[np.float64]

BANDWIDTH = 8.0  # Hz, of the velocity loop
VELOCITY_NOISE = 2e-3  # rad/s
RESOLUTION = 6e-6  # rad, of the encoder


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


def lag_of(setup: Setup) -> float:
    """Return by how much the measured velocity lags, s: half a period where it is a difference of readings."""
    return 0.5 / setup.rate if setup.cascade else 0.0


def make_pi(machine: Machine, setup: Setup) -> Separate:
    """Make a PI loop for each joint."""
    period = 1.0 / setup.rate
    designs = [PI.design(inertia=inertia, period=period, bandwidth=BANDWIDTH) for inertia in machine.inertia]
    return Separate([PI(design.proportional, design.integral, period) for design in designs])


def make_fixed(machine: Machine, setup: Setup) -> Separate:
    """Make loops with feedforward from the true friction and the inertia in the middle of the motion.

    A joint that MuJoCo's Coulomb friction holds at rest creeps, which is known here: with friction held, it is up to
    five times worse.
    """
    period, made = 1.0 / setup.rate, []
    for axis, inertia in zip(machine.axes, machine.inertia, strict=True):
        design = PI.design(inertia=inertia, period=period, bandwidth=BANDWIDTH)
        stiction = axis.coulomb if machine.friction == "coulomb" else STICTION * axis.coulomb
        model = TorqueModel(float(inertia), axis.coulomb, stiction, axis.viscous, 0.0, STRIBECK, 1.0)
        held = 0.0 if machine.friction == "coulomb" else 1.0
        gains = design.proportional, design.integral
        made.append(ModelBased(*gains, period, model, velocity_lag=lag_of(setup), held=held))
    return Separate(made)


def make_adaptive(machine: Machine, setup: Setup, name: str = "adaptive") -> Any:
    """Make adaptive joints that know nothing of friction; gravity is learnt where it is not given."""
    period, joints = 1.0 / setup.rate, {}
    for axis, inertia in zip(machine.axes, machine.inertia, strict=True):
        design = PI.design(inertia=inertia, period=period, bandwidth=BANDWIDTH)
        learns_gravity = axis.gravity and not setup.gravity_given
        joints[axis.name] = {
            "proportional": design.proportional,
            "integral": design.integral,
            "inertia": float(inertia),
            "stribeck_velocity": STRIBECK,
            "velocity_lag": lag_of(setup),
            "identify": "gravity" if learns_gravity else "offset",
            **({} if setup.gravity_given else {"preceding": axis.preceding}),
        }
    return controller_class(name, GROUPS).from_table({"period": period, "joints": joints})


def make_controllers(name: str, machine: Machine, setup: Setup) -> Any:
    """Make the controllers of all joints by a name: PI, ``model_based`` with the truth, or a group that learns."""
    makers = {"pi": make_pi, "model_based": make_fixed}
    return makers[name](machine, setup) if name in makers else make_adaptive(machine, setup, name)


def drive(machine: Machine, controller: Any, plan: Plan, setup: Setup, seed: int) -> Driven:
    """Run a machine along a plan and return what was left."""
    model, data, scratch = machine.model, mujoco.MjData(machine.model), mujoco.MjData(machine.model)
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
            inputs["feedforward"] = gravity_of(model, scratch, read)
        velocity_error[k], position_error[k] = plan.velocity[k] - data.qvel, plan.position[k] - data.qpos
        torques[k] = controller.step(plan.velocity[k], velocity, **inputs)
        data.qfrc_applied[:] = torques[k]
        mujoco.mj_step(model, data, substeps)
    return Driven(velocity_error, position_error, torques)
