"""Cogging of the drive of the built-in joint, whose period the controller is given, given wrong, or not given."""

from functools import partial

from adaptive_ff import Scenario, load_scenario
from benchmarks.running import scenario_case
from benchmarks.suite import Case

DRIVES = ((0.0, 0.02), (3.0, 0.05), (12.0, 0.05), (12.0, 0.01), (30.0, 0.02))
"""Amplitude, N m, and period, rad, of the cogging."""

GIVEN = {"unspecified": None, "given": 1.0, "given 1 % wrong": 1.01}
"""Period that the controller is given, over the true one."""


def cogged(amplitude: float, period: float, given: float | None, seed: int) -> Scenario:
    """Return the built-in joint with cogging (N m, rad)."""
    return load_scenario().modified(
        seed=seed,
        actuator={"ripple_amplitude": amplitude, "ripple_period": period},
        adaptation={"ripple_periods": [] if given is None else [given * period]},
    )


def built_in(count: int, draws: int = 1, first: int = 1) -> list[Case]:
    """Return all drives and all that is given of them."""
    cases = []
    for amplitude, period in DRIVES:
        for name, given in GIVEN.items():
            row = f"{amplitude:g} N m every {period:g} rad, period {name}"
            for seed in range(first, first + count):
                cases.append(scenario_case(row, row, seed, partial(cogged, amplitude, period, given, seed), draws))
    return cases
