"""The controllers of a comparison, made for a scenario."""

from collections.abc import Callable, Mapping
from typing import Any

from adaptive_ff.adaptive import AdaptiveController
from adaptive_ff.errors import InputError
from adaptive_ff.model import TorqueModel
from adaptive_ff.rivals import ModelBased, PaperController
from adaptive_ff.scenario import Scenario
from controllers import PI

Maker = Callable[[Scenario], Any]
"""Makes a controller, any object with a method ``step``, for a scenario."""


def true_model(scenario: Scenario) -> TorqueModel:
    """Return the true parameters of a scenario's joint as a model."""
    joint = scenario.joint
    return TorqueModel(
        joint.inertia,
        joint.coulomb,
        joint.stiction,
        joint.viscous,
        joint.friction_lag,
        joint.stribeck_velocity,
        joint.stribeck_shape,
    )


def _pi(scenario: Scenario) -> PI:
    return PI(*scenario.feedback.gains, scenario.sampling.period)


def _inertia_feedforward(scenario: Scenario) -> ModelBased:
    model = TorqueModel(scenario.feedback.inertia, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0)
    return ModelBased(*scenario.feedback.gains, scenario.sampling.period, model)


def _fixed(scenario: Scenario) -> ModelBased:
    return ModelBased(*scenario.feedback.gains, scenario.sampling.period, scenario.fixed.model)


def _oracle(scenario: Scenario) -> ModelBased:
    changes = [(change.time, change.friction_scale) for change in scenario.change]
    return ModelBased(*scenario.feedback.gains, scenario.sampling.period, true_model(scenario), changes)


def _told(scenario: Scenario) -> dict[str, Any]:
    """Return what an identifying controller is told, and nothing else."""
    return {
        "period": scenario.sampling.period,
        "inertia": scenario.feedback.inertia,
        "stribeck_velocity": scenario.adaptation.stribeck_velocity,
        "stribeck_shape": scenario.adaptation.stribeck_shape,
        "memory": scenario.adaptation.memory,
    }


def _adaptive_paper(scenario: Scenario) -> PaperController:
    return PaperController(*scenario.feedback.gains, **_told(scenario))


def _adaptive(scenario: Scenario) -> AdaptiveController:
    return AdaptiveController(*scenario.feedback.gains, **_told(scenario))


CONTROLLERS: dict[str, Maker] = {
    "pi": _pi,
    "pi_inertia": _inertia_feedforward,
    "fixed": _fixed,
    "oracle": _oracle,
    "adaptive_paper": _adaptive_paper,
    "adaptive": _adaptive,
}
"""Controllers by name."""


def make_controller(scenario: Scenario, name: str, own: Mapping[str, Maker] | None = None) -> Any:
    """Make a controller for a scenario.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    name : str
        Name of the controller.
    own : mapping, optional
        Further makers by name.

    Raises
    ------
    InputError
        There is no controller of that name; the message lists those there are.
    """
    makers = {**CONTROLLERS, **(own or {})}
    if name not in makers:
        raise InputError(f"controllers = {name!r} is not known; there are {', '.join(makers)}")
    return makers[name](scenario)
