"""A controller as a discrete-time system of python-control."""

import copy
from collections.abc import Sequence
from typing import Any

import control
import numpy as np

from adaptive_ff.blocks.state_vector import Vector, rebuilt, state_names, state_vector
from controllers import Controller, Inputs

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

    def update(t: float, x: Vector, u: Vector, params: Any) -> Vector:
        advance(x, u)
        return state_vector(worker.state)

    def outputs(t: float, x: Vector, u: Vector, params: Any) -> Vector:
        torque = advance(x, u)
        feedforward = float(worker.native.exchange[-1])  # behind inputs and torque
        return np.array([torque, feedforward, *worker.estimates.values()])

    system = control.NonlinearIOSystem(
        update,
        outputs,
        name=name,
        inputs=list(inputs),
        outputs=["torque", "feedforward_torque", *(f"estimated_{estimate}" for estimate in estimates)],
        states=state_names(template),
        dt=controller.period,
    )
    system.initial_state = begin.copy()
    return system


def _check_inputs(inputs: Sequence[str]) -> None:
    for signal in inputs:
        if signal not in KNOWN:
            raise ValueError(f"inputs = {signal!r} is not known; there are {', '.join(KNOWN)}")
    for signal in ("reference", "velocity"):
        if signal not in inputs:
            raise ValueError(f"inputs = {list(inputs)} is not allowed: {signal} is missing")
    if len(set(inputs)) < len(inputs):
        raise ValueError(f"inputs = {list(inputs)} is not allowed: a signal is there twice")
