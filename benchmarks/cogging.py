"""Joints with cogging, whose period is told or not: ``python -m benchmarks.cogging [--joints 200]``.

Cogging is a torque ``A sin(n q)`` over the position. First the built-in joint, whose Coulomb friction is 60 N m, with a
drive of some amplitude and period (``[actuator]``): settled errors of PI, of a disturbance observer, of ``adaptive``
told nothing, told the period (``ripple_periods``), told it 1 % wrong, of the true parameters with the true cogging
(``oracle_tuned``), and of the same loop on a joint with neither (noise floor).

Then joints of another simulator, drawn as :mod:`benchmarks.other_joints` draws them, each without cogging, and with one
of 0.1, 0.3 and 0.6 of its Coulomb friction, 6 to 100 periods in a turn. Left out are those whose encoder has fewer than
20 counts in such a period, or whose velocity is the difference of counts that are more than 2 % of the largest speed.
PI's error over that of ``adaptive`` is given as there.
"""

import itertools
import math
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff import AdaptiveController, Scenario, compare, load_scenario
from adaptive_ff.comparison.reference_lines import noise_floor
from adaptive_ff.files import write_json
from adaptive_ff.model.friction import WITH_OFFSET
from benchmarks.other_joints import COMPARED, against, compared, draw, drive, loop_gains, told_of
from benchmarks.robot.in_turn import CORES, Workers, run_seeds
from benchmarks.wide import wide_console
from controllers import PI, Controller, DisturbanceObserver

DRIVES = ((0.0, 0.02), (3.0, 0.05), (12.0, 0.05), (12.0, 0.01), (30.0, 0.02))
"""Amplitude, N m, and period, rad, of the cogging of the built-in joint."""

WRONG = 1.01
"""Period that is told over the true one, where it is told wrong."""

LINES = ("pi", "disturbance_observer", "untold", "told", "told 1 % wrong", "oracle_tuned", "noise floor")

SHARES = (0.0, 0.1, 0.3, 0.6)
"""Amplitude of the cogging of drawn joints, over their Coulomb friction."""

FEWEST_COUNTS, COARSEST = 20.0, 0.02
"""Counts in a period of cogging, and a count in a sampling period over the largest speed, that are taken."""

OBSERVER = 10.0
"""Largest bandwidth of the disturbance observer of drawn joints, Hz; else it is that of the loop."""


def with_cogging(amplitude: float, period: float, told: float | None, seed: int) -> Scenario:
    """Return the built-in scenario with cogging (N m, rad) and a period that is told, if any."""
    return load_scenario().modified(
        seed=seed,
        controllers=["pi", "disturbance_observer", "adaptive", "oracle_tuned"],
        actuator={"ripple_amplitude": amplitude, "ripple_period": period},
        adaptation={"ripple_periods": [] if told is None else [told]},
    )


def built_in(seed: int) -> dict[str, dict[str, float]]:
    """Return the settled errors (rad/s) of a seed, by drive and line."""
    found = {}
    for amplitude, period in DRIVES:
        plain = with_cogging(amplitude, period, None, seed)
        runs = compare(plain).runs
        errors = {name: runs[name].metrics.rms_error_settled for name in ("pi", "disturbance_observer", "oracle_tuned")}
        errors["untold"] = runs["adaptive"].metrics.rms_error_settled
        errors["noise floor"] = noise_floor(plain).metrics.rms_error_settled
        for line, told in (("told", period), ("told 1 % wrong", WRONG * period)):
            scenario = with_cogging(amplitude, period, told, seed).modified(controllers=["adaptive"])
            errors[line] = compare(scenario).runs["adaptive"].metrics.rms_error_settled
        found[f"{amplitude:g} N m every {period:g} rad"] = {line: errors[line] for line in LINES}
    return found


def drawn(seed: int) -> dict[str, Any]:
    """Return the figures of a drawn joint, by the share of its cogging; none where its encoder is too coarse."""
    joint, loop, plan = draw(seed)
    fastest = float(np.abs(plan).max())
    counts = 2.0 * math.pi / (joint.poles * loop.resolution)
    coarse = loop.sensor == "encoder" and loop.resolution > COARSEST * fastest * loop.period
    if coarse or counts < FEWEST_COUNTS:
        return {"seed": seed, "shares": {}}
    gains, given = loop_gains(joint, loop), told_of(joint, loop)
    periods = {"untold": [], "told": [2.0 * math.pi / joint.poles]}
    bandwidth = min(loop.bandwidth, OBSERVER)
    shares: dict[str, dict[str, dict[str, float]]] = {}
    for share in SHARES:
        cogged = joint._replace(cogging=share * joint.coulomb)
        observed = DisturbanceObserver(*gains, inertia=given["inertia"], bandwidth=bandwidth, delay=given["delay"])
        made: dict[str, Controller] = {"pi": PI(*gains), "disturbance observer": observed}
        for name, told in periods.items():
            made[name] = AdaptiveController(*gains, **given, parameters=WITH_OFFSET, ripple_periods=told)
        runs = {name: drive(one, cogged, loop, plan, seed, tells_position=True) for name, one in made.items()}
        alone = np.square(runs.pop("pi").errors)
        shares[f"{share:g}"] = {}
        for name, run in runs.items():
            settled, windows = against(alone, np.square(run.errors), loop.period)
            shares[f"{share:g}"][name] = {"settled": settled, "window": max(windows)}
    return {"seed": seed, "shares": shares}


def built_in_table(found: list[dict[str, dict[str, float]]]) -> Table:
    """Return the table of the built-in joint."""
    table = Table(title=f"settled error, mrad/s, median of {len(found)} seeds", box=SIMPLE, title_style="bold")
    table.add_column("cogging")
    for line in LINES:
        table.add_column(line, justify="right")
    for drive_name in found[0]:
        cells = (1e3 * float(np.median([one[drive_name][line] for one in found])) for line in LINES)
        table.add_row("none" if drive_name.startswith("0 ") else drive_name, *(f"{cell:.3g}" for cell in cells))
    return table


def drawn_table(found: list[dict[str, Any]]) -> Table:
    """Return the table of drawn joints."""
    rows = [row["shares"] for row in found if row["shares"]]
    title = f"PI's error over that of each, {len(rows)} joints of another simulator"
    table = Table(title=title, box=SIMPLE, title_style="bold")
    table.add_column("cogging over Fc")
    table.add_column("controller")
    for heading in COMPARED:
        table.add_column(heading, justify="right")
    for share, name in itertools.product(rows[0], ("disturbance observer", "untold", "told")):
        settled = [row[share][name]["settled"] for row in rows]
        windows = [row[share][name]["window"] for row in rows]
        table.add_row(share if name == "disturbance observer" else "", name, *compared(settled, windows))
    return table


def main(
    seeds: Annotated[int, typer.Option(min=1, help="Seeds of the built-in joint.")] = 10,
    joints: Annotated[int, typer.Option(min=0, help="How many joints are drawn.")] = 200,
    first: Annotated[int, typer.Option(min=0, help="First seed.")] = 1,
    workers: Workers = CORES,
    json: Annotated[Path | None, typer.Option(help="Write the figures there.")] = None,
) -> None:
    """Track with cogging, told and untold, and print how the controllers compare."""
    console = wide_console()
    own = run_seeds(built_in, range(first, first + seeds), workers, "seeds")
    console.print(built_in_table(own))
    others = run_seeds(drawn, range(first, first + joints), workers, "joints") if joints else []
    if any(row["shares"] for row in others):
        console.print(drawn_table(others))
    if json is not None:
        write_json(json, {"built_in": own, "joints": others})


if __name__ == "__main__":
    typer.run(main)
