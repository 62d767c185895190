"""Sliding gate: which samples may be learnt from.

The friction map holds while the joint slides. Around zero velocity the joint may stick, where friction is whatever the
torque is, and an equation taken there is false; a filter remembers it for a few of its time constants. So the gate
closes at low speed and opens a hold time after.

But nothing shows the friction lag as clearly as a reversal. While the estimator is young, the gate therefore opens at
once after a reversal that the joint passed about as fast as its reference: it can have stuck for a moment only. That
leaves a bias of a few per cent, which is forgotten later, when every reversal closes the gate.
"""

from typing import NamedTuple

from numba.extending import register_jitable

PATIENCE = 1.5
"""How much longer than its reference a joint may be slow in a reversal that is passed."""


class Gate(NamedTuple):
    """Parameters of the gate.

    Attributes
    ----------
    slowest : float
        Speed below which the joint may stick, rad/s.
    hold : float
        For how long the joint must have been sliding, s.
    margin : float
        How much longer than ``PATIENCE`` allows the joint may be slow in a reversal that is passed, s.
    """

    slowest: float
    hold: float
    margin: float


class GateState(NamedTuple):
    """State of the gate.

    Attributes
    ----------
    sliding : float
        For how long the joint has been sliding, reversals that were passed included, s.
    slow : float
        For how long it has been slow since then, s; zero while it slides.
    allowed : float
        For how long its reference has been slow, s.
    """

    sliding: float
    slow: float
    allowed: float


def initial_gate_state(gate: Gate) -> GateState:
    """Return the state at the start: the filters start from a guess, so the hold is twice as long."""
    return GateState(-gate.hold, 0.0, 0.0)


@register_jitable(forceinline=True)
def slides(velocity: float, reference: float, valid: bool, slowest: float) -> bool:
    """Tell whether a joint slides; one that moves against its reference does not count.

    Parameters
    ----------
    velocity, reference : float
        Measured and reference velocity, rad/s.
    valid : bool
        Whether the measurement is one.
    slowest : float
        Speed below which the joint may stick, rad/s.
    """
    return valid and abs(velocity) >= slowest and velocity * reference > 0.0


@register_jitable(forceinline=True)
def sliding_time(elapsed: float, velocity: float, slowest: float, duration: float) -> float:
    """Return for how long a joint without a reference has been sliding, s, where every stop counts.

    Parameters
    ----------
    elapsed : float
        For how long it had been at the last sample, s.
    velocity, slowest : float
        Its velocity, and the speed below which it may stick, rad/s.
    duration : float
        Time since the last sample, s.
    """
    return elapsed + duration if slides(velocity, velocity, True, slowest) else 0.0


@register_jitable(forceinline=True)
def step_gate(
    gate: Gate, state: GateState, velocity: float, reference: float, valid: bool, young: bool, duration: float
) -> GateState:
    """Return the state of the gate at a sample.

    Parameters
    ----------
    gate : Gate
        The gate.
    state : GateState
        State at the last sample.
    velocity : float
        Measured velocity, rad/s.
    reference : float
        Reference velocity, rad/s.
    valid : bool
        Whether the measurement is one.
    young : bool
        Whether reversals may be passed.
    duration : float
        Time since the last sample, s.
    """
    turning = abs(reference) < gate.slowest
    allowed = state.allowed + duration if turning else state.allowed
    if slides(velocity, reference, valid, gate.slowest):
        passed = state.slow == 0.0 or (young and state.slow <= PATIENCE * allowed + gate.margin)
        sliding = state.sliding + duration if passed else duration
        return GateState(sliding, 0.0, allowed if turning else 0.0)
    return GateState(state.sliding, state.slow + duration, allowed)


@register_jitable(forceinline=True)
def is_open(gate: Gate, state: GateState) -> bool:
    """Tell whether the sample may be learnt from."""
    return state.slow == 0.0 and state.sliding > gate.hold
