"""Rivals from the literature of friction and from practice, made for a scenario.

What their sources leave open did best in ``python -m benchmarks.tuning``, on other joints and seeds, but for two rates
of learning. The fastest of that search, where no drive has a delay, do not hold: ``radial_basis`` gets unstable with a
delay of one period from a rate of 3 on, and ``maxwell_adaptive`` takes long to recover from saturation from some rate
between 0.3 and 1 on. A slower rate of the search is chosen.
"""

import math

from adaptive_ff.comparison.fixed_models import fixed_model
from adaptive_ff.rivals.learnt_feedforward import LearntFeedforward
from adaptive_ff.rivals.lugre_observer import LuGreObserver
from adaptive_ff.rivals.repetitive import Repetitive
from adaptive_ff.scenario.reference import Multisine
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.scenario.truth import true_model
from controllers import SuperTwisting

REACHES = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)
"""Reaches of the stop operators, in units of the way at ``Vs`` in a time constant of the feedback."""

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


def make_maxwell_adaptive(
    scenario: Scenario, rate: float = 0.3, reaches: tuple[float, ...] = REACHES
) -> LearntFeedforward:
    """Make an adaptive Maxwell-slip compensation; the rate is a share of the feedback's crossover."""
    return LearntFeedforward(
        *scenario.feedback.gains,
        scenario.sampling.period,
        inertia=scenario.feedback.inertia,
        stribeck_velocity=scenario.adaptation.stribeck_velocity,
        reaches=[reach * _assumed_way(scenario) for reach in reaches],
        rate=rate / response_time(scenario),
        delay=scenario.assumed_delay,
    )


def make_radial_basis(scenario: Scenario, rate: float = 1.5, lag: float = 1.0) -> LearntFeedforward:
    """Make a radial-basis feedforward; rate and lag are in units of the feedback's crossover and time constant."""
    response = response_time(scenario)
    return LearntFeedforward(
        *scenario.feedback.gains,
        scenario.sampling.period,
        inertia=scenario.feedback.inertia,
        stribeck_velocity=scenario.adaptation.stribeck_velocity,
        centres=CENTRES,
        lag=lag * response,
        rate=rate / response,
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
