"""Joint, drive and controllers as discrete-time systems of python-control, for ``control.interconnect``.

The state of a kernel, nested named tuples of numbers and arrays, is one vector of floats. A solver may evaluate a block
at a state as often as it likes. Kernels of learning controllers change the arrays of their state in place; a state that
is rebuilt from a vector has arrays of its own, so nothing is ever learnt twice.
"""

import copy
import math
from collections.abc import Callable, Sequence
from typing import Any

import control
import numpy as np
from numpy.typing import NDArray

from controllers import Controller, Inputs
from controllers.kernels.memory import Leaf, leaves, value_at
from controllers.kernels.memory import rebuilt as with_numbers
from controllers.kernels.types import type_of
from plant import (
    INITIAL_STATE,
    SENSED_VELOCITY,
    STEP_JOINT,
    Actuator,
    AnyJoint,
    gravity_torque,
    realise_torque,
    whole_multiple,
)

Vector = NDArray[np.float64]

SIGNALS = ("reference", "velocity", "next_reference", "realised_torque")
"""Inputs of a controller's block by default."""

KNOWN = tuple(name for name in Inputs._fields if name != "dt")
"""Inputs that a controller's block may have."""


def controller_block(
    controller: Controller, *, name: str = "controller", inputs: Sequence[str] = SIGNALS
) -> "control.NonlinearIOSystem":
    """Return a controller as a ``control.NonlinearIOSystem`` in discrete time, with the controller's period.

    The whole state of the controller, estimates included, is the state of the system: update and output are functions
    of state and inputs, so that python-control may evaluate them as often as it likes. The controller that is given
    is not changed by a simulation.

    Parameters
    ----------
    controller : Controller
        ``PI``, ``AdaptiveController`` or any other controller of the package. Hand its present state over as
        ``initial_state``: python-control starts at zeros by default, which are a new ``PI``. Where zeros are no state
        (of all controllers that learn), they stand for the present one.
    name : str, optional
        Name of the system.
    inputs : sequence of str, optional
        Signals that it takes, some of ``reference``, ``velocity``, ``next_reference``, ``correction`` (rad/s),
        ``position`` (rad), ``realised_torque``, ``feedforward`` (N m), ``inertia`` (kg m^2), ``acting_reference`` and
        ``next_acting_reference`` (rad/s, both or none); the first two must be there. What is not there is not known to
        the controller.

    Returns
    -------
    control.NonlinearIOSystem
        Outputs are ``torque`` and ``feedforward_torque`` (N m) and ``estimated_NAME`` for each estimate, as they are
        when the step is done. Its attribute ``initial_state`` (ndarray) is the state that the controller has now.

    Raises
    ------
    ValueError
        The controller is of another kind, whose steps have effects that cannot be repeated, or a signal is not known.

    Examples
    --------
    >>> from controllers import PI
    >>> from adaptive_ff.blocks import controller_block
    >>> controller_block(PI(100.0, 500.0, 0.01)).output_labels
    ['torque', 'feedforward_torque']
    """
    if not isinstance(controller, Controller):
        raise ValueError(
            f"controller = {type(controller).__name__} is not allowed: a solver evaluates a block several times a "
            "sample, and a step of this object changes the object; it must be a controller of this package, whose "
            "state is explicit"
        )
    _check_inputs(inputs)
    new = copy.deepcopy(controller)
    new.reset()
    # python-control starts at zeros where it is given no state; of a controller that learns they are none
    begin, replaces_zeros = state_vector(controller.state), bool(np.any(state_vector(new.state)))
    worker, template, estimates = copy.deepcopy(controller), copy.deepcopy(controller.state), controller.estimate_names

    def advance(x: Vector, u: Vector) -> float:
        """Do one step of the worker from a state; return the torque, N m."""
        worker.state = rebuilt(template, begin if replaces_zeros and not np.any(x) else x)
        return worker.step(**dict(zip(inputs, np.asarray(u, dtype=np.float64).tolist(), strict=True)))

    def update(x: Vector, u: Vector) -> Vector:
        advance(x, u)
        return state_vector(worker.state)

    def outputs(x: Vector, u: Vector) -> Vector:
        torque = advance(x, u)
        feedforward = float(worker.native.exchange[-1])  # behind inputs and torque
        return np.array([torque, feedforward, *worker.estimates.values()])

    return _system(
        update,
        outputs,
        begin.copy(),
        name=name,
        inputs=list(inputs),
        outputs=["torque", "feedforward_torque", *(f"estimated_{estimate}" for estimate in estimates)],
        states=state_names(template),
        dt=controller.period,
    )


def _check_inputs(inputs: Sequence[str]) -> None:
    for signal in inputs:
        if signal not in KNOWN:
            raise ValueError(f"inputs = {signal!r} is not known; there are {', '.join(KNOWN)}")
    for signal in ("reference", "velocity"):
        if signal not in inputs:
            raise ValueError(f"inputs = {list(inputs)} is not allowed: {signal} is missing")
    if len(set(inputs)) < len(inputs):
        raise ValueError(f"inputs = {list(inputs)} is not allowed: a signal is there twice")


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

    def update(x: Vector, u: Vector) -> Vector:
        return np.array([given(x, u)])

    def outputs(x: Vector, u: Vector) -> Vector:
        return np.array([given(x, u), x[0]])

    return _system(
        update,
        outputs,
        np.zeros(1),
        name=name,
        inputs=["command"],
        outputs=["torque", "realised_torque"],
        states=["given"],
        dt=float(period),
    )


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

    def update(x: Vector, u: Vector) -> Vector:
        state, torque = rebuilt(start, x), float(np.asarray(u)[0])
        for _ in range(steps):
            state = step(parameters, state, torque - gravity_torque(weight, state.position), solver)
        return state_vector(state)

    def outputs(x: Vector, u: Vector) -> Vector:
        state = rebuilt(start, x)
        return np.array([sensed(state), state.position, state.friction_torque])

    return _system(
        update,
        outputs,
        state_vector(start),
        name=name,
        inputs=["torque"],
        outputs=["velocity", "position", "friction"],
        states=state_names(start),
        dt=float(period),
    )


def _system(
    update: Callable[[Vector, Vector], Vector],
    output: Callable[[Vector, Vector], Vector],
    initial_state: Vector,
    /,
    **described: Any,
) -> "control.NonlinearIOSystem":
    """Return a system that does not vary with time, by its functions of state and inputs."""
    system = control.NonlinearIOSystem(
        lambda t, x, u, params: update(x, u), lambda t, x, u, params: output(x, u), **described
    )
    system.initial_state = initial_state
    return system


def state_names(state: Any) -> list[str]:
    """Return a name for each number of a state, in the order of the vector: its fields, joined by underscores."""
    return [
        name
        for leaf in _leaves(state)
        for name in ([f"{leaf.storage}_{place}" for place in range(leaf.count)] if leaf.is_array else [leaf.storage])
    ]


def state_vector(state: Any) -> Vector:
    """Return all numbers of a state, shape (n,); counts and truth values as floats, which hold them exactly."""
    parts = [np.ravel(np.asarray(value_at(state, leaf.path), dtype=np.float64)) for leaf in _leaves(state)]
    return np.concatenate([np.zeros(0), *parts])


def rebuilt(template: Any, vector: Vector) -> Any:
    """Return a state like the template, with arrays of its own and the numbers of a vector, shape (n,)."""
    found = _leaves(template)
    ends = np.cumsum([leaf.count for leaf in found])
    if ends[-1] != np.size(vector):
        raise ValueError(f"the vector has {np.size(vector)} numbers; the state has {ends[-1]}")
    parts = zip(found, np.split(np.asarray(vector, dtype=np.float64), ends[:-1]), strict=True)
    return with_numbers(template, (part if leaf.is_array else part.item() for leaf, part in parts))


def _leaves(state: Any) -> list[Leaf]:
    return list(leaves(type_of(state, "state", sizes=True)))
