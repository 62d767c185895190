"""Whether a restored state is one that an adaptive controller can have come to."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.adaptive.at_rest.held_friction import LEAST_SHARE, HeldFriction
from adaptive_ff.adaptive.at_rest.outer_loop import ENOUGH, SETTLED, OuterLoop
from adaptive_ff.adaptive.at_rest.wound_integral import Standing
from adaptive_ff.adaptive.faults.drive_limit_state import DriveLimit
from adaptive_ff.adaptive.faults.held_integral import HeldIntegral
from adaptive_ff.adaptive.faults.seen_velocity import SeenVelocity
from adaptive_ff.adaptive.learning.candidate_state import CandidateState
from adaptive_ff.adaptive.learning.candidates import (
    FITS,
    FLAT_ROWS,
    candidate_distance,
    candidate_velocity,
)
from adaptive_ff.adaptive.learning.estimator import PEAK_FACTOR
from adaptive_ff.adaptive.learning.estimator_state import EstimatorParameters, EstimatorState, Levels, load_count
from adaptive_ff.adaptive.supervised_state import SupervisedState
from adaptive_ff.adaptive.supervision.acquittal import GUILTY, WAITS, Acquittal
from adaptive_ff.adaptive.supervision.observer_state import ObserverState
from adaptive_ff.adaptive.supervision.ringing import Ringing
from adaptive_ff.adaptive.supervision.swift_ringing import DIES_OUT
from adaptive_ff.adaptive.supervision.trust import TrustState
from adaptive_ff.friction.bounds import COULOMB, FRICTION_LAG, INERTIA, VISCOUS, VISCOUS_ASYMMETRY, write_ranges
from adaptive_ff.learning.torque_form import BENT, DAMPING
from controllers.plausible_sizes import LARGEST_VELOCITY

ROUNDING = 1e-9
"""How far an estimate may lie beyond its range, relative to it."""

SLACK = 10.0
"""How far signals of the candidates may lie beyond their plausible sizes."""

NOT_DEFINITE = 1e-6
"""Least eigenvalue of scaled moments below zero that is taken for rounding."""

LEAST_MOMENT = 1e-24
"""Mean square below which a signal is taken for zero, over its largest plausible one."""


def check_estimator_state(estimator: EstimatorParameters, state: EstimatorState, largest: float) -> None:
    """Raise ``ValueError`` where an estimator cannot have come to a state.

    Parameters
    ----------
    estimator : EstimatorParameters
        Its parameters.
    state : EstimatorState
        The state.
    largest : float
        Largest plausible torque, N m.
    """
    levels = state.levels
    check_not_negative("estimator.levels", **levels._asdict())
    if levels.torque > largest:
        raise ValueError(f"state.estimator.levels.torque = {levels.torque} is not allowed: at most {largest:g} N m")
    if levels.learnt > 0.0 and levels.speed <= 0.0:
        raise ValueError("state.estimator.levels.speed = 0 is not allowed of an estimator that has learnt")
    _check_within("recursion.estimate", state.recursion.estimate, estimator.first, possible_now(estimator, levels))


def possible_now(estimator: EstimatorParameters, levels: Levels) -> NDArray[np.float64]:
    """Return the least and the largest value that each estimate can have come to, shape (n, 2)."""
    ranges = np.array(estimator.ranges)
    if levels.learnt > 0.0 and levels.speed > 0.0:
        write_ranges(
            estimator.ranges, PEAK_FACTOR * max(levels.torque, 0.0), levels.speed, ranges, load_count(estimator)
        )
        # peaks fade, and estimates follow only where they are learnt: a factor lies between
        ranges[1:] *= np.where(np.isfinite(ranges[1:]), 10.0, 1.0)
    return ranges


def _check_within(
    name: str, estimate: NDArray[np.float64], first: NDArray[np.float64], ranges: NDArray[np.float64]
) -> None:
    slack = ROUNDING * np.abs(ranges)
    outside = (estimate < ranges[:, 0] - slack[:, 0]) | (estimate > ranges[:, 1] + slack[:, 1])
    outside &= estimate != first
    if np.any(outside):
        place = int(np.argmax(outside))
        raise ValueError(
            f"state.estimator.{name}[{place}] = {estimate[place]} is not allowed: "
            f"it must be from {ranges[place, 0]:g} to {ranges[place, 1]:g}"
        )


def check_candidate_state(
    estimator: EstimatorParameters, state: CandidateState, ranges: NDArray[np.float64], largest: float
) -> None:
    """Raise ``ValueError`` where the candidates of an estimator cannot have come to a state.

    Parameters
    ----------
    estimator : EstimatorParameters
        Its parameters.
    state : CandidateState
        The state.
    ranges : ndarray, shape (n, 2)
        Least and largest value that each estimate of the estimator can have come to.
    largest : float
        Largest plausible torque, N m.
    """
    _check_choice(estimator, state)
    errors = {f"errors[{place}]": error for place, error in enumerate(state.errors.tolist())}
    check_not_negative("estimator.candidates", seen=state.seen, waited=state.waited, **errors)
    if not 0.0 <= state.reversals[0] <= state.reversals[1]:
        raise ValueError(
            f"state.estimator.candidates.reversals = {state.reversals} is not allowed: zero or more, in ascending order"
        )
    if not FLAT_ROWS <= state.phase <= FITS:
        raise ValueError(f"state.estimator.candidates.phase = {state.phase} is not allowed: from {FLAT_ROWS} to {FITS}")
    check_share("estimator.candidates.share", state.share)
    size = state.gain.size - 1
    first = np.append(estimator.first[:size], 0.0)
    possible = np.vstack([ranges[:size], [0.0, ranges[COULOMB, 1]]])
    for i, estimate in enumerate(state.estimates):
        _check_within(f"candidates.estimates[{i}]", estimate, first, possible)
    # bends are from -1 to 1; their filters, and those of the micro-damping, hardly more than that
    units = np.array([1.0, estimator.form.pole])
    bends, damped = np.abs(state.bent[:, BENT]), np.abs(state.bent[:, DAMPING])
    if np.any(np.abs(state.filters) > SLACK * units) or np.any(bends > SLACK) or np.any(damped > SLACK * units):
        raise ValueError("state.estimator.candidates is not allowed: its filters are beyond the signals' sizes")
    _check_moments(estimator, state, largest)


def _check_moments(estimator: EstimatorParameters, state: CandidateState, largest: float) -> None:
    """Raise ``ValueError`` where moments are not those of rows of any motion; only their lower triangle is used."""
    pole = estimator.form.pole
    sizes = np.ones(state.row.size)
    sizes[INERTIA + 1 : COULOMB + 1] = pole * LARGEST_VELOCITY
    sizes[0] = pole * sizes[INERTIA + 1]
    sizes[VISCOUS + 1] = LARGEST_VELOCITY
    if sizes.size > VISCOUS_ASYMMETRY + 3:
        sizes[VISCOUS_ASYMMETRY + 1] = LARGEST_VELOCITY
    sizes[FRICTION_LAG + 1], sizes[-1] = pole * largest, largest
    least = LEAST_MOMENT * sizes * sizes
    for i, lower in enumerate(np.tril(state.moments)):
        squares = np.diag(lower)
        units = np.sqrt(np.maximum(squares, least))
        scaled = (lower + np.tril(lower, -1).T) / np.outer(units, units)
        if np.any(squares > (SLACK * sizes) ** 2) or not np.all(np.abs(scaled) <= 1.0 + NOT_DEFINITE):
            raise ValueError(f"state.estimator.candidates.moments[{i}] is not allowed: no signals have such moments")
        if np.linalg.eigvalsh(scaled)[0] < -NOT_DEFINITE:
            raise ValueError(
                f"state.estimator.candidates.moments[{i}] is not allowed: it must be positive semi-definite"
            )


def _check_choice(estimator: EstimatorParameters, state: CandidateState) -> None:
    count = estimator.candidates.size + estimator.presliding.size
    for name in ("chosen", "turn"):
        place = getattr(state, name)
        if not 0 <= place < max(count, 1):
            raise ValueError(f"state.estimator.candidates.{name} = {place} is not allowed: there are {count}")
    wanted = {"stribeck_velocity": estimator.begin, "presliding": 0.0}
    if count > 0:
        wanted["stribeck_velocity"] = candidate_velocity(estimator, state.chosen)
        wanted["presliding"] = candidate_distance(estimator, state.chosen)
    for name, value in wanted.items():
        found = getattr(state, name)
        if not math.isclose(found, value, rel_tol=ROUNDING):
            raise ValueError(
                f"state.estimator.candidates.{name} = {found} is not allowed: that of the candidate in use is {value:g}"
            )


def check_not_negative(where: str, **values: float) -> None:
    """Raise ``ValueError`` for the first value of a part of the state that is below zero."""
    for name, value in values.items():
        if value < 0.0:
            raise ValueError(f"state.{where}.{name} = {value} is not allowed: it must be zero or more")


def check_trust(trust: TrustState) -> None:
    """Raise ``ValueError`` where the trust, or what it is weighed by, cannot be."""
    check_share("trust.trust", trust.trust)
    check_share("trust.earned", trust.earned)
    check_not_negative("trust", xx=trust.xx, yy=trust.yy, span=trust.span)
    for name in ("peak", "fastest", "before"):
        speed = getattr(trust, name)
        if speed < 0.0 or speed > LARGEST_VELOCITY:
            raise ValueError(
                f"state.trust.{name} = {speed} is not allowed: it must be from 0 to {LARGEST_VELOCITY:g} rad/s"
            )


def check_observer(observer: ObserverState) -> None:
    """Raise ``ValueError`` where what the observer holds, or what is known of its effect, cannot be."""
    noise, colour, effect = observer.noise, observer.colour, observer.effect
    check_share("observer.gain", observer.gain)
    for name in ("share", "ceiling", "help"):
        check_share(f"observer.effect.{name}", getattr(effect, name))
    check_ringing("ringing", effect.ringing, 0)
    check_ringing("swift", effect.swift, -DIES_OUT)
    check_acquittal(effect.acquittal)
    for name in ("stuck", "away", "one_way", "squared", "quiet"):
        check_not_negative("observer", **{name: getattr(observer, name)})
    for name in ("measured", "mean", "variance", "usual"):
        check_not_negative("observer.noise", **{name: getattr(noise, name)})
    for name in ("squared", "variance", "samples", "time", "means", "measured"):
        check_not_negative("observer.colour", **{name: getattr(colour, name)})
    check_not_negative("observer.effect", used_expected=effect.used_expected)


def check_share(name: str, value: Any) -> None:
    """Raise ``ValueError`` where a share is not from 0 to 1."""
    if not (math.isfinite(value) and 0.0 <= value <= 1.0):
        raise ValueError(f"state.{name} = {value} is not allowed: it must be from 0 to 1")


def check_seen_velocity(seen: SeenVelocity) -> None:
    """Raise ``ValueError`` where what is remembered of measured velocities cannot be."""
    check_share("seen.share", seen.share)
    counted = ("gap", "finest", "changes", "fine", "leapt", "leaps", "multiples", "ratio", "decays")
    check_not_negative("seen", **{name: getattr(seen, name) for name in counted})


def check_plan_known(state: SupervisedState) -> None:
    """Raise ``ValueError`` where what is known of the plan, or was seen of it, is no velocity."""
    foresight, observer = state.doubt.foresight, state.observer
    velocities = {
        "doubt.foresight.coming": foresight.coming,
        "doubt.foresight.slope": foresight.slope,
        "observer.reference": observer.reference,
        "observer.velocity": observer.velocity,
        "observer.unforeseen": observer.unforeseen,
        "bridge.unforeseen": state.bridge.unforeseen,
    }
    for name, velocity in velocities.items():
        if abs(velocity) > 2.0 * LARGEST_VELOCITY:  # a change goes from one end to the other
            raise ValueError(f"state.{name} = {velocity} is not allowed: at most {2.0 * LARGEST_VELOCITY:g} rad/s")
    check_not_negative("doubt.foresight", square=foresight.square)


def check_ringing(name: str, ringing: Ringing, fewest: int) -> None:
    """Raise ``ValueError`` where half cycles of the error cannot be; ``fewest`` is how many there are in a row."""
    where = f"state.observer.effect.{name}"
    if ringing.sign not in (-1.0, 0.0, 1.0):
        raise ValueError(f"{where}.sign = {ringing.sign} is not allowed: it is -1, 0 or 1")
    for field, least in {"extreme": 0.0, "length": 0.0, "last_extreme": 0.0, "sustained": fewest}.items():
        value = getattr(ringing, field)
        if value < least:
            raise ValueError(f"{where}.{field} = {value} is not allowed: it must be {least:g} or more")


def check_acquittal(acquittal: Acquittal) -> None:
    """Raise ``ValueError`` where what the error did without the observer cannot be."""
    where = "state.observer.effect.acquittal"
    if not WAITS <= acquittal.stage <= GUILTY:
        raise ValueError(f"{where}.stage = {acquittal.stage} is not allowed: it must be from {WAITS} to {GUILTY}")
    check_not_negative("observer.effect.acquittal", **acquittal._asdict())


def check_held_integral(held: HeldIntegral, largest: float) -> None:
    """Raise ``ValueError`` where the mean of the integral, or a magnitude, is beyond a torque (N m)."""
    for name, value in held._asdict().items():
        least = -largest if name == "mean" else 0.0
        if not least <= value <= largest:
            raise ValueError(
                f"state.held.{name} = {value} is not allowed: it must be from {least:g} to {largest:g} N m"
            )


def check_outer_loop(outer: OuterLoop) -> None:
    """Raise ``ValueError`` where the step of the correction or what else is known of it is none."""
    if not (math.isfinite(outer.step) and outer.step >= 0.0):
        raise ValueError(f"state.outer.step = {outer.step} is not allowed: it must be zero or more, rad/s")
    if outer.seen not in range(ENOUGH + 1):
        raise ValueError(f"state.outer.seen = {outer.seen} is not allowed: it must be from 0 to {ENOUGH}")
    if not abs(outer.play) <= 0.5 * outer.step:
        raise ValueError(f"state.outer.play = {outer.play} is not allowed: it must be within half of the step, rad/s")
    if not 0.0 <= outer.rested <= SETTLED:
        raise ValueError(f"state.outer.rested = {outer.rested} is not allowed: it must be from 0 to {SETTLED:g} s")


def check_standing(standing: Standing, largest: float) -> None:
    """Raise ``ValueError`` where what the integral has wound up is more than the controller may command (N m)."""
    for name, torque in (("wound", standing.wound), ("left", standing.left)):
        if not abs(torque) <= largest:
            raise ValueError(f"state.standing.{name} = {torque} is not allowed: at most {largest:g} N m")


def check_held_friction(held: HeldFriction) -> None:
    """Raise ``ValueError`` where the share of the friction that is held at rest, or what shows it, is none."""
    if not LEAST_SHARE <= held.share <= 1.0:
        raise ValueError(
            f"state.held_friction.share = {held.share} is not allowed: it must be from {LEAST_SHARE:g} to 1"
        )
    if not all(math.isfinite(value) for value in held) or held.held < 0.0:
        raise ValueError("state.held_friction is not allowed: its values must be finite, and 'held' zero or more")


def check_drive_limit(drive: DriveLimit) -> None:
    """Raise ``ValueError`` where what the motion has shown of the drive is impossible."""
    signed = ("torque", "moved", "error", "velocity", "usual", "broke", "rising.resistance", "rising.covariance")
    values = drive._asdict()
    rising = values.pop("rising")
    values |= {f"rising.{name}": value for name, value in rising._asdict().items()}
    for name, value in values.items():
        if not math.isfinite(value) or (value < 0.0 and name not in signed):
            least = "" if name in signed else ", and zero or more"
            raise ValueError(f"state.drive.{name} = {value} is not allowed: it must be finite{least}")
    if drive.doubt > 2.0:
        raise ValueError(f"state.drive.doubt = {drive.doubt} is not allowed: it must be at most 2")
