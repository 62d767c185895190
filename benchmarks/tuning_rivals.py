"""What the sources of the rivals leave open, as candidates of a search; the rules found are their defaults.

``adaptive_paper``: memory. ``canudas``: dead zone, as a share of the assumed Stribeck velocity, and share of the
friction that is compensated, along the reference and at the measured velocity. ``feedback_error``: learning rate, as a
share of the crossover ``Kp/J``, and the friction lags of its features, in time constants ``J/Kp``.
"""

from typing import Any

from adaptive_ff.baselines.canudas import CanudasController, CanudasMeasuredController
from adaptive_ff.baselines.feedback_error import FeedbackErrorLearning
from adaptive_ff.baselines.paper import PaperController
from adaptive_ff.comparison.registry import Maker
from adaptive_ff.scenario.scenario import Scenario

MEMORIES = (0.3, 0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 20.0, 50.0, 100.0)
DEAD_ZONES = (0.1, 0.3, 1.0, 2.0)
SHARES = (0.7, 0.85, 1.0)
MEASURED_SHARES = (0.3, 0.6, 0.7, 0.8)
RATES = (0.05, 0.15, 0.3)
LAGS = ((0.0,), (1.0,), (2.0,), (0.0, 2.0), (0.0, 3.0), (0.5, 2.5), (1.0, 3.0), (0.0, 1.0, 3.0))


def paper(memory: float) -> Maker:
    """Return the maker of ``adaptive_paper`` with a memory (s)."""

    def make(scenario: Scenario) -> PaperController:
        assumed = scenario.adaptation
        return PaperController(
            *scenario.feedback.gains,
            scenario.sampling.period,
            inertia=scenario.feedback.inertia,
            stribeck_velocity=assumed.stribeck_velocity,
            stribeck_shape=assumed.stribeck_shape,
            memory=memory,
        )

    return make


def canudas(controller: Any, dead_zone: float, share: float) -> Maker:
    """Return the maker of a controller after Canudas, Astrom and Braun."""

    def make(scenario: Scenario) -> Any:
        return controller(
            *scenario.feedback.gains,
            scenario.sampling.period,
            inertia=scenario.feedback.inertia,
            dead_zone=dead_zone * scenario.adaptation.stribeck_velocity,
            share=share,
        )

    return make


def feedback_error(rate: float, lags: tuple[float, ...]) -> Maker:
    """Return the maker of ``feedback_error`` with a learning rate and lags in units of the feedback's time constant."""

    def make(scenario: Scenario) -> FeedbackErrorLearning:
        assumed, response = scenario.adaptation, scenario.feedback.inertia / scenario.feedback.gains[0]
        return FeedbackErrorLearning(
            *scenario.feedback.gains,
            scenario.sampling.period,
            inertia=scenario.feedback.inertia,
            stribeck_velocity=assumed.stribeck_velocity,
            stribeck_shape=assumed.stribeck_shape,
            rate=rate / response,
            lags=[lag * response for lag in lags],
        )

    return make


def candidates() -> dict[str, dict[str, Maker]]:
    """Return the candidates by controller and label."""
    return {
        "adaptive_paper": {f"memory {memory:g} s": paper(memory) for memory in MEMORIES},
        "canudas": {
            f"dead zone {zone:g}, share {share:g}": canudas(CanudasController, zone, share)
            for zone in DEAD_ZONES
            for share in SHARES
        },
        "canudas_measured": {
            f"dead zone {zone:g}, share {share:g}": canudas(CanudasMeasuredController, zone, share)
            for zone in DEAD_ZONES
            for share in MEASURED_SHARES
        },
        "feedback_error": {
            f"rate {rate:g}, lags {', '.join(f'{lag:g}' for lag in lags)}": feedback_error(rate, lags)
            for rate in RATES
            for lags in LAGS
        },
    }
