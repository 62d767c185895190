"""Where a plan that has rested sets out: what was wound up meanwhile becomes friction of the feedforward."""

from numba.extending import register_jitable

from adaptive_ff.adaptive.at_rest.outer_loop import unseen_error
from adaptive_ff.adaptive.at_rest.wound_integral import Standing, advance_standing, wound_up
from adaptive_ff.adaptive.learning.unexplained import breakaway
from adaptive_ff.adaptive.sensing import Sensed
from adaptive_ff.adaptive.supervised_state import SupervisedParameters, SupervisedState
from adaptive_ff.friction.feedforward import FeedforwardState, is_plan_at_rest


@register_jitable
def stand(block: SupervisedParameters, state: SupervisedState, sensed: Sensed) -> Standing:
    """Return what the integral has wound up after the period that has ended."""
    feedback, measured = block.feedback, state.feedback.guard.lost == 0.0
    rests = is_plan_at_rest(state.feedforward, sensed.inputs, feedback.delay)
    held = state.feedback.integral + state.observer.gain * state.observer.disturbance
    fed = state.command.share * state.trust.trust * state.feedforward.friction
    correction = state.outer.correction - unseen_error(state.outer, state.standing.rests)
    asked = feedback.integral * sensed.inputs.dt * correction if measured else 0.0
    torque, friction = held + fed + feedback.proportional * correction, breakaway(state.estimator)
    return advance_standing(state.standing, held, asked, torque, friction, rests, sensed.inputs.dt)


@register_jitable
def setting_out(state: SupervisedState, standing: Standing) -> FeedforwardState:
    """Return the state of the feedforward to go on from: with what was wound up where the plan sets out."""
    past, wound, most = state.feedforward, wound_up(state.standing, standing), breakaway(state.estimator)
    if wound == 0.0:
        return past
    friction = min(max(past.friction + wound, -most), most)
    slip, adhesion = past.slip, past.adhesion
    if state.estimator.candidates.presliding > 0.0 and most > 0.0:
        bent = friction / most
        slip, adhesion = bent * (1.0 - abs(past.adhesion)), bent * abs(past.adhesion)
    return FeedforwardState(friction, past.reference, past.started, slip, adhesion, past.turned)


@register_jitable
def begins_to_observe(state: SupervisedState, share: float, rests: bool) -> bool:
    """Tell whether the feedforward begins to be faded in, to a share, or a plan that has rested sets out."""
    return (state.command.share == 0.0 and share > 0.0) or (state.standing.rests and not rests)
