"""Controllers against PI on a scenario, over draws of the noise."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from adaptive_ff.comparison.comparison import BASELINE
from adaptive_ff.comparison.run import Run, run_by_name
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.experiment import RunSetup, build_setup
from adaptive_ff.simulation.metrics import standstill_range
from adaptive_ff.simulation.tracking_errors import (
    TrackingErrors,
    failed,
    first_motion_time,
    pooled,
    ratios,
    tracking_errors,
)

NOISE_STREAM = 1  # stream of random numbers of the sensor's noise; a draw beyond the first adds its number
Figures = dict[str, float]  # figures of a controller by name


def track_scenario(scenario: Scenario, controllers: Sequence[str], *, draws: int = 1) -> dict[str, Figures]:
    """Run controllers, ``noise_floor`` included, on a scenario over draws of the noise, and compare them with PI.

    The seed gives the reference and the first draw; without noise one draw is all. By controller: ``error``, its
    settled error (rad/s, behind a position loop rad), the ratios of
    :func:`~adaptive_ff.simulation.tracking_errors.ratios`; ``torque_variation``, sum of the torque's steps over PI's;
    and ``standstill``, range of the velocity at standstill in rad/s, where the reference stands still. One that cannot
    be made for the scenario has none.
    """
    setups = list(noisy_setups(scenario, draws))
    base, variation, _ = _pooled(scenario, BASELINE, setups)
    found: dict[str, Figures] = {}
    for name in controllers:
        try:
            errors, varied, rest = _pooled(scenario, name, setups)
        except ArithmeticError:
            errors, varied, rest = failed(base), float("inf"), {}
        except ValueError:
            found[name] = {}
            continue
        varied = varied / variation if variation > 0.0 else 1.0
        found[name] = {"error": errors.settled, **ratios(base, errors), "torque_variation": varied, **rest}
    return found


def noisy_setups(scenario: Scenario, draws: int) -> Iterator[RunSetup]:
    """Yield the setup of a scenario with one draw of the noise after the other; draw 0 is the scenario's own."""
    if draws < 1:
        raise ValueError(f"draws = {draws} is not allowed: it must be at least 1")
    setup = build_setup(scenario)
    yield setup
    if scenario.sensor.is_random:  # an encoder without faults has nothing to draw
        for draw in range(1, draws):
            noise, held = scenario.sensed(np.random.default_rng([scenario.seed, NOISE_STREAM, draw]))
            yield setup._replace(noise=noise, held=held)


def _pooled(scenario: Scenario, name: str, setups: list[RunSetup]) -> tuple[TrackingErrors, float, Figures]:
    """Return the errors over all draws, and torque variation (N m) and range at standstill (rad/s) of the first."""
    runs = [run_by_name(scenario, name, setup, thin=1) for setup in setups]
    rest = standstill_range(runs[0].solver_time, runs[0].reference, runs[0].velocity)
    return pooled(map(run_errors, runs)), runs[0].metrics.torque_variation, {} if rest is None else {"standstill": rest}


def run_errors(run: Run) -> TrackingErrors:
    """Return the errors of a run, of the position behind a position loop."""
    error: Any = run.reference - run.velocity if run.position_error is None else run.position_error
    period = run.scenario.joint.solver_period
    changes = [change.time for change in run.scenario.change]
    return tracking_errors(np.square(error), period, begin=first_motion_time(run.reference, period), changes=changes)
