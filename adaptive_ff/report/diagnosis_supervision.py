"""What the supervised controller distrusts, and why, a sentence each."""

from collections.abc import Iterator

from adaptive_ff.adaptive.controller import AdaptiveBase, AdaptiveController
from adaptive_ff.adaptive.faults.counts import shown_deviation
from adaptive_ff.adaptive.fed_shares import kicked_by_counts
from adaptive_ff.adaptive.learning.change_detection import EITHER, FRICTION, LOAD, UNDECIDED
from adaptive_ff.adaptive.learning.unexplained import breakaway
from adaptive_ff.adaptive.supervision.acquittal import ACQUITTED, GUILTY, TRIED
from adaptive_ff.adaptive.supervision.noise_level import noise_known
from adaptive_ff.adaptive.supervision.observer_effect import steadily_oscillates
from adaptive_ff.adaptive.supervision.observer_gates import helping_share
from adaptive_ff.adaptive.supervision.swift_ringing import SLOWED
from adaptive_ff.adaptive.supervision.trust import MEMORY, MISSED, caution, soft_bound, trust_by_error
from adaptive_ff.adaptive.watching import holding_friction

SHOWN = 0.995
"""Trust below which it is worth a sentence."""

OSCILLATES = (
    "as with cogging, teeth or an eccentric wheel. Where the period over the position is known, give it as "
    "ripple_periods, and the position at each step."
)
"""What makes a joint oscillate by itself, and what helps."""

CAUSES = {
    UNDECIDED: "A sudden change of the torque is not attributed yet, to friction or to a load: the joint has not moved "
    "the other way since. The estimates hold, the observer carries the difference.",
    FRICTION: "The last sudden change of the torque turned with the motion: it is taken for friction.",
    LOAD: "The last sudden change of the torque kept its sign when the joint turned: it is taken for a load.",
    EITHER: "The last sudden change of the torque could not be attributed, as the joint has not moved the other way "
    "for long: friction and offset are both learnt anew.",
}


def supervision(controller: AdaptiveBase) -> Iterator[str]:
    """Yield what the controller distrusts of its model, and what its observer does; nothing for one without them."""
    yield from _last_change(controller)
    if isinstance(controller, AdaptiveController):
        yield from _friction_withheld(controller)
        yield from _observer_withheld(controller)
        yield from _sensor(controller)


def _last_change(controller: AdaptiveBase) -> Iterator[str]:
    """Yield what the last sudden change of the torque is taken for."""
    alarm = controller.state.estimator.alarm
    if alarm.cause in CAUSES:
        yield CAUSES[alarm.cause]
    if alarm.load != 0.0:
        load = alarm.load * controller.parameters.estimator.torque_scale
        yield (
            f"The last sudden load that was told from friction changed the torque by {load:.3g} N m; the offset "
            "followed it, inertia and friction did not."
        )


def _friction_withheld(controller: AdaptiveController) -> Iterator[str]:
    """Yield why less than all of the identified friction is fed forward."""
    block, state = controller.parameters, controller.state
    time, learnt = state.feedback.samples * block.period, state.estimator.levels.learnt
    bound = caution(state.trust, block.slowest, learnt, block.estimator.memory, time)
    friction, gain = breakaway(state.estimator), block.feedback.proportional
    soft = soft_bound(state.trust, gain, friction, time)
    if soft < min(bound, SHOWN):
        yield (
            f"The loop is soft for this friction: the proportional gain needs an error of {friction / gain:.2g} rad/s "
            f"to overcome {friction:.3g} N m, and motion is up to {state.trust.peak:.2g} rad/s. What breaks the joint "
            f"away there makes it slip: at most {100.0 * soft:.0f} % of friction and observed torque are used."
        )
    elif bound < SHOWN:
        yield (
            f"Motion up to {state.trust.peak:.2g} rad/s is too slow to learn from, which takes more than "
            f"{block.slowest:.2g} rad/s: at most {100.0 * bound:.0f} % of friction and observed torque are used."
        )
    elif controller.trust < SHOWN and trust_by_error(state.trust.missed, state.trust.xx) <= controller.trust:
        yield (
            f"Only {100.0 * controller.trust:.0f} % of the identified friction is fed forward: the error of the last "
            f"{MEMORY:g} s is more than {100.0 * MISSED:g} % of the one that all of it would make, and the model does "
            "not fit. The joint hunts, or behaves as the model does not say: friction that falls steeply with speed, "
            "bristles, gravity."
        )
    elif controller.trust < SHOWN:
        yield (
            f"Only {100.0 * controller.trust:.0f} % of the identified friction is fed forward: over the last "
            f"{MEMORY:g} s all of it would have left more error than that. The joint does not behave as the model "
            "says: presliding (bristles), gravity, motion within the Stribeck regime, or a Stribeck velocity assumed "
            "wrong."
        )


def _used_with(share: float) -> str:
    """Return how much of its gain the observer is used with, as the begin of a sentence."""
    return f"The observer is used with {100.0 * share:.0f} % of its gain"


def _observer_withheld(controller: AdaptiveController) -> Iterator[str]:
    """Yield why the observer is used with less than all of its gain, but for its gates."""
    state, effect = controller.state, controller.state.observer.effect
    stage = effect.acquittal.stage
    used = _used_with(effect.share)
    if stage in (TRIED, ACQUITTED):
        yield f"Oscillation is not held against the observer: without it the joint oscillates as well, {OSCILLATES}"
    if stage == GUILTY:
        yield f"{used}: it takes nothing of an oscillation that is there without it as well, {OSCILLATES}"
    elif effect.ringing.blamed:
        yield (
            "The observer is not used until the controller is reset: the loop oscillated with it, as where the drive "
            "or a filter of the velocity lags by more than has been told, the torque rises more slowly than it is "
            "asked to, or the gear is elastic or has play. Tell delay and velocity_lag, hand over "
            "realised_torque, or take a slower observer_bandwidth."
        )
    elif effect.swift.blamed:
        yield (
            f"The observer has {SLOWED:g} of its bandwidth until the controller is reset: with it the joint "
            "swung faster than a rigid one can, as where the gear is elastic or has play. Take a slower "
            "observer_bandwidth, or a slower loop."
        )
    elif effect.ceiling < SHOWN:
        yield (
            f"{used}: the loop oscillated with it, as where the drive or a filter of the velocity lags by more than "
            "has been told. Tell delay and velocity_lag, or take a slower observer_bandwidth."
        )
    elif effect.share < SHOWN:
        yield (
            f"{used}: the error is more than the loop would make without it, as where the measured velocity lags by "
            "more than has been told (a filter behind a coarse encoder)."
        )
    helping = helping_share(state.observer, holding_friction(state))
    if helping < SHOWN and steadily_oscillates(state.observer.effect, state.observer.noise.variance):
        yield (
            f"{_used_with(helping)}: the error oscillates steadily and the observer takes little of it, as where the "
            "measured velocity ripples as the joint turns (a resolver, a tachometer, a disc that is not round), or "
            "cogging is too fast for it."
        )
    elif helping < SHOWN:
        yield (
            f"{_used_with(helping)}: it takes little of the error, and the noise of the measured velocity changes "
            "slowly, as behind a filter that makes a velocity of an encoder's counts. A finer encoder leaves more to "
            "gain."
        )


def _sensor(controller: AdaptiveController) -> Iterator[str]:
    """Yield what the sensor lets the controller make of the observed torque, and what it feeds back of that."""
    block, state = controller.parameters, controller.state
    friction, gain = breakaway(state.estimator), block.feedback.proportional
    kicked = kicked_by_counts(block, state, state.observer, state.trust.peak, state.seen)
    if kicked > 0.0:
        kick = gain * shown_deviation(state.seen, state.observer.noise)
        yield (
            f"The feedback makes {kick:.3g} N m (rms) of counts or noise of the measured velocity, and friction is "
            f"{friction:.3g} N m: such kicks shake a joint free of it. At most {100.0 * (1.0 - kicked):.0f} % of the "
            "observed torque is used, and of friction what the mean torque tells of. A filter of the velocity, a "
            "slower loop or a finer encoder leaves more to gain."
        )
    elif not noise_known(state.observer.noise):
        yield "The noise of the measurement is not known yet, so all of the observed torque is fed back."
    if noise_known(state.observer.noise) and controller.observer_gain > 0.0:
        yield (
            f"The observer feeds back {100.0 * controller.observer_gain:.0f} % of {controller.observed_torque:.3g} N m "
            "that the model does not explain and that is louder than the noise."
        )
