"""What the figures have in common: panels, labels above them, one legend; looks of ``adaptive_ff.report.style``."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import ScaledTranslation

from adaptive_ff.report.comparison_pictures import LOOKS
from adaptive_ff.report.style import INK, LIFT, QUIET, WIDTH

Look = Mapping[str, Any]

TRUTH: Look = {"color": "#b5b5b5", "linewidth": 2.6, "label": "simulated joint"}
SERIES: Look = {"color": LOOKS["adaptive_paper"]["color"], "linewidth": 1.1, "label": "series (4)"}
TORQUE_FORM: Look = {"color": LOOKS["adaptive"]["color"], "linewidth": 1.1, "label": "torque form"}
NAIVE: Look = {"color": "#a6a6a6", "linewidth": 1.2, "label": "naive predictor w(k-1)"}
GUIDE: Look = {"color": QUIET, "linewidth": 0.9, "linestyle": (0, (2, 2)), "zorder": 1.5}


def panels(heights: Sequence[float], height: float) -> tuple[Figure, list[Axes]]:
    """Make a figure of panels below each other, with relative heights; the height of all is in inches."""
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    axes = figure.subplots(len(heights), 1, squeeze=False, gridspec_kw={"height_ratios": list(heights)})
    figure.get_layout_engine().set(h_pad=0.08)
    return figure, list(axes[:, 0])


def label(axes: Axes, text: str, xlabel: str = "") -> None:
    """Label the vertical axis above it, where it is read without turning the head, and the horizontal one."""
    axes.set_ylabel(text, rotation=0.0, horizontalalignment="left", verticalalignment="baseline")
    lift = ScaledTranslation(0.0, LIFT / 72.0, axes.figure.dpi_scale_trans)
    axes.yaxis.set_label_coords(0.0, 1.0, transform=axes.transAxes + lift)
    axes.set_xlabel(xlabel)


def legend(target: Figure | Axes, looks: Sequence[Look], **places: Any) -> None:
    """Explain looks above all panels, or in one of them."""
    handles = [Line2D([], [], **look) for look in looks]
    if isinstance(target, Figure):
        widths = [0.5 + 0.075 * len(str(handle.get_label())) for handle in handles]  # roughly, in inches
        rows = math.ceil(sum(widths) / WIDTH)
        columns = math.ceil(len(handles) / rows)
        target.legend(handles=handles, loc="outside upper center", ncols=columns, handlelength=1.7)
    else:
        target.legend(handles=handles, handlelength=1.7, labelcolor=INK, **places)
