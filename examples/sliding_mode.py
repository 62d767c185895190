"""A controller of one's own in one file: sliding mode with a boundary layer around a PI loop.

    adaptive-ff compare --own examples/sliding_mode.py:SlidingMode

V. Utkin, "Variable structure systems with sliding modes" (1977); boundary layer of J.-J. Slotine (1984).
"""

import math
from typing import NamedTuple

from controllers import (
    DesignedLoop,
    Inputs,
    Output,
    PIState,
    argument,
    controller,
    feed_back,
    plausible_inputs,
    positive,
    slope_torque,
    with_feedforward,
)


class SlidingModeState(NamedTuple):
    """State of the loop."""

    feedback: PIState
    reference: float = 0.0  # last reference, rad/s


def step_sliding_mode(
    parameters: "SlidingMode", state: SlidingModeState, inputs: Inputs
) -> tuple[Output, SlidingModeState]:
    """Do one sample: the surface ``s = e + Ki/Kp integral(e)``, the torque that drives the joint to it, feedback."""
    inputs, guard = plausible_inputs(parameters.feedback, state.feedback, inputs)
    last, proportional = state.feedback, parameters.feedback.proportional
    error = inputs.reference + inputs.correction - inputs.velocity if math.isfinite(inputs.velocity) else 0.0
    surface = error + last.integral / proportional
    switched = parameters.level * proportional * min(max(surface / parameters.layer, -1.0), 1.0)
    ahead = slope_torque(parameters.inertia, inputs, state.reference, last.samples > 0, parameters.period)
    output, feedback = feed_back(parameters.feedback, last, with_feedforward(inputs, ahead + switched), guard)
    return output, SlidingModeState(feedback, inputs.reference)


@controller(step_sliding_mode, SlidingModeState)
class SlidingMode(DesignedLoop):
    """``u = PI(e) + J dr/dt + level Kp sat(s/layer)``, ``s = e + Ki/Kp integral(e)``."""

    level: float = argument(positive, "Torque of the switching term over ``Kp``, rad/s.", default=0.05)
    layer: float = argument(positive, "Width of the boundary layer, rad/s.", default=0.05)


if __name__ == "__main__":
    from adaptive_ff import compare, load_scenario

    short = load_scenario().modified(duration=20.0, controllers=["pi"])
    print(compare(short, own={"sliding": SlidingMode}).improvement)
