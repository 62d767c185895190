"""The controllers of a comparison by name, each made for a scenario by a factory of one argument.

What the sources leave open did best in ``python -m benchmarks.tuning``, on other joints and seeds; the factories take
it as keyword arguments. Two rates are slower than the best of that search, which hold with little to spare:
``radial_basis`` where a drive is late, and ``lugre_gradient`` by a factor of four below the rate at which it loses its
stability.
"""

import inspect
import math
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from adaptive_ff.adaptive.controller import AdaptiveController
from adaptive_ff.adaptive.tuning import Tuning
from adaptive_ff.baselines.canudas import CanudasController, CanudasMeasuredController
from adaptive_ff.baselines.feedback_error import FeedbackErrorLearning
from adaptive_ff.baselines.friction_observer import FrictionObserver
from adaptive_ff.baselines.learnt_feedforward import LearntFeedforward
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
from adaptive_ff.comparison.oracle import make_oracle, make_oracle_tuned
from adaptive_ff.comparison.own import Own, make_own
from adaptive_ff.comparison.own_bandwidth import in_own_loop, plain_pi
from adaptive_ff.errors import InputError
from adaptive_ff.friction.model import WITH_GRAVITY, TorqueModel
from adaptive_ff.scenario.reference import Multisine
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.scenario.truth import true_model
from controllers import DisturbanceObserver, ExtendedState, KalmanDisturbance, SuperTwisting

Made = TypeVar("Made")

Maker = Callable[[Scenario], Any]
"""Makes a controller, any object with a method ``step``, for a scenario."""

PAPER_MEMORY = 3.0
"""Memory of ``adaptive_paper``, s, where the scenario gives none."""

DEAD_ZONE, MEASURED_DEAD_ZONE = 0.3, 0.1
"""Dead zones of ``canudas`` and ``canudas_measured``, over the assumed Stribeck velocity."""

REACHES = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)
"""Reaches of the stop operators, over the displacement at ``Vs`` in a time constant of the feedback."""

CENTRES = (-20.0, -6.0, -2.0, -0.6, -0.2, 0.2, 0.6, 2.0, 6.0, 20.0)
"""Centres of the bells, over ``Vs``."""

SHORTEST_REPEATS = 3
"""Periods of a motion that a run must hold for it to be worth learning."""

QUIET = 0.02
"""Least noise that a super-twisting observer is set for, over ``Vs``."""


def made_for(scenario: Scenario, kind: Callable[..., Made], **given: Any) -> Made:
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


def _nominal(scenario: Scenario, form: str = "lagged") -> TorqueModel:
    return fixed_model(scenario, true_model(scenario), form, "nominal")


def fixed(form: str, source: str) -> Maker:
    """Return the factory of the feedforward from a fixed model, of one of ``FORMS`` and from one of ``SOURCES``."""
    return lambda scenario: made_for(
        scenario, ModelBased, model=fixed_model(scenario, true_model(scenario), form, source)
    )


def make_adaptive(scenario: Scenario, **options: Any) -> AdaptiveController:
    """Make the adaptive controller as a scenario asks for it, with further options of :class:`AdaptiveController`."""
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
    return made_for(scenario, AdaptiveController, **{**settings, **options})


def _without_observer(scenario: Scenario) -> AdaptiveController:
    return make_adaptive(scenario, tuning=Tuning(gate_on=-1e300))


def _canudas(kind: Any, dead_zone: float) -> Maker:
    return lambda scenario: made_for(scenario, kind, dead_zone=dead_zone * scenario.adaptation.stribeck_velocity)


def make_disturbance_observer(scenario: Scenario, multiple: float = 1.7) -> DisturbanceObserver:
    """Make a PI loop with a disturbance observer, whose bandwidth is a fraction of the balance."""
    bandwidth = observer_bandwidth(scenario, multiple, DisturbanceObserver.design, *scenario.feedback.gains)
    return made_for(scenario, DisturbanceObserver, bandwidth=bandwidth)


def make_extended_state(scenario: Scenario, multiple: float = 3.4) -> ExtendedState:
    """Make a loop with an extended state observer, whose bandwidth is a fraction of the balance."""
    bandwidth = observer_bandwidth(scenario, multiple, ExtendedState.design, scenario.feedback.gains[0])
    return made_for(scenario, ExtendedState, bandwidth=bandwidth)


def _kalman_gains(scenario: Scenario, inertia: float, multiple: float) -> dict[str, float]:
    noise = scenario.velocity_noise or 1.0  # only its ratio to the walk matters
    bandwidth = observer_bandwidth(scenario, multiple, KalmanDisturbance.design, *scenario.feedback.gains)
    walk = KalmanDisturbance.walk(inertia, scenario.sampling.period, noise, bandwidth)
    first, second = KalmanDisturbance.gains(inertia, scenario.sampling.period, noise, walk)
    return {"velocity_gain": first, "disturbance_gain": second}


def make_kalman_disturbance(scenario: Scenario, multiple: float = 2.4) -> KalmanDisturbance:
    """Make a PI loop with a Kalman disturbance estimate, whose bandwidth is a fraction of the balance."""
    return made_for(scenario, KalmanDisturbance, **_kalman_gains(scenario, scenario.feedback.inertia, multiple))


def _observed(scenario: Scenario, source: str, multiple: float) -> ObservedModel:
    model = fixed_model(scenario, true_model(scenario), "lagged", source)
    bandwidth = observer_bandwidth(scenario, multiple, DisturbanceObserver.design, *scenario.feedback.gains)
    return made_for(scenario, ObservedModel, model=model, bandwidth=bandwidth)


def make_observed_nominal(scenario: Scenario, multiple: float = 0.28) -> ObservedModel:
    """Make an observer around a feedforward from nominal parameters."""
    return _observed(scenario, "nominal", multiple)


def make_observed_batch(scenario: Scenario, multiple: float = 0.1) -> ObservedModel:
    """Make an observer around a feedforward identified in a calibration run."""
    return _observed(scenario, "batch", multiple)


def learning_rate(scenario: Scenario, multiple: float, caution: float) -> float:
    """Compute a fraction of the feedback's crossover, 1/s, less where a delay of the drive makes the loop late."""
    return multiple / (response_time(scenario) + caution * scenario.assumed_delay * scenario.sampling.period)


def make_maxwell_adaptive(
    scenario: Scenario, rate: float = 1.0, reaches: tuple[float, ...] = REACHES, caution: float = 5.0
) -> LearntFeedforward:
    """Make an adaptive Maxwell-slip compensation; rate and caution are those of ``learning_rate``."""
    displacements = [reach * assumed_displacement(scenario) for reach in reaches]
    rate = learning_rate(scenario, rate, caution)
    return made_for(scenario, LearntFeedforward, reaches=displacements, rate=rate)


def make_radial_basis(
    scenario: Scenario, rate: float = 6.0, lag: float = 2.0, caution: float = 20.0
) -> LearntFeedforward:
    """Make a radial-basis feedforward; rate and caution are those of ``learning_rate``, the lag in time constants."""
    bells = {"centres": CENTRES, "lag": lag * response_time(scenario)}
    rate = learning_rate(scenario, rate, caution)
    return made_for(scenario, LearntFeedforward, rate=rate, **bells)


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


def make_repetitive(scenario: Scenario, gain: float = 0.9, lead: float = 0.5) -> Repetitive:
    """Make a repetitive feedforward; the lead is in time constants of the feedback."""
    period, cycle = scenario.sampling.period, cycle_of(scenario)
    samples = math.ceil(lead * response_time(scenario) / period + scenario.assumed_delay - 1e-9)
    places = {"cycle": cycle, "lead": min(samples, max(cycle - 1, 0))}
    return made_for(scenario, Repetitive, gain=gain, **places)


def make_lugre_observer(scenario: Scenario, way: float = 0.3, gain: float = 1.0) -> LuGreObserver:
    """Make a LuGre observer from nominal parameters; it breaks away after a displacement in the unit of ``REACHES``."""
    model = _nominal(scenario)
    stiffness = model.stiction / (way * assumed_displacement(scenario))
    return made_for(scenario, LuGreObserver, model=model, stiffness=stiffness, gain=gain)


def make_lugre_gradient(scenario: Scenario, rate: float = 0.8, way: float = 0.3, floor: float = 1.2) -> LuGreGradient:
    """Make a LuGre feedforward tuned by gradient; the rate is a fraction of the crossover, the way as above."""
    torque = scenario.feedback.gains[0] * scenario.adaptation.stribeck_velocity
    settings = {"stiffness": torque / (way * assumed_displacement(scenario)), "rate": rate / response_time(scenario)}
    return made_for(scenario, LuGreGradient, floor=floor, **settings)


def make_friction_observer(scenario: Scenario, stretch: float = 1.0, multiple: float = 0.2) -> FrictionObserver:
    """Make a feed-forward friction observer from nominal parameters.

    ``stretch`` is the assumed presliding displacement over the nominal one.
    """
    model, presliding = _nominal(scenario), stretch * nominal_presliding(scenario)
    gains = _kalman_gains(scenario, model.inertia, multiple)
    return made_for(scenario, FrictionObserver, model=model, presliding=presliding, **gains)


def make_lee_tomizuka(
    scenario: Scenario, form: str = "coulomb", multiple: float = 6.0, integrates: bool = False
) -> LeeTomizuka:
    """Make Lee and Tomizuka's controller from nominal parameters, of form ``coulomb`` or ``stribeck``.

    Whether it integrates says whether the integral of the PI loop stands beside the observer.
    """
    gains = scenario.feedback.gains if integrates else (scenario.feedback.gains[0], 0.0)
    # behind a position loop, which it was made for, the bound on the margin makes it worse
    bounded = scenario.position is None
    bandwidth = observer_bandwidth(scenario, multiple, DisturbanceObserver.design, *gains, bounded=bounded)
    settings = {"integral": gains[1], "bandwidth": bandwidth}
    return made_for(scenario, LeeTomizuka, model=_nominal(scenario, form), **settings)


def make_super_twisting(scenario: Scenario, multiple: float = 40.0) -> SuperTwisting:
    """Make a super-twisting observer: ``L`` is a multiple of noise times the square of the feedback's crossover."""
    noise = max(scenario.velocity_noise, QUIET * scenario.adaptation.stribeck_velocity)
    bound = multiple * noise / response_time(scenario) ** 2
    return made_for(scenario, SuperTwisting, bound=bound)


# of the true parameters with their lag there is the oracle, which follows changes as well
FIXED = {f"{f}_{s}": fixed(f, s) for f in FORMS for s in SOURCES if (f, s) != ("lagged", "true")}
"""Feedforwards from fixed models by name."""

CONTROLLERS: dict[str, Maker] = {
    "pi": plain_pi,
    "pi_inertia": lambda scenario: made_for(
        scenario, ModelBased, model=TorqueModel(scenario.feedback.inertia, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0)
    ),
    "fixed": lambda scenario: made_for(scenario, ModelBased, model=scenario.fixed.model),
    "oracle": make_oracle,
    "oracle_tuned": make_oracle_tuned,
    "disturbance_observer": make_disturbance_observer,
    "extended_state": make_extended_state,
    "kalman_disturbance": make_kalman_disturbance,
    "observed_nominal": make_observed_nominal,
    "observed_batch": make_observed_batch,
    "adaptive_paper": lambda scenario: made_for(
        scenario, PaperController, memory=scenario.adaptation.memory or PAPER_MEMORY
    ),
    "adaptive_unsupervised": _without_observer,
    "adaptive": make_adaptive,
    "canudas": _canudas(CanudasController, DEAD_ZONE),
    "canudas_measured": _canudas(CanudasMeasuredController, MEASURED_DEAD_ZONE),
    "feedback_error": lambda scenario: made_for(scenario, FeedbackErrorLearning),
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
"""Factories by the names that scenarios, command line and results know."""


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
