"""Adaptive compensation of Coulomb and viscous friction that differ by direction: Canudas, Astrom, Braun.

The joint is taken as ``J dw/dt = u - F(w)`` with ``F = Fc+ + sigma+ w`` forwards and ``F = -Fc- + sigma- w`` backwards:
no stiction, no Stribeck curve, no lag. Its discrete model over a period ``dt``, with everything else at the
value of the last sample, is linear in five parameters,

    w(k) - w(k-1) = dt/J (u(k-1) - F(w(k-1)))

which recursive least squares with forgetting finds. The increment is regressed rather than ``w(k)``, so that the
real length of a period takes part and noise hardly touches the regressors. A fraction of the estimated friction is
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
from typing import Any, NamedTuple

import numpy as np

from adaptive_ff.baselines.bounds import INERTIA_RANGE, VISCOUS_UNIT
from adaptive_ff.friction.feedforward import FeedforwardState, coming_plan
from adaptive_ff.friction.identifying import IdentifyingController
from adaptive_ff.learning.rls import RLSState, initial_rls_state, trace, update_rls_in_place
from controllers.arrays import MutableArray, NDArray
from controllers.checks import check_positive
from controllers.declaration import argument, begin, controller, derived, fraction, positive
from controllers.loops import DesignedLoop
from controllers.pi import PIState, asked_torque, feed_back, plausible_inputs
from controllers.plausibility import Guard
from controllers.registry import Inputs, Output, present_inertia, with_feedforward
from controllers.torques import acting_torque

NAMES = ("inertia", "coulomb_positive", "coulomb_negative", "viscous_positive", "viscous_negative")
"""What is estimated: kg m^2, N m for each direction, N m s/rad for each direction."""

PARAMETERS = len(NAMES)
INERTIA, COULOMB, VISCOUS = 0, 1, 3
"""Places of the estimates; ``COULOMB`` and ``VISCOUS`` are followed by those of the negative direction."""

INITIAL_COVARIANCE = 100.0
"""Covariance of the scaled parameters at the start."""


class CanudasState(NamedTuple):
    """State of the controller; its arrays are changed in place."""

    feedback: PIState
    # scaled estimate of the five coefficients ``J0/J (1, Fc+, Fc-, sigma+, sigma-)`` and its covariance
    recursion: RLSState = begin(
        lambda _: initial_rls_state(np.eye(PARAMETERS)[INERTIA], INITIAL_COVARIANCE * np.eye(PARAMETERS))
    )
    # physical parameters that it stands for
    physical: MutableArray = begin(lambda parameters: parameters.inertia * np.eye(PARAMETERS)[INERTIA])
    velocity: float = 0.0  # last measured velocity, rad/s
    reference: float = 0.0  # last reference, rad/s
    known_torque: float = 0.0  # torque known from elsewhere in the last period, N m
    valid: int = 0  # valid measurements without interruption
    enabled: bool = True  # whether the estimates adapt
    row: MutableArray = begin(lambda _: np.zeros(PARAMETERS))  # regressors of the last equation


def learn_canudas_in_place(
    parameters: "CanudasLoop", state: CanudasState, torque: float, velocity: float, duration: float
) -> None:
    """Take a period into account: the torque (N m) in it, the velocity (rad/s) at its end, its length (s)."""
    backwards = 1 if state.velocity < 0.0 else 0
    gain = parameters.feedback.proportional * duration / (parameters.inertia * parameters.torque_scale)
    for k in range(state.row.size):
        state.row[k] = 0.0
    state.row[INERTIA] = gain * torque
    state.row[COULOMB + backwards] = -gain * math.copysign(parameters.scale[COULOMB], state.velocity)
    state.row[VISCOUS + backwards] = -gain * state.velocity * parameters.scale[VISCOUS]
    excited = trace(state.recursion.covariance) < PARAMETERS * INITIAL_COVARIANCE
    factor = math.exp(-duration / parameters.memory) if excited else 1.0  # without excitation it would wind up
    output = parameters.feedback.proportional * (velocity - state.velocity) / parameters.torque_scale
    update_rls_in_place(state.recursion, state.row, output, factor)
    coefficients = state.recursion.estimate
    mobility = min(max(coefficients[INERTIA], 1.0 / INERTIA_RANGE), INERTIA_RANGE)  # J0/J
    state.physical[INERTIA] = parameters.inertia / mobility
    for i in range(COULOMB, PARAMETERS):
        state.physical[i] = max(coefficients[i], 0.0) * parameters.scale[i] / mobility


def friction_along(physical: NDArray[np.float64], start: float, end: float) -> float:
    """Return the mean friction (N m) over a period in which the velocity (rad/s) goes evenly from start to end."""
    if start * end < 0.0:
        turn = start / (start - end)
        return turn * friction_along_one_way(physical, start) + (1.0 - turn) * friction_along_one_way(physical, end)
    return friction_along_one_way(physical, start + end)


def friction_along_one_way(physical: NDArray[np.float64], twice: float) -> float:
    """Return the friction (N m) at half of a velocity (rad/s)."""
    if twice > 0.0:
        return physical[COULOMB] + 0.5 * twice * physical[VISCOUS]  # type: ignore[no-any-return]
    if twice < 0.0:
        return -physical[COULOMB + 1] + 0.5 * twice * physical[VISCOUS + 1]  # type: ignore[no-any-return]
    return 0.0


def step_identified(
    parameters: "CanudasLoop", state: CanudasState, inputs: Inputs
) -> tuple[float, float, float, float]:
    """Learn from the period that ends, and look at the one in which the coming torque acts.

    Returned are the velocity, the last one where it is not measured, the plan at the start and at the end of the coming
    period, all in rad/s, and the torque that moves the inertia along it, N m.
    """
    finite = math.isfinite(inputs.velocity)
    velocity = inputs.velocity if finite else state.feedback.velocity
    slides = min(abs(velocity), abs(state.velocity)) >= parameters.dead_zone and velocity * state.velocity > 0.0
    if state.enabled and finite and state.valid > 0 and slides:
        torque = acting_torque(inputs, asked_torque(parameters.feedback, state.feedback), state.known_torque)
        learn_canudas_in_place(parameters, state, torque, velocity, inputs.dt)
    past = FeedforwardState(0.0, state.reference, state.feedback.samples > 0)
    start, end = coming_plan(past, inputs, parameters.feedback.delay)
    return velocity, start, end, present_inertia(inputs, state.physical[INERTIA]) * (end - start) / parameters.period


def finish_canudas(
    parameters: "CanudasLoop", state: CanudasState, inputs: Inputs, guard: Guard, velocity: float, torque: float
) -> tuple[Output, CanudasState]:
    """Do the feedback with a torque (N m) fed forward, and keep what the next sample needs."""
    output, feedback = feed_back(parameters.feedback, state.feedback, with_feedforward(inputs, torque), guard)
    return output, state._replace(
        feedback=feedback,
        velocity=velocity,
        reference=inputs.reference,
        known_torque=inputs.feedforward,
        valid=state.valid + 1 if math.isfinite(inputs.velocity) else 0,
    )


def step_canudas(parameters: "CanudasLoop", state: CanudasState, inputs: Inputs) -> tuple[Output, CanudasState]:
    """Do one sample with friction fed forward along the reference."""
    inputs, guard = plausible_inputs(parameters.feedback, state.feedback, inputs)
    velocity, start, end, torque = step_identified(parameters, state, inputs)
    torque += parameters.compensated * friction_along(state.physical, start, end)
    return finish_canudas(parameters, state, inputs, guard, velocity, torque)


def step_canudas_measured(
    parameters: "CanudasLoop", state: CanudasState, inputs: Inputs
) -> tuple[Output, CanudasState]:
    """Do one sample with friction compensated at the measured velocity."""
    inputs, guard = plausible_inputs(parameters.feedback, state.feedback, inputs)
    velocity, _, _, torque = step_identified(parameters, state, inputs)
    edge = max(abs(velocity), parameters.dead_zone)
    friction = friction_along_one_way(state.physical, 2.0 * math.copysign(edge, velocity))
    torque += parameters.compensated * abs(velocity) / edge * friction
    return finish_canudas(parameters, state, inputs, guard, velocity, torque)


def write_canudas(parameters: "CanudasLoop", state: CanudasState, row: MutableArray) -> None:
    """Write the physical estimates into a row."""
    for i in range(PARAMETERS):
        row[i] = state.physical[i]


COMPENSATED = "Fraction of the estimated friction that is compensated."


@controller()
class CanudasLoop(DesignedLoop, IdentifyingController):
    """What the two controllers have in common."""

    estimate_names = NAMES

    dead_zone: float = argument(positive, "Speed below which nothing is learnt, rad/s.")
    compensated: float = argument(fraction, COMPENSATED, default=0.85)
    memory: float = argument(positive, "Memory, s of motion outside the dead zone.", default=5.0)
    scale: NDArray[np.float64] = derived("Unit in which each coefficient is estimated.")
    torque_scale: float = derived("Unit of torque, N m.")

    def derive(self) -> dict[str, Any]:
        """Return the units of the estimates."""
        check_positive(forgetting_factor=math.exp(-self.period / self.memory))
        torque, viscous = self.proportional * self.dead_zone, VISCOUS_UNIT * self.proportional
        return {"scale": np.array([1.0, torque, torque, viscous, viscous]), "torque_scale": torque}


@controller(step_canudas, CanudasState, estimates=write_canudas)
class CanudasController(CanudasLoop):
    """``u = PI(e) + J dr/dt + c (Fc+- sgn(r) + sigma+- r)``, identified by recursive least squares.

    Friction by direction is fed forward along the reference ``r``, and of it the fraction ``c`` compensated.
    """


@controller(step_canudas_measured, CanudasState, estimates=write_canudas)
class CanudasMeasuredController(CanudasLoop):
    """``u = PI(e) + J dr/dt + c (Fc+- sgn(w) + sigma+- w)``, compensated at the measured velocity ``w``."""

    compensated: float = argument(fraction, COMPENSATED, default=0.7)
