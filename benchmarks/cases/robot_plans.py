"""Plans of all joints of a machine at the instants of the controllers: multisines, and moves from point to point."""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff import load_scenario
from benchmarks.cases.robot_machines import Axis

Array = NDArray[np.float64]

SINES = 6
SLOWEST, FASTEST = 0.1, 0.9  # Hz
FADE = 2.0  # s, in which a multisine rises from rest
SPEED, ACCELERATION, JERK = (0.3, 0.9), 2.0, 40.0  # rad/s (drawn between these), rad/s^2, rad/s^3
DWELL = 0.5  # s


class Plan(NamedTuple):
    """What the joints are to do, at samples 0 to n inclusive."""

    velocity: Array  # velocity, position: shape (n + 1, joints): planned velocity, rad/s, and its integral, rad
    position: Array


def multisines(axes: tuple[Axis, ...], seed: int, duration: float, period: float) -> Plan:
    """Draw a sum of sines for each axis, which rises from rest and keeps within its swing."""
    time = period * np.arange(round(duration / period) + 1)
    fraction = np.clip(time / FADE, 0.0, 1.0)
    rise, slope = (
        fraction**3 * (10.0 - 15.0 * fraction + 6.0 * fraction**2),
        30.0 * fraction**2 * (1.0 - fraction) ** 2 / FADE,
    )
    velocity, position = np.zeros((2, time.size, len(axes)))
    for place, axis in enumerate(axes):
        generator = np.random.default_rng([seed, place, 5])
        omega = 2.0 * math.pi * generator.uniform(SLOWEST, FASTEST, (SINES, 1))
        phase = omega * time + generator.uniform(0.0, 2.0 * math.pi, (SINES, 1))
        wave, rate = np.sum(np.sin(phase) / omega, axis=0), np.sum(np.cos(phase), axis=0)
        size = axis.swing / np.max(np.abs(wave))
        position[:, place] = size * rise * wave
        velocity[:, place] = size * (slope * wave + rise * rate)
    return Plan(velocity, position)


def moves(axes: tuple[Axis, ...], seed: int, duration: float, period: float) -> Plan:
    """Draw moves from point to point for each axis, with a rest after each."""
    columns = []
    for place, axis in enumerate(axes):
        scenario = load_scenario().modified(
            duration=duration + period,
            reference=_points(axis, np.random.default_rng([seed, place, 7]), duration),
            sampling={"period": period},
            joint={"solver_period": period},
        )
        columns.append(scenario.reference_velocity()[: round(duration / period) + 1])
    velocity = np.column_stack(columns)
    steps = 0.5 * period * (velocity[1:] + velocity[:-1])
    return Plan(velocity, np.vstack([np.zeros(len(axes)), np.cumsum(steps, axis=0)]))


def then_rest(plan: Plan, rest: float, period: float) -> Plan:
    """Let each axis end where it was last at rest in a plan, and stay there to its end and for ``rest`` (s) more."""
    velocity = np.vstack([plan.velocity, np.zeros((round(rest / period), plan.velocity.shape[1]))])
    position = np.vstack([plan.position, np.repeat(plan.position[-1:], round(rest / period), axis=0)])
    for place, planned in enumerate(plan.velocity.T):
        last = np.flatnonzero(planned == 0.0)[-1]
        velocity[last:, place], position[last:, place] = 0.0, plan.position[last, place]
    return Plan(velocity, position)


def _points(axis: Axis, generator: np.random.Generator, duration: float) -> dict[str, Any]:
    speed, elapsed, positions = float(generator.uniform(*SPEED)), 0.0, [0.0]
    while elapsed < duration:
        positions.append(round(float(generator.uniform(-axis.swing, axis.swing)), 3))
        elapsed += abs(positions[-1] - positions[-2]) / speed + speed / ACCELERATION + ACCELERATION / JERK + DWELL
    return {
        "kind": "point_to_point",
        "positions": positions[1:],
        "speed": speed,
        "acceleration": ACCELERATION,
        "jerk": JERK,
        "dwell": DWELL,
        "repeats": 1,
    }
