"""A controller whose observer has come to a state that it cannot have come to."""

from adaptive_ff import load_scenario
from adaptive_ff.comparison.registry import make_controller


def with_effect(name, value):
    """Return the built-in scenario's controller with a field of its observer's effect changed, or a ``part.field``."""
    controller = make_controller(load_scenario(), "adaptive")
    state, observer = controller.state, controller.state.observer
    part, _, field = name.rpartition(".")
    changed = getattr(observer.effect, part)._replace(**{field: value}) if part else value
    effect = observer.effect._replace(**{part or field: changed})
    controller.state = state._replace(observer=observer._replace(effect=effect))
    return controller
