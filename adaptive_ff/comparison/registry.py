"""The controllers of a comparison by name, each made for a scenario by a factory of one argument.

What the sources leave open did best in ``python -m benchmarks run tuning``, on other joints and seeds; the factories
take it as arguments. Two rates are slower than the best of that search, which hold with little to spare:
``radial_basis`` where a drive is late, and ``lugre_gradient`` by a factor of four below the rate at which it loses its
stability.
"""

import inspect
import math
from collections.abc import Callable, Mapping
from typing import Any

from adaptive_ff.adaptive.controller import AdaptiveController
from adaptive_ff.adaptive.tuning import Tuning
from adaptive_ff.baselines.canudas import CanudasController, CanudasMeasuredController
from adaptive_ff.baselines.feedback_learning import FeedbackErrorLearning, LearntFeedforward
from adaptive_ff.baselines.friction_observer import FrictionObserver
from adaptive_ff.baselines.lee_tomizuka import LeeTomizuka
from adaptive_ff.baselines.lugre_gradient import LuGreGradient
from adaptive_ff.baselines.lugre_observer import LuGreObserver
from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.baselines.observed_model import ObservedModel
from adaptive_ff.baselines.paper import PaperController
from adaptive_ff.baselines.repetitive import Repetitive
from adaptive_ff.comparison.fixed_models import (
    FORMS,
    SOURCES,
    assumed_displacement,
    fixed_model,
    nominal_presliding,
    response_time,
)
from adaptive_ff.comparison.observer_bandwidth import observer_bandwidth
from adaptive_ff.comparison.oracle import make_oracle, suitable_lag
from adaptive_ff.comparison.own import Own, make_own
from adaptive_ff.comparison.own_bandwidth import in_own_loop, plain_pi
from adaptive_ff.errors import InputError
from adaptive_ff.friction.model import WITH_GRAVITY, TorqueModel
from adaptive_ff.scenario.reference import Multisine
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.scenario.truth import true_model
from controllers import DisturbanceObserver, ExtendedState, KalmanDisturbance, SuperTwisting

Maker = Callable[..., Any]
"""Makes a controller, any object with a method ``step``, for a scenario."""

Settings = Callable[..., dict[str, Any]]
"""Returns arguments of a controller by name for a scenario."""

PAPER_MEMORY = 3.0
"""Memory of ``adaptive_paper``, s, where the scenario gives none."""

REACHES = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)
"""Reaches of the stop operators, over the displacement at ``Vs`` in a time constant of the feedback."""

CENTRES = (-20.0, -6.0, -2.0, -0.6, -0.2, 0.2, 0.6, 2.0, 6.0, 20.0)
"""Centres of the bells, over ``Vs``."""

SHORTEST_REPEATS = 3
"""Periods of a motion that a run must hold for it to be worth learning."""

QUIET = 0.02
"""Least noise that a super-twisting observer is set for, over ``Vs``."""


def made_for(scenario: Scenario, kind: Callable[..., Any], **given: Any) -> Any:
    """Make a controller with those of its arguments that the loop of a scenario knows, and further ones."""
    assumed = scenario.adaptation
    known = {
        "proportional": scenario.feedback.gains[0],
        "integral": scenario.feedback.gains[1],
        "period": scenario.sampling.period,
        "inertia": scenario.feedback.inertia,
        "stribeck_velocity": assumed.stribeck_velocity,
        "stribeck_shape": assumed.stribeck_shape,
        "delay": scenario.assumed_delay,
        "velocity_lag": scenario.velocity_lag,
        **({} if assumed.memory is None else {"memory": assumed.memory}),
    }
    names = inspect.signature(kind).parameters
    return kind(**{**{name: value for name, value in known.items() if name in names}, **given})


CONTROLLERS: dict[str, Maker] = {"pi": plain_pi}
"""Factories by the names that scenarios, command line and results know."""


def made_of(kind: Callable[..., Any], name: str = "") -> Callable[[Settings], Settings]:
    """Return a decorator that registers a factory: the function returns those settings that a scenario leaves open."""

    def register(settings: Settings) -> Settings:
        def make(scenario: Scenario, *chosen: Any, **named: Any) -> Any:
            return made_for(scenario, kind, **settings(scenario, *chosen, **named))

        CONTROLLERS[name or settings.__name__] = make
        return settings

    return register


def _model(scenario: Scenario, form: str = "lagged", source: str = "nominal") -> TorqueModel:
    return fixed_model(scenario, true_model(scenario), form, source)


@made_of(ModelBased)
def pi_inertia(scenario: Scenario) -> dict[str, Any]:
    """PI and the torque of the inertia alone."""
    return {"model": TorqueModel(scenario.feedback.inertia, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0)}


made_of(ModelBased, "fixed")(lambda scenario: {"model": scenario.fixed.model})
CONTROLLERS["oracle"] = make_oracle
CONTROLLERS["oracle_tuned"] = lambda scenario: make_oracle(scenario, suitable_lag(scenario))


@made_of(DisturbanceObserver)
def disturbance_observer(scenario: Scenario, multiple: float = 1.7) -> dict[str, Any]:
    """PI and a disturbance observer, whose bandwidth is a multiple of the balance."""
    return {"bandwidth": observer_bandwidth(scenario, multiple, DisturbanceObserver.design, *scenario.feedback.gains)}


@made_of(ExtendedState)
def extended_state(scenario: Scenario, multiple: float = 3.4) -> dict[str, Any]:
    """Extended state observer, whose bandwidth is a multiple of the balance."""
    return {"bandwidth": observer_bandwidth(scenario, multiple, ExtendedState.design, scenario.feedback.gains[0])}


@made_of(KalmanDisturbance)
def kalman_disturbance(scenario: Scenario, multiple: float = 2.4, inertia: float | None = None) -> dict[str, float]:
    """PI and a Kalman disturbance estimate for an inertia (kg m^2), whose bandwidth is a multiple of the balance."""
    known = (scenario.feedback.inertia if inertia is None else inertia), scenario.sampling.period
    noise = scenario.velocity_noise or 1.0  # only its ratio to the walk matters
    bandwidth = observer_bandwidth(scenario, multiple, KalmanDisturbance.design, *scenario.feedback.gains)
    first, second = KalmanDisturbance.gains(*known, noise, KalmanDisturbance.walk(*known, noise, bandwidth))
    return {"velocity_gain": first, "disturbance_gain": second}


@made_of(ObservedModel)
def observed_nominal(scenario: Scenario, multiple: float = 0.28, source: str = "nominal") -> dict[str, Any]:
    """Observer around a feedforward from nominal parameters."""
    return {"model": _model(scenario, source=source), **disturbance_observer(scenario, multiple)}


@made_of(ObservedModel)
def observed_batch(scenario: Scenario, multiple: float = 0.1) -> dict[str, Any]:
    """Observer around a feedforward identified in a calibration run."""
    return observed_nominal(scenario, multiple, "batch")


made_of(PaperController, "adaptive_paper")(lambda scenario: {"memory": scenario.adaptation.memory or PAPER_MEMORY})


def adaptive(scenario: Scenario, **options: Any) -> dict[str, Any]:
    """Adaptive controller as a scenario asks for it, with further options of :class:`AdaptiveController`."""
    assumed = scenario.adaptation
    settings = {
        "parameters": assumed.parameters or WITH_GRAVITY,
        "ripple_periods": assumed.ripple_periods,
        "position_periods": scenario.friction_periods,
        "position_hats": assumed.position_hats,
        "position_range": assumed.position_range,
        "load_friction": assumed.load_friction,
        "friction_share": assumed.friction_share,
    }
    return {**settings, **options}


made_of(AdaptiveController, "adaptive_unsupervised")(
    lambda scenario: adaptive(scenario, tuning=Tuning(explained=1e300))  # without its observer
)
made_of(AdaptiveController)(adaptive)
make_adaptive = CONTROLLERS["adaptive"]


@made_of(CanudasController)
def canudas(scenario: Scenario, dead_zone: float = 0.3) -> dict[str, Any]:
    """Compensation of Canudas along the reference; the dead zone is over the assumed Stribeck velocity."""
    return {"dead_zone": dead_zone * scenario.adaptation.stribeck_velocity}


made_of(CanudasMeasuredController, "canudas_measured")(lambda scenario: canudas(scenario, 0.1))
made_of(FeedbackErrorLearning, "feedback_error")(lambda scenario: {})


@made_of(LuGreObserver)
def lugre_observer(scenario: Scenario, way: float = 0.3, gain: float = 1.0) -> dict[str, Any]:
    """LuGre observer from nominal parameters; it breaks away after a displacement in the unit of ``REACHES``."""
    model = _model(scenario)
    return {"model": model, "stiffness": model.stiction / (way * assumed_displacement(scenario)), "gain": gain}


@made_of(LuGreGradient)
def lugre_gradient(scenario: Scenario, rate: float = 0.8, way: float = 0.3, floor: float = 1.2) -> dict[str, Any]:
    """LuGre feedforward tuned by gradient; the rate is a fraction of the crossover, the way as above."""
    stiffness = scenario.feedback.gains[0] * scenario.adaptation.stribeck_velocity
    stiffness /= way * assumed_displacement(scenario)
    return {"stiffness": stiffness, "rate": rate / response_time(scenario), "floor": floor}


@made_of(FrictionObserver)
def friction_observer(scenario: Scenario, stretch: float = 1.0, multiple: float = 0.2) -> dict[str, Any]:
    """Feed-forward friction observer from nominal parameters, presliding displacement and a stretch of it."""
    model, presliding = _model(scenario), stretch * nominal_presliding(scenario)
    return {"model": model, "presliding": presliding, **kalman_disturbance(scenario, multiple, model.inertia)}


@made_of(LeeTomizuka)
def lee_tomizuka(
    scenario: Scenario, form: str = "coulomb", multiple: float = 6.0, integrates: bool = False
) -> dict[str, Any]:
    """Lee and Tomizuka's controller from nominal parameters, of form ``coulomb`` or ``stribeck``.

    Whether it integrates says whether the integral of the PI loop stands beside the observer.
    """
    gains = scenario.feedback.gains if integrates else (scenario.feedback.gains[0], 0.0)
    # behind a position loop, which it was made for, the bound on the margin makes it worse
    bounded = scenario.position is None
    bandwidth = observer_bandwidth(scenario, multiple, DisturbanceObserver.design, *gains, bounded=bounded)
    return {"integral": gains[1], "bandwidth": bandwidth, "model": _model(scenario, form)}


def learning_rate(scenario: Scenario, multiple: float, caution: float) -> float:
    """Compute a fraction of the feedback's crossover, 1/s, less where a delay of the drive makes the loop late."""
    return multiple / (response_time(scenario) + caution * scenario.assumed_delay * scenario.sampling.period)


@made_of(LearntFeedforward)
def maxwell_adaptive(
    scenario: Scenario, rate: float = 1.0, reaches: tuple[float, ...] = REACHES, caution: float = 5.0
) -> dict[str, Any]:
    """Adaptive Maxwell-slip compensation; rate and caution are those of ``learning_rate``."""
    displacements = [reach * assumed_displacement(scenario) for reach in reaches]
    return {"reaches": displacements, "rate": learning_rate(scenario, rate, caution)}


@made_of(LearntFeedforward)
def radial_basis(scenario: Scenario, rate: float = 6.0, lag: float = 2.0, caution: float = 20.0) -> dict[str, Any]:
    """Radial-basis feedforward; rate and caution are those of ``learning_rate``, the lag in time constants."""
    bells = {"centres": CENTRES, "lag": lag * response_time(scenario)}
    return {"rate": learning_rate(scenario, rate, caution), **bells}


@made_of(SuperTwisting)
def super_twisting(scenario: Scenario, multiple: float = 40.0) -> dict[str, Any]:
    """Super-twisting observer: ``L`` is a multiple of noise times the square of the feedback's crossover."""
    noise = max(scenario.velocity_noise, QUIET * scenario.adaptation.stribeck_velocity)
    return {"bound": multiple * noise / response_time(scenario) ** 2}


def cycle_of(scenario: Scenario) -> int:
    """Return the samples in a period of the scenario's reference; zero where it has none that repeats in the run.

    A machine that repeats a motion knows its period; here it is that of the multisine's frequencies.
    """
    reference = scenario.reference
    if not isinstance(reference, Multisine):
        return 0
    slowest = min(reference.frequencies)
    for count in range(1, 101):
        length = count / slowest
        if SHORTEST_REPEATS * length > scenario.length:
            return 0
        samples = length / scenario.sampling.period
        whole = [abs(length * frequency - round(length * frequency)) < 1e-6 for frequency in reference.frequencies]
        if all(whole) and abs(samples - round(samples)) < 1e-6:
            return round(samples)
    return 0


@made_of(Repetitive)
def repetitive(scenario: Scenario, gain: float = 0.9, lead: float = 0.5) -> dict[str, Any]:
    """Repetitive feedforward; the lead is in time constants of the feedback."""
    period, cycle = scenario.sampling.period, cycle_of(scenario)
    samples = math.ceil(lead * response_time(scenario) / period + scenario.assumed_delay - 1e-9)
    return {"cycle": cycle, "lead": min(samples, max(cycle - 1, 0)), "gain": gain}


# of the true parameters with their lag there is the oracle, which follows changes as well
FIXED = {f"{f}_{s}": (f, s) for f in FORMS for s in SOURCES if (f, s) != ("lagged", "true")}
"""Forms and sources of the feedforwards from fixed models, by name."""

for _name, (_form, _source) in FIXED.items():
    made_of(ModelBased, _name)(lambda scenario, form=_form, source=_source: {"model": _model(scenario, form, source)})


def loop_of(scenario: Scenario, name: str, own: Mapping[str, Own] | None = None) -> Scenario:
    """Return a scenario in whose loop a controller runs: with the bandwidth that suits it, for ``auto``.

    An own controller (of ``own``, by name) has that of PI.
    """
    own = own or {}
    if name in own:
        return in_own_loop(scenario, CONTROLLERS["pi"])
    if name not in CONTROLLERS:
        raise InputError(f"controllers = {name!r} is not known; there are {', '.join([*CONTROLLERS, *own])}")
    return in_own_loop(scenario, CONTROLLERS[name])


def make_for_machine(scenario: Scenario, name: str) -> Any:
    """Make a controller of the package as it is to run on a machine: the adaptive one knows the limit of the drive.

    In a comparison the simulated drive reports what it gave; a machine may not. A scenario need not have a limit: one
    that is identified from a log has none.
    """
    if name == "adaptive":
        limit = scenario.actuator.torque_limit
        return make_adaptive(loop_of(scenario, name), **({} if limit is None else {"torque_limit": limit}))
    return make_controller(scenario, name)


def make_controller(scenario: Scenario, name: str, own: Mapping[str, Own] | None = None) -> Any:
    """Make a controller for a scenario by its name, an own one by :func:`~adaptive_ff.comparison.own.make_own`."""
    loop = loop_of(scenario, name, own)
    if own and name in own:
        return make_own(name, own[name], loop)
    return CONTROLLERS[name](loop)
