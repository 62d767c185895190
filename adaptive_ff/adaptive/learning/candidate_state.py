"""State of the bank of candidates; see :mod:`adaptive_ff.adaptive.learning.candidates`."""

from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.friction.model import WITH_OFFSET
from controllers.arrays import MutableArray


class CandidateState(NamedTuple):
    """State of the candidates, ``m`` of them with ``n`` parameters of friction; all arrays are changed in place.

    Attributes
    ----------
    filters : ndarray, shape (m, k, 2)
        Filtered value and derivative of ``g``, ``h``, and ``|h|`` where friction differs by direction.
    bent : ndarray, shape (d, 2, 2)
        Of those with a presliding distance, the last ones: ``g`` and ``h`` behind the lag over the path, and the
        filtered micro-damping and its derivative.
    moments : ndarray, shape (m, n + 3, n + 3)
        Fading moments of the regressors, the micro-damping and the regressed torque.
    estimates : ndarray, shape (m, n + 1)
        Estimates, the micro-damping (N m) last.
    errors : ndarray, shape (m,)
        Mean squared errors of the torque, N^2 m^2.
    chosen : int
        The one in use.
    turn : int
        The one whose turn it is.
    phase : int
        What is done at the next sample; see ``candidates.FLAT_ROWS``.
    share : float
        Share with which the last row was taken into account.
    seen : float
        For how long there have been moments, s of sliding motion.
    waited : float
        For how long the moments of those without a presliding distance have not been taken, s of sliding motion.
    stribeck_velocity : float
        Stribeck velocity in use, rad/s; without candidates, the assumed one.
    presliding : float
        Presliding distance in use, rad; zero without.
    reversals : ndarray, shape (2,)
        Least and largest acceleration at which the reference reversed, started or stopped of late, rad/s^2, else zero.
    row : ndarray, shape (n + 3,)
        Scratch: regressors and torque.
    products : ndarray, shape (n + 1, n + 3)
        Scratch: moments of gradient and regressors.
    factor : ndarray, shape (n + 1, n + 1)
        Scratch: information, and its Cholesky factor.
    gain, work : ndarray, shape (n + 1,)
        Scratch.
    ranges : ndarray, shape (n + 1, 2)
        Scratch: possible values.
    """

    filters: MutableArray
    bent: MutableArray
    moments: MutableArray
    estimates: MutableArray
    errors: MutableArray
    chosen: int
    turn: int
    phase: int
    share: float
    seen: float
    waited: float
    stribeck_velocity: float
    presliding: float
    reversals: MutableArray
    row: MutableArray
    products: MutableArray
    factor: MutableArray
    gain: MutableArray
    work: MutableArray
    ranges: MutableArray


def initial_candidate_state(
    velocities: NDArray[np.float64], distances: NDArray[np.float64], begin: float, first: NDArray[np.float64]
) -> CandidateState:
    """Return the state of candidates that have seen nothing.

    Parameters
    ----------
    velocities : ndarray, shape (v,)
        Stribeck velocities of those without presliding, rad/s.
    distances : ndarray, shape (d,)
        Presliding distances of the others, rad.
    begin : float
        Stribeck velocity to begin with, rad/s: one of them where there are any.
    first : ndarray, shape (n,)
        First estimate of friction.
    """
    count, size = velocities.size + distances.size, first.size
    rows = 2 if size <= len(WITH_OFFSET) else 3
    chosen = int(np.argmin(np.abs(velocities - begin))) if count else 0
    return CandidateState(
        filters=np.zeros((count, rows, 2)),
        bent=np.zeros((distances.size, 2, 2)),
        moments=np.zeros((count, size + 3, size + 3)),
        estimates=np.tile(np.append(first, 0.0), (count, 1)),
        errors=np.zeros(count),
        chosen=chosen,
        turn=0,
        phase=0,
        share=0.0,
        seen=0.0,
        waited=0.0,
        stribeck_velocity=float(begin),
        presliding=0.0,
        reversals=np.zeros(2),
        row=np.zeros(size + 3),
        products=np.zeros((size + 1, size + 3)),
        factor=np.zeros((size + 1, size + 1)),
        gain=np.zeros(size + 1),
        work=np.zeros(size + 1),
        ranges=np.zeros((size + 1, 2)),
    )


@register_jitable
def slides(state: CandidateState) -> bool:
    """Return whether the candidate in use has no bristles; with them, what looks like a change is how they bend."""
    return state.presliding <= 0.0


@register_jitable
def with_numbers(
    state: CandidateState,
    turn: int,
    phase: int,
    share: float,
    seen: float,
    waited: float,
    chosen: int,
    velocity: float,
    presliding: float,
) -> CandidateState:
    """Return the state with all that is no array given anew; it shares the arrays."""
    return state._replace(
        chosen=chosen,
        turn=turn,
        phase=phase,
        share=share,
        seen=seen,
        waited=waited,
        stribeck_velocity=velocity,
        presliding=presliding,
    )


@register_jitable
def with_turn(state: CandidateState, turn: int, phase: int, share: float, seen: float, waited: float) -> CandidateState:
    """Return the state with another turn, phase, share, time seen and time waited (s)."""
    chosen, velocity, presliding = state.chosen, state.stribeck_velocity, state.presliding
    return with_numbers(state, turn, phase, share, seen, waited, chosen, velocity, presliding)


@register_jitable
def with_choice(state: CandidateState, chosen: int, velocity: float, presliding: float) -> CandidateState:
    """Return the state with another candidate in use; its Stribeck velocity is in rad/s, its distance in rad."""
    turn, phase, share, seen, waited = state.turn, state.phase, state.share, state.seen, state.waited
    return with_numbers(state, turn, phase, share, seen, waited, chosen, velocity, presliding)


@register_jitable
def forgetful(state: CandidateState) -> CandidateState:
    """Return the state as if there had been no moments: those that there are fade with the next ones."""
    return with_turn(state, state.turn, 0, 0.0, 0.0, 0.0)
