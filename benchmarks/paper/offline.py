"""Section IV-A, Fig. 4: offline least squares (7)-(9) on noise-driven data, beside the gated torque form."""

from adaptive_ff.friction.model import ESTIMATED
from adaptive_ff.learning.batch import Identification
from adaptive_ff.simulation.metrics import rms
from benchmarks.cases.reports import Row, limited
from benchmarks.paper.estimators import filtered, series, series_free_run, series_one_step
from benchmarks.paper.experiment import SYMBOLS, Experiment, deviations, in_words, notes
from benchmarks.paper.figures import figure_04
from benchmarks.paper.records import MORE_SEEDS, SEED, Record, predict, simulate_noise

FINE_PERIOD = 0.001  # s
PLAIN = "(4), all samples, u commanded at k"
SHIFTED = "(4), all samples, u over (k-1, k]"
SLIDING_PLAIN = "(4), sliding samples, u commanded at k"
SLIDING = "(4), sliding samples, u over (k-1, k]"
FILTERED = "torque form with gate, 10 ms"
FINE = "torque form with gate, 1 ms"
LIMITS = {
    SLIDING: {"inertia": 10.0, "coulomb": 10.0, "stiction": 10.0, "viscous": 10.0, "friction_lag": 30.0},
    FILTERED: {"inertia": 2.0, "coulomb": 1.0, "stiction": 3.0, "viscous": 1.0, "friction_lag": 15.0},
    FINE: dict.fromkeys(ESTIMATED, 1.0),
}
"""Largest deviation of each parameter from the truth that is asked for, %."""


def identify_all(data: Record) -> dict[str, Identification]:
    """Identify in every way that is compared."""
    return {
        PLAIN: series(data.velocity, data.commanded, sliding=False),
        SHIFTED: series(data.velocity, data.acting, sliding=False),
        SLIDING_PLAIN: series(data.velocity, data.commanded, sliding=True),
        SLIDING: series(data.velocity, data.acting, sliding=True),
        FILTERED: filtered(data),
        FINE: filtered(data.every(FINE_PERIOD)),
    }


def worst_deviations(seeds: range) -> dict[str, dict[str, float]]:
    """Return the largest deviation (%) of each parameter over some seeds, for the ways with a target."""
    every = [identify_all(simulate_noise(seed)) for seed in seeds]
    off = {way: [deviations(found[way].model) for found in every] for way in LIMITS}
    return {way: {name: max(abs(one[name]) for one in each) for name in ESTIMATED} for way, each in off.items()}


def run() -> Experiment:
    """Identify the joint of Fig. 4 in all ways."""
    data = simulate_noise(SEED)
    found = identify_all(data)
    rows = [Row(f"{name}: off the truth by, %", in_words(way.model)) for name, way in found.items()]
    worst = worst_deviations(MORE_SEEDS)
    for name, limits in LIMITS.items():
        for parameter, limit in limits.items():
            quantity = f"{name}: {SYMBOLS[parameter]} off by, %, worst of {len(MORE_SEEDS)} seeds"
            rows.append(limited(quantity, worst[name][parameter], limit))
    rows += prediction_rows(data, found)
    figure = figure_04(data, *(found[name] for name in (SHIFTED, SLIDING, FILTERED)))
    return Experiment("Fig. 4, section IV-A: offline least squares", rows, notes("offline"), {"figure_04": figure})


def prediction_rows(data: Record, found: dict[str, Identification]) -> list[Row]:
    """Return one-step and free-run errors of the ways at 10 ms."""
    errors = {}
    for name, torque in ((PLAIN, data.commanded), (SHIFTED, data.acting), (SLIDING, data.acting)):
        fit = found[name].regression.values, data.velocity, torque
        errors[name] = series_one_step(*fit), series_free_run(*fit) - data.velocity
    model = found[FILTERED].model
    errors[FILTERED] = [predict(model, data, one_step=step) - data.velocity for step in (True, False)]
    rows = [
        Row(f"{name}: {kind} error, mrad/s rms", 1e3 * rms(both[place]))
        for place, kind in enumerate(("one-step", "free-run"))
        for name, both in errors.items()
    ]
    return [*rows, Row("velocity itself, mrad/s rms", 1e3 * rms(data.velocity))]
