"""Adaptive compensation of Coulomb and viscous friction that differ by direction: Canudas, Astrom, Braun.

The joint is taken as ``J dw/dt = u - F(w)`` with ``F = Fc+ + sigma+ w`` forwards and ``F = -Fc- + sigma- w`` backwards:
no stiction, no Stribeck curve, no lag. Its discrete model over a period ``dt``, with everything else at the
value of the last sample, is linear in five parameters,

    w(k) - w(k-1) = dt/J (u(k-1) - F(w(k-1)))

which recursive least squares with forgetting finds. The increment is regressed rather than ``w(k)``, so that the
real length of a period takes part and noise hardly touches the regressors. A share of the estimated friction is
compensated: more than there is makes a limit cycle, so a deliberate rest is left to the feedback.

Of the scheme of 1987, whose text was not at hand, this keeps what later literature says of it: recursive least squares,
friction by direction, a dead zone around zero velocity, deliberate under-compensation. As chosen here:

- ``CanudasController`` feeds the friction forward along the reference, as all controllers of the comparison do;
  ``CanudasMeasuredController`` compensates it at the measured velocity, in the dead zone in proportion to the velocity.
  The linear controller is the PI loop of the comparison, with feedforward of the identified inertia.
- Equations with a velocity in the dead zone, or from one direction to the other, are left out.
- Forgetting pauses while the covariance is larger than at the start.
- Inertia is confined to the range that all controllers assume, friction to no less than zero.

Source: C. Canudas de Wit, K. J. Astrom, K. Braun, "Adaptive friction compensation in DC-motor drives" (IEEE Journal of
Robotics and Automation, 1987).
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.friction.bounds import INERTIA_RANGE, VISCOUS_SHARE
from adaptive_ff.friction.feedforward import FeedforwardState, coming_plan
from adaptive_ff.friction.identifying import IdentifyingController
from adaptive_ff.learning.rls import RLSState, initial_rls_state, trace, update_rls_in_place
from controllers import (
    ESTIMATES,
    STEPS,
    Guard,
    Inputs,
    Output,
    PIParameters,
    PIState,
    acting_torque,
    asked_torque,
    check_gains,
    check_positive,
    feed_back,
    initial_pi_state,
    plausible_inputs,
    present_inertia,
    with_feedforward,
)
from controllers.arrays import MutableArray

NAMES = ("inertia", "coulomb_positive", "coulomb_negative", "viscous_positive", "viscous_negative")
"""What is estimated: kg m^2, N m for each direction, N m s/rad for each direction."""

PARAMETERS = len(NAMES)
INERTIA, COULOMB, VISCOUS = 0, 1, 3
"""Places of the estimates; ``COULOMB`` and ``VISCOUS`` are followed by those of the negative direction."""

INITIAL_COVARIANCE = 100.0
"""Covariance of the scaled parameters at the start."""


class CanudasParameters(NamedTuple):
    """Parameters of the controller.

    Attributes
    ----------
    feedback : PIParameters
        The PI loop.
    inertia : float
        Inertia that the feedback was designed for, kg m^2.
    scale : ndarray, shape (5,)
        Unit in which the coefficients ``J0/J (1, Fc+, Fc-, sigma+, sigma-)`` are estimated.
    torque_scale : float
        Unit of torque, N m.
    dead_zone : float
        Speed below which nothing is learnt, rad/s.
    share : float
        Share of the estimated friction that is compensated.
    memory : float
        Memory, s of sliding motion.
    period : float
        Nominal period, s.
    """

    feedback: PIParameters
    inertia: float
    scale: NDArray[np.float64]
    torque_scale: float
    dead_zone: float
    share: float
    memory: float
    period: float


class CanudasMeasuredParameters(NamedTuple):
    """Parameters of the controller that compensates at the measured velocity.

    Attributes
    ----------
    adaptation : CanudasParameters
        All of them.
    """

    adaptation: CanudasParameters

    @property
    def feedback(self) -> PIParameters:
        """The PI loop."""
        return self.adaptation.feedback


class CanudasState(NamedTuple):
    """State of the controller.

    Attributes
    ----------
    feedback : PIState
        State of the PI loop.
    recursion : RLSState
        Scaled estimate of the five coefficients and its covariance; changed in place.
    physical : ndarray, shape (5,)
        Physical parameters that it stands for; changed in place.
    velocity : float
        Last measured velocity, rad/s.
    reference : float
        Last reference, rad/s.
    known_torque : float
        Torque known from elsewhere in the last period, N m.
    valid : int
        Valid measurements without interruption.
    enabled : bool
        Whether the estimates adapt.
    row : ndarray, shape (5,)
        Scratch: regressors of the last equation; changed in place.
    """

    feedback: PIState
    recursion: RLSState
    physical: MutableArray
    velocity: float
    reference: float
    known_torque: float
    valid: int
    enabled: bool
    row: MutableArray


def initial_canudas_state(block: CanudasParameters) -> CanudasState:
    """Return the state of a controller that knows nothing but the assumed inertia."""
    known = np.zeros(PARAMETERS)
    known[INERTIA] = 1.0
    return CanudasState(
        feedback=initial_pi_state(block.feedback),
        recursion=initial_rls_state(known, INITIAL_COVARIANCE * np.eye(PARAMETERS)),
        physical=known * block.inertia,
        velocity=0.0,
        reference=0.0,
        known_torque=0.0,
        valid=0,
        enabled=True,
        row=np.zeros(PARAMETERS),
    )


def initial_canudas_measured_state(block: CanudasMeasuredParameters) -> CanudasState:
    """Return the state of a controller that knows nothing but the assumed inertia."""
    return initial_canudas_state(block.adaptation)


@register_jitable
def learn_canudas_in_place(
    block: CanudasParameters, state: CanudasState, torque: float, velocity: float, duration: float
) -> None:
    """Take a period into account: the torque (N m) in it, the velocity (rad/s) at its end, its length (s)."""
    backwards = 1 if state.velocity < 0.0 else 0
    gain = block.feedback.proportional * duration / (block.inertia * block.torque_scale)
    for k in range(state.row.size):
        state.row[k] = 0.0
    state.row[INERTIA] = gain * torque
    state.row[COULOMB + backwards] = -gain * math.copysign(block.scale[COULOMB], state.velocity)
    state.row[VISCOUS + backwards] = -gain * state.velocity * block.scale[VISCOUS]
    excited = trace(state.recursion.covariance) < PARAMETERS * INITIAL_COVARIANCE
    factor = math.exp(-duration / block.memory) if excited else 1.0  # without excitation it would wind up
    output = block.feedback.proportional * (velocity - state.velocity) / block.torque_scale
    update_rls_in_place(state.recursion, state.row, output, factor)
    coefficients = state.recursion.estimate
    mobility = min(max(coefficients[INERTIA], 1.0 / INERTIA_RANGE), INERTIA_RANGE)  # J0/J
    state.physical[INERTIA] = block.inertia / mobility
    for i in range(COULOMB, PARAMETERS):
        state.physical[i] = max(coefficients[i], 0.0) * block.scale[i] / mobility


@register_jitable
def friction_along(physical: NDArray[np.float64], start: float, end: float) -> float:
    """Return the mean friction (N m) over a period in which the velocity (rad/s) goes evenly from start to end."""
    if start * end < 0.0:
        turn = start / (start - end)
        return turn * friction_along_one_way(physical, start) + (1.0 - turn) * friction_along_one_way(physical, end)
    return friction_along_one_way(physical, start + end)


@register_jitable
def friction_along_one_way(physical: NDArray[np.float64], twice: float) -> float:
    """Return the friction (N m) at half of a velocity (rad/s)."""
    if twice > 0.0:
        return physical[COULOMB] + 0.5 * twice * physical[VISCOUS]  # type: ignore[no-any-return]
    if twice < 0.0:
        return -physical[COULOMB + 1] + 0.5 * twice * physical[VISCOUS + 1]  # type: ignore[no-any-return]
    return 0.0


@register_jitable
def step_identified(block: CanudasParameters, state: CanudasState, inputs: Inputs) -> tuple[float, float, float, float]:
    """Learn from the period that ends, and look at the one in which the coming torque acts.

    Returns
    -------
    velocity : float
        Velocity, the last one where it is not measured, rad/s.
    start, end : float
        Plan at the start and at the end of the coming period, rad/s.
    torque : float
        Torque that moves the inertia along it, N m.
    """
    finite = math.isfinite(inputs.velocity)
    velocity = inputs.velocity if finite else state.feedback.velocity
    slides = min(abs(velocity), abs(state.velocity)) >= block.dead_zone and velocity * state.velocity > 0.0
    if state.enabled and finite and state.valid > 0 and slides:
        torque = acting_torque(inputs, asked_torque(block.feedback, state.feedback), state.known_torque)
        learn_canudas_in_place(block, state, torque, velocity, inputs.dt)
    past = FeedforwardState(0.0, state.reference, state.feedback.samples > 0)
    start, end = coming_plan(past, inputs, block.feedback.delay)
    return velocity, start, end, present_inertia(inputs, state.physical[INERTIA]) * (end - start) / block.period


@register_jitable
def finish_canudas(
    block: CanudasParameters, state: CanudasState, inputs: Inputs, guard: Guard, velocity: float, torque: float
) -> tuple[Output, CanudasState]:
    """Do the feedback with a torque (N m) fed forward, and keep what the next sample needs."""
    output, feedback = feed_back(block.feedback, state.feedback, with_feedforward(inputs, torque), guard)
    return output, state._replace(
        feedback=feedback,
        velocity=velocity,
        reference=inputs.reference,
        known_torque=inputs.feedforward,
        valid=state.valid + 1 if math.isfinite(inputs.velocity) else 0,
    )


@register_jitable
def step_canudas(block: CanudasParameters, state: CanudasState, inputs: Inputs) -> tuple[Output, CanudasState]:
    """Do one sample with friction fed forward along the reference."""
    inputs, guard = plausible_inputs(block.feedback, state.feedback, inputs)
    velocity, start, end, torque = step_identified(block, state, inputs)
    torque += block.share * friction_along(state.physical, start, end)
    return finish_canudas(block, state, inputs, guard, velocity, torque)


@register_jitable
def step_canudas_measured(
    block: CanudasMeasuredParameters, state: CanudasState, inputs: Inputs
) -> tuple[Output, CanudasState]:
    """Do one sample with friction compensated at the measured velocity."""
    adaptation = block.adaptation
    inputs, guard = plausible_inputs(adaptation.feedback, state.feedback, inputs)
    velocity, _, _, torque = step_identified(adaptation, state, inputs)
    edge = max(abs(velocity), adaptation.dead_zone)
    friction = friction_along_one_way(state.physical, 2.0 * math.copysign(edge, velocity))
    torque += adaptation.share * abs(velocity) / edge * friction
    return finish_canudas(adaptation, state, inputs, guard, velocity, torque)


@register_jitable
def write_canudas(block: CanudasParameters, state: CanudasState, row: NDArray[np.float64]) -> None:
    """Write the physical estimates into a row."""
    for i in range(PARAMETERS):
        row[i] = state.physical[i]


@register_jitable
def write_canudas_measured(block: CanudasMeasuredParameters, state: CanudasState, row: NDArray[np.float64]) -> None:
    """Write the physical estimates into a row."""
    write_canudas(block.adaptation, state, row)


STEPS[CanudasParameters] = step_canudas
STEPS[CanudasMeasuredParameters] = step_canudas_measured
ESTIMATES[CanudasParameters] = write_canudas
ESTIMATES[CanudasMeasuredParameters] = write_canudas_measured


def check_canudas(
    proportional: float,
    integral: float,
    period: float,
    *,
    inertia: float,
    dead_zone: float,
    share: float,
    memory: float,
    delay: float,
) -> CanudasParameters:
    """Return the parameters, or raise ``ValueError`` for the first that is out of range."""
    feedback = check_gains(proportional, integral, period, delay)
    check_positive(proportional=proportional, period=period, inertia=inertia, dead_zone=dead_zone, memory=memory)
    check_positive(forgetting_factor=math.exp(-period / memory))
    if not 0.0 <= share <= 1.0:
        raise ValueError(f"share = {share} is not allowed: it must be from 0 to 1")
    torque_scale = proportional * dead_zone
    viscous_scale = VISCOUS_SHARE * proportional
    return CanudasParameters(
        feedback=feedback,
        inertia=float(inertia),
        scale=np.array([1.0, torque_scale, torque_scale, viscous_scale, viscous_scale]),
        torque_scale=float(torque_scale),
        dead_zone=float(dead_zone),
        share=float(share),
        memory=float(memory),
        period=float(period),
    )


class CanudasController(IdentifyingController):
    """``u = PI(e) + J dr/dt + share (Fc+- sgn(r) + sigma+- r)``, identified by recursive least squares.

    ``e = reference + correction - velocity``; friction by direction is fed forward along the plan ``r``.

    Dead zone and share were searched on twelve joints drawn around the built-in one (those of ``adaptive-ff sweep``,
    seed 101) at 100 Hz and 1 kHz. A dead zone of 0.3 Stribeck velocities, which the line-up sets, was best. All of the
    estimated friction would do 1 to 2 % better than the share of 0.85: along the reference, the source's deliberate
    rest costs hardly anything. Memory makes less difference than that between 5 and 60 s.

    Parameters
    ----------
    proportional, integral : float
        Gains of the PI loop, N m s/rad and N m/rad.
    period : float
        Nominal sampling period, s.
    inertia : float
        Inertia that the feedback was designed for, kg m^2; the first estimate.
    dead_zone : float
        Speed below which nothing is learnt, rad/s.
    share : float, optional
        Share of the estimated friction that is compensated.
    memory : float, optional
        Memory, s of motion outside the dead zone.
    delay : float, optional
        Computation delay of the drive, sampling periods: it applies the torque of a sample from that much later on.

    Raises
    ------
    ValueError
        A value is out of range.
    """

    estimate_names = NAMES

    def __init__(
        self,
        proportional: float,
        integral: float,
        period: float,
        *,
        inertia: float,
        dead_zone: float,
        share: float = 0.85,
        memory: float = 5.0,
        delay: float = 0.0,
    ) -> None:
        assumed = {"inertia": inertia, "dead_zone": dead_zone, "share": share, "memory": memory, "delay": delay}
        parameters = check_canudas(proportional, integral, period, **assumed)
        super().__init__(parameters, period, initial_canudas_state)


class CanudasMeasuredController(IdentifyingController):
    """``u = PI(e) + J dr/dt + share (Fc+- sgn(w) + sigma+- w)``, compensated at the measured velocity ``w``.

    Parameters are those of ``CanudasController``. In ``python -m benchmarks.tuning`` and on joints drawn at random
    (``adaptive-ff sweep``, seed 101) a dead zone of 0.1 Stribeck velocities, which the line-up sets, with a share of
    0.7 did best; it is worse than ``pi`` on 3 of 14 of these joints at 100 Hz and on 2 at 1 kHz all the same.
    """

    estimate_names = NAMES

    def __init__(
        self,
        proportional: float,
        integral: float,
        period: float,
        *,
        inertia: float,
        dead_zone: float,
        share: float = 0.7,
        memory: float = 5.0,
        delay: float = 0.0,
    ) -> None:
        assumed = {"inertia": inertia, "dead_zone": dead_zone, "share": share, "memory": memory, "delay": delay}
        parameters = check_canudas(proportional, integral, period, **assumed)
        super().__init__(CanudasMeasuredParameters(parameters), period, initial_canudas_measured_state)
