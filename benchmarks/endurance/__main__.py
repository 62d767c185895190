"""``python -m benchmarks.endurance``: drawn joints through a simulated week at 100 Hz, or an idle hour (``--idle``)."""

from typing import Annotated

import numpy as np
import typer
from rich.console import Console

from benchmarks.endurance import idle
from benchmarks.endurance.week import PART, Week, drawn_joint, live

WORSE = 1.1
"""Settled error at the end over that at the beginning, at most."""

GROWTH = 20.0
"""Growth of the memory, MB, at most."""


def verdict(week: Week) -> str:
    """Return what is wrong with a week, or that nothing is."""
    wrong = {
        "torque beyond the limit": not week.torque <= 1.0,
        "estimates out of bounds": week.outside > 0,
        "error": not week.after <= WORSE * week.before,
        "memory": week.growth > GROWTH,
    }
    return ", ".join(name for name, is_wrong in wrong.items() if is_wrong) or "holds"


def main(
    hours: Annotated[float, typer.Option(min=0.001, help="Length, h; a week, or an hour for --idle.")] = 168.0,
    joints: Annotated[int, typer.Option(min=1, help="Number of drawn joints.")] = 20,
    first: Annotated[int, typer.Option(min=0, help="Number of the first one.")] = 0,
    without_excitation: Annotated[bool, typer.Option("--idle", help="Constant speed and standstill instead.")] = False,
) -> None:
    """Run drawn joints through a week of motion, rest, saturation, faults, changes and restarts."""
    console = Console(width=120)
    if without_excitation:
        console.print(idle.table(1.0 if hours == 168.0 else hours))
        return
    console.print(f"parts of {PART} s; rms error of the undisturbed first and last part in mrad/s")
    console.print("joint    hours restarts torque/limit outside   first    last  ratio  memory, MB")
    draw, weeks = first, []
    while len(weeks) < joints:
        scenario = drawn_joint(draw)
        if scenario is not None:
            weeks.append(week := live(scenario, draw, hours))
            print(
                f"{week.draw:5d} {week.hours:8.2f} {week.restarts:8d} {week.torque:12.4f} {week.outside:7d} "
                f"{1e3 * week.before:7.3g} {1e3 * week.after:7.3g} {week.after / week.before:6.3f} {week.growth:8.1f}  "
                f"{verdict(week)}",
                flush=True,
            )
        draw += 1
    ratios = [week.after / week.before for week in weeks]
    held = sum(verdict(week) == "holds" for week in weeks)
    console.print(
        f"{held} of {joints} hold; last over first part: median {np.median(ratios):.3f}, most {max(ratios):.3f}"
    )


if __name__ == "__main__":
    typer.run(main)
