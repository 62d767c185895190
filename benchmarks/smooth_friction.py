"""Friction whose sign is smoothed, as simulations write it: ``python -m benchmarks.smooth_friction``.

The joint has ``F(w) = Fc tanh(w/width) + Fv w``: it creeps where real friction would hold it, and no model in this
package is of that form. It is integrated here, implicitly, not by ``plant``. It is driven along multisines (velocity
loop, noise of 2 mrad/s) or from point to point behind a position loop (encoder of 6 urad). ``fed`` is the PI loop with
the true friction and inertia fed forward, which is not told that a velocity made of positions is half a period late;
``adaptive`` knows that and the inertia, and learns the rest. ``told`` is the same controller that is given the torque
of the last period (``realised_torque``): to one that is told nothing friction that goes on rising looks like a drive at
its limit at first.

Errors are roots of mean squares over the seeds, of the velocity, or of the position behind a position loop; PI's error
is given over that of ``adaptive`` and of ``fed``, in the second half of a run, and over that of ``adaptive`` in the
first 5 s: above 1 is better than PI.
"""

import math
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer
from numpy.typing import NDArray
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff import AdaptiveController
from adaptive_ff.files import write_json
from benchmarks.robot.in_turn import CORES, First, Only, Seeds, Workers, chosen_cases, run_in_turn
from benchmarks.robot.loops import BANDWIDTH, RESOLUTION, VELOCITY_NOISE
from benchmarks.robot.machines import Axis
from benchmarks.robot.plans import Plan, moves, multisines
from benchmarks.wide import wide_console
from controllers import PI, PositionLoop

WIDTHS = (0.002, 0.01, 0.05, 0.2)
"""Speeds at which three quarters of the Coulomb friction are there, rad/s; plans reach 1 rad/s and less."""

JOINTS = {2.0: (15.0, 10.0), 20.0: (60.0, 80.0)}
"""Coulomb (N m) and viscous friction (N m s/rad) by inertia, kg m^2."""

STEP = 1e-3  # s, of the physics at most
START = 5.0  # s
NEWTON, CLOSE = 50, 1e-13  # iterations at most, and the change of speed, rad/s, that ends them


class Case(NamedTuple):
    """A joint and how it is driven.

    Attributes
    ----------
    inertia : float
        Inertia, kg m^2.
    width : float
        Width of the smoothed sign, rad/s.
    rate : int
        Sampling rate, Hz.
    cascade : bool
        Whether a position loop is outside.
    """

    inertia: float
    width: float
    rate: int
    cascade: bool

    @property
    def name(self) -> str:
        """Its name in the table."""
        loop = "moves, position loop" if self.cascade else "multisine, velocity loop"
        return f"{self.inertia:g} kg m², {loop}, {self.rate} Hz, {1e3 * self.width:g} mrad/s"


def cases() -> list[Case]:
    """Return all of them."""
    kinds = [(cascade, rate) for cascade in (False, True) for rate in (100, 500)]
    return [Case(inertia, width, rate, cascade) for inertia in JOINTS for cascade, rate in kinds for width in WIDTHS]


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


def errors_of(
    case: Case, controller: Any, plan: Plan, seed: int, *, feeds: bool = False, tells: bool = False
) -> NDArray[np.float64]:
    """Return mean squares of the error, in the second half and in the first 5 s.

    The true friction and inertia may be fed, and the controller told the torque of the last period.
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
    square = np.square(errors)
    return np.array([np.mean(square[square.size // 2 :]), np.mean(square[: round(START * case.rate)])])


def run_case(case: Case, seeds: range, duration: float) -> dict[str, Any]:
    """Return the figures of a case."""
    period, (coulomb, viscous) = 1.0 / case.rate, JOINTS[case.inertia]
    axes, lag = (Axis("joint", coulomb, viscous, (), False, 0.6),), 0.5 * period if case.cascade else 0.0
    design = PI.design(inertia=case.inertia, period=period, bandwidth=BANDWIDTH)
    gains, total = (design.proportional, design.integral), np.zeros((4, 2))
    for seed in seeds:
        plan = (moves if case.cascade else multisines)(axes, seed, duration, period)
        known = {"inertia": case.inertia, "stribeck_velocity": 0.05, "velocity_lag": lag}
        total[0] += errors_of(case, PI(*gains, period), plan, seed)
        total[1] += errors_of(case, AdaptiveController(*gains, period, **known), plan, seed)
        total[2] += errors_of(case, AdaptiveController(*gains, period, **known), plan, seed, tells=True)
        total[3] += errors_of(case, PI(*gains, period), plan, seed, feeds=True)
    errors = np.sqrt(total / len(seeds))
    return {
        "case": case.name,
        "pi": float(errors[0, 0]),
        "settled": float(errors[0, 0] / errors[1, 0]),
        "start": float(errors[0, 1] / errors[1, 1]),
        "told": float(errors[0, 0] / errors[2, 0]),
        "told_start": float(errors[0, 1] / errors[2, 1]),
        "fed": float(errors[0, 0] / errors[3, 0]),
        "position": case.cascade,
    }


def table_of(rows: list[dict[str, Any]]) -> Table:
    """Return the table."""
    table = Table(title="PI's error over that of adaptive, and with the truth fed", box=SIMPLE, title_style="bold")
    table.add_column("inertia, motion, rate, width")
    for heading in ("pi", "pi / adaptive", "first 5 s", "pi / told", "first 5 s", "pi / fed"):
        table.add_column(heading, justify="right")
    for row in rows:
        ratios = [f"{row[name]:.2f}" for name in ("settled", "start", "told", "told_start", "fed")]
        table.add_row(row["case"], f"{1e3 * row['pi']:.3g} {'mrad' if row['position'] else 'mrad/s'}", *ratios)
    return table


def main(
    only: Only = "",
    seeds: Seeds = 5,
    first: First = 1,
    duration: Annotated[float, typer.Option(min=12.0, help="Length of a run, s.")] = 40.0,
    workers: Workers = CORES,
    json: Annotated[Path | None, typer.Option(help="Write the figures there.")] = None,
) -> None:
    """Drive joints whose friction is smoothed, and print how much is gained."""
    rows = run_in_turn(run_case, chosen_cases(cases(), only), range(first, first + seeds), duration, workers)
    console = wide_console()
    console.print(table_of(rows))
    worse = sum(min(row["settled"], row["start"]) < 1.0 for row in rows)
    console.print(f"{worse} of {len(rows)} cases are worse than PI, settled or in the first 5 s", highlight=False)
    if json is not None:
        write_json(json, rows)


if __name__ == "__main__":
    typer.run(main)
