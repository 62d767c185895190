"""A joint as a discrete-time system of python-control."""

from typing import Any

import control
import numpy as np

from adaptive_ff.blocks.state_vector import Vector, rebuilt, state_names, state_vector
from plant import INITIAL_STATE, SENSED_VELOCITY, STEP_JOINT, AnyJoint, gravity_torque, whole_multiple


def joint_block(
    model: AnyJoint, period: float, *, velocity: float = 0.0, name: str = "joint"
) -> "control.NonlinearIOSystem":
    """Return a joint of any kind as a ``control.NonlinearIOSystem`` in discrete time.

    The joint is stepped at its own solver period as ``simulate`` does, under a torque that is held over the sampling
    period. There is no such system in continuous time: friction at rest is set-valued, and needs the implicit step.

    Parameters
    ----------
    model : JointModel, LuGreJoint or another of ``plant.AnyJoint``
        The joint.
    period : float
        Sampling period, s, a whole number of solver periods.
    velocity : float, optional
        Velocity at the start, rad/s; the joint has moved so for long.
    name : str, optional
        Name of the system.

    Returns
    -------
    control.NonlinearIOSystem
        Input ``torque`` (N m); outputs ``velocity`` (rad/s) at the sensor, ``position`` (rad) and ``friction`` (N m),
        none of which depends on the torque of the same sample. Its attribute ``initial_state`` (ndarray) is the state
        at the start.

    Raises
    ------
    ValueError
        The period is no whole number of solver periods, or the velocity is not finite.
    """
    solver = model.solver_period
    steps = whole_multiple(period, solver)
    if steps is None:
        raise ValueError(
            f"period = {period} s is not allowed: it must be a whole number of solver periods of {solver:g} s"
        )
    if not np.isfinite(velocity):
        raise ValueError(f"velocity = {velocity} is not allowed: it must be a finite number of rad/s")
    parameters, weight = model.parameters, model.weight
    start = INITIAL_STATE[type(parameters)](parameters, float(velocity))
    step, sensed = STEP_JOINT[type(parameters)], SENSED_VELOCITY[type(start)]

    def update(t: float, x: Vector, u: Vector, params: Any) -> Vector:
        state, torque = rebuilt(start, x), float(np.asarray(u)[0])
        for _ in range(steps):
            state = step(parameters, state, torque - gravity_torque(weight, state.position), solver)
        return state_vector(state)

    def outputs(t: float, x: Vector, u: Vector, params: Any) -> Vector:
        state = rebuilt(start, x)
        return np.array([sensed(state), state.position, state.friction_torque])

    system = control.NonlinearIOSystem(
        update,
        outputs,
        name=name,
        inputs=["torque"],
        outputs=["velocity", "position", "friction"],
        states=state_names(start),
        dt=float(period),
    )
    system.initial_state = state_vector(start)
    return system
