"""Joints drawn at random around that of a scenario, and classes of them."""

import math

import numpy as np

from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.scenario.series import largest_size
from plant import AnyJoint, check_factor, schedule, steepest_fall

CONTROLLERS = ("pi", "oracle", "adaptive")

CLASSES = {
    "up to 0.5 Kp": 0.0,
    "0.5 to 1 Kp": 0.5,
    "1 to 2 Kp": 1.0,
    "2 to 5 Kp": 2.0,
    "5 to 10 Kp": 5.0,
    "10 to 20 Kp": 10.0,
    "above 20 Kp": 20.0,
}
"""Classes of joints by how steeply friction falls, over the proportional gain: each from its number on."""

HUNTING = 1.0
"""Fall of the friction over the proportional gain from which PI itself hunts at low speed."""

FINEST = 64
"""Largest number of parts that the scenario's solver period is cut into for a drawn joint."""


def draw_scenario(scenario: Scenario, seed: int, draw: int) -> Scenario:
    """Draw a joint and what the controllers assume of it.

    The PI loop is redesigned for the assumed inertia with the scenario's bandwidth; the torque limit grows with the
    largest torque that the reference needs. A joint that the solver period is too long for gets a shorter one. An
    encoder keeps its resolution, and gets no noise of the velocity beside it.
    """
    generator = np.random.default_rng([seed, draw])
    ranges, joint = scenario.sweep, scenario.joint

    def even(bounds: list[float]) -> float:
        return float(generator.uniform(bounds[0], bounds[1]))

    def logarithmic(bounds: list[float]) -> float:
        return float(np.exp(generator.uniform(math.log(bounds[0]), math.log(bounds[1]))))

    inertia = joint.inertia * logarithmic(ranges.inertia)
    coulomb, viscous = logarithmic(ranges.coulomb), logarithmic(ranges.viscous)
    stiction, lag = even(ranges.stiction), even(ranges.friction_lag)
    table = {"inertia": inertia}
    curves = {"": joint.friction, "_backward": joint.friction_backward}
    if curves["_backward"] == curves[""]:
        del curves["_backward"]
    for ending, curve in curves.items():
        table[f"coulomb{ending}"] = curve.coulomb * coulomb
        table[f"viscous{ending}"] = curve.viscous * viscous
        table[f"stiction{ending}"] = curve.coulomb * coulomb * stiction
    if "friction_lag" in type(joint).model_fields:
        table["friction_lag"] = lag
    noise = even(ranges.velocity_noise)
    assumed_velocity = joint.stribeck_velocity * logarithmic(ranges.assumed_stribeck_velocity)
    assumed_inertia = inertia * logarithmic(ranges.assumed_inertia)
    if scenario.feedback.bandwidth is None:
        fraction = assumed_inertia / scenario.feedback.inertia
        proportional, integral = (fraction * gain for gain in scenario.feedback.gains)
        feedback = {"inertia": assumed_inertia, "proportional": proportional, "integral": integral}
    else:
        feedback = {"inertia": assumed_inertia, "bandwidth": scenario.feedback.hertz}
    own_seed, limit = int(generator.integers(2**31)), scenario.actuator.torque_limit
    drawn = drawn_joint(scenario, table)
    table["solver_period"] = scenario.joint.solver_period if drawn is None else drawn.solver_period
    drive = {}
    if drawn is not None and limit is not None:  # a copy without checks: of it only the needed torque is asked for
        alike = scenario.model_copy(update={"seed": own_seed, "joint": drawn})
        drive = {"actuator": {"torque_limit": limit * needed_torque(alike) / needed_torque(scenario)}}
    sensor = {} if scenario.sensor.encoder_resolution is not None else {"sensor": {"velocity_noise": noise}}
    return scenario.modified(
        seed=own_seed,
        controllers=list(CONTROLLERS),
        joint=table,
        **sensor,
        feedback=feedback,
        adaptation={"stribeck_velocity": assumed_velocity},
        **drive,
    )


def drawn_joint(scenario: Scenario, table: dict[str, float]) -> AnyJoint | None:
    """Return a scenario's joint with other fields, and the longest part of its solver period that leaves one solution.

    None where the step of the joint is ambiguous even with the shortest part; what makes a scenario of it says why.
    """
    period: float = scenario.joint.solver_period
    fields = {**scenario.joint.model_dump(exclude_unset=True), **table}
    for parts in (2**power for power in range(FINEST.bit_length())):
        try:
            joint = type(scenario.joint)(**{**fields, "solver_period": period / parts})
            plan = schedule(scenario.change, period / parts, scenario.variation)
            check_factor(joint.parameters, plan, period / parts, joint.weight.amplitude)
        except ValueError:
            continue
        return joint
    return None


def fall_over_gain(scenario: Scenario) -> float:
    """Return how steeply friction falls at worst, over the proportional gain; from one on, PI itself hunts."""
    steepest = max(map(steepest_fall, (scenario.joint.friction, scenario.joint.friction_backward)))
    return float(steepest / scenario.feedback.gains[0])


def class_of(fall: float) -> str:
    """Return the class of a joint whose friction falls by a multiple of the proportional gain."""
    return [name for name, least in CLASSES.items() if fall >= least][-1]


def needed_torque(scenario: Scenario) -> float:
    """Return a bound on the torque that the reference needs, N m."""
    joint, reference = scenario.joint, scenario.reference_velocity()
    fastest = largest_size(np.diff(reference)) / joint.solver_period
    friction = max(joint.stiction, joint.coulomb + joint.viscous * largest_size(reference))
    return joint.inertia * fastest + friction
