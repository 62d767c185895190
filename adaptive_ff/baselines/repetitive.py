"""PI loop with a repetitive feedforward: the feedback torque of one period of the motion ago is fed forward now.

Repetitive control in its plug-in form (S. Hara, Y. Yamamoto, T. Omata, M. Nakano, "Repetitive control system", 1988),
with the feedback torque as the signal that is learnt from, as in feedback-error learning:

    m(p) += gain (Q u_fb)(p + lead)      u = PI(e) + J dr/dt + m(p)

``p`` is the place in the period, ``Q`` a mean of three samples without phase, which keeps what the loop cannot follow
out of the memory, and ``lead`` samples make up for the loop's own lag. A motion without a period leaves nothing to
learn. Sampling that jitters is taken as even: places are counted in samples.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from controllers.arrays import MutableArray
from controllers.checks import check_finite
from controllers.declaration import argument, begin, controller, portion, positive
from controllers.loops import PILoop
from controllers.pi import PIState, feed_back, plausible_inputs
from controllers.registry import Inputs, Output, with_feedforward
from controllers.torques import slope_torque


class RepetitiveState(NamedTuple):
    """State of the controller; its memory is changed in place."""

    feedback: PIState
    memory: MutableArray = begin(lambda parameters: np.zeros(parameters.cycle))  # torque fed at each place, N m
    past: float = 0.0  # feedback torque one sample ago, N m
    older: float = 0.0  # feedback torque two samples ago, N m
    place: int = 0  # place in the period
    reference: float = 0.0  # last reference, rad/s
    enabled: bool = True  # whether the memory changes


def step_repetitive(parameters: "Repetitive", state: RepetitiveState, inputs: Inputs) -> tuple[Output, RepetitiveState]:
    """Do one sample: feed the memory forward, then feedback, then learn from it for the next period."""
    inputs, guard = plausible_inputs(parameters.feedback, state.feedback, inputs)
    last = state.feedback
    torque = slope_torque(parameters.inertia, inputs, state.reference, last.samples > 0, parameters.period)
    place = state.place
    if parameters.cycle > 0:
        torque += state.memory[place]
    output, feedback = feed_back(parameters.feedback, last, with_feedforward(inputs, torque), guard)
    fed_back = output.torque - output.feedforward
    if parameters.cycle > 0:
        if state.enabled and last.samples > 1 and math.isfinite(inputs.velocity):
            smooth = 0.25 * (fed_back + 2.0 * state.past + state.older)  # of the sample before
            target = (place - 1 - parameters.lead) % parameters.cycle
            state.memory[target] += parameters.gain * smooth
        place = (place + 1) % parameters.cycle
    return output, RepetitiveState(feedback, state.memory, fed_back, state.past, place, inputs.reference, state.enabled)


def count(name: str, value: Any) -> int:
    """Check that a number counts something."""
    check_finite(**{name: value})
    if value < 0 or value != int(value):
        raise ValueError(f"{name} = {value} is not allowed: it must be a whole number, zero or more")
    return int(value)


@controller(step_repetitive, RepetitiveState)
class Repetitive(PILoop):
    """``u = PI(e) + J dr/dt + m``, ``m(p) += gain (Q u_fb)(p + lead)``: repetitive learning of a periodic motion."""

    inertia: float = argument(positive, "Inertia fed forward, kg m^2.")
    cycle: int = argument(count, "Samples in a period of the motion; zero where it has none and nothing is learnt.")
    lead: int = argument(count, "Samples by which learning leads, less than the cycle.", default=1)
    gain: float = argument(portion, "Fraction of the feedback torque that is learnt in a period.", default=0.3)

    def derive(self) -> dict[str, Any]:
        """Return nothing; cycle and lead must fit one another."""
        if 0 < self.cycle <= self.lead:
            raise ValueError(f"lead = {self.lead} is not allowed: it must be less than the cycle, {self.cycle}")
        return {}
