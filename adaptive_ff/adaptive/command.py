"""What stands between an adaptive controller and the machine: torque limit, known torque, feedforward on and off."""

import math
from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.friction.feedforward import FeedforwardState, coming_plan
from controllers import Inputs, PIParameters, PIState, present_inertia, with_feedforward, with_realised_torque

FADE = 1.0
"""Time in which the feedforward is faded in or out, s: long for the integral of the feedback, which takes over."""


class CommandParameters(NamedTuple):
    """Parameters of the command.

    Attributes
    ----------
    torque_limit : float
        Largest torque that is commanded, N m; infinite without a limit.
    includes_inertia : bool
        Whether the torque known from elsewhere includes that of the inertia along the plan.
    """

    torque_limit: float
    includes_inertia: bool


class CommandState(NamedTuple):
    """State of the command.

    Attributes
    ----------
    feedforward_enabled : bool
        Whether what is identified is fed forward.
    share : float
        Share of it that is: it fades to 1, or to 0.
    """

    feedforward_enabled: bool
    share: float


def initial_command_state() -> CommandState:
    """Return the state of a controller that feeds forward."""
    return CommandState(True, 1.0)


@register_jitable
def limited(torque: float, limit: float) -> float:
    """Return a torque (N m) cut off at a limit."""
    return min(max(torque, -limit), limit)


@register_jitable
def limited_torque(commands: tuple[float, ...], delay: float, limit: float) -> float:
    """Return the mean torque (N m) over the period that ends, every command of the line cut off at a limit."""
    whole = int(delay)
    torque = limited(commands[whole], limit)
    if whole < delay:
        rest = delay - whole
        torque = (1.0 - rest) * torque + rest * limited(commands[whole + 1], limit)
    return torque


@register_jitable
def inertia_torque(inertia: float, state: FeedforwardState, inputs: Inputs, period: float, delay: float) -> float:
    """Return the torque (N m) that moves the assumed inertia (kg m^2), or the given one, along the plan."""
    start, end = coming_plan(state, inputs, delay)
    return present_inertia(inputs, inertia) * (end - start) / period


@register_jitable
def machine_inputs(
    command: CommandParameters,
    feedback: PIParameters,
    state: PIState,
    inputs: Inputs,
    moved: float,
) -> Inputs:
    """Return the inputs with what the controller itself knows of them.

    The torque that its own limit let pass counts as realised where no other is given. What is known of the torque is
    known but for the inertia: that part, ``moved`` (N m), is taken out, since the model's takes its place.
    """
    if state.samples > 0 and not math.isfinite(inputs.realised_torque) and command.torque_limit < math.inf:
        realised = limited_torque(state.commands, feedback.delay, command.torque_limit)
        inputs = with_realised_torque(inputs, realised)
    if command.includes_inertia:
        inputs = with_feedforward(inputs, -moved)
    return inputs


@register_jitable
def fade(state: CommandState, duration: float) -> CommandState:
    """Return the state after a time (s)."""
    step = duration / FADE
    share = min(state.share + step, 1.0) if state.feedforward_enabled else max(state.share - step, 0.0)
    return CommandState(state.feedforward_enabled, share)
