"""The model that is fed forward: the identified one with a lag of its own, as it is where the joint will be."""

from typing import Any

from numba.extending import register_jitable

from adaptive_ff.adaptive.learning.candidate_margins import alike
from adaptive_ff.adaptive.learning.candidate_state import CandidateState, slides
from adaptive_ff.adaptive.learning.change_detection import JUMP_WINDOW, undecided_factor
from adaptive_ff.adaptive.learning.estimator_state import EstimatorState, damping_in_use, form_in_use, load_count
from adaptive_ff.adaptive.learning.friction_map import coming_factor
from adaptive_ff.friction.bounds import FRICTION_LAG, INERTIA, torque_model, with_bristles, with_friction_times
from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.learning.torque_form import BENT
from controllers import Inputs, present_inertia

Block = Any
"""Parameters or state of kernels that serve the supervised controller too: its tuples have these fields and more."""

RISE_MEMORIES = 2.0
"""Time in memories for which friction is not taken to rise from standstill on while all reversals are alike.

What comes late at all of them looks the same: without it a machine on bristles has 1.4 of PI's error in the first 5 s,
with it 1.07.
"""


@register_jitable
def fed_model(block: Block, estimator: EstimatorState, lag: float) -> TorqueModel:
    """Return the model that is fed forward: the identified one with a lag (s) of its own."""
    form, loads = form_in_use(block.estimator, estimator), load_count(block.estimator)
    rise, young = 1.0, estimator.levels.learnt < RISE_MEMORIES * block.estimator.memory
    if young and alike(estimator.candidates.reversals) and not block.estimator.rises:
        rise = 0.0
    estimate = estimator.recursion.estimate
    model = torque_model(estimate, lag, form.stribeck_velocity, form.stribeck_shape, loads, rise)
    return with_bristles(model, form.presliding, damping_in_use(estimator))


@register_jitable
def present_model(block: Block, estimator: EstimatorState, lag: float, reference: float) -> TorqueModel:
    """Return the model that is fed forward where the joint will be, on its plan (rad/s), when the torque acts."""
    turn = (block.feedback.delay + 0.5) * block.period * reference / block.estimator.gear_ratio
    factor = coming_factor(block.estimator.friction_map, estimator.friction_map, turn)
    if slides(estimator.candidates):
        factor *= undecided_factor(estimator.alarm, estimator.surprise, JUMP_WINDOW / block.estimator.form.pole)
    return with_friction_times(fed_model(block, estimator, lag), factor)


@register_jitable
def identified_model(block: Block, state: Block) -> TorqueModel:
    """Return the model as it is identified now."""
    return fed_model(block, state.estimator, state.estimator.recursion.estimate[FRICTION_LAG])


@register_jitable
def bent_shares(candidates: CandidateState) -> tuple[float, float]:
    """Return the shares of Coulomb friction and stiction of the candidate in use, as they are over the reference."""
    slip, adhesion = 0.0, 0.0
    if candidates.bent.shape[0] > 0:
        place = candidates.chosen - (candidates.errors.size - candidates.bent.shape[0])
        if place >= 0:
            slip, adhesion = candidates.bent[place, BENT, 0], candidates.bent[place, BENT, 1]
    return slip, adhesion


@register_jitable
def gate_speed(block: Block, estimator: EstimatorState) -> float:
    """Return the speed below which the joint may stick, rad/s: it is that of the curve in use."""
    speed: float = block.slowest * (estimator.candidates.stribeck_velocity / block.estimator.form.stribeck_velocity)
    return speed


@register_jitable
def inertia_ratio(block: Block, inputs: Inputs) -> float:
    """Return the inertia that is given for the present configuration over the one that is estimated at first.

    What is given counts as the assumed inertia of the configuration; what is estimated is by how much it is wrong.
    """
    assumed = float(block.estimator.first[INERTIA])
    return present_inertia(inputs, assumed) / assumed
