"""PI loop with a repetitive feedforward: what the feedback had to do a period of the motion ago is fed forward now.

Repetitive control in its plug-in form (S. Hara, Y. Yamamoto, T. Omata, M. Nakano, "Repetitive control system", 1988),
with the feedback torque as the signal that is learnt from, as in feedback-error learning:

    m(p) += gain (Q u_fb)(p + lead)      u = PI(e) + J dr/dt + m(p)

``p`` is the place in the period, ``Q`` a mean of three samples without phase, which keeps what the loop cannot follow
out of the memory, and ``lead`` samples make up for the loop's own lag. A motion without a period leaves nothing to
learn. Sampling that jitters is taken as even: places are counted in samples.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from controllers import (
    ESTIMATES,
    STEPS,
    Controller,
    Inputs,
    Output,
    PIParameters,
    PIState,
    check_gains,
    check_positive,
    feed_back,
    initial_pi_state,
    plausible_inputs,
    slope_torque,
    with_feedforward,
    without_estimates,
)
from controllers.arrays import MutableArray


class RepetitiveParameters(NamedTuple):
    """Parameters of the controller.

    Attributes
    ----------
    feedback : PIParameters
        The PI loop.
    inertia : float
        Inertia fed forward, kg m^2.
    period : float
        Nominal period, s.
    cycle : int
        Samples in a period of the motion; zero where it has none.
    lead : int
        Samples by which learning leads.
    gain : float
        Share of the feedback torque that is learnt in a period.
    """

    feedback: PIParameters
    inertia: float
    period: float
    cycle: int
    lead: int
    gain: float


class RepetitiveState(NamedTuple):
    """State of the controller; its arrays are changed in place.

    Attributes
    ----------
    feedback : PIState
        State of the PI loop.
    memory : ndarray, shape (cycle,)
        Torque fed forward at each place, N m.
    past, older : float
        Feedback torque one and two samples ago, N m.
    place : int
        Place in the period.
    reference : float
        Last reference, rad/s.
    enabled : bool
        Whether the memory changes.
    """

    feedback: PIState
    memory: MutableArray
    past: float
    older: float
    place: int
    reference: float
    enabled: bool


def initial_repetitive_state(block: RepetitiveParameters) -> RepetitiveState:
    """Return the state of a controller that has learnt nothing."""
    return RepetitiveState(initial_pi_state(block.feedback), np.zeros(block.cycle), 0.0, 0.0, 0, 0.0, True)


@register_jitable
def step_repetitive(
    block: RepetitiveParameters, state: RepetitiveState, inputs: Inputs
) -> tuple[Output, RepetitiveState]:
    """Do one sample: feed the memory forward, then feedback, then learn from it for the next period."""
    inputs, guard = plausible_inputs(block.feedback, state.feedback, inputs)
    last = state.feedback
    torque = slope_torque(block.inertia, inputs, state.reference, last.samples > 0, block.period)
    place = state.place
    if block.cycle > 0:
        torque += state.memory[place]
    output, feedback = feed_back(block.feedback, last, with_feedforward(inputs, torque), guard)
    asked = output.torque - output.feedforward
    if block.cycle > 0:
        if state.enabled and last.samples > 1 and math.isfinite(inputs.velocity):
            smooth = 0.25 * (asked + 2.0 * state.past + state.older)  # of the sample before
            target = (place - 1 - block.lead) % block.cycle
            state.memory[target] += block.gain * smooth
        place = (place + 1) % block.cycle
    return output, RepetitiveState(feedback, state.memory, asked, state.past, place, inputs.reference, state.enabled)


STEPS[RepetitiveParameters] = step_repetitive
ESTIMATES[RepetitiveParameters] = without_estimates


class Repetitive(Controller):
    """``u = PI(e) + J dr/dt + m``, ``m(p) += gain (Q u_fb)(p + lead)``: repetitive learning of a periodic motion.

    Parameters
    ----------
    proportional, integral : float
        Gains of the PI loop, N m s/rad and N m/rad.
    period : float
        Nominal sampling period, s.
    inertia : float
        Inertia fed forward, kg m^2.
    cycle : int
        Samples in a period of the motion; zero where it has none, nothing is learnt then.
    lead : int, optional
        Samples by which learning leads, less than the cycle.
    gain : float, optional
        Share of the feedback torque that is learnt in a period, from 0 to 1.
    delay : float, optional
        Computation delay of the drive, sampling periods.

    Raises
    ------
    ValueError
        A value is out of range.
    """

    def __init__(
        self,
        proportional: float,
        integral: float,
        period: float,
        *,
        inertia: float,
        cycle: int,
        lead: int = 1,
        gain: float = 0.3,
        delay: float = 0.0,
    ) -> None:
        feedback = check_gains(proportional, integral, period, delay)
        check_positive(inertia=inertia)
        if cycle < 0 or (cycle > 0 and not 0 <= lead < cycle):
            raise ValueError(
                f"cycle = {cycle}, lead = {lead} is not allowed: both count samples, the lead less than the cycle"
            )
        if not 0.0 < gain <= 1.0:
            raise ValueError(f"gain = {gain} is not allowed: it must be above 0 and at most 1")
        parameters = RepetitiveParameters(feedback, float(inertia), float(period), int(cycle), int(lead), float(gain))
        super().__init__(parameters, period, initial_repetitive_state)
