"""A bank of candidates for what the regression is not linear in: Stribeck velocity and presliding distance.

The columns ``g`` and ``h`` of the torque form need a Stribeck velocity ``Vs``. Where bristles bend before they slide,
both follow over the path, ``dy/dx = (F - y)/s`` with a presliding distance ``s``, and there is a column of
micro-damping, ``exp(-(w/Vs)^2) s (dU/dt)/Vs`` with ``U = g + h``. A few candidates, ``(Vs_i, 0)`` and ``(Vs, s_i)``,
run beside what is in use. Candidate ``i`` has filters of its own for these columns over the reference, which are free
of noise, and fading second moments of its row ``x_i``, which are the normal equations of least squares:

    S_i <- S_i + v (1 - lambda) (x_i x_i' - S_i),    x_i = (w''_f, w'_f, g_f, h_f, w_f, -u'_f, 1, .., micro; u_f)

All else is common to the candidates; ``u_f`` is measured, less the known loads. The weight ``v`` is one, and less
where the candidate in use leaves an error that is out of proportion. The estimate ``P_i`` is fitted to these moments by
Gauss-Newton, one step of one candidate at a time, so that the time of a sample hardly grows with their number. The
prior is the estimate in use, ``P``, which holds what the motion does not excite:

    P_i <- P_i + (A_i + rho I)^-1 (b_i + rho (P - P_i))

``A_i`` and ``b_i`` are the moments of the gradient of the prediction, and of the gradient with its error. The score is
the mean squared error ``E_i`` of the torque that ``P_i`` leaves on these rows. On rows of the reference the noise does
not depend on the candidate; on measured rows a smooth curve would win because it averages the chatter of the sign.

A candidate that leaves clearly less than the one in use takes its place: the estimator goes on with its estimate and
its information, the gate with its speed, and the feedforward with its curve. The micro-damping is the candidate's own:
the estimator takes it as known. Where the model holds, a factor of two in ``Vs`` leaves 1.5 to 100 times the mean
square; where it does not (gravity that is not modelled), all candidates leave within some 10 % of each other, and the
margin keeps the one that is assumed. A presliding distance is kept only while it leaves clearly less than the best
candidate without one.

The bank is a small multiple-model estimator, K. Narendra and J. Balakrishnan, "Adaptive control using multiple models"
(IEEE Transactions on Automatic Control, 1997); the score on the reference is this package's.
"""

import math

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.adaptive.learning.candidate_margins import alike, least_error, margin_of, note_reversal_in_place
from adaptive_ff.adaptive.learning.candidate_moments import (
    complete_in_place,
    note_moments_in_place,
    residual_moments_in_place,
    write_information,
)
from adaptive_ff.adaptive.learning.candidate_state import CandidateState, forgetful, slides, with_choice, with_turn
from adaptive_ff.adaptive.learning.correction import correct_in_place
from adaptive_ff.adaptive.learning.estimator_state import EstimatorParameters, EstimatorState
from adaptive_ff.adaptive.learning.prediction import add_loads, scale_inertia_in_place
from adaptive_ff.estimation.resetting import ResettingState, factor_in_place, solve_in_place, total_of
from adaptive_ff.friction.bounds import (
    COULOMB,
    FRICTION_LAG,
    INERTIA,
    OFFSET,
    STICTION,
    VISCOUS,
    VISCOUS_ASYMMETRY,
)
from adaptive_ff.friction.model import adhesion_share
from adaptive_ff.learning.filters import advance_filter_in_place, filter_decay
from adaptive_ff.learning.torque_form import (
    BENT,
    FILTER_ADHESION,
    FILTER_COULOMB,
    FILTER_SHARE,
    FILTER_TORQUE,
    Signals,
    advance_bent_in_place,
    bending_of,
    write_regressors,
)

MEMORIES = 4.0
"""Memory of the moments, in memories of the estimator ..."""

GROWTH = 0.5
"""... and at most this share of the time for which there have been any: the first ones come from a poor start."""

ONE_WAY = 0.99
"""Squared correlation of the sign of the motion and the offset beyond which the motion was one way."""

FIRST = 1.0
"""Time for which there must have been moments before that, in memories of the estimator."""

FLAT_ROWS, BENT_ROWS, FITS = range(3)
"""What is done at a sample, in turn: moments of candidates without and with a presliding distance, a fit."""

PRIOR = 0.02
"""Weight ``rho`` of the estimate in use, times the mean squared error in units of the torque scale squared ..."""

LEAST_PRIOR = 1e-9
"""... and at least this; in single precision more, above what rounding makes of the moments (``export.single``)."""


@register_jitable
def candidate_velocity(estimator: EstimatorParameters, place: int) -> float:
    """Return the Stribeck velocity of a candidate, rad/s; those with a presliding distance have the assumed one."""
    if place < estimator.candidates.size:
        return estimator.candidates[place]  # type: ignore[no-any-return]
    return estimator.form.stribeck_velocity


@register_jitable
def candidate_distance(estimator: EstimatorParameters, place: int) -> float:
    """Return the presliding distance of a candidate, rad; zero of those without one."""
    distance = 0.0
    if estimator.presliding.size > 0:
        bent = place - estimator.candidates.size
        if bent >= 0:
            distance = estimator.presliding[bent]
    return distance


@register_jitable
def settle_candidates_in_place(estimator: EstimatorParameters, candidates: CandidateState, velocity: float) -> None:
    """Set the filters to those of a reference that has had a velocity (rad/s) for long."""
    if estimator.candidates.size > 0:
        direction = math.copysign(1.0, velocity) if velocity != 0.0 else 0.0
        for i in range(candidates.errors.size):
            bend = candidate_velocity(estimator, i)
            share = adhesion_share(abs(velocity), bend, estimator.form.stribeck_shape)
            filters = candidates.filters[i]
            filters[0, 0], filters[1, 0] = direction * (1.0 - share), direction * share
            if filters.shape[0] > 2:
                filters[2, 0] = abs(direction) * share
        for i in range(estimator.presliding.size):
            share = adhesion_share(abs(velocity), estimator.form.stribeck_velocity, estimator.form.stribeck_shape)
            bent = candidates.bent[i]
            bent[BENT, 0], bent[BENT, 1] = direction * (1.0 - share), direction * share


@register_jitable
def advance_candidates_one_way_in_place(
    estimator: EstimatorParameters, candidates: CandidateState, start: float, end: float, duration: float
) -> None:
    """Advance the filters over a motion of the reference that does not reverse."""
    if duration <= 0.0:
        return
    direction = math.copysign(1.0, start + end) if start + end != 0.0 else 0.0
    form = estimator.form
    pole, shape, decay = form.pole, form.stribeck_shape, filter_decay(form.pole, duration)
    for i in range(estimator.candidates.size):
        first = direction * adhesion_share(abs(start), estimator.candidates[i], shape)
        last = direction * adhesion_share(abs(end), estimator.candidates[i], shape)
        filters = candidates.filters[i]
        advance_filter_in_place(filters[0], pole, decay, direction - first, direction - last, duration)
        advance_filter_in_place(filters[1], pole, decay, first, last, duration)
        if filters.shape[0] > 2:
            advance_filter_in_place(filters[2], pole, decay, abs(first), abs(last), duration)
    if estimator.presliding.size > 0:
        count, bending = estimator.candidates.size, bending_of(form, start, end, duration)
        for i in range(estimator.presliding.size):
            filters, bent = candidates.filters[count + i], candidates.bent[i]
            slip, adhesion = bent[BENT, 0], bent[BENT, 1]
            advance_bent_in_place(bent, estimator.presliding[i], bending, pole, decay, duration)
            advance_filter_in_place(filters[0], pole, decay, slip, bent[BENT, 0], duration)
            advance_filter_in_place(filters[1], pole, decay, adhesion, bent[BENT, 1], duration)
            if filters.shape[0] > 2:
                first = abs(direction) * adhesion_share(abs(start), form.stribeck_velocity, shape)
                last = abs(direction) * adhesion_share(abs(end), form.stribeck_velocity, shape)
                advance_filter_in_place(filters[2], pole, decay, first, last, duration)


@register_jitable
def follow_candidates_in_place(
    estimator: EstimatorParameters, candidates: CandidateState, start: float, end: float, duration: float, learns: bool
) -> None:
    """Advance the filters over the motion of the reference from a velocity to another (rad/s) in a duration (s).

    ``learns`` tells whether a reversal is noted: how alike they are decides what the estimates are read as.
    """
    if estimator.candidates.size > 0 and duration > 0.0:
        if learns and start * end <= 0.0 and start != end:
            note_reversal_in_place(candidates.reversals, abs(end - start) / duration)
        if start * end < 0.0:
            turn = duration * start / (start - end)
            advance_candidates_one_way_in_place(estimator, candidates, start, 0.0, turn)
            advance_candidates_one_way_in_place(estimator, candidates, 0.0, end, duration - turn)
        else:
            advance_candidates_one_way_in_place(estimator, candidates, start, end, duration)


@register_jitable
def fit_in_place(
    estimator: EstimatorParameters, recursion: ResettingState, candidates: CandidateState, ranges: NDArray[np.float64]
) -> bool:
    """Improve the estimate of the candidate whose turn it is by one step, and note its error; tell if all is finite."""
    moments, estimate = candidates.moments[candidates.turn], candidates.estimates[candidates.turn]
    correlation, gain, factor, size = candidates.row, candidates.gain, candidates.factor, estimate.size
    complete_in_place(moments)
    squared = residual_moments_in_place(moments, estimate, correlation)
    candidates.errors[candidates.turn] = squared
    unit = estimator.torque_scale
    prior = PRIOR * squared / (unit * unit) + LEAST_PRIOR
    write_information(estimator, moments, estimate, candidates.products, factor)
    for i in range(size):
        gain[i] = correlation[i + 1]
    gain[INERTIA] += estimate[FRICTION_LAG] * correlation[0]
    gain[FRICTION_LAG] += estimate[INERTIA] * correlation[0]
    for i in range(size):
        gain[i] *= estimator.fit_scale[i] / (unit * unit)
        factor[i, i] += prior
    # short bristles stand for a lag in time: a candidate of the other kind has a lag of its own
    bends = candidate_distance(estimator, candidates.turn) > 0.0
    same = bends != slides(candidates)
    for i in range(size - 1):  # the last is not among what the estimator in use knows
        if same or i != FRICTION_LAG:
            gain[i] += prior * (recursion.estimate[i] - estimate[i]) / estimator.fit_scale[i]
        candidates.ranges[i, 0], candidates.ranges[i, 1] = ranges[i, 0], ranges[i, 1]
    candidates.ranges[size - 1, 1] = ranges[COULOMB, 1]
    factor_in_place(factor)
    solve_in_place(factor, gain)
    solved = math.isfinite(total_of(gain))  # before it is confined, which can hide what is no number
    correct_in_place(estimator.fit_scale, estimate, gain, factor, candidates.ranges, candidates.work)
    return solved and math.isfinite(total_of(estimate))


@register_jitable
def keep_offset_in_place(estimate: NDArray[np.float64], moments: NDArray[np.float64], offset: float) -> None:
    """Keep an offset (N m) where a candidate knows motion one way only; its friction takes the difference.

    The sum of both is all that such a motion shows. An offset that nothing has shown throws the joint at the first
    reversal. Stiction is then not below Coulomb friction, which the estimator would mend by such an offset at once.
    """
    # g + h is the sign of the motion
    mixed = moments[OFFSET + 1, COULOMB + 1] + moments[OFFSET + 1, STICTION + 1]
    sign = moments[COULOMB + 1, COULOMB + 1] + moments[STICTION + 1, STICTION + 1]
    sign += 2.0 * moments[STICTION + 1, COULOMB + 1]
    if mixed * mixed > ONE_WAY * moments[OFFSET + 1, OFFSET + 1] * sign:
        direction = math.copysign(1.0, mixed)
        change = max(direction * (estimate[OFFSET] - offset), -estimate[COULOMB])
        estimate[COULOMB] += change
        estimate[STICTION] = max(estimate[STICTION] + change, estimate[COULOMB])
        estimate[OFFSET] -= direction * change


@register_jitable
def take_candidate_in_place(
    estimator: EstimatorParameters, state: EstimatorState, place: int, measured: Signals, model: Signals
) -> None:
    """Let the estimator go on with a candidate's estimate, information and filters.

    The filters over the measurements have none of its own: those over the reference take their place, and what they
    differ by is forgotten within a few time constants of the filters. An offset stays where only motion one way
    is known.
    """
    candidates, recursion = state.candidates, state.recursion
    estimate, information, filters = candidates.estimates[place], recursion.information, candidates.filters[place]
    size = estimate.size - 1
    offset = recursion.estimate[OFFSET] if size > OFFSET else 0.0
    write_information(estimator, candidates.moments[place], estimate, candidates.products, candidates.factor)
    floor = PRIOR * candidates.errors[place] / (estimator.torque_scale * estimator.torque_scale) + LEAST_PRIOR
    for i in range(size):
        recursion.estimate[i] = estimate[i]
        for j in range(size):
            information[i, j] = candidates.factor[i, j]
        for j in range(size, information.shape[0]):
            information[i, j] = 0.0
            information[j, i] = 0.0
        information[i, i] += floor
    if size > OFFSET:
        keep_offset_in_place(recursion.estimate, candidates.moments[place], offset)
    # with a wrong curve joint and reference part at reversals, which looks like a short lag; a long one hurts less
    recursion.estimate[FRICTION_LAG] = max(estimate[FRICTION_LAG], estimator.first[FRICTION_LAG])
    if candidates.bent.shape[0] > 0:
        bent = place - estimator.candidates.size
        for j in range(2):
            for k in range(2):
                value = candidates.bent[bent, j, k] if bent >= 0 else 0.0
                measured.bent[j, k], model.bent[j, k] = value, value
    for k in range(2):
        measured.filters[FILTER_COULOMB, k] = filters[0, k]
        measured.filters[FILTER_ADHESION, k] = filters[1, k]
        model.filters[FILTER_COULOMB, k] = filters[0, k]
        model.filters[FILTER_ADHESION, k] = filters[1, k]
        if measured.filters.shape[0] > FILTER_SHARE:
            measured.filters[FILTER_SHARE, k] = filters[2, k]
            model.filters[FILTER_SHARE, k] = filters[2, k]


@register_jitable
def write_row_in_place(
    estimator: EstimatorParameters,
    state: EstimatorState,
    measured: Signals,
    model: Signals,
    ratio: float,
    factor: float,
) -> None:
    """Write what the rows of all candidates have in common; arguments as below."""
    row = state.candidates.row
    write_regressors(estimator.form, model, row)
    scale_inertia_in_place(row, ratio)
    row[VISCOUS + 1] *= factor
    if state.candidates.filters.shape[1] > 2:
        row[VISCOUS_ASYMMETRY + 1] *= factor
    loads = add_loads(0.0, state.recursion.estimate, state.scratch.row)
    row[row.size - 1] = measured.filters[FILTER_TORQUE, 0] - loads


@register_jitable
def begin_anew_in_place(candidates: CandidateState, estimate: NDArray[np.float64]) -> None:
    """Let all candidates begin with the estimate in use, the micro-damping as it is."""
    for i in range(candidates.errors.size):
        for j in range(candidates.estimates.shape[1] - 1):
            candidates.estimates[i, j] = estimate[j]


@register_jitable
def recover_candidates_in_place(candidates: CandidateState, estimate: NDArray[np.float64]) -> None:
    """Let all candidates begin with the estimate in use and without moments, and clear what is computed with.

    Moments are positive semi-definite by construction, but rounding, or a state from elsewhere, can spoil them. All
    begin anew, because errors can be compared only over the same time.
    """
    begin_anew_in_place(candidates, estimate)
    last, size = candidates.gain.size - 1, candidates.row.size
    for i in range(candidates.errors.size):
        candidates.estimates[i, last] = 0.0
        candidates.errors[i] = 0.0
        for j in range(size):
            for k in range(size):
                candidates.moments[i, j, k] = 0.0
    for i in range(size):
        candidates.row[i] = 0.0
    for i in range(last + 1):
        candidates.gain[i] = 0.0
        candidates.work[i] = 0.0
        for j in range(last + 1):
            candidates.factor[i, j] = 0.0
        for j in range(size):
            candidates.products[i, j] = 0.0


@register_jitable
def compare_candidates_in_place(
    estimator: EstimatorParameters,
    state: EstimatorState,
    measured: Signals,
    model: Signals,
    duration: float,
    ratio: float,
    factor: float,
) -> CandidateState:
    """Compare the candidates at a sample of sliding motion from which the estimator has just learnt.

    At one sample the moments of those without a presliding distance are taken, at the next those of the others, and
    then the one whose turn it is improves its estimate.

    Parameters
    ----------
    estimator : EstimatorParameters
        The estimator.
    state : EstimatorState
        Its state; where another candidate is chosen, its estimate and information are changed in place.
    measured, model : Signals
        Filters over the measurements, and over the reference and the torque of the model; their friction is that of
        the candidate in use, and is changed in place with it.
    duration : float
        Time since the last sample, s.
    ratio : float
        Inertia in the present configuration over that of the first estimate.
    factor : float
        Friction at the present position and load over that which is estimated.

    Returns
    -------
    CandidateState
        The new state of the candidates.
    """
    candidates, count = state.candidates, estimator.candidates.size
    waited, seen = candidates.waited + duration, candidates.seen
    if candidates.phase == FLAT_ROWS:
        if seen == 0.0:
            begin_anew_in_place(candidates, state.recursion.estimate)
        seen += waited
        share = -math.expm1(-waited / min(MEMORIES * estimator.memory, GROWTH * seen))
        write_row_in_place(estimator, state, measured, model, ratio, factor)
        note_moments_in_place(candidates, share, 0, count, factor)
        return with_turn(candidates, candidates.turn, BENT_ROWS, share, seen, 0.0)
    if candidates.phase == BENT_ROWS and estimator.presliding.size > 0:
        write_row_in_place(estimator, state, measured, model, ratio, factor)
        note_moments_in_place(candidates, candidates.share, count, candidates.errors.size, factor)
        return with_turn(candidates, candidates.turn, FITS, candidates.share, seen, waited)
    if not fit_in_place(estimator, state.recursion, candidates, state.scratch.ranges):
        recover_candidates_in_place(candidates, state.recursion.estimate)
        return forgetful(candidates)
    tried, chosen, error = candidates.turn, candidates.chosen, candidates.errors[candidates.turn]
    following = tried + 1 if tried + 1 < candidates.errors.size else 0
    candidates = with_turn(candidates, following, FLAT_ROWS, candidates.share, seen, waited)
    present, distance = candidate_distance(estimator, chosen), candidate_distance(estimator, tried)
    beside = count if present > 0.0 and distance <= 0.0 else candidates.errors.size
    if seen < FIRST * estimator.memory or error > least_error(candidates.errors, beside):
        return candidates
    # errors on the same moments: one bad sample must not count for the one and not yet for the other
    complete_in_place(candidates.moments[chosen])
    usual = residual_moments_in_place(candidates.moments[chosen], candidates.estimates[chosen], candidates.row)
    short = 0.0 if alike(candidates.reversals) else estimator.form.stribeck_velocity / estimator.form.pole
    if not error < margin_of(present, distance, short) * usual:
        return candidates
    take_candidate_in_place(estimator, state, tried, measured, model)
    return with_choice(candidates, tried, candidate_velocity(estimator, tried), distance)
