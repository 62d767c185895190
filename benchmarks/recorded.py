"""The comparison on a recorded motion: axis 4 of a KUKA KR300.

Run with ``python -m benchmarks.recorded [FOLDER]``, where the folder holds ``trajectory_A.npz``: the arrays ``t`` (s),
and ``dphi_ref_rad_per_s`` (samples by axes, rad/s) of the source's ``2020-10-21 10s FF A 08ms/data.mat``
(github.com/JonasWeigand/Robot_Identification, ``data/recorded_trajectories``, MIT licence).
"""

import sys
import tempfile
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from adaptive_ff import Comparison, compare, load_scenario
from adaptive_ff.files import write_csv, write_json
from adaptive_ff.report.tables import estimates_table, tracking_table
from benchmarks.wide import wide_console

ROOT = Path(__file__).resolve().parent.parent
DATA = ROOT.parent / "shared" / "data" / "kuka_kr300"
SCENARIO = ROOT / "benchmarks" / "kuka_kr300_axis4.toml"
AXIS = 3
"""Index of axis 4."""


def write_reference(folder: Path, target: Path, record: str = "trajectory_A.npz") -> None:
    """Write the reference of axis 4 of a record as a CSV file with time and velocity."""
    with np.load(folder / record) as arrays:
        write_csv(target, {"time": arrays["t"], "velocity": arrays["dphi_ref_rad_per_s"][:, AXIS]})


def run(folder: Path) -> Comparison:
    """Compare all controllers of the scenario on the recorded reference."""
    with tempfile.TemporaryDirectory() as temporary:
        file = Path(temporary) / "reference.csv"
        write_reference(folder, file)
        return compare(load_scenario(SCENARIO).modified(reference={"kind": "csv", "path": str(file)}))


def main(
    folder: Annotated[Path, typer.Argument(help="Folder with trajectory_A.npz.")] = DATA,
    json: Annotated[Path | None, typer.Option(help="Write the result there.")] = None,
) -> None:
    """Print the tables of the comparison on the recorded motion."""
    if not (folder / "trajectory_A.npz").is_file():
        print(f"{folder}: there is no trajectory_A.npz. {__doc__}", file=sys.stderr)
        raise typer.Exit(2)
    comparison = run(folder)
    console = wide_console()
    console.print(tracking_table(comparison))
    estimates = estimates_table(comparison)
    if estimates is not None:
        console.print(estimates)
    if json is not None:
        write_json(json, comparison.to_dict())


if __name__ == "__main__":
    typer.run(main)
