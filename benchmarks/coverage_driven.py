"""How honest the intervals of ``identify`` are where PI alone drives a joint: ``python -m benchmarks.coverage_driven``.

Logs as a laboratory would record them, of the joints, sensors and loops of ``other_joints``: nothing of the
package's plant. Friction has a stiction that falls with the square of the speed, which the identified models have
in another shape; the joint sticks at its reversals, for moments or for seconds; motion is not designed to identify
anything. Recorded are the encoder's position, or the velocity of a tachometer, and the torque with noise of 0.5 to 5 %
of the Coulomb friction. Friction has no lag in any.
"""

from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer

from adaptive_ff.files import write_json
from adaptive_ff.logs.log import Log
from benchmarks.cases.other_joints import draw, drive, loop_gains
from benchmarks.coverage import coverage_table, examine
from benchmarks.in_turn import CORES, Workers, run_seeds
from benchmarks.wide import wide_console
from controllers import PI

NOISES = (0.005, 0.05)
"""Least and largest noise of the recorded torque, over the Coulomb friction."""

STREAM = 79
"""Stream of random numbers of that noise."""

COARSE = 3.0
"""Counts in a sample at half of the largest planned speed below which an encoder counts as coarse."""


class Driven(NamedTuple):
    """A log with its truth, the time (s) after its stamp at which a torque acts, and what the log lacks."""

    log: Log
    truth: dict[str, float]
    delay: float
    kind: str


def driven_case(seed: int) -> Driven:
    """Return the log of a seed."""
    joint, loop, plan = draw(seed)
    run = drive(PI(*loop_gains(joint, loop)), joint, loop, plan, seed)
    random = np.random.default_rng([seed, STREAM])
    noise = joint.coulomb * NOISES[0] * (NOISES[1] / NOISES[0]) ** random.random()
    torque = run.torques + noise * random.standard_normal(run.torques.size)
    tachometer = loop.sensor == "tachometer"
    motion = {"velocity": run.measured} if tachometer else {"position": run.readings}
    log = Log(f"joint {seed}", run.times, torque, **motion)
    velocity = np.gradient(run.readings, run.times) if not tachometer else run.measured
    speed = np.abs(velocity)
    falling = (joint.stiction - joint.coulomb) * np.exp(-((speed / joint.stribeck_velocity) ** 2))
    static = np.sign(velocity) * (joint.coulomb + falling) + joint.viscous * velocity
    slides = speed > 0.02 * np.quantile(speed, 0.95)
    line = np.linalg.lstsq(np.column_stack([np.sign(velocity), velocity])[slides], static[slides])[0]
    truth = {"inertia": joint.inertia, "coulomb": float(line[0]), "viscous": float(line[1])}
    counts = 0.5 * float(np.abs(plan).max()) * loop.period / loop.resolution
    kind = "coarse encoder" if counts < COARSE and not tachometer else "cogging" if joint.cogging > 0.0 else "other"
    return Driven(log, truth, 0.5 * loop.period, kind)


def examine_seed(seed: int) -> dict[str, Any]:
    """Identify the log of a seed, and compare the intervals with the truth."""
    case = driven_case(seed)
    return {**examine(case.log, case.truth, torque_delay=case.delay), "kind": case.kind}


def main(
    logs: Annotated[int, typer.Option(min=1, help="Number of logs.")] = 200,
    first: Annotated[int, typer.Option(min=0, help="Seed of the first log.")] = 1,
    workers: Workers = CORES,
    json: Annotated[Path | None, typer.Option(help="Write all results there.")] = None,
) -> None:
    """Print coverage and width of the stated intervals, by what the logs lack."""
    results = run_seeds(examine_seed, range(first, first + logs), workers, "logs")
    console = wide_console()
    console.print(coverage_table([[result] for result in results], "joints under PI alone"))
    for kind in ("other", "cogging", "coarse encoder"):
        found = [result for result in results if result["kind"] == kind and result["refused"] is None]
        held = [sum(name in one and one[name]["covers"] for one in found) for name in ("inertia", "coulomb", "viscous")]
        console.print(f"{kind}: inertia, Coulomb and viscous friction held in {held} of {len(found)}", highlight=False)
    if json is not None:
        write_json(json, {"logs": results})


if __name__ == "__main__":
    typer.run(main)
