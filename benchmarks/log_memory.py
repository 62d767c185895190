"""Memory that reading a CSV log takes: ``python -m benchmarks.log_memory [--rows N]``.

The log has time, position and torque; once as numbers alone, once with a cell that holds none, for which the quick way
is given up. Counted is the largest amount that Python and numpy had allocated at any moment of the reading.
"""

import tracemalloc
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import numpy as np
import typer

from adaptive_ff.logs.log import read_log


def peak_over_columns(rows: int, *, gap: bool) -> float:
    """Return the peak of the memory over the size of the three columns."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "log.csv"
        with path.open("w", encoding="utf-8") as stream:
            stream.write("t,q,u\n")
            for k in range(rows):
                torque = "lost" if gap and k == rows // 2 else f"{np.cos(0.001 * k):.6f}"
                stream.write(f"{0.001 * k:.3f},{np.sin(0.001 * k):.6f},{torque}\n")
        tracemalloc.start()
        read_log(path, time="t", position="q", torque="u")
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    return peak / (3 * 8 * rows)


def main(rows: Annotated[int, typer.Option(min=1, help="Rows of the file.")] = 1_000_000) -> None:
    """Print the memory of the reading, over the size of the columns."""
    for what, gap in (("numbers alone", False), ("a cell without a number", True)):
        typer.echo(f"{rows} rows, {what}: {peak_over_columns(rows, gap=gap):.2f} times the size of the columns")


if __name__ == "__main__":
    typer.run(main)
