"""What the matrix says: medians over seeds by scenario and controller, means over scenarios, the best."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.comparison.comparison import BASELINE
from adaptive_ff.comparison.verdict import KNOW_THE_TRUTH
from adaptive_ff.studies.matrix import Results

OURS = "adaptive"

ALIKE = 1.02
"""A median ratio nearer to one than this factor counts as equal."""


@dataclass(frozen=True)
class Cell:
    """A controller on a scenario."""

    error: NDArray[np.float64]  # shape (seeds,); settled rms error, rad/s
    gain: NDArray[np.float64]  # shape (seeds,); that of PI over its own, seed by seed

    @property
    def median(self) -> float:
        """Median error, rad/s."""
        return float(np.median(self.error))

    @property
    def median_gain(self) -> float:
        """Median improvement over PI."""
        return float(np.median(self.gain))


Cells = dict[str, dict[str, Cell]]
"""Cells by scenario and controller; a controller that failed on a seed has none."""


def collect(results: Results, figure: str = "rms_error_settled") -> Cells:
    """Return the cells of the matrix for a figure of merit."""
    cells: Cells = {}
    for scenario in dict.fromkeys(job.scenario for job in results):
        runs = [found for job, found in results.items() if job.scenario == scenario]
        base = np.array([found[BASELINE][figure] for found in runs], dtype=float)
        cells[scenario] = {}
        for name in runs[0]:
            values = [found[name].get(figure) for found in runs]
            if any(value is None for value in values):
                continue
            errors = np.array(values, dtype=float)
            cells[scenario][name] = Cell(errors, base / np.maximum(errors, np.finfo(float).tiny))
    return cells


def mean_gain(cells: Cells, name: str) -> float:
    """Return the geometric mean over scenarios of the improvement over PI; not a number where it failed on one."""
    gains = [row[name].median_gain if name in row else np.nan for row in cells.values()]
    return float(np.exp(np.mean(np.log(gains))))


def verdict(cells: Cells) -> dict[str, Any]:
    """Return which controller is best in the geometric mean over the scenarios, by how much, and where it is not."""
    names = dict.fromkeys(name for row in cells.values() for name in row if name not in KNOW_THE_TRUTH)
    means = {name: mean_gain(cells, name) for name in names}
    best = max(means, key=lambda name: np.nan_to_num(means[name]))
    gains = {scenario: row[best].median_gain for scenario, row in cells.items() if best in row}
    worst = min(gains, key=lambda scenario: gains[scenario])
    return {
        "best": best,
        "over_pi": means[best],
        "scenarios": len(cells),
        "worst": worst,
        "worst_over_pi": gains[worst],
        "below_pi": [scenario for scenario, gain in gains.items() if gain < 1.0 / ALIKE],
    }
