"""Diagnosis of an adaptive controller as data: what is known, how surely, what is not and why, what is suspected.

It reads the state and changes nothing. ``report.diagnosis`` puts it into words.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from adaptive_ff.adaptive.estimates import deviations
from adaptive_ff.adaptive.extensions.over_position import LearntMap
from adaptive_ff.friction.columns import INERTIA
from adaptive_ff.friction.identifying import IdentifyingController
from adaptive_ff.friction.model import GRAVITY, RIPPLE, unit_of
from adaptive_ff.learning.kalman import LOOP, Estimate
from adaptive_ff.reported import Reported
from controllers.arrays import packed, unpacked

SURE = 2.0
"""Standard deviations of a difference that is taken for one."""

LEARNT = 0.5
"""Standard deviation over that of the prior below which an estimate is learnt."""

ALIKE = 0.5
"""Correlation of successive innovations beyond which they are not white."""

FAR = 2.0
"""Factor between identified and assumed inertia that the contract allows; beyond it the gains should be looked at."""


class Code(StrEnum):
    """What a diagnosis finds."""

    HELD = "held"
    NO_MOTION = "no_motion"
    NOT_LEARNT = "not_learnt"
    NO_POSITION = "no_position"
    TORQUE_UNKNOWN = "torque_unknown"
    PLAN_UNKNOWN = "plan_unknown"
    NO_INTEGRAL = "no_integral"
    MEASUREMENTS_LOST = "measurements_lost"
    INPUTS_IMPLAUSIBLE = "inputs_implausible"
    INNOVATIONS_COLOURED = "innovations_coloured"
    JUST_CHANGED = "just_changed"
    OBSERVER_HELPS = "observer_helps"
    AT_BOUND = "at_bound"
    INERTIA_FAR = "inertia_far"
    FRICTION_RISES = "friction_rises"


WARNINGS = frozenset(
    {
        Code.TORQUE_UNKNOWN,
        Code.PLAN_UNKNOWN,
        Code.NO_INTEGRAL,
        Code.MEASUREMENTS_LOST,
        Code.INPUTS_IMPLAUSIBLE,
        Code.INNOVATIONS_COLOURED,
        Code.AT_BOUND,
        Code.INERTIA_FAR,
    }
)
"""What an engineer should look at."""


@dataclass(frozen=True)
class Finding:
    """One thing that is found.

    Attributes
    ----------
    code : Code
        What.
    names : tuple of str
        Estimates that it concerns.
    values : mapping of str to float
        Numbers, by name, in SI units.
    """

    code: Code
    names: tuple[str, ...] = ()
    values: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class ParameterDiagnosis:
    """What is known of one estimate.

    Attributes
    ----------
    name, unit : str
        Name and unit.
    estimate : float
        The estimate that is fed forward.
    uncertainty : float
        Its standard deviation, as the filter believes.
    learnt : float
        That over the one before anything was measured, at the present unit of friction: 1 where nothing was learnt.
    """

    name: str
    unit: str
    estimate: float
    uncertainty: float
    learnt: float


@dataclass(frozen=True)
class Diagnosis(Reported):
    """What an adaptive controller knows and suspects.

    Attributes
    ----------
    parameters : tuple of ParameterDiagnosis
        The estimates.
    findings : tuple of Finding
        What is found, warnings among it.
    moved : float
        Time with a reference that is not zero so far, s.
    change_probability : float
        Probability that the joint has changed lately.
    correlation : float
        Correlation of successive innovations; white ones have none.
    observer_gain, observed_torque : float
        What the observer does: gain, and torque, N m.
    friction_map : LearntMap or None
        Friction over position and load, where that is learnt.
    """

    parameters: tuple[ParameterDiagnosis, ...]
    findings: tuple[Finding, ...]
    moved: float
    change_probability: float
    correlation: float
    observer_gain: float
    observed_torque: float
    friction_map: LearntMap | None

    @property
    def codes(self) -> frozenset[Code]:
        """Codes of the findings."""
        return frozenset(finding.code for finding in self.findings)

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """Findings that an engineer should look at."""
        return tuple(finding for finding in self.findings if finding.code in WARNINGS)

    def __str__(self) -> str:
        return str(self._report("diagnosis_text"))


def diagnose(controller: IdentifyingController, friction_map: LearntMap | None) -> Diagnosis:
    """Return what an adaptive controller knows and suspects; it is left as it is."""
    state = controller.state
    watch = state.watch
    correlation = watch.product / watch.square if watch.square > 0.0 else 0.0
    parameters = tuple(_parameters(controller))
    return Diagnosis(
        parameters=parameters,
        findings=tuple(_findings(controller, parameters, correlation)),
        moved=float(watch.moved),
        change_probability=float(state.weight),
        correlation=float(correlation),
        observer_gain=float(state.observer.gain),
        observed_torque=float(state.observer.torque),
        friction_map=friction_map,
    )


def _parameters(controller: IdentifyingController) -> Iterator[ParameterDiagnosis]:
    parameters, state = controller.parameters, controller.state
    units = np.concatenate([np.zeros(LOOP), np.where(parameters.prior.scaled, state.unit, 1.0)])
    first = np.zeros((units.size, units.size))
    first[LOOP:, LOOP:] = unpacked(parameters.prior.covariance) * np.outer(units[LOOP:], units[LOOP:])
    first[1, 1] = (parameters.tuning.load * state.unit) ** 2
    known = state._replace(estimate=Estimate(state.estimate.mean, packed(first)))
    before = deviations(parameters, known, len(controller.estimate_names))
    now = deviations(parameters, state, len(controller.estimate_names))
    for (name, estimate), spread, prior in zip(
        controller.estimates.items(), now.tolist(), before.tolist(), strict=True
    ):
        learnt = min(spread / prior, 1.0) if prior > 0.0 else 1.0
        yield ParameterDiagnosis(name, unit_of(name), estimate, spread, learnt)


def _findings(
    controller: IdentifyingController, parameters: tuple[ParameterDiagnosis, ...], correlation: float
) -> Iterator[Finding]:
    state, watch = controller.state, controller.state.watch
    running = state.feedback.samples * controller.parameters.period
    judged = controller.parameters.tuning.switching  # 1/s
    if not controller.enabled:
        yield Finding(Code.HELD)
    if watch.moved == 0.0 and running * judged > 1.0:
        yield Finding(Code.NO_MOTION, values={"time": running})
    yield from _given(controller, running)
    if watch.moved * judged > 1.0 and abs(correlation) > ALIKE:
        yield Finding(Code.INNOVATIONS_COLOURED, values={"correlation": correlation})
    if state.weight > LEARNT and watch.moved * judged > 1.0:
        yield Finding(Code.JUST_CHANGED, values={"probability": state.weight})
    if state.observer.gain > 0.0:
        gain, torque = state.observer.gain, state.observer.torque
        yield Finding(Code.OBSERVER_HELPS, values={"gain": gain, "torque": torque})
    if watch.moved == 0.0:
        return
    yield from _learnt(controller, parameters)
    yield from _suspect(controller, {one.name: one for one in parameters})


def _given(controller: IdentifyingController, running: float) -> Iterator[Finding]:
    """Yield what the controller is not given, or not as it should be."""
    watch = controller.state.watch
    if running > 0.0 and not watch.torque_known and not controller.parameters.machine.torque_known:
        yield Finding(Code.TORQUE_UNKNOWN)
    if running > 0.0 and not watch.plan_known:
        yield Finding(Code.PLAN_UNKNOWN)
    if controller.parameters.feedback.integral == 0.0:
        yield Finding(Code.NO_INTEGRAL)
    if controller.rejected:
        lost = {"lost": float(controller.rejected), "samples": float(controller.state.feedback.samples)}
        yield Finding(Code.MEASUREMENTS_LOST, values=lost)
    if controller.faults:
        yield Finding(Code.INPUTS_IMPLAUSIBLE, values={"samples": float(controller.faults)})


def _learnt(controller: IdentifyingController, parameters: tuple[ParameterDiagnosis, ...]) -> Iterator[Finding]:
    """Yield which estimates are not learnt."""
    over_position = [one.name for one in parameters if one.name.startswith((*GRAVITY, *RIPPLE))]
    silent = [one.name for one in parameters if one.learnt > LEARNT]
    if over_position and set(over_position) <= set(silent):
        yield Finding(Code.NO_POSITION, tuple(over_position))
        silent = [name for name in silent if name not in over_position]
    fixed = {"stribeck_velocity"} if controller.parameters.tuning.velocity_deviation == 0.0 else set()
    silent = [name for name in silent if name not in fixed]
    if silent:
        yield Finding(Code.NOT_LEARNT, tuple(silent))


def _suspect(controller: IdentifyingController, known: Mapping[str, ParameterDiagnosis]) -> Iterator[Finding]:
    """Yield what of the estimates is unlikely for a joint as it was described."""
    prior, assumed = controller.parameters.prior, controller.parameters.machine.inertia
    inertia = known["inertia"]
    ratio = inertia.estimate / assumed
    if not 1.0 / FAR < ratio < FAR and abs(inertia.estimate - assumed) > SURE * inertia.uncertainty:
        yield Finding(Code.INERTIA_FAR, ("inertia",), {"ratio": ratio, "assumed": assumed})
    coefficients = controller.state.estimate.mean[LOOP:]
    places = {"inertia": INERTIA, "friction_lag": -2, "stribeck_velocity": -1}
    for name, place in places.items():
        if coefficients[place] <= prior.lowest[place] or coefficients[place] >= prior.highest[place]:
            yield Finding(Code.AT_BOUND, (name,), {"value": known[name].estimate})
    coulomb, stiction = known["coulomb"], known["stiction"]
    uncertainty = math.hypot(coulomb.uncertainty, stiction.uncertainty)
    if coulomb.estimate - stiction.estimate > SURE * uncertainty:
        yield Finding(Code.FRICTION_RISES, ("coulomb", "stiction"), {"from": stiction.estimate, "to": coulomb.estimate})
