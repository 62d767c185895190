"""Joints drawn around the built-in one, and machines over decades of size, speed and sampling rate.

The same in a cascade: with a weight, behind a position loop; there with rests of seconds between moves as well. And
with drives that saturate and do not report it, and with elastic gears.
"""

import math
import tomllib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from adaptive_ff import Scenario, load_scenario, simulate
from adaptive_ff.scenario.loop import fall_over_gain
from adaptive_ff.studies.sweep import class_of, draw_scenario
from benchmarks.running import tracked
from benchmarks.suite import Case

RANGES = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
DELAYS = {0: 1.0, 1: 0.45, 2: 0.3}  # periods of delay of the drive, and the fraction of the bandwidth that they leave
LONGEST_STEP = 1e-3  # step of the simulated joint, s, about; shorter where its friction asks for it
KINDS = ("stribeck", "lugre", "elasto_plastic")  # kinds of friction, as often the one as the other

RIGID = {"inertia", "coulomb", "stiction", "viscous", "stribeck_velocity", "stribeck_shape", "friction_lag"}
"""Fields of a joint that one with an elastic gear has as well, the lag but of one without LuGre friction."""

GEAR_DAMPING = 0.05  # damping of the resonance of a gear

PEAK_QUANTILE = 0.995
"""Fraction of the time in which the needed torque is no larger than its peak: single peaks are of noise."""

ABOVE_STICTION = 1.02  # least limit of such a drive over the stiction of its joint, which it would never move otherwise
draw_joint = partial(draw_scenario, load_scenario())  # a joint drawn around the built-in one, by seed and draw
LASTS = 120.0  # duration of the run of a machine that rests, s
WEIGHT, SATURATION, REST, GEAR = 1, 2, 3, 4  # streams of random numbers of what is drawn beside the machine


def log_uniform(generator: np.random.Generator, name: str) -> float:
    """Return a number of a range by name, whose logarithm is drawn evenly."""
    return float(np.exp(generator.uniform(*np.log(RANGES[name]))))


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

    wide = partial(log_uniform, generator)

    def choice(values: Any) -> Any:
        return values[generator.integers(len(values))]

    period, inertia, peak = choice(RANGES["periods"]), wide("inertia"), wide("speed")
    tempo, kind = wide("tempo"), choice(KINDS)
    torque = inertia * 2.0 * math.pi * tempo * peak
    coulomb = wide("friction") * torque
    stiction, viscous = float(generator.uniform(1.0, 1.8)) * coulomb, float(generator.uniform(0.0, 1.5)) * coulomb
    stribeck_velocity, way = peak * wide("stribeck_velocity"), peak * wide("presliding")
    lag = choice((0.0, 1.0, 1.0)) * wide("lag")
    delay, noise = choice(tuple(DELAYS)), peak * wide("noise")
    bandwidth = float(generator.uniform(*RANGES["bandwidth"])) / period * DELAYS[delay]
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
        "feedback": {"inertia": inertia * wide("inertia_error"), "bandwidth": bandwidth},
        "adaptation": {"stribeck_velocity": stribeck_velocity * wide("stribeck_error")},
        "fixed": {"inertia": inertia, "coulomb": coulomb, "viscous": viscous / peak},
    }
    return with_fine_steps(table, joint, period)


def draw_cascade(seed: int, draw: int) -> Scenario:
    """Return the machine of :func:`draw_machine` with a weight that turns with it, behind a position loop.

    That gravity is there is given, how much is not. The position loop has the default gain, a sixth of the bandwidth of
    the velocity loop. The encoder of the position makes a count a period at the speed of the machine's noise.
    """
    machine, generator = draw_machine(seed, draw), np.random.default_rng([seed, draw, WEIGHT])
    weight = machine.joint.coulomb * log_uniform(generator, "weight")
    sensor, period = machine.sensor, machine.sampling.period
    return machine.modified(
        joint={"gravity": weight, "gravity_phase": float(generator.uniform(-math.pi, math.pi))},
        actuator={"torque_limit": machine.actuator.torque_limit + 3.0 * weight},
        adaptation={"identify": "gravity"},
        position={"encoder_resolution": sensor.encoder_resolution or sensor.velocity_noise * period},
    )


def draw_resting(seed: int, draw: int) -> Scenario:
    """Return the machine of :func:`draw_cascade`, which moves to and fro between rests of 1 to 20 s."""
    machine, generator = draw_cascade(seed, draw), np.random.default_rng([seed, draw, REST])
    tempo, rest = log_uniform(generator, "tempo"), log_uniform(generator, "rest")
    peak = float(np.max(np.abs(machine.reference_velocity())))
    return machine.modified(duration=LASTS, reference=moves(peak, tempo, rest))


def draw_elastic(seed: int, draw: int) -> Scenario:
    """Return the machine of :func:`draw_machine` with an elastic gear (even draws), or with one that has play as well.

    Nothing of the gear is given. Friction is that of the motor, the Stribeck curve with its lag.
    """
    machine, generator = draw_machine(seed, draw), np.random.default_rng([seed, draw, GEAR])
    fraction, inertia = float(generator.uniform(*RANGES["link_fraction"])), machine.joint.inertia
    reduced = fraction * (1.0 - fraction) * inertia
    resonance = 2.0 * math.pi * machine.feedback.bandwidth * log_uniform(generator, "resonance")
    joint = machine.joint.model_dump(include=RIGID) | {
        "kind": "backlash" if draw % 2 else "elastic",
        "link_share": fraction,
        "link_stiffness": resonance**2 * reduced,
        "link_damping": 2.0 * GEAR_DAMPING * resonance * reduced,
    }
    if draw % 2:
        joint["gap"] = float(np.max(np.abs(machine.reference_velocity()))) * log_uniform(generator, "gap")
    return with_fine_steps(machine.model_dump(exclude_defaults=True), joint, machine.sampling.period)


def draw_saturating(seed: int, draw: int) -> Scenario:
    """Return a joint drawn around the built-in one (even draws) or a machine, whose drive saturates unreported.

    The controllers know only what they ask the drive for. Its limit is a fraction of the torque that true parameters
    need along the plan.
    """
    scenario = (draw_machine if draw % 2 else draw_joint)(seed, draw // 2)
    without = {"torque_limit": None} if scenario.actuator.torque_limit else {}
    run = simulate(scenario.modified(actuator=without), "oracle", uncertain=False)
    fraction = float(np.random.default_rng([seed, draw, SATURATION]).uniform(*RANGES["saturation"]))
    needed = fraction * float(np.quantile(np.abs(run.torque), PEAK_QUANTILE))
    limit = max(needed, ABOVE_STICTION * scenario.joint.stiction)
    return scenario.modified(actuator={"torque_limit": limit, "reports_torque": False})


def row_of(kind: str, draw: int, scenario: Scenario) -> str:
    """Return the row of a draw: of a joint how steeply its friction falls over Kp, else its kind."""
    if kind == "joint":
        return class_of(fall_over_gain(scenario))
    if kind == "saturating":
        return "machine" if draw % 2 else "joint"
    return {"elastic": "elastic gear", "backlash": "play"}.get(scenario.joint.kind, scenario.joint.kind)


DRAWN: dict[str, Callable[[int, int], Scenario]] = {
    "joint": draw_joint,
    "machine": draw_machine,
    "cascade": draw_cascade,
    "rests": draw_resting,
    "gear": draw_elastic,
    "saturating": draw_saturating,
}
"""What is drawn, by kind."""


def scenarios(kind: str, count: int, draws: int = 1, first: int = 1) -> list[Case]:
    """Return so many draws of a kind."""
    make = partial(DRAWN[kind], first)
    return [Case(f"{kind}/{n}", n, partial(tracked, partial(row_of, kind, n), make, draws, n)) for n in range(count)]
