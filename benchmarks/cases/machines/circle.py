"""The tip of the two-link arm along a circle, as a ball bar tests a machine: a joint reverses twice in each lap.

Each joint has its position loop and learns friction and gravity; the error is the distance of the tip from its target.
"""

import math

import numpy as np

from adaptive_ff.simulation.tracking_errors import figures_of, tracking_errors
from adaptive_ff.studies.study import Found
from benchmarks.cases.machines.robots import Array, Plan, Setup, drive, make_machine
from benchmarks.suite import seeded

LINKS = 0.6, 0.5  # m
POSE = 0.9, 0.7  # rad, of the links at the outermost point, where the circle begins; the second from the first
RADIUS, LAP, LAPS = 0.1, 4.0, 10  # m, s
RATE = 500  # Hz
SETUP = Setup(RATE, cascade=True, gravity_given=False)


def chain(position: Array) -> Array:
    """Return elbow and tip, each ``forward - 1j * down`` of the shoulder, m, for angles of the joints (rad)."""
    upper = np.exp(-1j * (math.pi / 2.0 - POSE[0] - position[..., 0]))
    lower = upper * np.exp(1j * (POSE[1] + position[..., 1]))
    return np.stack([LINKS[0] * upper, LINKS[0] * upper + LINKS[1] * lower])


OUTERMOST = complex(chain(np.zeros(2))[1])
CENTRE = OUTERMOST * (1.0 - RADIUS / abs(OUTERMOST))


def circle(period: float) -> Plan:
    """Plan the laps, the first from rest to full speed, at samples a period (s) apart."""
    time = period * np.arange(round(LAP * LAPS / period) + 1)
    angle = 2.0 * math.pi / LAP * np.where(time < LAP, time**2 / (2.0 * LAP), time - LAP / 2.0)
    target = CENTRE + (OUTERMOST - CENTRE) * np.exp(1j * angle)
    elbow = np.arccos((np.abs(target) ** 2 - LINKS[0] ** 2 - LINKS[1] ** 2) / (2.0 * LINKS[0] * LINKS[1]))
    shoulder = np.angle(1j * target / (LINKS[0] + LINKS[1] * np.exp(1j * elbow)))
    position = np.stack([shoulder - POSE[0], elbow - POSE[1]], axis=-1)
    return Plan(np.gradient(position, period, axis=0), position)


def laps_of(name: str, friction: str, seed: int) -> tuple[Array, Array]:
    """Return where a controller takes the tip, and its target, m, as complex numbers."""
    machine, plan = make_machine("two-link arm", friction), circle(1.0 / RATE)
    error = drive(machine, name, plan, SETUP, seed).position_error
    target = plan.position[:-1]
    return chain(target - error)[1], chain(target)[1]


def run_circle(friction: str, seed: int, controllers: list[str]) -> Found:
    """Run the laps; errors are distances of the tip from its target, m."""
    errors = {}
    for name in dict.fromkeys(["pi", *controllers]):
        tip, target = laps_of(name, friction, seed)
        errors[name] = tracking_errors(np.abs(tip - target) ** 2, 1.0 / RATE)
    return {"": {"row": friction}, **figures_of(errors)}


laps = seeded(run_circle, {friction: (friction,) for friction in ("coulomb", "LuGre")})
