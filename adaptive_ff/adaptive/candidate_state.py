"""State of the bank of candidates; see :mod:`adaptive_ff.adaptive.candidates`."""

from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.model.friction import WITH_OFFSET
from controllers.arrays import MutableArray


class CandidateState(NamedTuple):
    """State of the candidates, ``m`` of them with ``n`` parameters of friction; all arrays are changed in place.

    Attributes
    ----------
    filters : ndarray, shape (m, k, 2)
        Filtered value and derivative of ``g``, ``h``, and ``|h|`` where friction differs by direction.
    moments : ndarray, shape (m, n + 2, n + 2)
        Fading moments of the regressors and, in the last place, of the regressed torque.
    estimates : ndarray, shape (m, n)
        Estimates.
    errors : ndarray, shape (m,)
        Mean squared errors of the torque, N^2 m^2.
    chosen : int
        The one in use.
    turn : int
        The one whose turn it is.
    seen : float
        For how long there have been moments, s of sliding motion.
    waited : float
        For how long no moments have been taken, s of sliding motion.
    stribeck_velocity : float
        Stribeck velocity in use, rad/s; without candidates, the assumed one.
    row : ndarray, shape (n + 2,)
        Scratch: regressors and torque.
    products : ndarray, shape (n, n + 2)
        Scratch: moments of gradient and regressors.
    factor : ndarray, shape (n, n)
        Scratch: information, and its Cholesky factor.
    gain, work : ndarray, shape (n,)
        Scratch.
    """

    filters: MutableArray
    moments: MutableArray
    estimates: MutableArray
    errors: MutableArray
    chosen: int
    turn: int
    seen: float
    waited: float
    stribeck_velocity: float
    row: MutableArray
    products: MutableArray
    factor: MutableArray
    gain: MutableArray
    work: MutableArray


def initial_candidate_state(
    velocities: NDArray[np.float64], begin: float, first: NDArray[np.float64]
) -> CandidateState:
    """Return the state of candidates that have seen nothing.

    Parameters
    ----------
    velocities : ndarray, shape (m,)
        Their Stribeck velocities, rad/s.
    begin : float
        The one to begin with, rad/s: one of them where there are any.
    first : ndarray, shape (n,)
        First estimate of friction.
    """
    count, size = velocities.size, first.size
    rows = 2 if size <= len(WITH_OFFSET) else 3
    chosen = int(np.argmin(np.abs(velocities - begin))) if count else 0
    return CandidateState(
        np.zeros((count, rows, 2)),
        np.zeros((count, size + 2, size + 2)),
        np.tile(first, (count, 1)),
        np.zeros(count),
        chosen,
        0,
        0.0,
        0.0,
        float(begin),
        np.zeros(size + 2),
        np.zeros((size, size + 2)),
        np.zeros((size, size)),
        np.zeros(size),
        np.zeros(size),
    )


@register_jitable(forceinline=True)
def with_turn(state: CandidateState, turn: int, seen: float, waited: float) -> CandidateState:
    """Return the state with another turn, time seen and time waited (s); it shares the arrays."""
    return CandidateState(
        state.filters,
        state.moments,
        state.estimates,
        state.errors,
        state.chosen,
        turn,
        seen,
        waited,
        state.stribeck_velocity,
        state.row,
        state.products,
        state.factor,
        state.gain,
        state.work,
    )


@register_jitable(forceinline=True)
def with_choice(state: CandidateState, chosen: int, velocity: float) -> CandidateState:
    """Return the state with another candidate, and its Stribeck velocity (rad/s), in use; it shares the arrays."""
    return CandidateState(
        state.filters,
        state.moments,
        state.estimates,
        state.errors,
        chosen,
        state.turn,
        state.seen,
        state.waited,
        velocity,
        state.row,
        state.products,
        state.factor,
        state.gain,
        state.work,
    )


@register_jitable(forceinline=True)
def forgetful(state: CandidateState) -> CandidateState:
    """Return the state as if there had been no moments: those that there are fade with the next ones."""
    return with_turn(state, state.turn, 0.0, 0.0)
