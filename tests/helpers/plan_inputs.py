"""Inputs of a feedforward, of which it looks at the plan alone."""

import math

from controllers import planned_inputs


def plan_inputs(reference, next_reference, acting=math.nan, next_acting=math.nan):
    """Inputs with a plan now and at the next sample, and for when the torque acts, rad/s, and nothing else."""
    inputs = planned_inputs(reference, math.nan, next_reference, math.nan, 0.01)
    return inputs._replace(acting_reference=acting, next_acting_reference=next_acting)
