"""The controllers of a comparison, made for a scenario."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from adaptive_ff.adaptive.controller import AdaptiveController, UnsupervisedController
from adaptive_ff.adaptive.settings import FASTEST
from adaptive_ff.baselines.canudas import CanudasController, CanudasMeasuredController
from adaptive_ff.baselines.feedback_error import FeedbackErrorLearning
from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.baselines.observed_model import ObservedModel
from adaptive_ff.baselines.paper import PaperController
from adaptive_ff.comparison.fixed_models import FORMS, SOURCES, fixed_model
from adaptive_ff.comparison.literature import (
    make_friction_observer,
    make_lee_tomizuka,
    make_lugre_gradient,
    make_lugre_observer,
    make_maxwell_adaptive,
    make_radial_basis,
    make_repetitive,
    make_super_twisting,
)
from adaptive_ff.comparison.observer_bandwidth import observer_bandwidth
from adaptive_ff.comparison.oracle import make_oracle, make_oracle_tuned
from adaptive_ff.comparison.own import Own, make_own
from adaptive_ff.comparison.own_bandwidth import in_own_loop
from adaptive_ff.errors import InputError
from adaptive_ff.friction.model import ESTIMATED, WITH_OFFSET, TorqueModel
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.scenario.truth import true_model
from controllers import PI, DisturbanceObserver, ExtendedState, KalmanDisturbance

Maker = Callable[[Scenario], Any]
"""Makes a controller, any object with a method ``step``, for a scenario."""


def _pi(scenario: Scenario) -> PI:
    return PI(*scenario.feedback.gains, scenario.sampling.period, delay=scenario.assumed_delay)


def _with_model(scenario: Scenario, model: TorqueModel) -> ModelBased:
    return ModelBased(
        *scenario.feedback.gains,
        scenario.sampling.period,
        model,
        delay=scenario.assumed_delay,
        velocity_lag=scenario.velocity_lag,
    )


def _inertia_feedforward(scenario: Scenario) -> ModelBased:
    return _with_model(scenario, TorqueModel(scenario.feedback.inertia, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0))


def _fixed(scenario: Scenario) -> ModelBased:
    return _with_model(scenario, scenario.fixed.model)


def _assumed(scenario: Scenario) -> dict[str, Any]:
    """Return what an identifying controller assumes of the joint and its drive, and nothing else."""
    return {
        "period": scenario.sampling.period,
        "inertia": scenario.feedback.inertia,
        "stribeck_velocity": scenario.adaptation.stribeck_velocity,
        "stribeck_shape": scenario.adaptation.stribeck_shape,
        "delay": scenario.assumed_delay,
    }


def _with_memory(assumed: dict[str, Any], memory: float | None) -> dict[str, Any]:
    """Return what is assumed, with a memory where the scenario gives one."""
    return assumed if memory is None else {**assumed, "memory": memory}


PAPER_MEMORY = 3.0
"""Memory of ``adaptive_paper``, s, where the scenario gives none; found best over 100 Hz and 1 kHz together.

On 16 joints drawn around the built-in one (``adaptive-ff sweep``, seed 101): at 1 kHz 3 s beats all from 0.3 to 100 s;
at 100 Hz anything from 3 s on does about as well.
"""

DEAD_ZONE = 0.3
"""Dead zone of ``canudas``, as a share of the assumed Stribeck velocity."""

MEASURED_DEAD_ZONE = 0.1
"""The same of ``canudas_measured``, which compensates in proportion to the velocity there."""


def _adaptive_paper(scenario: Scenario) -> PaperController:
    memory = scenario.adaptation.memory or PAPER_MEMORY
    return PaperController(*scenario.feedback.gains, **_assumed(scenario), memory=memory)


def _canudas_assumed(scenario: Scenario, dead_zone: float) -> dict[str, Any]:
    assumed = {
        "period": scenario.sampling.period,
        "inertia": scenario.feedback.inertia,
        "dead_zone": dead_zone * scenario.adaptation.stribeck_velocity,
        "delay": scenario.assumed_delay,
    }
    return _with_memory(assumed, scenario.adaptation.memory)


def _canudas(scenario: Scenario) -> CanudasController:
    return CanudasController(*scenario.feedback.gains, **_canudas_assumed(scenario, DEAD_ZONE))


def _canudas_measured(scenario: Scenario) -> CanudasMeasuredController:
    return CanudasMeasuredController(*scenario.feedback.gains, **_canudas_assumed(scenario, MEASURED_DEAD_ZONE))


def _feedback_error(scenario: Scenario) -> FeedbackErrorLearning:
    return FeedbackErrorLearning(*scenario.feedback.gains, **_assumed(scenario))


def _adaptive_settings(scenario: Scenario, default: Sequence[str]) -> dict[str, Any]:
    assumed = _with_memory(_assumed(scenario), scenario.adaptation.memory)
    return assumed | {
        "parameters": scenario.adaptation.parameters or default,
        "velocity_lag": scenario.velocity_lag,
        "ripple_periods": scenario.adaptation.ripple_periods,
    }


def make_adaptive(scenario: Scenario, **options: Any) -> AdaptiveController:
    """Make the adaptive controller as a scenario asks for it, with further options of :class:`AdaptiveController`."""
    gains = scenario.feedback.gains
    fastest = FASTEST / (2.0 * math.pi)
    bounded = scenario.velocity_lag == 0.0  # else it is told the lag
    bandwidth = min(observer_bandwidth(scenario, 1.7, DisturbanceObserver.design, *gains, bounded=bounded), fastest)
    assumed = scenario.adaptation
    settings = _adaptive_settings(scenario, WITH_OFFSET) | {
        "position_periods": scenario.friction_periods,
        "position_hats": assumed.position_hats,
        "position_range": assumed.position_range,
        "load_friction": assumed.load_friction,
    }
    settings |= {"observer_bandwidth": bandwidth, **options}
    return AdaptiveController(*gains, **settings)


def _adaptive_unsupervised(scenario: Scenario) -> UnsupervisedController:
    return UnsupervisedController(*scenario.feedback.gains, **_adaptive_settings(scenario, ESTIMATED))


def make_disturbance_observer(scenario: Scenario, share: float = 1.7) -> DisturbanceObserver:
    """Make a PI loop with a disturbance observer; the share did best in ``python -m benchmarks.tuning``."""
    gains, inertia = scenario.feedback.gains, scenario.feedback.inertia
    bandwidth = observer_bandwidth(scenario, share, DisturbanceObserver.design, *gains)
    period, delay = scenario.sampling.period, scenario.assumed_delay
    return DisturbanceObserver(*gains, period, inertia=inertia, bandwidth=bandwidth, delay=delay)


def make_extended_state(scenario: Scenario, share: float = 3.4) -> ExtendedState:
    """Make a loop with an extended state observer; the share did best in ``python -m benchmarks.tuning``."""
    proportional, inertia = scenario.feedback.gains[0], scenario.feedback.inertia
    bandwidth = observer_bandwidth(scenario, share, ExtendedState.design, proportional)
    period, delay = scenario.sampling.period, scenario.assumed_delay
    return ExtendedState(proportional, period, inertia=inertia, bandwidth=bandwidth, delay=delay)


def make_kalman_disturbance(scenario: Scenario, share: float = 2.4) -> KalmanDisturbance:
    """Make a PI loop with a Kalman disturbance estimate; the share did best in ``python -m benchmarks.tuning``."""
    gains, inertia, period = scenario.feedback.gains, scenario.feedback.inertia, scenario.sampling.period
    noise = scenario.velocity_noise or 1.0  # only its ratio to the walk matters
    bandwidth = observer_bandwidth(scenario, share, KalmanDisturbance.design, *gains)
    walk = KalmanDisturbance.walk(inertia, period, noise, bandwidth)
    first, second = KalmanDisturbance.gains(inertia, period, noise, walk)
    settings = {"inertia": inertia, "velocity_gain": first, "disturbance_gain": second, "delay": scenario.assumed_delay}
    return KalmanDisturbance(*gains, period, **settings)


def make_observed(scenario: Scenario, source: str, share: float) -> ObservedModel:
    """Make a fixed feedforward with lag and an observer around it.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    source : str
        Source of the fixed model, see ``fixed_models``.
    share : float
        Bandwidth of the observer over the balance, as found by ``python -m benchmarks.tuning``.
    """
    model = fixed_model(scenario, true_model(scenario), "lagged", source)
    gains, period, delay = scenario.feedback.gains, scenario.sampling.period, scenario.assumed_delay
    bandwidth = observer_bandwidth(scenario, share, DisturbanceObserver.design, *gains)
    return ObservedModel(*gains, period, model, bandwidth=bandwidth, delay=delay)


def make_observed_nominal(scenario: Scenario, share: float = 0.28) -> ObservedModel:
    """Make an observer around a feedforward from nominal parameters."""
    return make_observed(scenario, "nominal", share)


def make_observed_batch(scenario: Scenario, share: float = 0.1) -> ObservedModel:
    """Make an observer around a feedforward identified in a calibration run.

    Where the model is right the slowest observer is the best; twice as fast as the slowest of the search costs 1 %
    there, and follows loads and changes sooner.
    """
    return make_observed(scenario, "batch", share)


def _fixed_maker(form: str, source: str) -> Maker:
    def make(scenario: Scenario) -> ModelBased:
        return _with_model(scenario, fixed_model(scenario, true_model(scenario), form, source))

    return make


FIXED: dict[str, Maker] = {f"{form}_{source}": _fixed_maker(form, source) for form in FORMS for source in SOURCES}
del FIXED["lagged_true"]  # that is the oracle, which follows changes as well


CONTROLLERS: dict[str, Maker] = {
    "pi": _pi,
    "pi_inertia": _inertia_feedforward,
    "fixed": _fixed,
    "oracle": make_oracle,
    "oracle_tuned": make_oracle_tuned,
    "disturbance_observer": make_disturbance_observer,
    "extended_state": make_extended_state,
    "kalman_disturbance": make_kalman_disturbance,
    "observed_nominal": make_observed_nominal,
    "observed_batch": make_observed_batch,
    "adaptive_paper": _adaptive_paper,
    "adaptive_unsupervised": _adaptive_unsupervised,
    "adaptive": make_adaptive,
    "canudas": _canudas,
    "canudas_measured": _canudas_measured,
    "feedback_error": _feedback_error,
    "lugre_observer": make_lugre_observer,
    "lugre_gradient": make_lugre_gradient,
    "friction_observer": make_friction_observer,
    "lee_tomizuka": make_lee_tomizuka,
    "maxwell_adaptive": make_maxwell_adaptive,
    "radial_basis": make_radial_basis,
    "super_twisting": make_super_twisting,
    "repetitive": make_repetitive,
    **FIXED,
}
"""Controllers by name."""


def loop_of(scenario: Scenario, name: str, own: Mapping[str, Own] | None = None) -> Scenario:
    """Return the scenario that a controller is made for: with its own best bandwidth where the file says ``auto``.

    Own controllers are given the bandwidth that suits ``pi``: they may be objects that cannot be made anew.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    name : str
        Name of the controller.
    own : mapping, optional
        Further controllers by name.

    Raises
    ------
    InputError
        There is no controller of that name; the message lists those there are.
    """
    own = own or {}
    if name in own:
        return in_own_loop(scenario, _pi)
    if name not in CONTROLLERS:
        raise InputError(f"controllers = {name!r} is not known; there are {', '.join([*CONTROLLERS, *own])}")
    return in_own_loop(scenario, CONTROLLERS[name])


def make_for_machine(scenario: Scenario, name: str) -> Any:
    """Make a controller of the package as it is to run on a machine: the adaptive one is told the limit of the drive.

    In a comparison the simulated drive reports what it gave; a machine may not. A scenario need not have a limit: one
    that is identified from a log has none.
    """
    if name == "adaptive":
        limit = scenario.actuator.torque_limit
        return make_adaptive(loop_of(scenario, name), **({} if limit is None else {"torque_limit": limit}))
    return make_controller(scenario, name)


def make_controller(scenario: Scenario, name: str, own: Mapping[str, Own] | None = None) -> Any:
    """Make a controller for a scenario.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    name : str
        Name of the controller.
    own : mapping, optional
        Further controllers by name; see :func:`~adaptive_ff.comparison.own.make_own`.

    Raises
    ------
    InputError
        There is no controller of that name; the message lists those there are.
    """
    loop = loop_of(scenario, name, own)
    if own and name in own:
        return make_own(name, own[name], loop)
    return CONTROLLERS[name](loop)
