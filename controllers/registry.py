"""What kernels of controllers take and give, and the registries that choose a kernel by the class of its parameters.

The extension that calls kernels has the same rules for what a step may be given, without the words.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from controllers.checks import check_finite, check_numbers, check_positive
from controllers.kernels.language import dispatched


class Inputs(NamedTuple):
    """What a controller is given at a sample.

    Feedback acts on ``reference + correction - velocity``. Feedforward, preview and instruments see the plan alone,
    ``reference`` and ``next_reference``: a correction contains the measurement, and friction fed forward along it
    would close a loop of its own. Identification sees the true velocity and torque. Where the drive is late, the torque
    that is computed now begins to act ``delay`` periods from now.
    """

    reference: float  # planned velocity now, rad/s
    velocity: float  # measured velocity now, rad/s; not finite where the measurement failed
    next_reference: float  # planned velocity at the next sample, rad/s; not a number where it is not known
    correction: float  # what an outer loop adds to the plan, rad/s
    position: float  # measured position now, rad; not a number where it is not known
    realised_torque: float  # mean torque that the drive gave over the last period, N m; not a number where not known
    feedforward: float  # torque known from elsewhere, such as gravity, N m
    inertia: float  # inertia in the present configuration, kg m^2; not a number where the controller's own holds
    dt: float  # time since the last sample, s
    acting_reference: float  # planned velocity when this torque begins to act, rad/s; not a number where not known
    next_acting_reference: float  # planned velocity one period after that, rad/s; not a number where it is not known


def planned_inputs(
    reference: float, velocity: float, next_reference: float, realised_torque: float, dt: float
) -> Inputs:
    """Return the inputs along a plan without an outer loop, with no known torque, position or given inertia.

    Planned and measured velocity now and planned at the next sample are in rad/s; the mean torque that the drive gave
    over the last period in N m, and the time since the last sample in s.
    """
    unknown = math.nan
    given = (reference, velocity, next_reference, 0.0, unknown, realised_torque, 0.0)
    return Inputs(*given, inertia=unknown, dt=dt, acting_reference=unknown, next_acting_reference=unknown)


def with_feedforward(inputs: Inputs, torque: float) -> Inputs:
    """Return the inputs with a torque (N m) added to their feedforward."""
    return inputs._replace(feedforward=inputs.feedforward + torque)


def with_reference(inputs: Inputs, reference: float) -> Inputs:
    """Return the inputs with another planned velocity (rad/s) now."""
    return inputs._replace(reference=reference)


def with_realised_torque(inputs: Inputs, torque: float) -> Inputs:
    """Return the inputs with a mean torque (N m) that the drive gave over the last period."""
    return inputs._replace(realised_torque=torque)


def present_inertia(inputs: Inputs, inertia: float) -> float:
    """Return the inertia (kg m^2) of the present configuration, or the controller's own where none is given."""
    return inputs.inertia if math.isfinite(inputs.inertia) else inertia


def acts_on_plan(inputs: Inputs) -> bool:
    """Tell whether the plan is known over the period in which a torque computed now acts."""
    return math.isfinite(inputs.acting_reference) and math.isfinite(inputs.next_acting_reference)


class Output(NamedTuple):
    """What a controller gives at a sample."""

    torque: float  # commanded torque, N m
    feedforward: float  # the part of it that is not feedback, N m


STEPS: dict[type, Callable[..., Any]] = {}
"""Step kernel of each class of controller parameters: ``step(parameters, state, inputs) -> (output, state)``."""

ESTIMATES: dict[type, Callable[..., Any]] = {}
"""Kernel that writes the physical estimates into a row: ``write(parameters, state, row)``."""


MONITORS: dict[type, Callable[..., Any]] = {}
"""Kernel that writes what a controller watches itself by into a row: ``write(parameters, state, row)``."""


step = dispatched(STEPS)
step.__doc__ = "Do one sample of any controller: ``step(parameters, state, inputs) -> (output, state)``."

write_estimates = dispatched(ESTIMATES)
write_estimates.__doc__ = "Write the physical estimates of any controller: ``write(parameters, state, row)``."

write_monitors = dispatched(MONITORS)
write_monitors.__doc__ = "Write what any controller watches itself by; of those that do not, nothing."


def without_estimates(parameters: Any, state: Any, row: Any) -> None:
    """Write nothing: for controllers that estimate nothing."""


COMMANDED, MEASURED, UNKNOWN, PREVIEW, INERTIA, TIME = "cmupit"
"""Finite; any number; the same or none; finite or none; positive or none; positive, or none for the nominal period."""

RULES = {
    "reference": COMMANDED,
    "velocity": MEASURED,
    "next_reference": PREVIEW,
    "correction": COMMANDED,
    "position": UNKNOWN,
    "realised_torque": UNKNOWN,
    "feedforward": COMMANDED,
    "inertia": INERTIA,
    "dt": TIME,
    "acting_reference": PREVIEW,
    "next_acting_reference": PREVIEW,
}
"""Rule of each input, in the order of ``Inputs``."""


def checked_step(given: tuple[Any, ...], period: float) -> Inputs:
    """Return the inputs of a step as floats, not a number where there is none."""
    numbers = []
    for (name, rule), value in zip(RULES.items(), given, strict=True):
        if value is None and rule not in (COMMANDED, MEASURED):
            numbers.append(period if rule == TIME else math.nan)
            continue
        if rule == INERTIA:
            check_positive(inertia=value)
        elif rule in (COMMANDED, PREVIEW):
            check_finite(**{name: value})
        check_numbers(**{name: value})
        if rule == TIME and not 0.0 < value < math.inf:
            raise ValueError(f"dt = {value} is not allowed: it must be a positive number of seconds")
        numbers.append(float(value))
    return Inputs(*numbers)
