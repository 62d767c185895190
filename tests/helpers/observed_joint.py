"""An observer beside a joint whose torque and motion a test gives sample by sample."""

import math

from closed_loops import SCENARIO

from adaptive_ff.adaptive.supervision.circumstances import Circumstances
from adaptive_ff.adaptive.supervision.observer import observe
from adaptive_ff.adaptive.supervision.observer_state import ObserverParameters, initial_observer, start_observer
from controllers import check_gains

PERIOD = 0.01
FEEDBACK = check_gains(*SCENARIO.feedback.gains, 0.01)
INERTIA = SCENARIO.feedback.inertia
OBSERVER = ObserverParameters(20.0, 20.0, INERTIA, 0.0, PERIOD)

NOTHING_SPECIAL = Circumstances(
    held=False,
    peak=1.0,
    strained=False,
    falls=False,
    believed=True,
    saturates=False,
    friction=0.0,
    unforeseen=0.0,
    learnt=True,
)
"""A joint that moves freely, of which something has been learnt."""


def after(
    observer,
    state,
    torque,
    reference,
    correction,
    velocity,
    held,
    peak,
    strained,
    duration=PERIOD,
    unforeseen=0.0,
    learnt=True,
):
    """State after a period over which the drive gave a torque."""
    lacking = torque - state.fed[0]
    known = NOTHING_SPECIAL._replace(held=held, peak=peak, strained=strained, unforeseen=unforeseen, learnt=learnt)
    return observe(observer, state, FEEDBACK, lacking, INERTIA, reference, correction, velocity, duration, known)


def observed(torques, velocities, references, observer=OBSERVER):
    """States while the drive gives torques; velocity and reference have one value more, of the start."""
    state, states = start_observer(initial_observer(FEEDBACK), references[0], velocities[0]), []
    for torque, reference, velocity in zip(torques, references[1:], velocities[1:], strict=True):
        state = after(observer, state, torque, reference, 0.0, velocity, False, 1.0, math.inf)
        states.append(state)
    return states
