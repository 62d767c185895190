"""Rivals from the literature of friction and from practice, made for a scenario.

What their sources leave open did best in ``python -m benchmarks.tuning``, on other joints and seeds, but for two rates:
the fastest of that search hold with little to spare. ``radial_basis`` learns slower where a drive is late than it
could, and ``lugre_gradient`` stays a factor of four below the rate at which it loses its stability.
"""

import math

import numpy as np

from adaptive_ff.baselines.friction_observer import FrictionObserver
from adaptive_ff.baselines.learnt_feedforward import LearntFeedforward
from adaptive_ff.baselines.lee_tomizuka import LeeTomizuka
from adaptive_ff.baselines.lugre_gradient import LuGreGradient
from adaptive_ff.baselines.lugre_observer import LuGreObserver
from adaptive_ff.baselines.repetitive import Repetitive
from adaptive_ff.comparison.fixed_models import SPREAD, STREAM, fixed_model
from adaptive_ff.comparison.observer_bandwidth import observer_bandwidth
from adaptive_ff.scenario.reference import Multisine
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.scenario.truth import true_model
from controllers import DisturbanceObserver, KalmanDisturbance, SuperTwisting
from plant import ElastoPlasticJoint, LuGreJoint, MaxwellJoint, RollingJoint

REACHES = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)
"""Reaches of the stop operators, in units of the way at ``Vs`` in a time constant of the feedback."""

LEAST_REACH = 1e-3
"""Presliding displacement of a joint that has none, in the same units."""

CENTRES = (-20.0, -6.0, -2.0, -0.6, -0.2, 0.2, 0.6, 2.0, 6.0, 20.0)
"""Centres of the bells, in units of ``Vs``."""

SHORTEST_REPEATS = 3
"""Periods of a motion that a run must hold for it to be worth learning."""

QUIET = 0.02
"""Noise that a super-twisting observer is set for at least, as a share of ``Vs``."""


def response_time(scenario: Scenario) -> float:
    """Return the time constant ``J/Kp`` of the feedback, s."""
    return scenario.feedback.inertia / scenario.feedback.gains[0]


def _assumed_way(scenario: Scenario) -> float:
    return scenario.adaptation.stribeck_velocity * response_time(scenario)


def learning_rate(scenario: Scenario, share: float, caution: float) -> float:
    """Return a share of the feedback's crossover, 1/s, less where a delay of the drive makes the loop late."""
    response = response_time(scenario)
    return share / (response + caution * scenario.assumed_delay * scenario.sampling.period)


def make_maxwell_adaptive(
    scenario: Scenario, rate: float = 1.0, reaches: tuple[float, ...] = REACHES, caution: float = 5.0
) -> LearntFeedforward:
    """Make an adaptive Maxwell-slip compensation; rate and caution are those of ``learning_rate``."""
    return LearntFeedforward(
        *scenario.feedback.gains,
        scenario.sampling.period,
        inertia=scenario.feedback.inertia,
        stribeck_velocity=scenario.adaptation.stribeck_velocity,
        reaches=[reach * _assumed_way(scenario) for reach in reaches],
        rate=learning_rate(scenario, rate, caution),
        delay=scenario.assumed_delay,
    )


def make_radial_basis(
    scenario: Scenario, rate: float = 6.0, lag: float = 2.0, caution: float = 20.0
) -> LearntFeedforward:
    """Make a radial-basis feedforward; rate and caution are those of ``learning_rate``, the lag in time constants."""
    return LearntFeedforward(
        *scenario.feedback.gains,
        scenario.sampling.period,
        inertia=scenario.feedback.inertia,
        stribeck_velocity=scenario.adaptation.stribeck_velocity,
        centres=CENTRES,
        lag=lag * response_time(scenario),
        rate=learning_rate(scenario, rate, caution),
        delay=scenario.assumed_delay,
    )


def cycle_of(scenario: Scenario) -> int:
    """Return the samples in a period of the scenario's plan; zero where it has none that repeats in the run.

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
    return Repetitive(
        *scenario.feedback.gains,
        period,
        inertia=scenario.feedback.inertia,
        cycle=cycle,
        lead=min(samples, max(cycle - 1, 0)),
        gain=gain,
        delay=scenario.assumed_delay,
    )


def make_lugre_observer(scenario: Scenario, way: float = 0.3, gain: float = 1.0) -> LuGreObserver:
    """Make a LuGre observer from nominal parameters; it breaks away after a way in units as of ``REACHES``."""
    model = fixed_model(scenario, true_model(scenario), "lagged", "nominal")
    return LuGreObserver(
        *scenario.feedback.gains,
        scenario.sampling.period,
        model,
        stiffness=model.stiction / (way * _assumed_way(scenario)),
        gain=gain,
        delay=scenario.assumed_delay,
    )


def make_lugre_gradient(scenario: Scenario, rate: float = 0.8, way: float = 0.3, floor: float = 1.2) -> LuGreGradient:
    """Make a LuGre feedforward tuned by gradient; the rate is a share of the crossover, the way as above."""
    proportional, assumed = scenario.feedback.gains[0], scenario.adaptation
    return LuGreGradient(
        *scenario.feedback.gains,
        scenario.sampling.period,
        inertia=scenario.feedback.inertia,
        stribeck_velocity=assumed.stribeck_velocity,
        stribeck_shape=assumed.stribeck_shape,
        stiffness=proportional * assumed.stribeck_velocity / (way * _assumed_way(scenario)),
        rate=rate / response_time(scenario),
        floor=floor,
        delay=scenario.assumed_delay,
    )


def nominal_presliding(scenario: Scenario) -> float:
    """Return the displacement (rad) from a reversal until the joint slides, as from a data sheet; least where none is.

    Bristles and elements slip gradually: of a LuGre joint it is twice what the stiction bends, of Maxwell slip the
    reach of the last element, of rolling friction its range. It is off by a factor as the parameters of ``nominal``
    models are.
    """
    joint, least = scenario.joint, LEAST_REACH * _assumed_way(scenario)
    true = 0.0
    if isinstance(joint, LuGreJoint):
        true = 2.0 * joint.stiction / joint.stiffness
    elif isinstance(joint, MaxwellJoint):
        true = max(joint.displacements)
    elif isinstance(joint, RollingJoint):
        true = joint.rolling_range
    elif isinstance(joint, ElastoPlasticJoint):
        true = joint.presliding
    factor = SPREAD ** np.random.default_rng([scenario.seed, STREAM, 1]).uniform(-1.0, 1.0)
    return max(float(factor) * true, least)


def make_friction_observer(scenario: Scenario, stretch: float = 1.0, share: float = 0.2) -> FrictionObserver:
    """Make a feed-forward friction observer from nominal parameters.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    stretch : float, optional
        Presliding displacement that is assumed, over the nominal one.
    share : float, optional
        Bandwidth of the observer over the balance.
    """
    model = fixed_model(scenario, true_model(scenario), "lagged", "nominal")
    gains, period = scenario.feedback.gains, scenario.sampling.period
    noise = scenario.velocity_noise or 1.0  # only its ratio to the walk matters
    bandwidth = observer_bandwidth(scenario, share, KalmanDisturbance.design, *gains)
    walk = KalmanDisturbance.walk(model.inertia, period, noise, bandwidth)
    first, second = KalmanDisturbance.gains(model.inertia, period, noise, walk)
    return FrictionObserver(
        *gains,
        period,
        model,
        presliding=stretch * nominal_presliding(scenario),
        velocity_gain=first,
        disturbance_gain=second,
        delay=scenario.assumed_delay,
    )


def make_lee_tomizuka(
    scenario: Scenario, form: str = "coulomb", share: float = 6.0, integrates: bool = False
) -> LeeTomizuka:
    """Make Lee and Tomizuka's controller from nominal parameters; the observer's bandwidth is a share of the balance.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    form : "coulomb" or "stribeck", optional
        Curve of the friction compensation.
    share : float, optional
        Bandwidth of the observer over the balance.
    integrates : bool, optional
        Whether the integral of the PI loop stands beside the observer.
    """
    model = fixed_model(scenario, true_model(scenario), form, "nominal")
    gains = scenario.feedback.gains if integrates else (scenario.feedback.gains[0], 0.0)
    # behind a position loop, which it was made for, the bound makes it 1.5 times worse (`positioning`, seeds 101-103)
    bounded = scenario.position is None
    bandwidth = observer_bandwidth(scenario, share, DisturbanceObserver.design, *gains, bounded=bounded)
    period, delay = scenario.sampling.period, scenario.assumed_delay
    return LeeTomizuka(*gains, period, model, bandwidth=bandwidth, delay=delay)


def make_super_twisting(scenario: Scenario, share: float = 40.0) -> SuperTwisting:
    """Make a super-twisting observer: ``L`` is a share of noise times the square of the feedback's crossover."""
    noise = max(scenario.velocity_noise, QUIET * scenario.adaptation.stribeck_velocity)
    return SuperTwisting(
        *scenario.feedback.gains,
        scenario.sampling.period,
        inertia=scenario.feedback.inertia,
        bound=share * noise / response_time(scenario) ** 2,
        delay=scenario.assumed_delay,
    )
