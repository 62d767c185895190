"""What an engineer should look at in an adaptive controller, a sentence each."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.adaptive.controller import AdaptiveBase
from adaptive_ff.adaptive.learning.estimator import PEAK_FACTOR
from adaptive_ff.adaptive.learning.uncertainty import Confidence
from adaptive_ff.estimation.instruments import AGREEMENT
from adaptive_ff.friction.bounds import COULOMB, FRICTION_LAG, INERTIA, STICTION, write_ranges
from adaptive_ff.friction.model import unit_of

NOT_IDENTIFIABLE = 0.5
"""Standard deviation of a parameter, as a share of its scale, from which on the data do not identify it."""

SURE = 3.0
"""Uncertainties by which something must be wrong for a warning."""

FAR_INERTIA = 1.5
"""Factor between identified and assumed inertia beyond which the gains should be looked at."""

POOR_FIT = 0.15
"""Torque that the model leaves unexplained, as a share of the largest, that calls for a warning."""

WOUND_UP = 10.0
"""Largest torque over proportional gain and largest speed from which on a drive seems to have saturated untold."""

SATURATED = 4.0
"""Largest torque that was not believed, over what has moved the joint beside its inertia, from which on it did."""

HELD = 0.01
"""Share of velocities that are repeated to the bit that calls for a warning."""

LONG_WITHOUT = 10.0
"""Time without a sample to learn from that calls for a warning, s."""


def find_warnings(controller: AdaptiveBase, confidence: Confidence, unexplained: float) -> Iterator[str]:
    """Yield what should be looked at.

    Parameters
    ----------
    controller : AdaptiveBase
        The controller; it is left as it is.
    confidence : Confidence
        How well the recent data determine its parameters.
    unexplained : float
        Root of the mean square of the torque that the model did not predict, N m.
    """
    block, state = controller.parameters, controller.state
    levels = state.estimator.levels
    if controller.rejected:
        yield f"{controller.rejected} measurements of {state.feedback.samples} were not finite and skipped."
    yield from _faults(controller)
    if levels.learnt == 0.0:
        running = state.feedback.samples * block.period
        if running > LONG_WITHOUT:
            yield (
                f"in {running:.3g} s there was nothing to learn from: the joint never slid faster than "
                f"{block.slowest:.2g} rad/s along its reference for {block.hold:.2g} s."
            )
        return
    yield from _bounds(controller)
    yield from _implausible(controller, confidence)
    if confidence.together[FRICTION_LAG] >= NOT_IDENTIFIABLE:
        yield (
            "the recent motion hardly shows the friction lag (only reversals do, and noise hides it): its estimate is "
            "a guess, or an old one."
        )
    if unexplained > POOR_FIT * levels.torque:
        yield (
            f"the model leaves {unexplained:.2g} N m (rms) unexplained, the largest torque was {levels.torque:.3g} N m"
            ": the joint has changed lately, the measurement is loud, or the model does not suit the joint."
        )
    yield from _untold_limit(controller)
    alike = _resembles(state.estimator.agreement)
    identified = confidence.together < NOT_IDENTIFIABLE
    names = controller.estimate_names[: alike.size]
    strangers = [name for i, name in enumerate(names) if not alike[i] and identified[i]]
    if strangers:
        yield (
            f"measured and modelled motion differ in what shows {', '.join(strangers)} (poor tracking, saturation, or "
            "a model that is still wrong): noise of the measurement may bias the estimates."
        )


def _faults(controller: AdaptiveBase) -> Iterator[str]:
    """Yield a sentence for each fault that the sensor seems to have."""
    seen = getattr(controller.state, "seen", None)
    if seen is None:
        return
    if seen.leaps > 0:
        yield (
            f"{seen.leaps} measured velocities leapt further than any torque so far takes the joint; the feedback "
            "followed them, nothing was learnt or observed from them: look at the sensor."
        )
    if seen.share > HELD:
        yield (
            f"{100.0 * seen.share:.0f} % of the measured velocities of late were the last ones once more: the sensor "
            "is slower than the loop, or loses messages. A measurement that is lost is best given as not a number."
        )


def _bounds(controller: AdaptiveBase) -> Iterator[str]:
    """Yield a sentence for each parameter at an end of its assumed range."""
    estimator, state = controller.parameters.estimator, controller.state.estimator
    ranges = np.empty_like(estimator.ranges)
    write_ranges(estimator.ranges, PEAK_FACTOR * state.levels.torque, max(state.levels.speed, 1e-300), ranges)
    names = controller.estimate_names[: len(ranges)]
    for name, value, (least, most) in zip(names, state.recursion.estimate, ranges, strict=True):
        end = "least" if value <= least else "largest" if value >= most else ""
        if end:
            yield f"{name} is at the {end} value that is assumed possible, {value:.3g} {unit_of(name)}."


def _untold_limit(controller: AdaptiveBase) -> Iterator[str]:
    """Yield a sentence where a drive that tells nothing of its torque seems to have saturated."""
    block, levels = controller.parameters, controller.state.estimator.levels
    drive = getattr(controller.state, "drive", None)
    if drive is not None:
        if drive.suspect or drive.largest > SATURATED * max(drive.proven, drive.usual):
            moved = (
                "and never followed its plan" if drive.suspect else f"beside its inertia {drive.proven:.3g} N m move it"
            )
            yield (
                f"the drive was asked for up to {drive.largest:.3g} N m, and the joint did not answer ({moved}): it "
                "seems to saturate. Nothing is learnt from such torque; tracking improves where torque_limit is given, "
                "or realised_torque at each step."
            )
        return
    usual = block.feedback.proportional * max(levels.speed, 1e-300)
    if block.command.torque_limit == math.inf and levels.torque > WOUND_UP * usual:
        yield (
            f"the torque was up to {levels.torque:.3g} N m, {levels.torque / usual:.3g} times what the proportional "
            "gain makes of the fastest motion, and no torque_limit is given: if the drive saturates, give it, or "
            "realised_torque at each step; else the estimates are of torque that never acted."
        )


def _implausible(controller: AdaptiveBase, confidence: Confidence) -> Iterator[str]:
    estimate, errors = controller.state.estimator.recursion.estimate, confidence.errors
    doubt = math.hypot(errors[COULOMB], errors[STICTION])
    if estimate[COULOMB] - estimate[STICTION] > SURE * doubt:
        yield (
            f"friction rises from {estimate[STICTION]:.3g} N m at standstill to {estimate[COULOMB]:.3g} N m: the joint "
            "has no Stribeck peak; it creeps, or its friction saturates."
        )
    assumed = float(controller.parameters.estimator.first[INERTIA])
    ratio = float(estimate[INERTIA]) / assumed
    if confidence.together[INERTIA] < NOT_IDENTIFIABLE and not 1.0 / FAR_INERTIA < ratio < FAR_INERTIA:
        yield (
            f"the inertia is {ratio:.2g} times the {assumed:.3g} kg m² that the feedback was designed for: so is its "
            f"bandwidth, divided by {ratio:.2g}."
        )


def _resembles(agreement: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return for which parameters the model's gradient resembles the measured one, on the average."""
    squares, products = agreement[:, 0], agreement[:, 1]
    alike: NDArray[np.bool_] = (products >= AGREEMENT[0] * squares) & (products <= AGREEMENT[1] * squares)
    return alike
