"""What is true of a scenario's joint, for controllers that know it and for pictures and tables that show it."""

import numpy as np

from adaptive_ff.model.friction import TorqueModel
from adaptive_ff.scenario.scenario import Scenario
from plant import friction_factor

GRID = 2000
"""Times at which the oracle gets the factor on friction that varies all the time, over a run."""


def true_model(scenario: Scenario) -> TorqueModel:
    """Return the true parameters of a scenario's joint, before its friction changes, as a model.

    The model has no bristles and no spring: of a LuGre joint it has the static curve, of an elastic one the whole
    inertia.
    """
    joint, backward = scenario.joint, scenario.joint.friction_backward
    return TorqueModel.from_directions(
        joint.inertia,
        (joint.coulomb, backward.coulomb),
        (joint.stiction, backward.stiction),
        (joint.viscous, backward.viscous),
        getattr(joint, "friction_lag", 0.0),
        joint.stribeck_velocity,
        joint.stribeck_shape,
        joint.offset,
    )


def friction_course(scenario: Scenario) -> list[tuple[float, float]]:
    """Return times (s) and factors on the joint's friction from then on, as they are along the reference.

    Friction that varies with position is taken where the reference is.
    """
    if not scenario.plan.varies:
        return [(change.time, change.friction_scale) for change in scenario.change]
    plan, period, velocity = scenario.plan, scenario.joint.solver_period, scenario.reference_velocity()
    position = np.cumsum(velocity) * period
    steps = np.unique(np.append(plan.starts, np.linspace(0, velocity.size - 1, GRID).astype(np.int64)))
    phases = np.searchsorted(plan.starts, steps, side="right") - 1
    times = steps * period
    return [
        (float(time), friction_factor(plan, int(phase), float(time), float(position[step])))
        for step, phase, time in zip(steps, phases, times, strict=True)
    ]
