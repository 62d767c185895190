"""What is laid down before a run starts."""

import numpy as np

from adaptive_ff.loop import Course
from adaptive_ff.scenario import Scenario


def lay_course(scenario: Scenario) -> Course:
    """Lay down everything of a scenario that does not depend on the controller."""
    return Course(
        scenario.plan,
        scenario.actuator.parameters,
        scenario.joint.solver_period,
        np.arange(scenario.samples + 1, dtype=np.int64) * scenario.substeps,
        scenario.reference_velocity(),
        scenario.noise(),
    )
