"""Who wins where: a picture of the whole matrix, controllers by scenarios."""

from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from adaptive_ff.drawing import STYLE
from benchmarks.tracking.summary import TOLD_THE_TRUTH, Cells

WEAKEST, STRONGEST = 0.25, 64.0
"""Range of improvement over PI that the colours show."""


def draw_matrix(cells: Cells, controllers: list[str], path: Path, title: str) -> None:
    """Draw the improvement over PI of every controller on every scenario, and write the picture.

    Parameters
    ----------
    cells : dict
        The matrix.
    controllers : list of str
        Columns, in this order.
    path : Path
        Where to write the picture.
    title : str
        Heading.
    """
    scenarios = list(cells)
    gains = np.full((len(scenarios), len(controllers)), np.nan)
    for i, scenario in enumerate(scenarios):
        for j, name in enumerate(controllers):
            if name in cells[scenario]:
                gains[i, j] = np.median(cells[scenario][name].gain)
    with rc_context(STYLE):
        figure = Figure(figsize=(1.8 + 0.46 * len(controllers), 1.9 + 0.3 * len(scenarios)), layout="constrained")
        axes = figure.add_subplot()
        norm = LogNorm(WEAKEST, STRONGEST)
        image = axes.imshow(np.clip(gains, WEAKEST, STRONGEST), cmap="RdYlGn", norm=norm, aspect="auto")
        for i in range(len(scenarios)):
            rivals = [
                j for j, name in enumerate(controllers) if name not in TOLD_THE_TRUTH and np.isfinite(gains[i, j])
            ]
            best = max(rivals, key=lambda j: gains[i, j]) if rivals else -1
            for j in range(len(controllers)):
                text = f"{gains[i, j]:.2g}" if np.isfinite(gains[i, j]) else "x"
                axes.text(j, i, text, ha="center", va="center", size=7.0, weight="bold" if j == best else "normal")
        axes.set_xticks(range(len(controllers)), controllers, rotation=60.0, ha="right", rotation_mode="anchor")
        axes.set_yticks(range(len(scenarios)), scenarios)
        axes.grid(False)
        axes.set_title(title, size=9.0, loc="left")
        bar = figure.colorbar(image, ax=axes, shrink=0.5, pad=0.01, format="%g", ticks=[0.25, 1.0, 4.0, 16.0, 64.0])
        bar.set_label("error of pi / own")
        bar.ax.minorticks_off()
        figure.savefig(path, dpi=150)
