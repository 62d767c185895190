"""What is true of a scenario's joint, for controllers that know it and for pictures and tables that show it."""

import math

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.friction.model import GRAVITY, TorqueModel, ripple_names
from adaptive_ff.scenario.scenario import Scenario
from plant import UNCHANGED, JointChange, friction_factor, gravity_torque, heated, phase_change, sliding_friction

GRID = 2000  # times at which friction that varies all the time is given, over a run


def true_waves(scenario: Scenario) -> dict[str, float]:
    """Return the torque that carries gravity and the ripple of the drive, by the names of the estimates, N m.

    The ripple is that over each of the periods that are assumed; it is none over one that is not its own.
    """
    weight, drive = scenario.joint.weight, scenario.actuator
    periods = scenario.adaptation.ripple_periods
    sizes = [-drive.ripple_amplitude if period == drive.ripple_period else 0.0 for period in periods]
    gravity = weight.amplitude * math.cos(weight.phase), weight.amplitude * math.sin(weight.phase)
    ripples = [value for size in sizes for value in (size, 0.0)]
    return dict(zip((*GRAVITY, *ripple_names(len(periods))), (*gravity, *ripples), strict=True))


def true_model(scenario: Scenario, factor: float = 1.0, change: JointChange = UNCHANGED) -> TorqueModel:
    """Return the true parameters of a scenario's joint as a model, by default those before it changes.

    The model has no bristles and no spring: of a LuGre joint it has the static curve, of an elastic one the whole
    inertia. It has no gravity either. All friction has the factor. What differs by direction is halved.
    """
    joint, backward = scenario.joint, scenario.joint.friction_backward
    carried = getattr(joint, "link_share", 1.0) * joint.inertia  # a payload is beyond the spring
    scales = {"coulomb": change.dry, "stiction": change.dry, "viscous": change.viscous}
    pairs = [[factor * scale * getattr(one, name) for one in (joint, backward)] for name, scale in scales.items()]
    coulomb, stiction, viscous = (0.5 * (one + other) for one, other in pairs)
    slip, adhesion, slope = (0.5 * (one - other) for one, other in pairs)
    return TorqueModel(
        joint.inertia - carried + carried * change.inertia,
        *(coulomb, stiction, viscous, getattr(joint, "friction_lag", 0.0) * change.lag),
        *(joint.stribeck_velocity, joint.stribeck_shape),
        *(joint.offset + change.load + slip, adhesion - slip, slope),
    )


def friction_power(scenario: Scenario, velocity: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the power (W) that the joint's friction, as it is before it varies, takes along a velocity (rad/s)."""
    grid = np.linspace(0.0, max(float(np.max(np.abs(velocity))), 1e-12), GRID)
    curves = (scenario.joint.friction, scenario.joint.friction_backward)
    forward, backward = (
        np.interp(np.abs(velocity), grid, [sliding_friction(curve, speed) for speed in grid.tolist()])
        for curve in curves
    )
    return np.where(velocity > 0.0, forward, backward) * np.abs(velocity)


def model_changes(scenario: Scenario) -> list[tuple[float, TorqueModel]]:
    """Return times (s) and the true model from then on, as they are along the reference.

    Friction that varies with position, weight or its own heat is taken where the reference is.
    """
    plan, period = scenario.plan, scenario.joint.solver_period
    if not plan.varies:
        return [
            (change.time, true_model(scenario, change.friction_scale, change.parameters)) for change in scenario.change
        ]
    velocity = scenario.reference_velocity()
    position = np.cumsum(velocity) * period
    work = np.append(0.0, np.cumsum(friction_power(scenario, velocity)) * period)
    steps = np.unique(np.append(plan.starts, np.linspace(0, velocity.size - 1, GRID).astype(np.int64)))
    phases = np.searchsorted(plan.starts, steps, side="right") - 1
    setup, warmth = [], 0.0
    for step, following, phase in zip(steps, [*steps[1:], steps[-1]], phases.tolist(), strict=True):
        time, duration = float(step * period), float((following - step) * period)
        weight = gravity_torque(scenario.joint.weight, float(position[step]))
        factor = float(friction_factor(plan, phase, time, float(position[step]), weight, warmth))
        change = JointChange(*map(float, phase_change(plan, phase)))
        setup.append((time, true_model(scenario, factor, change)))
        if duration > 0.0:
            power = factor * float(work[following] - work[step]) / duration
            warmth = heated(plan, warmth, power, duration)
    return setup


def last_model(scenario: Scenario) -> TorqueModel:
    """Return the true model after the last sudden change."""
    if not scenario.change:
        return true_model(scenario)
    return true_model(scenario, scenario.change[-1].friction_scale, scenario.change[-1].parameters)
