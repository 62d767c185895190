"""Corrections that mean harm, on the built-in joint: how much worse than PI alone the compensation makes them.

``python -m benchmarks.hostile_corrections [--first-seed 1 --seeds 5]``

An outer loop asks for up to 0.2 rad/s beside the plan, by a rule that no position loop would follow. The controllers
are stepped from a loop of one's own, as on a machine: 12 s of the plan alone, so that friction is learnt, then 12 s
with the correction. Shown is the rms of plan and correction less the joint's velocity over these 12 s, root mean square
over the seeds, of ``pi`` and of ``adaptive``, and their ratio, with the largest ratio of a single seed.
"""

import math
from collections.abc import Callable
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff import WITH_GRAVITY, load_scenario
from adaptive_ff.comparison.registry import make_adaptive
from benchmarks.wide import wide_console
from controllers import PI, Controller
from plant import Joint

CORRECTION, LIMIT = 0.2, 400.0  # rad/s, N m
LEARNING, HOSTILE = 12.0, 12.0  # s

Rule = Callable[[int, float], float]
Array = NDArray[np.float64]


def rules(period: float, seed: int) -> dict[str, Rule]:
    """Return the corrections, as shares of the largest, by sample and position (rad)."""
    draws = np.random.default_rng([seed, 5]).uniform(-1.0, 1.0, round((LEARNING + HOSTILE) / period))
    return {
        "none": lambda sample, position: 0.0,
        "square wave of 1.4 Hz": lambda sample, position: math.copysign(1.0, math.sin(9.0 * sample * period)),
        "another sign at every sample": lambda sample, position: (-1.0) ** sample,
        "drawn at every sample": lambda sample, position: float(draws[sample]),
        "away from where the joint is": lambda sample, position: math.copysign(1.0, math.sin(5.0 * position)),
    }


def squared_error(controller: Controller, rule: Rule, joint: Joint, plan: Array, noise: Array, period: float) -> float:
    """Return the mean squared error (rad^2/s^2) under a correction, for one plan and noise by sample."""
    steps, errors = round(period / joint.model.solver_period), []
    for sample in range(noise.size):
        state, begun = joint.state, sample * period >= LEARNING
        correction = CORRECTION * rule(sample, state.position) if begun else 0.0
        if begun:
            errors.append(plan[sample] + correction - state.velocity)
        torque = controller.step(
            plan[sample],
            state.velocity + noise[sample],
            next_reference=plan[sample + 1],
            correction=correction,
            position=state.position,
        )
        for _ in range(steps):
            joint.step(min(max(torque, -LIMIT), LIMIT), period / steps)
    return float(np.mean(np.square(errors)))


def measure(seed: int) -> dict[str, list[float]]:
    """Return the mean squared errors of PI and adaptive by the name of the correction."""
    scenario = load_scenario().modified(seed=seed, duration=LEARNING + HOSTILE)
    period = scenario.sampling.period
    plan = scenario.reference_velocity()[:: round(period / scenario.joint.solver_period)]
    noise = scenario.sensor.velocity_noise * np.random.default_rng([seed, 6]).standard_normal(plan.size - 1)
    found = {}
    for name, rule in rules(period, seed).items():
        own = make_adaptive(scenario, parameters=WITH_GRAVITY, torque_limit=LIMIT)
        found[name] = [
            squared_error(controller, rule, Joint(scenario.joint), plan, noise, period)
            for controller in (PI(*scenario.feedback.gains, period), own)
        ]
    return found


def main(
    first_seed: Annotated[int, typer.Option(min=0, help="First seed; 101 and more while tuning.")] = 1,
    seeds: Annotated[int, typer.Option(min=1, help="Number of seeds.")] = 5,
) -> None:
    """Print the errors of PI and adaptive under each correction."""
    table = Table(title=f"corrections of up to {CORRECTION:g} rad/s", box=SIMPLE)
    for heading in ("correction", "pi, mrad/s", "adaptive, mrad/s", "ratio", "worst seed"):
        table.add_column(heading, justify="left" if heading == "correction" else "right")
    found = [measure(seed) for seed in range(first_seed, first_seed + seeds)]
    for name in found[0]:
        squares = np.array([one[name] for one in found])
        pi, own = 1e3 * np.sqrt(np.mean(squares, axis=0))
        worst = float(np.sqrt(np.max(squares[:, 1] / squares[:, 0])))
        table.add_row(name, f"{pi:.3g}", f"{own:.3g}", f"{own / pi:.2f}", f"{worst:.2f}")
    wide_console().print(table)


if __name__ == "__main__":
    typer.run(main)
