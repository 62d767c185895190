"""The controllers of a comparison by name, each made for a scenario by a factory of one argument.

What the sources leave open did best in ``python -m benchmarks run tuning``, on other joints and seeds; the factories
take it as arguments. Two rates are slower than the best of that search, which are close to instability: that of
``radial_basis`` where a drive is late, and that of ``lugre_gradient``, a quarter of the rate at which it is unstable.
"""

import inspect
import math
from collections.abc import Callable, Mapping
from functools import cache, lru_cache, partial
from typing import Any

import scipy

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
from adaptive_ff.comparison.own import Own, make_own
from adaptive_ff.comparison.own_bandwidth import (
    TUNING_SEEDS,
    Maker,
    find_own_bandwidth,
    plain_pi,
    settled_error,
    with_bandwidth,
)
from adaptive_ff.errors import InputError, check_among
from adaptive_ff.friction.model import WITH_GRAVITY, WITH_OFFSET, TorqueModel
from adaptive_ff.scenario.reference import Multisine
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.scenario.truth import model_changes, true_model
from adaptive_ff.simulation.experiment import build_setup
from controllers import DisturbanceObserver, ExtendedState, KalmanDisturbance, ObserverDesign, SuperTwisting
from controllers.design.observer_design import SLOWEST

signature = cache(inspect.signature)  # of the class of a controller
Settings = Callable[..., dict[str, Any]]  # arguments of a controller by name, for a scenario
PAPER_MEMORY = 3.0  # memory of ``adaptive_paper``, s, where the scenario gives none
REACHES = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)  # of the stop operators, over ``assumed_displacement``
CENTRES = (-20.0, -6.0, -2.0, -0.6, -0.2, 0.2, 0.6, 2.0, 6.0, 20.0)  # centres of the bells, over ``Vs``
SHORTEST_REPEATS = 3  # periods of a motion that a run must hold for it to be worth learning
QUIET = 0.02  # least noise that a super-twisting observer is set for, over ``Vs``
LARGEST_ADDED = 2.0  # largest lag that an oracle adds, sampling periods beside 20 ms
RESOLUTION = 2e-4  # resolution of that lag, s

LARGEST_BEHIND_FILTER = 4.5
"""Largest maximum sensitivity, for the measured velocity, with which an observer is as fast as for the true one.

With 2 the observers alone are up to 1.7 times worse with a fine encoder and its Kalman filter (``encoder``,
``positioning``), where they have 3 to 4.1 with their usual bandwidth; without a bound a fast loop oscillates.
"""


def made_for(scenario: Scenario, kind: Callable[..., Any], **given: Any) -> Any:
    """Make a controller with those of its arguments that the loop of a scenario knows, and further ones."""
    proportional, integral = scenario.feedback.gains
    known = {
        **{name: getattr(scenario.adaptation, name) for name in ("stribeck_velocity", "stribeck_shape", "memory")},
        "proportional": proportional,
        "integral": integral,
        "period": scenario.sampling.period,
        "inertia": scenario.feedback.inertia,
        "delay": scenario.assumed_delay,
        "velocity_lag": scenario.velocity_lag,
        "velocity_noise": scenario.velocity_noise,
    }
    names = signature(kind).parameters
    return kind(**{name: value for name, value in known.items() if name in names and value is not None} | given)


CONTROLLERS: dict[str, Maker] = {"pi": plain_pi}  # factories by the names that scenarios, command line and results know


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


made_of(ModelBased, "pi_inertia")(
    lambda scenario: {"model": TorqueModel(scenario.feedback.inertia, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0)}
)
made_of(ModelBased, "fixed")(lambda scenario: {"model": scenario.fixed.model})


def make_oracle(scenario: Scenario, added: float = 0.0) -> ModelBased:
    """Make the feedforward from the true parameters of every moment, with a lag (s) added to the friction lag.

    It knows the true delay of the drive, too, whatever the feedback assumes.
    """

    def tuned(model: TorqueModel) -> TorqueModel:
        return model._replace(friction_lag=max(0.0, model.friction_lag + added))

    return ModelBased(
        *scenario.feedback.gains,
        scenario.sampling.period,
        tuned(true_model(scenario)),
        [(time, tuned(model)) for time, model in model_changes(scenario)],
        gravity=scenario.joint.weight,
        ripple=(scenario.actuator.ripple_amplitude, scenario.actuator.ripple_period),
        delay=scenario.delay,
        velocity_lag=scenario.velocity_lag,
    )


def suitable_lag(scenario: Scenario) -> float:
    """Return what added to the true friction lag (s) leaves the least settled error on ``TUNING_SEEDS``.

    The true lag is not the best one for a torque that is held over a sampling period.
    """
    return _suitable_lag(scenario.modified(seed=0).model_dump_json(exclude_unset=True))


@lru_cache(maxsize=64)
def _suitable_lag(text: str) -> float:
    scenario = Scenario.model_validate_json(text)
    setups = [build_setup(scenario.modified(seed=seed)) for seed in TUNING_SEEDS]

    def error(added: float) -> float:
        maker = partial(make_oracle, added=float(added))
        return min(1e300, sum(settled_error(scenario, maker, setup) ** 2 for setup in setups))

    lag = true_model(scenario).friction_lag
    bounds = (-lag, LARGEST_ADDED * scenario.sampling.period + 0.02)
    found = scipy.optimize.minimize_scalar(error, bounds=bounds, method="bounded", options={"xatol": RESOLUTION})
    return float(found.x) if found.fun < error(0.0) else 0.0


CONTROLLERS["oracle"] = make_oracle
CONTROLLERS["oracle_tuned"] = lambda scenario: make_oracle(scenario, suitable_lag(scenario))


def balance(scenario: Scenario) -> float:
    """Return the frequency (Hz) at which what friction does and what the noise hides balance.

    It is the bandwidth of a Kalman filter for the noise of the measured velocity and for a disturbance that walks by
    ``Kp Vs``, a torque, in a root of a second; infinite without noise.
    """
    noise = scenario.velocity_noise
    if noise == 0.0:
        return math.inf
    walk = scenario.feedback.gains[0] * scenario.adaptation.stribeck_velocity
    return math.sqrt(walk / (scenario.feedback.inertia * noise * math.sqrt(scenario.sampling.period))) / (2.0 * math.pi)


def observer_bandwidth(
    scenario: Scenario, multiple: float, design: Callable[..., ObserverDesign], *gains: float, bounded: bool = True
) -> float:
    """Return a multiple of the balance, Hz, or the most that a maximum sensitivity of 2 allows where that is less.

    ``design`` is the observer's, with the gains that it takes. Where an encoder's velocity leaves the loop with a
    maximum sensitivity beyond :data:`LARGEST_BEHIND_FILTER` it is less, and where the PI loop itself has more, it is
    the slowest that a design looks at; not bounded so is an observer that knows its lag.
    """
    inertia, period = scenario.feedback.inertia, scenario.sampling.period
    delay = math.ceil(scenario.assumed_delay - 1e-6)
    try:
        largest = design(inertia, period, *gains, delay=delay).bandwidth
    except ValueError as error:
        raise InputError(f"feedback: {error}") from error
    bandwidth = min(multiple * balance(scenario), largest)
    if scenario.sensor.encoder_resolution is None or not bounded:
        return bandwidth
    measured = {"delay": delay, "velocity": scenario.velocity_estimator}
    if design(inertia, period, *gains, bandwidth, **measured).maximum_sensitivity <= LARGEST_BEHIND_FILTER:
        return bandwidth
    try:
        slower = design(inertia, period, *gains, maximum_sensitivity=LARGEST_BEHIND_FILTER, **measured).bandwidth
    except ValueError:
        slower = SLOWEST * gains[0] / (2.0 * math.pi * inertia)
    return min(bandwidth, slower)


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


made_of(ObservedModel, "observed_batch")(lambda scenario, multiple=0.1: observed_nominal(scenario, multiple, "batch"))
made_of(PaperController, "adaptive_paper")(lambda scenario: {"memory": scenario.adaptation.memory or PAPER_MEMORY})


def adaptive(scenario: Scenario, **options: Any) -> dict[str, Any]:
    """Adaptive controller as a scenario asks for it, with further options of :class:`AdaptiveController`."""
    assumed = scenario.adaptation
    names = ("ripple_periods", "position_hats", "position_range", "load_friction", "friction_share")
    usual = WITH_OFFSET if scenario.joint.axis == "linear" else WITH_GRAVITY
    known = {"parameters": assumed.parameters or usual, "position_periods": scenario.friction_periods}
    return {**known, **{name: getattr(assumed, name) for name in names}, **options}


made_of(AdaptiveController, "adaptive_unsupervised")(
    lambda scenario: adaptive(scenario, tuning=Tuning(explained=1e300))  # without its observer
)
made_of(AdaptiveController)(adaptive)


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
    """Lee and Tomizuka's controller from nominal parameters; it may integrate, as PI does, beside the observer."""
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
    frequencies = scenario.reference.frequencies if isinstance(scenario.reference, Multisine) else []
    for count in range(1, 101) if frequencies else ():
        length = count / min(frequencies)
        if SHORTEST_REPEATS * length > scenario.length:
            return 0
        samples = length / scenario.sampling.period
        if all(abs(one - round(one)) < 1e-6 for one in [samples, *(length * each for each in frequencies)]):
            return round(samples)
    return 0


@made_of(Repetitive)
def repetitive(scenario: Scenario, gain: float = 0.9, lead: float = 0.5) -> dict[str, Any]:
    """Repetitive feedforward; the lead is in time constants of the feedback."""
    period, cycle = scenario.sampling.period, cycle_of(scenario)
    samples = math.ceil(lead * response_time(scenario) / period + scenario.assumed_delay - 1e-9)
    return {"cycle": cycle, "lead": min(samples, max(cycle - 1, 0)), "gain": gain}


# of the true parameters with their lag there is the oracle, which follows changes as well
FIXED = {f"{f}_{s}": (f, s) for f in FORMS for s in SOURCES if (f, s) != ("lagged", "true")}  # forms and sources

for _name, (_form, _source) in FIXED.items():
    made_of(ModelBased, _name)(lambda scenario, form=_form, source=_source: {"model": _model(scenario, form, source)})


def loop_of(scenario: Scenario, name: str, own: Mapping[str, Own] | None = None) -> Scenario:
    """Return a scenario in whose loop a controller runs: with the bandwidth that suits it, for ``auto``.

    An own controller (of ``own``, by name) has that of PI.
    """
    own = own or {}
    check_among("controllers = ", name, [*CONTROLLERS, *own])
    if not scenario.feedback.is_auto:
        return scenario
    return with_bandwidth(scenario, find_own_bandwidth(scenario, CONTROLLERS["pi" if name in own else name]).best)


def make_for_machine(scenario: Scenario, name: str) -> Any:
    """Make a controller of the package as it is to run on a machine: the adaptive one knows the limit of the drive.

    In a comparison the simulated drive reports what it gave; a machine may not. Not every scenario has a limit.
    """
    limit = scenario.actuator.torque_limit
    known = {"torque_limit": limit} if name == "adaptive" and limit is not None else {}
    loop = loop_of(scenario, name)
    return CONTROLLERS[name](loop, **known)


def make_controller(scenario: Scenario, name: str, own: Mapping[str, Own] | None = None) -> Any:
    """Make a controller for a scenario by its name, an own one by :func:`~adaptive_ff.comparison.own.make_own`."""
    loop = loop_of(scenario, name, own)
    return make_own(name, own[name], loop) if own and name in own else CONTROLLERS[name](loop)
