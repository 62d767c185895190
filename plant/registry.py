"""The kernels of every kind of joint, found by the class of its parameters: a kind registers itself in its own file."""

from collections.abc import Callable
from typing import Any

from plant.friction import scaled_friction

Kernels = dict[type, Callable[..., Any]]

STEP_JOINT: Kernels = {}
"""Kernel ``step(parameters, state, torque, period) -> state`` for each class of parameters."""

READY_JOINT: Kernels = {}
"""Kernel ``ready(parameters, period) -> ready`` for each class of parameters: constants of the step, found once."""

STEP_READY: Kernels = {}
"""Kernel ``step(ready, state, torque, period) -> state`` for each class that :data:`READY_JOINT` makes."""

SCALE_JOINT: Kernels = {}
"""Kernel ``scaled(parameters, factor) -> parameters`` for each class of parameters: friction times a factor."""

CHANGE_JOINT: Kernels = {}
"""Kernel ``changed(parameters, change) -> parameters`` for each class of parameters; see ``plant.friction``."""

SENSED_VELOCITY: Kernels = {}
"""Kernel ``sensed(state) -> velocity`` at the motor, rad/s, for each class of states."""

INITIAL_STATE: Kernels = {}
"""``initial(parameters, velocity) -> state``, in plain Python, for each class of parameters."""

CHECK_PERIOD: Kernels = {}
"""``check(parameters, period)``, in plain Python, for each class of parameters; refuses a solver period."""


def as_it_is(joint: Any, period: float) -> Any:
    """Return a joint whose step has no constants worth keeping."""
    return joint


def sensed_velocity(state: Any) -> float:
    """Return the velocity at the motor, rad/s, of a rigid joint of any kind: it has one velocity."""
    return state.velocity  # type: ignore[no-any-return]


def register(
    parameters: type,
    state: type,
    step: Callable[..., Any],
    initial: Callable[..., Any],
    check_period: Callable[..., None],
    changed: Callable[..., Any],
    scaled: Callable[..., Any] = scaled_friction,
    sensed: Callable[..., Any] = sensed_velocity,
) -> None:
    """Register a kind of joint; what each argument is stands at the table that it goes into."""
    STEP_JOINT[parameters] = STEP_READY[parameters] = step
    READY_JOINT[parameters] = as_it_is
    SCALE_JOINT[parameters], CHANGE_JOINT[parameters] = scaled, changed
    SENSED_VELOCITY[state] = sensed
    INITIAL_STATE[parameters], CHECK_PERIOD[parameters] = initial, check_period
