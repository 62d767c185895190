"""Who wins where: a picture of the whole matrix, controllers by scenarios."""

import math
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure

from adaptive_ff.report.drawing import INK, STYLE
from benchmarks.tracking.groups import grouped
from benchmarks.tracking.summary import OURS, TOLD_THE_TRUTH, Cell, Cells

WEAKEST, STRONGEST = -2.0, 6.0
"""Range of improvement over PI that the colours show, powers of two; PI itself is in the middle of the colours."""

DARK = 4.0
"""Power of two from which the colour is too dark for dark letters."""


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
    groups = grouped(cells)
    scenarios = [name for names in groups.values() for name in names]
    ordered = [name for name in controllers if name not in TOLD_THE_TRUTH and name != OURS]
    ordered += [name for name in (OURS, *sorted(TOLD_THE_TRUTH)) if name in controllers]
    gains = np.array([[_gain(cells[scenario], name) for name in ordered] for scenario in scenarios])
    with rc_context(STYLE):
        figure = Figure(figsize=(1.8 + 0.46 * len(ordered), 1.9 + 0.3 * len(scenarios)), layout="constrained")
        axes = figure.add_subplot()
        levels = np.clip(np.log2(gains), WEAKEST, STRONGEST)
        image = axes.imshow(levels, cmap="RdYlGn", norm=TwoSlopeNorm(0.0, WEAKEST, STRONGEST), aspect="auto")
        rivals = [place for place, name in enumerate(ordered) if name not in TOLD_THE_TRUTH]
        for i in range(len(scenarios)):
            best = max(rivals, key=lambda j, row=gains[i]: np.nan_to_num(row[j]))
            for j, gain in enumerate(gains[i]):
                axes.text(
                    *(j, i, _shown(gain)),
                    **{"ha": "center", "va": "center", "size": 7.0, "weight": "bold" if j == best else "normal"},
                    color="white" if abs(levels[i, j]) > DARK or levels[i, j] < -1.5 else INK,
                )
        axes.axvline(len(rivals) - 0.5, color=INK, linewidth=1.0)
        for count in np.cumsum([len(names) for names in groups.values()])[:-1]:
            axes.axhline(count - 0.5, color=INK, linewidth=0.8)
        axes.set_xticks(range(len(ordered)), ordered, rotation=60.0, ha="right", rotation_mode="anchor")
        axes.set_yticks(range(len(scenarios)), scenarios)
        axes.grid(False)
        axes.set_title(f"{title} (bold: best; right of the line: told the truth)", size=9.0, loc="left")
        bar = figure.colorbar(image, ax=axes, shrink=0.5, pad=0.01, ticks=range(-2, 7, 2))
        bar.ax.set_yticklabels([f"{2.0**power:g}" for power in range(-2, 7, 2)])
        bar.set_label("error of pi / own")
        figure.savefig(path, dpi=150)


def _shown(gain: float) -> str:
    if not math.isfinite(gain):
        return "x"
    return f"{gain:.0f}" if gain >= 10.0 else f"{gain:.2g}"


def _gain(row: dict[str, Cell], name: str) -> float:
    return float(np.median(row[name].gain)) if name in row else math.nan
