"""Parameters and state of the estimator; see :mod:`adaptive_ff.adaptive.learning.estimator`."""

from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.adaptive.learning.candidate_state import CandidateState, initial_candidate_state
from adaptive_ff.adaptive.learning.change_detection import NO_ALARM, NOTHING, Alarm, Surprise
from adaptive_ff.adaptive.learning.friction_map import MapParameters, MapState, initial_map
from adaptive_ff.estimation.resetting import ResettingState, initial_resetting_state
from adaptive_ff.friction.bounds import COULOMB, FRICTION_LAG, OFFSET, STICTION
from adaptive_ff.learning.torque_form import TorqueForm
from adaptive_ff.regression.known_loads import COSINE, INPUT, SINE, initial_loads
from controllers.arrays import MutableArray

PRIOR = 6e-4
"""Information on a parameter at the start, if its standard deviation is its unit; it goes with the inverse variance."""

LAG_PRIOR = 20.0
"""Factor on that of the friction lag: without reversals it is not identifiable, and stays."""


class EstimatorParameters(NamedTuple):
    """Parameters of the estimator; constant.

    Attributes
    ----------
    form : TorqueForm
        The regression.
    first : ndarray, shape (n,)
        First estimate: inertia, Coulomb friction, stiction, viscous coefficient, friction lag, and the offset and what
        differs by direction where they are estimated.
    scale : ndarray, shape (n,)
        Unit in which each parameter is estimated, of its expected size.
    torque_scale : float
        Unit of torque, N m.
    memory : float
        Memory, s of sliding motion.
    ranges : ndarray, shape (n, 2)
        Least and largest possible value of each parameter before there are data; see ``possible_ranges``.
    regressors : int
        How many of the last parameters are sizes of further known regressors.
    waves : ndarray, shape (w,)
        Waves of torque over the position, times ``2 pi``, in a rad: one for gravity, more for ripples. The ``2 w``
        parameters before those of the regressors are sizes of a sine and a cosine of each.
    gear_ratio : float
        Measured position and velocity over those of the joint that gravity turns.
    deviation : ndarray, shape (n,)
        Standard deviation of the first estimate.
    given : bool
        Whether the first estimate is that of a model, which no guess replaces.
    candidates : ndarray, shape (v,)
        Stribeck velocities that are tried, rad/s, in ascending order; see ``adaptive.candidates``.
    presliding : ndarray, shape (d,)
        Presliding distances that are tried with the assumed Stribeck velocity, rad, in ascending order.
    fit_scale : ndarray, shape (k + 1,)
        Units of the parameters of friction, and of the micro-damping, which the candidates alone fit.
    begin : float
        Stribeck velocity to begin with, rad/s; that of the regression where there are no candidates.
    friction_map : MapParameters
        Map of friction over position and load.
    rises : bool
        Whether friction that rises from standstill on is taken for that at once, whatever reversals there are: in a
        controller that only watches.
    """

    form: TorqueForm
    first: NDArray[np.float64]
    scale: NDArray[np.float64]
    torque_scale: float
    memory: float
    ranges: NDArray[np.float64]
    regressors: int
    waves: NDArray[np.float64]
    gear_ratio: float
    deviation: NDArray[np.float64]
    given: bool
    candidates: NDArray[np.float64]
    presliding: NDArray[np.float64]
    fit_scale: NDArray[np.float64]
    begin: float
    friction_map: MapParameters
    rises: bool


class Levels(NamedTuple):
    """Levels of the signals so far.

    Attributes
    ----------
    squared_error : float
        Fading mean of the squared prediction error, in units of the torque scale squared.
    torque : float
        Largest filtered torque, N m.
    speed : float
        Largest filtered reference speed, rad/s.
    learnt : float
        For how long there has been something to learn from, s.
    stuck : float
        For how long the joint has not followed a reference that moves, before anything was learnt, s.
    """

    squared_error: float
    torque: float
    speed: float
    learnt: float
    stuck: float


class Scratch(NamedTuple):
    """Arrays that a sample is computed in, so that no step allocates memory; they hold nothing between samples.

    Attributes
    ----------
    row : ndarray, shape (n + 1 + m,)
        Regressors, and the derivatives of those of the ``m`` known loads.
    model_gradient, measured_gradient : ndarray, shape (n,)
        Scaled gradients of the predicted torque.
    ranges : ndarray, shape (n, 2)
        Least and largest possible value of each parameter, those of friction narrowed by the data.
    """

    row: MutableArray
    model_gradient: MutableArray
    measured_gradient: MutableArray
    ranges: MutableArray


class EstimatorState(NamedTuple):
    """State of the estimator; all its arrays are changed in place.

    Attributes
    ----------
    recursion : ResettingState
        Estimate, in the order of the first one, and information matrix of the scaled parameters.
    agreement : ndarray, shape (n, 2)
        Fading means of ``z^2`` and ``z x`` of each scaled gradient.
    levels : Levels
        Levels of error, torque and speed.
    surprise : Surprise
        Means over the short window, by which a change of friction is detected.
    alarm : Alarm
        Change that was noticed, and what it is attributed to.
    loads : ndarray, shape (m, 3)
        Filters of the regressors of known loads; see ``known_loads``.
    regressors : ndarray
        Further known regressors at the present sample; written before each step.
    scratch : Scratch
        Scratch.
    candidates : CandidateState
        Candidates for the Stribeck velocity, and the one in use.
    friction_map : MapState
        Map of friction over position and load.
    """

    recursion: ResettingState
    agreement: MutableArray
    levels: Levels
    surprise: Surprise
    alarm: Alarm
    loads: MutableArray
    regressors: MutableArray
    scratch: Scratch
    candidates: CandidateState
    friction_map: MapState


@register_jitable
def load_count(estimator: EstimatorParameters) -> int:
    """Return how many of the last parameters are sizes of known loads."""
    return estimator.regressors + 2 * estimator.waves.size


@register_jitable
def carries_loads(estimator: EstimatorParameters, state: "EstimatorState") -> bool:
    """Return whether there are loads to identify: further regressors, or waves once a position has been given."""
    if estimator.regressors > 0:
        return True
    if state.loads.shape[0] > 0:
        return state.loads[SINE, INPUT] != 0.0 or state.loads[COSINE, INPUT] != 0.0  # type: ignore[no-any-return]
    return False


def known_torque(first: NDArray[np.float64], loads: int) -> float:
    """Return the torque of a given model, N m: ``max(Fc, Fs) + |offset|`` and the sum of the sizes of its known loads.

    The largest torque so far, from which the ranges of the estimates follow, begins with it: it must not cut the model.
    """
    size = first.size - loads
    constant = abs(first[OFFSET]) if size > OFFSET else 0.0
    return float(max(first[COULOMB], first[STICTION]) + constant + np.sum(np.abs(first[size:])))


def initial_estimator_state(estimator: EstimatorParameters) -> EstimatorState:
    """Return the state of an estimator before its first sample."""
    size, loads = estimator.first.size, load_count(estimator)
    friction = estimator.first[: size - loads]
    information = PRIOR * np.diag((estimator.scale / estimator.deviation) ** 2)
    information[FRICTION_LAG, FRICTION_LAG] *= LAG_PRIOR
    largest = known_torque(estimator.first, loads) if estimator.given else 0.0
    return EstimatorState(
        recursion=initial_resetting_state(estimator.first, information),
        agreement=np.zeros((size, 2)),
        levels=Levels(0.0, largest, 0.0, 0.0, 0.0),
        surprise=Surprise(0.0, 0.0, 0.0),
        alarm=NO_ALARM,
        loads=initial_loads(loads),
        regressors=np.zeros(estimator.regressors),
        scratch=Scratch(np.zeros(size + 1 + loads), np.zeros(size), np.zeros(size), np.zeros((size, 2))),
        candidates=initial_candidate_state(estimator.candidates, estimator.presliding, estimator.begin, friction),
        friction_map=initial_map(estimator.friction_map),
    )


@register_jitable
def with_levels(state: EstimatorState, levels: Levels, surprise: Surprise, alarm: Alarm) -> EstimatorState:
    """Return the state with other levels, short means and alarm; it shares the arrays."""
    return state._replace(levels=levels, surprise=surprise, alarm=alarm)


@register_jitable
def lose_evidence_in_place(estimator: EstimatorParameters, state: EstimatorState) -> None:
    """Set the information to the prior's, without the factor on that of the friction lag, and the agreement to zero."""
    information = state.recursion.information
    for i in range(information.shape[0]):
        state.agreement[i, 0] = 0.0
        state.agreement[i, 1] = 0.0
        for j in range(information.shape[0]):
            information[i, j] = 0.0
        ratio = estimator.scale[i] / estimator.deviation[i]
        information[i, i] = PRIOR * ratio * ratio


@register_jitable
def begin_anew_in_place(estimator: EstimatorParameters, state: EstimatorState) -> EstimatorState:
    """Return the state with the first estimate and its information, where the data so far are not those of the joint.

    Levels but for the speed, short means and alarm begin anew as well; candidates and map stay. Changed in place.
    """
    recursion = state.recursion
    for i in range(recursion.estimate.size):
        recursion.estimate[i] = estimator.first[i]
    lose_evidence_in_place(estimator, state)
    recursion.information[FRICTION_LAG, FRICTION_LAG] *= LAG_PRIOR
    levels = Levels(0.0, 0.0, state.levels.speed, 0.0, 0.0)
    none = Alarm(NOTHING, 0.0, 0.0, 0.0, 0.0, 0.0, False)
    return with_levels(state, levels, Surprise(0.0, 0.0, 0.0), none)


@register_jitable
def with_curve(state: EstimatorState, candidates: CandidateState, friction_map: MapState) -> EstimatorState:
    """Return the state with other states of the candidates and of the map; it shares the arrays."""
    return state._replace(candidates=candidates, friction_map=friction_map)


@register_jitable
def with_candidates(state: EstimatorState, candidates: CandidateState) -> EstimatorState:
    """Return the state with another state of the candidates; it shares the arrays."""
    return with_curve(state, candidates, state.friction_map)


@register_jitable
def with_map(state: EstimatorState, friction_map: MapState) -> EstimatorState:
    """Return the state with another state of the map; it shares the arrays."""
    return with_curve(state, state.candidates, friction_map)


@register_jitable
def damping_in_use(state: EstimatorState) -> float:
    """Return the micro-damping of the candidate in use, N m."""
    damping = 0.0
    if state.candidates.errors.size > 0:
        damping = state.candidates.estimates[state.candidates.chosen, state.candidates.gain.size - 1]
    return damping


@register_jitable
def form_in_use(estimator: EstimatorParameters, state: EstimatorState) -> TorqueForm:
    """Return the regression with the Stribeck velocity that is in use."""
    form = estimator.form
    return TorqueForm(form.pole, state.candidates.stribeck_velocity, form.stribeck_shape, state.candidates.presliding)


@register_jitable
def lag_is_hidden(estimator: EstimatorParameters, state: EstimatorState, period: float) -> bool:
    """Return whether the data hold no information about the friction lag: ``<eps^2> T >= 2 m <z^2>``.

    ``<eps^2>`` is the mean squared prediction error, ``<z^2>`` that of the gradient of the lag, ``m`` the memory and
    ``T`` the period. With the other parameters known, the standard deviation of the lag would then be its unit or more
    (:mod:`adaptive_ff.adaptive.learning.uncertainty`). Noise in a fast loop hides the lag like that.
    """
    data = 2.0 * estimator.memory * state.agreement[FRICTION_LAG, 0]
    return state.levels.squared_error * period >= data  # type: ignore[no-any-return]


@register_jitable
def has_learnt(state: EstimatorState) -> bool:
    """Return whether the estimator has learnt from any sample."""
    return state.levels.learnt > 0.0


@register_jitable
def may_guess(estimator: EstimatorParameters, state: EstimatorState) -> bool:
    """Return whether friction may be guessed: nothing was learnt, and no model was given."""
    return not (estimator.given or has_learnt(state))
