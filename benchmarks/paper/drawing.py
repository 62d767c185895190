"""What the figures have in common beside ``adaptive_ff.report.style``: looks, canvases, axes with plain numbers."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter
from numpy.typing import NDArray

from adaptive_ff.report.comparison_pictures import LOOKS
from adaptive_ff.report.style import INK, QUIET, WIDTH, label_above

Look = Mapping[str, Any]

TRUTH: Look = {"color": "#b5b5b5", "linewidth": 2.6, "label": "simulated joint"}
SERIES: Look = {"color": LOOKS["adaptive_paper"]["color"], "linewidth": 1.1, "label": "series (4)"}
TORQUE_FORM: Look = {"color": LOOKS["adaptive"]["color"], "linewidth": 1.1, "label": "torque form"}
TRUE_LOOK: Look = {"color": INK, "linewidth": 1.0, "linestyle": (0, (2, 2)), "zorder": 3.0, "label": "true"}
GUIDE: Look = {"color": QUIET, "linewidth": 0.9, "linestyle": (0, (2, 2)), "zorder": 1.5}


def canvas(layout: list[list[str]], height: float, **more: Any) -> tuple[Figure, dict[str, Axes]]:
    """Return a figure of named panels; the height is in inches."""
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    return figure, figure.subplot_mosaic(layout, **more)


def label(axes: Axes, text: str, xlabel: str = "") -> None:
    """Label the vertical axis above it, and the horizontal one."""
    label_above(axes, text)
    axes.set_xlabel(xlabel)


def plain_numbers(axis: Axis) -> None:
    """Write the numbers of an axis without powers of ten."""
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def running_rms(errors: NDArray[np.float64], window: int) -> NDArray[np.float64]:
    """Return the rms over the last samples before each."""
    sums = np.convolve(errors**2, np.ones(window))[: errors.size]
    return np.asarray(np.sqrt(sums / np.minimum(np.arange(errors.size) + 1, window)))
