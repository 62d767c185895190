"""What supervision costs: the adaptive controller over itself without it, on the scenarios of the matrix."""

import numpy as np
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.comparison.matrix.jobs import Results
from adaptive_ff.comparison.matrix.summary import OURS

WITHOUT = "adaptive_unsupervised"

LIMITS = {"rms_error_settled": 1.02, "torque_variation": 1.05}
"""What each figure over that without supervision may be at most where the model holds."""


def costs(results: Results) -> dict[str, dict[str, float]]:
    """Return the median ratio over seeds of each figure of :data:`LIMITS`, by scenario; the dearest first."""
    ratios: dict[str, list[list[float]]] = {}
    for job, found in results.items():
        own, without = found.get(OURS, {}), found.get(WITHOUT, {})
        pairs = [(own.get(figure), without.get(figure)) for figure in LIMITS]
        if not job.fastest and all(above is not None and below for above, below in pairs):
            ratios.setdefault(job.scenario, []).append([above / below for above, below in pairs])  # type: ignore[operator]
    medians = {name: np.median(found, axis=0) for name, found in ratios.items()}
    order = sorted(medians, key=lambda name: -float(medians[name][0]))
    return {name: dict(zip(LIMITS, medians[name].tolist(), strict=True)) for name in order}


def cost_table(results: Results) -> Table | None:
    """Return the scenarios on which supervision costs more than a limit; None where nothing was run without it."""
    found = costs(results)
    if not found:
        return None
    over = {name: row for name, row in found.items() if any(row[figure] > most for figure, most in LIMITS.items())}
    cheapest = sum(row["rms_error_settled"] <= 1.0 for row in found.values())
    title = f"{OURS} over {WITHOUT}: {len(over)} of {len(found)} scenarios beyond a limit, {cheapest} no worse"
    table = Table(title=title, box=SIMPLE, title_style="bold")
    table.add_column("scenario")
    for figure, most in LIMITS.items():
        table.add_column(f"{figure.replace('_', ' ')} <= {most:g}", justify="right")
    for name, row in over.items():
        table.add_row(name, *(f"{row[figure]:.3f}" for figure in LIMITS))
    return table
