"""PI loop with a LuGre feedforward whose parameters a gradient method tunes while it works.

After the idea of F. Altpeter, M. Grunenberg, P. Myszkowski, R. Longchamp, "Auto-tuning of feedforward friction
compensation based on the gradient method" (2000); its text could not be compared, and no number of it is claimed. The
friction of a LuGre model along the reference ``r`` is fed forward; its parameters ``p`` descend along the gradient
of the squared tracking error:

    dy/dt = sigma0 (r - |r| y/g(r)),   g(r) = Fc + (Fs - Fc) exp(-|r/Vs|^delta),   f = y + sigma2 r + offset
    dp/dt = -rate e de/dp,             de/dp = -G df/dp,                            G = s / (J s^2 + Kp s + Ki)

``y`` is the torque of the bristles; ``G`` is what the loop makes of a torque. The sensitivities ``dy/dp`` are the exact
derivatives of the discrete law, all along the reference: noise of the measurement is in ``e`` alone.

As chosen here:

- *Parameters*: inertia, ``sigma2``, offset, ``Fc``, ``Fs`` and ``sigma0``; ``Vs`` and ``delta`` are assumed. There is
  no damping ``sigma1`` of the bristles. What is known at the start is the inertia; ``sigma0`` begins with a given one.
- *Gradient* normalised: with a unit ``s_i`` of each parameter, ``dp_i = f s_i^2 v_i e/(floor^2 + sum (s v)^2)`` and
  ``v = G df/dp``; the floor keeps a joint at rest from learning noise.
- ``G`` is that of the assumed inertia and the loop without delay, sampled as the loop is.
- Learning pauses where the measurement failed or the drive did not give the commanded torque.
- Inertia and ``sigma0`` stay within a range, ``Fc`` above zero, ``Fs`` at ``Fc`` or above, ``sigma2`` not negative.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from adaptive_ff.baselines.bounds import INERTIA_RANGE, VISCOUS_UNIT
from adaptive_ff.baselines.feedback_learning import was_refused
from adaptive_ff.friction.feedforward import FeedforwardState, coming_plan
from adaptive_ff.friction.identifying import IdentifyingController
from adaptive_ff.friction.model import stiction_fraction
from controllers.arrays import MutableArray, NDArray
from controllers.declaration import argument, begin, controller, derived, positive
from controllers.loops import DesignedLoop
from controllers.pi import PIState, feed_back, plausible_inputs
from controllers.registry import Inputs, Output, present_inertia, with_feedforward

NAMES = ("inertia", "viscous", "offset", "coulomb", "stiction", "stiffness")
"""What is tuned: kg m^2, N m s/rad, N m, N m, N m, N m/rad."""

PARAMETERS = len(NAMES)
INERTIA, VISCOUS, OFFSET, COULOMB, STICTION, STIFFNESS = range(PARAMETERS)
"""Places of the parameters; those from ``COULOMB`` on act through the bristles."""

STIFFNESS_RANGE = 100.0
"""``sigma0`` is assumed to lie within this factor of the one that it begins with."""

LEAST_FRACTION = 1e-3
"""Least Coulomb friction, as a fraction of the unit of torque: the bristles need some level to slip at."""


def _first_parameters(own: "LuGreGradient") -> MutableArray:
    """Return what a controller knows that knows nothing but the assumed inertia."""
    least = LEAST_FRACTION * own.torque_scale
    return np.array([own.inertia, 0.0, 0.0, least, least, own.stiffness])


def _zeros(own: "LuGreGradient") -> MutableArray:
    return np.zeros(PARAMETERS)


class LuGreGradientState(NamedTuple):
    """State of the controller; its arrays, one number for each parameter, are changed in place."""

    feedback: PIState
    parameters: MutableArray = begin(_first_parameters)  # parameters of the feedforward
    bristles: float = 0.0  # torque ``y`` of the bristles, N m
    slopes: MutableArray = begin(_zeros)  # derivatives of that torque by each parameter
    sensitivities: MutableArray = begin(_zeros)  # ``G df/dp``: derivatives of the velocity by each parameter
    integrals: MutableArray = begin(_zeros)  # second state of ``G`` for each, as velocities
    reference: float = 0.0  # last reference, rad/s
    enabled: bool = True  # whether the parameters adapt


def unit_of(own: "LuGreGradient", parameters: NDArray[np.float64], place: int) -> float:
    """Return the unit in which a parameter is tuned; that of ``sigma0``, which spans decades, is its present value."""
    return parameters[place] if place == STIFFNESS else own.scale[place]  # type: ignore[no-any-return]


def descend_in_place(own: "LuGreGradient", state: LuGreGradientState, error: float, duration: float) -> None:
    """Move the parameters along the gradient of the squared error (rad/s) over a period (s)."""
    found, least = state.parameters, LEAST_FRACTION * own.torque_scale
    size = own.least_size * own.least_size
    for i in range(PARAMETERS):
        scaled = unit_of(own, found, i) * state.sensitivities[i]
        size += scaled * scaled
    fraction = -math.expm1(-own.rate * duration)
    for i in range(PARAMETERS):
        unit = unit_of(own, found, i)
        found[i] += fraction * unit * unit * state.sensitivities[i] * error / size
    found[INERTIA] = min(max(found[INERTIA], own.inertia / INERTIA_RANGE), own.inertia * INERTIA_RANGE)
    found[STIFFNESS] = min(max(found[STIFFNESS], own.stiffness / STIFFNESS_RANGE), own.stiffness * STIFFNESS_RANGE)
    found[VISCOUS] = max(found[VISCOUS], 0.0)
    found[COULOMB] = max(found[COULOMB], least)
    found[STICTION] = max(found[STICTION], found[COULOMB])


def bend_in_place(own: "LuGreGradient", state: LuGreGradientState, velocity: float, adhesion: float) -> float:
    """Advance the bristles and their derivatives over a period of constant velocity (rad/s); return their torque.

    With ``g`` constant the law is ``y+ = g d + (y - g d) k``, ``k = exp(-sigma0 |v| T/g)``, ``d = sgn v``. The adhesion
    is the fraction of stiction in ``g`` at this velocity.
    """
    values, slopes = state.parameters, state.slopes
    level = values[COULOMB] + (values[STICTION] - values[COULOMB]) * adhesion
    way = 0.0 if velocity == 0.0 else math.copysign(1.0, velocity)
    distance = abs(velocity) * own.period
    decay = values[STIFFNESS] * distance / level
    keep = math.exp(-decay)
    open_gap = (state.bristles - level * way) * keep
    by_level = way * (1.0 - keep) + open_gap * decay / level
    slopes[COULOMB] = by_level * (1.0 - adhesion) + slopes[COULOMB] * keep
    slopes[STICTION] = by_level * adhesion + slopes[STICTION] * keep
    slopes[STIFFNESS] = slopes[STIFFNESS] * keep - open_gap * distance / level
    return level * way + open_gap  # type: ignore[no-any-return]


def filter_in_place(own: "LuGreGradient", state: LuGreGradientState, place: int, torque: float) -> None:
    """Pass the derivative of the torque by a parameter through ``G``, sampled as the loop samples it."""
    state.integrals[place] += own.spring * state.sensitivities[place]
    pushed = own.period / own.inertia * torque
    state.sensitivities[place] += pushed - own.damping * state.sensitivities[place] - state.integrals[place]


def step_lugre_gradient(
    own: "LuGreGradient", state: LuGreGradientState, inputs: Inputs
) -> tuple[Output, LuGreGradientState]:
    """Do one sample: tune by the last error, feed the friction of the coming period forward, then feedback."""
    inputs, guard = plausible_inputs(own.feedback, state.feedback, inputs)
    last, values = state.feedback, state.parameters
    refused = was_refused(own.feedback, last, inputs.realised_torque, own.torque_scale)
    if state.enabled and last.samples > 0 and not refused and math.isfinite(inputs.velocity):
        descend_in_place(own, state, inputs.reference + inputs.correction - inputs.velocity, inputs.dt)
    past = FeedforwardState(0.0, state.reference, last.samples > 0)
    start, end = coming_plan(past, inputs, own.feedback.delay)
    velocity, slope = 0.5 * (start + end), (end - start) / own.period
    for i in range(COULOMB, PARAMETERS):
        filter_in_place(own, state, i, 0.5 * state.slopes[i])
    adhesion = stiction_fraction(abs(velocity), own.stribeck_velocity, own.stribeck_shape)
    bristles = bend_in_place(own, state, velocity, adhesion)
    filter_in_place(own, state, INERTIA, slope)
    filter_in_place(own, state, VISCOUS, velocity)
    filter_in_place(own, state, OFFSET, 1.0)
    for i in range(COULOMB, PARAMETERS):  # the other half of the mean over the period
        state.sensitivities[i] += 0.5 * own.period / own.inertia * state.slopes[i]
    friction = 0.5 * (state.bristles + bristles) + values[VISCOUS] * velocity + values[OFFSET]
    torque = present_inertia(inputs, values[INERTIA]) * slope + friction
    output, feedback = feed_back(own.feedback, last, with_feedforward(inputs, torque), guard)
    return output, state._replace(feedback=feedback, parameters=values, bristles=bristles, reference=inputs.reference)


def write_lugre_gradient(own: "LuGreGradient", state: LuGreGradientState, row: NDArray[np.float64]) -> None:
    """Write the parameters into a row."""
    for i in range(PARAMETERS):
        row[i] = state.parameters[i]


@controller(step_lugre_gradient, LuGreGradientState, estimates=write_lugre_gradient)
class LuGreGradient(DesignedLoop, IdentifyingController):
    """``u = PI(e) + J dr/dt + y + sigma2 r + offset``, LuGre bristles ``y(r)``, ``dp/dt = rate e G df/dp``."""

    estimate_names = NAMES

    stribeck_velocity: float = argument(positive, "Pre-estimated ``Vs``, rad/s.")
    stribeck_shape: float = argument(positive, "Pre-estimated ``delta``.", default=1.0)
    stiffness: float = argument(positive, "First stiffness ``sigma0`` of the bristles, N m/rad.")
    rate: float = argument(positive, "Learning rate, 1/s. It loses its stability at some ``2.2 floor^2 Kp/J``.")
    floor: float = argument(
        positive, "What is added to the size of the sensitivities, over ``Vs``.", default=1.2, kept=False
    )
    scale: NDArray[np.float64] = derived("Unit in which each parameter is tuned; that of ``sigma0`` is not in it.")
    torque_scale: float = derived("Unit of torque, N m.")
    least_size: float = derived("What is added to the size of the sensitivities, rad/s.")
    damping: float = derived("Gain ``Kp T/J`` of the loop in ``G``, per period.")
    spring: float = derived("Gain ``Ki T^2/J`` of the loop in ``G``, per period.")

    def derive(self) -> dict[str, Any]:
        """Return the units and the gains of ``G``."""
        torque = self.proportional * self.stribeck_velocity
        return {
            "scale": np.array([self.inertia, VISCOUS_UNIT * self.proportional, torque, torque, torque]),
            "torque_scale": torque,
            "least_size": self.floor * self.stribeck_velocity,
            # so that ``G`` is stable whatever the gains
            "damping": min(self.proportional * self.period / self.inertia, 1.0),
            "spring": min(self.integral * self.period * self.period / self.inertia, 0.25),
        }
