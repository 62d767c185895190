"""The drive between a controller and a joint as a discrete-time system of python-control."""

import math
from typing import Any

import control
import numpy as np

from adaptive_ff.blocks.state_vector import Vector
from plant import Actuator, realise_torque


def drive_block(actuator: Actuator, period: float, *, name: str = "drive") -> "control.NonlinearIOSystem":
    """Return a drive with limit, rate limit and resolution as a ``control.NonlinearIOSystem`` in discrete time.

    Parameters
    ----------
    actuator : Actuator
        The drive. What acts between the samples (delay, lag of the current loop, ripple, a torque constant that is
        off) is refused: ``adaptive_ff.simulate`` has it.
    period : float
        Sampling period, s.
    name : str, optional
        Name of the system.

    Returns
    -------
    control.NonlinearIOSystem
        Input ``command``; outputs ``torque``, which the joint is given now, and ``realised_torque``, which it was given
        in the last period, N m. Its attribute ``initial_state`` (ndarray) is the state at the start, no torque.

    Raises
    ------
    ValueError
        The period is not positive and finite, or the drive has one of these.
    """
    if not (math.isfinite(period) and period > 0.0):
        raise ValueError(f"period = {period} is not allowed: it must be positive, s")
    for field, plain in (("delay", 0.0), ("lag", 0.0), ("ripple_amplitude", 0.0), ("gain", 1.0)):
        value = getattr(actuator, field)
        if value != plain:
            raise ValueError(
                f"{field} = {value:g} is not allowed in a block: it must be {plain:g}; adaptive_ff.simulate has it"
            )
    parameters = actuator.parameters

    def given(x: Vector, u: Vector) -> float:
        return realise_torque(parameters, float(np.asarray(u)[0]), float(x[0]), period)

    def update(t: float, x: Vector, u: Vector, params: Any) -> Vector:
        return np.array([given(x, u)])

    def outputs(t: float, x: Vector, u: Vector, params: Any) -> Vector:
        return np.array([given(x, u), x[0]])

    system = control.NonlinearIOSystem(
        update,
        outputs,
        name=name,
        inputs=["command"],
        outputs=["torque", "realised_torque"],
        states=["given"],
        dt=float(period),
    )
    system.initial_state = np.zeros(1)
    return system
