"""What the sources of the rivals from the literature leave open, as candidates of the search of ``benchmarks.tuning``.

``lugre_observer``: way to breakaway, in units of the way at ``Vs`` in a time constant ``J/Kp`` of the feedback, and the
observer's gain. ``maxwell_adaptive``: learning rate, as a share of the crossover ``Kp/J``, and the reaches of its
elements in the unit of the way. ``radial_basis``: learning rate and lag. ``super_twisting``: its bound over the noise
times the square of the crossover. ``repetitive``: gain and lead, on motions that have a period.
"""

from typing import Any

from adaptive_ff.comparison.literature import (
    REACHES,
    make_lugre_observer,
    make_maxwell_adaptive,
    make_radial_basis,
    make_repetitive,
    make_super_twisting,
)
from adaptive_ff.comparison.registry import Maker
from adaptive_ff.scenario.scenario import Scenario

WAYS = (0.1, 0.2, 0.3, 0.5, 1.0, 2.0)
OBSERVER_GAINS = (0.0, 0.3, 1.0, 2.0)
SLIP_RATES = (0.05, 0.15, 0.3, 0.6, 1.0)
GRIDS = (REACHES, (0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0), (0.3, 1.0, 3.0, 10.0, 30.0))
BELL_RATES = (0.15, 0.4, 1.5, 3.0, 6.0)
BELL_LAGS = (0.0, 1.0, 2.0)
SHARES = (10.0, 20.0, 30.0, 40.0, 60.0, 100.0)
GAINS = (0.2, 0.4, 0.7, 0.9)
LEADS = (0.0, 0.5, 1.0)

PERIODIC = {"frequencies": [0.25, 0.5, 1.5], "amplitudes": [1.0, 0.5, 0.3]}
"""Reference that ``repetitive`` is searched along: the others of the search have no period."""


def _made(make: Any, *values: Any) -> Maker:
    def maker(scenario: Scenario) -> Any:
        return make(scenario, *values)

    return maker


def literature_candidates() -> dict[str, dict[str, Maker]]:
    """Return the candidates by controller and label."""
    return {
        "lugre_observer": {
            f"way {way:g}, gain {gain:g}": _made(make_lugre_observer, way, gain)
            for way in WAYS
            for gain in OBSERVER_GAINS
        },
        "maxwell_adaptive": {
            f"rate {rate:g}, reaches {grid[0]:g} to {grid[-1]:g}": _made(make_maxwell_adaptive, rate, grid)
            for rate in SLIP_RATES
            for grid in GRIDS
        },
        "radial_basis": {
            f"rate {rate:g}, lag {lag:g}": _made(make_radial_basis, rate, lag)
            for rate in BELL_RATES
            for lag in BELL_LAGS
        },
        "super_twisting": {f"share {share:g}": _made(make_super_twisting, share) for share in SHARES},
        "repetitive": {
            f"gain {gain:g}, lead {lead:g}": _made(make_repetitive, gain, lead) for gain in GAINS for lead in LEADS
        },
    }
