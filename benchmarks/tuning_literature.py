"""What the sources of the rivals from the literature leave open, as candidates of the search of ``benchmarks.tuning``.

``lugre_observer``: way to breakaway, in units of the way at ``Vs`` in a time constant ``J/Kp`` of the feedback, and the
observer's gain. ``lugre_gradient``: learning rate, as a share of the crossover ``Kp/J``, first way to breakaway and
floor. ``friction_observer``: presliding displacement over the nominal one, and bandwidth of its observer, on joints
with presliding. ``lee_tomizuka``: form of the friction curve, bandwidth of its observer, with and without an integral,
in a position loop. ``maxwell_adaptive``: learning rate, the reaches of its elements in the unit of the way, and how
much slower it learns where a drive is late. ``radial_basis``: learning rate, lag, and the same. ``super_twisting``: its
bound over the noise times the square of the crossover. ``repetitive``: gain and lead, on motions that have a period.
"""

from typing import Any

from adaptive_ff.comparison.registry import (
    REACHES,
    Maker,
    make_friction_observer,
    make_lee_tomizuka,
    make_lugre_gradient,
    make_lugre_observer,
    make_maxwell_adaptive,
    make_radial_basis,
    make_repetitive,
    make_super_twisting,
)
from adaptive_ff.scenario.scenario import Scenario

WAYS = (0.1, 0.2, 0.3, 0.5, 1.0, 2.0)
OBSERVER_GAINS = (0.0, 0.3, 1.0, 2.0)
SLIP_RATES = (0.1, 0.3, 0.6, 1.0, 2.0)
GRIDS = (REACHES, (0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0))
BELL_RATES = (1.5, 3.0, 6.0, 10.0)
BELL_LAGS = (0.0, 2.0)
CAUTIONS = (0.0, 5.0, 10.0, 20.0)
SHARES = (10.0, 20.0, 30.0, 40.0, 60.0, 100.0)
GAINS = (0.2, 0.4, 0.7, 0.9)
LEADS = (0.0, 0.5, 1.0)
GRADIENT_RATES = (0.1, 0.2, 0.4, 0.8)
GRADIENT_WAYS = (0.1, 0.3, 1.0)
FLOORS = (0.3, 0.5, 0.8, 1.2)
STRETCHES = (0.5, 0.7, 1.0, 1.4)
OBSERVER_SHARES = (0.1, 0.2, 0.4, 0.8, 1.6)
COMPENSATED_SHARES = (1.0, 2.0, 4.0, 6.0, 8.0)

BY_GRADIENT = ("lugre_gradient", "maxwell_adaptive", "radial_basis")
"""Rivals that are searched on further scenarios, on which learning too fast does not hold."""

MADE_FOR: dict[str, dict[str, Any]] = {
    "repetitive": {"reference": {"frequencies": [0.25, 0.5, 1.5], "amplitudes": [1.0, 0.5, 0.3]}},
    "lee_tomizuka": {"position": {}},
    "friction_observer": {"joint": {"kind": "elasto_plastic", "presliding": 2e-3}},
}
"""Tables of what a rival is searched on where it was made for that: a period, a position loop, a presliding joint."""


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
        "lugre_gradient": {
            f"rate {rate:g}, way {way:g}, floor {floor:g}": _made(make_lugre_gradient, rate, way, floor)
            for rate in GRADIENT_RATES
            for way in GRADIENT_WAYS
            for floor in FLOORS
        },
        "friction_observer": {
            f"stretch {stretch:g}, {share:g} x balance": _made(make_friction_observer, stretch, share)
            for stretch in STRETCHES
            for share in OBSERVER_SHARES
        },
        "lee_tomizuka": {
            f"{form}, {share:g} x balance, {'PI' if integrates else 'P'}": _made(
                make_lee_tomizuka, form, share, integrates
            )
            for form in ("coulomb", "stribeck")
            for share in COMPENSATED_SHARES
            for integrates in (True, False)
        },
        "maxwell_adaptive": {
            f"rate {rate:g}, reaches {grid[0]:g} to {grid[-1]:g}, caution {caution:g}": _made(
                make_maxwell_adaptive, rate, grid, caution
            )
            for rate in SLIP_RATES
            for grid in GRIDS
            for caution in CAUTIONS
        },
        "radial_basis": {
            f"rate {rate:g}, lag {lag:g}, caution {caution:g}": _made(make_radial_basis, rate, lag, caution)
            for rate in BELL_RATES
            for lag in BELL_LAGS
            for caution in CAUTIONS
        },
        "super_twisting": {f"share {share:g}": _made(make_super_twisting, share) for share in SHARES},
        "repetitive": {
            f"gain {gain:g}, lead {lead:g}": _made(make_repetitive, gain, lead) for gain in GAINS for lead in LEADS
        },
    }
