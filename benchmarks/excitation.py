"""What an exciting motion is worth: ``python -m benchmarks.excitation [--joint NAME] [--seeds N]``.

For each joint ``adaptive-ff excite``'s motion of 10 s is found, with the limits that its drive has, and followed by the
PI loop of the scenario. The 95 % intervals of the torque form, identified with the assumed Stribeck velocity, are
printed over those of 60 s of the built-in multisine on the same joint, medians over reported seeds; the motion is
chosen on others. Note that the multisine keeps to seven Stribeck velocities, and the motion to what the drive allows.
The same for two periods, 20 s.
"""

import math
from pathlib import Path
from typing import Annotated

import typer
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff import Scenario, load_scenario
from adaptive_ff.files import write_json
from adaptive_ff.scenario.library import SCENARIOS
from adaptive_ff.studies.exciting_motion import (
    default_limits,
    exciting_motion,
    interval_widths,
    with_motion,
    yardstick,
)
from adaptive_ff.studies.information import NAMES
from benchmarks.wide import wide_console

PERIOD = 10.0
"""Length of the motion, s."""


def joints() -> dict[str, Scenario]:
    """Return the joints by name."""
    kuka = load_scenario(Path(__file__).with_name("kuka_kr300_axis4.toml"))
    return {
        "built-in, 1 kHz": load_scenario(SCENARIOS / "noisy_1khz.toml"),
        "built-in, 100 Hz": load_scenario(SCENARIOS / "paper_100hz.toml"),
        "servo": load_scenario(SCENARIOS / "servo.toml"),
        "KUKA axis 4": kuka,
    }


def rows_of(scenario: Scenario, seeds: range) -> list[dict[str, float]]:
    """Return interval widths over those of the multisine, for one period of the motion and for two."""
    motion = exciting_motion(scenario, default_limits(scenario), period=PERIOD)
    base = interval_widths(yardstick(scenario), seeds)
    rows = []
    for duration in (PERIOD, 2.0 * PERIOD):
        widths = interval_widths(with_motion(scenario, motion.reference.model_dump(), duration), seeds)
        rows.append({"duration": duration, **{name: widths[name] / base[name] for name in NAMES}})
    return rows


def main(
    joint: Annotated[list[str] | None, typer.Option(help="Joint; may be repeated.")] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Number of reported seeds, from 1 on.")] = 20,
    json: Annotated[Path | None, typer.Option(help="Write the rows there.")] = None,
) -> None:
    """Print intervals of exciting motions over those of a minute of multisine."""
    known = joints()
    for name in joint or []:
        if name not in known:
            raise typer.BadParameter(f"{name!r} is not known; there are {', '.join(known)}", param_hint="--joint")
    table = Table(title="95 % intervals over those of 60 s of multisine", box=SIMPLE, title_style="bold")
    table.add_column("joint")
    for heading in ("motion, s", *(name.replace("_", " ") for name in NAMES), "largest"):
        table.add_column(heading, justify="right")
    written = []
    for name in joint or known:
        for row in rows_of(known[name], range(1, seeds + 1)):
            sizes = [row[parameter] for parameter in NAMES]
            table.add_row(name, f"{row['duration']:g}", *(f"{size:.2f}" for size in sizes), f"{max(sizes):.2f}")
            written.append({"joint": name, **{key: one if math.isfinite(one) else None for key, one in row.items()}})
    wide_console().print(table)
    if json is not None:
        write_json(json, {"rows": written})


if __name__ == "__main__":
    typer.run(main)
