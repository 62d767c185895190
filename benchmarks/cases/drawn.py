"""Joints drawn around the built-in one, and machines over decades of size, speed and sampling rate.

The same in a cascade: with a weight, behind a position loop; there with rests of seconds between moves as well. And
with drives that saturate and do not report it, and with elastic gears.
"""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from pydantic import ValidationError

from adaptive_ff import Scenario, load_scenario, simulate
from adaptive_ff.studies.sweep import class_of, draw_scenario, fall_over_gain
from benchmarks.running import tracked
from benchmarks.suite import Case

PERIODS = (0.02, 0.01, 0.005, 0.002, 0.001)  # sampling periods, s
INERTIAS = (0.003, 100.0)  # smallest and largest inertia, kg m^2
SPEEDS = (0.05, 20.0)  # smallest and largest peak of the plan, rad/s

TEMPOS = (0.1, 0.6)
"""Slowest and fastest plan: its peak acceleration over its peak speed, by 2 pi, Hz; of sines about 0.6 of that."""

FRICTION = (0.2, 20.0)  # smallest and largest Coulomb friction over the torque of the inertia at that acceleration
STRIBECK_VELOCITIES = (0.03, 0.4)  # smallest and largest Stribeck velocity over the peak speed
PRESLIDING = (3e-4, 3e-2)  # smallest and largest way before a joint with bristles slides, in seconds of the peak speed
LAGS = (0.002, 0.05)  # shortest and longest lag of friction, s, of two joints of three that are not LuGre's

NOISE = (2e-4, 8e-3)
"""Least and largest noise of the measured velocity over the peak speed; or a count of the encoder a period."""

BANDWIDTHS = (0.04, 0.1)  # smallest and largest bandwidth of the loop over the sampling rate, without delay
DELAYS = {0: 1.0, 1: 0.45, 2: 0.3}  # periods of delay of the drive, and the fraction of the bandwidth that they leave
LONGEST_STEP = 1e-3  # step of the simulated joint, s, about; shorter where its friction asks for it
KINDS = ("stribeck", "lugre", "elasto_plastic")  # kinds of friction, as often the one as the other
WEIGHTS = (0.1, 3.0)  # smallest and largest torque of the weight of a machine in a cascade, over its Coulomb friction

RIGID = {"inertia", "coulomb", "stiction", "viscous", "stribeck_velocity", "stribeck_shape", "friction_lag"}
"""Fields of a joint that one with an elastic gear has as well, the lag but of one without LuGre friction."""

LINK_FRACTIONS = (0.3, 0.8)  # smallest and largest fraction of the inertia that is beyond the gear
RESONANCES = (3.0, 10.0)  # smallest and largest resonance of a gear over the bandwidth of the loop
GEAR_DAMPING = 0.05  # damping of that resonance
GAPS = (1e-4, 5e-3)  # smallest and largest play, in seconds of the peak speed

SATURATIONS = (0.5, 1.05)
"""Smallest and largest limit of a drive that saturates unreported, over the torque that its plan needs."""

PEAK_QUANTILE = 0.995
"""Share of the time in which the needed torque is no larger than its peak: single peaks are of noise."""

ABOVE_STICTION = 1.02  # least limit of such a drive over the stiction of its joint, which it would never move otherwise
RESTS = (1.0, 20.0)  # shortest and longest rest between the moves of a machine that rests, s
LASTS = 120.0  # duration of its run, s
WEIGHT_STREAM = 1  # stream of random numbers of the weight
SATURATION_STREAM = 2  # stream of random numbers of the limit
REST_STREAM = 3  # stream of random numbers of moves and rests
GEAR_STREAM = 4  # stream of random numbers of the gear


def log_uniform(generator: np.random.Generator, bounds: tuple[float, float]) -> float:
    """Return a number whose logarithm is drawn evenly between those of two bounds."""
    return float(np.exp(generator.uniform(*np.log(bounds))))


def moves(peak: float, tempo: float, dwell: float) -> dict[str, Any]:
    """Return a reference of moves with a speed (rad/s), a tempo (Hz) and rests (s) between them."""
    return {
        "kind": "point_to_point",
        "distance": peak * 1.5 / tempo,
        "speed": peak,
        "acceleration": 2.0 * math.pi * tempo * peak,
        "dwell": dwell,
    }


def with_fine_steps(table: dict[str, Any], joint: dict[str, Any], period: float) -> Scenario:
    """Return a scenario whose joint is simulated in steps as short as it asks for, parts of a sampling period (s)."""
    parts = math.ceil(period / LONGEST_STEP + 3.0)
    while True:
        try:
            return Scenario(**{**table, "joint": {**joint, "solver_period": period / parts}})
        except ValidationError as error:
            if "solver_period" not in str(error) or parts > 1000:
                raise
            parts *= 2


def draw_machine(seed: int, draw: int) -> Scenario:
    """Return a machine, what is known of it, and a reference for it.

    Given are its inertia (off by up to 1.25), the delay of its drive, and a Stribeck velocity (off by up to 2, with a
    shape of 1 where half the machines have 2). Noise and phases of the plan are those of the draw, with any seed.
    """
    generator = np.random.default_rng([seed, draw])

    def wide(bounds: tuple[float, float]) -> float:
        return log_uniform(generator, bounds)

    def choice(values: Any) -> Any:
        return values[generator.integers(len(values))]

    period, inertia, peak, tempo, kind = choice(PERIODS), wide(INERTIAS), wide(SPEEDS), wide(TEMPOS), choice(KINDS)
    torque = inertia * 2.0 * math.pi * tempo * peak
    coulomb = wide(FRICTION) * torque
    stiction, viscous = float(generator.uniform(1.0, 1.8)) * coulomb, float(generator.uniform(0.0, 1.5)) * coulomb
    stribeck_velocity, way = peak * wide(STRIBECK_VELOCITIES), peak * wide(PRESLIDING)
    lag = choice((0.0, 1.0, 1.0)) * wide(LAGS)
    delay, noise = choice(tuple(DELAYS)), peak * wide(NOISE)
    bandwidth = float(generator.uniform(*BANDWIDTHS)) / period * DELAYS[delay]
    joint = {
        "kind": kind,
        "inertia": inertia,
        "coulomb": coulomb,
        "stiction": stiction,
        "viscous": viscous / peak,
        "stribeck_velocity": stribeck_velocity,
        "stribeck_shape": choice((1.0, 2.0)),
    }
    joint |= {"stiffness": coulomb / way} if kind == "lugre" else {"friction_lag": lag}
    joint |= {"presliding": way} if kind == "elasto_plastic" else {}
    sensor = choice(({"velocity_noise": noise}, {"velocity_noise": noise}, {"encoder_resolution": noise * period}))
    plans: list[dict[str, Any]] = [
        {
            "kind": "multisine",
            "peak": peak,
            "frequencies": [2.5 * tempo * each for each in (0.03, 0.11, 0.23, 0.41, 1.0)],
            "amplitudes": [0.12, 0.1, 0.08, 0.06, 0.03],
        },
        {"kind": "triangle", "peak": peak, "period": 4.0 / (2.0 * math.pi * tempo)},
        moves(peak, tempo, 0.5 / tempo),
    ]
    strength = 3.0 * (stiction + viscous + 4.0 * torque) + 60.0 * math.pi * inertia * bandwidth * noise
    table = {
        "duration": 60.0,
        "seed": draw,
        "sampling": {"period": period},
        "sensor": sensor,
        "velocity": {"cutoff": min(5.0 * bandwidth, 0.4 / period)},
        "actuator": {"torque_limit": strength, "delay": delay * period},
        "reference": choice(plans),
        "feedback": {"inertia": inertia * wide((0.8, 1.25)), "bandwidth": bandwidth},
        "adaptation": {"stribeck_velocity": stribeck_velocity * wide((0.5, 2.0))},
        "fixed": {"inertia": inertia, "coulomb": coulomb, "viscous": viscous / peak},
    }
    return with_fine_steps(table, joint, period)


def draw_cascade(seed: int, draw: int) -> Scenario:
    """Return the machine of :func:`draw_machine` with a weight that turns with it, behind a position loop.

    That gravity is there is given, how much is not. The position loop has the default gain, a sixth of the bandwidth of
    the velocity loop. The encoder of the position makes a count a period at the speed of the machine's noise.
    """
    machine, generator = draw_machine(seed, draw), np.random.default_rng([seed, draw, WEIGHT_STREAM])
    weight = machine.joint.coulomb * log_uniform(generator, WEIGHTS)
    sensor, period = machine.sensor, machine.sampling.period
    return machine.modified(
        joint={"gravity": weight, "gravity_phase": float(generator.uniform(-math.pi, math.pi))},
        actuator={"torque_limit": machine.actuator.torque_limit + 3.0 * weight},
        adaptation={"identify": "gravity"},
        position={"encoder_resolution": sensor.encoder_resolution or sensor.velocity_noise * period},
    )


def draw_resting(seed: int, draw: int) -> Scenario:
    """Return the machine of :func:`draw_cascade`, which moves to and fro between rests of 1 to 20 s."""
    machine, generator = draw_cascade(seed, draw), np.random.default_rng([seed, draw, REST_STREAM])
    tempo, rest = log_uniform(generator, TEMPOS), log_uniform(generator, RESTS)
    peak = float(np.max(np.abs(machine.reference_velocity())))
    return machine.modified(duration=LASTS, reference=moves(peak, tempo, rest))


def draw_elastic(seed: int, draw: int) -> Scenario:
    """Return the machine of :func:`draw_machine` with an elastic gear (even draws), or with one that has play as well.

    Nothing of the gear is given. Friction is that of the motor, the Stribeck curve with its lag.
    """
    machine, generator = draw_machine(seed, draw), np.random.default_rng([seed, draw, GEAR_STREAM])
    fraction, inertia = float(generator.uniform(*LINK_FRACTIONS)), machine.joint.inertia
    reduced = fraction * (1.0 - fraction) * inertia
    resonance = 2.0 * math.pi * machine.feedback.bandwidth * log_uniform(generator, RESONANCES)
    joint = machine.joint.model_dump(include=RIGID) | {
        "kind": "backlash" if draw % 2 else "elastic",
        "link_share": fraction,
        "link_stiffness": resonance**2 * reduced,
        "link_damping": 2.0 * GEAR_DAMPING * resonance * reduced,
    }
    if draw % 2:
        joint["gap"] = float(np.max(np.abs(machine.reference_velocity()))) * log_uniform(generator, GAPS)
    return with_fine_steps(machine.model_dump(exclude_defaults=True), joint, machine.sampling.period)


def draw_saturating(seed: int, draw: int) -> Scenario:
    """Return a joint drawn around the built-in one (even draws) or a machine, whose drive saturates unreported.

    The controllers know only what they ask the drive for. Its limit is a fraction of the torque that true parameters
    need along the plan.
    """
    scenario = (draw_machine if draw % 2 else draw_joint)(seed, draw // 2)
    without = {"torque_limit": None} if scenario.actuator.torque_limit else {}
    run = simulate(scenario.modified(actuator=without), "oracle", uncertain=False)
    fraction = float(np.random.default_rng([seed, draw, SATURATION_STREAM]).uniform(*SATURATIONS))
    needed = fraction * float(np.quantile(np.abs(run.torque), PEAK_QUANTILE))
    limit = max(needed, ABOVE_STICTION * scenario.joint.stiction)
    return scenario.modified(actuator={"torque_limit": limit, "reports_torque": False})


def draw_joint(seed: int, draw: int) -> Scenario:
    """Return a joint drawn around the built-in one."""
    return draw_scenario(load_scenario(), seed, draw)


def _steepness(scenario: Scenario) -> str:
    return class_of(fall_over_gain(scenario))


def _kind(scenario: Scenario) -> str:
    return {"elastic": "elastic gear", "backlash": "play"}.get(scenario.joint.kind, scenario.joint.kind)


DRAWN: dict[str, tuple[Callable[[int, int], Scenario], Callable[[Scenario], str] | tuple[str, ...]]] = {
    "joint": (draw_joint, _steepness),
    "machine": (draw_machine, _kind),
    "cascade": (draw_cascade, _kind),
    "rests": (draw_resting, _kind),
    "gear": (draw_elastic, _kind),
    "saturating": (draw_saturating, ("joint", "machine")),
}
"""What is drawn, by name, and the rows: of a joint by how steeply its friction falls over Kp; a tuple in turn."""


def scenarios(kind: str, count: int, draws: int = 1, first: int = 1) -> list[Case]:
    """Return so many draws of a kind."""
    draw, row = DRAWN[kind]
    rows = [row[place % len(row)] if isinstance(row, tuple) else row for place in range(count)]
    return [Case(f"{kind}/{n}", n, partial(tracked, rows[n], partial(draw, first), draws, n)) for n in range(count)]
