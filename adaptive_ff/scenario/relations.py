"""What the fields of a scenario must be beside each other: a check each, which raises ``ValueError`` and names them."""

import math

from adaptive_ff.scenario.content import Content
from adaptive_ff.scenario.reference import Multisine
from controllers import design_pi
from plant import check_factor, whole_multiple

LONGEST = 200_000_000  # largest number of solver steps of a run; its series then fill some gigabytes


def check_periods(scenario: Content) -> None:
    """Sampling period and delay are whole multiples of the solver's period."""
    solver = scenario.joint.solver_period
    for field, seconds in (("sampling.period", scenario.sampling.period), ("actuator.delay", scenario.actuator.delay)):
        if seconds > 0.0 and whole_multiple(seconds, solver) is None:
            raise ValueError(
                f"{field} = {seconds:g} s is not allowed: it must be a whole multiple of "
                f"joint.solver_period = {solver:g} s"
            )


def check_duration(scenario: Content) -> None:
    """A run has a sample, and series that memory can hold."""
    period, solver = scenario.sampling.period, scenario.joint.solver_period
    if not 1.0 - 1e-6 <= scenario.length / period <= LONGEST * solver / period:
        raise ValueError(
            f"duration = {scenario.length:g} s is not allowed: it must be from one sampling period ({period:g} s) "
            f"to {LONGEST} solver periods ({LONGEST * solver:g} s)"
        )


def check_changes(scenario: Content) -> None:
    """Changes come before the end, and are of what the joint has."""
    end = float(scenario.sample_steps[-1]) * scenario.joint.solver_period
    for index, change in enumerate(scenario.change):
        if change.time >= end:
            raise ValueError(
                f"change.{index}.time = {change.time:g} s is not allowed: it must be before the end, {end:g} s"
            )
        if change.lag_scale != 1.0 and "friction_lag" not in type(scenario.joint).model_fields:
            raise ValueError(
                f"change.{index}.lag_scale = {change.lag_scale:g} is not allowed: a joint of kind "
                f"{scenario.joint.kind!r} has no friction lag; lag_scale must be 1"
            )


def check_axis(scenario: Content) -> None:
    """Check that what is identified exists on this axis, and that a rotary encoder has more than a count a turn."""
    step = scenario.sensor.encoder_resolution or 0.0
    if scenario.joint.axis == "rotary" and step >= 2.0 * math.pi:
        must = f"less than a turn; of {step:g} counts a turn it is {2.0 * math.pi / step:.4g}"
        raise ValueError(f"sensor.encoder_resolution = {step:g} rad is not allowed: it must be {must}")
    if scenario.joint.axis == "linear" and "gravity" in (scenario.adaptation.identify or ""):
        raise ValueError(
            f"adaptation.identify = {scenario.adaptation.identify!r} is not allowed for axis = 'linear': it must be "
            "symmetric, offset or directions; the weight on a linear axis is its offset"
        )
    if scenario.adaptation.motor_turn and scenario.joint.gear_ratio is None:
        raise ValueError("joint.gear_ratio is missing; it must be given where adaptation.motor_turn is true")


def check_frequencies(scenario: Content) -> None:
    """A multisine is slower than half the sampling frequency."""
    period = scenario.sampling.period
    if not isinstance(scenario.reference, Multisine):
        return
    for index, frequency in enumerate(scenario.reference.frequencies):
        if frequency >= 0.5 / period:
            raise ValueError(
                f"reference.frequencies.{index} = {frequency:g} Hz is not allowed: it must be less than half "
                f"the sampling frequency, {0.5 / period:g} Hz"
            )


def check_loops(scenario: Content) -> None:
    """Velocity loop and position loop can be designed."""
    feedback = scenario.feedback
    if feedback.is_auto and scenario.position is not None and scenario.position.gain is None:
        raise ValueError("position.gain is missing; it must be given where feedback.bandwidth is 'auto'")
    if feedback.bandwidth is not None and not feedback.is_auto:
        delay = math.ceil(scenario.assumed_delay - 1e-6)
        try:
            design_pi(feedback.inertia, scenario.sampling.period, feedback.hertz, delay=delay)
        except ValueError as error:
            raise ValueError(f"feedback.{error}") from error


def check_friction(scenario: Content) -> None:
    """Friction stays one that the solver can follow, whatever changes."""
    joint = scenario.joint
    try:
        check_factor(joint.parameters, scenario.plan, joint.solver_period, joint.weight.amplitude)
    except ValueError as error:
        raise ValueError(f"change: {error}") from error


RELATIONS = (
    check_periods,
    check_duration,
    check_changes,
    check_axis,
    check_frequencies,
    check_loops,
    check_friction,
)
"""All of them; what a later one asks of a scenario, an earlier one has made sure of."""
