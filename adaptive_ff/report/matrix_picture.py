"""Who wins where: a picture of the whole matrix, controllers by scenarios, both in groups."""

import math
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, TwoSlopeNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from adaptive_ff.comparison.fixed_models import FORMS, SOURCES
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.report.drawing import INK, STYLE, stamp
from adaptive_ff.studies.ranking import KNOWS_THE_TRUTH, OURS, Cell, Cells, grouped

WEAKEST, STRONGEST = -2.0, 6.0
"""Range of improvement over PI that the colours show, powers of two; PI itself is in the middle of the colours."""

COLOURS = LinearSegmentedColormap.from_list(
    "worse_better",
    ("#590007", "#8b2706", "#be6533", "#d39774", "#eacebd", "#c9dde7", "#71a7c4", "#1e6f9d", "#033d7c", "#001260"),
)
"""Red is worse than PI, blue better: perceptually uniform and the same to colour-blind eyes.

Colours of the map vik, F. Crameri, "Scientific colour maps" (2018), doi 10.5281/zenodo.1243862.
"""

DARK, DARK_RED = 3.0, -1.2
"""Powers of two beyond which the colour is too dark for dark letters."""

FIXED = tuple(f"{form}_{source}" for form in FORMS for source in SOURCES)
COLUMNS = {
    "ours": (OURS,),
    "learners": (
        *("adaptive_paper", "canudas", "canudas_measured", "feedback_error", "lugre_gradient"),
        *("maxwell_adaptive", "radial_basis", "repetitive"),
    ),
    "observers": ("disturbance_observer", "extended_state", "kalman_disturbance", "super_twisting"),
    "friction model and observer": ("lugre_observer", "friction_observer", "lee_tomizuka"),
    "with a fixed model": (
        *(name for name in ("pi_inertia", *FIXED) if name not in KNOWS_THE_TRUTH),
        *("observed_nominal", "observed_batch"),
    ),
    "knows the truth": ("oracle", "oracle_tuned", "noise_floor"),
}
"""Groups of columns in their order; what is in none stands under ``own`` or ``others``. PI itself is one everywhere."""


def column_groups(controllers: list[str]) -> dict[str, list[str]]:
    """Return the columns by group, own ones first; PI and the models that are true but for the lag are left out."""
    found = {"own": [name for name in controllers if name not in CONTROLLERS and name not in KNOWS_THE_TRUTH]}
    found |= {group: [name for name in names if name in controllers] for group, names in COLUMNS.items()}
    placed = {name for names in found.values() for name in names} | KNOWS_THE_TRUTH | {"pi"}
    truth = found.pop("knows the truth")
    found["others"] = [name for name in controllers if name not in placed]
    found["knows the truth"] = truth
    return {group: names for group, names in found.items() if names}


def draw_matrix(cells: Cells, controllers: list[str], title: str, source: str) -> Figure | None:
    """Draw the improvement over PI of every controller on every scenario; None where there is none but PI.

    Parameters
    ----------
    cells : dict
        The matrix.
    controllers : list of str
        Names of the controllers.
    title : str
        Heading.
    source : str
        Scenarios and seeds, for the line below the picture.
    """
    rows, columns = grouped(cells), column_groups(controllers)
    scenarios = [name for names in rows.values() for name in names]
    ordered = [name for names in columns.values() for name in names]
    if not ordered:
        return None
    gains = np.array([[_gain(cells[scenario], name) for name in ordered] for scenario in scenarios])
    with rc_context(STYLE):
        figure = Figure(figsize=(5.6 + 0.46 * len(ordered), 3.4 + 0.3 * len(scenarios)), layout="constrained")
        axes = figure.add_subplot()
        levels = np.clip(np.log2(gains), WEAKEST, STRONGEST)
        image = axes.imshow(levels, cmap=COLOURS, norm=TwoSlopeNorm(0.0, WEAKEST, STRONGEST), aspect="auto")
        _write_gains(axes, gains, levels, [name not in KNOWS_THE_TRUTH for name in ordered])
        _divide(axes, [len(names) for names in columns.values()], list(columns), vertical=True)
        _divide(axes, [len(names) for names in rows.values()], list(rows), vertical=False)
        axes.set_xticks(range(len(ordered)), ordered, rotation=60.0, ha="right", rotation_mode="anchor")
        axes.set_yticks(range(len(scenarios)), scenarios)
        axes.tick_params(length=0.0)
        axes.grid(False)
        figure.suptitle(f"{title}\nbold: best of those that do not know the truth; x: failed", size=9.0)
        bar = figure.colorbar(
            image, ax=axes, shrink=0.5 if len(scenarios) > 12 else 1.0, pad=0.02, ticks=range(-2, 7, 2)
        )
        bar.ax.set_yticklabels([f"{2.0**power:g}" for power in range(-2, 7, 2)])
        bar.set_label("error of pi / own")
        stamp([figure], source)
    return figure


def _write_gains(axes: Axes, gains: NDArray[np.float64], levels: NDArray[np.float64], rivals: list[bool]) -> None:
    places = np.flatnonzero(rivals)
    for i, row in enumerate(gains):
        best = places[np.argmax(np.nan_to_num(row[places]))] if places.size else -1
        for j, gain in enumerate(row):
            dark = levels[i, j] > DARK or levels[i, j] < DARK_RED
            look: dict[str, Any] = {"ha": "center", "va": "center", "size": 7.0, "color": "white" if dark else INK}
            axes.text(j, i, _shown(gain), weight="bold" if j == best else "normal", **look)


def _divide(axes: Axes, sizes: list[int], names: list[str], *, vertical: bool) -> None:
    """Draw lines between groups, and name them above, or at the right."""
    ends = np.cumsum(sizes)
    for end in ends[:-1]:
        (axes.axvline if vertical else axes.axhline)(end - 0.5, color=INK, linewidth=1.0)
    for name, end, size in zip(names, ends, sizes, strict=True):
        middle = end - 0.5 * size - 0.5
        if vertical:
            place: Any = {"xytext": (0.0, 6.0), "textcoords": "offset points", "annotation_clip": False}
            axes.annotate(name, (middle, -0.5), **place, rotation=30.0, ha="left", va="bottom", size=8.0)
        else:
            axes.text(1.01, middle, name, transform=axes.get_yaxis_transform(), ha="left", va="center", size=8.0)


def _shown(gain: float) -> str:
    if not math.isfinite(gain):
        return "x"
    return f"{gain:.0f}" if gain >= 10.0 else f"{gain:.2g}"


def _gain(row: dict[str, Cell], name: str) -> float:
    return float(np.median(row[name].gain)) if name in row else math.nan
