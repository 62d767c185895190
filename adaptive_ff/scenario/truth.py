"""What is true of a scenario's joint, for controllers that know it and for pictures and tables that show it."""

import numpy as np

from adaptive_ff.model.friction import TorqueModel
from adaptive_ff.scenario.scenario import Scenario
from plant import UNCHANGED, JointChange, friction_factor, phase_change

GRID = 2000
"""Times at which friction that varies all the time is given, over a run."""


def true_model(scenario: Scenario, factor: float = 1.0, change: JointChange = UNCHANGED) -> TorqueModel:
    """Return the true parameters of a scenario's joint as a model, by default those before it changes.

    The model has no bristles and no spring: of a LuGre joint it has the static curve, of an elastic one the whole
    inertia. It has no gravity either.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    factor : float, optional
        Factor on all friction.
    change : JointChange, optional
        What else has changed.
    """
    joint, backward = scenario.joint, scenario.joint.friction_backward
    carried = getattr(joint, "link_share", 1.0) * joint.inertia  # a payload is beyond the spring
    dry, viscous = factor * change.dry, factor * change.viscous
    return TorqueModel.from_directions(
        joint.inertia - carried + carried * change.inertia,
        (dry * joint.coulomb, dry * backward.coulomb),
        (dry * joint.stiction, dry * backward.stiction),
        (viscous * joint.viscous, viscous * backward.viscous),
        getattr(joint, "friction_lag", 0.0) * change.lag,
        joint.stribeck_velocity,
        joint.stribeck_shape,
        joint.offset + change.load,
    )


def model_course(scenario: Scenario) -> list[tuple[float, TorqueModel]]:
    """Return times (s) and the true model from then on, as they are along the reference.

    Friction that varies with position is taken where the reference is.
    """
    plan, period = scenario.plan, scenario.joint.solver_period
    if not plan.varies:
        return [
            (change.time, true_model(scenario, change.friction_scale, change.parameters)) for change in scenario.change
        ]
    velocity = scenario.reference_velocity()
    position = np.cumsum(velocity) * period
    steps = np.unique(np.append(plan.starts, np.linspace(0, velocity.size - 1, GRID).astype(np.int64)))
    phases = np.searchsorted(plan.starts, steps, side="right") - 1
    times = steps * period
    course = []
    for step, phase, time in zip(steps.tolist(), phases.tolist(), times.tolist(), strict=True):
        factor = float(friction_factor(plan, phase, time, float(position[step])))
        change = JointChange(*map(float, phase_change(plan, phase)))
        course.append((time, true_model(scenario, factor, change)))
    return course


def last_model(scenario: Scenario) -> TorqueModel:
    """Return the true model after the last sudden change."""
    if not scenario.change:
        return true_model(scenario)
    return true_model(scenario, scenario.change[-1].friction_scale, scenario.change[-1].parameters)
