"""Section IV-A, Fig. 4: offline least squares (7)-(9) on noise-driven data, beside the gated torque form."""

from adaptive_ff.friction.model import ESTIMATED
from adaptive_ff.learning.batch import Identification
from benchmarks.paper.data import (
    MORE_SEEDS,
    SEED,
    SYMBOLS,
    Data,
    deviations,
    in_words,
    rms,
    simulate_noise,
)
from benchmarks.paper.experiment import Experiment, Row, limited, notes
from benchmarks.paper.figures import figure_04
from benchmarks.paper.identification import (
    filtered,
    model_free_run,
    model_one_step,
    series,
    series_free_run,
    series_one_step,
)

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


def identify_all(data: Data) -> dict[str, Identification]:
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
    worst = {name: dict.fromkeys(ESTIMATED, 0.0) for name in LIMITS}
    for seed in seeds:
        data = simulate_noise(seed)
        found = {
            SLIDING: series(data.velocity, data.acting, sliding=True),
            FILTERED: filtered(data),
            FINE: filtered(data.every(FINE_PERIOD)),
        }
        for name, parameters in worst.items():
            for parameter, deviation in deviations(found[name].model).items():
                parameters[parameter] = max(parameters[parameter], 100.0 * abs(deviation))
    return worst


def run() -> Experiment:
    """Identify the joint of Fig. 4 in all ways."""
    data = simulate_noise(SEED)
    found = identify_all(data)
    rows = [Row(f"{name}: off the truth by, %", in_words(way.model)) for name, way in found.items()]
    worst = worst_deviations(MORE_SEEDS)
    for name, limits in LIMITS.items():
        for parameter, limit in limits.items():
            value = worst[name][parameter]
            quantity = f"{name}: {SYMBOLS[parameter]} off by, %, worst of {len(MORE_SEEDS)} seeds"
            rows.append(limited(quantity, value, limit))
    rows += prediction_rows(data, found)
    return Experiment(
        "Fig. 4, section IV-A: offline least squares",
        rows,
        notes("offline"),
        {"figure_04": figure_04(data, *(found[name] for name in (SHIFTED, SLIDING, FILTERED)))},
    )


def prediction_rows(data: Data, found: dict[str, Identification]) -> list[Row]:
    """Return one-step and free-run errors of the ways at 10 ms."""
    velocity, errors = data.velocity, {}
    for name, torque in ((PLAIN, data.commanded), (SHIFTED, data.acting), (SLIDING, data.acting)):
        coefficients = found[name].regression.values
        one_step = series_one_step(coefficients, velocity, torque)
        errors[name] = one_step, series_free_run(coefficients, velocity, torque) - velocity
    model = found[FILTERED].model
    errors[FILTERED] = model_one_step(model, velocity, data.acting), model_free_run(model, data) - velocity
    rows = [
        Row(f"{name}: {kind} error, mrad/s rms", 1e3 * rms(error))
        for place, kind in enumerate(("one-step", "free-run"))
        for name, error in ((name, both[place]) for name, both in errors.items())
    ]
    return [*rows, Row("velocity itself, mrad/s rms", 1e3 * rms(velocity))]
