"""Scenarios by name: those of the package, and situations made of the built-in one."""

import tomllib
from collections.abc import Iterable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from adaptive_ff import Scenario, load_scenario, parse_scenario
from adaptive_ff.scenario.library import SCENARIOS, scenario_names
from adaptive_ff.scenario.new import new_scenario_text
from benchmarks.cases.maps import MAPS, told
from benchmarks.running import scenario_case
from benchmarks.suite import Case

LIGHTNESS = 0.1  # inertia of light joints over that of the built-in one

LIGHT_PEAKS = {"light_slow": 0.0125, "light_medium": 0.05, "light": 0.35}
"""Largest speeds of the plan of joints with a tenth of the built-in inertia, and of the gain, rad/s, by name."""

TOLD_NOTHING = {"torque_untold": "paper_100hz", "limit_untold": "saturation"}
"""Scenarios of which the controllers are told nothing of the torque that the drive gives, by name."""

DRIVES_UNTOLD: dict[str, dict[str, float]] = {
    "lag_untold_10": {"lag": 0.010},
    "lag_untold_13": {"lag": 0.013},
    "lag_untold_20": {"lag": 0.020},
    "lag_untold_30": {"lag": 0.030},
    "rate_untold_1500": {"rate_limit": 1500.0},
    "rate_untold_2000": {"rate_limit": 2000.0},
}
"""Lags of the drive's current loop, s, and limits to how fast its torque rises, N m/s, by name.

The controllers are told nothing of them, nor what the drive gives.
"""

SENSOR_FAULTS: dict[str, dict[str, Any]] = {
    "sensor_leaps": {"leap": 3.0, "leap_share": 0.001},
    "sensor_leaps_often": {"leap": 1.0, "leap_share": 0.01},
    "sensor_held_10": {"held": 10, "held_share": 0.002},
    "sensor_held_50": {"held": 50, "held_share": 0.001},
    "sensor_held_often": {"held": 2, "held_share": 0.1},
}
"""Faults of the sensor of the built-in joint, by name: single velocities that leap, and messages that are lost."""


class Rippled(NamedTuple):
    """A velocity that is off by a share of itself, so many times in a turn, on the built-in joint at 500 Hz."""

    share: float  # amplitude, over the velocity
    times: int  # periods in a turn
    # whether the plan is the built-in multisine, up to 2 rad/s, or a staircase of speeds of one sign
    reverses: bool = False


RIPPLED = {
    "sensor_ripple_4": Rippled(0.01, 4),
    "sensor_ripple_20": Rippled(0.01, 20),
    "sensor_ripple_60": Rippled(0.01, 60),
    "sensor_ripple_120": Rippled(0.005, 120),
    "sensor_ripple_reverses": Rippled(0.005, 120, reverses=True),
}
"""Velocities out of resolvers, tachometers and discs that are not round, by name."""

STAIRS, STAIR_SPEEDS = 20, (1.0, 3.0)  # number and range (rad/s) of the speeds of their plans, drawn for each reference

TOLD_INERTIAS = {"inertia_told_double": 2.0, "inertia_told_half": 0.5}
"""Inertia that is told, and the feedback is designed for, over that of the built-in joint, by name."""

DATA_SHEETS = {"data_sheet": (0.5, 20.0, 6.0), "data_sheet_heavy": (20.0, 400.0, 2.5)}
"""Inertia, kg m^2, rated torque, N m, and speed, rad/s, of joints that ``adaptive-ff new`` makes, at 1 kHz, by name."""

DATA_SHEET_TIME = 240.0  # for how long they move, s: what noise does to a fast loop shows after minutes


class Encoder(NamedTuple):
    """An encoder instead of a measured velocity on the built-in joint."""

    counts: int  # counts in a turn
    velocity: dict[str, Any]  # what makes a velocity of it
    period: float = 0.01  # sampling period, s
    bandwidth: float = 10.0  # bandwidth of the loop, Hz
    scenario: str = "paper_100hz"  # scenario of the matrix that the joint and its motion are from


KALMAN: dict[str, Any] = {"method": "kalman"}  # a velocity made by the default Kalman filter

ENCODERS = {
    "coarse_encoder": Encoder(4096, {"method": "low_pass", "cutoff": 30.0}, bandwidth=6.0),
    "coarse_encoder_kalman": Encoder(4096, KALMAN, bandwidth=6.0),
    **{f"kalman_1khz_{counts}": Encoder(counts, KALMAN, period=1e-3) for counts in (4096, 8192, 16384, 65536)},
    "kalman_1khz_load_step": Encoder(65536, KALMAN, period=1e-3, scenario="load_step_80"),
    "kalman_1khz_triples": Encoder(65536, KALMAN, period=1e-3, scenario="friction_triples"),
}
"""Encoders of few counts by name; at 100 Hz the loop has 6 Hz, since PI itself hunts with 10."""

MADE = (LIGHT_PEAKS, TOLD_INERTIAS, TOLD_NOTHING, DRIVES_UNTOLD, SENSOR_FAULTS, RIPPLED, DATA_SHEETS, ENCODERS, MAPS)
"""All tables of situations that are not in the matrix."""

SITUATIONS = (
    *("paper_100hz", "noisy_1khz", "load_step_30", "load_step_80", "friction_drops", "friction_triples"),
    *("payload_double", "payload_half", "gravity_40", "gravity_100", "lugre_1e3", "lugre_3e3", "lugre_1e4"),
    *("slow_010", "slow_025", "slow_050", "steep_2", "steep_5", "steep_10", "steep_20"),
    *("high_stiction", "high_stiction_vs_quarter", "high_stiction_vs_fourfold", "delay", "elastic"),
    *("fast_loop_1khz", "fast_loop_encoder"),
    *(name for table in MADE for name in table),
)
"""Names of the scenarios on which the adaptive controller is to be never worse than PI."""


def situations(count: int, draws: int = 1, first: int = 1, names: Iterable[str] = SITUATIONS) -> list[Case]:
    """Return so many references of each situation."""
    return [
        scenario_case(name, name, seed, partial(named_scenario, name, seed), draws)
        for name in names
        for seed in range(first, first + count)
    ]


def matrix(count: int, draws: int = 1, first: int = 1) -> list[Case]:
    """Return so many references of each scenario of the package."""
    return situations(count, draws, first, scenario_names())


def named_scenario(name: str, seed: int) -> Scenario:
    """Return a scenario of the matrix, or of one of the tables above, with a seed."""
    if name in MAPS:
        return told(MAPS[name], seed)
    if name in LIGHT_PEAKS:
        light, peak = {"inertia": LIGHTNESS * load_scenario().joint.inertia}, LIGHT_PEAKS[name]
        return load_scenario().modified(seed=seed, joint=light, feedback=light, reference={"peak": peak})
    if name in TOLD_NOTHING:
        told_nothing = load_scenario(SCENARIOS / f"{TOLD_NOTHING[name]}.toml")
        return told_nothing.modified(seed=seed, actuator={"reports_torque": False})
    if name in DRIVES_UNTOLD:
        return load_scenario().modified(seed=seed, actuator={**DRIVES_UNTOLD[name], "reports_torque": False})
    if name in SENSOR_FAULTS:
        return load_scenario().modified(seed=seed, sensor=SENSOR_FAULTS[name])
    if name in RIPPLED:
        return rippled(RIPPLED[name], seed)
    if name in TOLD_INERTIAS:
        told_inertia = TOLD_INERTIAS[name] * load_scenario().joint.inertia
        return load_scenario().modified(seed=seed, feedback={"inertia": told_inertia})
    if name in DATA_SHEETS:
        made = parse_scenario(tomllib.loads(new_scenario_text(*DATA_SHEETS[name])), name)
        return made.modified(seed=seed, duration=DATA_SHEET_TIME)
    if name in ENCODERS:
        encoder = ENCODERS[name]
        return load_scenario(SCENARIOS / f"{encoder.scenario}.toml").modified(
            seed=seed,
            sampling={"period": encoder.period},
            sensor={"velocity_noise": 0.0, "encoder_resolution": 2.0 * np.pi / encoder.counts},
            velocity=encoder.velocity,
            feedback={"bandwidth": encoder.bandwidth},
        )
    return load_scenario(SCENARIOS / f"{name}.toml").modified(seed=seed)


def rippled(sensor: Rippled, seed: int) -> Scenario:
    """Return the built-in joint with a velocity that ripples."""
    period = 2.0 * np.pi / sensor.times
    speeds = np.random.default_rng([seed, STAIRS]).uniform(*STAIR_SPEEDS, STAIRS).round(3)
    stairs = {"kind": "staircase", "velocities": speeds.tolist(), "hold": 3.0, "acceleration": 2.0}
    return load_scenario().modified(
        seed=seed,
        sampling={"period": 0.002},
        sensor={"ripple_amplitude": sensor.share * period / (2.0 * np.pi), "ripple_period": period},
        reference={"peak": 2.0} if sensor.reverses else stairs,
    )
