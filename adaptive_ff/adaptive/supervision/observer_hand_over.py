"""Torque that passes between observer, integral and feedforward, so that what is asked of the drive does not jump."""

from numba.extending import register_jitable

from adaptive_ff.adaptive.supervision.circumstances import is_astray
from adaptive_ff.adaptive.supervision.observer_state import ObserverState
from controllers import remember


@register_jitable
def take_up(state: ObserverState, integral: float, moves: bool) -> tuple[ObserverState, float]:
    """Return the state, and what leaves the integral (N m), once a joint moves for which the observer was off.

    While it was off, the integral alone has grown to the torque that sets the joint free. Friction that is learnt now
    would come on top of it, for as long as the integral takes to unwind. So the observer takes that torque over, and
    gives back what is not needed within its time constant. The torque does not jump.

    Parameters
    ----------
    state : ObserverState
        The state.
    integral : float
        Integral of the feedback, N m.
    moves : bool
        Whether the joint is sure to move.
    """
    if not state.let_go or not moves or is_astray(state.stuck, state.away):
        return state, 0.0
    return (
        state._replace(disturbance=state.disturbance + integral, let_go=False),
        state.gain * integral,
    )


@register_jitable
def observe_all(state: ObserverState, integral: float) -> tuple[ObserverState, float]:
    """Return the state where an observer begins to follow, and what it gives no more for the moment, N m.

    While the plan rests the observer holds what it has, and the integral takes all that comes: a weight at a cold
    start, a payload that is picked. Once the plan sets out the observer would find that once more within some samples,
    beside the integral, which takes its time to unwind: behind a position loop a joint that is held against 18 times
    its friction would be thrown by up to 2.7 times the error of PI. So what both give is what is observed, with a gain
    of zero; as far as the gates open, it leaves the integral.

    Parameters
    ----------
    state : ObserverState
        The state.
    integral : float
        Integral of the feedback without what becomes friction of the feedforward, N m.
    """
    given = state.gain * state.disturbance
    return state._replace(disturbance=integral + given, gain=0.0), given


@register_jitable
def hand_over_to_observer(
    state: ObserverState, change: float, gain: float, fed: float, integral: float, spurious: float
) -> tuple[ObserverState, float]:
    """Return the state with what is fed forward now, and what leaves the integral of the feedback, N m.

    Neither a change of the feedforward nor one of the gain lets the torque jump: what the feedforward gives from now on
    (N m, ``change``), observer and integral need no longer give; what the observer no longer gives goes into the
    integral. Where the observer's gain rises, the integral holds part of what the observer now gives: that share goes.

    Parameters
    ----------
    state : ObserverState
        The state.
    change : float
        By how much the estimates have changed the torque that is fed forward, N m.
    gain : float
        The new gain.
    fed : float
        Torque that is fed forward over the coming period, known loads included, N m.
    integral : float
        Integral of the feedback, N m.
    spurious : float
        Part of what is observed that this sample has brought and that is none, N m: the integral takes none of it.
    """
    disturbance = state.disturbance - change
    leaves = (1.0 - state.gain) * change  # shared out at the old gain: the change of the gain comes after it
    if gain < state.gain:
        leaves -= (state.gain - gain) * (disturbance - spurious)
    elif gain > state.gain:
        leaves += (integral - leaves) * (gain - state.gain) / (1.0 - state.gain)
    return (
        state._replace(disturbance=disturbance, gain=gain, fed=remember(state.fed, fed)),
        leaves,
    )
