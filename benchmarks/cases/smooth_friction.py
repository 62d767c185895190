"""Friction whose sign is smoothed, as simulations write it: no model in this package is of that form.

The joint has ``F(w) = Fc tanh(w/width) + Fv w``: it creeps where real friction would hold it. It is integrated here,
implicitly. It is driven along multisines (velocity loop, noise of 2 mrad/s) or from point to point behind a position
loop (encoder of 6 urad). ``model_based`` is the PI loop with the true friction and inertia fed forward, which is not
given that a velocity made of positions is half a period late; ``adaptive`` is given that and the inertia, and
``adaptive, torque`` the torque of the last period as well.
"""

import itertools
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.simulation.tracking_errors import figures_of, tracking_errors
from adaptive_ff.studies.study import Found
from benchmarks.cases.machines.robots import BANDWIDTH, RESOLUTION, VELOCITY_NOISE, Axis, Plan, moves, multisines
from benchmarks.cases.stepped import controller_class
from benchmarks.suite import seeded
from controllers import PI, PositionLoop

WIDTHS = (0.002, 0.01, 0.05, 0.2)
"""Speeds at which three quarters of the Coulomb friction are there, rad/s; plans reach 1 rad/s and less."""

JOINTS = {2.0: (15.0, 10.0), 20.0: (60.0, 80.0)}  # coulomb (N m) and viscous friction (N m s/rad) by inertia, kg m^2
STEP = 1e-3  # s, of the physics at most
DURATION = 40.0  # s
FED = "model_based"  # PI with the truth fed forward
NEWTON, CLOSE = 50, 1e-13  # iterations at most, and the change of speed, rad/s, that ends them


class Case(NamedTuple):
    """A joint and how it is driven."""

    inertia: float  # inertia, kg m^2
    cascade: bool  # whether a position loop is outside
    rate: int  # sampling rate, Hz
    width: float  # width of the smoothed sign, rad/s

    @property
    def name(self) -> str:
        """Its name in the table."""
        loop = "moves, position loop" if self.cascade else "multisine, velocity loop"
        return f"{self.inertia:g} kg m², {loop}, {self.rate} Hz, {1e3 * self.width:g} mrad/s"


def friction(case: Case, velocity: float) -> float:
    """Return the friction at a velocity (rad/s), N m."""
    coulomb, viscous = JOINTS[case.inertia]
    return coulomb * math.tanh(velocity / case.width) + viscous * velocity


def next_velocity(case: Case, velocity: float, torque: float, step: float) -> float:
    """Return the velocity (rad/s) after a step (s) of implicit Euler: friction rises, so Newton's method converges."""
    coulomb, viscous = JOINTS[case.inertia]
    low, high = sorted((velocity, velocity + step * (torque - friction(case, velocity)) / case.inertia))
    found = velocity
    for _ in range(NEWTON):
        residual = case.inertia * (found - velocity) - step * (torque - friction(case, found))
        low, high = (low, found) if residual > 0.0 else (found, high)
        bent = 1.0 - math.tanh(found / case.width) ** 2
        better = found - residual / (case.inertia + step * (coulomb * bent / case.width + viscous))
        if not low <= better <= high:
            better = 0.5 * (low + high)
        if abs(better - found) < CLOSE:
            return better
        found = better
    return found


def squares_of(
    case: Case, controller: Any, plan: Plan, seed: int, *, feeds: bool = False, tells: bool = False
) -> NDArray[np.float64]:
    """Return the squared error of each sample.

    The true friction and inertia may be fed, and the controller given the torque of the last period.
    """
    period, generator = 1.0 / case.rate, np.random.default_rng([seed, 3])
    substeps = math.ceil(period / STEP)
    outer = PositionLoop(PositionLoop.design(period=period, bandwidth=BANDWIDTH).gain)
    velocity, angle, last, errors = 0.0, float(plan.position[0, 0]), float(plan.position[0, 0]), []
    torque = 0.0
    for k in range(plan.velocity.shape[0] - 1):
        now, following = float(plan.velocity[k, 0]), float(plan.velocity[k + 1, 0])
        inputs = {"next_reference": following, "position": angle}
        if case.cascade:
            reading = RESOLUTION * round(angle / RESOLUTION)
            measured, last = (reading - last) / period, reading
            inputs |= {"position": reading, "correction": outer.step(float(plan.position[k, 0]), reading)}
            errors.append(float(plan.position[k, 0]) - angle)
        else:
            measured = velocity + VELOCITY_NOISE * float(generator.standard_normal())
            errors.append(now - velocity)
        if feeds:
            middle = 0.5 * (now + following)
            inputs["feedforward"] = case.inertia * (following - now) / period + friction(case, middle)
        if tells:
            inputs["realised_torque"] = torque
        torque = controller.step(now, measured, **inputs)
        for _ in range(substeps):
            velocity = next_velocity(case, velocity, torque, period / substeps)
            angle += period / substeps * velocity
    return np.square(errors)


def run_case(case: Case, seed: int, controllers: list[str]) -> Found:
    """Drive a joint along the plan of a seed."""
    period, (coulomb, viscous) = 1.0 / case.rate, JOINTS[case.inertia]
    axes, lag = (Axis("joint", coulomb, viscous, 0.6),), 0.5 * period if case.cascade else 0.0
    design = PI.design(inertia=case.inertia, period=period, bandwidth=BANDWIDTH)
    gains = design.proportional, design.integral, period
    plan = (moves if case.cascade else multisines)(axes, seed, DURATION, period)
    known = {"inertia": case.inertia, "stribeck_velocity": 0.05, "velocity_lag": lag}
    errors = {}
    for name in dict.fromkeys(["pi", *controllers]):
        own, _, given = name.partition(", ")
        made = PI(*gains) if own in ("pi", FED) else controller_class(own)(*gains, **known)
        squares = squares_of(case, made, plan, seed, feeds=own == FED, tells=bool(given))
        errors[name] = tracking_errors(squares, period)
    return {"": {"row": case.name}, **figures_of(errors)}


CASES = itertools.starmap(Case, itertools.product(JOINTS, (False, True), (100, 500), WIDTHS))
joints = seeded(run_case, {case.name: (case,) for case in CASES})
